//! Shared by the text formats: decoding, lines, coordinates.

use glam::DVec3;

/// Decodes the bytes of a file: UTF-8, or UTF-16 if a byte order mark says so. Invalid bytes become �, which both
/// formats accept only in comments and names.
pub(super) fn text_of(bytes: &[u8]) -> String {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = (bytes.as_chunks::<2>().0.iter().copied())
            .map(unit)
            .collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        _ => String::from_utf8_lossy(bytes).into_owned(),
    }
}

/// Lines of a text with their numbers from 1. A line may end with `\n`, `\r\n` or `\r`.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut rest = Some(text);
    std::iter::from_fn(move || {
        let text = rest?;
        let Some(end) = text.find(['\n', '\r']) else {
            rest = None;
            return Some(text);
        };
        let ending = if text[end..].starts_with("\r\n") {
            2
        } else {
            1
        };
        rest = Some(&text[end + ending..]);
        Some(&text[..end])
    })
    .enumerate()
    .map(|(index, line)| (index + 1, line))
}

/// Three coordinates from the first three words of a line; further words are ignored.
pub(super) fn point<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<DVec3> {
    let mut coordinate = || words.next()?.parse::<f64>().ok();
    Some(DVec3::new(coordinate()?, coordinate()?, coordinate()?))
}
