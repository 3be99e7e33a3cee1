//! Results that replace older ones (`--force`): they are written into a subfolder, and take the place of the older
//! ones when they are complete.
//!
//! Until then the older results stay where they are, however the program ends. While files are exchanged, the older
//! ones are in a folder `older_1`, `older_2`, …, which is removed last.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use overfall::output::write_durably;

use super::console;
use super::exit::{Failure, cannot_write};
use super::lock::{LOCK, lock_folder};
use super::manifest::{Listing, MANIFEST, NOT_OURS, failed, is_there};
use super::writer::Writer;

/// Name of the subfolder.
const UNFINISHED: &str = "unfinished";

/// The subfolder of results that replace those of a folder.
pub(super) fn unfinished(root: &Path) -> PathBuf {
    root.join(UNFINISHED)
}

/// Where a file was left: by a program that was to replace the results of `root`, or in `root` itself.
pub(super) fn newest(root: &Path, name: &str) -> PathBuf {
    let beside = unfinished(root);
    let is_newer = beside.join(MANIFEST).is_file() && beside.join(name).is_file();
    if is_newer { beside } else { root.to_owned() }
}

/// The folder whose results are to be replaced.
#[derive(Debug)]
pub(super) struct Replaced {
    root: PathBuf,
    is_done: AtomicBool,
    /// Unlocked on drop.
    _lock: Option<File>,
}

impl Replaced {
    /// Replaces the results of a folder, which is locked.
    pub(super) fn new(root: &Path, lock: Option<File>) -> Self {
        Self {
            root: root.to_owned(),
            is_done: AtomicBool::new(false),
            _lock: lock,
        }
    }

    /// The folder whose results the writer was to replace when it was stopped; `None` if `beside` is no such folder.
    pub(super) fn again(beside: &Path, writer: &Writer) -> Result<Option<Self>, Failure> {
        let Ok(real) = beside.canonicalize() else {
            return Ok(None);
        };
        let named = beside.parent().filter(|path| *path != Path::new(""));
        let root = named.or_else(|| real.parent());
        let Some(root) = root.filter(|_| real.ends_with(UNFINISHED)) else {
            return Ok(None);
        };
        match Listing::read(root)? {
            Some(older) if older.writer == writer.line() => {
                Ok(Some(Self::new(root, lock_folder(root)?)))
            }
            _ => Ok(None),
        }
    }

    /// Exchanges the results: those in `beside` take the place of the older ones, which are removed.
    pub(super) fn replace(&self, beside: &Path) -> Result<(), Failure> {
        let root = &self.root;
        let (Some(new), older) = (Listing::read(beside)?, Listing::read(root)?) else {
            let reason = std::io::Error::from(std::io::ErrorKind::NotFound);
            return Err(failed("cannot read", &beside.join(MANIFEST), &reason));
        };
        let is_older = |name: &String| older.as_ref().is_some_and(|old| old.files.contains(name));
        let is_new = |name: &&String| is_there(&beside.join(name));
        for name in new.files.iter().filter(is_new) {
            let path = root.join(name);
            if !is_older(name) && is_there(&path) {
                return Err(Failure::Failed(format!(
                    "{}: {NOT_OURS}; the new results stay in {}",
                    path.display(),
                    beside.display()
                )));
            }
        }
        let aside = (older.as_ref())
            .map(|older| older.move_aside(root, root))
            .transpose()?;
        // The manifest first: a file that is moved is one of ours at once.
        let manifest = beside.join(MANIFEST);
        let text = fs::read(&manifest).map_err(|error| failed("cannot read", &manifest, &error))?;
        write_durably(&root.join(MANIFEST), &text).map_err(cannot_write)?;
        for name in new.files.iter().filter(is_new) {
            let (from, to) = (beside.join(name), root.join(name));
            let moved = (to.parent())
                .map_or(Ok(()), fs::create_dir_all)
                .and_then(|()| fs::rename(&from, &to));
            moved.map_err(|error| failed("cannot move the new", &from, &error))?;
        }
        self.is_done.store(true, Ordering::Relaxed);
        new.remove(beside)?;
        // What else is in the folders is not ours, and stays.
        let _ = fs::remove_file(beside.join(LOCK));
        let _ = fs::remove_dir(beside);
        if let (Some(older), Some(aside)) = (older, aside) {
            older.remove(&aside)?;
            let _ = fs::remove_dir(aside);
        }
        Ok(())
    }

    /// Where a file in `beside` is now.
    pub(super) fn place(&self, beside: &Path, file: &Path) -> PathBuf {
        match file.strip_prefix(beside) {
            Ok(name) if self.is_done.load(Ordering::Relaxed) => self.root.join(name),
            _ => file.to_owned(),
        }
    }
}

impl Drop for Replaced {
    /// Tells where the results are if the program ends early, for whatever reason.
    fn drop(&mut self) {
        if !self.is_done.load(Ordering::Relaxed) {
            console::note(&format!(
                "the older results in {} are as they were; what there is of the new ones is in {}",
                self.root.display(),
                unfinished(&self.root).display()
            ));
        }
    }
}

/// Moves results that were to replace those of `root`, but were never complete, into a new folder and returns it.
pub(super) fn set_aside(root: &Path, writer: &Writer) -> Result<Option<PathBuf>, Failure> {
    let beside = unfinished(root);
    if !beside.is_dir() {
        return Ok(None);
    }
    let Some(listing) = Listing::read(&beside)? else {
        return Ok(None);
    };
    let _lock = lock_folder(&beside)?;
    writer.refuse_inputs(&beside, &listing)?;
    let aside = listing.move_aside(&beside, root)?;
    let _ = fs::remove_file(beside.join(LOCK));
    let _ = fs::remove_dir(beside);
    Ok(Some(aside))
}

#[cfg(test)]
mod tests {
    use super::super::claims::Claims;
    use super::*;

    fn start(root: &Path, force: bool) -> Result<(Claims, Option<PathBuf>), Failure> {
        let writer = Writer {
            kind: "study",
            name: "a",
            force,
            inputs: Vec::new(),
        };
        Claims::start(root, &writer, &["a.csv".to_owned()])
    }

    /// Writes files of ours with a text; returns where each of them is in the end.
    fn write(root: &Path, text: &str, names: &[&str], is_complete: bool) -> Result<(), Failure> {
        let (claims, _) = start(root, true)?;
        for name in names {
            let path = claims.claim(name).expect("a file of ours");
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, text).expect("a file");
        }
        if is_complete {
            claims.complete()?;
        }
        Ok(())
    }

    fn read(path: PathBuf) -> String {
        fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    #[test]
    fn older_results_stay_until_the_new_ones_are_complete() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        let names = ["a.csv", "frames/b.csv"];
        write(root, "first", &names, false).expect("the first needs no other place");
        fs::write(root.join("frames/notes.txt"), "mine").expect("a file");
        write(root, "stopped", &names, false).expect("results");
        for name in names {
            assert_eq!(read(root.join(name)), "first");
            assert_eq!(read(unfinished(root).join(name)), "stopped");
        }
        assert_eq!(newest(root, "a.csv"), unfinished(root));
        write(root, "third", &names[..1], true).expect("results");
        assert_eq!(read(root.join("a.csv")), "third");
        assert_eq!(newest(root, "a.csv"), root);
        assert!(!root.join("frames/b.csv").exists() && !unfinished(root).exists());
        // What was stopped is kept, what was complete is replaced, and what is the user's stays.
        assert_eq!(read(root.join("older_1/a.csv")), "stopped");
        assert!(!root.join("older_2").exists());
        assert_eq!(read(root.join("frames/notes.txt")), "mine");
    }

    #[test]
    fn a_file_of_the_users_that_appears_meanwhile_is_not_replaced() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        write(root, "first", &["a.csv"], true).expect("results");
        let (claims, _) = start(root, true).expect("a folder");
        for name in ["a.csv", "b.csv"] {
            fs::write(claims.claim(name).expect("a file of ours"), "second").expect("a file");
        }
        fs::write(root.join("b.csv"), "mine").expect("a file");
        let refused = claims.complete();
        assert!(matches!(refused, Err(Failure::Failed(text)) if text.contains("b.csv")));
        drop(claims);
        assert_eq!(read(root.join("b.csv")), "mine");
        assert_eq!(read(root.join("a.csv")), "first");
        assert_eq!(read(unfinished(root).join("b.csv")), "second");
    }

    #[test]
    fn a_folder_of_that_name_with_files_of_the_users_is_refused_or_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        write(root, "first", &["a.csv"], true).expect("results");
        fs::create_dir(unfinished(root)).expect("a folder");
        fs::write(unfinished(root).join("a.csv"), "mine").expect("a file");
        assert!(matches!(start(root, true), Err(Failure::Refused(_))));
        fs::rename(unfinished(root).join("a.csv"), unfinished(root).join("z")).expect("renamed");
        write(root, "second", &["a.csv"], true).expect("results");
        assert_eq!(read(root.join("a.csv")), "second");
        assert_eq!(read(unfinished(root).join("z")), "mine");
    }

    #[test]
    fn two_programs_do_not_write_into_the_same_unfinished_results() {
        let folder = tempfile::tempdir().expect("a folder");
        let root = folder.path();
        write(root, "first", &["a.csv"], true).expect("results");
        let (claims, _) = start(root, true).expect("a folder");
        let refusals = [
            start(root, true).err(),
            Claims::reopen(&unfinished(root)).err(),
        ];
        for refused in refusals {
            assert!(matches!(refused, Some(Failure::Refused(text)) if text.contains("another")));
        }
        drop(claims);
    }
}
