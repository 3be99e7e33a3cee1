//! Reads triangles from a file; the suffix of its name selects [`obj`] or [`stl`].

use std::fs;
use std::path::Path;

use super::{error::MeshError, obj, soup::Soup, stl};
use crate::{input::read_bytes, memory};

/// Larger files hold more triangles than are supported \[bytes].
const MAX_BYTES: u64 = 2_000_000_000;

/// Memory that a byte of a file takes while its triangles are connected \[bytes], vertices and edges included.
const BYTES_A_BYTE: u64 = 10;

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
    let length = fs::metadata(file).map_or(0, |about| about.len());
    room_for(length, memory::of_machine()).map_err(refuse)?;
    let bytes = read_bytes(file).map_err(|source| MeshError::Unreadable {
        file: file.to_owned(),
        source,
    })?;
    parse(&bytes).map_err(refuse)
}

/// Refuses a file that is too long, or longer than the machine has memory to connect its triangles \[bytes].
fn room_for(length: u64, machine: u64) -> Result<(), String> {
    let megabytes = |bytes: u64| bytes / 1_000_000;
    if length > MAX_BYTES {
        return Err(format!(
            "it has more than {} MB; decimate it to triangles of about the spacing",
            megabytes(MAX_BYTES)
        ));
    }
    let needed = length.saturating_mul(BYTES_A_BYTE);
    if needed > machine {
        return Err(format!(
            "it has {} MB, whose triangles take about {} to connect, and there are {}; decimate it to triangles of \
             about the spacing",
            megabytes(length),
            memory::in_words(needed as f64),
            memory::in_words(machine as f64)
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_do_not_fit_are_refused_before_they_are_read() {
        for (length, machine, part) in [
            (MAX_BYTES + 1, u64::MAX, "more than 2000 MB"),
            (u64::MAX, u64::MAX, "more than 2000 MB"),
            (
                300_000_000,
                2_000_000_000,
                "300 MB, whose triangles take about 3.0 GB",
            ),
            (100_000_000, 2_000_000_000, ""),
        ] {
            let said = room_for(length, machine).err().unwrap_or_default();
            assert!(
                said.contains(part) && said.is_empty() == part.is_empty(),
                "{length}: {said}"
            );
        }
    }
}
