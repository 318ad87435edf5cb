//! One population for two laboratories: candidates in the ten conditions of the encounter and in the 24 of HIKER, and the weights with which
//! they do what people did in the one, in the other, and in both.

use rayon::prelude::*;

use super::encounter::EncounterCondition;
use super::held_back::HikerPersons;
use super::hiker::{AS_PUBLISHED, HikerReference, HikerScenario};
use super::parameters::Parameters;
use super::variant::Variant;
use numbers::distributions::beta_quantile;
use numbers::inference::{
    CandidateShares, EntropyWeights, HeldCounts, WeightTarget, effective_size, maximum_entropy,
};
use numbers::random::derive_seed;
use scenario::ObservedRow;

/// Half of what lies within a standard error of a normal distribution, and a half.
const ONE_ERROR: f64 = 0.841_344_746_068_542_9;

/// Whom weights are to be like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Laboratory {
    /// The encounter of two coupled simulators.
    Encounter,
    /// The gap behind a first car.
    Hiker,
}

/// What people did in a condition.
struct ObservedPersons {
    laboratory: Laboratory,
    share: WeightTarget,
    spread: WeightTarget,
}

/// What weights that know of some laboratories do, under noise that no weight has seen.
#[derive(Clone, Debug, PartialEq)]
pub struct LaboratoryFit {
    /// Whom the weights are from.
    pub knows: Vec<Laboratory>,
    /// How many candidates of equal weight vary a mean as much.
    pub effective_size: f64,
    /// Of each laboratory.
    pub missed: Vec<LaboratoryMisses>,
}

/// How far from people a laboratory's conditions are, in shares of 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaboratoryMisses {
    /// Whose conditions.
    pub laboratory: Laboratory,
    /// Root mean square of shares.
    pub share: f64,
    /// The farthest share.
    pub farthest: f64,
    /// Root mean square of the spread between persons.
    pub spread: f64,
}

/// What candidates do in all conditions of both.
pub struct Laboratories {
    observed: Vec<ObservedPersons>,
    features: CandidateShares,
    fresh: CandidateShares,
}

/// Everything that decides what candidates do.
pub struct LaboratoryStudy<'a> {
    /// What people did in the encounter.
    pub encounter: &'a [(EncounterCondition, &'a ObservedRow)],
    /// The conditions of HIKER.
    pub hiker: &'a HikerReference,
    /// What people did in them.
    pub persons: &'a HikerPersons,
    /// The model's variant.
    pub variant: &'a Variant,
    /// Who is weighed.
    pub candidates: &'a [Parameters],
    /// Where each stands among the others, for predictions from those who are alike.
    pub coordinates: &'a [Vec<f64>],
    /// Runs of each in every condition, at least 2, and as many of fresh noise.
    pub runs: u32,
    /// Decides the noise of every run.
    pub seed: u64,
}

enum Condition<'a> {
    Encounter(EncounterCondition),
    Hiker(&'a str, &'a HikerScenario),
}

impl Condition<'_> {
    fn held(&self, variant: &Variant, person: &Parameters, seed: u64) -> bool {
        match self {
            Self::Encounter(condition) => condition.first(variant, person, seed).is_some(),
            Self::Hiker(_, scenario) => {
                scenario.start_of_crossing(variant, person, (seed, AS_PUBLISHED)).is_some()
            }
        }
    }

    fn name(&self) -> String {
        match self {
            Self::Encounter(condition) => condition.name(),
            Self::Hiker(name, _) => (*name).to_string(),
        }
    }
}

impl LaboratoryStudy<'_> {
    /// Puts every candidate into every condition; `done` is told after each candidate.
    pub fn run(&self, done: impl Fn() + Sync) -> Laboratories {
        let mut conditions = Vec::new();
        let mut observed = Vec::new();
        for (condition, row) in self.encounter {
            let most = row.by_count.len() as u32 - 1;
            let persons: Vec<_> =
                (0..).zip(&row.by_count).map(|(held, number)| (most, held, *number)).collect();
            conditions.push(Condition::Encounter(*condition));
            observed.push(ObservedPersons::of(Laboratory::Encounter, &persons));
        }
        for (name, scenario) in &self.hiker.scenarios {
            let Some(persons) = self.persons.scenarios.get(name) else { continue };
            conditions.push(Condition::Hiker(name, scenario));
            observed.push(ObservedPersons::of(Laboratory::Hiker, persons));
        }
        let names: Vec<String> = conditions.iter().map(Condition::name).collect();
        let counts: Vec<[Vec<u32>; 2]> = self
            .candidates
            .par_iter()
            .enumerate()
            .map(|(number, person)| {
                let pass = |pass: u32| {
                    let count = |(condition, name): (&Condition, &String)| {
                        let held = |run: &u32| {
                            let key = format!("laboratories/{name}/{number}/{pass}/{run}");
                            condition.held(self.variant, person, derive_seed(self.seed, &key))
                        };
                        (0..self.runs).filter(held).count() as u32
                    };
                    conditions.iter().zip(&names).map(count).collect()
                };
                let both = [pass(0), pass(1)];
                done();
                both
            })
            .collect();
        let [own, fresh] =
            [0, 1].map(|pass| counts.iter().map(|one| one[pass].clone()).collect::<Vec<Vec<u32>>>());
        Laboratories {
            observed,
            features: HeldCounts { held: &own, defined: &[], runs: self.runs }.smoothed(self.coordinates),
            fresh: HeldCounts { held: &fresh, defined: &[], runs: self.runs }.shares(),
        }
    }
}

impl Laboratories {
    /// Weights that match shares and spreads of these laboratories within their errors, and what they do in both.
    pub fn fit(&self, knows: &[Laboratory]) -> LaboratoryFit {
        let known: Vec<usize> =
            (0..self.observed.len()).filter(|at| knows.contains(&self.observed[*at].laboratory)).collect();
        let targets: Vec<WeightTarget> = known
            .iter()
            .map(|at| self.observed[*at].share)
            .chain(known.iter().map(|at| self.observed[*at].spread))
            .collect();
        let of = |(shares, pairs): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
            known.iter().map(|at| shares[*at]).chain(known.iter().map(|at| pairs[*at])).collect()
        };
        let features: Vec<Vec<f64>> = self.features.shares.iter().zip(&self.features.pairs).map(of).collect();
        let EntropyWeights { weights, .. } = maximum_entropy(&features, &targets);
        self.judged(knows.to_vec(), &weights)
    }

    /// Everybody of the same weight.
    pub fn equal(&self) -> LaboratoryFit {
        let number = self.fresh.shares.len();
        self.judged(Vec::new(), &vec![1.0 / number as f64; number])
    }

    fn judged(&self, knows: Vec<Laboratory>, weights: &[f64]) -> LaboratoryFit {
        let mean = |rows: &[Vec<f64>], at: usize| -> f64 {
            rows.iter().zip(weights).map(|(row, weight)| weight * row[at]).sum()
        };
        let missed = |laboratory: Laboratory| {
            let own = self.observed.iter().enumerate().filter(|(_, one)| one.laboratory == laboratory);
            let apart: Vec<(f64, f64)> = own
                .map(|(at, one)| {
                    let (share, spread) = (mean(&self.fresh.shares, at), mean(&self.fresh.pairs, at));
                    (share - one.share.value, spread - one.spread.value)
                })
                .collect();
            let rms = |of: &dyn Fn(&(f64, f64)) -> f64| {
                let squares: f64 = apart.iter().map(|one| of(one) * of(one)).sum();
                libm::sqrt(squares / apart.len().max(1) as f64)
            };
            LaboratoryMisses {
                laboratory,
                share: rms(&|one| one.0),
                farthest: apart.iter().map(|one| one.0.abs()).fold(0.0, f64::max),
                spread: rms(&|one| one.1),
            }
        };
        LaboratoryFit {
            knows,
            effective_size: effective_size(weights),
            missed: [Laboratory::Encounter, Laboratory::Hiker].map(missed).to_vec(),
        }
    }
}

impl ObservedPersons {
    fn of(laboratory: Laboratory, persons: &[(u32, u32, u32)]) -> Self {
        let (share, error) = super::held_back::share_of(persons);
        let number: f64 = persons.iter().map(|(.., count)| f64::from(*count)).sum();
        let share = WeightTarget { value: share, error: error.max(least_error(number)) };
        // Who has a single trial has no pair of them.
        let several: Vec<(f64, f64)> = persons
            .iter()
            .filter(|(trials, ..)| *trials > 1)
            .map(|(trials, held, count)| {
                let (trials, held) = (f64::from(*trials), f64::from(*held));
                (held * (held - 1.0) / (trials * (trials - 1.0)), f64::from(*count))
            })
            .collect();
        let number: f64 = several.iter().map(|(_, count)| count).sum();
        let value = several.iter().map(|(pairs, count)| pairs * count).sum::<f64>() / number;
        let squares: f64 =
            several.iter().map(|(pairs, count)| count * (pairs - value) * (pairs - value)).sum();
        let error = libm::sqrt(squares / number / (number - 1.0).max(1.0));
        let spread = WeightTarget { value, error: error.max(least_error(number)) };
        Self { laboratory, share, spread }
    }
}

/// Where nearly all persons are alike, how much they differ says little of the error: it is at least as far as Jeffreys' bound of one
/// standard error is from 1 where so many persons are all alike.
fn least_error(persons: f64) -> f64 {
    1.0 - beta_quantile(1.0 - ONE_ERROR, persons + 0.5, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_have_the_errors_of_persons() {
        // As `calibrate` has them: by hand (4·0 + 2·2 + 5·6 + 8·12) / 12 / 32.
        let plain = [(4, 0, 13), (4, 1, 4), (4, 2, 2), (4, 3, 5), (4, 4, 8)];
        let found = ObservedPersons::of(Laboratory::Encounter, &plain);
        assert!((found.spread.value - 130.0 / 12.0 / 32.0).abs() < 1e-12);
        assert!((found.share.value - 55.0 / 128.0).abs() < 1e-12);
        assert!((found.share.error - 0.075).abs() < 0.001 && (found.spread.error - 0.075).abs() < 0.001);
        // All alike, or all but one: as little is known as of 60 of 60.
        for alike in [vec![(6, 6, 60)], vec![(6, 6, 59), (6, 5, 1)]] {
            let found = ObservedPersons::of(Laboratory::Hiker, &alike);
            for target in [found.share, found.spread] {
                assert!((target.error - 0.0165).abs() < 0.001, "{target:?}");
            }
        }
    }

    /// Candidates who do with certainty what their place says, in two conditions that ask for different people.
    fn laboratories(first: f64, second: f64) -> Laboratories {
        let target = |value| WeightTarget { value, error: 0.02 };
        let observed =
            [(Laboratory::Encounter, first), (Laboratory::Hiker, second)].map(|(laboratory, value)| {
                ObservedPersons { laboratory, share: target(value), spread: target(value) }
            });
        let shares: Vec<Vec<f64>> = (0..100).map(|one| vec![f64::from(u8::from(one < 50)); 2]).collect();
        let defined = vec![vec![1.0; 2]; 100];
        let all = CandidateShares { pairs: shares.clone(), shares, defined_pairs: defined.clone(), defined };
        Laboratories { observed: observed.into(), features: all.clone(), fresh: all }
    }

    #[test]
    fn what_both_ask_for_costs_nothing_and_what_they_do_not_is_said() {
        let both = [Laboratory::Encounter, Laboratory::Hiker];
        let same = laboratories(0.3, 0.3).fit(&both);
        assert!(same.missed.iter().all(|one| one.share < 0.01), "{same:?}");
        let torn = laboratories(0.3, 0.7);
        let fit = torn.fit(&both);
        assert!(fit.missed.iter().all(|one| (one.share - 0.2).abs() < 0.01), "{fit:?}");
        // Who knows one of them does as people did there, and nothing else.
        let one = torn.fit(&both[..1]);
        assert!(one.missed[0].share < 0.01 && (one.missed[1].share - 0.4).abs() < 0.02, "{one:?}");
        assert!(torn.equal().missed.iter().all(|one| (one.share - 0.2).abs() < 1e-9));
        assert!((torn.equal().effective_size - 100.0).abs() < 1e-6);
    }
}
