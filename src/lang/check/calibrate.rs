//! `calibrate NAME { … }`

use std::collections::BTreeMap;
use std::path::Path;

use super::block::{Layer, missing, reject_repeats};
use super::comparison;
use super::criterion;
use super::literal;
use super::matched_parameters::matched_parameters;
use super::pedestrian::individuals_of;
use super::places::TextPlaces;
use super::subject::{StatementSubject, Subjects};
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax;
use crate::syntax::ast;
use crate::value::{self, NameScope};
use scenario::{
    Calibrate, CandidateSource, DeclaredPedestrian, Dimension, Individuals, MatchedRate, Observations,
    ObservedRow, PopulationShare, Variation,
};

const MOST_CANDIDATES: u32 = 100_000;
/// Where nothing is said.
const RUNS: u32 = 20;

/// The calibration at `node`.
pub fn calibrate(
    node: ast::Calibrate,
    subjects: &Subjects,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Calibrate> {
    let (name, block) = (node.name(), node.block());
    reject_repeats(*block, report);
    let layers = [Layer { block, scope }];
    let what = format!("calibrate `{}`", name.text());
    let scenarios = match block.scenarios() {
        Some(said) => named_scenarios(said, subjects, places, report),
        None => {
            missing::<ast::CalibrateIn>(&layers, name.span(), &what, report);
            None
        }
    };
    if block.matched().next().is_none() {
        missing::<ast::Matched>(&layers, name.span(), &what, report);
        return None;
    }
    let Some(candidates) = block.candidates() else {
        missing::<ast::Candidates>(&layers, name.span(), &what, report);
        return None;
    };
    let scenarios = scenarios?;
    let within = match block.method().and_then(|method| method.within()) {
        Some(within) => tolerance(within, scope, report),
        None => Some(1.0),
    };
    let rates = matched_rates(block, &scenarios, within.unwrap_or(1.0), scope, places, report);
    let folds = match block.folds() {
        Some(folds) => literal::count(folds.count(), 2, 100, "the number of folds", report),
        None => Some(0),
    };
    let runs = match block.repeat() {
        Some(repeat) => {
            literal::count(repeat.count(), 2, 10_000, "the number of runs of a candidate", report)
        }
        None => Some(RUNS),
    };
    let candidates = candidates_of(candidates, &scenarios, places, report);
    let compared = block.compare().map(|said| compared(said, places)).unwrap_or_default();
    let able = scenarios.iter().all(|(span, subject)| one_is_weighed(*span, subject, report));
    let parameters = if able {
        let (_, first) = &scenarios[0];
        let person = weighed(&first.scenario.pedestrians)[0];
        matched_parameters(block, first, person, scope, report)
    } else {
        None
    };
    let (rates, candidates) = (rates?, candidates?);
    let conditions: usize = rates.iter().map(|rate| rate.observations.rows.len()).sum();
    let targets = rates.iter().map(MatchedRate::targets).sum::<usize>() + block.parameters().count();
    if let CandidateSource::LatinHypercube(count) = candidates
        && (count as usize) < targets
    {
        report.push(
            unweighable(
                block.candidates().map_or(name.span(), |said| said.span()),
                format!("{count} candidates are fewer than the {targets} targets"),
            )
            .label("too few to be weighed")
            .hint("take some hundreds for each target, such as `candidates 2000 by latin_hypercube`"),
        );
        return None;
    }
    if let Some(folds) = folds
        && folds as usize > conditions
    {
        report.push(
            Diagnostic::new(
                Code::BadObservations,
                block.folds().map_or(name.span(), |said| said.span()),
                format!("{folds} folds of {conditions} conditions"),
            )
            .label("more than conditions")
            .hint(format!("take at most {conditions}")),
        );
        return None;
    }
    able.then_some(Calibrate {
        name: name.text().to_string(),
        doc: literal::doc(block.doc()),
        candidates,
        scenarios: scenarios.iter().map(|(_, subject)| subject.scenario.name.clone()).collect(),
        rates,
        within: within?,
        parameters: parameters?,
        folds: folds?,
        runs: runs?,
        compared,
        origin: places.origin(name.span()),
    })
}

/// Every rate of the block with what people did. Each scenario has rows of one of them at least, and none of a rate twice.
fn matched_rates(
    block: ast::CalibrateBlock,
    scenarios: &[Named],
    within: f64,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<MatchedRate>> {
    reject_other_spreads(block, report)?;
    let mut rates: Vec<MatchedRate> = Vec::new();
    let mut is_whole = true;
    for matched in block.matched() {
        match matched_rate(matched, block, scenarios, within, scope, places, report) {
            Some(rate) => rates.push(rate),
            None => is_whole = false,
        }
    }
    if !is_whole {
        return None;
    }
    for (span, subject) in scenarios {
        let name = &subject.scenario.name;
        let about: Vec<&MatchedRate> = rates.iter().filter(|rate| rate.is_about(name)).collect();
        if about.is_empty() {
            let files: Vec<&str> = rates.iter().map(|rate| rate.observations.file.as_str()).collect();
            let message = format!("{}: no row is about `{name}`", files.join(", "));
            report.push(
                Diagnostic::new(Code::BadObservations, *span, message)
                    .label("not observed")
                    .hint(format!("add its conditions, or leave `{name}` out of the block")),
            );
            return None;
        }
        let is_again = |index: usize| about[..index].iter().any(|one| one.text == about[index].text);
        if (0..about.len()).any(is_again) {
            let message = format!("two files say how often people did the same in `{name}`");
            report.push(
                Diagnostic::new(Code::BadObservations, *span, message)
                    .label("observed twice")
                    .hint("put what is known into the rows of one file"),
            );
            return None;
        }
    }
    Some(rates)
}

/// Reports a spread of a rate that is not matched, or one that is said twice.
fn reject_other_spreads(block: ast::CalibrateBlock, report: &mut Vec<Diagnostic>) -> Option<()> {
    let mut seen: Vec<(String, Span)> = Vec::new();
    for spread in block.spreads() {
        let text = rate_text(spread.rate());
        if let Some((_, first)) = seen.iter().find(|(known, _)| *known == text) {
            report.push(crate::settings::repeated("match spread", spread.span(), *first));
            return None;
        }
        if block.matched().all(|matched| rate_text(matched.rate()) != text) {
            let matched = block.matched().next()?;
            report.push(
                Diagnostic::new(
                    Code::BadObservations,
                    spread.rate().span(),
                    format!("the spread is not that of `{}`", rate_text(matched.rate())),
                )
                .label("another rate")
                .context(matched.rate().span(), "observed is this")
                .hint(format!("write `match spread between individuals of {}`", rate_text(matched.rate()))),
            );
            return None;
        }
        seen.push((text, spread.span()));
    }
    Some(())
}

/// A rate with what people did; `within` is the tolerance of shares.
fn matched_rate(
    node: ast::Matched,
    block: ast::CalibrateBlock,
    scenarios: &[Named],
    within: f64,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<MatchedRate> {
    let rate = node.rate();
    if ast::Aggregate::Rate(rate).word() != "rate" {
        report.push(
            Diagnostic::new(Code::BadObservations, rate.span(), "a share of trials is observed, not a count")
                .label("counts runs")
                .hint(format!("write `{}`", rate_text(rate).replacen("count", "rate", 1))),
        );
        return None;
    }
    if let (Some(inside), Some(behind)) = (rate.undefined(), node.not_counted()) {
        report.push(
            Diagnostic::new(
                Code::RepeatedModifier,
                behind.span(),
                "it is said twice what an undefined run is",
            )
            .label("said here again")
            .context(inside.span(), "first here")
            .hint(
                "say `undefined not counted` alone where shares are of the runs in which the metric exists",
            ),
        );
    }
    let observations = observations(node, scenarios, places, report)?;
    let text = rate_text(rate);
    let spread = block.spreads().find(|spread| rate_text(spread.rate()) == text);
    let spread_within = match spread {
        Some(spread) => Some(spread.within().map_or(Some(within), |said| tolerance(said, scope, report))?),
        None => None,
    };
    if let Some(spread) = spread
        && !observations.rows.iter().any(ObservedRow::has_pairs)
    {
        report.push(
            Diagnostic::new(
                Code::BadObservations,
                spread.span(),
                format!("{} says no spread between individuals", observations.file),
            )
            .label("of which nothing is known")
            .hint("add the columns `pair_share` and `pair_error`, or leave `match spread` out"),
        );
        return None;
    }
    // Each scenario has its own vehicles and pedestrians that a condition may name.
    let mut found = None;
    for (_, subject) in scenarios {
        if observations.is_about(&subject.scenario.name) {
            let cast = subject.cast();
            let condition = criterion::condition_of_rate(rate, node.undefined(), &cast, scope, report)?;
            let counted_where = match node.counted_where() {
                Some(said) => {
                    let said = (said.condition(), None, "the bound behind `where`");
                    Some(comparison::constant_comparison(said, &cast, scope, report)?)
                }
                None => None,
            };
            found.get_or_insert((condition, counted_where));
        }
    }
    let (condition, counted_where) = found?;
    Some(MatchedRate {
        condition,
        only_defined: node.not_counted().is_some(),
        counted_where,
        text: match node.counted_where() {
            Some(said) => format!("{text} where {}", syntax::condition_text(said.condition(), None)),
            None => text,
        },
        observations,
        spread_within,
    })
}

/// In canonical words, such as `rate(gap_accepted)`.
fn rate_text(rate: ast::Rate) -> String {
    syntax::aggregate_text(ast::Aggregate::Rate(rate))
}

type Named<'a> = (Span, StatementSubject<'a>);

fn named_scenarios<'a>(
    said: ast::CalibrateIn,
    subjects: &Subjects<'a>,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<Named<'a>>> {
    let mut found: Vec<Named> = Vec::new();
    for name in said.names() {
        let subject = subjects.scenario(name.span(), name.text(), &[], places, report)?;
        if let Some((first, _)) = found.iter().find(|(_, known)| known.scenario.name == name.text()) {
            report.push(crate::settings::repeated(name.text(), name.span(), *first));
            return None;
        }
        found.push((name.span(), subject));
    }
    Some(found)
}

fn unweighable(span: Span, message: String) -> Diagnostic {
    Diagnostic::new(Code::BadCandidates, span, message)
}

/// The pedestrian of a scenario that the candidates are.
fn weighed(people: &[DeclaredPedestrian]) -> Vec<&DeclaredPedestrian> {
    let of_population: Vec<_> = people.iter().filter(|person| person.individuals.is_some()).collect();
    if !of_population.is_empty() {
        return of_population;
    }
    let takes = |person: &&DeclaredPedestrian| {
        person.model.all().iter().all(|model| model.entry().is_some_and(|model| model.takes_individuals))
    };
    people.iter().filter(takes).collect()
}

fn one_is_weighed(span: Span, subject: &StatementSubject, report: &mut Vec<Diagnostic>) -> bool {
    let scenario = subject.scenario;
    let people = weighed(&scenario.pedestrians);
    if people.len() != 1 || people[0].model.varied_by.is_some() {
        let message = match people.len() {
            1 => format!("the model of `{}` varies in `{}`", people[0].name, scenario.name),
            count => format!("{count} pedestrians of `{}` could be the candidates", scenario.name),
        };
        report.push(
            unweighable(span, message).label("nobody is weighed here").hint(
                "let one pedestrian take `individuals`, of one model that has them, such as `commotions`",
            ),
        );
        return false;
    }
    true
}

fn candidates_of(
    node: ast::Candidates,
    scenarios: &[Named],
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<CandidateSource> {
    let number = match node.count() {
        Some(count) => Some(literal::count(count, 1, MOST_CANDIDATES, "the number of candidates", report)?),
        None => None,
    };
    if node.is_latin_hypercube() {
        return Some(CandidateSource::LatinHypercube(number?));
    }
    let selection = number.map_or(PopulationShare::All, PopulationShare::Count);
    let person =
        scenarios.iter().find_map(|(_, subject)| weighed(&subject.scenario.pedestrians).first().copied());
    let (population, text) = individuals_of(node.population()?, places);
    let origin = places.origin(node.span());
    let individuals = Individuals { selection, population, text, origin };
    person.map(|_| CandidateSource::Population(individuals))
}

/// The smallest and the largest part of an error that targets are matched within.
const TOLERANCES: (f64, f64) = (0.01, 10.0);

/// How many errors of targets are their tolerance.
fn tolerance(node: ast::Expression, scope: &NameScope, report: &mut Vec<Diagnostic>) -> Option<f64> {
    let what = "the part of the error";
    let value = value::quantity_of(node, Dimension::NUMBER, what, scope, report)?;
    let number = value
        .as_constant_number()
        .or_else(|| value::not_constant(value.span, &value.expression, what, report))?;
    let (low, high) = TOLERANCES;
    if (low..=high).contains(&number) {
        return Some(number);
    }
    report.push(
        Diagnostic::new(
            Code::OutOfRange,
            node.span(),
            format!("{what} is {} %, but must be between {} % and {} %", 100.0 * number, 100.0 * low, 100.0 * high),
        )
        .label("out of range")
        .hint("100 % is as well as the targets are known; 50 % matches twice as well, by weights that are less equal"),
    );
    None
}

/// Populations that are shown beside, everybody in them.
fn compared(node: ast::ComparePeople, places: &TextPlaces) -> Vec<Individuals> {
    let one = |node: ast::Population| {
        let origin = places.origin(node.span());
        let (population, text) = individuals_of(node, places);
        Individuals { selection: PopulationShare::All, population, text, origin }
    };
    node.populations().map(one).collect()
}

/// What people did, each row about a condition of one of the scenarios.
fn observations(
    node: ast::Matched,
    scenarios: &[Named],
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Observations> {
    let path = node.path();
    let file = places.beside(path.span(), &path.path());
    let short =
        Path::new(&file).file_name().map_or_else(|| file.clone(), |name| name.to_string_lossy().into_owned());
    let wrong = |message: String| {
        Diagnostic::new(Code::BadObservations, path.span(), format!("{short}: {message}")).label("read here")
    };
    let text = match places.files.text_of(&file, &["csv"]) {
        Ok(text) => text,
        Err(error) => {
            report.push(wrong(error).hint("paths are relative to the file they stand in"));
            return None;
        }
    };
    let read = match Observations::parse(&short, &text) {
        Ok(read) => read,
        Err(error) => {
            report.push(wrong(error.to_string()).hint(error.hint()));
            return None;
        }
    };
    let mut conditions = BTreeMap::new();
    for (span, subject) in scenarios {
        conditions.insert(subject.scenario.name.as_str(), conditions_of(*span, subject, report)?);
    }
    for row in &read.rows {
        let Some(known) = conditions.get(row.scenario.as_str()) else {
            let names = conditions.keys().copied();
            report.push(
                wrong(format!("row {}: `{}` is none of the scenarios of this block", row.row, row.scenario))
                    .suggest(&row.scenario, names),
            );
            return None;
        };
        let fits = |condition: &Vec<(String, String)>| {
            condition.len() == row.values.len()
                && condition.iter().all(|(name, label)| row.is_at(name, label))
        };
        if !known.iter().any(fits) {
            let shown: Vec<String> = known.iter().take(12).map(|condition| words(condition)).collect();
            report.push(
                wrong(format!("row {}: there is no condition {}", row.row, row.in_words())).hint(format!(
                    "`{}` has {}",
                    row.scenario,
                    shown.join("; ")
                )),
            );
            return None;
        }
    }
    Some(read)
}

fn words(condition: &[(String, String)]) -> String {
    let each: Vec<_> = condition.iter().map(|(name, label)| format!("{name} {label}")).collect();
    if each.is_empty() { "a single condition, and no column for values".to_string() } else { each.join(", ") }
}

/// The combinations of what a scenario varies, with the values as they are written.
fn conditions_of(
    span: Span,
    subject: &StatementSubject,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<Vec<(String, String)>>> {
    let mut all = vec![Vec::new()];
    for variation in &subject.scenario.variations {
        let Variation::Grid { names, rows } = variation else {
            let message =
                format!("`{}` draws values of `{}`", subject.scenario.name, variation.names().join("`, `"));
            report.push(
                unweighable(span, message)
                    .label("has no conditions that a table could name")
                    .hint("list the values: `vary gap in [3 s, 4 s, 5 s]`"),
            );
            return None;
        };
        let add = |condition: &Vec<(String, String)>| {
            let condition = condition.clone();
            rows.iter().map(move |row| {
                let values = names.iter().zip(row).map(|(name, varied)| (name.clone(), varied.label.clone()));
                condition.iter().cloned().chain(values).collect::<Vec<_>>()
            })
        };
        all = all.iter().flat_map(add).collect();
        if all.len() > 100_000 {
            return Some(all);
        }
    }
    Some(all)
}
