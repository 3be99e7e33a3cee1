//! A text that is put together from files, and where each of its bytes comes from.

use std::ops::Range;

/// A text and its origins.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Mapped {
    pub(super) text: String,
    pieces: Vec<Piece>,
}

/// A part of the text that one file has, or that stands for something in it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    /// Where it begins.
    start: usize,
    file: usize,
    /// Where it begins in the file.
    byte: usize,
    /// Whether its bytes are those of the file; all are at `byte` otherwise.
    is_copy: bool,
}

impl Mapped {
    /// The text of a file.
    pub(super) fn of_file(text: &str, file: usize) -> Self {
        Self {
            text: text.to_owned(),
            pieces: vec![Piece {
                start: 0,
                file,
                byte: 0,
                is_copy: true,
            }],
        }
    }

    /// The file and the byte in it that a byte of the text comes from.
    pub(super) fn origin(&self, byte: usize) -> (usize, usize) {
        match self.piece(byte) {
            Some(piece) if piece.is_copy => (piece.file, piece.byte + byte - piece.start),
            Some(piece) => (piece.file, piece.byte),
            None => (0, 0),
        }
    }

    fn piece(&self, byte: usize) -> Option<&Piece> {
        let after = self.pieces.partition_point(|piece| piece.start <= byte);
        self.pieces.get(after.checked_sub(1)?)
    }

    /// Appends a part of another text, with its origins.
    pub(super) fn copy(&mut self, other: &Self, range: Range<usize>) {
        if range.is_empty() {
            return;
        }
        let start = self.text.len();
        self.text.push_str(&other.text[range.clone()]);
        let (file, byte) = other.origin(range.start);
        let is_copy = other.piece(range.start).is_none_or(|piece| piece.is_copy);
        self.pieces.push(Piece {
            start,
            file,
            byte,
            is_copy,
        });
        let inside = |piece: &&Piece| piece.start > range.start && piece.start < range.end;
        self.pieces
            .extend(other.pieces.iter().filter(inside).map(|piece| Piece {
                start: start + piece.start - range.start,
                ..*piece
            }));
    }

    /// Appends another text.
    pub(super) fn append(&mut self, other: &Self) {
        self.copy(other, 0..other.text.len());
    }

    /// Appends a text that stands for something at a place of a file.
    pub(super) fn glue(&mut self, text: &str, (file, byte): (usize, usize)) {
        self.pieces.push(Piece {
            start: self.text.len(),
            file,
            byte,
            is_copy: false,
        });
        self.text.push_str(text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_knows_where_it_comes_from() {
        let (a, b) = (Mapped::of_file("abcdef", 0), Mapped::of_file("123", 1));
        let mut inner = Mapped::default();
        inner.copy(&a, 1..3);
        inner.glue(", ", (0, 2));
        inner.append(&b);
        let mut outer = Mapped::default();
        outer.glue("(", (2, 9));
        outer.copy(&inner, 1..6);
        outer.copy(&a, 5..6);
        assert_eq!(outer.text, "(c, 12f");
        let origins: Vec<_> = (0..7).map(|byte| outer.origin(byte)).collect();
        assert_eq!(
            origins,
            [(2, 9), (0, 2), (0, 2), (0, 2), (1, 0), (1, 1), (0, 5)]
        );
    }
}
