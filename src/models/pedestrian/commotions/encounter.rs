//! The encounter of two coupled simulators (Markkula et al. 2023), without a world around it: who goes first, when they start, and how
//! long they are on the road.
//!
//! `scenarios/people/encounter.scn` says the same as scenarios; that the two agree is tested.

use rayon::prelude::*;

use super::meeting::{Meeting, MetDriver, PEDESTRIAN, VEHICLE, Waiting};
use super::parameters::Parameters;
use super::variant::Variant;
use numbers::random::derive_seed;
use numbers::summary::median;

/// Free speed of the vehicle and its speed at the start, m/s.
const DRIVES: f64 = 50.0 / 3.6;
/// How far the person stands from the conflict point, m.
const STANDS: f64 = 3.25;
/// Of the gap, for the step to the kerb, s.
const STEP_TO_KERB: f64 = 1.0;
/// s.
const TIME_STEP: f64 = 0.025;
/// Whoever has not entered by then is not first, s.
const ENDS: f64 = 20.0;

/// A condition of the encounter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncounterCondition {
    /// Whether the pedestrian has priority.
    pub zebra: bool,
    /// Time gap, s.
    pub gap: f64,
}

/// A person who went first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstPassage {
    /// When the person started to walk, s.
    pub start: f64,
    /// From then until the person was out of the conflict space, s; `None` where time was up before.
    pub crossing: Option<f64>,
}

/// What a population does in a condition.
#[derive(Clone, Debug, PartialEq)]
pub struct EncounteredShares {
    /// Share of runs in which the person goes first.
    pub share: f64,
    /// Share of pairs of a person's runs in which it does so in both.
    pub spread: f64,
    /// Median initiation time of those who go first, s.
    pub start: Option<f64>,
    /// Median crossing duration of those who go first, s.
    pub crossing: Option<f64>,
}

impl EncounterCondition {
    /// Whether the person enters its conflict space before the vehicle does, a driver of the same parameters.
    pub fn first(&self, variant: &Variant, person: &Parameters, seed: u64) -> Option<FirstPassage> {
        let both = Parameters { vehicle_free_speed: DRIVES, ..person.clone() };
        let meeting = Meeting {
            pedestrian: (STANDS, 0.0),
            vehicle: (VEHICLE.half_extent + (self.gap - STEP_TO_KERB) * DRIVES, DRIVES),
            driver: MetDriver::Commotions,
            pedestrian_priority: self.zebra,
            waiting: Waiting::Inhibited(0.0),
            dt: TIME_STEP,
            end_time: ENDS,
        };
        let (mut start, mut entered, mut out) = (None, false, None);
        meeting.run(variant, &both, seed, |moment| {
            if start.is_none() && moment.pedestrian.speed > 0.0 {
                start = Some(moment.time);
            }
            // Who steps back to stand starts anew.
            if !entered && moment.pedestrian.speed <= 0.0 {
                start = None;
            }
            entered |= moment.pedestrian.distance < PEDESTRIAN.half_extent;
            if moment.pedestrian.distance < -PEDESTRIAN.half_extent {
                out = Some(moment.time);
            }
            out.is_none() && (entered || moment.vehicle.distance >= VEHICLE.half_extent)
        });
        let start = start.filter(|_| entered)?;
        Some(FirstPassage { start, crossing: out.map(|out| out - start) })
    }

    /// What these people do in it, `repetitions` times each, at least 2.
    pub fn shares(
        &self,
        variant: &Variant,
        people: &[Parameters],
        repetitions: u32,
        seed: u64,
    ) -> EncounteredShares {
        let name = self.name();
        let runs: Vec<Vec<FirstPassage>> = people
            .par_iter()
            .enumerate()
            .map(|(person, parameters)| {
                let run = |repetition| {
                    let seed = derive_seed(seed, &format!("encounter/{name}/{person}/{repetition}"));
                    self.first(variant, parameters, seed)
                };
                (0..repetitions).filter_map(run).collect()
            })
            .collect();
        let (count, number) = (f64::from(repetitions), people.len() as f64);
        let pairs = |held: f64| held * (held - 1.0) / (count * (count - 1.0));
        let all = || runs.iter().flatten();
        let middle = |mut times: Vec<f64>| {
            times.sort_by(f64::total_cmp);
            median(&times)
        };
        EncounteredShares {
            share: all().count() as f64 / (number * count),
            spread: runs.iter().map(|runs| pairs(runs.len() as f64)).sum::<f64>() / number,
            start: middle(all().map(|one| one.start).collect()),
            crossing: middle(all().filter_map(|one| one.crossing).collect()),
        }
    }

    /// Such as `zebra 4 s`.
    pub fn name(&self) -> String {
        format!("{} {} s", if self.zebra { "zebra" } else { "plain" }, self.gap)
    }

    /// The condition that a row of `human_crossing.csv` is about: scenario `crossing_plain` or `crossing_zebra`, and what `gap` is there.
    pub fn of_row(scenario: &str, gap: &str) -> Option<Self> {
        let zebra = match scenario {
            "crossing_plain" => false,
            "crossing_zebra" => true,
            _ => return None,
        };
        let gap = gap.trim().strip_suffix('s')?.trim().parse().ok()?;
        Some(Self { zebra, gap })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn condition(zebra: bool, gap: f64) -> EncounterCondition {
        EncounterCondition { zebra, gap }
    }

    #[test]
    fn a_row_says_its_condition() {
        assert_eq!(EncounterCondition::of_row("crossing_zebra", "4 s"), Some(condition(true, 4.0)));
        assert_eq!(EncounterCondition::of_row("crossing_plain", "3.5s"), Some(condition(false, 3.5)));
        assert_eq!(EncounterCondition::of_row("crossing_plain", "4 m"), None);
        assert_eq!(EncounterCondition::of_row("crossing", "4 s"), None);
        assert_eq!(condition(true, 4.0).name(), "zebra 4 s");
    }

    #[test]
    fn more_people_go_first_with_more_time_and_where_they_have_priority() {
        let people = vec![Parameters { pedestrian_free_speed: 1.3, ..Parameters::default() }; 20];
        let share = |zebra, gap| condition(zebra, gap).shares(&Variant::STANDARD, &people, 2, 1);
        let (short, long, zebra) = (share(false, 2.0), share(false, 12.0), share(true, 6.0));
        assert!(short.share <= zebra.share && short.share < long.share, "{short:?} {long:?} {zebra:?}");
        // 1.95 m to the conflict space and 2.6 m through it take 3.5 s at 1.3 m/s.
        let crossing = long.crossing.expect("some cross");
        assert!((3.4..6.0).contains(&crossing), "{crossing} s");
        assert!(long.start.is_some_and(|start| (0.0..8.0).contains(&start)), "{long:?}");
        // All together differ by luck alone: pairs are less than shares.
        assert!(long.spread <= long.share);
    }
}
