//! `controller NAME`, `dynamics NAME`, `model NAME`: a registered thing, or those that a variation lists.

use super::Places;
use super::block::Said;
use crate::lang::codes::Code;
use crate::lang::diagnostic::Diagnostic;
use crate::lang::settings;
use crate::lang::source::Span;
use crate::lang::tree::Rule;
use crate::lang::value::{Kind, Typed};
use crate::scenario::{Declaration, Expression, Model, Value};

/// A kind of registered thing.
pub struct Registry<T: 'static> {
    /// Of one whose name is not known.
    pub code: Code,
    /// Such as `controller`.
    pub what: &'static str,
    /// Begins the message about an unknown name: "there is no controller".
    pub there_is_no: &'static str,
    pub all: &'static [&'static T],
    pub declaration: fn(&'static T) -> &'static Declaration,
}

/// What a statement names.
pub struct Named<T: 'static> {
    /// More than one if the runs differ in it; never empty.
    pub found: Vec<&'static T>,
    /// The first of them, and the variation that chooses.
    pub model: Model,
    /// What its settings were given as.
    pub given: Vec<(String, Typed)>,
    /// Of the name.
    pub span: Span,
}

/// The things that a statement names, with settings that all of them have.
pub fn named<T>(
    said: Said,
    registry: &Registry<T>,
    places: &Places,
    report: &mut Vec<Diagnostic>,
) -> Option<Named<T>> {
    let name = said.node.child(Rule::name)?;
    let (found, varied_by) = registered(said, registry, report)?;
    let before = report.len();
    let mut given: Vec<(String, Typed)> = Vec::new();
    for (index, one) in found.iter().enumerate() {
        let declaration = (registry.declaration)(one);
        let node = said.node.child(Rule::settings);
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
            let first = (registry.declaration)(found[0]).name;
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
        name: (registry.declaration)(found[0]).name.to_string(),
        varied_by,
        settings: given.iter().map(|(name, typed)| (name.clone(), typed.expression.clone())).collect(),
        origin: places.origin(name.span()),
    };
    Some(Named { found, model, given, span: name.span() })
}

/// The things themselves, and the variation that chooses between them. Their own names come first.
fn registered<T>(
    said: Said,
    registry: &Registry<T>,
    report: &mut Vec<Diagnostic>,
) -> Option<(Vec<&'static T>, Option<String>)> {
    let name = said.node.child(Rule::name)?;
    let find =
        |wanted: &str| registry.all.iter().copied().find(|one| (registry.declaration)(one).name == wanted);
    if let Some(found) = find(name.text()) {
        return Some((vec![found], None));
    }
    let known = registry.all.iter().map(|one| (registry.declaration)(one).name);
    let Some(binding) = said.scope.find(name.text()) else {
        report.push(
            Diagnostic::new(
                registry.code,
                name.span(),
                format!("{} `{}`", registry.there_is_no, name.text()),
            )
            .label(format!("unknown {}", registry.what))
            .suggest(name.text(), known),
        );
        return None;
    };
    let value = binding.value.as_ref()?;
    if value.kind != Kind::Word {
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
        let Some(one) = find(word) else {
            report.push(
                Diagnostic::new(registry.code, name.span(), format!("{} `{word}`", registry.there_is_no))
                    .label(format!("where `{}` is `{word}`", name.text()))
                    .context(binding.span, "defined here")
                    .suggest(word, known.clone()),
            );
            return None;
        };
        found.push(one);
    }
    (!found.is_empty()).then_some((found, varied_by))
}
