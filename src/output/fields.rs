//! The fields of a frame, declared once: this table drives writers, readers and the documentation of the files.

use glam::Vec3;

use super::{Frame, OutputError, error::equal_columns};

/// One field of a frame.
pub struct Field {
    /// Name in the VTK file.
    pub name: &'static str,
    /// SI unit; "-" if it has none.
    pub unit: &'static str,
    /// Description.
    pub sentence: &'static str,
    /// Names of its components in the PLY file, one for a scalar.
    pub ply: &'static [&'static str],
    pub(super) column: fn(&Frame) -> Column<'_>,
    pub(super) column_mut: fn(&mut Frame) -> ColumnMut<'_>,
}

/// All fields of a frame file, in the order of the PLY properties. The first is the position.
pub const FIELDS: [Field; 5] = [
    Field {
        name: "position",
        unit: "m",
        sentence: "position of the particle; the points of the VTK file",
        ply: &["x", "y", "z"],
        column: |frame| Column::Vectors(&frame.positions),
        column_mut: |frame| ColumnMut::Vectors(&mut frame.positions),
    },
    Field {
        name: "velocity",
        unit: "m/s",
        sentence: "velocity of the particle",
        ply: &["vx", "vy", "vz"],
        column: |frame| Column::Vectors(&frame.velocities),
        column_mut: |frame| ColumnMut::Vectors(&mut frame.velocities),
    },
    Field {
        name: "density",
        unit: "kg/m3",
        sentence: "density at the particle, boundary contribution included",
        ply: &["density"],
        column: |frame| Column::Scalars(&frame.densities),
        column_mut: |frame| ColumnMut::Scalars(&mut frame.densities),
    },
    Field {
        name: "pressure",
        unit: "Pa",
        sentence: "pressure at the particle",
        ply: &["pressure"],
        column: |frame| Column::Scalars(&frame.pressures),
        column_mut: |frame| ColumnMut::Scalars(&mut frame.pressures),
    },
    Field {
        name: "id",
        unit: "-",
        sentence: "permanent number of the particle: the same in every frame, whatever its row, and never another \
         particle's",
        ply: &["id"],
        column: |frame| Column::Numbers(&frame.ids),
        column_mut: |frame| ColumnMut::Numbers(&mut frame.ids),
    },
];

/// A column of a frame, with its type.
pub(super) enum Column<'a> {
    Vectors(&'a [Vec3]),
    Scalars(&'a [f32]),
    Numbers(&'a [u32]),
}

/// As [`Column`], to be filled by a reader.
pub(super) enum ColumnMut<'a> {
    Vectors(&'a mut Vec<Vec3>),
    Scalars(&'a mut Vec<f32>),
    Numbers(&'a mut Vec<u32>),
}

impl Column<'_> {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Vectors(rows) => rows.len(),
            Self::Scalars(rows) => rows.len(),
            Self::Numbers(rows) => rows.len(),
        }
    }

    /// Type of a component in a VTK file.
    pub(super) fn vtk_type(&self) -> &'static str {
        match self {
            Self::Vectors(_) | Self::Scalars(_) => "Float32",
            Self::Numbers(_) => "UInt32",
        }
    }

    /// Type of a component in a PLY file.
    pub(super) fn ply_type(&self) -> &'static str {
        match self {
            Self::Vectors(_) | Self::Scalars(_) => "float",
            Self::Numbers(_) => "uint",
        }
    }

    /// Appends one row, little endian.
    pub(super) fn push_row(&self, row: usize, bytes: &mut Vec<u8>) {
        match self {
            Self::Vectors(rows) => {
                for component in rows[row].to_array() {
                    bytes.extend_from_slice(&component.to_le_bytes());
                }
            }
            Self::Scalars(rows) => bytes.extend_from_slice(&rows[row].to_le_bytes()),
            Self::Numbers(rows) => bytes.extend_from_slice(&rows[row].to_le_bytes()),
        }
    }
}

impl ColumnMut<'_> {
    /// Appends one row from its little endian bytes, four per component.
    pub(super) fn push(&mut self, bytes: &[u8]) {
        let word = |component: usize| {
            let mut word = [0; 4];
            word.copy_from_slice(&bytes[component * 4..component * 4 + 4]);
            word
        };
        match self {
            Self::Vectors(rows) => rows.push(Vec3::new(
                f32::from_le_bytes(word(0)),
                f32::from_le_bytes(word(1)),
                f32::from_le_bytes(word(2)),
            )),
            Self::Scalars(rows) => rows.push(f32::from_le_bytes(word(0))),
            Self::Numbers(rows) => rows.push(u32::from_le_bytes(word(0))),
        }
    }

    pub(super) fn reserve(&mut self, rows: usize) {
        match self {
            Self::Vectors(column) => column.reserve(rows),
            Self::Scalars(column) => column.reserve(rows),
            Self::Numbers(column) => column.reserve(rows),
        }
    }
}

impl Field {
    /// Number of components: 3 for a vector, 1 for a scalar.
    pub fn components(&self) -> usize {
        self.ply.len()
    }

    /// Bytes of a row in a file.
    pub(super) fn row_bytes(&self) -> usize {
        4 * self.components()
    }
}

/// Number of particles of a frame; fails if its columns differ in length.
pub(super) fn rows(frame: &Frame) -> Result<usize, OutputError> {
    let expected = frame.positions.len();
    let columns = FIELDS.iter();
    let columns = columns.map(|field| (field.name, (field.column)(frame).len()));
    equal_columns(expected, columns)?;
    // Readers of both formats commonly count in signed 32-bit integers.
    if i32::try_from(expected).is_err() {
        return Err(OutputError::TooManyParticles {
            particles: expected,
        });
    }
    Ok(expected)
}
