//! A block's fingerprint: a number that changes when any bit of what it measured changes.
//!
//! It covers what was simulated and what was found by it, not the words in which a report says so. Metrics that are
//! only summed up for tables stay out, so that a new metric leaves it alone.

use sha2::{Digest, Sha256};

use crate::numbers::random::digest_bits;
use crate::optimise::Value;
use crate::results::{
    BlockResult, Candidate, CaseRun, ClaimResult, ClaimValues, ConditionResult, Course, CoursePoint,
    EvaluateResult, Found, SearchResult, StatementResult, TuneResult,
};

impl BlockResult {
    /// The first eight bytes of SHA-256 over everything that the block measured.
    pub fn fingerprint(&self) -> u64 {
        let mut mixture = Mixture(Sha256::new());
        match self {
            Self::Search(search) => mixture.search(search),
            Self::Tune(tune) => mixture.tune(tune),
            Self::Evaluate(evaluate) => mixture.evaluate(evaluate),
            Self::Statement(statement) => mixture.statement(statement),
        }
        digest_bits(mixture.0)
    }
}

struct Mixture(Sha256);

impl Mixture {
    fn bits(&mut self, bits: u64) {
        self.0.update(bits.to_le_bytes());
    }

    fn count(&mut self, count: usize) {
        self.bits(count as u64);
    }

    fn number(&mut self, number: f64) {
        self.bits(number.to_bits());
    }

    fn numbers(&mut self, numbers: &[Option<f64>]) {
        self.count(numbers.len());
        numbers.iter().for_each(|number| self.perhaps(*number));
    }

    fn perhaps(&mut self, number: Option<f64>) {
        self.bits(u64::from(number.is_some()));
        self.number(number.unwrap_or(0.0));
    }

    fn point(&mut self, point: &[Value]) {
        self.count(point.len());
        for value in point {
            match value {
                Value::Integer(integer) => self.bits(integer.cast_unsigned()),
                Value::Real(real) => self.number(*real),
                Value::Category(word) => self.0.update(word),
            }
        }
    }

    fn runs(&mut self, runs: &[CaseRun]) {
        self.count(runs.len());
        for run in runs {
            self.bits(run.case.seed);
            self.bits(run.outcome.fingerprint);
        }
    }

    fn search(&mut self, search: &SearchResult) {
        self.count(search.found.len());
        search.found.iter().for_each(|found| self.found(found));
    }

    fn found(&mut self, found: &Found) {
        for individual in &found.individuals {
            self.bits(individual.number.into());
        }
        self.count(found.evaluations.len());
        for (point, objective) in &found.evaluations {
            self.point(point);
            self.perhaps(*objective);
        }
        self.perhaps(found.observed);
        self.perhaps(found.fresh);
        self.runs(&found.runs);
        found.kept.iter().for_each(|kept| self.bits((*kept).into()));
        self.count(found.courses.len());
        for Course { over: _, points } in &found.courses {
            for CoursePoint { at, smallest, mean, largest, runs } in points {
                [*at, *smallest, *mean, *largest].into_iter().for_each(|number| self.number(number));
                self.count(*runs);
            }
        }
    }

    fn tune(&mut self, tune: &TuneResult) {
        self.count(tune.evaluations.len());
        tune.evaluations.iter().for_each(|candidate| self.candidate(candidate));
        self.count(tune.pareto.len());
        tune.pareto.iter().for_each(|candidate| self.candidate(candidate));
        self.bits(tune.chosen.is_some().into());
        tune.chosen.iter().for_each(|candidate| self.candidate(candidate));
        self.bits(tune.comparison.as_ref().is_some_and(|one| one.feasible_fresh).into());
    }

    fn candidate(&mut self, Candidate { point, objectives, margins, feasible }: &Candidate) {
        self.point(point);
        self.numbers(objectives);
        self.numbers(margins);
        self.bits((*feasible).into());
    }

    fn evaluate(&mut self, evaluate: &EvaluateResult) {
        self.count(evaluate.conditions.len());
        for ConditionResult { measured, runs, .. } in &evaluate.conditions {
            self.numbers(measured);
            self.runs(runs);
        }
    }

    fn statement(&mut self, statement: &StatementResult) {
        self.count(statement.claims.len());
        for ClaimResult { holds, values, .. } in &statement.claims {
            self.bits(holds.map_or(2, u64::from));
            match values {
                ClaimValues::Compared { left, relation: _, right } => self.numbers(&[*left, *right]),
                ClaimValues::Trend { points, .. } => {
                    self.count(points.len());
                    points.iter().for_each(|point| {
                        self.number(point.at);
                        self.perhaps(point.value);
                    });
                }
            }
        }
    }
}
