//! `statement`: what a source says, held against the results of the suite.

use super::claim::{Operand, combine, follows, in_words, name_of};
use super::context::Context;
use super::earlier::EarlierResults;
use super::error::ExperimentError;
use super::evaluate;
use super::needs::measured_by;
use crate::plan::variables;
use optimise::Coordinate;
use results::judge::{ValueSpan, open_runs, untested_by};
use results::{ClaimResult, ClaimValues, Conclusion, Outcome, StatementResult, TrendPoint, Untested};
use scenario::{
    Assignment, DeclaredStanding, Measured, OutcomesOf, Quantity, Statement, StatementClaim,
    StatementClaimKind, Value, significant,
};

/// Looks at one statement. `results` holds everything that it names.
///
/// # Errors
/// Something that it names was not run; numbers that do not exist are not errors but make it not comparable.
pub fn run_statement(
    context: &Context,
    statement: &Statement,
    results: &EarlierResults,
) -> Result<StatementResult, ExperimentError> {
    let court = Court { context, results };
    let claims: Vec<ClaimResult> =
        statement.claims.iter().map(|claim| court.claim(claim)).collect::<Result<_, _>>()?;
    let conclusion = match &statement.standing {
        DeclaredStanding::NotComparable(reason) => Conclusion::NotComparable(reason.clone()),
        _ if claims.iter().any(|claim| claim.holds == Some(false)) => Conclusion::NotReproduced,
        _ => match claims.iter().find_map(|claim| claim.undefined.clone()) {
            Some(reason) => Conclusion::NotComparable(reason),
            None if claims.iter().any(|claim| claim.untested.is_some()) => Conclusion::Untested,
            None => Conclusion::Reproduced,
        },
    };
    Ok(StatementResult {
        name: statement.name.clone(),
        doc: statement.doc.clone(),
        source: statement.source.clone(),
        reported: statement.reported.clone(),
        conclusion,
        claims,
        standing: statement.standing.clone(),
    })
}

/// Where claims are held against results.
struct Court<'a> {
    context: &'a Context<'a>,
    results: &'a EarlierResults,
}

/// Outcomes with the values of their variations.
type Runs<'a> = Vec<(&'a [Assignment], &'a Outcome)>;

impl Court<'_> {
    fn claim(&self, claim: &StatementClaim) -> Result<ClaimResult, ExperimentError> {
        let (holds, values, unit) = match &claim.kind {
            StatementClaimKind::Compares { left, relation, right } => {
                let (left, right) = (self.quantity(left)?, self.quantity(right)?);
                let unit = left.unit.or(right.unit).unwrap_or_default();
                let values = ClaimValues::Compared {
                    left: left.value.clone().ok(),
                    relation: *relation,
                    right: right.value.clone().ok(),
                };
                let holds = left.span.and_then(|left| Ok(left.holds(*relation, right.span?)));
                (holds, values, unit)
            }
            StatementClaimKind::Trend { measured, direction, variable } => {
                let (holds, points) = match self.runs(measured)? {
                    Ok(runs) => {
                        let (points, spans) = self.points(measured, variable, &runs);
                        (follows(*direction, &points, &spans, variable, measured), points)
                    }
                    Err(reason) => (Err(reason), Vec::new()),
                };
                let values = ClaimValues::Trend { direction: *direction, variable: variable.clone(), points };
                (holds, values, measured.aggregate.unit())
            }
        };
        let holds = match holds {
            Ok(Some(holds)) => Ok(holds),
            Ok(None) => Err(self.cut_off(claim)?),
            Err(reason) => Err(reason),
        };
        let untested = if holds == Ok(true) { self.untested(claim)? } else { None };
        Ok(ClaimResult {
            text: claim.text.clone(),
            untested,
            holds: holds.as_ref().ok().copied(),
            undefined: holds.err(),
            values,
            unit,
        })
    }

    /// Why nothing was at stake in the runs that a claim measures.
    fn untested(&self, claim: &StatementClaim) -> Result<Option<Untested>, ExperimentError> {
        for measured in measured_by(claim) {
            let Ok(runs) = self.runs(measured)? else { continue };
            let outcomes: Vec<&Outcome> = runs.iter().map(|(_, outcome)| *outcome).collect();
            let why = untested_by(measured.aggregate.metric(), &outcomes, self.context.requests());
            if why.is_some() {
                return Ok(why);
            }
        }
        Ok(None)
    }

    /// Of how many runs that a claim rests on the end was not seen, when they ended and what that leaves open, in words.
    fn cut_off(&self, claim: &StatementClaim) -> Result<String, ExperimentError> {
        let mut said = Vec::new();
        for measured in measured_by(claim) {
            let Ok(runs) = self.runs(measured)? else { continue };
            let outcomes: Vec<Outcome> = runs.iter().map(|(_, outcome)| (*outcome).clone()).collect();
            let requests = self.context.requests();
            let open = open_runs(measured.aggregate.metric(), &outcomes, requests);
            let times = ValueSpan::around(open.iter().map(|outcome| outcome.ending.time));
            if open.is_empty() {
                continue;
            }
            let seconds = |time| significant(time, 4);
            let when = match times {
                ValueSpan { low, high } if low == high => format!("at {} s", seconds(low)),
                ValueSpan { low, high } => format!("at {} s to {} s", seconds(low), seconds(high)),
            };
            let (cut_off, all, of) = (open.len(), runs.len(), name_of(&measured.of));
            let reason = format!("{cut_off} of {all} runs of {of} were cut off {when}");
            let span = evaluate::measured_between(&measured.aggregate, &outcomes, requests);
            said.push(match (&claim.kind, span) {
                (StatementClaimKind::Compares { .. }, Some(span)) => {
                    format!("{reason}, which leaves {}", in_words(span, &measured.aggregate.unit()))
                }
                _ => reason,
            });
        }
        said.dedup();
        Ok(said.join("; "))
    }

    fn quantity(&self, quantity: &Quantity) -> Result<Operand, ExperimentError> {
        Ok(match quantity {
            Quantity::Number(number) => Operand::known(Ok(*number), None),
            Quantity::Measured(measured) => {
                let runs = self.runs(measured)?;
                let value = runs.as_ref().map_err(String::clone).and_then(|runs| self.value(measured, runs));
                let span = runs.and_then(|runs| self.span(measured, &runs));
                Operand { value, span, unit: Some(measured.aggregate.unit()) }
            }
            Quantity::Chosen { tune, target } => {
                let result = self.results.tune(tune)?;
                let parameter = target.to_string();
                let place = result.parameters.iter().position(|name| *name == parameter);
                let value = match (&result.chosen, place) {
                    (None, _) => Err(format!("tune `{tune}` chose nothing")),
                    (_, None) => Err(format!("tune `{tune}` does not tune `{parameter}`")),
                    (Some(chosen), Some(place)) => chosen
                        .point
                        .get(place)
                        .and_then(Coordinate::number)
                        .ok_or_else(|| format!("`{parameter}` of `{tune}` is not one number")),
                };
                let declared = self.context.suite.tunes.iter().find(|one| one.name == *tune);
                let range = declared.and_then(|tune| tune.over.iter().find(|range| range.target == *target));
                Operand::known(value, range.map(|range| range.unit.clone()))
            }
            Quantity::Binary { operator, left, right } => {
                combine(*operator, self.quantity(left)?, self.quantity(right)?)
            }
        })
    }

    /// The runs that an aggregate is over, or why there are none.
    fn runs<'r>(&'r self, measured: &Measured) -> Result<Result<Runs<'r>, String>, ExperimentError> {
        let all: Runs = match &measured.of {
            OutcomesOf::Scenario(name) => {
                let runs = self.results.scenarios.get(name);
                let runs = runs.ok_or_else(|| ExperimentError::NotRun(name.clone()))?;
                runs.iter().map(|(case, outcome)| (case.variation.as_slice(), outcome)).collect()
            }
            OutcomesOf::Search(name) => {
                let runs = self.results.search(name)?.found.iter().flat_map(|one| &one.runs);
                runs.map(|run| (run.case.variation.as_slice(), &run.outcome)).collect()
            }
            OutcomesOf::Condition { evaluate, condition } => {
                let conditions = &self.results.evaluate(evaluate)?.conditions;
                let found = conditions.iter().find(|one| one.name == *condition);
                let found =
                    found.ok_or_else(|| ExperimentError::NotRun(format!("{evaluate}.{condition}")))?;
                if let Some(reason) = &found.missing {
                    return Ok(Err(reason.clone()));
                }
                found.runs.iter().map(|run| (run.case.variation.as_slice(), &run.outcome)).collect()
            }
        };
        let mut kept = Vec::with_capacity(all.len());
        for (variation, outcome) in all {
            let variables = variables(variation);
            let mut applies = true;
            for condition in &measured.when {
                match condition.holds(&variables) {
                    Ok(holds) => applies &= holds,
                    Err(error) => return Ok(Err(format!("{}: {error}", name_of(&measured.of)))),
                }
            }
            if applies {
                kept.push((variation, outcome));
            }
        }
        Ok(Ok(kept))
    }

    fn value(&self, measured: &Measured, runs: &Runs) -> Result<f64, String> {
        let outcomes: Vec<Outcome> = runs.iter().map(|(_, outcome)| (*outcome).clone()).collect();
        let value = evaluate::measured(&measured.aggregate, &outcomes, self.context.requests());
        value.ok_or_else(|| too_few(measured, runs))
    }

    /// Between what the runs that were cut off could still have made of it.
    fn span(&self, measured: &Measured, runs: &Runs) -> Result<ValueSpan, String> {
        let outcomes: Vec<Outcome> = runs.iter().map(|(_, outcome)| (*outcome).clone()).collect();
        let span = evaluate::measured_between(&measured.aggregate, &outcomes, self.context.requests());
        span.ok_or_else(|| too_few(measured, runs))
    }

    /// The aggregate at every value of a variation, in ascending order.
    fn points(
        &self,
        measured: &Measured,
        variable: &str,
        runs: &Runs,
    ) -> (Vec<TrendPoint>, Vec<Option<ValueSpan>>) {
        let mut groups: Vec<(f64, String, Runs)> = Vec::new();
        for (variation, outcome) in runs {
            let assigned = variation.iter().find(|assignment| assignment.name == variable);
            let Some((Value::Number(at), label)) = assigned.map(|one| (&one.value, &one.label)) else {
                continue;
            };
            match groups.iter_mut().find(|group| group.0 == *at) {
                Some(group) => group.2.push((*variation, *outcome)),
                None => groups.push((*at, label.clone(), vec![(*variation, *outcome)])),
            }
        }
        groups.sort_by(|left, right| left.0.total_cmp(&right.0));
        let spans = groups.iter().map(|(_, _, runs)| self.span(measured, runs).ok()).collect();
        let point = |(at, label, runs): (f64, String, Runs)| TrendPoint {
            label,
            at,
            value: self.value(measured, &runs).ok(),
            runs: runs.len(),
        };
        (groups.into_iter().map(point).collect(), spans)
    }
}

fn too_few(measured: &Measured, runs: &Runs) -> String {
    let of = name_of(&measured.of);
    if runs.is_empty() {
        return format!("no run of {of} is asked about");
    }
    let metric = measured.aggregate.metric().label();
    format!("`{metric}` exists in too few of the {} runs of {of}", runs.len())
}
