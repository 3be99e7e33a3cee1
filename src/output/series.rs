//! The series of a run's frames: the file of each time. ParaView opens it as one animation.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::OutputError;
use super::atomic::write_atomically;
use super::cursor::{attribute, number};
use crate::input::read_text;

/// One frame of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct SeriesEntry {
    /// Simulated time \[s].
    pub time: f64,
    /// The frame's file, relative to the series' folder.
    pub file: String,
}

/// A `.pvd` file. It is rewritten atomically with every frame, so it is valid at any time. At 60 bytes per frame that
/// costs less than the frame itself up to tens of thousands of frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    path: PathBuf,
    entries: Vec<SeriesEntry>,
}

impl Series {
    /// A series without frames; the file is created with the first.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            entries: Vec::new(),
        }
    }

    /// Reads a series that an earlier run wrote.
    ///
    /// # Errors
    /// If the file cannot be read or is not a series of ours.
    pub fn read(path: impl Into<PathBuf>) -> Result<Self, OutputError> {
        let path = path.into();
        let text = read_text(&path).map_err(|source| OutputError::io(&path, source))?;
        let entries = parse(&text).map_err(|reason| OutputError::malformed(&path, reason))?;
        Ok(Self { path, entries })
    }

    /// Adds a frame at a time \[s] and writes the file. Frames at that time or later are removed first: a run that
    /// resumes from a checkpoint writes them again.
    ///
    /// # Errors
    /// If the operating system reports an error; the previous series then stays on disk.
    pub fn push(&mut self, time: f64, file: &str) -> Result<(), OutputError> {
        self.entries.retain(|entry| entry.time < time);
        self.entries.push(SeriesEntry {
            time,
            file: file.to_owned(),
        });
        self.write()
    }

    fn write(&self) -> Result<(), OutputError> {
        let text = self.text();
        write_atomically(&self.path, |out| out.write_all(text.as_bytes()))
    }

    /// Removes the frames after a time \[s]; writes the file if there were any.
    ///
    /// # Errors
    /// As [`push`](Self::push).
    pub fn withdraw_after(&mut self, time: f64) -> Result<(), OutputError> {
        let frames = self.entries.len();
        self.entries.retain(|entry| entry.time <= time);
        if self.entries.len() == frames {
            return Ok(());
        }
        self.write()
    }

    /// The frames, sorted by time.
    pub fn entries(&self) -> &[SeriesEntry] {
        &self.entries
    }

    /// The path of the series.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn text(&self) -> String {
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" \
             byte_order=\"LittleEndian\">\n<Collection>\n",
        );
        for SeriesEntry { time, file } in &self.entries {
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "<DataSet timestep=\"{time}\" part=\"0\" file=\"{}\"/>",
                escape(file)
            );
        }
        text.push_str("</Collection>\n</VTKFile>\n");
        text
    }
}

fn parse(text: &str) -> Result<Vec<SeriesEntry>, String> {
    if !text.contains("type=\"Collection\"") || !text.ends_with("</VTKFile>\n") {
        return Err("not a complete series of frames".to_owned());
    }
    text.lines()
        .filter_map(|line| line.strip_prefix("<DataSet")?.strip_suffix("/>"))
        .map(|tag| {
            Ok(SeriesEntry {
                time: number(attribute(tag, "timestep")?, "timestep")?,
                file: unescape(attribute(tag, "file")?),
            })
        })
        .collect()
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}

fn unescape(text: &str) -> String {
    text.replace("&quot;", "\"")
        .replace("&lt;", "<")
        .replace("&amp;", "&")
}
