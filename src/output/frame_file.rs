//! Writes frames to files and reads them, by format.

use std::path::Path;

use super::error::OutputError;
use super::frame::Frame;
use super::{ply, vtu};
use crate::input::read_bytes;
use crate::scene::FrameFormat;

impl Frame {
    /// Writes the frame in a format; `path` should end in that format's [`extension`](FrameFormat::extension).
    ///
    /// # Errors
    /// If the columns differ in length, there are more than 2³¹ − 1 particles, or the operating system reports an
    /// error.
    pub fn write(&self, path: &Path, format: FrameFormat) -> Result<(), OutputError> {
        match format {
            FrameFormat::Vtu => self.write_vtu(path),
            FrameFormat::Ply => self.write_ply(path),
        }
    }

    /// Writes a VTK XML unstructured grid with one vertex per particle; data are base64, little endian. Time \[s] and
    /// step are the field data `TimeValue` and `step`.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_vtu(&self, path: &Path) -> Result<(), OutputError> {
        vtu::write(self, path)
    }

    /// Writes a binary little endian PLY file with one element `vertex` per particle: x, y, z \[m], vx, vy, vz \[m/s],
    /// density \[kg/m³], pressure \[Pa], id. Time \[s] and step are in comments of the header.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_ply(&self, path: &Path) -> Result<(), OutputError> {
        ply::write(self, path)
    }

    /// Reads a frame that [`write`](Self::write) wrote; the suffix of its name selects the format. Files of other
    /// programs are not supported in general.
    ///
    /// # Errors
    /// If the operating system reports an error, the suffix is unknown, or the file is not a complete frame.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let parse = match path.extension().and_then(|e| e.to_str()) {
            Some("vtu") => vtu::parse,
            Some("ply") => ply::parse,
            _ => {
                return Err(OutputError::UnknownFormat {
                    path: path.to_owned(),
                });
            }
        };
        let bytes = read_bytes(path).map_err(|source| OutputError::io(path, source))?;
        parse(&bytes).map_err(|reason| OutputError::malformed(path, reason))
    }
}

impl FrameFormat {
    /// Suffix of its files, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Vtu => "vtu",
            Self::Ply => "ply",
        }
    }
}
