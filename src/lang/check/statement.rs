//! `statement NAME { … }`

use super::Places;
use super::block::reject_repeats;
use super::claim::claim;
use super::subject::Subjects;
use crate::lang::codes::Code;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::tree::{Node, Rule};
use crate::lang::value::{Scope, unquote};
use crate::scenario::{Standing, Statement};

/// The statement at `node`.
pub fn statement(
    node: Node,
    subjects: &Subjects,
    scope: &Scope,
    places: &Places,
    report: &mut Vec<Diagnostic>,
) -> Option<Statement> {
    let name = node.child(Rule::name)?;
    let block = node.child(Rule::statement_block)?;
    reject_repeats(block, &[Rule::claim], report);
    let standing = standing(block, report);
    let nodes: Vec<Node> = block.all(Rule::claim).collect();
    if nodes.is_empty() && !block.has(Rule::not_comparable) && !block.has(Rule::bad) {
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
        doc: super::doc(block),
        source: super::source(block),
        reported: super::text(block, Rule::reported),
        claims: claims.into_iter().collect::<Option<_>>()?,
        standing: standing?,
        origin: places.origin(name.span()),
    })
}

fn standing(block: Node, report: &mut Vec<Diagnostic>) -> Option<Standing> {
    let (differs, not_comparable) = (block.child(Rule::differs), block.child(Rule::not_comparable));
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
    let Some(node) = differs.or(not_comparable) else { return Some(Standing::Reproduced) };
    let reason = node.child(Rule::string).map(|text| unquote(text.text())).unwrap_or_default();
    if reason.trim().is_empty() {
        report.push(
            Diagnostic::new(Code::BadStatement, node.span(), "nothing says why")
                .label("no reason")
                .hint("a reader needs the reason: `differs \"…\"`"),
        );
        return None;
    }
    Some(if differs.is_some() { Standing::Differs(reason) } else { Standing::NotComparable(reason) })
}
