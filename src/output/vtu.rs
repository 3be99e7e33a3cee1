//! VTK XML unstructured grid, version 1.0.
//!
//! Option 1: base64 inline, which is valid XML. Option 2: raw appended data, which a strict XML parser refuses. We use
//! 2, because the files are a quarter smaller, and ParaView, the vtk library and meshio all read it.
//!
//! One vertex cell per particle: ParaView shows points without cells only after a filter.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use super::atomic::write_atomically;
use super::cursor::{attribute, block, number, split_header};
use super::fields::{self, FIELDS};
use super::{Frame, OutputError};

/// VTK's number of the cell type "vertex".
const VERTEX: u8 = 1;
/// Every block of appended data starts with its length in bytes as a `UInt64`.
const LENGTH_BYTES: usize = 8;
const DATA_START: &str = "<AppendedData encoding=\"raw\">\n_";

pub(super) fn write(frame: &Frame, path: &Path) -> Result<(), OutputError> {
    let rows = fields::rows(frame)?;
    let header = header(frame, rows);
    write_atomically(path, |out| {
        out.write_all(header.as_bytes())?;
        let mut bytes = Vec::new();
        for field in &FIELDS {
            let column = (field.column)(frame);
            bytes.clear();
            (0..rows).for_each(|row| column.push_row(row, &mut bytes));
            write_block(out, &bytes)?;
        }
        // Connectivity and offsets: vertex cell i consists of point i and ends before i + 1.
        for first in [0, 1] {
            bytes.clear();
            let numbers = first..first + rows as i32;
            numbers.for_each(|i| bytes.extend_from_slice(&i.to_le_bytes()));
            write_block(out, &bytes)?;
        }
        write_block(out, &vec![VERTEX; rows])?;
        out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
    })
}

fn write_block(out: &mut impl std::io::Write, bytes: &[u8]) -> std::io::Result<()> {
    out.write_all(&(bytes.len() as u64).to_le_bytes())?;
    out.write_all(bytes)
}

fn header(frame: &Frame, rows: usize) -> String {
    let mut offset = 0;
    let mut array = |name: &str, kind: &str, components: usize, row_bytes: usize| {
        // meshio reads a scalar with an explicit component count of 1 as a matrix of one column.
        let components = match components {
            1 => String::new(),
            more => format!(" NumberOfComponents=\"{more}\""),
        };
        let line = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\"{components} format=\"appended\" offset=\"{offset}\"/>\n"
        );
        offset += LENGTH_BYTES + rows * row_bytes;
        line
    };

    let mut points = String::new();
    let mut data = String::new();
    for (i, field) in FIELDS.iter().enumerate() {
        let kind = (field.column)(frame).vtk_type();
        let line = array(field.name, kind, field.components(), field.row_bytes());
        let section = if i == 0 { &mut points } else { &mut data };
        section.push_str(&line);
    }
    let cells = array("connectivity", "Int32", 1, 4)
        + &array("offsets", "Int32", 1, 4)
        + &array("types", "UInt8", 1, 1);

    let mut header = String::new();
    // Writing to a String cannot fail.
    let _ = write!(
        header,
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
         <UnstructuredGrid>\n\
         <FieldData>\n\
         <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time}</DataArray>\n\
         <DataArray type=\"UInt64\" Name=\"step\" NumberOfTuples=\"1\" format=\"ascii\">{step}</DataArray>\n\
         </FieldData>\n\
         <Piece NumberOfPoints=\"{rows}\" NumberOfCells=\"{rows}\">\n\
         <Points>\n{points}</Points>\n\
         <Cells>\n{cells}</Cells>\n\
         <PointData Scalars=\"density\" Vectors=\"velocity\">\n{data}</PointData>\n\
         </Piece>\n\
         </UnstructuredGrid>\n\
         {DATA_START}",
        time = frame.time,
        step = frame.step,
    );
    header
}

pub(super) fn parse(bytes: &[u8]) -> Result<Frame, String> {
    let (header, data) = split_header(bytes, DATA_START)?;
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
        let (tag, _) = array(header, field.name)?;
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
        let offset: usize = number(attribute(tag, "offset")?, "offset")?;
        let length = block(data, offset, 1, LENGTH_BYTES)?;
        let values = block(
            data,
            offset.saturating_add(LENGTH_BYTES),
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
    if !data.ends_with(b"</VTKFile>\n") {
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
