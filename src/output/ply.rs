//! Stanford PLY, binary little endian: one element `vertex` per particle, with the properties in [`FIELDS`].

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use super::atomic::write_atomically;
use super::cursor::{block, number, split_header};
use super::fields::{self, FIELDS};
use super::{Frame, OutputError};

const MAGIC: &str = "ply\nformat binary_little_endian 1.0\n";
const HEADER_END: &str = "\nend_header\n";

pub(super) fn write(frame: &Frame, path: &Path) -> Result<(), OutputError> {
    let rows = fields::rows(frame)?;
    write_atomically(path, |out| {
        out.write_all(header(frame, rows).as_bytes())?;
        let mut bytes = Vec::new();
        for row in 0..rows {
            bytes.clear();
            for field in &FIELDS {
                (field.column)(frame).push_row(row, &mut bytes);
            }
            out.write_all(&bytes)?;
        }
        Ok(())
    })
}

fn header(frame: &Frame, rows: usize) -> String {
    let mut header = MAGIC.to_owned();
    // Writing to a String cannot fail.
    let _ = writeln!(header, "comment time_s {}", frame.time);
    let _ = writeln!(header, "comment step {}", frame.step);
    for field in &FIELDS {
        let _ = writeln!(
            header,
            "comment {} [{}]: {}",
            field.name, field.unit, field.sentence
        );
    }
    let _ = write!(header, "element vertex {rows}");
    for field in &FIELDS {
        let kind = (field.column)(frame).ply_type();
        for name in field.ply {
            let _ = write!(header, "\nproperty {kind} {name}");
        }
    }
    header.push_str(HEADER_END);
    header
}

pub(super) fn parse(bytes: &[u8]) -> Result<Frame, String> {
    let (header, data) = split_header(bytes, HEADER_END)?;
    if !header.starts_with(MAGIC) {
        return Err("not a binary little endian PLY file".to_owned());
    }
    let value = |name: &str| {
        let mut lines = header.lines();
        lines
            .find_map(|line| line.strip_prefix(name))
            .ok_or_else(|| format!("no line {name:?} in the header"))
    };
    let mut frame = Frame {
        time: number(value("comment time_s ")?, "time_s")?,
        step: number(value("comment step ")?, "step")?,
        ..Frame::default()
    };
    let rows: usize = number(value("element vertex ")?, "element vertex")?;

    // Only our own layout is supported, so comparing the lines is a complete check.
    let properties = header.lines().filter(|line| line.starts_with("property "));
    let expected = FIELDS.iter().flat_map(|field| {
        let kind = (field.column)(&frame).ply_type();
        field
            .ply
            .iter()
            .map(move |name| format!("property {kind} {name}"))
    });
    if !properties.eq(expected) {
        return Err("the properties are not those of a frame".to_owned());
    }

    let row_bytes = FIELDS.iter().map(fields::Field::row_bytes).sum();
    let values = block(data, 0, rows, row_bytes)?;
    let mut start = 0;
    for field in &FIELDS {
        let mut column = (field.column_mut)(&mut frame);
        column.reserve(rows);
        values
            .chunks_exact(row_bytes)
            .for_each(|row| column.push(&row[start..start + field.row_bytes()]));
        start += field.row_bytes();
    }
    Ok(frame)
}
