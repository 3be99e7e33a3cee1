//! The folder of a run: what lies where, and how an older run there makes room.
//!
//! ```text
//! out/dam_break/
//!   scene.ron           the scene as it ran, overrides applied
//!   order.ron           its order file, if it has one
//!   mesh_0.obj          the files of its meshes, if it has some
//!   history.csv         a row a step
//!   summary.json        how it went
//!   dam_break.pvd       the frames as one animation
//!   contact_sheet.png   the pictures at a glance
//!   frames/frame_00000.vtu
//!   pictures/frame_00000.png
//! ```

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use overfall::scene::{FrameFormat, Scene};

use super::Failure;
use super::scene_copy::{ORDER, is_copied_mesh};

/// Where runs go that are not told where to go.
const DEFAULT_PARENT: &str = "out";

/// The folder of one run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RunFolder {
    root: PathBuf,
    /// The scene's name, as far as a file can be called that.
    name: String,
}

impl RunFolder {
    /// The folder for a run of a scene: `out`, or `out/<scene name>` without it.
    pub(super) fn new(out: Option<&Path>, scene_name: &str) -> Self {
        let name = file_name(scene_name);
        let root = out.map_or_else(|| Path::new(DEFAULT_PARENT).join(&name), Path::to_owned);
        Self { root, name }
    }

    /// The folder of a run that is over.
    pub(super) fn open(root: &Path) -> Self {
        Self::new(Some(root), "")
    }

    /// Makes the folder ready: it exists, and what an older run left there is gone.
    ///
    /// Only files that a run writes are deleted. A `scene.ron` without the rest of a run is somebody's own: the
    /// folder is refused rather than the scene overwritten.
    pub(super) fn prepare(&self, pictures: bool) -> Result<(), Failure> {
        if self.scene().exists() && !self.history().exists() {
            return Err(Failure::Refused(format!(
                "{}: this scene was not written by a run and would be overwritten; choose another --out",
                self.scene().display()
            )));
        }
        self.remove_older_run()?;
        create_folder(&self.frames())?;
        if pictures {
            self.create_pictures()?;
        }
        Ok(())
    }

    /// Makes the folder of the pictures, if it is not there.
    pub(super) fn create_pictures(&self) -> Result<(), Failure> {
        create_folder(&self.pictures())
    }

    fn remove_older_run(&self) -> Result<(), Failure> {
        if !self.history().exists() {
            return Ok(());
        }
        let mut old = vec![
            self.summary(),
            self.contact_sheet(),
            self.series(),
            self.order(),
        ];
        // The run before may have been of a scene by another name.
        if let Ok(scene) = Scene::load(&self.scene(), &[]) {
            old.push(self.root.join(format!("{}.pvd", file_name(&scene.name))));
        }
        let entries = fs::read_dir(&self.root)
            .map_err(|error| failed("cannot read the folder", &self.root, &error))?;
        for entry in entries.flatten() {
            if entry.file_name().to_str().is_some_and(is_copied_mesh) {
                old.push(entry.path());
            }
        }
        for (folder, extension) in [
            (self.frames(), "vtu"),
            (self.frames(), "ply"),
            (self.pictures(), "png"),
        ] {
            // A run that was killed leaves the file it was at under a name of its own.
            for extension in [extension, &format!("{extension}.partial")] {
                let files = numbered_files(&folder, extension)?;
                old.extend(files.into_iter().map(|(_, path)| path));
            }
        }
        // Last, so that a run that cannot clean up is still known as one of ours.
        old.extend([self.scene(), self.history()]);
        for file in old {
            match fs::remove_file(&file) {
                Err(error) if !is_absent(&error) => {
                    return Err(failed("cannot remove the older", &file, &error));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The frames that are there in a format, by number.
    pub(super) fn written_frames(
        &self,
        format: FrameFormat,
    ) -> Result<Vec<(u64, PathBuf)>, Failure> {
        numbered_files(&self.frames(), format.extension())
    }

    /// The folder itself.
    pub(super) fn root(&self) -> &Path {
        &self.root
    }

    /// The scene as it ran.
    pub(super) fn scene(&self) -> PathBuf {
        self.root.join("scene.ron")
    }

    /// The order file of the scene as it ran.
    pub(super) fn order(&self) -> PathBuf {
        self.root.join(ORDER)
    }

    /// A row a step.
    pub(super) fn history(&self) -> PathBuf {
        self.root.join("history.csv")
    }

    /// How the run went.
    pub(super) fn summary(&self) -> PathBuf {
        self.root.join("summary.json")
    }

    /// The frames as one animation.
    pub(super) fn series(&self) -> PathBuf {
        self.root.join(format!("{}.pvd", self.name))
    }

    /// The pictures at a glance.
    pub(super) fn contact_sheet(&self) -> PathBuf {
        self.root.join("contact_sheet.png")
    }

    /// Holds the frames.
    pub(super) fn frames(&self) -> PathBuf {
        self.root.join("frames")
    }

    /// Holds the pictures.
    pub(super) fn pictures(&self) -> PathBuf {
        self.root.join("pictures")
    }

    /// A frame, relative to the folder.
    pub(super) fn frame(&self, number: u64, format: FrameFormat) -> String {
        format!("frames/{STEM}{number:05}.{}", format.extension())
    }

    /// The picture of a frame.
    pub(super) fn picture(&self, number: u64) -> PathBuf {
        self.pictures().join(format!("{STEM}{number:05}.png"))
    }
}

/// What the names of frames and pictures begin with.
const STEM: &str = "frame_";

/// The number in the name of a frame or a picture; none if we do not name files like that.
fn number(name: &str, extension: &str) -> Option<u64> {
    let digits = name
        .strip_prefix(STEM)?
        .strip_suffix(extension)?
        .strip_suffix('.')?;
    let is_ours = digits.len() >= 5 && digits.bytes().all(|byte| byte.is_ascii_digit());
    is_ours.then(|| digits.parse().ok()).flatten()
}

/// The files of our own naming in a folder, by number. A folder that is not there has none.
fn numbered_files(folder: &Path, extension: &str) -> Result<Vec<(u64, PathBuf)>, Failure> {
    let read = || -> io::Result<Vec<(u64, PathBuf)>> {
        let mut files = Vec::new();
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            let name = path.file_name().and_then(|name| name.to_str());
            if let Some(number) = name.and_then(|name| number(name, extension)) {
                files.push((number, path));
            }
        }
        files.sort();
        Ok(files)
    };
    match read() {
        Err(error) if is_absent(&error) => Ok(Vec::new()),
        files => files.map_err(|error| failed("cannot read the folder", folder, &error)),
    }
}

/// A scene name as a file name: what could leave the folder or upset a shell becomes `_`.
fn file_name(scene_name: &str) -> String {
    let name: String = scene_name
        .chars()
        .map(|c| match c {
            '-' | '_' | '.' => c,
            c if c.is_alphanumeric() => c,
            _ => '_',
        })
        .collect();
    match name.trim_start_matches('.') {
        "" => "scene".to_owned(),
        name => name.to_owned(),
    }
}

fn create_folder(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|error| failed("cannot create the folder", path, &error))
}

fn failed(what: &str, path: &Path, error: &io::Error) -> Failure {
    Failure::Failed(format!("{what} {}: {error}", path.display()))
}

/// Whether there is nothing by that name.
fn is_absent(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_our_own_have_a_number() {
        assert_eq!(number("frame_00012.vtu.partial", "vtu.partial"), Some(12));
        let number = |name: &str| number(name, "vtu");
        assert_eq!(number("frame_00012.vtu"), Some(12));
        assert_eq!(number("frame_123456.vtu"), Some(123_456));
        for foreign in [
            "frame_12.vtu",
            "frame_00012.ply",
            "frame_00012.vtu.bak",
            "frame_0001a.vtu",
            "frame_+0001.vtu",
            "my_frame_00012.vtu",
            "frame_.vtu",
        ] {
            assert_eq!(number(foreign), None, "{foreign}");
        }
    }

    #[test]
    fn a_scene_name_cannot_leave_the_folder() {
        for (name, expected) in [
            ("dam_break", "dam_break"),
            ("../../etc", "_.._etc"),
            ("a/b c", "a_b_c"),
            ("..", "scene"),
            ("", "scene"),
            ("Überfall-2.5", "Überfall-2.5"),
        ] {
            assert_eq!(file_name(name), expected);
        }
        assert_eq!(
            RunFolder::new(None, "a/b").root(),
            Path::new("out").join("a_b")
        );
    }

    #[test]
    fn an_older_run_goes_and_foreign_files_stay() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let run = RunFolder::new(Some(folder.path()), "dam");
        assert_eq!(run.prepare(true), Ok(()));
        let write = |name: &str| fs::write(folder.path().join(name), "").expect("a file");
        let ours = [
            "scene.ron",
            "history.csv",
            "summary.json",
            "dam.pvd",
            "contact_sheet.png",
            "frames/frame_00000.vtu",
            "frames/frame_00000.ply",
            "frames/frame_00001.vtu.partial",
            "pictures/frame_00000.png",
        ];
        let foreign = ["notes.txt", "frames/scan_00001.ply", "pictures/best.png"];
        ours.iter().chain(&foreign).for_each(|name| write(name));
        assert_eq!(run.prepare(false), Ok(()));
        for name in ours {
            assert!(!folder.path().join(name).exists(), "{name} is still there");
        }
        for name in foreign {
            assert!(folder.path().join(name).exists(), "{name} is gone");
        }
    }

    #[test]
    fn a_scene_that_no_run_wrote_is_not_overwritten() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join("scene.ron"), "(name: \"mine\")").expect("a file");
        let refused = RunFolder::new(Some(folder.path()), "dam").prepare(true);
        assert!(matches!(refused, Err(Failure::Refused(text)) if text.contains("--out")));
    }
}
