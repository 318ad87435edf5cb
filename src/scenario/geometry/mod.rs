//! Curves in the plane that roads follow: lines, arcs and clothoids end to end, and the courses beside them.
//!
//! A [`Piece`] is a length and the curvature at both ends, between which that changes evenly. A [`ReferenceLine`] is pieces
//! end to end, a [`CurvedPath`] what lies at a constant distance beside one and is driven in one direction. Lengths are
//! metres, angles radians, positive to the left; all of it by `libm`, so that every machine has the same bits.

mod curved_path;
mod geometry_error;
mod piece;
mod reference_line;

pub use curved_path::{CurvedPath, PathProjection};
pub use geometry_error::GeometryError;
pub use piece::{Piece, Pose};
pub use reference_line::{LineProjection, ReferenceLine};
