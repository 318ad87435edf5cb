//! `keep pet < 1.5 s and plausibility >= 5 %` of a search

use super::comparison::{bound_in, constant_comparison};
use super::criterion;
use super::metric::Cast;
use super::subject::StatementSubject;
use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::syntax::ast;
use crate::value::NameScope;
use scenario::population::SHIPPED_MODEL;
use scenario::{DeclaredPedestrian, Keep, Part, Relation, Scenario, SearchRange, Target};

/// What is asked of an encounter, not of somebody in it.
const PLAUSIBILITY: &str = "plausibility";

/// What a search keeps; `people` is whether it brings people of a population.
pub fn keep(
    node: ast::Keep,
    (subject, cast, scope): (&StatementSubject, &Cast, &NameScope),
    over: Option<&[SearchRange]>,
    people: bool,
    report: &mut Vec<Diagnostic>,
) -> Option<Vec<Keep>> {
    let each = node.each().map(|one| {
        if !asks_for_plausibility(one.condition()) {
            let said = (one.condition(), one.undefined(), "the bound of this comparison");
            let comparison = constant_comparison(said, cast, scope, report)?;
            return Some(Keep::Metric { comparison, written_in: bound_in(one.condition(), scope) });
        }
        let (relation, bound) = plausibility(one, scope, report)?;
        is_declared(one.span(), subject.scenario, over?, people, report)?;
        Some(Keep::Plausibility { relation, bound })
    });
    each.collect::<Vec<_>>().into_iter().collect()
}

/// `plausibility(population: standard)` and `plausibility(walker)` are of a person.
fn asks_for_plausibility(condition: ast::Condition) -> bool {
    let metric = condition.metric();
    metric.name().text() == PLAUSIBILITY && metric.details().is_none() && !condition.is_negative()
}

fn plausibility(
    node: ast::Constraint,
    scope: &NameScope,
    report: &mut Vec<Diagnostic>,
) -> Option<(Relation, f64)> {
    let condition = node.condition();
    let mut wrong = |span: Span, message: &str, label: &str, hint: &str| {
        report.push(Diagnostic::new(Code::MissingComparison, span, message).label(label).hint(hint));
        None
    };
    if let Some(undefined) = node.undefined() {
        return wrong(
            undefined.span(),
            "an encounter of which nobody knows how usual it is is not kept",
            "not for a plausibility",
            "leave it out; reports say how many there are",
        );
    }
    let relation = condition.relation().map(ast::Relation::meaning);
    let (Some(relation), Some(bound)) = (relation, condition.bound()) else {
        return wrong(
            condition.span(),
            "how plausible an encounter must be is missing",
            "no comparison",
            "write `plausibility >= 5 %`",
        );
    };
    if matches!(relation, Relation::Equal | Relation::NotEqual) {
        return wrong(
            condition.span(),
            "no encounter is exactly so plausible",
            "not `>=` or `<=`",
            "write `plausibility >= 5 %`",
        );
    }
    Some((relation, criterion::share(bound, "the plausibility", false, scope, report)?))
}

/// Whether it is declared how all that the search chooses of an encounter is distributed.
fn is_declared(
    span: Span,
    scenario: &Scenario,
    over: &[SearchRange],
    people: bool,
    report: &mut Vec<Diagnostic>,
) -> Option<()> {
    let mut unknown = |message: String, label: &str, hint: String| {
        report.push(Diagnostic::new(Code::NothingDeclared, span, message).label(label).hint(hint));
        None
    };
    let drawn = |name: &String| scenario.draws.iter().any(|draw| draw.names.contains(name));
    let is_known =
        |person: &DeclaredPedestrian| person.model.all().iter().all(|model| model.name() == SHIPPED_MODEL);
    for range in over {
        match &range.target {
            Target::Variation(name) if !drawn(name) => {
                return unknown(
                    format!("nothing says how `{name}` is distributed, which the search chooses"),
                    "an encounter may be as unusual as it likes",
                    format!(
                        "let `{}` draw it: `draw {name} from normal(…)`; of the person alone, `plausibility(population: humans)` speaks",
                        scenario.name
                    ),
                );
            }
            Target::Setting { road_user, part: Part::Model, parameter } => {
                let mut people = scenario.pedestrians.iter().filter(|person| person.is(road_user));
                if !people.all(|person| person.individuals.is_some() || is_known(person)) {
                    return unknown(
                        format!(
                            "nothing says how `{parameter}` of `{road_user}` is distributed, which the search chooses"
                        ),
                        "an encounter may be as unusual as it likes",
                        format!(
                            "draw it in `{}`: `draw x from normal(…)` and `{parameter}: x`, and search over `x`",
                            scenario.name
                        ),
                    );
                }
            }
            Target::Variation(_) | Target::Setting { .. } => {}
        }
    }
    let chooses_people =
        over.iter().any(|one| matches!(one.target, Target::Setting { part: Part::Model, .. }));
    let of_population = scenario.pedestrians.iter().any(|person| person.individuals.is_some());
    if scenario.draws.is_empty() && !of_population && !people && !chooses_people {
        return unknown(
            format!("nothing says how encounters of `{}` are distributed", scenario.name),
            "every one would be as plausible as any other",
            "let it `draw x from normal(…)` or take `individuals drawn from humans`".to_string(),
        );
    }
    Some(())
}
