//! Frames as VTK XML unstructured grids, one vertex per particle.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::atomic::write_atomically;
use super::cursor::{attribute, block, number, split_header};
use super::fields::{self, FIELDS, Field};
use super::grid::{Array, Cells, Grid};
use super::{Frame, OutputError};

/// Every block of data starts with its length in bytes as a `UInt64`.
const LENGTH_BYTES: usize = 8;
/// Frames of earlier versions end with raw data after this line.
const DATA_START: &str = "<AppendedData encoding=\"raw\">\n_";

pub(super) fn write(frame: &Frame, path: &Path) -> Result<(), OutputError> {
    let rows = fields::rows(frame)?;
    let array = |field: &'static Field| {
        let column = (field.column)(frame);
        Array {
            name: field.name,
            kind: column.vtk_type(),
            components: field.components(),
            row_bytes: field.row_bytes(),
            push_row: Box::new(move |row, bytes| column.push_row(row, bytes)),
        }
    };
    let grid = Grid {
        time: frame.time,
        step: frame.step,
        rows,
        points: array(&FIELDS[0]),
        cells: Cells::Vertices,
        data: FIELDS[1..].iter().map(array).collect(),
        shown_first: " Scalars=\"density\" Vectors=\"velocity\"",
    };
    write_atomically(path, |out| grid.write(out))
}

pub(super) fn parse(bytes: &[u8]) -> Result<Frame, String> {
    // A frame without raw data is text as a whole.
    let (header, data) = match split_header(bytes, DATA_START) {
        Ok((header, data)) => (header, Some(data)),
        Err(_) => (
            std::str::from_utf8(bytes).map_err(|_| "the file is not text".to_owned())?,
            None,
        ),
    };
    if !header.contains("type=\"UnstructuredGrid\"") {
        return Err("not a VTK unstructured grid".to_owned());
    }
    for expected in ["byte_order=\"LittleEndian\"", "header_type=\"UInt64\""] {
        if !header.contains(expected) {
            return Err(format!("the header does not say {expected}"));
        }
    }

    let (_, time) = array(header, "TimeValue")?;
    let (_, step) = array(header, "step")?;
    let mut frame = Frame {
        time: number(time, "TimeValue")?,
        step: number(step, "step")?,
        ..Frame::default()
    };

    let piece = tags(header)
        .find(|tag| tag.starts_with("Piece "))
        .ok_or("no <Piece>")?;
    let rows: usize = number(attribute(piece, "NumberOfPoints")?, "NumberOfPoints")?;
    for field in &FIELDS {
        let (tag, text) = array(header, field.name)?;
        let kind = (field.column)(&frame).vtk_type();
        let components = match attribute(tag, "NumberOfComponents") {
            Ok(number_of) => number(number_of, "NumberOfComponents")?,
            Err(_) => 1,
        };
        if attribute(tag, "type")? != kind || components != field.components() {
            return Err(format!(
                "{} must have {} components of type {kind}",
                field.name,
                field.components()
            ));
        }
        let decoded;
        let (data, start) = match (attribute(tag, "format")?, data) {
            ("binary", _) => {
                let decode = STANDARD.decode(text.trim());
                decoded = decode.map_err(|error| format!("{}: {error}", field.name))?;
                (&decoded[..], 0)
            }
            ("appended", Some(data)) => (data, number(attribute(tag, "offset")?, "offset")?),
            (format, _) => return Err(format!("{} has the format {format:?}", field.name)),
        };
        let length = block(data, start, 1, LENGTH_BYTES)?;
        let values = block(
            data,
            start.saturating_add(LENGTH_BYTES),
            rows,
            field.row_bytes(),
        )?;
        if length != (values.len() as u64).to_le_bytes() {
            return Err(format!("{} has not {rows} rows", field.name));
        }
        let mut column = (field.column_mut)(&mut frame);
        column.reserve(rows);
        values
            .chunks_exact(field.row_bytes())
            .for_each(|row| column.push(row));
    }
    if !bytes.ends_with(b"</VTKFile>\n") {
        return Err("the file ends too early".to_owned());
    }
    Ok(frame)
}

/// The text between each `<` and `>`.
fn tags(header: &str) -> impl Iterator<Item = &str> {
    header
        .split('<')
        .filter_map(|part| part.split_once('>').map(|(tag, _)| tag))
}

/// Tag and text of the array with a name.
fn array<'a>(header: &'a str, name: &str) -> Result<(&'a str, &'a str), String> {
    header
        .split('<')
        .filter_map(|part| part.split_once('>'))
        .find(|(tag, _)| tag.starts_with("DataArray ") && attribute(tag, "Name") == Ok(name))
        .ok_or_else(|| format!("no array {name}"))
}
