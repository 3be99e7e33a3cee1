//! Ownership of files in an output folder: a manifest lists every file of ours before it is written, and no other file
//! is ever replaced, moved or removed.
//!
//! The files of an older run or study are known from its manifest: they are moved into a subfolder, or on request
//! replaced when the new ones are complete (`beside.rs`).

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use overfall::output::{OutputError, partial_name};

use super::beside::{self, Replaced};
use super::exit::Failure;
use super::lock::lock_folder;
use super::manifest::{HEAD, Listing, MANIFEST, NOT_OURS, create_folder, failed, is_there};
use super::writer::Writer;

/// The files of a folder that are ours, and the lock on it.
#[derive(Debug)]
pub(super) struct Claims {
    root: PathBuf,
    manifest: Mutex<Manifest>,
    /// Where the results belong when they are complete, if that is another folder.
    replaced: Option<Replaced>,
    /// Unlocked on drop; `None` if the file system has no locks.
    _lock: Option<File>,
}

#[derive(Debug)]
struct Manifest {
    file: File,
    listed: BTreeSet<String>,
}

impl Claims {
    /// Prepares the folder `root`: creates it, locks it against other programs, and moves the files of an older run
    /// aside. Also returns the folder to which these were moved. If they are to be replaced, they stay until
    /// [`complete`](Self::complete), and files are written into a subfolder.
    ///
    /// `planned` are the files, relative to the folder, that will be written there. If one of them exists and is not
    /// ours, the folder is refused.
    pub(super) fn start(
        root: &Path,
        writer: &Writer,
        planned: &[String],
    ) -> Result<(Self, Option<PathBuf>), Failure> {
        create_folder(root)?;
        let lock = lock_folder(root)?;
        let older = Listing::read(root)?;
        let is_listed = |name: &String| older.as_ref().is_some_and(|old| old.files.contains(name));
        for name in planned.iter().filter(|name| !is_listed(name)) {
            refuse_if_there(root, name)?;
        }
        let mut aside = beside::set_aside(root, writer)?;
        if let Some(older) = older {
            writer.refuse_inputs(root, &older)?;
            if writer.force && older.writer == writer.line() {
                let beside = beside::unfinished(root);
                create_folder(&beside)?;
                for name in planned {
                    refuse_if_there(&beside, name)?;
                }
                let mut claims = Self::create(&beside, writer, lock_folder(&beside)?)?;
                claims.replaced = Some(Replaced::new(root, lock));
                return Ok((claims, aside));
            }
            aside = Some(older.move_aside(root, root)?);
        }
        Ok((Self::create(root, writer, lock)?, aside))
    }

    /// Writes the manifest of a folder.
    fn create(root: &Path, writer: &Writer, lock: Option<File>) -> Result<Self, Failure> {
        let path = root.join(MANIFEST);
        let file = File::create_new(&path)
            .and_then(|mut file| {
                file.write_all(format!("{HEAD}\n{}\n", writer.line()).as_bytes())?;
                Ok(file)
            })
            .map_err(|error| failed("cannot write", &path, &error))?;
        Ok(Self::new(root, file, BTreeSet::new(), lock))
    }

    /// The folder into which files are written.
    pub(super) fn root(&self) -> &Path {
        &self.root
    }

    /// Puts complete results where they belong: older ones are replaced now. Nothing is written afterwards.
    pub(super) fn complete(&self) -> Result<(), Failure> {
        match &self.replaced {
            Some(replaced) => replaced.replace(&self.root),
            None => Ok(()),
        }
    }

    /// Where a file or the folder is now.
    pub(super) fn place(&self, file: &Path) -> PathBuf {
        match &self.replaced {
            Some(replaced) => replaced.place(&self.root, file),
            None => file.to_owned(),
        }
    }

    /// Continues in the folder of a run that resumes. Refuses a folder of another writer.
    pub(super) fn go_on(root: &Path, writer: &Writer) -> Result<Self, Failure> {
        if let Some(listing) = Listing::read(root)?
            && listing.writer != writer.line()
        {
            return Err(Failure::Refused(format!(
                "{}: this is the folder of {}, not of {}; choose another --out",
                root.display(),
                listing.writer,
                writer.line()
            )));
        }
        let mut claims = Self::reopen(root)?;
        claims.replaced = Replaced::again(root, writer)?;
        Ok(claims)
    }

    /// Whether the manifest lists the file.
    pub(super) fn is_ours(&self, name: &str) -> bool {
        let manifest = self.manifest.lock();
        let manifest = manifest.unwrap_or_else(|lock| lock.into_inner());
        manifest.listed.contains(name)
    }

    /// Continues in the folder of a finished run.
    pub(super) fn reopen(root: &Path) -> Result<Self, Failure> {
        let Some(listing) = Listing::read(root)? else {
            return Err(Failure::Refused(format!(
                "{}: no run wrote this folder (there is no {MANIFEST} in it)",
                root.display()
            )));
        };
        let lock = lock_folder(root)?;
        let path = root.join(MANIFEST);
        let open = || {
            let file = File::options().append(true).open(&path)?;
            // A program that was killed may have left an incomplete last line.
            file.set_len(listing.bytes)?;
            Ok(file)
        };
        let file = open().map_err(|error| failed("cannot write", &path, &error))?;
        Ok(Self::new(root, file, listing.files, lock))
    }

    fn new(root: &Path, file: File, listed: BTreeSet<String>, lock: Option<File>) -> Self {
        Self {
            root: root.to_owned(),
            manifest: Mutex::new(Manifest { file, listed }),
            replaced: None,
            _lock: lock,
        }
    }

    /// Fails if the folder or its manifest was removed meanwhile: further output would be lost.
    pub(super) fn check(&self) -> Result<(), OutputError> {
        let path = self.root.join(MANIFEST);
        if is_there(&path) {
            return Ok(());
        }
        let source = io::Error::new(ErrorKind::NotFound, "the file or its folder was removed");
        Err(OutputError::Io { path, source })
    }

    /// The path of a file that will be written, from its name relative to the folder.
    ///
    /// Fails if the file exists and is not ours.
    pub(super) fn claim(&self, name: &str) -> Result<PathBuf, OutputError> {
        let path = self.root.join(name);
        let mut manifest = self
            .manifest
            .lock()
            .unwrap_or_else(|lock| lock.into_inner());
        if manifest.listed.contains(name) {
            return Ok(path);
        }
        let claimed = if is_there(&path) || is_there(&partial_name(&path)) {
            Err(io::Error::new(ErrorKind::AlreadyExists, NOT_OURS))
        } else {
            manifest.file.write_all(format!("{name}\n").as_bytes())
        };
        claimed.map_err(|source| OutputError::Io {
            path: path.clone(),
            source,
        })?;
        manifest.listed.insert(name.to_owned());
        Ok(path)
    }
}

fn refuse_if_there(root: &Path, name: &str) -> Result<(), Failure> {
    let path = root.join(name);
    for path in [partial_name(&path), path] {
        if is_there(&path) {
            return Err(Failure::Refused(format!(
                "{}: {NOT_OURS}; choose another --out",
                path.display()
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::lock::LOCK;
    use super::*;

    fn run(name: &str, force: bool) -> Writer<'_> {
        Writer {
            kind: "run",
            name,
            force,
            inputs: Vec::new(),
        }
    }

    fn planned() -> Vec<String> {
        ["history.csv", "frames/frame_00000.vtu"]
            .map(str::to_owned)
            .to_vec()
    }

    /// Writes the planned files, each with the name of the run as its content; returns where the older files are now.
    fn write(root: &Path, writer: &Writer) -> Result<Option<PathBuf>, Failure> {
        let (claims, aside) = Claims::start(root, writer, &planned())?;
        fs::create_dir_all(claims.root().join("frames")).expect("a folder");
        for name in planned() {
            let path = claims.claim(&name).expect("a file of ours");
            fs::write(path, writer.name).expect("a file");
        }
        claims.complete()?;
        Ok(aside)
    }

    fn read(path: PathBuf) -> String {
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    #[test]
    fn an_older_run_is_moved_aside_and_foreign_files_stay() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        let foreign = [
            "notes.txt",
            "frames/frame_00007.vtu",
            "frames/scan.ply",
            "older_2",
        ];
        assert_eq!(write(root, &run("a", false)), Ok(None));
        for name in foreign {
            fs::write(root.join(name), "mine").expect("a file");
        }
        assert_eq!(
            write(root, &run("a", false)),
            Ok(Some(root.join("older_1")))
        );
        // A run of another scene is never replaced.
        assert_eq!(write(root, &run("b", true)), Ok(Some(root.join("older_3"))));
        assert_eq!(write(root, &run("b", true)), Ok(None));
        for (place, name) in [("", "b"), ("older_1", "a"), ("older_3", "a")] {
            for file in planned() {
                assert_eq!(read(root.join(place).join(&file)), name, "{place}/{file}");
            }
        }
        for name in foreign {
            assert_eq!(read(root.join(name)), "mine", "{name}");
        }
    }

    #[test]
    fn a_folder_with_a_file_of_somebodys_is_refused_and_nothing_is_changed() {
        for foreign in [
            "history.csv",
            "history.csv.partial",
            "frames/frame_00000.vtu",
            MANIFEST,
        ] {
            let folder = tempfile::tempdir().expect("a folder");
            fs::create_dir(folder.path().join("frames")).expect("a folder");
            fs::write(folder.path().join(foreign), "mine\n").expect("a file");
            for force in [false, true] {
                let refused = write(folder.path(), &run("a", force));
                assert!(
                    matches!(&refused, Err(Failure::Refused(text)) if text.contains("--out")),
                    "{foreign}: {refused:?}"
                );
            }
            assert_eq!(read(folder.path().join(foreign)), "mine\n");
        }
    }

    #[test]
    fn a_file_that_appears_while_it_runs_is_not_overwritten() {
        let folder = tempfile::tempdir().expect("a folder");
        let (claims, _) = Claims::start(folder.path(), &run("a", false), &[]).expect("a folder");
        fs::write(folder.path().join("late.csv"), "mine").expect("a file");
        assert!(claims.claim("late.csv").is_err());
        assert!(claims.claim("new.csv").is_ok());
        fs::write(folder.path().join("new.csv"), "ours").expect("a file");
        assert!(claims.claim("new.csv").is_ok(), "it is ours already");
    }

    #[test]
    fn what_is_read_is_not_moved() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(write(folder.path(), &run("a", false)), Ok(None));
        let mut again = run("a", true);
        again.inputs = vec![folder.path().join("frames/../history.csv")];
        let refused = write(folder.path(), &again);
        assert!(matches!(refused, Err(Failure::Refused(text)) if text.contains("it is an input")));
        assert_eq!(read(folder.path().join("history.csv")), "a");
    }

    #[test]
    fn two_that_write_are_kept_apart() {
        let folder = tempfile::tempdir().expect("a folder");
        let first = Claims::start(folder.path(), &run("a", false), &[]).expect("a folder");
        let second = Claims::start(folder.path(), &run("a", false), &[]);
        assert!(matches!(second, Err(Failure::Refused(text)) if text.contains("another overfall")));
        drop(first);
        assert!(Claims::start(folder.path(), &run("a", false), &[]).is_ok());
        fs::remove_file(folder.path().join(LOCK)).expect("removed");
        fs::create_dir(folder.path().join(LOCK)).expect("a folder");
        let third = Claims::start(folder.path(), &run("a", false), &[]);
        assert!(matches!(third, Err(Failure::Refused(_))), "no file of ours");
    }

    #[test]
    fn a_manifest_cannot_lead_out_of_its_folder_and_half_a_line_is_left_out() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path().join("out");
        for name in ["../mine", "/etc/hostname", "a/../../mine", ""] {
            fs::create_dir_all(&root).expect("a folder");
            fs::write(root.join(MANIFEST), format!("{HEAD}\nrun \"a\"\n{name}\n")).expect("a file");
            assert!(write(&root, &run("a", true)).is_err(), "{name}");
        }
        let text = format!("{HEAD}\nrun \"a\"\nhistory.csv\nframes/fra");
        fs::write(root.join(MANIFEST), text).expect("a file");
        let claims = Claims::reopen(&root).expect("a manifest");
        claims.claim("late.csv").expect("a file of ours");
        let text = read(root.join(MANIFEST));
        assert_eq!(text, format!("{HEAD}\nrun \"a\"\nhistory.csv\nlate.csv\n"));
    }
}
