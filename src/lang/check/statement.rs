//! `statement NAME { … }`

use super::block::reject_repeats;
use super::claim::claim;
use super::literal;
use super::places::TextPlaces;
use super::subject::Subjects;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::syntax::ast;
use crate::value::NameScope;
use scenario::{DeclaredStanding, Statement};

/// The statement at `node`.
pub fn statement(
    node: ast::Statement,
    subjects: &Subjects,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Statement> {
    let (name, block) = (node.name(), node.block());
    reject_repeats(*block, report);
    let standing = standing(block, report);
    let nodes: Vec<ast::Claim> = block.claims().collect();
    if nodes.is_empty() && block.not_comparable().is_none() && !block.has_bad() {
        report.push(
            Diagnostic::new(
                Code::BadStatement,
                name.span(),
                format!("statement `{}` claims nothing", name.text()),
            )
            .label("nothing to hold against results")
            .hint("say `claim mean(pet) of SCENARIO >= 1.5 s`, or `not comparable \"why\"`"),
        );
    }
    let claims: Vec<_> = nodes.into_iter().map(|node| claim(node, subjects, scope, places, report)).collect();
    Some(Statement {
        name: name.text().to_string(),
        doc: literal::doc(block.doc()),
        source: block.source().map(|source| source.quoted().value()),
        reported: block.reported().map(|reported| reported.quoted().value()),
        claims: claims.into_iter().collect::<Option<_>>()?,
        standing: standing?,
        origin: places.origin(name.span()),
    })
}

fn standing(block: ast::StatementBlock, report: &mut Vec<Diagnostic>) -> Option<DeclaredStanding> {
    let (differs, not_comparable) = (block.differs(), block.not_comparable());
    if let (Some(differs), Some(other)) = (differs, not_comparable) {
        report.push(
            Diagnostic::new(
                Code::BadStatement,
                other.span(),
                "what cannot be compared is not known to differ either",
            )
            .label("cannot be compared")
            .context(differs.span(), "known to differ")
            .hint("keep one of the two"),
        );
        return None;
    }
    let reasons = [
        differs.map(|said| (said.span(), said.reason())),
        not_comparable.map(|said| (said.span(), said.reason())),
    ];
    let Some((span, reason)) = reasons.into_iter().flatten().next() else {
        return Some(DeclaredStanding::Reproduced);
    };
    let reason = reason.value();
    if reason.trim().is_empty() {
        report.push(
            Diagnostic::new(Code::BadStatement, span, "nothing says why")
                .label("no reason")
                .hint("a reader needs the reason: `differs \"…\"`"),
        );
        return None;
    }
    Some(if differs.is_some() {
        DeclaredStanding::Differs(reason)
    } else {
        DeclaredStanding::NotComparable(reason)
    })
}
