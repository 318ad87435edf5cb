//! What an estimate came to: a bound that holds without assumptions, an estimate with its assumption, and what speaks against it.

use serde::{Deserialize, Serialize};

use super::written_counts::is_zero;
use crate::Verdict;
use numbers::inference::Interval;
use scenario::{EstimateMethod, Exposure};

/// How probable an event is: two numbers, side by side.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EstimateResult {
    /// As the suite calls it.
    pub name: String,
    /// What the suite says of it, in a sentence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doc: Option<String>,
    /// The scenario that it is of.
    pub scenario: String,
    /// What the probability is of, such as `pet < 0.5 s`.
    pub event: String,
    /// The metric that showed where to look, if one was needed.
    pub score: Option<String>,
    /// How runs were made.
    pub method: EstimateMethod,
    /// Of the suite.
    pub seed: u64,
    /// Runs that were made, those of the pilot among them.
    pub runs: usize,
    /// Runs that only showed where to look.
    pub pilot_runs: usize,
    /// What each replicate came to: independent of each other, and unbiased.
    pub replicates: Vec<f64>,
    /// Their mean: the estimate.
    pub value: f64,
    /// Of the interval, the bound and what may be unseen: between 0 and 1.
    pub confidence: f64,
    /// Where the probability lies by the estimate, two-sided; it says nothing where the estimate is refused.
    pub interval: Interval,
    /// On what the interval rests, in a sentence.
    pub assumption: String,
    /// Standard deviation of the replicates, in their mean; with that of what they are divided by where encounters are left out.
    pub relative_deviation: f64,
    /// The probability is at most this, whatever the method did: one-sided, by the nominal runs alone.
    pub guaranteed: f64,
    /// A region that no nominal run fell into has at most this probability.
    pub unseen: f64,
    /// Runs drawn as they are without a method, of which alone the bound is made.
    pub nominal_runs: u64,
    /// How many of them have the event.
    pub nominal_hits: u64,
    /// Runs with the event, of those that count.
    pub hits: usize,
    /// How many of them ended, or say too little, before that was decided: they count as having it.
    pub undecided: usize,
    /// How many others ended before the end of what the event is about was seen, such as with somebody neither hit nor arrived: they count
    /// as not having it.
    #[serde(default)]
    pub cut_off: usize,
    /// In how many of the runs that count something was at stake that the event is about.
    #[serde(default)]
    pub encounters: usize,
    /// Encounters that are left out, since there are none such, of those that would count.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub left_out: usize,
    /// So many hits of equal weight would say as much.
    pub effective_size: f64,
    /// The largest weight in the sum of all.
    pub largest_share: f64,
    /// How likely chance is to give so many or so few nominal hits if the estimate is right.
    pub contradiction: f64,
    /// Why the estimate must not be believed; empty where nothing speaks against it.
    pub refusals: Vec<String>,
    /// What to know besides.
    pub warnings: Vec<String>,
    /// What the heaviest hits have of the sum of weights, falling: the tail of the weights.
    pub shares: Vec<f64>,
    /// Hits that are near each other, the heaviest group first.
    pub clusters: Vec<EstimatedCluster>,
    /// The runs that carry the estimate, the heaviest first.
    pub carrying: Vec<EstimatedRun>,
    /// What was claimed, in order.
    pub claims: Vec<EstimatedClaim>,
    /// The same for a distance, where somebody says how many encounters there are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub per_1000_km: Option<EventsPerDistance>,
    /// What it is compared with, if that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared: Option<ComparedEstimate>,
}

/// How probable the same event is with another scenario in the same encounters, and how the two differ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ComparedEstimate {
    /// The scenario that it is compared with.
    pub scenario: String,
    /// What of the two is not the same, such as the controller of `av`; nothing where nothing is.
    pub differs: Vec<String>,
    /// What each replicate came to in that scenario.
    pub replicates: Vec<f64>,
    /// Their mean.
    pub value: f64,
    /// Where that probability lies, two-sided; it says nothing where it is refused.
    pub interval: Interval,
    /// It is at most this, whatever the method did.
    pub guaranteed: f64,
    /// How many of the runs drawn as they are have the event there.
    pub nominal_hits: u64,
    /// Runs with the event there.
    pub hits: usize,
    /// How many of them ended, or say too little, before that was decided: they count as *not* having it, which favours nobody's claim.
    pub undecided: usize,
    /// How many others ended before the end of what the event is about was seen.
    pub cut_off: usize,
    /// In how many of its runs something was at stake that the event is about.
    #[serde(default)]
    pub encounters: usize,
    /// Why the probability there must not be believed.
    pub refusals: Vec<String>,
    /// Encounters with the event in the estimate's own scenario alone.
    pub only_here: usize,
    /// Encounters with the event in the scenario that it is compared with alone.
    pub only_there: usize,
    /// So many of both of these, of equal weight, would say as much.
    pub effective_size: f64,
    /// How much more probable the event is than there: negative where it is less.
    pub difference: f64,
    /// Where that lies, two-sided.
    pub difference_interval: Interval,
    /// Why it must not be believed.
    pub difference_refusals: Vec<String>,
    /// Where the difference lies whatever the method did, two-sided: by the nominal runs alone.
    pub guaranteed_difference: Interval,
    /// How many times as probable the event is as there; `None` where it never happened there.
    pub ratio: Option<f64>,
    /// Where that lies, two-sided.
    pub ratio_interval: RatioInterval,
    /// Why it must not be believed.
    pub ratio_refusals: Vec<String>,
    /// Encounters with the event in the estimate's own scenario alone, the heaviest first: runs of that.
    pub here: Vec<EstimatedRun>,
    /// Encounters with the event in the other alone, the heaviest first: runs of that.
    pub there: Vec<EstimatedRun>,
}

/// Between what a ratio lies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RatioInterval {
    /// At least this.
    pub low: f64,
    /// At most this; `None` where what it is divided by may be nothing.
    pub high: Option<f64>,
}

impl From<Interval> for RatioInterval {
    fn from(Interval { low, high }: Interval) -> Self {
        Self { low, high: high.is_finite().then_some(high) }
    }
}

/// How many events are to be expected in 1,000 km: the probability in an encounter times the number of encounters, whatever they have to do
/// with each other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EventsPerDistance {
    /// Encounters in 1,000 km, as somebody says.
    pub encounters: Interval,
    /// How sure that is; `None`: it is taken for granted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure_confidence: Option<f64>,
    /// How it is known.
    pub source: String,
    /// Events at most, whatever the method did: the guaranteed bound times the most encounters.
    pub guaranteed: f64,
    /// The estimate times the fewest and the most encounters.
    pub value: Interval,
    /// The ends of the interval of the estimate times the fewest and the most encounters.
    pub interval: Interval,
    /// Events that an unseen region may have: what may be unseen times the most encounters.
    pub unseen: f64,
    /// Of the bound, the interval and what may be unseen: that of the probability less what the exposure may be wrong by.
    pub confidence: f64,
}

impl EventsPerDistance {
    /// Of a probability whose numbers hold with `confidence`.
    pub fn new(
        exposure: &Exposure,
        (guaranteed, unseen): (f64, f64),
        (value, interval): (f64, Interval),
        confidence: f64,
    ) -> Self {
        let Exposure { low, high, confidence: sure, source, .. } = exposure;
        Self {
            encounters: Interval { low: *low, high: *high },
            exposure_confidence: *sure,
            source: source.clone(),
            guaranteed: guaranteed * high,
            value: Interval { low: value * low, high: value * high },
            interval: Interval { low: interval.low * low, high: interval.high * high },
            unseen: unseen * high,
            confidence: confidence - sure.map_or(0.0, |sure| 1.0 - sure),
        }
    }
}

/// Hits that are near each other in what is drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EstimatedCluster {
    /// Of the estimate.
    pub share: f64,
    /// The heaviest of them.
    pub run: EstimatedRun,
}

/// A run with the event.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EstimatedRun {
    /// `replay` takes it.
    pub key: String,
    /// Its share of the estimate.
    pub share: f64,
    /// What it drew: names with values as they are said.
    pub drawn: Vec<(String, String)>,
}

/// What became of a claim.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EstimatedClaim {
    /// As it is written.
    pub text: String,
    /// Whether the bound that needs no assumption decided.
    pub guaranteed: bool,
    /// What it came to.
    pub verdict: Verdict,
    /// Why, in a sentence with the number that decided.
    pub reason: String,
}

impl EstimateResult {
    /// Failed where a claim failed; inconclusive where one could not be decided, or where the estimate is refused and nothing else was
    /// asked for.
    pub fn verdict(&self) -> Verdict {
        let any = |verdict: Verdict| self.claims.iter().any(|one| one.verdict == verdict);
        if any(Verdict::Failed) {
            Verdict::Failed
        } else if any(Verdict::Inconclusive) || self.claims.is_empty() && self.why_refused().is_some() {
            Verdict::Inconclusive
        } else {
            Verdict::Passed
        }
    }

    /// Why something that was estimated must not be believed, if nothing is claimed.
    fn why_refused(&self) -> Option<String> {
        if !self.refusals.is_empty() {
            return Some(format!("the estimate is refused: {}", self.refusals.join("; ")));
        }
        let refusals = &self.compared.as_ref()?.difference_refusals;
        (!refusals.is_empty()).then(|| format!("the difference is refused: {}", refusals.join("; ")))
    }

    /// Why it is not passed; `None` if it is.
    pub fn failure(&self) -> Option<String> {
        if self.verdict() == Verdict::Passed {
            return None;
        }
        let open = self.claims.iter().filter(|one| one.verdict != Verdict::Passed);
        let claims: Vec<String> = open.map(|one| format!("`{}`: {}", one.text, one.reason)).collect();
        if claims.is_empty() { self.why_refused() } else { Some(claims.join("; ")) }
    }
}
