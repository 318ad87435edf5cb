//! How a road bends as it is declared: pieces of a path whose numbers may still depend on variations.

use serde::{Deserialize, Serialize};

use super::geometry::Piece;
use super::{Expression, Origin};

/// The path that a road follows, and where its crossing is on it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeclaredBend {
    /// In the order in which they are driven; never empty.
    pub pieces: Vec<DeclaredPiece>,
    /// From the beginning of the path to the middle of the crossing, m.
    pub crossing: Expression,
    /// Where the place of the crossing is said.
    pub origin: Origin,
}

/// A statement of a path.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeclaredPiece {
    /// What it says.
    pub kind: PieceKind,
    /// Where it is written.
    pub origin: Origin,
}

/// What a path is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PieceKind {
    /// A line.
    Straight {
        /// m
        length: Expression,
    },
    /// From the curvature at which the piece before it ends.
    Clothoid {
        /// m
        length: Expression,
        /// What it ends at; `None`: straight.
        to: Option<BendRadius>,
    },
    /// A part of a circle.
    Arc {
        /// rad
        angle: Expression,
        /// `None`: that at which the piece before it ends.
        about: Option<BendRadius>,
    },
    /// A clothoid from [`WIDE`], an arc and the clothoid back.
    Turn {
        /// Or to the right.
        is_left: bool,
        /// m
        radius: Expression,
        /// Of each clothoid, rad.
        clothoid: Expression,
        /// rad
        arc: Expression,
    },
}

/// How tightly a piece bends, and to which side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BendRadius {
    /// m
    pub radius: Expression,
    /// Or to the right.
    pub is_left: bool,
}

/// The radius at which the clothoids of a turn begin and end, m: Euro NCAP's.
pub const WIDE: f64 = 1500.0;

impl BendRadius {
    /// 1/m, to the left.
    fn curvature<E>(&self, number: &mut impl FnMut(&Expression) -> Result<f64, E>) -> Result<f64, E> {
        let curvature = 1.0 / number(&self.radius)?;
        Ok(if self.is_left { curvature } else { -curvature })
    }
}

impl PieceKind {
    /// The pieces that it stands for, after one that ends at the curvature `before` (1/m, to the left); `number` gives values.
    ///
    /// # Errors
    /// Those of `number`.
    pub fn pieces<E>(
        &self,
        before: f64,
        mut number: impl FnMut(&Expression) -> Result<f64, E>,
    ) -> Result<Vec<Piece>, E> {
        Ok(match self {
            Self::Straight { length } => vec![Piece::line(number(length)?)],
            Self::Clothoid { length, to } => {
                let end = to.as_ref().map(|to| to.curvature(&mut number)).transpose()?;
                vec![Piece::clothoid(number(length)?, before, end.unwrap_or(0.0))]
            }
            Self::Arc { angle, about } => {
                let curvature = match about {
                    Some(about) => about.curvature(&mut number)?,
                    None => before,
                };
                vec![Piece::arc(1.0 / curvature, number(angle)?)]
            }
            Self::Turn { is_left, radius, clothoid, arc } => {
                let turn = Piece::turn(WIDE, number(radius)?, number(clothoid)?, number(arc)?);
                turn.map(|piece| if *is_left { piece } else { piece.mirrored() }).into()
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(kind: &PieceKind, before: f64) -> Vec<Piece> {
        kind.pieces(before, |value| value.evaluate_number(&Default::default())).unwrap()
    }

    #[test]
    fn each_begins_at_the_curvature_that_it_says_or_that_of_the_one_before() {
        let number = Expression::number;
        let radius = |is_left| Some(BendRadius { radius: number(20.0), is_left });
        let clothoid = |to| PieceKind::Clothoid { length: number(8.0), to };
        assert_eq!(pieces(&clothoid(radius(true)), 0.0), [Piece::clothoid(8.0, 0.0, 0.05)]);
        assert_eq!(pieces(&clothoid(radius(false)), 0.05), [Piece::clothoid(8.0, 0.05, -0.05)]);
        assert_eq!(pieces(&clothoid(None), -0.05), [Piece::clothoid(8.0, -0.05, 0.0)]);
        let arc = |about| PieceKind::Arc { angle: number(1.5), about };
        assert_eq!(pieces(&arc(None), -0.05), [Piece::arc(-20.0, 1.5)]);
        assert_eq!(pieces(&arc(radius(true)), -0.05), [Piece::arc(20.0, 1.5)]);
        let turn = |is_left| PieceKind::Turn {
            is_left,
            radius: number(9.0),
            clothoid: number(0.36),
            arc: number(0.85),
        };
        let right = pieces(&turn(true), 0.0).into_iter().map(Piece::mirrored).collect::<Vec<_>>();
        assert_eq!(pieces(&turn(false), 0.0), right);
        assert!(right[1].from < 0.0);
    }
}
