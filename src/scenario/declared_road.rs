//! A road that lies over another, as it is declared: what it is like, and where they meet.

use serde::{Deserialize, Serialize};

use super::{DeclaredGround, DeclaredPiece, Expression, Origin, Road};

/// A road that lies over the road of a scenario. The centre lines of their lanes 0 meet at a point, which is the origin of all places on
/// this one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeclaredOtherRoad {
    /// Straight, without crossings and boxes, and with its ground unsaid.
    pub road: Road,
    /// How it bends; empty of one that is straight and endless.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pieces: Vec<DeclaredPiece>,
    /// How steep it is and how well tyres hold on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground: Option<DeclaredGround>,
    /// Where they meet: along the other road from the middle of its first crossing, on a path from its beginning, m.
    pub at: Expression,
    /// How far behind the beginning of its own path that is, m; `None` of one that has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub meets: Option<Expression>,
    /// From the direction of the other road to its own there, to the left, rad.
    pub angle: Expression,
    /// Where that is said.
    pub origin: Origin,
}
