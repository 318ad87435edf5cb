//! A block's fingerprint: a number that changes when any bit of what it measured changes.
//!
//! It covers what was simulated and what was found by it, not the words in which a report says so. Metrics that are
//! only summed up for tables stay out, so that a new metric leaves it alone, and so does what the surrogate believes. Results are
//! taken apart whole: whoever adds something to one decides here.

use sha2::{Digest, Sha256};

use crate::{
    BlockResult, CalibrateResult, CalibratedCondition, CalibratedParameter, CalibratedShare, Candidate,
    CaseRun, ClaimResult, ClaimValues, ComparedEstimate, ConditionResult, CountedRuns, CoursePoint,
    EstimateResult, EvaluateResult, Found, MetricCourse, SearchResult, StatementResult, TrendPoint,
    TuneResult, Violations,
};
use numbers::random::digest_bits;
use optimise::Coordinate;

impl BlockResult {
    /// The first eight bytes of SHA-256 over everything that the block measured.
    pub fn fingerprint(&self) -> u64 {
        let mut mixture = Mixture(Sha256::new());
        match self {
            Self::Search(search) => mixture.search(search),
            Self::Tune(tune) => mixture.tune(tune),
            Self::Evaluate(evaluate) => mixture.evaluate(evaluate),
            Self::Calibrate(calibrate) => mixture.calibrate(calibrate),
            Self::Estimate(estimate) => mixture.estimate(estimate),
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

    fn point(&mut self, point: &[Coordinate]) {
        self.count(point.len());
        for value in point {
            match value {
                Coordinate::Integer(integer) => self.bits(integer.cast_unsigned()),
                Coordinate::Real(real) => self.number(*real),
                Coordinate::Category(word) => self.0.update(word),
            }
        }
    }

    fn runs(&mut self, runs: &[CaseRun]) {
        self.count(runs.len());
        for CaseRun { case, outcome, passed_first: _ } in runs {
            self.bits(case.seed);
            self.bits(outcome.fingerprint);
        }
    }

    fn calibrate(&mut self, calibrate: &CalibrateResult) {
        let CalibrateResult {
            name: _,
            doc: _,
            matched: _,
            observations: _,
            candidates: _,
            model: _,
            variant: _,
            parameters: _,
            individuals,
            weights,
            digest: _,
            effective_size: _,
            conditions,
            matched_parameters,
            folds: _,
            folds_rms,
            left_out_rms,
            fresh_rms: _,
            runs,
            seed,
            vehicle_speeds: _,
            compared,
            resampled,
            warnings: _,
        } = calibrate;
        self.bits(*seed);
        self.count(*runs as usize);
        for rows in [individuals, resampled] {
            rows.iter().flatten().for_each(|number| self.number(*number));
        }
        weights.iter().for_each(|weight| self.number(*weight));
        self.numbers(&[*folds_rms, *left_out_rms]);
        for (share, spread) in compared.iter().flat_map(|one| &one.shares) {
            self.number(share.unwrap_or(f64::NAN));
            self.number(spread.unwrap_or(f64::NAN));
        }
        for CalibratedParameter { parameter: _, statistic: _, unit: _, wanted, within, equal, fitted } in
            matched_parameters
        {
            [wanted, within, equal, fitted].into_iter().for_each(|number| self.number(*number));
        }
        for statistic in compared.iter().flat_map(|one| &one.parameters) {
            self.perhaps(*statistic);
        }
        for CalibratedCondition {
            scenario: _,
            values: _,
            rate: _,
            trials,
            persons,
            undefined,
            counted,
            share,
            spread,
        } in conditions
        {
            self.count(*trials as usize);
            self.count(*persons as usize);
            self.number(*undefined);
            if let Some(CountedRuns { share, runs, candidates }) = counted {
                self.number(*share);
                self.number(*runs);
                self.number(*candidates);
            }
            for CalibratedShare { observed, error, equal, fitted, fresh, left_out, matched: _ } in
                std::iter::once(share).chain(spread)
            {
                [observed, error, equal, fitted, fresh].into_iter().for_each(|number| self.number(*number));
                self.perhaps(*left_out);
            }
        }
    }

    fn estimate(&mut self, estimate: &EstimateResult) {
        let EstimateResult {
            name: _,
            doc: _,
            scenario: _,
            event: _,
            score: _,
            method: _,
            seed,
            runs,
            pilot_runs,
            replicates,
            // Out of the replicates and their hits, as all that is not taken here.
            value: _,
            confidence: _,
            interval: _,
            relative_deviation: _,
            assumption: _,
            guaranteed: _,
            unseen: _,
            // Out of that and of what the block says.
            per_1000_km: _,
            nominal_runs,
            nominal_hits,
            hits,
            undecided,
            // Nothing that is estimated depends on it.
            cut_off: _,
            encounters: _,
            left_out: _,
            effective_size,
            largest_share: _,
            contradiction: _,
            refusals: _,
            warnings: _,
            shares,
            clusters: _,
            carrying: _,
            claims: _,
            compared,
        } = estimate;
        self.bits(*seed);
        for count in [*runs, *pilot_runs, *hits, *undecided] {
            self.count(count);
        }
        self.bits(*nominal_runs);
        self.bits(*nominal_hits);
        self.number(*effective_size);
        [replicates, shares].into_iter().flatten().for_each(|number| self.number(*number));
        if let Some(compared) = compared {
            self.compared_estimate(compared);
        }
    }

    fn compared_estimate(&mut self, compared: &ComparedEstimate) {
        let ComparedEstimate {
            scenario: _,
            differs: _,
            replicates,
            nominal_hits,
            hits,
            undecided,
            cut_off: _,
            encounters: _,
            only_here,
            only_there,
            effective_size,
            // Out of the replicates and their hits.
            value: _,
            interval: _,
            guaranteed: _,
            refusals: _,
            difference: _,
            difference_interval: _,
            difference_refusals: _,
            guaranteed_difference: _,
            ratio: _,
            ratio_interval: _,
            ratio_refusals: _,
            here: _,
            there: _,
        } = compared;
        for count in [*hits, *undecided, *only_here, *only_there] {
            self.count(count);
        }
        self.bits(*nominal_hits);
        self.number(*effective_size);
        replicates.iter().for_each(|number| self.number(*number));
    }

    fn search(&mut self, search: &SearchResult) {
        let SearchResult {
            name: _,
            objective: _,
            direction: _,
            shown_in: _,
            objective_in: _,
            metrics: _,
            found,
            // Out of the runs of `found`.
            kept: _,
            // Out of the evaluations and their points.
            usual: _,
            // Out of the runs of `found`, and of those with fresh seeds there.
            judged: _,
            // They have no value.
            left_out: _,
        } = search;
        self.count(found.len());
        found.iter().for_each(|found| self.found(found));
    }

    fn found(&mut self, found: &Found) {
        let Found {
            individuals,
            // Out of the evaluations.
            best: _,
            observed,
            predicted: _,
            fresh,
            fresh_runs: _,
            passed_first: _,
            // Out of the parameters of the case.
            plausibility: _,
            evaluations,
            // Out of the points of the evaluations.
            plausibilities: _,
            stop: _,
            slices: _,
            runs,
            kept,
            courses,
        } = found;
        for individual in individuals {
            self.bits(individual.number.into());
        }
        self.count(evaluations.len());
        for (point, objective) in evaluations {
            self.point(point);
            self.perhaps(*objective);
        }
        self.perhaps(*observed);
        self.perhaps(*fresh);
        self.runs(runs);
        kept.iter().for_each(|kept| self.bits((*kept).into()));
        self.count(courses.len());
        for MetricCourse { over: _, points } in courses {
            for CoursePoint { at, smallest, mean, largest, runs } in points {
                [*at, *smallest, *mean, *largest].into_iter().for_each(|number| self.number(number));
                self.count(*runs);
            }
        }
    }

    fn tune(&mut self, tune: &TuneResult) {
        let TuneResult {
            name: _,
            objectives: _,
            constraints: _,
            cases: _,
            fresh: _,
            parameters: _,
            shown_in: _,
            objectives_in: _,
            margins_in: _,
            chosen,
            // Out of the objectives of runs that are made again.
            change: _,
            // Out of the margins.
            violations: _,
            pareto,
            fresh_violations,
            // Out of runs that are made again.
            untested: _,
            evaluations,
            stop: _,
            slices: _,
            comparison: _,
        } = tune;
        self.count(evaluations.len());
        evaluations.iter().for_each(|candidate| self.candidate(candidate));
        self.count(pareto.len());
        pareto.iter().for_each(|candidate| self.candidate(candidate));
        self.bits(chosen.is_some().into());
        chosen.iter().for_each(|candidate| self.candidate(candidate));
        for Violations { runs, of } in fresh_violations {
            self.count(*runs);
            self.count(*of);
        }
    }

    fn candidate(
        &mut self,
        Candidate { origin: _, point, objectives, margins, keeps_constraints: _, feasible }: &Candidate,
    ) {
        self.point(point);
        self.numbers(objectives);
        self.numbers(margins);
        self.bits((*feasible).into());
    }

    fn evaluate(&mut self, evaluate: &EvaluateResult) {
        let EvaluateResult {
            name: _,
            doc: _,
            source: _,
            metrics: _,
            measures: _,
            cases: _,
            fresh: _,
            conditions,
        } = evaluate;
        self.count(conditions.len());
        for condition in conditions {
            let ConditionResult {
                name: _,
                parameters: _,
                missing: _,
                caveat: _,
                measured,
                undecided: _,
                reported: _,
                // Out of what was measured.
                differences: _,
                runs,
            } = condition;
            self.numbers(measured);
            self.runs(runs);
        }
    }

    fn statement(&mut self, statement: &StatementResult) {
        let StatementResult {
            name: _,
            doc: _,
            source: _,
            reported: _,
            // Out of the claims.
            conclusion: _,
            claims,
            standing: _,
        } = statement;
        self.count(claims.len());
        // Whether something was at stake is out of the runs.
        for ClaimResult { text: _, holds, undefined: _, untested: _, values, unit: _ } in claims {
            self.bits(holds.map_or(2, u64::from));
            match values {
                ClaimValues::Compared { left, relation: _, right } => self.numbers(&[*left, *right]),
                ClaimValues::Trend { direction: _, variable: _, points } => {
                    self.count(points.len());
                    points.iter().for_each(|TrendPoint { label: _, at, value, runs: _ }| {
                        self.number(*at);
                        self.perhaps(*value);
                    });
                }
            }
        }
    }
}
