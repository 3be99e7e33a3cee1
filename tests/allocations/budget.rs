//! A budget of memory for readers, and files that promise more than they hold.

use std::fs;
use std::path::{Path, PathBuf};

use stats_alloc::Region;

use crate::ALLOCATOR;

/// Numbers that a file may promise: of records, of bytes, of repetitions.
const PROMISES: [&str; 4] = [
    "1000000000000",
    "4294967295",
    "18446744073709551615",
    "1e12",
];

/// Most numbers of a file that are replaced, one after the other.
const MOST_NUMBERS: usize = 60;

/// Memory that a reader may take: bytes for every byte of its files, and bytes in addition.
#[derive(Clone, Copy)]
struct Budget {
    per_byte: usize,
    more: usize,
}

/// Readings of one kind of files, and those that took too much.
pub(super) struct Readings {
    kind: &'static str,
    budget: Budget,
    count: usize,
    faults: Vec<String>,
}

impl Readings {
    pub(super) fn new(kind: &'static str, per_byte: usize, more: usize) -> Self {
        Self {
            kind,
            budget: Budget { per_byte, more },
            count: 0,
            faults: Vec::new(),
        }
    }

    /// Reads something that files of this length hold \[bytes].
    pub(super) fn read<T>(&mut self, name: &str, length: usize, read: impl FnOnce() -> T) {
        let region = Region::new(ALLOCATOR);
        let result = read();
        let taken = region.change().bytes_allocated;
        drop(result);
        let most = self.budget.per_byte * length + self.budget.more;
        self.count += 1;
        if taken > most {
            self.faults
                .push(format!("{name}: {taken} bytes for a file of {length}"));
        }
    }

    /// Reads a file, and what may be made of it.
    pub(super) fn all(&mut self, name: &str, bytes: &[u8], mut read: impl FnMut(&[u8])) {
        for (how, spoilt) in spoilt(bytes) {
            self.read(&format!("{name}, {how}"), spoilt.len(), || read(&spoilt));
        }
    }

    #[track_caller]
    pub(super) fn end(self) {
        assert!(self.count > 1, "{}", self.kind);
        let (first, number) = (self.faults.iter().take(20), self.faults.len());
        let first: Vec<&String> = first.collect();
        assert!(
            number == 0,
            "{}: {number} took too much: {first:#?}",
            self.kind
        );
    }
}

/// A file as it is, cut short, and with each of its first numbers replaced.
pub(super) fn spoilt(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let mut all = vec![("whole".to_owned(), bytes.to_vec())];
    all.extend((1..8).map(|k| (format!("{k}/8"), bytes[..k * bytes.len() / 8].to_vec())));
    let mut numbers = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let length = bytes[at..].iter().take_while(|byte| byte.is_ascii_digit());
        let length = length.count();
        if length > 0 {
            numbers.push(at..at + length);
        }
        at += length.max(1);
    }
    let step = numbers.len().div_ceil(MOST_NUMBERS).max(1);
    // Headers come first: their numbers are all tried.
    let tried = numbers
        .iter()
        .take(20)
        .chain(numbers.iter().skip(20).step_by(step));
    for range in tried {
        for promise in PROMISES {
            let parts = [
                &bytes[..range.start],
                promise.as_bytes(),
                &bytes[range.end..],
            ];
            all.push((format!("{promise} at byte {}", range.start), parts.concat()));
        }
    }
    all
}

/// The files in a folder of the repository, by name.
pub(super) fn files(folder: &str) -> Vec<(String, Vec<u8>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut paths: Vec<PathBuf> = fs::read_dir(&root)
        .unwrap_or_else(|error| panic!("{}: {error}", root.display()))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.is_file())
        .collect();
    paths.sort();
    let name = |path: &Path| path.file_name().unwrap_or_default().display().to_string();
    let read = |path: &PathBuf| (name(path), fs::read(path).expect("a file"));
    paths.iter().map(read).collect()
}

pub(super) fn text(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    String::from_utf8_lossy(bytes)
}
