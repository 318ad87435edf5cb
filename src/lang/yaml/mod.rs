//! The YAML form: the same statements under the same words.
//!
//! A YAML file is turned into the text of a scenario file with a map back to where everything came from, so that one
//! grammar and one checker serve both forms and every finding still points into the YAML.

mod document;
mod schema;
mod shape;
mod to_scn;
mod to_yaml;

pub use schema::schema;
pub use to_scn::{Translation, to_scn};
pub use to_yaml::to_yaml;

/// From a place in the translation to the place in the YAML that it was made from.
#[derive(Debug, Clone, Default)]
pub struct Places {
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

impl Places {
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
