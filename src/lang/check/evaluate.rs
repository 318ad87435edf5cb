//! `evaluate NAME { … }`

use std::collections::HashMap;
use std::path::Path;

use super::block::{Layer, missing, reject_repeats};
use super::comparison::bound_in;
use super::experiment::{SummedUp, fresh_seeds, summed_up};
use super::literal;
use super::places::TextPlaces;
use super::subject::{StatementSubject, Subjects, case_set};
use super::target::{Takes, reject_unmeant, target};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::settings::{self, repeated};
use crate::source::Span;
use crate::syntax::ast;
use crate::syntax::phrase;
use crate::value::{self, NameScope};
use scenario::{Condition, Dimension, Evaluate, Expression, Measure, Notation, ParameterSet, Target, Value};

/// What a condition is called that changes nothing.
const DEFAULT: &str = "default";

/// The evaluate at `node`.
pub fn evaluate(
    node: ast::Evaluate,
    subjects: &Subjects,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Evaluate> {
    let (name, block) = (node.name(), node.block());
    reject_repeats(*block, report);
    let layers = [Layer { block, scope }];
    let what = format!("evaluate `{}`", name.text());
    let Some(on) = block.on() else {
        missing::<ast::OnCases>(&layers, name.span(), &what, report);
        return None;
    };
    let (on, subject) = case_set(on, subjects, places, report)?;
    let nodes: Vec<ast::Evaluated> = block.conditions().flat_map(ast::Conditions::each).collect();
    if nodes.is_empty() {
        missing::<ast::Conditions>(&layers, name.span(), &what, report);
    }
    let mut names: HashMap<String, Span> = HashMap::new();
    let mut given_in = Vec::new();
    let conditions: Vec<_> = nodes
        .into_iter()
        .map(|node| {
            let condition = condition(node, (subjects, &subject), scope, &mut given_in, places, report)?;
            let named = node.alias().map_or(node.span(), |alias| alias.span());
            if let Some(first) = names.insert(condition.name.clone(), named) {
                report.push(
                    Diagnostic::new(
                        Code::BadCondition,
                        named,
                        format!("two conditions are called `{}`", condition.name),
                    )
                    .label("the second one")
                    .context(first, "the first one")
                    .hint("give one of them another name: `… as NAME`"),
                );
                return None;
            }
            Some(condition)
        })
        .collect();
    let fresh = fresh_seeds(block.fresh_seeds(), report);
    let cast = subject.cast();
    let measures: Vec<_> = block
        .measures()
        .flat_map(ast::Measures::each)
        .map(|node| summed_up(node, "measure", &cast, scope, report))
        .collect();
    let conditions: Vec<Condition> = conditions.into_iter().collect::<Option<_>>()?;
    let measures: Vec<_> = measures.into_iter().collect::<Option<_>>()?;
    let mut written_in = vec![None; measures.len()];
    let reported = reported(block, &conditions, &measures, &mut written_in, scope, report);
    let nodes = block.measures().flat_map(ast::Measures::each);
    let compared: Vec<_> = nodes
        .zip(&measures)
        .filter_map(|(node, measure)| {
            let Some(ast::Aggregate::Rate(rate)) = node.aggregate() else { return None };
            Some((measure.aggregate.metric(), bound_in(rate.condition(), scope)?))
        })
        .collect();
    for (notation, measure) in written_in.iter_mut().zip(&measures) {
        let same = compared.iter().find(|(metric, _)| *metric == measure.aggregate.metric());
        *notation = notation.or(same.map(|(_, unit)| *unit));
        // Shares and counts have no unit but their own.
        *notation = notation.filter(|_| measure.dimension != Dimension::NUMBER);
    }
    Some(Evaluate {
        name: name.text().to_string(),
        doc: literal::doc(block.doc()),
        on,
        conditions: Some(conditions).filter(|conditions| !conditions.is_empty())?,
        fresh: fresh?,
        source: block.source().map(|source| source.quoted().value()),
        reported: reported?,
        measures: measures
            .into_iter()
            .zip(written_in)
            .map(|(SummedUp { aggregate, text, dimension, .. }, notation)| Measure {
                aggregate,
                text,
                unit: dimension.si_unit(),
                notation,
            })
            .collect(),
        given_in,
        origin: places.origin(name.span()),
    })
}

fn condition(
    node: ast::Evaluated,
    (subjects, subject): (&Subjects, &StatementSubject),
    scope: &NameScope,
    given_in: &mut Vec<(Target, Notation)>,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Condition> {
    let alias = node.alias().map(ast::Alias::name);
    let (parameters, own_name) = if let Some(name) = node.name() {
        (by_name(name, subjects, subject, places, report)?, Some(name))
    } else if let Some(path) = node.path() {
        let saved = places.beside(path.span(), &path.path());
        if !places.files.texts().is_file(Path::new(&saved)) {
            report.push(
                Diagnostic::new(
                    Code::UnreadableFile,
                    path.span(),
                    format!("there is no file `{saved}` with parameters"),
                )
                .label("named here")
                .hint("a tune writes such a file; paths are relative to the file they stand in"),
            );
            return None;
        }
        (ParameterSet::Saved(saved), None)
    } else {
        let set = node.set()?;
        (ParameterSet::Given(given(set, subject, scope, given_in, report)?), None)
    };
    let Some(name) = alias.or(own_name) else {
        report.push(
            Diagnostic::new(Code::BadCondition, node.span(), "this condition has no name")
                .label("nothing to call it by")
                .hint("give it one: `… as NAME`"),
        );
        return None;
    };
    Some(Condition { name: name.text().to_string(), parameters, origin: places.origin(node.span()) })
}

/// `default`, what a tune chose, or another scenario.
fn by_name(
    name: ast::Name,
    subjects: &Subjects,
    subject: &StatementSubject,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<ParameterSet> {
    if name.text() == DEFAULT {
        return Some(ParameterSet::Declared);
    }
    if subjects.scenario_names(places).any(|known| known == name.text()) {
        let other = subjects.scenario(name.span(), name.text(), &[], places, report)?;
        return fits(name, &other, subject, report).then(|| ParameterSet::Scenario(name.text().to_string()));
    }
    if !subjects.tunes.has(name.text()) {
        let diagnostic = Diagnostic::new(
            Code::UnknownBlock,
            name.span(),
            format!("there is no tune or scenario `{}` here", name.text()),
        );
        report.push(if subjects.searches.has(name.text()) {
            diagnostic
                .label("a search, which finds cases and no parameters")
                .hint(format!("take its cases: `on {}`", name.text()))
        } else {
            diagnostic.label("not in this suite").suggest(
                name.text(),
                subjects.tunes.names().chain(subjects.scenario_names(places)).chain([DEFAULT]),
            )
        });
        return None;
    }
    let tune = subjects.tunes.find(name.text())?;
    if let Some(range) = tune.over.iter().find(|range| !subject.takes(&range.target)) {
        report.push(
            Diagnostic::new(
                Code::BadCondition,
                name.span(),
                format!(
                    "tune `{}` chooses `{}`, which scenario `{}` does not have",
                    name.text(),
                    range.target,
                    subject.scenario.name
                ),
            )
            .label("does not fit these cases")
            .hint("compare parameter sets on cases of a scenario that has their parameters"),
        );
        return None;
    }
    Some(ParameterSet::Tuned(name.text().to_string()))
}

/// Whether the cases of `subject` can be run in the scenario `other`: they must say everything that it leaves open, and
/// the people in them must be people there.
fn fits(
    name: ast::Name,
    other: &StatementSubject,
    subject: &StatementSubject,
    report: &mut Vec<Diagnostic>,
) -> bool {
    let unsaid = other.varied.keys().filter(|varied| !subject.varied.contains_key(*varied)).min();
    let lost = subject.scenario.pedestrians.iter().filter(|one| one.individuals.is_some()).find(|one| {
        let same = |there: &&scenario::DeclaredPedestrian| {
            there.name == one.name && there.model.first == one.model.first
        };
        !other.scenario.pedestrians.iter().any(|there| same(&there))
    });
    let (own, theirs) = (&subject.scenario.name, name.text());
    let diagnostic = |message: String| {
        Diagnostic::new(Code::BadCondition, name.span(), message)
            .label("does not fit these cases")
            .hint("a scenario as a condition runs the same variations, people and seeds in its own world")
    };
    match (unsaid, lost) {
        (Some(varied), _) => report.push(diagnostic(format!(
            "scenario `{theirs}` varies `{varied}`, for which the cases of `{own}` have no value"
        ))),
        (None, Some(person)) => report.push(diagnostic(format!(
            "pedestrian `{}` of `{own}` is an individual of `{}`, but not in scenario `{theirs}`",
            person.name, person.model.first
        ))),
        (None, None) => return true,
    }
    false
}

/// `{ av.controller.braking_distance: 10 m }`; `given_in` takes the units.
fn given(
    node: ast::ParameterSet,
    subject: &StatementSubject,
    scope: &NameScope,
    given_in: &mut Vec<(Target, Notation)>,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<(Target, Value)>> {
    let nodes: Vec<ast::Given> = node.given().collect();
    if nodes.is_empty() && !node.has_bad() {
        report.push(
            Diagnostic::new(Code::BadCondition, node.span(), "this condition sets nothing")
                .label("no parameters")
                .hint("what the scenario declares is called `default`"),
        );
        return None;
    }
    let mut said: HashMap<String, Span> = HashMap::new();
    let values: Vec<_> = nodes
        .into_iter()
        .map(|node| {
            let (place, wanted) = (node.target(), node.value());
            if let Some(first) = said.insert(phrase(*place), place.span()) {
                report.push(repeated(&phrase(*place), place.span(), first));
                return None;
            }
            let (target, takes) = target(place, subject, report)?;
            reject_unmeant(place, &target, &takes, subject.scenario, "is compared", report)?;
            let (Takes::Parameter(declaration, _), Some(parameter)) = (takes, place.parameter()) else {
                report.push(
                    Diagnostic::new(
                        Code::BadTarget,
                        place.span(),
                        format!("`{target}` is varied, and a condition sets parameters"),
                    )
                    .label("not a parameter")
                    .hint("the cases have their own values; choose other cases after `on`"),
                );
                return None;
            };
            let value = settings::one(parameter, wanted, &declaration, scope, report)?;
            given_in.extend(value.notation.map(|notation| (target.clone(), notation)));
            match value.expression {
                Expression::Constant(value) => Some((target, value)),
                varying => value::not_constant(wanted.span(), &varying, "a condition", report),
            }
        })
        .collect();
    values.into_iter().collect()
}

/// The rows of a source, each with a value for every measure; `written_in` takes the first unit of each.
fn reported(
    block: ast::EvaluateBlock,
    conditions: &[Condition],
    measures: &[SummedUp],
    written_in: &mut [Option<Notation>],
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<(String, Vec<f64>)>> {
    let mut said: HashMap<&str, Span> = HashMap::new();
    let rows: Vec<_> = block
        .rows()
        .map(|row| {
            let name = row.name();
            if !conditions.iter().any(|condition| condition.name == name.text()) {
                report.push(
                    Diagnostic::new(
                        Code::UnknownCondition,
                        name.span(),
                        format!("there is no condition `{}`", name.text()),
                    )
                    .label("not after `with`")
                    .suggest(name.text(), conditions.iter().map(|condition| condition.name.as_str())),
                );
                return None;
            }
            if let Some(first) = said.insert(name.text(), name.span()) {
                report.push(repeated(name.text(), name.span(), first));
                return None;
            }
            let values: Vec<ast::Expression> = row.values().collect();
            if values.len() != measures.len() {
                let (count, wanted) = (values.len(), measures.len());
                let values = if count == 1 { "1 value".to_string() } else { format!("{count} values") };
                let diagnostic = Diagnostic::new(
                    Code::BadReported,
                    row.span(),
                    format!("the row has {values}, but {wanted} are measured"),
                )
                .label(values);
                report.push(match measures {
                    [] => diagnostic.hint("say what they are, in their order: `measure mean(pet), …`"),
                    _ => {
                        let texts: Vec<_> = measures.iter().map(|measure| measure.text.as_str()).collect();
                        diagnostic.hint(format!("give one for each of {}", texts.join(", ")))
                    }
                });
                return None;
            }
            let values: Vec<_> = values
                .into_iter()
                .zip(measures)
                .zip(written_in.iter_mut())
                .map(|((value, measure), notation)| {
                    let (dimension, range) = (measure.dimension, measure.range);
                    let what = format!("the reported `{}`", measure.text);
                    let (value, written) =
                        value::written_constant(value, dimension, range, &what, scope, report)?;
                    *notation = notation.or(written);
                    Some(value)
                })
                .collect();
            Some((name.text().to_string(), values.into_iter().collect::<Option<_>>()?))
        })
        .collect();
    rows.into_iter().collect()
}
