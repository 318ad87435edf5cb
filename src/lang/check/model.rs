//! `controller NAME`, `dynamics NAME`, `model NAME`: a registered thing, or those that a variation lists.

use std::sync::Arc;

use super::block::Said;
use super::places::TextPlaces;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::{self, Typed};
use scenario::registry::Table;
use scenario::{Expression, Model, Reference, Registered, Value};

/// A kind of registered thing.
pub struct ModelKind<'r, T> {
    /// Of one whose name is not known.
    pub code: Code,
    /// Such as `controller`.
    pub what: &'static str,
    /// Begins the message about an unknown name: "there is no controller".
    pub there_is_no: &'static str,
    pub all: &'r Table<T>,
}

/// What a statement names.
pub struct Named<T> {
    /// More than one if the runs differ in it; never empty.
    pub found: Vec<Arc<T>>,
    /// The first of them, and the variation that chooses.
    pub model: Model<T>,
    /// What its settings were given as.
    pub given: Vec<(String, Typed)>,
    /// Of the name.
    pub span: Span,
}

/// The things that a statement names, with settings that all of them have.
pub fn named<T: Registered>(
    said: Said<ast::Named>,
    kind: &ModelKind<T>,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Named<T>> {
    let name = said.node.name();
    let (found, varied_by) = registered(said, kind, report)?;
    let before = report.len();
    let mut given: Vec<(String, Typed)> = Vec::new();
    for (index, one) in found.iter().enumerate() {
        let declaration = one.declaration();
        let node = said.node.settings();
        let own = settings::check(node, declaration, said.scope, report);
        if report.len() == before {
            settings::check_texts(name, node, &own, declaration, said.scope, report);
            settings::check_published(&own, declaration, report);
        }
        if report.len() > before {
            // The others would only say the same of it again.
            return None;
        }
        let differs = |(one, other): (&(String, Typed), &(String, Typed))| {
            one.0 != other.0 || one.1.expression != other.1.expression
        };
        if index == 0 {
            given = own;
        } else if own.len() != given.len() || own.iter().zip(&given).any(differs) {
            let first = &found[0].declaration().name;
            report.push(
                Diagnostic::new(
                    Code::DoesNotFit,
                    said.node.span(),
                    format!(
                        "these settings mean one thing to `{first}` and another to `{}`",
                        declaration.name
                    ),
                )
                .label("a word that one of them knows as an option")
                .hint("give the variation that stands in a setting another name"),
            );
            return None;
        }
    }
    let model = Model {
        first: Reference::from(&found[0]),
        others: varied_by.iter().flat_map(|_| kind.all).map(Reference::from).collect(),
        varied: varied_by.iter().flat_map(|_| &found).map(Reference::from).collect(),
        varied_by,
        settings: given.iter().map(|(name, typed)| (name.clone(), typed.expression.clone())).collect(),
        origin: places.origin(name.span()),
    };
    Some(Named { found, model, given, span: name.span() })
}

/// The things themselves, and the variation that chooses between them. Their own names come first.
fn registered<T: Registered>(
    said: Said<ast::Named>,
    kind: &ModelKind<T>,
    report: &mut Vec<Diagnostic>,
) -> Option<(Vec<Arc<T>>, Option<String>)> {
    let name = said.node.name();
    if let Some(found) = kind.all.get(name.text()) {
        return Some((vec![found.clone()], None));
    }
    let known = kind.all.names();
    let Some(binding) = said.scope.find(name.text()) else {
        report.push(
            Diagnostic::new(kind.code, name.span(), format!("{} `{}`", kind.there_is_no, name.text()))
                .label(format!("unknown {}", kind.what))
                .suggest(name.text(), known),
        );
        return None;
    };
    let value = binding.value.as_ref()?;
    if value.kind != value::ValueKind::Word {
        report.push(
            Diagnostic::new(
                Code::WrongType,
                name.span(),
                format!("`{}` is {}, where a name is needed", name.text(), value.kind.name()),
            )
            .label(format!("this is {}", value.kind.name()))
            .context(binding.span, "defined here")
            .hint(format!(
                "vary it over names: `vary {} in [{}, …]`",
                name.text(),
                known.clone().next()?
            )),
        );
        return None;
    }
    let (words, varied_by): (Vec<&Value>, _) = match (&value.expression, &binding.varied) {
        (Expression::Constant(word), _) => (vec![word], None),
        (_, Some(values)) => {
            (values.iter().map(|varied| &varied.value).collect(), Some(name.text().to_string()))
        }
        _ => return None,
    };
    let mut found = Vec::new();
    for word in words.into_iter().filter_map(Value::as_word) {
        let Some(one) = kind.all.get(word) else {
            report.push(
                Diagnostic::new(kind.code, name.span(), format!("{} `{word}`", kind.there_is_no))
                    .label(format!("where `{}` is `{word}`", name.text()))
                    .context(binding.span, "defined here")
                    .suggest(word, known.clone()),
            );
            return None;
        };
        found.push(one.clone());
    }
    (!found.is_empty()).then_some((found, varied_by))
}
