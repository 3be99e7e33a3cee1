//! The file format: named parts, with a length and a checksum.
//!
//! ```text
//! "OVFLCHK\n"   8 bytes
//! version       u32
//! length        u64   of the whole file
//! parts         each: u32 and name, u64 and bytes
//! checksum      u32   CRC-32 of all before it
//! ```
//!
//! Numbers are little-endian. The structure around the parts is the same in every version.

use std::io::{Read, Write};

use super::error::{CheckpointError, FORMAT_VERSION};

const MAGIC: &[u8; 8] = b"OVFLCHK\n";
/// Bytes before the parts, and after them.
const HEAD: usize = 8 + 4 + 8;
const TAIL: usize = 4;

/// The part that holds the scene.
pub(super) const SCENE: &str = "scene";
/// Prefix of the names of a host's own parts.
const ATTACHED: &str = "host:";

/// A checkpoint in memory.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Checkpoint {
    parts: Vec<(String, Vec<u8>)>,
}

impl Checkpoint {
    /// Reads a checkpoint. Refuses a file that is truncated, altered, of another kind or of a newer version.
    pub fn read(reader: &mut impl Read) -> Result<Self, CheckpointError> {
        let mut bytes = Vec::new();
        (&mut *reader).take(HEAD as u64).read_to_end(&mut bytes)?;
        if !MAGIC.starts_with(&bytes[..bytes.len().min(MAGIC.len())]) || bytes.is_empty() {
            return Err(CheckpointError::Foreign);
        }
        let mut head = Parts(bytes.get(MAGIC.len()..).unwrap_or_default());
        let (Some(version), Some(expected)) = (head.u32(), head.u64()) else {
            return Err(CheckpointError::Truncated {
                expected: (HEAD + TAIL) as u64,
                found: bytes.len() as u64,
            });
        };
        // Reading one byte more detects trailing data. Memory is allocated only for bytes that exist.
        let rest = expected.saturating_sub(HEAD as u64).saturating_add(1);
        reader.take(rest).read_to_end(&mut bytes)?;
        let found = bytes.len() as u64;
        if found < expected {
            return Err(CheckpointError::Truncated { expected, found });
        }
        let (content, tail) = bytes.split_at(bytes.len().saturating_sub(TAIL).max(HEAD));
        let [expected_sum, found_sum] = [
            Parts(tail).u32().unwrap_or_default(),
            crc32fast::hash(content),
        ];
        if found > expected || expected_sum != found_sum {
            return Err(CheckpointError::Altered {
                expected: expected_sum,
                found: found_sum,
            });
        }
        if version != FORMAT_VERSION {
            return Err(CheckpointError::Version { found: version });
        }
        let mut rest = Parts(&content[HEAD..]);
        let mut parts = Vec::new();
        while !rest.0.is_empty() {
            let part = rest.part();
            parts.push(part.ok_or_else(|| {
                CheckpointError::malformed("list of parts", "a part is longer than the file")
            })?);
        }
        Ok(Self { parts })
    }

    /// Writes the checkpoint.
    pub fn write(&self, writer: &mut impl Write) -> Result<(), CheckpointError> {
        Ok(writer.write_all(&self.to_bytes())?)
    }

    /// The bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let of_part = |(name, bytes): &(String, Vec<u8>)| 4 + name.len() + 8 + bytes.len();
        let length = HEAD + self.parts.iter().map(of_part).sum::<usize>() + TAIL;
        let mut out = Vec::with_capacity(length);
        out.extend(MAGIC);
        out.extend(FORMAT_VERSION.to_le_bytes());
        out.extend((length as u64).to_le_bytes());
        for (name, bytes) in &self.parts {
            out.extend((name.len() as u32).to_le_bytes());
            out.extend(name.as_bytes());
            out.extend((bytes.len() as u64).to_le_bytes());
            out.extend(bytes);
        }
        out.extend(crc32fast::hash(&out).to_le_bytes());
        out
    }

    /// Adds a part of the host, which can be retrieved by its name.
    pub fn attach(&mut self, name: &str, bytes: Vec<u8>) {
        self.put(format!("{ATTACHED}{name}"), bytes);
    }

    /// A part of the host.
    pub fn attached(&self, name: &str) -> Option<&[u8]> {
        self.find(&format!("{ATTACHED}{name}"))
    }

    pub(super) fn put(&mut self, name: String, bytes: Vec<u8>) {
        self.parts.retain(|part| part.0 != name);
        self.parts.push((name, bytes));
    }

    pub(super) fn find(&self, name: &str) -> Option<&[u8]> {
        let part = self.parts.iter().find(|part| part.0 == name)?;
        Some(&part.1)
    }

    /// Names of the engine's parts.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        let names = self.parts.iter().map(|part| part.0.as_str());
        names.filter(|name| !name.starts_with(ATTACHED))
    }
}

/// Bytes that are consumed from the front.
struct Parts<'a>(&'a [u8]);

impl<'a> Parts<'a> {
    fn take(&mut self, count: u64) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(usize::try_from(count).ok()?)?;
        self.0 = rest;
        Some(taken)
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }

    fn part(&mut self) -> Option<(String, Vec<u8>)> {
        let length = self.u32()?;
        let name = str::from_utf8(self.take(length.into())?).ok()?.to_owned();
        let length = self.u64()?;
        Some((name, self.take(length)?.to_vec()))
    }
}
