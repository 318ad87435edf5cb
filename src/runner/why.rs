//! The story of one run, and what would have come of it had something gone otherwise: each a run of its own.

use crate::run::{BatchError, Ran, RunBatch, Wanted};
use results::judge::{PerRun, per_run};
use results::{
    CameOf, ContactMoment, FirstSeen, Otherwise, OtherwiseRun, Outcome, Requests, Story, TriedDeceleration,
    WhatIf,
};
use scenario::{Appearance, Case, Criterion};
use sim::{GivenCommand, Happening, RunChange, Sample, TimelineEvent, Trace, brakes};

/// How much earlier a vehicle would have braked, s.
const EARLIER: f64 = 0.5;
/// How much later somebody would have come, s.
const LATER: f64 = 0.2;
/// To this the smallest deceleration that is enough is found, m/s².
const UNIT: f64 = 0.01;
/// Between two decelerations that are always tried, in units.
const STEP: usize = 50;
/// The largest deceleration that is tried, in units.
const MOST: usize = 1000;

/// The story of a run, with what would have come of it where it does not have all that `criteria` want of each run, or a vehicle touched
/// something.
///
/// # Errors
/// As for [`RunBatch::one`], of the run itself. One in which something goes otherwise and that does not come to its end is told as such.
///
/// # Panics
/// As a run does.
pub fn story(batch: RunBatch, case: &Case, criteria: &[Criterion]) -> Result<Story, BatchError> {
    let Ran { outcome, trace, events, commands, .. } = batch.one(case, Wanted::Commands)?;
    let first_seen = first_seen(case, &events, &trace);
    let contact = first_contact(case, &events, &trace);
    let mut story = Story { outcome, trace, events, first_seen, contact, otherwise: Vec::new() };
    let (against, _) = against(criteria, &story.outcome, &batch.measured.requests, true);
    if !against.is_empty() || story.contact.is_some() {
        let what_ifs = WhatIfs { batch, case, criteria, story: &story, commands: &commands };
        story.otherwise = what_ifs.all()?;
    }
    Ok(story)
}

/// What a run does not have that criteria want of each, in canonical words, and how many criteria want something of it: those whose metric
/// does not exist in it only where that is `undefined`.
fn against(
    criteria: &[Criterion],
    outcome: &Outcome,
    requests: &Requests,
    undefined: bool,
) -> (Vec<String>, usize) {
    let exists = |one: &PerRun| {
        let index = requests.index(one.criterion.claim.metric());
        undefined
            || index.is_some_and(|index| outcome.metrics[index].is_some() || outcome.open(index).is_some())
    };
    let wanted = criteria.iter().filter_map(per_run).filter(exists);
    let standings: Vec<_> = wanted.map(|one| one.standing(outcome, requests)).collect();
    let number = standings.len();
    (standings.into_iter().filter(|one| !one.holds).map(|one| one.criterion).collect(), number)
}

/// Where a road user is at the end of the step in which `time` (s) is, or at that moment where it is recorded.
fn at(trace: &Trace, who: usize, time: f64) -> Option<&Sample> {
    trace.samples.iter().find(|sample| sample.who == who && sample.time >= time - 1e-9)
}

fn first_seen(case: &Case, events: &[TimelineEvent], trace: &Trace) -> Vec<FirstSeen> {
    let (world, cars) = (&case.world, case.world.vehicles.len());
    let mut all = Vec::new();
    for (vehicle, car) in world.vehicles.iter().enumerate() {
        for (pedestrian, person) in world.pedestrians.iter().enumerate() {
            let is_shown = |event: &&TimelineEvent| {
                event.who == person.name
                    && matches!(&event.what, Happening::ComesIntoSight { of } if *of == car.name)
            };
            let appears =
                |event: &&TimelineEvent| event.who == person.name && matches!(event.what, Happening::Appears);
            let time = match &car.sees {
                Some(_) => events.iter().find(is_shown).map(|event| event.time),
                None => events.iter().find(appears).map(|event| event.time),
            };
            let both =
                time.and_then(|time| Some((at(trace, vehicle, time)?, at(trace, cars + pedestrian, time)?)));
            all.push(FirstSeen {
                vehicle: car.name.clone(),
                pedestrian: person.name.clone(),
                time,
                distance: both.map(|(car, person)| (car.position - person.position).norm()),
                speed: both.map(|(car, _)| car.velocity.norm()),
                sees_everything: car.sees.is_none(),
            });
        }
    }
    all.sort_by(|one, other| {
        one.time.unwrap_or(f64::INFINITY).total_cmp(&other.time.unwrap_or(f64::INFINITY))
    });
    all
}

/// The first contact of a vehicle.
fn first_contact(case: &Case, events: &[TimelineEvent], trace: &Trace) -> Option<ContactMoment> {
    contacts(case, events, trace).next()
}

/// Every contact of a vehicle, in the order of time.
pub(crate) fn contacts<'r>(
    case: &'r Case,
    events: &'r [TimelineEvent],
    trace: &'r Trace,
) -> impl Iterator<Item = ContactMoment> + use<'r> {
    let world = &case.world;
    let vehicle = |name: &str| world.vehicles.iter().position(|car| car.name == name);
    events.iter().filter_map(move |event| {
        let Happening::Collides { with, relative_speed } = &event.what else { return None };
        let (car, other) = match (vehicle(&event.who), vehicle(with)) {
            (Some(struck), Some(car)) if strikes(trace, car, struck, event.time) => (car, &event.who),
            (Some(car), _) => (car, with),
            (None, Some(car)) => (car, &event.who),
            (None, None) => return None,
        };
        let sample = at(trace, car, event.time)?;
        let person = world.pedestrians.iter().position(|one| one.name == *other);
        let person = person.and_then(|person| at(trace, world.vehicles.len() + person, event.time));
        let place = person.unwrap_or(sample).position;
        Some(ContactMoment {
            time: event.time,
            vehicle: world.vehicles[car].name.clone(),
            with: other.clone(),
            relative_speed: *relative_speed,
            speed: sample.velocity.norm(),
            place: (place.x, place.y),
        })
    })
}

/// Whether of two vehicles that touch the first moves towards the other faster than the other towards it.
fn strikes(trace: &Trace, one: usize, other: usize, time: f64) -> bool {
    let (Some(one), Some(other)) = (at(trace, one, time), at(trace, other, time)) else { return false };
    let way = other.position - one.position;
    one.velocity.dot(&way) > -other.velocity.dot(&way)
}

/// The road users that a failure is about, by index.
#[derive(Debug, Clone, Copy, Default)]
struct About {
    vehicle: Option<usize>,
    /// The pedestrian that the vehicle met; `None` where it touched something else.
    pedestrian: Option<usize>,
    /// The vehicle that it touched.
    touched: Option<usize>,
    /// The pedestrian to vary: the first one where the failure is about none.
    anybody: Option<usize>,
}

/// Asks what would have come of a run.
struct WhatIfs<'a> {
    batch: RunBatch<'a>,
    case: &'a Case,
    criteria: &'a [Criterion],
    story: &'a Story,
    commands: &'a [Vec<GivenCommand>],
}

impl WhatIfs<'_> {
    fn all(&self) -> Result<Vec<WhatIf>, BatchError> {
        let mut all = Vec::new();
        let about = self.about();
        if let Some(vehicle) = about.vehicle {
            let seen = self.seen(vehicle, &about);
            let braked = self.braked(vehicle, &about, seen);
            all.push(self.earlier(vehicle, seen, braked)?);
            all.push(self.evenly(vehicle, &about, seen, braked)?);
        }
        if let Some(pedestrian) = about.anybody {
            all.push(self.later(pedestrian)?);
        }
        all.push(self.nobody()?);
        Ok(all)
    }

    /// Of the first contact, or of the first criterion that the run speaks against; else the first of all.
    fn about(&self) -> About {
        let world = &self.case.world;
        let requests = &self.batch.measured.requests;
        let standings = self.criteria.iter().filter_map(per_run);
        let standings = standings.map(|one| one.standing(&self.story.outcome, requests));
        let mut standings = standings;
        let standing = standings.find(|one| !one.holds);
        let (car, other) = match (&self.story.contact, &standing) {
            (Some(contact), _) => (Some(&*contact.vehicle), Some(&*contact.with)),
            (None, Some(standing)) => (standing.vehicle.as_deref(), standing.pedestrian.as_deref()),
            (None, None) => (None, None),
        };
        let vehicle = |name: &str| world.vehicles.iter().position(|one| one.name == name);
        let car = car.and_then(vehicle);
        let person = other.and_then(|name| world.pedestrians.iter().position(|one| one.name == name));
        let first = |some: bool| some.then_some(0);
        let anybody = person.or(first(!world.pedestrians.is_empty()));
        About {
            vehicle: car.or(first(!world.vehicles.is_empty())),
            pedestrian: if self.story.contact.is_some() { person } else { anybody },
            touched: other.filter(|_| self.story.contact.is_some()).and_then(vehicle),
            anybody,
        }
    }

    /// When the vehicle first saw the other party, s.
    fn seen(&self, vehicle: usize, about: &About) -> Option<f64> {
        let world = &self.case.world;
        let car = &world.vehicles[vehicle];
        if let Some(pedestrian) = about.pedestrian {
            let name = &world.pedestrians[pedestrian].name;
            let is_it = |one: &&FirstSeen| one.vehicle == car.name && one.pedestrian == *name;
            return self.story.first_seen.iter().find(is_it)?.time;
        }
        let Some(touched) = about.touched.filter(|_| car.sees.is_some()) else { return Some(0.0) };
        let is_it = |event: &&TimelineEvent| {
            event.who == world.vehicles[touched].name
                && matches!(&event.what, Happening::ComesIntoSight { of } if *of == car.name)
        };
        Some(self.story.events.iter().find(is_it)?.time)
    }

    /// When a vehicle first began to brake once `seen` (s); of one that touched something else than a person, when it last did before that,
    /// s.
    fn braked(&self, vehicle: usize, about: &About, seen: Option<f64>) -> Option<f64> {
        let name = &self.case.world.vehicles[vehicle].name;
        let end = self.story.contact.as_ref().map_or(f64::INFINITY, |contact| contact.time);
        let is_it = |event: &&TimelineEvent| {
            event.who == *name
                && matches!(event.what, Happening::Brakes { .. })
                && seen.is_none_or(|seen| event.time >= seen - 1e-9)
                && event.time <= end
        };
        let mut began = self.story.events.iter().filter(is_it).map(|event| event.time);
        if about.pedestrian.is_some() { began.next() } else { began.next_back() }
    }

    fn earlier(&self, vehicle: usize, seen: Option<f64>, braked: Option<f64>) -> Result<WhatIf, BatchError> {
        let name = self.case.world.vehicles[vehicle].name.clone();
        let Some(braked) = braked else {
            let because = format!(
                "{name} did not brake{}",
                if seen.is_some_and(|seen| seen > 0.0) { " once it was shown them" } else { "" }
            );
            let what = Otherwise::BrakesEarlier { vehicle: name, by: EARLIER, from: None };
            return Ok(WhatIf { what, came: CameOf::DoesNotApply { because } });
        };
        let (change, from) = brakes_earlier(self.commands, vehicle, braked, EARLIER, &self.story.outcome);
        let what = Otherwise::BrakesEarlier { vehicle: name, by: EARLIER, from: Some(from) };
        Ok(WhatIf { what, came: CameOf::Run(Box::new(self.run(&change)?)) })
    }

    fn evenly(
        &self,
        vehicle: usize,
        about: &About,
        seen: Option<f64>,
        braked: Option<f64>,
    ) -> Result<WhatIf, BatchError> {
        let name = self.case.world.vehicles[vehicle].name.clone();
        let what = Otherwise::Decelerates {
            vehicle: name.clone(),
            from: braked.or(seen),
            is_first_braking: braked.is_some(),
        };
        let Some(from) = braked.or(seen) else {
            let because = format!("{name} neither braked nor was shown anybody");
            return Ok(WhatIf { what, came: CameOf::DoesNotApply { because } });
        };
        let tried = self.decelerations(|deceleration| RunChange::Decelerates {
            vehicle,
            from,
            deceleration,
            until_gone: about.pedestrian,
        })?;
        Ok(WhatIf { what, came: CameOf::Decelerations(tried) })
    }

    /// Runs at decelerations, the smallest first: those that are always tried, and those that show the smallest that is enough to 0.01 m/s².
    fn decelerations(&self, change: impl Fn(f64) -> RunChange) -> Result<Vec<TriedDeceleration>, BatchError> {
        let at = |number: usize| {
            let deceleration = number as f64 * UNIT;
            Ok::<_, BatchError>(TriedDeceleration { deceleration, run: self.run(&change(deceleration))? })
        };
        let mut tried = (0..=MOST / STEP).map(|number| at(number * STEP)).collect::<Result<Vec<_>, _>>()?;
        if let Some(first @ 1..) = tried.iter().position(|one| self.is_enough(&one.run)) {
            let (mut low, mut high) = ((first - 1) * STEP, first * STEP);
            while high - low > 1 {
                let middle = (low + high) / 2;
                tried.push(at(middle)?);
                let is_enough = tried.last().is_some_and(|one| self.is_enough(&one.run));
                *(if is_enough { &mut high } else { &mut low }) = middle;
            }
        }
        tried.sort_by(|one, other| one.deceleration.total_cmp(&other.deceleration));
        Ok(tried)
    }

    /// Whether a run has no contact, where the run itself has one; else whether it has all that is wanted of it.
    fn is_enough(&self, run: &OtherwiseRun) -> bool {
        let avoids = run.error.is_none() && run.contact.is_none();
        avoids && (self.story.contact.is_some() || run.against.is_empty() && !run.cut_off)
    }

    fn later(&self, pedestrian: usize) -> Result<WhatIf, BatchError> {
        let person = &self.case.world.pedestrians[pedestrian];
        let what = Otherwise::AppearsLater { pedestrian: person.name.clone(), by: LATER };
        let came = match person.appears {
            Appearance::At(time) if time <= 0.0 => {
                CameOf::DoesNotApply { because: format!("{} is there from the start", person.name) }
            }
            _ => CameOf::Run(Box::new(self.run(&RunChange::AppearsLater { pedestrian, by: LATER })?)),
        };
        Ok(WhatIf { what, came })
    }

    fn nobody(&self) -> Result<WhatIf, BatchError> {
        let came = match self.case.world.pedestrians.is_empty() {
            true => CameOf::DoesNotApply { because: "there are no pedestrians in it".to_string() },
            // What is asked of meetings has no value then.
            false => CameOf::Run(Box::new(self.run_where(&RunChange::NobodyAppears, false)?)),
        };
        Ok(WhatIf { what: Otherwise::NobodyAppears, came })
    }

    fn run(&self, change: &RunChange) -> Result<OtherwiseRun, BatchError> {
        self.run_where(change, true)
    }

    /// What came of a change; `undefined` speaks against a criterion where that is so in the run itself.
    fn run_where(&self, change: &RunChange, undefined: bool) -> Result<OtherwiseRun, BatchError> {
        let requests = &self.batch.measured.requests;
        match self.batch.one_otherwise(self.case, Some(change), Wanted::TraceAndEvents) {
            Ok(ran) => {
                let contact = first_contact(self.case, &ran.events, &ran.trace);
                let (against, criteria) = against(self.criteria, &ran.outcome, requests, undefined);
                Ok(OtherwiseRun {
                    passes: against.is_empty() && criteria > 0,
                    criteria,
                    against,
                    contact: contact.map(|contact| contact.relative_speed),
                    cut_off: ran.outcome.hides_meetings(),
                    outcome: Some(ran.outcome),
                    error: None,
                })
            }
            Err(BatchError::Run { error, .. }) => Ok(OtherwiseRun {
                passes: false,
                criteria: 0,
                against: Vec::new(),
                contact: None,
                cut_off: false,
                outcome: None,
                error: Some(error.to_string()),
            }),
            Err(error) => Err(error),
        }
    }
}

/// A vehicle that is told what it was told in a run, `by` s earlier, from that much before the commands with which it `braked` (s) on; with
/// that moment, s.
fn brakes_earlier(
    commands: &[Vec<GivenCommand>],
    vehicle: usize,
    braked: f64,
    by: f64,
    outcome: &Outcome,
) -> (RunChange, f64) {
    let commands = commands[vehicle].clone();
    let before = commands.iter().rev().skip_while(|one| one.time > braked + 1e-9);
    let began = before.take_while(|one| brakes(one.command)).last().map_or(braked, |one| one.time);
    let from = (began - by).max(0.0);
    (RunChange::BrakesEarlier { vehicle, from, by, commands, until: outcome.ending.time }, from)
}
