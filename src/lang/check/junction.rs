//! Roads with a name, and which of them lie over the road of a scenario.

use super::block::{Layer, last};
use super::book::Book;
use super::places::TextPlaces;
use super::road::{DeclaredRoad, road, write_cross_section};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::View;
use crate::syntax::ast;
use crate::texts::{FileId, NameDefinition};
use crate::write::{BlockText, constant};
use scenario::{DeclaredOtherRoad, DeclaredPiece, Dimension, Road};

/// Checks a road with a name, whoever uses it.
pub fn check_road(definition: NameDefinition, places: &TextPlaces, report: &mut Vec<Diagnostic>) {
    let found = defined_road(definition, places, &mut Book::default(), report);
    let Some(over) = found.and_then(|found| found.over) else { return };
    let names = &places.files.names(definition.file).roads;
    match names.get(over.under.as_str()) {
        None => report.push(
            Diagnostic::new(Code::UnknownRoad, over.span, format!("there is no road `{}`", over.under))
                .label("not defined in this file or one it uses")
                .suggest(&over.under, names.keys().map(String::as_str)),
        ),
        Some(below) => {
            let below = ast::RoadDefinition::cast(places.files.node(*below));
            if let Some(below) = below.filter(|below| below.block().over().is_some()) {
                let message = format!("road `{}` lies over another itself", below.name().text());
                report.push(
                    Diagnostic::new(Code::BadJunction, over.span, message)
                        .label("not on the ground")
                        .hint("let both lie over the same road"),
                );
            }
        }
    }
}

/// A road with a name. Its mistakes are reported where it is defined, whoever uses it.
pub fn defined_road(
    definition: NameDefinition,
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Option<DeclaredRoad> {
    let node = ast::RoadDefinition::cast(places.files.node(definition))?;
    let name = node.name();
    let (scope, before) = (places.files.scope(definition.file), report.len());
    let found = road(name.text(), name.span(), node.block(), scope, places, written, report);
    for finding in report[before..].iter_mut().filter(|finding| finding.code == Code::UnknownName) {
        let unknown = finding.clone();
        *finding = unknown.hint(format!(
            "road `{}` is the same in every scenario: what a scenario varies or draws is known where the road stands in it, as `road {{ … }}`; or write a road for each value",
            name.text()
        ));
    }
    found
}

/// That a scenario cannot happen on a road that lies over another.
pub fn lies_over_another(name: &str, under: &str, chosen: Span) -> Diagnostic {
    let (which, on) = match name {
        "" => ("this road".to_string(), "side"),
        name => (format!("road `{name}`"), name),
    };
    Diagnostic::new(Code::BadJunction, chosen, format!("{which} lies over `{under}`"))
        .label("not the road below")
        .hint(format!("say `road {under}`, and `on {on}` of the vehicles that drive on `road {on} {{ … }}`"))
}

/// The roads that a scenario's vehicles say that they drive on, but for its own, in the order in which they say so; with whether each
/// vehicle's was found.
pub fn other_roads(
    vehicles: &[(ast::Name, Vec<Layer<ast::VehicleBlock>>)],
    main: Option<&Road>,
    places: &TextPlaces,
    written: &mut Book,
    report: &mut Vec<Diagnostic>,
) -> Vec<DeclaredOtherRoad> {
    let mut found: Vec<DeclaredOtherRoad> = Vec::new();
    let Some(main) = main else { return found };
    for (_, layers) in vehicles {
        let Some(said) = last(layers, ast::VehicleBlock::on) else { continue };
        let (name, span) = (said.node.name().text(), said.node.name().span());
        if (name == main.name && !name.is_empty()) || found.iter().any(|one| one.road.name == name) {
            continue;
        }
        let Some(file) = file_of(span, places) else { continue };
        let names = &places.files.names(file).roads;
        let Some(definition) = names.get(name) else {
            report.push(
                Diagnostic::new(Code::UnknownRoad, span, format!("there is no road `{name}`"))
                    .label("not defined in this file or one it uses")
                    .suggest(name, names.keys().map(String::as_str)),
            );
            continue;
        };
        let Some(DeclaredRoad { road, over, ground, .. }) =
            defined_road(*definition, places, written, report)
        else {
            continue;
        };
        let over = over.filter(|over| over.under == main.name && !main.name.is_empty());
        let Some(over) = over else {
            let (below, hint) = match main.name.as_str() {
                "" => (
                    "the road of this scenario",
                    "give that road a name, `road main { … }`, to lay another over it".into(),
                ),
                below => (below, format!("say in it where it does: `over {below} {{ at: 20 m }}`")),
            };
            report.push(
                Diagnostic::new(Code::WrongRoad, span, format!("road `{name}` does not lie over {below}"))
                    .label("nobody comes from there")
                    .hint(hint),
            );
            continue;
        };
        found.push(DeclaredOtherRoad {
            road,
            pieces: over.pieces,
            ground,
            at: over.at,
            meets: over.meets,
            angle: over.angle,
            origin: over.origin,
        });
    }
    found
}

/// The file in which something stands.
fn file_of(span: Span, places: &TextPlaces) -> Option<FileId> {
    places.files.ids().find(|file| places.files.tree(*file).source == span.source)
}

/// The block that says it, with the name of the road below.
pub fn write_other_road(other: &DeclaredOtherRoad, below: &str, out: &mut BlockText) {
    let DeclaredOtherRoad { road, pieces, ground, at, meets, angle, origin: _ } = other;
    out.open(&format!("road {}", road.name));
    let mut settings = vec![format!("at: {}", constant(at, Dimension::LENGTH))];
    settings.extend(meets.iter().map(|meets| format!("meets: {}", constant(meets, Dimension::LENGTH))));
    settings.push(format!("angle: {}", constant(angle, Dimension::ANGLE)));
    out.line(&format!("over {below} {{ {} }}", settings.join(", ")));
    let pieces: &[DeclaredPiece] = pieces;
    if !pieces.is_empty() {
        super::bend::write_path(pieces, out);
    }
    write_cross_section(road, ground.as_ref(), out);
    out.close();
}
