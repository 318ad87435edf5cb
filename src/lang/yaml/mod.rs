//! The YAML form: the same statements under the same words.
//!
//! A YAML file is turned into the text of a scenario file with a map back to where everything came from, so that one
//! grammar and one checker serve both forms and every finding still points into the YAML.

mod document;
mod schema;
mod to_scn;
mod to_yaml;

use std::ops::Range;

pub use schema::schema;
pub use to_scn::{Translation, to_scn};
pub use to_yaml::to_yaml;

/// From a place in the translation to the place in the YAML that it was made from.
#[derive(Debug, Clone, Default)]
pub struct TranslatedPlaces {
    /// In the order of the translation.
    pieces: Vec<Piece>,
}

#[derive(Debug, Clone, Copy)]
struct Piece {
    /// Byte range in the translation.
    start: usize,
    end: usize,
    /// Byte range in the YAML.
    from: usize,
    to: usize,
    /// Whether the bytes are the same ones.
    verbatim: bool,
}

impl TranslatedPlaces {
    /// The places of the translation once bytes of it were replaced: ranges in order, each with how many bytes are there
    /// instead, which came from where the old ones did.
    pub fn edited(&self, edits: &[(Range<usize>, usize)]) -> Self {
        let moved = |at: usize| {
            let before = edits.iter().take_while(|(range, _)| range.end <= at);
            before.fold(at, |at, (range, length)| at + length - range.len())
        };
        let mut pieces = Vec::new();
        for piece in &self.pieces {
            let mut part = |start: usize, end: usize| {
                if start < end {
                    let offset = if piece.verbatim { start - piece.start } else { 0 };
                    let to = if piece.verbatim { piece.from + end - piece.start } else { piece.to };
                    let start = moved(start);
                    pieces.push(Piece { start, end: moved(end), from: piece.from + offset, to, ..*piece });
                }
            };
            let mut start = piece.start;
            let inside =
                |(range, _): &&(Range<usize>, usize)| range.end >= piece.start && range.start < piece.end;
            for (range, _) in edits.iter().filter(inside) {
                part(start, range.start);
                start = start.max(range.end);
            }
            part(start, piece.end);
        }
        let mut shift = 0isize;
        for (range, length) in edits {
            let (from, to) = self.original(range.start, range.end.max(range.start + 1));
            let start = range.start.saturating_add_signed(shift);
            pieces.push(Piece { start, end: start + length, from, to, verbatim: false });
            shift += *length as isize - range.len() as isize;
        }
        pieces.sort_by_key(|piece| (piece.start, piece.end));
        Self { pieces }
    }

    /// The byte range of the YAML that `start..end` of the translation came from.
    pub fn original(&self, start: usize, end: usize) -> (usize, usize) {
        let from = self.place(start);
        let to = if end > start { self.place(end - 1) } else { from };
        let begin = from.0;
        (begin, if end > start { to.1.max(begin) } else { begin })
    }

    /// The original of one byte; made-up bytes belong to what came before.
    fn place(&self, at: usize) -> (usize, usize) {
        let index = self.pieces.partition_point(|piece| piece.start <= at);
        let Some(piece) = index.checked_sub(1).map(|index| self.pieces[index]) else { return (0, 0) };
        if piece.verbatim && at < piece.end {
            let from = piece.from + (at - piece.start);
            (from, from + 1)
        } else {
            (piece.from, piece.to)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_follow_what_is_replaced() {
        let piece = |start, end, from, to, verbatim| Piece { start, end, from, to, verbatim };
        let places =
            TranslatedPlaces { pieces: vec![piece(0, 4, 100, 101, false), piece(4, 10, 200, 206, true)] };
        // Bytes 5..7 become five others, and three come in at 8.
        let edited = places.edited(&[(5..7, 5), (8..8, 3)]);
        let at = |at| edited.original(at, at + 1);
        assert_eq!([at(0), at(3)], [(100, 101); 2]);
        assert_eq!(at(4), (200, 201));
        assert_eq!([at(5), at(9)], [(201, 203); 2]);
        assert_eq!(at(10), (203, 204));
        assert_eq!([at(11), at(13)], [(204, 205); 2]);
        assert_eq!([at(14), at(15)], [(204, 205), (205, 206)]);
    }
}
