//! `statement`: what a source says, held against the results of the suite.

use serde::Serialize;

use super::{ExperimentError, Laboratory, Results, evaluate};
use crate::judge::cut_off_runs;
use crate::plan::variables;
use crate::run::Outcome;
use crate::scenario::{
    Assignment, BinaryOperator, Measured, OutcomesOf, Quantity, Relation, Standing, Statement,
    StatementClaim, StatementClaimKind, TrendDirection, Value,
};

/// What a statement came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StatementResult {
    pub name: String,
    /// What the source says.
    pub doc: Option<String>,
    pub source: Option<String>,
    /// The numbers that the source gives, in words.
    pub reported: Option<String>,
    pub conclusion: Conclusion,
    pub claims: Vec<ClaimResult>,
    /// What the suite declares to be known of it.
    pub standing: Standing,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Conclusion {
    /// Every claim holds.
    Reproduced,
    /// At least one does not.
    NotReproduced,
    /// None is known not to hold, but not all can be looked at: the reason.
    NotComparable(String),
}

/// One claim with the numbers that decide it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClaimResult {
    /// In canonical words.
    pub text: String,
    /// `None` if that cannot be said.
    pub holds: Option<bool>,
    /// Why it cannot be said.
    pub undefined: Option<String>,
    pub values: ClaimValues,
    /// SI unit of the values; `%` says that they are shares in 0..1.
    pub unit: String,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ClaimValues {
    Compared { left: Option<f64>, relation: Relation, right: Option<f64> },
    Trend { direction: TrendDirection, variable: String, points: Vec<TrendPoint> },
}

/// The aggregate at one value of the variation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrendPoint {
    pub label: String,
    pub at: f64,
    /// `None` where no run gives one.
    pub value: Option<f64>,
    pub runs: usize,
}

impl StatementResult {
    /// Why the run fails: the results say otherwise than the statement's declared standing.
    pub fn surprise(&self) -> Option<String> {
        match (&self.standing, &self.conclusion) {
            (Standing::Reproduced, Conclusion::Reproduced)
            | (Standing::Differs(_), Conclusion::NotReproduced)
            | (Standing::NotComparable(_), _) => None,
            (Standing::Reproduced, Conclusion::NotReproduced) => Some("is not reproduced".to_string()),
            (Standing::Reproduced, Conclusion::NotComparable(reason)) => {
                Some(format!("is not comparable: {reason}"))
            }
            (Standing::Differs(reason), Conclusion::Reproduced) => Some(format!(
                "is reproduced, though declared to differ ({reason}): revise the reason or take it out"
            )),
            (Standing::Differs(_), Conclusion::NotComparable(reason)) => {
                Some(format!("is not comparable, though declared to differ: {reason}"))
            }
        }
    }
}

/// Looks at one statement. `results` holds everything that it names.
///
/// # Errors
/// Something that it names was not run; numbers that do not exist are not errors but make it not comparable.
pub fn run_statement(
    laboratory: &Laboratory,
    statement: &Statement,
    results: &Results,
) -> Result<StatementResult, ExperimentError> {
    let court = Court { laboratory, results };
    let claims: Vec<ClaimResult> =
        statement.claims.iter().map(|claim| court.claim(claim)).collect::<Result<_, _>>()?;
    let conclusion = match &statement.standing {
        Standing::NotComparable(reason) => Conclusion::NotComparable(reason.clone()),
        _ if claims.iter().any(|claim| claim.holds == Some(false)) => Conclusion::NotReproduced,
        _ => match claims.iter().find_map(|claim| claim.undefined.clone()) {
            Some(reason) => Conclusion::NotComparable(reason),
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

/// Every aggregate that a statement asks for.
pub(super) fn measured(statement: &Statement) -> Vec<&Measured> {
    statement.claims.iter().flat_map(measured_by).collect()
}

fn measured_by(claim: &StatementClaim) -> Vec<&Measured> {
    match &claim.kind {
        StatementClaimKind::Trend { measured, .. } => vec![measured],
        StatementClaimKind::Compares { left, right, .. } => {
            let leaves = leaves(left).into_iter().chain(leaves(right));
            let measured = leaves.filter_map(|quantity| match quantity {
                Quantity::Measured(measured) => Some(measured),
                _ => None,
            });
            measured.collect()
        }
    }
}

/// Every tune whose choice a statement asks for.
pub(super) fn tunes(statement: &Statement) -> Vec<&str> {
    let mut found = Vec::new();
    for claim in &statement.claims {
        if let StatementClaimKind::Compares { left, right, .. } = &claim.kind {
            for quantity in leaves(left).into_iter().chain(leaves(right)) {
                if let Quantity::Chosen { tune, .. } = quantity {
                    found.push(tune.as_str());
                }
            }
        }
    }
    found
}

fn leaves(quantity: &Quantity) -> Vec<&Quantity> {
    match quantity {
        Quantity::Binary { left, right, .. } => [leaves(left), leaves(right)].concat(),
        leaf => vec![leaf],
    }
}

/// Where claims are held against results.
struct Court<'a> {
    laboratory: &'a Laboratory<'a>,
    results: &'a Results,
}

/// A number with its unit, which plain numbers take from what they are compared with; or why there is none.
struct Operand {
    value: Result<f64, String>,
    unit: Option<String>,
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
                let holds = left.value.and_then(|left| Ok(relation.holds(left, right.value?)));
                (holds, values, unit)
            }
            StatementClaimKind::Trend { measured, direction, variable } => {
                let (holds, points) = match self.runs(measured)? {
                    Ok(runs) => {
                        let points = self.points(measured, variable, &runs);
                        (follows(*direction, &points, variable, measured), points)
                    }
                    Err(reason) => (Err(reason), Vec::new()),
                };
                let values = ClaimValues::Trend { direction: *direction, variable: variable.clone(), points };
                (holds, values, measured.aggregate.unit())
            }
        };
        let holds = match (holds, self.cut_off(claim)?) {
            (Ok(true), Some(reason)) => Err(reason),
            (holds, _) => holds,
        };
        Ok(ClaimResult {
            text: claim.text.clone(),
            holds: holds.as_ref().ok().copied(),
            undefined: holds.err(),
            values,
            unit,
        })
    }

    /// Of how many runs that a claim rests on the end was not seen, in words; `None` if of all.
    fn cut_off(&self, claim: &StatementClaim) -> Result<Option<String>, ExperimentError> {
        for measured in measured_by(claim) {
            let Ok(runs) = self.runs(measured)? else { continue };
            let outcomes = runs.iter().map(|(_, outcome)| *outcome);
            let cut_off = cut_off_runs(measured.aggregate.metric(), outcomes);
            if cut_off > 0 {
                let (of, all) = (name_of(&measured.of), runs.len());
                let reason =
                    format!("{cut_off} of {all} runs of {of} were cut off before the encounter was over");
                return Ok(Some(reason));
            }
        }
        Ok(None)
    }

    fn quantity(&self, quantity: &Quantity) -> Result<Operand, ExperimentError> {
        Ok(match quantity {
            Quantity::Number(number) => Operand { value: Ok(*number), unit: None },
            Quantity::Measured(measured) => {
                let value = self.runs(measured)?.and_then(|runs| self.value(measured, &runs));
                Operand { value, unit: Some(measured.aggregate.unit()) }
            }
            Quantity::Chosen { tune, target } => {
                let result = self.results.tune(tune)?;
                let parameter = target.to_string();
                let place = result.parameters.iter().position(|name| *name == parameter);
                let value = match (&result.chosen, place) {
                    (None, _) => Err(format!("tune `{tune}` chose nothing")),
                    (_, None) => Err(format!("tune `{tune}` does not tune `{parameter}`")),
                    (Some(chosen), Some(place)) => chosen.point[place]
                        .number()
                        .ok_or_else(|| format!("`{parameter}` of `{tune}` is not a number")),
                };
                let declared = self.laboratory.suite.tunes.iter().find(|one| one.name == *tune);
                let range = declared.and_then(|tune| tune.over.iter().find(|range| range.target == *target));
                Operand { value, unit: range.map(|range| range.unit.clone()) }
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
        evaluate::measured(&measured.aggregate, &outcomes, &self.laboratory.requests).ok_or_else(|| {
            let of = name_of(&measured.of);
            if runs.is_empty() {
                return format!("no run of {of} is asked about");
            }
            let metric = measured.aggregate.metric().label();
            format!("`{metric}` exists in too few of the {} runs of {of}", runs.len())
        })
    }

    /// The aggregate at every value of a variation, in ascending order.
    fn points(&self, measured: &Measured, variable: &str, runs: &Runs) -> Vec<TrendPoint> {
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
        let point = |(at, label, runs): (f64, String, Runs)| TrendPoint {
            label,
            at,
            value: self.value(measured, &runs).ok(),
            runs: runs.len(),
        };
        groups.into_iter().map(point).collect()
    }
}

/// Whether the values never move the other way and end beyond where they began.
fn follows(
    direction: TrendDirection,
    points: &[TrendPoint],
    variable: &str,
    measured: &Measured,
) -> Result<bool, String> {
    let of = name_of(&measured.of);
    if points.len() < 2 {
        return Err(format!("{of} has {} values of {variable}; a trend needs two", points.len()));
    }
    let sign = match direction {
        TrendDirection::Rises => 1.0,
        TrendDirection::Falls => -1.0,
    };
    let mut values = Vec::with_capacity(points.len());
    for point in points {
        let missing = || {
            let metric = measured.aggregate.metric().label();
            let at = format!("{variable} {}", point.label);
            format!("`{metric}` exists in too few of the {} runs of {of} at {at}", point.runs)
        };
        values.push(sign * point.value.ok_or_else(missing)?);
    }
    let steady = values.windows(2).all(|pair| pair[1] >= pair[0]);
    Ok(steady && values[values.len() - 1] > values[0])
}

fn combine(operator: BinaryOperator, left: Operand, right: Operand) -> Operand {
    let unit = match operator {
        BinaryOperator::Add | BinaryOperator::Subtract => left.unit.or(right.unit),
        BinaryOperator::Multiply => match (left.unit, right.unit) {
            (None, unit) | (unit, None) => unit,
            (Some(left), Some(right)) => Some([left, right].join(" ").trim().to_string()),
        },
        BinaryOperator::Divide => match (left.unit, right.unit) {
            (unit, None) => unit,
            (Some(left), Some(right)) if left == right => Some(String::new()),
            (left, Some(right)) => Some(format!("{}/{right}", left.unwrap_or_else(|| "1".to_string()))),
        },
    };
    let value = left.value.and_then(|left| {
        let right = right.value?;
        let value = match operator {
            BinaryOperator::Add => left + right,
            BinaryOperator::Subtract => left - right,
            BinaryOperator::Multiply => left * right,
            BinaryOperator::Divide => left / right,
        };
        if value.is_finite() { Ok(value) } else { Err("a division by 0".to_string()) }
    });
    Operand { value, unit }
}

/// As a claim would say it.
fn name_of(of: &OutcomesOf) -> String {
    match of {
        OutcomesOf::Scenario(name) | OutcomesOf::Search(name) => format!("`{name}`"),
        OutcomesOf::Condition { evaluate, condition } => format!("`{evaluate}.{condition}`"),
    }
}
