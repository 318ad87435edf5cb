//! What is wrong with a line or with a course beside it, with its numbers and a cure.

use thiserror::Error;

/// Why there is no such line or course. Pieces are counted from 1.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum GeometryError {
    /// A line of no pieces.
    #[error("a line needs at least one piece")]
    Empty,
    /// A piece without length.
    #[error("piece {piece} is {length} m long; its length must be above 0 m")]
    Length {
        /// Counted from 1.
        piece: usize,
        /// m
        length: f64,
    },
    /// A number that is none, or that no road has.
    #[error("piece {piece} has a number that is not finite")]
    NotFinite {
        /// Counted from 1.
        piece: usize,
    },
    /// A course whose distance from the line comes too close to the radius of a piece.
    #[error(
        "piece {piece} has a radius of {radius:.3} m, too tight for a lane whose centre is {} m beside the line: \
         the radius must be above {least:.3} m, or the lanes narrower",
        offset.abs()
    )]
    TooTight {
        /// Counted from 1.
        piece: usize,
        /// The smallest of the piece, m.
        radius: f64,
        /// Of the course from the line, left positive, m.
        offset: f64,
        /// That it must be above for this offset, m.
        least: f64,
    },
}
