//! Reads files that may be damaged: every access is checked, errors are sentences.

/// The text up to and including `end`, and the bytes behind it.
pub(super) fn split_header<'a>(bytes: &'a [u8], end: &str) -> Result<(&'a str, &'a [u8]), String> {
    // Our headers have about 2 KB; the bound avoids searching the whole of a wrong file.
    let searched = &bytes[..bytes.len().min(1 << 16)];
    let at = searched
        .windows(end.len())
        .position(|window| window == end.as_bytes())
        .ok_or_else(|| format!("no {:?} in the header", end.trim()))?;
    let (header, rest) = bytes.split_at(at + end.len());
    let header = std::str::from_utf8(header).map_err(|_| "the header is not text".to_owned())?;
    Ok((header, rest))
}

/// `count × size` bytes from `start`, if the file has them.
pub(super) fn block(
    bytes: &[u8],
    start: usize,
    count: usize,
    size: usize,
) -> Result<&[u8], String> {
    count
        .checked_mul(size)
        .and_then(|length| bytes.get(start..start.checked_add(length)?))
        .ok_or_else(|| {
            format!(
                "the file ends too early: {} bytes of data, {count} × {size} from byte {start} announced",
                bytes.len()
            )
        })
}

/// A number from text.
pub(super) fn number<T: std::str::FromStr>(text: &str, what: &str) -> Result<T, String> {
    text.trim()
        .parse()
        .map_err(|_| format!("{what} is {text:?}, not a number"))
}

/// The value of `name="value"` in a tag.
pub(super) fn attribute<'a>(tag: &'a str, name: &str) -> Result<&'a str, String> {
    let missing = || format!("no attribute {name} in <{tag}>");
    let start = tag.find(&format!(" {name}=\"")).ok_or_else(missing)? + name.len() + 3;
    let length = tag[start..].find('"').ok_or_else(missing)?;
    Ok(&tag[start..start + length])
}
