//! VTK XML unstructured grids, version 1.0: points with cells and data.
//!
//! Option 1: raw appended data, which is a quarter smaller. Option 2: base64 inline. We use 2, because it is valid XML
//! and every reader that we know takes it: ParaView, the vtk library, meshio, and splashsurf, which refuses raw data.

use std::io::{Result, Write};

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use glam::Vec3;

/// VTK's numbers of the cell types "vertex" and "triangle".
const VERTEX: u8 = 1;
const TRIANGLE: u8 = 5;
/// Bytes that are collected before they are encoded.
const CHUNK: usize = 1 << 16;

/// Appends a row, little endian.
pub(super) type PushRow<'a> = Box<dyn Fn(usize, &mut Vec<u8>) + 'a>;

/// One array of a grid.
pub(super) struct Array<'a> {
    pub(super) name: &'a str,
    /// VTK's name of the type of a component.
    pub(super) kind: &'static str,
    pub(super) components: usize,
    pub(super) row_bytes: usize,
    pub(super) push_row: PushRow<'a>,
}

/// The cells of a grid.
pub(super) enum Cells<'a> {
    /// One vertex per point: ParaView shows points without cells only after a filter.
    Vertices,
    /// Triangles of points, counter-clockwise from outside.
    Triangles(&'a [[u32; 3]]),
}

/// A grid to be written.
pub(super) struct Grid<'a> {
    /// \[s]
    pub(super) time: f64,
    pub(super) step: u64,
    /// Number of points: at most 2³¹ − 1.
    pub(super) rows: usize,
    pub(super) points: Array<'a>,
    pub(super) cells: Cells<'a>,
    /// Data of the points, and the attributes that name the ones to be shown first.
    pub(super) data: Vec<Array<'a>>,
    pub(super) shown_first: &'static str,
}

impl Grid<'_> {
    pub(super) fn write(&self, out: &mut impl Write) -> Result<()> {
        let cells = match self.cells {
            Cells::Vertices => self.rows,
            Cells::Triangles(triangles) => triangles.len(),
        };
        write!(
            out,
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <UnstructuredGrid>\n\
             <FieldData>\n\
             <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time}</DataArray>\n\
             <DataArray type=\"UInt64\" Name=\"step\" NumberOfTuples=\"1\" format=\"ascii\">{step}</DataArray>\n\
             </FieldData>\n\
             <Piece NumberOfPoints=\"{rows}\" NumberOfCells=\"{cells}\">\n\
             <Points>\n",
            time = self.time,
            step = self.step,
            rows = self.rows,
        )?;
        self.points.write(self.rows, out)?;
        out.write_all(b"</Points>\n<Cells>\n")?;
        self.write_cells(cells, out)?;
        write!(out, "</Cells>\n<PointData{}>\n", self.shown_first)?;
        for array in &self.data {
            array.write(self.rows, out)?;
        }
        out.write_all(b"</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")
    }

    fn write_cells(&self, cells: usize, out: &mut impl Write) -> Result<()> {
        let (corners, kind) = match self.cells {
            Cells::Vertices => (1, VERTEX),
            Cells::Triangles(_) => (3, TRIANGLE),
        };
        let corner = |i: usize| match self.cells {
            Cells::Vertices => i as u32,
            Cells::Triangles(triangles) => triangles[i / 3][i % 3],
        };
        numbers("connectivity", Box::new(corner)).write(corners * cells, out)?;
        // A cell ends before the offset.
        let end = move |i: usize| (corners * (i + 1)) as u32;
        numbers("offsets", Box::new(end)).write(cells, out)?;
        let kinds = Array {
            name: "types",
            kind: "UInt8",
            components: 1,
            row_bytes: 1,
            push_row: Box::new(move |_, bytes| bytes.push(kind)),
        };
        kinds.write(cells, out)
    }
}

fn numbers<'a>(name: &'a str, of: Box<dyn Fn(usize) -> u32 + 'a>) -> Array<'a> {
    Array {
        name,
        kind: "Int32",
        components: 1,
        row_bytes: 4,
        push_row: Box::new(move |i, bytes| bytes.extend_from_slice(&of(i).to_le_bytes())),
    }
}

impl Array<'_> {
    fn write(&self, rows: usize, out: &mut impl Write) -> Result<()> {
        // meshio reads a scalar with an explicit component count of 1 as a matrix of one column.
        let components = match self.components {
            1 => String::new(),
            more => format!(" NumberOfComponents=\"{more}\""),
        };
        write!(
            out,
            "<DataArray type=\"{}\" Name=\"{}\"{components} format=\"binary\">",
            self.kind, self.name
        )?;
        // The length in bytes and the data are one base64 text.
        let mut encoder = EncoderWriter::new(&mut *out, &STANDARD);
        encoder.write_all(&((rows * self.row_bytes) as u64).to_le_bytes())?;
        let mut bytes = Vec::with_capacity(CHUNK + self.row_bytes);
        for row in 0..rows {
            (self.push_row)(row, &mut bytes);
            if bytes.len() >= CHUNK {
                encoder.write_all(&bytes)?;
                bytes.clear();
            }
        }
        encoder.write_all(&bytes)?;
        encoder.finish()?;
        drop(encoder);
        out.write_all(b"</DataArray>\n")
    }
}

/// A vector, little endian.
pub(in crate::output) fn bytes(vector: Vec3) -> [u8; 12] {
    bytemuck::cast(vector.to_array().map(f32::to_le_bytes))
}

/// An array of vectors.
pub(in crate::output) fn vectors<'a>(name: &'a str, rows: &'a [Vec3]) -> Array<'a> {
    Array {
        name,
        kind: "Float32",
        components: 3,
        row_bytes: 12,
        push_row: Box::new(|row, out| out.extend_from_slice(&bytes(rows[row]))),
    }
}
