//! The manifest of an output folder: it lists every file of ours before that file is written.
//!
//! ```text
//! overfall manifest 1
//! run "dam_break"
//! scene/scene.ron
//! frames/frame_00000.vtu
//! ```

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Component, Path, PathBuf};

use overfall::input::read_text;
use overfall::output::partial_name;

use super::exit::Failure;

/// The manifest's name in the folder.
pub(super) const MANIFEST: &str = "overfall_manifest.txt";
/// The manifest's first line.
pub(super) const HEAD: &str = "overfall manifest 1";
/// Name of the folder for an older run, before its number.
const OLDER: &str = "older_";

/// Why a file that no manifest lists stays as it is.
pub(super) const NOT_OURS: &str = "it exists, was not written by overfall, and is not overwritten";

/// Content of a manifest.
pub(super) struct Listing {
    /// Its second line.
    pub(super) writer: String,
    /// Names relative to the folder.
    pub(super) files: BTreeSet<String>,
    /// Length of its complete lines.
    pub(super) bytes: u64,
}

impl Listing {
    /// Reads the manifest of a folder; `None` if there is no manifest.
    pub(super) fn read(root: &Path) -> Result<Option<Self>, Failure> {
        let path = root.join(MANIFEST);
        let text = match read_text(&path) {
            Err(error) if is_absent(&error) => return Ok(None),
            text => text.map_err(|error| failed("cannot read", &path, &error))?,
        };
        let whole = &text[..text.rfind('\n').map_or(0, |end| end + 1)];
        let mut lines = whole.lines();
        let writer = (lines.next() == Some(HEAD)).then(|| lines.next()).flatten();
        let files: BTreeSet<String> = lines.map(str::to_owned).collect();
        match writer {
            Some(writer) if files.iter().all(|name| stays_inside(name)) => Ok(Some(Self {
                writer: writer.to_owned(),
                files,
                bytes: whole.len() as u64,
            })),
            _ => Err(Failure::Refused(format!(
                "{}: this is not a manifest of overfall; choose another --out, or move the file away",
                path.display()
            ))),
        }
    }

    /// The files that exist, including unfinished ones of a killed program.
    fn present(&self, root: &Path) -> Vec<PathBuf> {
        let names = self.files.iter().map(PathBuf::from);
        names
            .flat_map(|name| [partial_name(&name), name])
            .filter(|name| is_there(&root.join(name)))
            // The manifest comes last, so that the files stay ours if moving or removing them is interrupted.
            .chain([PathBuf::from(MANIFEST)])
            .collect()
    }

    /// Removes all these files.
    pub(super) fn remove(&self, root: &Path) -> Result<(), Failure> {
        for name in self.present(root) {
            let path = root.join(name);
            fs::remove_file(&path)
                .map_err(|error| failed("cannot remove the older", &path, &error))?;
        }
        self.remove_empty_folders(root);
        Ok(())
    }

    /// Moves all these files of `root` into a new subfolder of `parent` and returns it.
    pub(super) fn move_aside(&self, root: &Path, parent: &Path) -> Result<PathBuf, Failure> {
        let aside = free_folder(parent)?;
        for name in self.present(root) {
            let (from, to) = (root.join(&name), aside.join(&name));
            let moved = (to.parent())
                .map_or(Ok(()), fs::create_dir_all)
                .and_then(|()| fs::rename(&from, &to));
            moved.map_err(|error| failed("cannot move the older", &from, &error))?;
        }
        self.remove_empty_folders(root);
        Ok(aside)
    }

    /// Removes folders that are empty; others stay.
    fn remove_empty_folders(&self, root: &Path) {
        let parents = self
            .files
            .iter()
            .filter_map(|name| Path::new(name).parent());
        let folders: BTreeSet<&Path> = parents.filter(|path| *path != Path::new("")).collect();
        for folder in folders {
            let _ = fs::remove_dir(root.join(folder));
        }
    }
}

/// Creates the first folder of `older_1`, `older_2`, … that does not exist.
fn free_folder(root: &Path) -> Result<PathBuf, Failure> {
    let mut number = 1_u64;
    loop {
        let path = root.join(format!("{OLDER}{number}"));
        match fs::create_dir(&path) {
            Ok(()) => return Ok(path),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
            Err(error) => return Err(failed("cannot create the folder", &path, &error)),
        }
    }
}

/// Whether a name in a manifest refers to a file inside the folder.
pub(super) fn stays_inside(name: &str) -> bool {
    !name.is_empty()
        && (Path::new(name).components()).all(|part| matches!(part, Component::Normal(_)))
}

/// Whether the path exists, even as a broken link.
pub(super) fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

/// Creates a folder and its parents.
pub(super) fn create_folder(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|error| {
        let is_no_folder = |path: &&Path| path.exists() && !path.is_dir();
        match path.ancestors().find(is_no_folder) {
            Some(file) => Failure::Failed(format!(
                "cannot create the folder {}: {} is no folder; choose another --out",
                path.display(),
                file.display()
            )),
            None => failed("cannot create the folder", path, &error),
        }
    })
}

/// An error of the operating system, in words.
pub(super) fn failed(what: &str, path: &Path, error: &io::Error) -> Failure {
    Failure::Failed(format!("{what} {}: {error}", path.display()))
}

/// Whether the error means that the path does not exist.
pub(super) fn is_absent(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory)
}
