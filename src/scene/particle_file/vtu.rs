//! Particles in a VTK XML unstructured grid: its points and, if it has them, the point data `velocity`. Data may be
//! base64, as frames of this program are, raw and appended, or ASCII.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::DVec3;

use super::particles::{Particles, possible};

const DATA: &str = "<AppendedData encoding=\"raw\">";

/// Head and appended data of a file.
struct Parts<'a> {
    head: &'a str,
    data: &'a [u8],
    is_big: bool,
    /// Bytes of the length before each block of data.
    length_bytes: usize,
}

pub(super) fn read(bytes: &[u8]) -> Result<Particles, String> {
    let place = bytes
        .windows(DATA.len())
        .position(|window| window == DATA.as_bytes());
    let (head, data) = bytes.split_at(place.unwrap_or(bytes.len()));
    let head = std::str::from_utf8(head);
    let head = head.map_err(|error| {
        format!(
            "byte {} is not text in UTF-8; write it again as VTU",
            error.valid_up_to()
        )
    })?;
    // The data begin after an underscore.
    let start = data.iter().position(|byte| *byte == b'_');
    let file = tags(head).find(|(tag, _)| tag.starts_with("VTKFile"));
    let of_file = |name: &str| file.and_then(|(tag, _)| attribute(tag, name));
    let parts = Parts {
        head,
        data: start.map_or(&[], |start| &data[start + 1..]),
        is_big: of_file("byte_order") == Some("BigEndian"),
        length_bytes: if of_file("header_type") == Some("UInt64") {
            8
        } else {
            4
        },
    };
    if of_file("compressor").is_some() {
        return Err("its data are compressed; write it without compression".to_owned());
    }
    let mut pieces = tags(head).filter(|(tag, _)| tag.starts_with("Piece "));
    let piece = pieces
        .next()
        .and_then(|(tag, _)| attribute(tag, "NumberOfPoints"));
    let count = piece.and_then(|count| count.parse().ok());
    let count: usize = count.ok_or("it has no <Piece> with a NumberOfPoints; write it as VTU")?;
    if pieces.next().is_some() {
        return Err("it has several pieces; join them to one".to_owned());
    }
    possible(count, bytes.len(), 6)?;
    let points = head.find("<Points").ok_or("it has no <Points>")?;
    let points = tags(&head[points..]).find(|(tag, _)| tag.starts_with("DataArray"));
    let points = points.ok_or("it has no array in <Points>")?;
    let velocity = tags(head).find(|(tag, _)| {
        tag.starts_with("DataArray") && attribute(tag, "Name") == Some("velocity")
    });
    Ok(Particles {
        positions: parts.vectors(points, count, "points")?,
        velocities: velocity
            .map(|velocity| parts.vectors(velocity, count, "velocity"))
            .transpose()?,
    })
}

impl Parts<'_> {
    fn vectors(
        &self,
        (tag, text): (&str, &str),
        count: usize,
        what: &str,
    ) -> Result<Vec<DVec3>, String> {
        if attribute(tag, "NumberOfComponents") != Some("3") {
            return Err(format!("its {what} must have 3 components"));
        }
        let numbers = match attribute(tag, "format").unwrap_or("ascii") {
            "ascii" => self.numbers_of_text(text, what)?,
            "binary" => {
                let bytes = STANDARD.decode(text.trim());
                let bytes = bytes.map_err(|error| format!("its {what} are not base64: {error}"))?;
                self.numbers_of_data(tag, &bytes, 0, (3 * count, what))?
            }
            "appended" => {
                let offset = attribute(tag, "offset").and_then(|offset| offset.parse().ok());
                let offset = offset.ok_or_else(|| format!("its {what} have no offset"))?;
                self.numbers_of_data(tag, self.data, offset, (3 * count, what))?
            }
            other => {
                return Err(format!(
                    "its {what} have the format `{other}`; write them `ascii` or `binary`, or `appended` and raw"
                ));
            }
        };
        if numbers.len() != 3 * count {
            return Err(format!(
                "its {what} are {} numbers and should be {} for {count} particles",
                numbers.len(),
                3 * count
            ));
        }
        let vectors = numbers.as_chunks::<3>().0.iter();
        Ok(vectors.map(|vector| DVec3::from_array(*vector)).collect())
    }

    fn numbers_of_text(&self, text: &str, what: &str) -> Result<Vec<f64>, String> {
        let line = |word: &str| {
            let place = word.as_ptr() as usize - self.head.as_ptr() as usize;
            1 + self.head[..place].matches('\n').count()
        };
        let number = |word: &str| {
            let parsed = word.parse();
            parsed.map_err(|_| format!("line {}: `{word}` in {what} is not a number", line(word)))
        };
        text.split_whitespace().map(number).collect()
    }

    fn numbers_of_data(
        &self,
        tag: &str,
        data: &[u8],
        offset: usize,
        (count, what): (usize, &str),
    ) -> Result<Vec<f64>, String> {
        let size = match attribute(tag, "type") {
            Some("Float32") => 4,
            Some("Float64") => 8,
            other => {
                return Err(format!(
                    "its {what} are of type {}; write Float32 or Float64",
                    other.unwrap_or("nothing")
                ));
            }
        };
        let start = offset.saturating_add(self.length_bytes);
        let end = start.saturating_add(count.saturating_mul(size));
        let block = data
            .get(start..end)
            .ok_or_else(|| format!("the file ends within its {what}; write it again"))?;
        let number = |bytes: &[u8]| {
            let mut bytes = bytes.to_vec();
            if self.is_big {
                bytes.reverse();
            }
            match bytes[..] {
                [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
                [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
                _ => f64::NAN,
            }
        };
        Ok(block.chunks_exact(size).map(number).collect())
    }
}

/// The text between each `<` and `>`, and the text after it.
fn tags(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.split('<').filter_map(|part| part.split_once('>'))
}

fn attribute<'t>(tag: &'t str, name: &str) -> Option<&'t str> {
    let key = format!(" {name}=\"");
    let start = tag.find(&key)? + key.len();
    let length = tag[start..].find('"')?;
    Some(&tag[start..start + length])
}
