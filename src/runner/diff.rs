//! Two runs on the same noise: which they are, and where their courses part.

use std::iter::Peekable;

use thiserror::Error;

use crate::baseline::differences;
use crate::experiment::searched_case;
use crate::plan::{PlanError, PlannedTrial, plan_scenario};
use crate::run::{BatchError, Ran, RunBatch, Wanted};
use crate::why::contacts;
use results::{
    ContactMoment, Doing, InBoth, OneOfTwo, PARTED_LENGTH, PARTED_SPEED, PartedIn, Parting, PartsBy,
    Recording, SharedMoment, TwoRuns,
};
use scenario::{Assignment, Case, Criterion, Suite, World};
use sim::{GivenCommand, Happening, Sample, TimelineEvent};

/// Moments that are nearer than this are the same, s.
const SAME: f64 = 1e-9;
/// So many moments of both runs are told, besides that at which they part.
const MOMENTS: usize = 8;

/// Why there is no run like another in which values are set.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum NoCounterpart {
    /// The scenario is gone.
    #[error("there is no scenario `{0}`")]
    Scenario(String),
    /// No run has the values of the other.
    #[error("with that no run of `{scenario}` has {values}")]
    Values {
        /// The scenario's name.
        scenario: String,
        /// What the other run has, in words.
        values: String,
    },
    /// Several runs could be meant.
    #[error("with that {0} runs could be meant")]
    Several(usize),
    /// The run was made for a point of a search or an estimate, and what was set changes what it is made of.
    #[error("`{0}` is a run at a point of its own, which cannot be made with other values")]
    AtPoint(String),
    /// It cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// The run of a suite in which these names are `set` that is `reference` in everything else: the same values of other variations, the
/// same people, and the same seed, from which everything is drawn. With what is asked of it.
///
/// # Errors
/// If there is none, or it cannot be told which.
pub fn counterpart(
    suite: &Suite,
    reference: &Case,
    set: &[&str],
) -> Result<(Case, Vec<Criterion>), NoCounterpart> {
    if let Some(case) = searched_case(suite, &reference.key).filter(|case| case.seed == reference.seed) {
        return Ok((case, Vec::new()));
    }
    let scenario = suite.scenarios.iter().chain(&suite.supporting).find(|one| one.name == reference.scenario);
    let scenario = scenario.ok_or_else(|| NoCounterpart::Scenario(reference.scenario.clone()))?;
    let plan = plan_scenario(suite, scenario)?;
    let others = |values: &[Assignment]| -> Vec<Assignment> {
        values.iter().filter(|one| !set.contains(&&*one.name)).cloned().collect()
    };
    let wanted = others(&reference.variation);
    let fitting: Vec<usize> =
        (0..plan.len()).filter(|index| others(&plan.variation(*index)) == wanted).collect();
    let trial = match fitting[..] {
        [only] => plan.trial(only),
        [] => {
            let values = wanted.iter().map(|one| format!("{} = {}", one.name, one.label));
            let values = values.collect::<Vec<_>>().join(", ");
            return Err(NoCounterpart::Values { scenario: scenario.name.clone(), values });
        }
        _ => return Err(NoCounterpart::Several(fitting.len())),
    };
    let key = format!("{}{}", trial.key, beyond_trial(suite, reference));
    let case = of_seed(&trial, &key, reference.seed)?.ok_or(NoCounterpart::AtPoint(key))?;
    Ok((case, trial.criteria.to_vec()))
}

/// The run of that name with that seed.
fn of_seed(trial: &PlannedTrial, key: &str, seed: u64) -> Result<Option<Case>, PlanError> {
    match trial.cases.named(key).filter(|case| case.seed == seed) {
        Some(case) => Ok(Some(case)),
        None => trial.cases.named_with_seed(key, seed).transpose(),
    }
}

/// What follows the trial's name in that of a run: `/individual=17/rep=2`.
fn beyond_trial<'c>(suite: &Suite, case: &'c Case) -> &'c str {
    let own = format!("{}/", suite.key_name());
    let rest = case.key.strip_prefix(&format!("{own}recorded=")).or_else(|| case.key.strip_prefix(&own));
    let values = case.variation.iter().map(|one| format!("/{}={}", one.name, one.label));
    let trial = format!("{}{}", case.scenario, values.collect::<String>());
    rest.and_then(|rest| rest.strip_prefix(&trial)).unwrap_or_default()
}

/// Makes two runs on the same noise and lays them side by side.
///
/// # Errors
/// The first that could not be made.
///
/// # Panics
/// If they have different seeds: they would differ by chance; and as runs do.
pub fn two_runs(batch: RunBatch, a: &Case, b: &Case) -> Result<TwoRuns, BatchError> {
    assert_eq!(a.seed, b.seed, "two runs are laid side by side on the same noise");
    let ran = [batch.one(a, Wanted::Everything)?, batch.one(b, Wanted::Everything)?];
    let [in_a, in_b] = [Side { case: a, ran: &ran[0] }, Side { case: b, ran: &ran[1] }];
    let both = Both { a: in_a, b: in_b };
    let first = both.part(&Least { length: 0.0, speed: 0.0, bits: true });
    let apart = both.part(&Least { length: PARTED_LENGTH, speed: PARTED_SPEED, bits: false });
    let touched = [both.a, both.b].map(Side::contacts);
    let moments = both.moments(apart.as_ref().or(first.as_ref()), &touched);
    let differs = differences(a, b);
    let [(a, in_a), (b, in_b)] = [(a, &ran[0]), (b, &ran[1])].map(|(case, ran)| {
        let recording = Recording::new(case, &ran.trace, ran.events.clone());
        (recording.with(ran.details.as_deref()), ran.outcome.clone())
    });
    let [of_a, of_b] = touched;
    Ok(TwoRuns {
        a: OneOfTwo { outcome: in_a, contacts: of_a, recording: a },
        b: OneOfTwo { outcome: in_b, contacts: of_b, recording: b },
        differs,
        first,
        apart,
        moments,
    })
}

/// One of two runs.
#[derive(Clone, Copy)]
struct Side<'r> {
    case: &'r Case,
    ran: &'r Ran,
}

impl Side<'_> {
    fn contacts(self) -> Vec<ContactMoment> {
        contacts(self.case, &self.ran.events, &self.ran.trace).collect()
    }
}

struct Both<'r> {
    a: Side<'r>,
    b: Side<'r>,
}

/// What counts as a difference.
struct Least {
    /// More than that, m.
    length: f64,
    /// More than that, m/s.
    speed: f64,
    /// Whether every bit counts, of decisions and of what happens, too.
    bits: bool,
}

impl Both<'_> {
    /// The first moment at which they differ.
    fn part(&self, least: &Least) -> Option<Parting> {
        let mut found = vec![self.states(least), self.ending()];
        if least.bits {
            found.extend([self.events(true), self.decisions(), self.events(false)]);
        }
        let found: Vec<Parting> = found.into_iter().flatten().collect();
        let time = found.iter().map(|one| one.time).min_by(f64::total_cmp);
        let Some(time) = time else {
            // Bits that no moment has that both runs have in common.
            let fingerprints = [self.a, self.b].map(|side| side.ran.outcome.fingerprint);
            let end = self.a.ran.outcome.ending.time;
            return (least.bits && fingerprints[0] != fingerprints[1])
                .then(|| Parting { time: end, by: Vec::new() });
        };
        let at_once = found.into_iter().filter(|one| one.time < time + SAME);
        Some(Parting { time, by: at_once.flat_map(|one| one.by).collect() })
    }

    /// Until when both go on, s.
    fn common_end(&self) -> f64 {
        let [a, b] = [self.a, self.b].map(|side| side.ran.outcome.ending.time);
        a.min(b)
    }

    /// Everybody of both, vehicles first, in the order of A, by their places in both.
    fn everybody(&self) -> Vec<(String, Option<usize>, Option<usize>)> {
        let [a, b] = [self.a, self.b].map(|side| names(&side.case.world));
        let place = |all: &[String], name: &String| all.iter().position(|one| one == name);
        let mut all: Vec<_> = a.iter().map(|name| (name.clone(), place(&a, name), place(&b, name))).collect();
        let only_b = b.iter().filter(|name| !a.contains(name));
        all.extend(only_b.map(|name| (name.clone(), None, place(&b, name))));
        all
    }

    fn states(&self, least: &Least) -> Option<Parting> {
        let everybody = self.everybody();
        let end = self.common_end();
        let (mut a, mut b) = (moments_of(&self.a), moments_of(&self.b));
        while let (Some((in_a, first)), Some((in_b, second))) = (a.peek(), b.peek()) {
            let (in_a, in_b) = (*in_a, *in_b);
            if in_a.min(in_b) > end + SAME {
                return None;
            }
            if (in_a - in_b).abs() < SAME {
                let found = |who: Option<usize>, rows: &[Sample]| -> Option<Sample> {
                    rows.iter().find(|row| Some(row.who) == who).cloned()
                };
                let by = everybody.iter().filter_map(|(name, one, other)| {
                    let what = parted((&found(*one, first), &found(*other, second)), least)?;
                    Some(PartsBy { who: name.clone(), what })
                });
                let by: Vec<PartsBy> = by.collect();
                if !by.is_empty() {
                    return Some(Parting { time: in_a.min(in_b), by });
                }
            }
            // A moment inside a step at which something touches is there in one run only.
            if in_a < in_b + SAME {
                a.next();
            }
            if in_b < in_a + SAME {
                b.next();
            }
        }
        None
    }

    fn ending(&self) -> Option<Parting> {
        let [a, b] = [self.a, self.b].map(|side| side.ran.outcome.ending);
        let by = vec![PartsBy { who: String::new(), what: PartedIn::Ending { a, b } }];
        (a != b).then(|| Parting { time: self.common_end(), by })
    }

    /// What happens: whom somebody is shown to and what touches, or what models say they are up to.
    fn events(&self, sights: bool) -> Option<Parting> {
        let counts = |event: &&TimelineEvent| match &event.what {
            Happening::ComesIntoSight { .. }
            | Happening::IsLostFromSight { .. }
            | Happening::Collides { .. }
            | Happening::Touches { .. } => sights,
            Happening::Mode(_) => !sights,
            _ => false,
        };
        let end = self.common_end();
        let [a, b] = [self.a, self.b].map(|side| {
            let all = side.ran.events.iter().filter(counts);
            all.filter(|event| event.time <= end + SAME).collect::<Vec<_>>()
        });
        let lacks = |all: &[&TimelineEvent], event: &TimelineEvent| !all.contains(&event);
        let only_a = a.iter().filter(|event| lacks(&b, event)).map(|event| (*event, true));
        let only_b = b.iter().filter(|event| lacks(&a, event)).map(|event| (*event, false));
        let only: Vec<(&TimelineEvent, bool)> = only_a.chain(only_b).collect();
        let time = only.iter().map(|(event, _)| event.time).min_by(f64::total_cmp)?;
        let mut by: Vec<PartsBy> = Vec::new();
        for (event, is_in_a) in only.into_iter().filter(|(event, _)| event.time < time + SAME) {
            let what = Some(event.what.clone());
            // The same of one road user in both is told as one.
            let known = by.iter_mut().find(|one| {
                let is_open = matches!(&one.what, PartedIn::Event { a: Some(_), b: None });
                one.who == event.who && is_open && !is_in_a
            });
            match known {
                Some(PartsBy { what: PartedIn::Event { b, .. }, .. }) => *b = what,
                _ => {
                    let (a, b) = if is_in_a { (what, None) } else { (None, what) };
                    by.push(PartsBy { who: event.who.clone(), what: PartedIn::Event { a, b } });
                }
            }
        }
        Some(Parting { time, by })
    }

    /// What vehicles are told, from each decision until the next.
    fn decisions(&self) -> Option<Parting> {
        let end = self.common_end();
        let mut found: Option<Parting> = None;
        for (name, one, other) in self.everybody() {
            let (Some(one), Some(other)) = (one, other) else { continue };
            let commands = [(self.a, one), (self.b, other)].map(|(side, who)| side.ran.commands.get(who));
            let [Some(a), Some(b)] = commands else { continue };
            let mut times: Vec<f64> = a.iter().chain(b).map(|one| one.time).collect();
            times.sort_by(f64::total_cmp);
            let parts = times.into_iter().filter(|time| *time < end - SAME).find_map(|time| {
                let (a, b) = (in_force(a, time), in_force(b, time));
                let is_same = match (a, b) {
                    (Some(a), Some(b)) => same_command(&a, &b),
                    (a, b) => a.is_none() && b.is_none(),
                };
                let [a, b] = [a, b].map(|given| given.map(|given| given.command));
                (!is_same).then_some((time, PartedIn::Decision { a, b }))
            });
            let Some((time, what)) = parts else { continue };
            let by = PartsBy { who: name, what };
            match &mut found {
                Some(known) if (known.time - time).abs() < SAME => known.by.push(by),
                Some(known) if known.time < time => {}
                _ => found = Some(Parting { time, by: vec![by] }),
            }
        }
        found
    }

    /// Moments that are spread over the longer run, the one at which they part, and the first contact of each.
    fn moments(&self, parting: Option<&Parting>, touched: &[Vec<ContactMoment>; 2]) -> Vec<SharedMoment> {
        let [a, b] = [self.a, self.b].map(|side| side.ran.outcome.ending.time);
        let end = a.max(b);
        let step = self.a.case.world.step;
        let spread = (0..MOMENTS).map(|number| {
            let time = end * number as f64 / (MOMENTS - 1) as f64;
            if number + 1 == MOMENTS { end } else { (time / step).round() * step }
        });
        let touch = touched.iter().filter_map(|contacts| contacts.first()).map(|contact| contact.time);
        let mut times: Vec<f64> = spread.chain(parting.map(|parting| parting.time)).chain(touch).collect();
        times.sort_by(f64::total_cmp);
        times.dedup_by(|one, other| (*one - *other).abs() < SAME);
        let everybody = self.everybody();
        let moment = |time: f64| {
            let each = everybody.iter().map(|(name, one, other)| InBoth {
                who: name.clone(),
                a: doing(&self.a, *one, time),
                b: doing(&self.b, *other, time),
            });
            SharedMoment { time, each: each.collect() }
        };
        times.into_iter().map(moment).collect()
    }
}

/// The names of everybody, vehicles first.
fn names(world: &World) -> Vec<String> {
    let cars = world.vehicles.iter().map(|car| &car.name);
    cars.chain(world.pedestrians.iter().map(|person| &person.name)).cloned().collect()
}

/// The recorded moments of a run with everybody who is there.
fn moments_of<'r>(side: &Side<'r>) -> Peekable<impl Iterator<Item = (f64, &'r [Sample])> + use<'r>> {
    let chunks = side.ran.trace.samples.chunk_by(|one, other| (one.time - other.time).abs() < SAME);
    chunks.map(|rows| (rows[0].time, rows)).peekable()
}

/// What differs of somebody at one moment.
fn parted((a, b): (&Option<Sample>, &Option<Sample>), least: &Least) -> Option<PartedIn> {
    let (a, b) = match (a, b) {
        (Some(a), Some(b)) => (a, b),
        (None, None) => return None,
        (in_a, _) => return Some(PartedIn::Presence { in_a: in_a.is_some() }),
    };
    let apart = (a.position - b.position).norm();
    let relative_speed = (a.velocity - b.velocity).norm();
    let differs = match least.bits {
        true => bits(a) != bits(b),
        false => apart > least.length || relative_speed > least.speed,
    };
    let (a, b) = (a.velocity.norm(), b.velocity.norm());
    differs.then_some(PartedIn::Motion { apart, relative_speed, a, b })
}

/// Every bit of where somebody is and how they move.
fn bits(sample: &Sample) -> [u64; 8] {
    let Sample { position, heading, travelled, velocity, acceleration, .. } = sample;
    let travelled = travelled.unwrap_or_default();
    let numbers =
        [position.x, position.y, heading.x, heading.y, velocity.x, velocity.y, travelled, *acceleration];
    numbers.map(f64::to_bits)
}

/// What a vehicle follows at `time` (s).
fn in_force(commands: &[GivenCommand], time: f64) -> Option<GivenCommand> {
    let after = commands.partition_point(|one| one.time <= time + SAME);
    after.checked_sub(1).map(|last| commands[last])
}

fn same_command(one: &GivenCommand, other: &GivenCommand) -> bool {
    use sim::Command::{Acceleration, Pedals};
    match (one.command, other.command) {
        (Acceleration(one), Acceleration(other)) => one.to_bits() == other.to_bits(),
        (Pedals { throttle, brake }, Pedals { throttle: other_throttle, brake: other_brake }) => {
            throttle.to_bits() == other_throttle.to_bits() && brake.to_bits() == other_brake.to_bits()
        }
        _ => false,
    }
}

fn doing(side: &Side, who: Option<usize>, time: f64) -> Option<Doing> {
    let who = who?;
    if time > side.ran.outcome.ending.time + SAME {
        return None;
    }
    let samples = &side.ran.trace.samples;
    let until = samples.partition_point(|sample| sample.time <= time + SAME);
    let last = samples[..until].last()?.time;
    let now = samples[..until].iter().rev().take_while(|sample| sample.time > last - SAME);
    let sample = now.into_iter().find(|sample| sample.who == who)?;
    let (x, y) = (sample.position.x, sample.position.y);
    Some(Doing { x, y, speed: sample.velocity.norm(), activity: sample.mode.to_string() })
}
