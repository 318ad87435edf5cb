//! `path { … }`: how a road bends, piece by piece.

use super::book::Book;
use super::places::TextPlaces;
use super::road_settings::turn;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{self, NameScope, Typed};
use crate::write::{BlockText, constant};
use scenario::limits::Limit;
use scenario::{BendRadius, DeclaredPiece, Dimension, Expression, PieceKind, limits};

/// What the path of a road is made of that is known as `road`; numbers are noted under `road.path.1.length`.
pub fn pieces(
    (path, road): (ast::RoadPath, &str),
    scope: &NameScope,
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<DeclaredPiece>> {
    let block = path.block();
    let before = report.len();
    let (mut pieces, mut bends) = (Vec::new(), false);
    for (index, node) in block.pieces().enumerate() {
        let mut reader = Reader { scope, places, written, road, index: index + 1 };
        let kind = reader.piece(node, bends, report);
        bends = match node {
            ast::PathPiece::Straight(_) | ast::PathPiece::Turn(_) => false,
            ast::PathPiece::Clothoid(node) => node.radius().is_some(),
            ast::PathPiece::Arc(_) => true,
        };
        pieces.extend(kind.map(|kind| DeclaredPiece { kind, origin: places.origin(node.span()) }));
    }
    if pieces.is_empty() && !block.has_bad() && report.len() == before {
        report.push(
            Diagnostic::new(Code::MissingStatement, path.span(), "this path has no pieces")
                .label("leads nowhere")
                .hint(
                    "say how it runs: `path { straight 60 m; arc 60 deg radius 30 m left }`, or leave it out",
                ),
        );
    }
    (report.len() == before && !block.has_bad()).then_some(pieces)
}

struct Reader<'a> {
    scope: &'a NameScope<'a>,
    places: &'a TextPlaces<'a>,
    written: &'a mut Book,
    /// As its numbers are noted.
    road: &'a str,
    /// Of the piece, counted from 1.
    index: usize,
}

impl Reader<'_> {
    /// `bends`: whether the piece before it ends in a bend.
    fn piece(
        &mut self,
        node: ast::PathPiece,
        bends: bool,
        report: &mut Vec<Diagnostic>,
    ) -> Option<PieceKind> {
        match node {
            ast::PathPiece::Straight(node) => {
                Some(PieceKind::Straight { length: self.length(node.length(), "a straight line", report)? })
            }
            ast::PathPiece::Clothoid(node) => {
                let length = self.length(node.length(), "a clothoid", report);
                let to = match node.radius() {
                    Some(radius) => Some(self.radius(radius, report)?),
                    None => None,
                };
                Some(PieceKind::Clothoid { length: length?, to })
            }
            ast::PathPiece::Arc(node) => {
                let what = "the angle of an arc";
                let angle = self.number(node.angle(), "arc", limits::BEND_ANGLE, what, report);
                let about = match node.radius() {
                    Some(radius) => Some(self.radius(radius, report)?),
                    None if bends => None,
                    None => {
                        report.push(
                            Diagnostic::new(Code::MissingStatement, node.span(), "nobody says the radius of this arc")
                                .label("what is before it ends straight")
                                .hint("say `arc 60 deg radius 30 m left`, or let a `clothoid 20 m to radius 30 m left` lead to it"),
                        );
                        None
                    }
                };
                (about.is_some() || bends).then_some(())?;
                Some(PieceKind::Arc { angle: angle?, about })
            }
            ast::PathPiece::Turn(node) => self.turn(node, report),
        }
    }

    fn turn(&mut self, node: ast::Turn, report: &mut Vec<Diagnostic>) -> Option<PieceKind> {
        let block = node.settings();
        let given = settings::check(Some(block), &turn(), self.scope, report);
        let mut number = |name: &str| -> Option<Expression> {
            let Some((_, typed)) = given.iter().find(|(said, _)| said == name) else {
                let said = block.each().any(|setting| setting.name().text() == name);
                if !block.has_bad() && !said {
                    report.push(
                        Diagnostic::new(
                            Code::MissingStatement,
                            node.span(),
                            format!("this turn has no `{name}`"),
                        )
                        .label(format!("has no `{name}`"))
                        .hint(
                            "a turn reads `turn left { radius: 9 m, clothoid: 20.62 deg, arc: 48.76 deg }`",
                        ),
                    );
                }
                return None;
            };
            self.note(name, typed);
            Some(typed.expression.clone())
        };
        let (radius, clothoid, arc) = (number("radius"), number("clothoid"), number("arc"));
        Some(PieceKind::Turn { is_left: node.is_left(), radius: radius?, clothoid: clothoid?, arc: arc? })
    }

    fn length(
        &mut self,
        node: ast::Expression,
        of: &str,
        report: &mut Vec<Diagnostic>,
    ) -> Option<Expression> {
        self.number(node, "length", limits::PIECE, &format!("the length of {of}"), report)
    }

    fn radius(&mut self, node: ast::BendRadius, report: &mut Vec<Diagnostic>) -> Option<BendRadius> {
        let what = "the radius of a bend";
        let radius = self.number(node.value(), "radius", limits::BEND_RADIUS, what, report)?;
        Some(BendRadius { radius, is_left: node.is_left() })
    }

    fn number(
        &mut self,
        node: ast::Expression,
        name: &str,
        limit: Limit,
        what: &str,
        report: &mut Vec<Diagnostic>,
    ) -> Option<Expression> {
        let typed = value::quantity_within(node, limit, what, self.scope, report)?;
        self.note(name, &typed);
        Some(typed.expression)
    }

    fn note(&mut self, name: &str, typed: &Typed) {
        let path = format!("{}.path", self.road);
        self.written.statement(&path, &format!("{}.{name}", self.index), Some(typed), self.places);
    }
}

/// Of a crossing on a path.
pub fn no_place(node: ast::Crossing) -> Diagnostic {
    Diagnostic::new(Code::MissingStatement, node.span(), "nobody says where on the path the crossing is")
        .label("has no `at`")
        .hint("say how far behind the beginning of the path its middle is: `crossing zebra { at: 130 m }`")
}

/// Of the place of a crossing on a road that has no path.
pub fn no_path(at: Span) -> Diagnostic {
    Diagnostic::new(Code::MissingStatement, at, "this road has no `path` on which the crossing could have a place")
        .label("from the beginning of what?")
        .hint("leave out `at`, since the crossing of a straight road is the origin of all places, or give the road a `path`")
}

/// The statement that says it, whose values are all constants.
pub fn write_path(pieces: &[DeclaredPiece], out: &mut BlockText) {
    let (length, angle) = (
        |value: &Expression| constant(value, Dimension::LENGTH),
        |value: &Expression| constant(value, Dimension::ANGLE),
    );
    let side = |is_left: bool| if is_left { "left" } else { "right" };
    let radius = |about: &BendRadius| format!("radius {} {}", length(&about.radius), side(about.is_left));
    out.open("path");
    for piece in pieces {
        out.line(&match &piece.kind {
            PieceKind::Straight { length: long } => format!("straight {}", length(long)),
            PieceKind::Clothoid { length: long, to } => {
                let to = to.as_ref().map_or_else(|| "straight".to_string(), radius);
                format!("clothoid {} to {to}", length(long))
            }
            PieceKind::Arc { angle: turned, about } => {
                let about = about.as_ref().map(|about| format!(" {}", radius(about))).unwrap_or_default();
                format!("arc {}{about}", angle(turned))
            }
            PieceKind::Turn { is_left, radius, clothoid, arc } => format!(
                "turn {} {{ radius: {}, clothoid: {}, arc: {} }}",
                side(*is_left),
                length(radius),
                angle(clothoid),
                angle(arc)
            ),
        });
    }
    out.close();
}
