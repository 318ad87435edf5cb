//! Two that are tested in the same encounters: how much more probable an event is with the first than with the second.
//!
//! Both make every run that is asked for, with one weight. What both have, or neither, cancels in the difference, so that only the
//! encounters in which exactly one has the event have to be many enough.

use super::estimate::{CONTRADICTION, LEAST_EFFECTIVE, RareEstimate, RareRefusal, RareScale, ReplicateRuns};
use super::space::RareSpace;
use crate::distributions::student_quantile;
use crate::inference::{Interval, lower_bound, upper_bound};

/// Which of two have the event in an encounter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PairedEvent {
    /// The first has it.
    pub first: bool,
    /// The second has it.
    pub second: bool,
}

/// What may be said of two probabilities of the same encounters.
#[derive(Debug, Clone, PartialEq)]
pub struct PairedRareEstimate {
    /// That at least one has the event: what methods are told.
    pub either: RareEstimate,
    /// That the first has it.
    pub first: RareEstimate,
    /// That the second has it.
    pub second: RareEstimate,
    /// That the first has it and the second has not.
    pub only_first: RareEstimate,
    /// That the second has it and the first has not.
    pub only_second: RareEstimate,
    /// That exactly one has it.
    pub only_one: RareEstimate,
    /// Of both in each replicate.
    replicates: Vec<(f64, f64)>,
    /// What each replicate adds to their difference.
    differences: Vec<f64>,
}

/// Of which probability of two a refusal is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RarePart {
    /// That at least one has the event.
    Either,
    /// That the second has it.
    Second,
    /// That the first has it and the second has not.
    OnlyFirst,
    /// That the second has it and the first has not.
    OnlySecond,
    /// That exactly one has it.
    OnlyOne,
}

impl PairedRareEstimate {
    /// From the replicates of a method that was told whether either has the event, and which of the two have it in a run of that number.
    pub fn of(
        space: &RareSpace,
        replicates: &[ReplicateRuns],
        scale: RareScale,
        had: impl Fn(usize) -> PairedEvent,
    ) -> Self {
        let only = |has: fn(PairedEvent) -> bool| -> Vec<ReplicateRuns> {
            replicates.iter().map(|one| one.only(|run| has(had(run)))).collect()
        };
        let part = |has| RareEstimate::of(space, &only(has), scale);
        let (firsts, seconds) = (only(|had| had.first), only(|had| had.second));
        let (first, second) =
            (RareEstimate::of(space, &firsts, scale), RareEstimate::of(space, &seconds, scale));
        let both = || firsts.iter().zip(&seconds);
        let difference = |(one, other): (&ReplicateRuns, &ReplicateRuns)| {
            one.of_ratio(first.value) - other.of_ratio(second.value)
        };
        Self {
            either: RareEstimate::of(space, replicates, scale),
            only_first: part(|had| had.first && !had.second),
            only_second: part(|had| had.second && !had.first),
            only_one: part(|had| had.first != had.second),
            replicates: both().map(|(one, other)| (one.probability, other.probability)).collect(),
            differences: both().map(difference).collect(),
            first,
            second,
        }
    }

    /// What the second came to in each replicate.
    pub fn second_replicates(&self) -> Vec<f64> {
        self.replicates.iter().map(|both| both.1).collect()
    }

    /// How much more probable the event is with the first.
    pub fn difference(&self) -> f64 {
        self.first.value - self.second.value
    }

    /// How many times as probable it is with the first; `None` where the second never has it.
    pub fn ratio(&self) -> Option<f64> {
        (self.second.value > 0.0).then(|| self.first.value / self.second.value)
    }

    /// Whether exactly one has the event so often that the spread of replicates tells how well their difference is known. Otherwise hits
    /// are counted as if each weighed as much as the heaviest.
    fn has_many(&self) -> bool {
        self.only_one.effective_size >= LEAST_EFFECTIVE
    }

    /// Why the difference must not be believed; empty where nothing speaks against it.
    pub fn difference_refusals(&self) -> Vec<(RarePart, RareRefusal)> {
        let mut found = Vec::new();
        if self.either.scale == RareScale::Exact {
            return found;
        }
        let (part, whole) = if self.has_many() {
            (RarePart::OnlyOne, &self.only_one)
        } else {
            (RarePart::Either, &self.either)
        };
        found.extend(whole.refusals.iter().map(|one| (part, one.clone())));
        for (part, one) in
            [(RarePart::OnlyFirst, &self.only_first), (RarePart::OnlySecond, &self.only_second)]
        {
            if one.contradiction <= CONTRADICTION {
                found.push((part, RareRefusal::Contradicted(one.contradiction)));
            }
        }
        found
    }

    /// Why the ratio must not be believed: what speaks against the difference, and against what it is divided by.
    pub fn ratio_refusals(&self) -> Vec<(RarePart, RareRefusal)> {
        let mut found = self.difference_refusals();
        let parts = [(RarePart::Either, &self.either), (RarePart::Second, &self.second)];
        for (part, one) in parts {
            let more: Vec<_> = one.refusals.iter().map(|one| (part, one.clone())).collect();
            found.extend(more.into_iter().filter(|one| !found.contains(one)).collect::<Vec<_>>());
        }
        found
    }

    /// Where the difference lies at this two-sided confidence (0..1), if nothing speaks against it.
    pub fn difference_interval(&self, confidence: f64) -> Interval {
        let each = 0.5 + confidence / 2.0;
        Interval { low: self.difference_lower(each), high: self.difference_upper(each) }
    }

    /// The difference is at most this, at one-sided `confidence`.
    pub fn difference_upper(&self, confidence: f64) -> f64 {
        difference_end(self, false, confidence)
    }

    /// The difference is at least this, at one-sided `confidence`.
    pub fn difference_lower(&self, confidence: f64) -> f64 {
        -difference_end(self, true, confidence)
    }

    /// Where the ratio lies at this two-sided confidence (0..1), if nothing speaks against it.
    pub fn ratio_interval(&self, confidence: f64) -> Interval {
        self.ratio_ends(0.5 + confidence / 2.0)
    }

    /// The ratio is at most this, at one-sided `confidence`; infinite where the second may be as rare as nothing.
    pub fn ratio_upper(&self, confidence: f64) -> f64 {
        self.ratio_ends(confidence).high
    }

    /// The ratio is at least this, at one-sided `confidence`.
    pub fn ratio_lower(&self, confidence: f64) -> f64 {
        self.ratio_ends(confidence).low
    }

    /// At one-sided `confidence` at each end.
    fn ratio_ends(&self, confidence: f64) -> Interval {
        if self.either.scale == RareScale::Exact {
            return self.guaranteed_ratio(confidence);
        }
        if self.has_many() {
            return self.fieller(confidence);
        }
        let each = 0.5 + confidence / 2.0;
        let (upper, lower) = (|part| self.share_upper(part, each), |part| self.share_lower(part, each));
        let (first, second) = (&self.only_first, &self.only_second);
        Interval {
            low: (1.0 - upper(second)) / (1.0 - lower(first)),
            high: (1.0 - lower(second)) / (1.0 - upper(first)),
        }
    }

    /// What both are divided by where runs are left out cancels. Ratios ρ with which the mean of first − ρ · second over the replicates is less than Student's distance from 0, at one-sided
    /// `confidence` at each end.
    ///
    /// Source: E. C. Fieller, J. R. Stat. Soc. B 16, 1954.
    fn fieller(&self, confidence: f64) -> Interval {
        let count = self.replicates.len() as f64;
        let (one, other) = (self.first.value, self.second.value);
        let covariance = |of: fn((f64, f64), (f64, f64)) -> f64| {
            let sum: f64 = self.replicates.iter().map(|both| of(*both, (one, other))).sum();
            sum / (count - 1.0) / count
        };
        let t = student_quantile(confidence, count - 1.0);
        let first = one * one - t * t * covariance(|x, mean| (x.0 - mean.0) * (x.0 - mean.0));
        let mixed = one * other - t * t * covariance(|x, mean| (x.0 - mean.0) * (x.1 - mean.1));
        let second = other * other - t * t * covariance(|x, mean| (x.1 - mean.1) * (x.1 - mean.1));
        // What is divided by may be nothing: every ratio is possible.
        if second <= 0.0 || !second.is_finite() {
            return Interval { low: 0.0, high: f64::INFINITY };
        }
        let root = (mixed * mixed - first * second).max(0.0).sqrt();
        Interval { low: ((mixed - root) / second).max(0.0), high: (mixed + root) / second }
    }

    /// A part of the hits, counted as if each of all weighed as much as the heaviest: their share of all is at most this.
    fn share_upper(&self, part: &RareEstimate, confidence: f64) -> f64 {
        let all = self.hits();
        let own = (self.share(part) * all).ceil();
        if all < 1.0 { 1.0 } else { upper_bound((own as u64).min(all as u64), all as u64, confidence) }
    }

    /// The same: at least this.
    fn share_lower(&self, part: &RareEstimate, confidence: f64) -> f64 {
        let all = self.hits();
        let own = (self.share(part) * all).floor();
        if all < 1.0 { 0.0 } else { lower_bound((own as u64).min(all as u64), all as u64, confidence) }
    }

    fn share(&self, part: &RareEstimate) -> f64 {
        if self.either.value > 0.0 { part.value / self.either.value } else { 0.0 }
    }

    /// As many hits as there would be if each weighed as much as the heaviest.
    fn hits(&self) -> f64 {
        if self.either.largest_share > 0.0 { (1.0 / self.either.largest_share).floor() } else { 0.0 }
    }

    /// The difference, whatever the method did, at one-sided `confidence` at each end: by the nominal runs alone.
    ///
    /// Source: Clopper–Pearson bounds of the encounters that the first alone has, and the second alone, each at half of the error
    /// (Bonferroni).
    pub fn guaranteed_difference(&self, confidence: f64) -> Interval {
        Interval {
            low: -guaranteed(&self.only_second, &self.only_first, confidence),
            high: guaranteed(&self.only_first, &self.only_second, confidence),
        }
    }

    /// The ratio, whatever the method did, at one-sided `confidence` at each end; infinite where no nominal run of the second has the event.
    pub fn guaranteed_ratio(&self, confidence: f64) -> Interval {
        let each = 0.5 + confidence / 2.0;
        let ends = |one: &RareEstimate| (nominal_lower(one, each), one.guaranteed(each));
        let (first, second) = (ends(&self.first), ends(&self.second));
        let over = |one: f64, other: f64| if other > 0.0 { one / other } else { f64::INFINITY };
        Interval { low: over(first.0, second.1), high: over(first.1, second.0) }
    }
}

/// How much more probable the first is than the second, or the second than the first, at most.
fn difference_end(of: &PairedRareEstimate, swapped: bool, confidence: f64) -> f64 {
    let (more, less) =
        if swapped { (&of.only_second, &of.only_first) } else { (&of.only_first, &of.only_second) };
    if of.either.scale == RareScale::Exact {
        return guaranteed(more, less, confidence);
    }
    if of.has_many() {
        let count = of.differences.len() as f64;
        let mean = of.differences.iter().sum::<f64>() / count;
        let squares: f64 = of.differences.iter().map(|one| (one - mean) * (one - mean)).sum();
        let half = student_quantile(confidence, count - 1.0) * (squares / (count - 1.0) / count).sqrt();
        return if swapped { half - mean } else { half + mean };
    }
    // Of three numbers, each may be wrong by a third.
    let each = 1.0 - (1.0 - confidence) / 3.0;
    let share = of.share_upper(more, each) - of.share_lower(less, each);
    share * if share > 0.0 { of.either.upper(each) } else { of.either.lower(each) }
}

/// How much more probable one is than the other at most, by nominal runs alone.
fn guaranteed(one: &RareEstimate, other: &RareEstimate, confidence: f64) -> f64 {
    let each = 0.5 + confidence / 2.0;
    one.guaranteed(each) - nominal_lower(other, each)
}

/// The probability is at least this at one-sided `confidence`, by nominal runs alone.
fn nominal_lower(one: &RareEstimate, confidence: f64) -> f64 {
    let (runs, hits) = one.nominal;
    if runs == 0 { 0.0 } else { lower_bound(hits, runs, confidence) }
}

#[cfg(test)]
mod tests {
    use super::super::{
        CrudeSampling, ImportanceSampling, RareAxis, RareOutcome, RarePoint, RareSampling, SplittingSampling,
        leaving_out,
    };
    use super::*;
    use crate::distributions::normal;
    use crate::random::derive_seed;

    /// Two events of a point: how far it is from each, which happen at 0 and below.
    struct Pair {
        name: &'static str,
        first: fn(&[f64]) -> f64,
        second: fn(&[f64]) -> f64,
        probabilities: (f64, f64),
    }

    fn tail(beta: f64) -> f64 {
        normal::cumulative(-beta)
    }

    fn space() -> RareSpace {
        RareSpace::new(vec![RareAxis::Continuous; 2])
    }

    fn estimated(method: &mut dyn RareSampling, scale: RareScale, pair: &Pair) -> PairedRareEstimate {
        estimated_of(method, scale, pair, |_| true)
    }

    /// Of the points that can be alone.
    fn estimated_of(
        method: &mut dyn RareSampling,
        scale: RareScale,
        pair: &Pair,
        can_be: fn(&[f64]) -> bool,
    ) -> PairedRareEstimate {
        let (mut had, mut left_out) = (Vec::new(), Vec::new());
        while let Some(round) = method.ask() {
            let mut outcome = |one: &RarePoint| {
                let z: Vec<f64> = one.point.iter().map(|share| normal::quantile(*share)).collect();
                let (first, second) = match can_be(&z) {
                    true => ((pair.first)(&z), (pair.second)(&z)),
                    false => (9.0, 9.0),
                };
                left_out.extend((!can_be(&z)).then_some(had.len()));
                had.push(PairedEvent { first: first <= 0.0, second: second <= 0.0 });
                RareOutcome { event: first <= 0.0 || second <= 0.0, score: first.min(second) }
            };
            let outcomes: Vec<_> = round.points.iter().map(&mut outcome).collect();
            method.tell(&outcomes);
        }
        let replicates = leaving_out(method.replicates(), &left_out);
        PairedRareEstimate::of(&space(), &replicates, scale, |run| had[run])
    }

    fn pairs() -> Vec<Pair> {
        vec![
            Pair {
                name: "the same",
                first: |z| 3.5 - z[0],
                second: |z| 3.5 - z[0],
                probabilities: (tail(3.5), tail(3.5)),
            },
            Pair {
                name: "hardly rarer",
                first: |z| 3.51 - z[0],
                second: |z| 3.5 - z[0],
                probabilities: (tail(3.51), tail(3.5)),
            },
            Pair {
                name: "a quarter rarer",
                first: |z| 3.58 - z[0],
                second: |z| 3.5 - z[0],
                probabilities: (tail(3.58), tail(3.5)),
            },
            Pair {
                name: "as probable elsewhere",
                first: |z| 3.5 - z[0],
                second: |z| 3.5 + z[0],
                probabilities: (tail(3.5), tail(3.5)),
            },
            Pair {
                name: "three times as probable",
                first: |z| (3.5 - z[0]).min(3.2905 - z[1]),
                second: |z| 3.5 - z[0],
                probabilities: (tail(3.5) + tail(3.2905) * (1.0 - tail(3.5)), tail(3.5)),
            },
        ]
    }

    /// Intervals cover, two-sided and each end by itself; what is refused is no more than so many of 40.
    #[test]
    fn differences_and_ratios_that_are_known_are_covered() {
        for pair in pairs() {
            let (one, other) = pair.probabilities;
            let (difference, ratio) = (one - other, one / other);
            let (mut kept, mut covered, mut refused, mut guaranteed) = (0, [0; 4], 0, 0);
            for repetition in 0..40_u64 {
                let seed = derive_seed(repetition, pair.name);
                let mut method = ImportanceSampling::new(space(), 4000, seed);
                let found = estimated(&mut method, RareScale::Logarithmic, &pair);
                guaranteed += u64::from(found.guaranteed_difference(0.975).contains(difference));
                assert!(found.guaranteed_ratio(0.975).high >= ratio || repetition > 0);
                if !found.ratio_refusals().is_empty() {
                    refused += 1;
                    continue;
                }
                kept += 1;
                // Of those that are the same, rounding of the weights' sum differs by nothing, so that they are exactly so.
                covered[0] += u64::from(found.difference_interval(0.95).contains(difference));
                covered[1] += u64::from(found.ratio_interval(0.95).contains(ratio));
                covered[2] += u64::from(found.difference_upper(0.95) >= difference);
                covered[3] += u64::from(found.ratio_upper(0.95) >= ratio);
            }
            let least = 0.93 - 3.0 * (0.93_f64 * 0.07 / f64::from(kept)).sqrt();
            for counted in covered {
                assert!(counted as f64 >= least * f64::from(kept), "{}: {covered:?} of {kept}", pair.name);
            }
            assert!(guaranteed >= 34, "{}: {guaranteed} of 40", pair.name);
            assert!(refused <= 8, "{}: {refused} of 40 refused", pair.name);
        }
    }

    /// What is left out has nothing to do with either event, so that the truth is the same.
    #[test]
    fn differences_and_ratios_of_what_is_left_are_covered() {
        let pair = Pair {
            name: "three times as probable, half left out",
            first: |z| 3.2 - z[0],
            second: |z| 3.5 - z[0],
            probabilities: (tail(3.2), tail(3.5)),
        };
        let (one, other) = pair.probabilities;
        let (mut kept, mut covered) = (0, [0; 2]);
        for repetition in 0..40_u64 {
            let mut method = ImportanceSampling::new(space(), 4000, derive_seed(repetition, pair.name));
            let found = estimated_of(&mut method, RareScale::Logarithmic, &pair, |z| z[1] > 0.0);
            assert!(found.has_many(), "intervals are of the replicates");
            if found.ratio_refusals().is_empty() {
                kept += 1;
                covered[0] += u64::from(found.difference_interval(0.95).contains(one - other));
                covered[1] += u64::from(found.ratio_interval(0.95).contains(one / other));
            }
        }
        let least = 0.93 - 3.0 * (0.93_f64 * 0.07 / f64::from(kept)).sqrt();
        assert!(
            kept >= 32 && covered.iter().all(|one| *one as f64 >= least * f64::from(kept)),
            "{covered:?} of {kept}"
        );
    }

    #[test]
    fn what_is_the_same_differs_by_nothing_and_is_not_shown_to_be_less() {
        let pair = &pairs()[0];
        let mut method = ImportanceSampling::new(space(), 4000, 7);
        let found = estimated(&mut method, RareScale::Logarithmic, pair);
        assert_eq!((found.difference(), found.ratio(), found.only_one.hits), (0.0, Some(1.0), 0));
        assert!(found.ratio_refusals().is_empty(), "{:?}", found.ratio_refusals());
        // Nothing that was seen differs, which is no proof that nothing does.
        assert!(
            found.ratio_upper(0.95) > 1.0 && found.ratio_upper(0.95) < 1.05,
            "{}",
            found.ratio_upper(0.95)
        );
        assert!(found.difference_upper(0.95) > 0.0 && found.difference_lower(0.95) < 0.0);
    }

    #[test]
    fn swapping_the_two_turns_the_difference_round() {
        for pair in pairs() {
            let swapped = Pair {
                name: pair.name,
                first: pair.second,
                second: pair.first,
                probabilities: (pair.probabilities.1, pair.probabilities.0),
            };
            let of = |pair: &Pair| {
                let mut method = ImportanceSampling::new(space(), 4000, 11);
                estimated(&mut method, RareScale::Logarithmic, pair)
            };
            let (one, other) = (of(&pair), of(&swapped));
            let near = |one: f64, other: f64| (one - other).abs() <= 1e-12 * one.abs().max(1e-12);
            assert!(near(one.difference(), -other.difference()), "{}", pair.name);
            assert!(near(one.difference_upper(0.9), -other.difference_lower(0.9)), "{}", pair.name);
            assert!(near(one.guaranteed_difference(0.9).high, -other.guaranteed_difference(0.9).low));
            let (ratio, inverse) = (one.ratio_interval(0.9), other.ratio_interval(0.9));
            assert!((ratio.high * inverse.low - 1.0).abs() < 1e-6, "{}: {ratio:?} {inverse:?}", pair.name);
        }
    }

    /// A contrast with the ratio at its end is as far from 0 as Student says: the second derivation of Fieller's interval.
    #[test]
    fn the_ends_of_a_ratio_are_where_its_contrast_is_as_far_from_0_as_student_says() {
        let pair = &pairs()[4];
        let mut method = ImportanceSampling::new(space(), 4000, 3);
        let found = estimated(&mut method, RareScale::Logarithmic, pair);
        assert!(found.has_many());
        let distance = |ratio: f64| {
            let contrasts: Vec<f64> = found.replicates.iter().map(|both| both.0 - ratio * both.1).collect();
            let error = crate::summary::std(&contrasts).unwrap() / (contrasts.len() as f64).sqrt();
            crate::summary::mean(&contrasts).unwrap() / error
        };
        let interval = found.ratio_interval(0.95);
        let t = student_quantile(0.975, 19.0);
        assert!((distance(interval.low) - t).abs() < 1e-6 && (distance(interval.high) + t).abs() < 1e-6);
    }

    #[test]
    fn nothing_found_says_nothing() {
        let never = Pair { name: "never", first: |_| 9.0, second: |_| 9.0, probabilities: (0.0, 0.0) };
        let mut method = ImportanceSampling::new(space(), 2000, 3);
        let found = estimated(&mut method, RareScale::Logarithmic, &never);
        assert_eq!(found.difference_refusals(), [(RarePart::Either, RareRefusal::NoHits)]);
        assert_eq!(found.ratio(), None);
        assert!(found.difference_upper(0.95) > 0.01 && found.difference_lower(0.95) < -0.01);
        assert!(found.ratio_upper(0.95).is_infinite() || found.ratio_upper(0.95).is_nan());
        assert_eq!(found.guaranteed_ratio(0.95).high, f64::INFINITY);
    }

    #[test]
    fn other_methods_know_who_had_it_too() {
        let pair = Pair {
            name: "twice as probable",
            first: |z| 2.0 - z[0],
            second: |z| 2.3 - z[0],
            probabilities: (tail(2.0), tail(2.3)),
        };
        let ratio = pair.probabilities.0 / pair.probabilities.1;
        let mut crude = CrudeSampling::new(space(), 40_000, 5);
        let found = estimated(&mut crude, RareScale::Exact, &pair);
        assert!(found.ratio_refusals().is_empty());
        assert!(found.ratio_interval(0.99).contains(ratio) && found.ratio_lower(0.95) > 1.5);
        assert_eq!(found.ratio_upper(0.95), found.guaranteed_ratio(0.95).high);
        let (runs, hits) = found.first.nominal;
        assert_eq!((runs, hits as usize), (40_000, found.first.hits));
        let mut splitting = SplittingSampling::new(space(), 40_000, 5);
        let found = estimated(&mut splitting, RareScale::Logarithmic, &pair);
        assert!(found.ratio_interval(0.999).contains(ratio), "{:?}", found.ratio_interval(0.999));
        assert!(found.either.nominal.1 == found.first.nominal.1, "the second is part of the first");
        assert!((found.either.value - found.first.value).abs() < 1e-12);
    }
}
