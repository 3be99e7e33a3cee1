//! Files that are written completely or not at all.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::OutputError;

/// Writes to `NAME.partial` beside `path` and renames it to `path` once complete.
/// The data are not forced to the disk. They survive a kill of the process, which is common, but not a power failure;
/// that would cost a disk flush per frame. The temporary name is fixed, so the next run overwrites what a killed one
/// left.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<(), OutputError> {
    let partial = partial_name(path);
    let result = File::create(&partial)
        .and_then(|file| {
            let mut writer = BufWriter::with_capacity(1 << 18, file);
            write(&mut writer)?;
            writer.flush()
        })
        .and_then(|()| fs::rename(&partial, path));
    result.map_err(|source| {
        // The first error is reported. A temporary file that cannot be removed does no harm.
        let _ = fs::remove_file(&partial);
        OutputError::io(path, source)
    })
}

/// As [`write_atomically`], but the file is on the disk on return: it also survives a power failure.
pub fn write_durably(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let partial = partial_name(path);
    let write = || {
        let mut file = File::create(&partial)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&partial, path)?;
        sync_folder_of(path)
    };
    write().map_err(|source| {
        let _ = fs::remove_file(&partial);
        OutputError::io(path, source)
    })
}

/// Forces a new name in a folder to the disk, on systems where folders can be opened.
fn sync_folder_of(path: &Path) -> std::io::Result<()> {
    if cfg!(not(unix)) {
        return Ok(());
    }
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}

/// The name under which [`write_atomically`] writes a file until it is complete.
pub fn partial_name(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".partial");
    PathBuf::from(name)
}
