//! The lock on a folder: one program at a time writes into it.

use std::fs::{File, TryLockError};
use std::path::Path;

use super::console;
use super::exit::Failure;
use super::manifest::{NOT_OURS, failed, is_there};

/// Locked by the program that writes into the folder. It is never removed: otherwise a third program could lock a new
/// file while a second waits for the old one.
pub(super) const LOCK: &str = ".overfall_lock";

/// Locks a folder.
pub(super) fn lock_folder(root: &Path) -> Result<Option<File>, Failure> {
    let path = root.join(LOCK);
    // Opening a pipe would wait for a reader.
    if is_there(&path) && !path.is_file() {
        return Err(Failure::Refused(format!(
            "{}: {NOT_OURS}; choose another --out",
            path.display()
        )));
    }
    let file = File::options()
        .create(true)
        .truncate(false)
        .write(true)
        .open(&path)
        .map_err(|error| failed("cannot write", &path, &error))?;
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => Err(Failure::Refused(format!(
            "{}: another overfall is writing into this folder; wait for it, or choose another --out",
            root.display()
        ))),
        Err(TryLockError::Error(error)) => {
            console::note(&format!(
                "{}: it cannot be locked ({error}); do not start a second run there",
                root.display()
            ));
            Ok(None)
        }
    }
}
