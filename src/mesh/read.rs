//! Reads triangles from a file; the suffix of its name selects [`obj`] or [`stl`].

use std::fs;
use std::path::Path;

use super::{error::MeshError, obj, soup::Soup, stl};
use crate::input::read_bytes;

/// Larger files hold more triangles than are supported \[bytes].
const MAX_BYTES: u64 = 2_000_000_000;

pub(super) fn read(file: &Path) -> Result<Soup, MeshError> {
    let refuse = |message: String| MeshError::Unusable {
        file: file.to_owned(),
        message,
    };
    let extension = file.extension().unwrap_or_default().to_ascii_lowercase();
    let parse = match extension.to_str() {
        Some("obj") => obj::read,
        Some("stl") => stl::read,
        _ => {
            return Err(refuse(
                "its name ends neither in .obj nor in .stl, the formats that can be read"
                    .to_owned(),
            ));
        }
    };
    if fs::metadata(file).is_ok_and(|about| about.len() > MAX_BYTES) {
        return Err(refuse(format!(
            "it has more than {} MB; decimate it to triangles of about the spacing",
            MAX_BYTES / 1_000_000
        )));
    }
    let bytes = read_bytes(file).map_err(|source| MeshError::Unreadable {
        file: file.to_owned(),
        source,
    })?;
    parse(&bytes).map_err(refuse)
}
