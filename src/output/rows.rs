//! A table that grows while a run goes on: whole rows in a text file.

use std::fs::{self, File};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::OutputError;
use super::atomic::write_atomically;

/// Rows go to the file when so many bytes wait …
const BUFFER_BYTES: usize = 1 << 16;
/// … or so long after the last time, so that who watches the file sees a slow run go on.
const BUFFER_TIME: Duration = Duration::from_secs(1);

/// A file that rows are appended to. Only whole rows ever go to it: what an interruption leaves is valid. Rows that
/// wait are written by [`flush`](Self::flush) or when it is dropped.
#[derive(Debug)]
pub(super) struct RowFile {
    path: PathBuf,
    file: File,
    waiting: String,
    /// Rows in the file and waiting.
    rows: u64,
    written_at: Instant,
}

impl RowFile {
    /// Starts a file that holds `text`, over an older one if there is one.
    pub(super) fn start(path: &Path, text: &str) -> Result<Self, OutputError> {
        write_atomically(path, |out| out.write_all(text.as_bytes()))?;
        let file = File::options()
            .append(true)
            .open(path)
            .map_err(|source| OutputError::io(path, source))?;
        Ok(Self {
            path: path.to_owned(),
            file,
            waiting: String::new(),
            rows: 0,
            written_at: Instant::now(),
        })
    }

    /// Goes on with a file after its first `rows` rows, and gives those. Of one with another header, or none, nothing is
    /// kept.
    pub(super) fn resume(
        path: &Path,
        header: &str,
        rows: u64,
    ) -> Result<(Self, Vec<String>), OutputError> {
        let old = match fs::read_to_string(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
            old => old.map_err(|source| OutputError::io(path, source))?,
        };
        let old = old.strip_prefix(header).unwrap_or_default();
        let whole = old.split_inclusive('\n').filter(|row| row.ends_with('\n'));
        let kept: Vec<String> = whole
            .take(usize::try_from(rows).unwrap_or(usize::MAX))
            .map(str::to_owned)
            .collect();
        let mut file = Self::start(path, &(header.to_owned() + &kept.concat()))?;
        file.rows = kept.len() as u64;
        Ok((file, kept))
    }

    /// Rows so far.
    pub(super) fn rows(&self) -> u64 {
        self.rows
    }

    /// Adds a row by what appends it, line break included.
    pub(super) fn push(&mut self, append: impl FnOnce(&mut String)) -> Result<(), OutputError> {
        append(&mut self.waiting);
        self.rows += 1;
        if self.waiting.len() >= BUFFER_BYTES || self.written_at.elapsed() >= BUFFER_TIME {
            self.flush()?;
        }
        Ok(())
    }

    /// Writes the rows that wait. Fails when the system refuses, or the file was removed meanwhile: whole rows stay,
    /// and those that wait are lost.
    pub(super) fn flush(&mut self) -> Result<(), OutputError> {
        let result = self.append();
        self.waiting.clear();
        self.written_at = Instant::now();
        result.map_err(|source| OutputError::io(&self.path, source))
    }

    fn append(&mut self) -> std::io::Result<()> {
        // A file that was removed takes rows without an end, and nobody would ever see them.
        if !self.is_there()? {
            let reason = "it was removed, or its folder was";
            return Err(std::io::Error::new(ErrorKind::NotFound, reason));
        }
        let before = self.file.metadata()?.len();
        self.file
            .write_all(self.waiting.as_bytes())
            .inspect_err(|_| {
                // A full disk takes a part: of that, whole rows stay. If this fails, too, there is nothing left to do.
                let _ = self.drop_half_a_row(before);
            })
    }

    /// Whether the file's name still leads to this file.
    fn is_there(&self) -> std::io::Result<bool> {
        let found = match fs::metadata(&self.path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(false),
            found => found?,
        };
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            let ours = self.file.metadata()?;
            Ok((found.dev(), found.ino()) == (ours.dev(), ours.ino()))
        }
        #[cfg(not(unix))]
        Ok(found.is_file())
    }

    fn drop_half_a_row(&self, before: u64) -> std::io::Result<()> {
        let written = self.file.metadata()?.len().saturating_sub(before) as usize;
        let written = &self.waiting.as_bytes()[..written.min(self.waiting.len())];
        let whole = written.iter().rposition(|&byte| byte == b'\n');
        self.file
            .set_len(before + whole.map_or(0, |end| end as u64 + 1))
    }
}

impl Drop for RowFile {
    fn drop(&mut self) {
        // There is no one to tell; who wants to know calls `flush`.
        let _ = self.flush();
    }
}
