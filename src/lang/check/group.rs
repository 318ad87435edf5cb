//! `pedestrian NAME times 5 { … }`: one block for a group of people.

use std::collections::HashMap;

use super::block::{Layer, Said, last};
use super::literal;
use super::pedestrian::Described;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::syntax::ast;
use crate::value::{Member, NameScope};
use scenario::{Membership, RoadUserKind};

const MOST: u32 = 100;

/// Whom the blocks of a name describe: one person, or every member of a group, `walkers_1` and so on. The last layer that says how
/// many there are has the last word.
pub fn described(
    name: ast::Name,
    layers: &[Layer<ast::Pedestrian>],
    report: &mut Vec<Diagnostic>,
) -> Vec<Described> {
    let kinds = || layers.iter().map(|layer| (kind(layer.block), layer.block.name().span()));
    let (kind, first) = kinds().next().unwrap_or((RoadUserKind::Pedestrian, name.span()));
    if let Some((other, span)) = kinds().find(|(other, _)| *other != kind) {
        let message = format!("`{}` is {} here and {} elsewhere", name.text(), other.noun(), kind.noun());
        report.push(
            Diagnostic::new(Code::WrongWay, span, message)
                .label("does not go together")
                .context(first, "said there")
                .hint(format!(
                    "say `{} {}` in both, or give one of them another name",
                    kind.word(),
                    name.text()
                )),
        );
    }
    let Some(Said { node: size, .. }) = last(layers, ast::Pedestrian::group) else {
        return vec![Described { name: name.text().to_string(), kind, span: name.span(), group: None }];
    };
    let Some(size) = literal::count(size.number(), 1, MOST, "the number of people in a group", report) else {
        return Vec::new();
    };
    let member = |index| {
        let membership = Membership { group: name.text().to_string(), index, size };
        Described { name: membership.member_name(), kind, span: name.span(), group: Some(membership) }
    };
    (0..size).map(member).collect()
}

/// Whether a block is about somebody who walks or who rides.
fn kind(node: ast::Pedestrian) -> RoadUserKind {
    match (node.is_cyclist(), node.is_escooter()) {
        (true, _) => RoadUserKind::Cyclist,
        (_, true) => RoadUserKind::Escooter,
        _ => RoadUserKind::Pedestrian,
    }
}

/// The names that values of a member's block may use: those of each layer, and `each(…)`.
pub fn scopes<'a>(
    who: &Described,
    layers: &[Layer<'a, ast::Pedestrian<'a>>],
) -> Vec<(ast::PedestrianBlock<'a>, NameScope<'a>)> {
    let member = who
        .group
        .as_ref()
        .map(|membership| Member { index: membership.index as usize, of: membership.size as usize });
    let scope = |layer: &Layer<'a, ast::Pedestrian<'a>>| {
        (layer.block.block(), NameScope { outer: Some(layer.scope), names: HashMap::new(), member })
    };
    layers.iter().map(scope).collect()
}

/// Members may not be called as anybody or anything else is; `others` are those who stand in no group with them.
pub fn reject_taken_names(who: &[Described], others: &[&str], report: &mut Vec<Diagnostic>) {
    let taken = who.iter().find(|one| one.group.is_some() && others.contains(&one.name.as_str()));
    if let Some((one, membership)) = taken.and_then(|one| Some((one, one.group.as_ref()?))) {
        report.push(
            Diagnostic::new(
                Code::BadGroup,
                one.span,
                format!("a member of the group `{}` is called `{}`", membership.group, one.name),
            )
            .label(format!("something else is called `{}`, too", one.name))
            .hint("give one of them another name"),
        );
    }
}

/// What is wrong with the block of a group is said once, not of every member.
pub fn once(found: Vec<Diagnostic>, report: &mut Vec<Diagnostic>) {
    for diagnostic in found {
        let key = |one: &Diagnostic| (one.code, one.span());
        let same = |known: &Diagnostic| key(known) == key(&diagnostic) && known.message == diagnostic.message;
        if !report.iter().any(same) {
            report.push(diagnostic);
        }
    }
}
