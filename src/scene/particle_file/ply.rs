//! Particles in a PLY file, ASCII or binary: the element `vertex` with the properties x, y, z and, if it has them, vx,
//! vy, vz. Other elements and properties are left out.

use std::io::Cursor;

use glam::DVec3;
use ply_rs_bw::{
    parser::{ParseError, Parser, Reader},
    ply::{Encoding, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType},
};

use super::particles::{Particles, possible};

const NAMES: [&str; 6] = ["x", "y", "z", "vx", "vy", "vz"];

/// One vertex, as far as it is wanted.
struct Vertex([f64; 6]);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([0.0; 6])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let place = NAMES.iter().position(|known| *known == name);
        let value = match property {
            Property::Char(value) => value.into(),
            Property::UChar(value) => value.into(),
            Property::Short(value) => value.into(),
            Property::UShort(value) => value.into(),
            Property::Int(value) => value.into(),
            Property::UInt(value) => value.into(),
            Property::Float(value) => value.into(),
            Property::Double(value) => value,
            _ => return PropertyAccessResult::Ignored,
        };
        if let Some(place) = place {
            self.0[place] = value;
        }
        PropertyAccessResult::Ignored
    }
}

fn bytes_of(kind: &PropertyType) -> usize {
    let scalar = match kind {
        PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => scalar,
    };
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Particles, String> {
    let wrong = |error: ParseError| {
        let message = error.to_string();
        let message = message
            .strip_prefix("Line ")
            .map_or_else(|| message.clone(), |rest| format!("line {rest}"));
        format!(
            "{}; write it again as PLY",
            message.replace(['\n', '\t'], " ")
        )
    };
    let parser = Parser::<Vertex>::new();
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = parser.read_header(&mut reader).map_err(wrong)?;
    for (name, element) in &header.elements {
        let kinds = element.properties.values();
        let row: usize = match header.encoding {
            // A digit and what separates it from the next.
            Encoding::Ascii => (2 * element.properties.len()).saturating_sub(1),
            _ => kinds.map(|property| bytes_of(&property.data_type)).sum(),
        };
        possible(element.count, bytes.len(), row.max(1))?;
        let rows = parser.read_payload_for_element(&mut reader, element, &header);
        let rows = rows.map_err(wrong)?;
        if name != "vertex" {
            continue;
        }
        let has = |name: &str| element.properties.contains_key(name);
        if let Some(missing) = NAMES[..3].iter().find(|name| !has(name)) {
            return Err(format!(
                "its element `vertex` has no property `{missing}`; a particle needs x, y and z"
            ));
        }
        let moves = NAMES[3..].iter().any(|name| has(name));
        let part = |row: &Vertex, first: usize| DVec3::from_slice(&row.0[first..]);
        return Ok(Particles {
            positions: rows.iter().map(|row| part(row, 0)).collect(),
            velocities: moves.then(|| rows.iter().map(|row| part(row, 3)).collect()),
        });
    }
    Err("it has no element `vertex`, whose rows are the particles; name it so".to_owned())
}
