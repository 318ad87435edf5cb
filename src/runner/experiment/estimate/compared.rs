//! What an estimate says of two scenarios in the same encounters.

use super::judged::{in_words, judged, number, percent};
use super::sampled::{CONFIDENCE, Hits, MOST_RUNS, Sampled};
use crate::baseline::differences;
use crate::experiment::error::ExperimentError;
use crate::plan::Cases;
use numbers::rare::{PairedRareEstimate, RarePart, RareRefusal};
use results::{ComparedEstimate, EstimatedClaim, EstimatedRun, Verdict};
use scenario::{Estimate, EstimateClaim, EstimateClaimOf, Exposure};

/// Two scenarios in the same encounters.
pub struct Compared<'a> {
    own: &'a str,
    with: &'a str,
    others: &'a Cases,
    paired: &'a PairedRareEstimate,
    difference_refusals: Vec<String>,
    ratio_refusals: Vec<String>,
}

impl<'a> Compared<'a> {
    /// Of an estimate that is compared with something; `cut_off` says of which of both too little was seen.
    pub fn new(
        block: &'a Estimate,
        others: &'a Cases,
        paired: &'a PairedRareEstimate,
        cut_off: &[String],
    ) -> Self {
        let (own, with) = (block.scenario.as_str(), block.compared_with.as_deref().unwrap_or_default());
        let words = |refusals: Vec<(RarePart, RareRefusal)>| {
            let said = refusals.iter().map(|(part, one)| said(*part, one, paired, (own, with)));
            said.chain(cut_off.iter().cloned()).collect()
        };
        let difference_refusals = words(paired.difference_refusals());
        let ratio_refusals = words(paired.ratio_refusals());
        Self { own, with, others, paired, difference_refusals, ratio_refusals }
    }

    /// A claim about the difference or the ratio: as one about the probability it holds where its one-sided bound shows it, is wrong where
    /// the bound from the other side shows that, and else open.
    pub fn decide(&self, claim: &EstimateClaim, exposure: Option<&Exposure>) -> EstimatedClaim {
        let EstimateClaim { of, guaranteed, confidence, text, .. } = claim;
        let (paired, level) = (self.paired, percent(*confidence));
        let is_ratio = *of == EstimateClaimOf::Ratio;
        let refusals = if is_ratio { &self.ratio_refusals } else { &self.difference_refusals };
        let (verdict, reason) = if *guaranteed {
            let bounds = if is_ratio {
                paired.guaranteed_ratio(*confidence)
            } else {
                paired.guaranteed_difference(*confidence)
            };
            let (runs, hits) = paired.first.nominal;
            let of = format!(
                "{hits} of {runs} encounters that are drawn as they are have the event in `{}`, and {} in `{}`; at {level} without assumptions",
                self.own, paired.second.nominal.1, self.with
            );
            judged(claim, exposure, (bounds.low, bounds.high), &of)
        } else if !refusals.is_empty() {
            let what = if is_ratio { "ratio" } else { "difference" };
            (Verdict::Inconclusive, format!("the {what} is refused: {}", refusals.join("; ")))
        } else {
            let bounds = if is_ratio {
                (paired.ratio_lower(*confidence), paired.ratio_upper(*confidence))
            } else {
                (paired.difference_lower(*confidence), paired.difference_upper(*confidence))
            };
            let of = format!(
                "the estimates are {} and {}; at {level} by them",
                number(paired.first.value),
                number(paired.second.value)
            );
            judged(claim, exposure, bounds, &of)
        };
        EstimatedClaim { text: text.clone(), guaranteed: *guaranteed, verdict, reason }
    }

    pub fn result(self, sampled: &Sampled) -> Result<ComparedEstimate, ExperimentError> {
        let Self { with, others, paired, difference_refusals, ratio_refusals, .. } = self;
        let second = &paired.second;
        let (undecided, cut_off) = (sampled.told.undecided_others, sampled.told.cut_off_others);
        let replicates = sampled.replicates();
        let hits = Hits::of(&replicates);
        let runs = |cases: &Cases, of_own: bool| -> Result<Vec<EstimatedRun>, ExperimentError> {
            let alone = |run: usize| {
                let had = sampled.had(run);
                had.first != had.second && had.first == of_own
            };
            hits.heaviest(alone).into_iter().take(MOST_RUNS).map(|index| hits.run(index, cases)).collect()
        };
        let middle = |cases: &Cases| cases.middle().unwrap_or_else(|| cases.first());
        Ok(ComparedEstimate {
            scenario: with.to_string(),
            differs: differences(&middle(others), &middle(sampled.cases)),
            replicates: paired.second_replicates(),
            value: second.value,
            interval: second.interval(CONFIDENCE),
            guaranteed: second.guaranteed(CONFIDENCE),
            nominal_hits: second.nominal.1,
            hits: second.hits,
            undecided,
            cut_off,
            encounters: sampled.told.met_others,
            refusals: second.refusals.iter().map(|one| in_words(one, second)).collect(),
            only_here: paired.only_first.hits,
            only_there: paired.only_second.hits,
            effective_size: paired.only_one.effective_size,
            difference: paired.difference(),
            difference_interval: paired.difference_interval(CONFIDENCE),
            difference_refusals,
            guaranteed_difference: paired.guaranteed_difference(0.5 + CONFIDENCE / 2.0),
            ratio: paired.ratio(),
            ratio_interval: paired.ratio_interval(CONFIDENCE).into(),
            ratio_refusals,
            here: runs(sampled.cases, true)?,
            there: runs(others, false)?,
        })
    }
}

/// Why something is refused, with what it is said of.
fn said(
    part: RarePart,
    refusal: &RareRefusal,
    paired: &PairedRareEstimate,
    (own, with): (&str, &str),
) -> String {
    let (of, estimate) = match part {
        RarePart::Either => ("of encounters with the event in either: ".to_string(), &paired.either),
        RarePart::Second => (format!("of `{with}`: "), &paired.second),
        RarePart::OnlyFirst => {
            (format!("of encounters with the event in `{own}` alone: "), &paired.only_first)
        }
        RarePart::OnlySecond => {
            (format!("of encounters with the event in `{with}` alone: "), &paired.only_second)
        }
        RarePart::OnlyOne => ("of encounters with the event in one alone: ".to_string(), &paired.only_one),
    };
    format!("{of}{}", in_words(refusal, estimate))
}
