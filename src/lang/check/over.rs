//! `over main { … }`: which road another lies over, and where.

use super::book::Book;
use super::places::TextPlaces;
use super::road_settings::over as declaration;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{NameScope, Typed};
use scenario::{DeclaredPiece, Expression, Origin};

/// Where a road lies over another.
pub struct SaidOver {
    /// The name of the road below.
    pub under: String,
    /// Where that is said.
    pub span: Span,
    pub at: Expression,
    pub meets: Option<Expression>,
    pub angle: Expression,
    pub origin: Origin,
    /// Of its path; empty without one.
    pub pieces: Vec<DeclaredPiece>,
}

/// What a road says of the road below it, which has this name in [`scenario::Scenario::written`]; `pieces` are those of its path, if it has
/// one that is right.
pub fn over(
    node: ast::LiesOver,
    (block, known_as): (ast::RoadBlock, &str),
    pieces: Option<Option<Vec<DeclaredPiece>>>,
    scope: &NameScope,
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<SaidOver> {
    let before = report.len();
    refuse_parts(block, report);
    let settings = node.settings();
    let mut given = settings::check(Some(settings), &declaration(), scope, report);
    let mut take = |name: &str| -> Option<Typed> {
        let index = given.iter().position(|(said, _)| said == name)?;
        Some(given.remove(index).1)
    };
    let (at, meets, angle) = (take("at"), take("meets"), take("angle"));
    for (name, typed) in [("at", &at), ("meets", &meets), ("angle", &angle)] {
        written.statement(known_as, name, typed.as_ref(), places);
    }
    let says = |name: &str| settings.has_bad() || settings.each().any(|one| one.name().text() == name);
    let mut lacks = |span: Span, message: &str, label: &str, hint: &str| {
        report.push(Diagnostic::new(Code::MissingStatement, span, message).label(label).hint(hint));
    };
    if at.is_none() && !says("at") {
        let hint = "say how far along that road from the middle of its first crossing, on a `path` from its beginning: `at: 20 m`";
        lacks(node.span(), "nobody says where the two roads meet", "has no `at`", hint);
    }
    match (&pieces, &meets) {
        (Some(_), None) if !says("meets") => {
            let hint = "say how far behind the beginning of its own path: `meets: 60 m`";
            lacks(
                node.span(),
                "nobody says where on its path the road meets the other",
                "has no `meets`",
                hint,
            );
        }
        (None, Some(meets)) => {
            let hint = "leave out `meets`, since a straight road has no beginning, or give it a `path`";
            lacks(
                meets.span,
                "this road has no `path` on which the junction could have a place",
                "from the beginning of what?",
                hint,
            );
        }
        _ => {}
    }
    let right_angle = || Expression::number(std::f64::consts::FRAC_PI_2);
    (report.len() == before).then_some(())?;
    Some(SaidOver {
        under: node.name().text().to_string(),
        span: node.name().span(),
        at: at?.expression,
        meets: meets.map(|typed| typed.expression),
        angle: angle.map_or_else(right_angle, |typed| typed.expression),
        origin: places.origin(node.span()),
        pieces: match pieces {
            Some(pieces) => pieces?,
            None => Vec::new(),
        },
    })
}

/// People walk on the road below, and what stands anywhere stands beside that.
fn refuse_parts(block: ast::RoadBlock, report: &mut Vec<Diagnostic>) {
    let mut refuse = |span: Span, what: &str, hint: &str| {
        report.push(
            Diagnostic::new(Code::BadJunction, span, format!("a road that lies over another has no {what}"))
                .label("not on this road")
                .hint(hint),
        );
    };
    let crossings = block.crossing().map(|node| node.span());
    for span in crossings.into_iter().chain(block.other_crossings().map(|node| node.span())) {
        refuse(span, "crossings", "people cross the road below: say the crossing there");
    }
    for node in block.obstacles() {
        refuse(node.span(), "boxes", "say it of the road below, with its place along that and across it");
    }
    for node in block.medians().filter(|median| median.is_refuge()) {
        refuse(node.span(), "refuges", "nobody walks there: leave `with refuge` out");
    }
}
