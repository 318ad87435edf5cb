//! `{ name: value, … }` against what a registered thing declares.

use std::collections::HashMap;

use super::codes::Code;
use super::diagnostic::{Diagnostic, Remedy};
use super::source::Span;
use super::syntax::ast;
use super::value::{self, NameScope, Typed, ValueKind};
use scenario::{ANOTHER_MODEL, ChoiceOption, Declaration, Dimension, Expression, ParameterKind, Value};

/// The settings in braces (or of none) in the order they are written, each checked against `declaration`.
pub fn check(
    node: Option<ast::Settings>,
    declaration: &Declaration,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Vec<(String, Typed)> {
    let mut settings = Vec::new();
    let mut said: HashMap<&str, Span> = HashMap::new();
    for setting in node.iter().flat_map(|node| node.each()) {
        let (name, given) = (setting.name(), setting.value());
        if let Some(first) = said.insert(name.text(), name.span()) {
            report.push(repeated(name.text(), name.span(), first));
            continue;
        }
        if let Some(value) = one(name, given, declaration, scope, report) {
            settings.push((name.text().to_string(), value));
        }
    }
    settings
}

/// Checks the texts that a model reads by itself, those that it takes if nothing is said included; `owner` is the
/// model's name where it is said.
pub fn check_texts(
    owner: ast::Name,
    node: Option<ast::Settings>,
    settings: &[(String, Typed)],
    declaration: &Declaration,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) {
    let given = |name: &str| {
        settings.iter().any(|(said, _)| said == name)
            || declaration.parameter(name).is_some_and(|parameter| parameter.default_value().is_some())
    };
    for parameter in &declaration.parameters {
        let ParameterKind::Text { default, check } = &parameter.kind else { continue };
        let said = settings.iter().find(|(name, _)| *name == parameter.name);
        let mut each = node.iter().flat_map(|node| node.each());
        let place = each.find(|setting| setting.name().text() == parameter.name);
        let place = place.map(ast::Setting::value);
        let texts = match said {
            Some((_, typed)) => value::possible(&typed.expression, scope),
            None => vec![(Value::Word(default.to_string()), None)],
        };
        for (text, varied) in texts {
            let Value::Word(text) = text else { continue };
            for error in check(&text, &given) {
                let whole = place.map_or(owner.span(), |place| place.span());
                let written = place.map_or("", |place| place.text());
                let span = match written.find(&error.part).filter(|_| !error.part.is_empty()) {
                    Some(at) => {
                        Span::new(whole.source, whole.start + at, whole.start + at + error.part.len())
                    }
                    None => whole,
                };
                let varied = varied.as_ref().map(|varied| format!(" where {varied}")).unwrap_or_default();
                let hint = error.hint.unwrap_or_else(|| {
                    format!(
                        "`scenario-runner models {}` says what `{}` takes",
                        declaration.name, parameter.name
                    )
                });
                report.push(
                    Diagnostic::new(Code::BadText, span, format!("{}{varied}", error.message))
                        .label("not understood")
                        .hint(hint),
                );
            }
        }
    }
}

/// Refuses to vary what makes another model than was published, unless the settings say that this is meant.
pub fn check_published(
    settings: &[(String, Typed)],
    declaration: &Declaration,
    report: &mut Vec<Diagnostic>,
) {
    let meant = settings.iter().any(|(name, typed)| {
        name == ANOTHER_MODEL && typed.expression == Expression::Constant(Value::Flag(true))
    });
    for (name, typed) in settings.iter().filter(|_| !meant) {
        let published = declaration.parameter(name).is_some_and(|parameter| parameter.published.is_some());
        if published && !matches!(typed.expression, Expression::Constant(_)) {
            report.push(unmeant(typed.span, &format!("`{name}` of `{}`", declaration.name), "is varied"));
        }
    }
}

/// That `what` is done to something that has one published value.
pub fn unmeant(span: Span, something: &str, what: &str) -> Diagnostic {
    let message = format!("{something} {what}, but every value beside the published one is another model");
    Diagnostic::new(Code::UnmeantModel, span, message).label("has one published value").hint(format!(
        "leave it as published, or say `{ANOTHER_MODEL}: true` in the model's settings if it is meant"
    ))
}

pub fn repeated(name: &str, span: Span, first: Span) -> Diagnostic {
    Diagnostic::new(Code::RepeatedStatement, span, format!("`{name}` is said twice"))
        .label("said again")
        .context(first, "said first here")
        .hint("remove one of them")
        .remedy(Remedy::Remove)
}

/// One setting against what `declaration` says about it.
pub fn one(
    name: ast::SettingName,
    given: ast::Expression,
    declaration: &Declaration,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Typed> {
    let what = format!("`{}` of `{}`", name.text(), declaration.name);
    if let Some(family) = declaration.presets.as_ref().filter(|family| family.word == name.text()) {
        let options: Vec<_> = family.presets.iter().map(|preset| &*preset.name).collect();
        return chosen(given, &what, &options, scope, report);
    }
    let Some(parameter) = declaration.parameter(name.text()) else {
        let known = declaration
            .parameters
            .iter()
            .map(|parameter| &*parameter.name)
            .chain(declaration.presets.as_ref().map(|family| &*family.word));
        report.push(
            Diagnostic::new(
                Code::UnknownParameter,
                name.span(),
                format!("`{}` has no parameter `{}`", declaration.name, name.text()),
            )
            .label("unknown parameter")
            .suggest(name.text(), known),
        );
        return None;
    };
    match &parameter.kind {
        ParameterKind::Choice { options, .. } => {
            let options: Vec<_> = options.iter().map(|option: &ChoiceOption| &*option.name).collect();
            chosen(given, &what, &options, scope, report)
        }
        ParameterKind::Text { .. } | ParameterKind::Pedestrian => word(given, scope, report)
            .filter(|value| value::expect_kind(value, ValueKind::Word, &what, report)),
        ParameterKind::Number { dimension, range, .. } => {
            value::quantity_in(given, *dimension, *range, &what, scope, report)
        }
        ParameterKind::Whole { range: (low, high), .. } => {
            let range = (*low as f64, *high as f64);
            let value = value::quantity_in(given, Dimension::NUMBER, range, &what, scope, report)?;
            value::possible(&value.expression, scope)
                .iter()
                .all(|(found, _)| match found {
                    Value::Number(number) if number.fract() != 0.0 => {
                        report.push(not_whole(value.span, &what, *number));
                        false
                    }
                    _ => true,
                })
                .then_some(value)
        }
        ParameterKind::Flag { .. } => value::evaluate(given, scope, report)
            .filter(|value| value::expect_kind(value, ValueKind::Flag, &what, report)),
    }
}

pub fn not_whole(span: Span, what: &str, found: f64) -> Diagnostic {
    Diagnostic::new(Code::NotWhole, span, format!("{what} is {found}, but must be a whole number"))
        .label("not whole")
        .hint(format!("write {} or {}", found.floor(), found.ceil()))
        .remedy(Remedy::Replace(found.floor().to_string()))
        .remedy(Remedy::Replace(found.ceil().to_string()))
}

/// A name alone is the word itself, unless a `let` or variation has that name.
fn word(given: ast::Expression, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<Typed> {
    match given.lone_word() {
        Some(word) if scope.find(word).is_none() => {
            Some(Typed::constant(Value::Word(word.to_string()), ValueKind::Word, given.span()))
        }
        _ => value::evaluate(given, scope, report),
    }
}

/// One of a few words. An option's own name always means the option.
pub fn choice(
    given: ast::Expression,
    what: &str,
    options: &[&str],
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Expression> {
    chosen(given, what, options, scope, report).map(|value| value.expression)
}

fn chosen(
    given: ast::Expression,
    what: &str,
    options: &[&str],
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Typed> {
    let value = match given.lone_word() {
        Some(word) if options.contains(&word) => return Some(Typed::word(word, given.span())),
        _ => word(given, scope, report)?,
    };
    if !value::expect_kind(&value, ValueKind::Word, what, report) {
        return None;
    }
    for (found, varied) in value::possible(&value.expression, scope) {
        if let Value::Word(found) = found
            && !options.contains(&found.as_str())
        {
            let place = varied.map(|varied| format!(" where {varied}")).unwrap_or_default();
            report.push(
                Diagnostic::new(
                    Code::UnknownOption,
                    value.span,
                    format!("{what} has no option `{found}`{place}"),
                )
                .label("unknown option")
                .suggest(&found, options.iter().copied()),
            );
            return None;
        }
    }
    Some(value)
}
