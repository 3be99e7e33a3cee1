//! A table that grows during a run: a text file of complete rows.

use std::fs::{self, File};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::OutputError;
use super::atomic::write_atomically;

/// Buffered rows are written to the file when they have this many bytes …
const BUFFER_BYTES: usize = 1 << 16;
/// … or after this time, so that the file also shows the progress of a slow run.
const BUFFER_TIME: Duration = Duration::from_secs(1);

/// A file that rows are appended to. Only complete rows are written to it, so that an interruption leaves a valid file.
/// Buffered rows are written by [`flush`](Self::flush) and on drop.
#[derive(Debug)]
pub(super) struct RowFile {
    path: PathBuf,
    file: File,
    waiting: String,
    /// Rows in the file and in the buffer.
    rows: u64,
    written_at: Instant,
}

impl RowFile {
    /// Creates a file that contains `text`; an existing file is replaced.
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

    /// Continues a file after its first `rows` rows, which are returned. If the file is missing or has another header,
    /// nothing is kept.
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

    /// Number of rows so far.
    pub(super) fn rows(&self) -> u64 {
        self.rows
    }

    /// Adds a row. `append` appends it to the buffer, line break included.
    pub(super) fn push(&mut self, append: impl FnOnce(&mut String)) -> Result<(), OutputError> {
        append(&mut self.waiting);
        self.rows += 1;
        if self.waiting.len() >= BUFFER_BYTES || self.written_at.elapsed() >= BUFFER_TIME {
            self.flush()?;
        }
        Ok(())
    }

    /// Writes the buffered rows. Fails if the operating system reports an error or the file was removed meanwhile:
    /// complete rows stay, buffered ones are lost.
    pub(super) fn flush(&mut self) -> Result<(), OutputError> {
        let result = self.append();
        self.waiting.clear();
        self.written_at = Instant::now();
        result.map_err(|source| OutputError::io(&self.path, source))
    }

    fn append(&mut self) -> std::io::Result<()> {
        // Writing to a removed file succeeds, but the rows would be lost.
        if !self.is_there()? {
            let reason = "the file or its folder was removed";
            return Err(std::io::Error::new(ErrorKind::NotFound, reason));
        }
        let before = self.file.metadata()?.len();
        self.file
            .write_all(self.waiting.as_bytes())
            .inspect_err(|_| {
                // A full disk accepts a part of the data: keep its complete rows. If that fails too, nothing more can
                // be done.
                let _ = self.drop_half_a_row(before);
            })
    }

    /// Whether the path still refers to this file.
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
        // An error cannot be reported here; callers that need it call `flush`.
        let _ = self.flush();
    }
}
