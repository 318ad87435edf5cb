//! The cells of a rating: which scenarios have its tags, and that of each of their cells one table of weights speaks.

use std::collections::{BTreeMap, HashMap};

use super::criterion::{self, From};
use super::places::TextPlaces;
use super::scenario::surroundings;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::ast;
use crate::texts::NameDefinition;
use crate::value::NameScope;
use scenario::{Scenario, TagPoints, Value, Variation, VariationCondition, VariedValue};

/// More combinations of the values that weights are about are not looked at before a run.
const MOST_ROWS: usize = 100_000;

/// Cells that are named where no weights are about them.
const MOST_NAMED: usize = 4;

/// The scenarios of a suite.
pub struct RatedScenarios<'a> {
    pub scenarios: &'a [Scenario],
    pub definitions: &'a [NameDefinition],
    /// Whether all of them are there: of a scenario with a mistake nobody knows tags and cells.
    pub complete: bool,
}

impl<'a> RatedScenarios<'a> {
    /// Those with a tag that earns points.
    fn of(&self, points: &'a [(Span, TagPoints)]) -> impl Iterator<Item = &'a Scenario> {
        let earns = |scenario: &&Scenario| points.iter().any(|(_, one)| scenario.tags.contains(&one.tag));
        self.scenarios.iter().filter(earns)
    }

    fn definition(&self, scenario: &Scenario, places: &TextPlaces) -> Option<NameDefinition> {
        let is_its_own = |one: &&NameDefinition| places.files.scenario(**one).name().text() == scenario.name;
        self.definitions.iter().find(is_its_own).copied()
    }
}

/// That every tag has scenarios, and no scenario two tags or a number of runs that depends on results.
pub fn tags(
    points: &[(Span, TagPoints)],
    rated: &RatedScenarios,
    report: &mut Vec<Diagnostic>,
) -> Option<()> {
    reject_tag_twice(points, report)?;
    if !rated.complete {
        return None;
    }
    let before = report.len();
    for (span, one) in points {
        if !rated.scenarios.iter().any(|scenario| scenario.tags.contains(&one.tag)) {
            let known = rated.scenarios.iter().flat_map(|scenario| &scenario.tags).map(String::as_str);
            report.push(
                Diagnostic::new(
                    Code::NoSuchTag,
                    *span,
                    format!("no scenario of the suite has the tag `{}`", one.tag),
                )
                .label("no cells")
                .suggest(&one.tag, known),
            );
        }
    }
    for scenario in rated.of(points) {
        let mut own = points.iter().filter(|(_, one)| scenario.tags.contains(&one.tag));
        if let (Some((first, one)), Some((second, other))) = (own.next(), own.next()) {
            let message = format!(
                "`{}` has the tags `{}` and `{}`, and earns points once",
                scenario.name, one.tag, other.tag
            );
            report.push(
                Diagnostic::new(Code::BadRating, *second, message)
                    .label("would count its cells again")
                    .context(*first, "counts them here")
                    .hint("give the points to one of the tags, or the scenarios tags of their own"),
            );
        }
        if scenario.runs.is_some() {
            let (span, _) = points.iter().find(|(_, one)| scenario.tags.contains(&one.tag))?;
            let message = format!("how many runs `{}` has depends on what they come to", scenario.name);
            report.push(
                Diagnostic::new(Code::BadRating, *span, message)
                    .label("has `runs`")
                    .note("the worst run of a cell counts, and fewer runs have a better worst one")
                    .hint("say `repeat` in that scenario: a cell has as many runs as another"),
            );
        }
    }
    (report.len() == before).then_some(())
}

/// Which cells each table of weights is about; `None` in place of one that is about none.
pub fn conditions(
    rating: Span,
    nodes: &[ast::Weights],
    points: &[(Span, TagPoints)],
    rated: &RatedScenarios,
    scope: &NameScope,
    places: &TextPlaces,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<Option<Vec<VariationCondition>>>> {
    let before = report.len();
    let otherwise = !places.files.overrides.is_empty();
    let mut found: Vec<Option<Vec<VariationCondition>>> = vec![None; nodes.len()];
    for scenario in rated.of(points) {
        let varied = surroundings(rated.definition(scenario, places)?, places)?;
        let varied = NameScope { outer: Some(scope), names: varied, member: None };
        let mut own: Vec<Option<Vec<VariationCondition>>> = Vec::new();
        for node in nodes {
            let conditions = node.when().into_iter().flat_map(ast::When::conditions);
            let mut wrong = Vec::new();
            let when: Vec<_> = conditions
                .map(|condition| criterion::when_condition(condition, From::Suite, &varied, &mut wrong))
                .collect();
            // What is wrong with a condition would be said of every scenario.
            if report.len() == before {
                report.append(&mut wrong);
            }
            own.push(when.into_iter().collect());
        }
        if report.len() > before {
            return None;
        }
        // The runs that values from outside make are not those of the rating, which is then not judged.
        if !otherwise {
            cover(rating, scenario, nodes, &own, report);
        }
        for (known, own) in found.iter_mut().zip(own) {
            if known.is_none() {
                *known = own;
            }
        }
    }
    for (node, when) in nodes.iter().zip(&found) {
        if when.is_none() && !otherwise {
            report.push(
                Diagnostic::new(
                    Code::BadWeights,
                    node.span(),
                    "these weights are about no cell of the rating",
                )
                .label("never count")
                .hint("`when` must be about something that a scenario with one of its tags varies"),
            );
        }
    }
    (report.len() == before).then_some(found)
}

/// That one table speaks of every cell of a scenario, and no second one.
fn cover(
    rating: Span,
    scenario: &Scenario,
    nodes: &[ast::Weights],
    tables: &[Option<Vec<VariationCondition>>],
    report: &mut Vec<Diagnostic>,
) {
    let about = tables.iter().flatten().flatten();
    let names: Vec<&str> = about.map(|condition| condition.variable.as_str()).collect();
    let Some(rows) = rows(rating, scenario, &names, report) else { return };
    let mut without: Vec<String> = Vec::new();
    for row in rows {
        let values: BTreeMap<String, Value> =
            row.iter().map(|(name, varied)| (name.to_string(), varied.value.clone())).collect();
        let speaks = |table: &Option<Vec<VariationCondition>>| {
            table.as_ref().is_some_and(|all| all.iter().all(|one| one.holds(&values) == Ok(true)))
        };
        let words: Vec<String> =
            row.iter().map(|(name, varied)| format!("{name} = {}", varied.label)).collect();
        let mut speaking = tables.iter().zip(nodes).filter(|(table, _)| speaks(table)).map(|(_, node)| node);
        match (speaking.next(), speaking.next()) {
            (None, _) => without.push(words.join(" and ")),
            (Some(first), Some(second)) => {
                let cell = [vec![format!("`{}`", scenario.name)], words].concat().join(" with ");
                report.push(
                    Diagnostic::new(
                        Code::BadWeights,
                        second.span(),
                        format!("two tables of weights are about {cell}"),
                    )
                    .label("the second")
                    .context(first.span(), "the first")
                    .hint("let one `when` leave out what the other is about"),
                );
                return;
            }
            _ => {}
        }
    }
    if let Some(first) = without.first() {
        let shown = without.iter().take(MOST_NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = match without.len().saturating_sub(MOST_NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let (with, hint) = match first.is_empty() {
            true => (String::new(), "add `weights { … }` without `when`".to_string()),
            false => (format!(" with {shown}{more}"), format!("add `weights when {first} {{ … }}`")),
        };
        report.push(
            Diagnostic::new(
                Code::BadWeights,
                rating,
                format!("no weights are about `{}`{with}", scenario.name),
            )
            .label("a cell without weights has no points")
            .hint(hint),
        );
    }
}

type Row<'s> = Vec<(&'s str, &'s VariedValue)>;

/// Every combination of values of those variations that take part in what weights are about.
fn rows<'s>(
    rating: Span,
    scenario: &'s Scenario,
    names: &[&str],
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<Row<'s>>> {
    let mut rows: Vec<Row> = vec![Vec::new()];
    for variation in &scenario.variations {
        let own: Vec<usize> = (0..variation.names().len())
            .filter(|index| names.contains(&variation.names()[*index].as_str()))
            .collect();
        if own.is_empty() {
            continue;
        }
        let Variation::Grid { names, rows: values } = variation else {
            let name = &variation.names()[own[0]];
            report.push(
                Diagnostic::new(
                    Code::BadWeights,
                    rating,
                    format!("`{}` draws `{name}`, which weights are about", scenario.name),
                )
                .label("its cells have no known values")
                .hint(format!("list the values: `vary {name} in [ … ]`")),
            );
            return None;
        };
        if rows.len().saturating_mul(values.len()) > MOST_ROWS {
            return None;
        }
        let joined = rows.iter().flat_map(|row| {
            values.iter().map(|value| {
                let added = own.iter().map(|index| (names[*index].as_str(), &value[*index]));
                row.iter().copied().chain(added).collect::<Row>()
            })
        });
        rows = joined.collect();
    }
    Some(rows)
}

/// Reports a tag that earns points twice.
fn reject_tag_twice(points: &[(Span, TagPoints)], report: &mut Vec<Diagnostic>) -> Option<()> {
    let mut seen: HashMap<&str, Span> = HashMap::new();
    let before = report.len();
    for (span, one) in points {
        if let Some(first) = seen.insert(&one.tag, *span) {
            report.push(
                Diagnostic::new(Code::BadRating, *span, format!("`{}` earns points twice", one.tag))
                    .label("said again")
                    .context(first, "said first here")
                    .hint("remove one of them"),
            );
        }
    }
    (report.len() == before).then_some(())
}
