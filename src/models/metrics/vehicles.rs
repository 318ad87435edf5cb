//! How near two vehicles come to each other in place and time: where their ways cross, and everywhere else.

use scenario::{
    Absence, Declaration, Dimension, Metric, MetricKind, MetricRange, PathConflict, Scope, Stake, Worst,
};
use sim::geometry::{Footprint, apart};
use sim::measure::{
    Contact, Encounters, End, InStep, Meter, MetricContext, Open, difference, least_of, meters,
};
use sim::{Solid, Step, VehicleState, path_conflicts, vehicles_meet};

const CONFLICT: &str = "shared area: what the bodies of both sweep along their lanes where these cross, so that a vehicle is in it \
     while its rectangle touches the strip of the other's width; exact where both go straight on, in bends to 0.1 mm";

/// Two vehicles, and where their ways cross.
struct Crossing {
    pair: (usize, usize),
    conflicts: Vec<PathConflict>,
}

/// When a vehicle entered and left an area, s: minus infinity before the start, infinity if not yet.
type Stay = (f64, f64);

impl Crossing {
    /// `None` where there is no other vehicle.
    fn new(context: &MetricContext) -> Option<Self> {
        let Some(Solid::Vehicle(other)) = context.with else { return None };
        let conflicts = path_conflicts(context.world, context.vehicle, other);
        Some(Self { pair: (context.vehicle, other), conflicts })
    }

    fn contact(&self, encounters: &Encounters) -> Option<Contact> {
        encounters.contact(self.pair.0, Solid::Vehicle(self.pair.1))
    }

    /// When both were in each area; of whom was steered nobody knows by its lane alone.
    fn stays<'a>(&'a self, encounters: &'a Encounters) -> impl Iterator<Item = (Stay, Stay)> + 'a {
        let (one, other) = (encounters.passage(self.pair.0), encounters.passage(self.pair.1));
        let steered = [self.pair.0, self.pair.1].into_iter().any(|vehicle| encounters.was_steered(vehicle));
        self.conflicts.iter().filter(move |_| !steered).map(move |met| {
            let first = (one.reached(met.first.from).moment(), one.reached(met.first.to).moment());
            (first, (other.reached(met.second.from).moment(), other.reached(met.second.to).moment()))
        })
    }
}

pub fn vehicle_pet() -> Metric {
    let declaration = Declaration::new(
        "vehicle_pet",
        "Post-encroachment time of two vehicles whose ways cross: from the rear of the first leaving the shared area to the front of the \
         second entering it; 0 on a collision and on overlap in time, undefined if one of them never enters, was steered, or their ways do not cross.",
    )
    .source(format!("Allen, Shin & Cooper 1978; {CONFLICT}"))
    .on_request();
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Vehicles,
        worst: Worst::Smallest,
        absence: Absence::Open,
        range: MetricRange::WithinRun,
        stake: Stake::Vehicles,
        meters: meters(|context| Box::new(VehiclePet(Crossing::new(context)))),
    }
}

struct VehiclePet(Option<Crossing>);

impl VehiclePet {
    /// The smallest time between the two, and when the second of them entered.
    fn closest(&self, encounters: &Encounters) -> Option<(f64, f64)> {
        let crossing = self.0.as_ref()?;
        if let Some(contact) = crossing.contact(encounters) {
            return Some((0.0, contact.time));
        }
        let between = |((one_in, one_out), (other_in, other_out)): (Stay, Stay)| {
            let both = [one_in, other_in].into_iter().all(f64::is_finite);
            let time = difference(one_in, other_out).max(difference(other_in, one_out)).max(0.0);
            both.then(|| (time, one_in.max(other_in)))
        };
        let times = crossing.stays(encounters).filter_map(between);
        times.reduce(|one, other| if other.0 < one.0 { other } else { one })
    }
}

impl Meter for VehiclePet {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        self.closest(encounters).map(|(time, _)| time)
    }

    fn open(&self, encounters: &Encounters, end: &End) -> Option<Open> {
        let crossing = self.0.as_ref()?;
        if crossing.contact(encounters).is_some() {
            return None;
        }
        // Who has yet to enter comes no earlier than now.
        let least = |((one_in, one_out), (other_in, other_out)): (Stay, Stay)| match (
            one_in == f64::INFINITY,
            other_in == f64::INFINITY,
        ) {
            (false, false) => None,
            (true, true) => Some(0.0),
            (true, false) => Some((end.time - other_out).max(0.0)),
            (false, true) => Some((end.time - one_out).max(0.0)),
        };
        let low = crossing.stays(encounters).filter_map(least).reduce(f64::min)?;
        let high = self.value(encounters).unwrap_or(f64::INFINITY);
        (low < high).then_some(Open { low, high })
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.closest(encounters).map(|(_, instant)| instant)
    }
}

pub fn entered_first() -> Metric {
    let declaration = Declaration::new(
        "entered_first",
        "Whether the first vehicle came to the area that both share before the second did; undefined if neither did, one was steered or their ways do not \
         cross, false if both came at once.",
    )
    .source(format!("order at the {CONFLICT}"))
    .on_request();
    Metric {
        declaration,
        kind: MetricKind::Flag,
        scope: Scope::Vehicles,
        worst: Worst::Neither,
        absence: Absence::Open,
        range: MetricRange::YesOrNo,
        stake: Stake::Vehicles,
        meters: meters(|context| Box::new(EnteredFirst(Crossing::new(context)))),
    }
}

struct EnteredFirst(Option<Crossing>);

impl EnteredFirst {
    /// Whether, and when the first of them came.
    fn first(&self, encounters: &Encounters) -> Option<(bool, f64)> {
        let mut stays = self.0.as_ref()?.stays(encounters);
        stays.find_map(|((one, _), (other, _))| {
            let came = one.min(other);
            (came < f64::INFINITY).then_some((one < other, came))
        })
    }
}

impl Meter for EnteredFirst {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        self.first(encounters).map(|(first, _)| f64::from(first))
    }

    fn open(&self, encounters: &Encounters, _: &End) -> Option<Open> {
        let crossing = self.0.as_ref().filter(|crossing| !crossing.conflicts.is_empty())?;
        let decided = crossing.contact(encounters).is_some() || self.first(encounters).is_some();
        (!decided).then_some(Open { low: 0.0, high: 1.0 })
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.first(encounters).map(|(_, came)| came)
    }
}

pub fn vehicle_ttc() -> Metric {
    let declaration = Declaration::new(
        "vehicle_ttc",
        "Smallest time to collision of two vehicles if both kept their speed along their lanes; 0 on a collision, undefined if they are \
         never on a collision course.",
    )
    .source(
        "Hayward 1972; exact contact time of the moving footprints, looked at after every step; in bends to 1e-9 m, by steps that no \
         contact can hide in, for no longer than 10 s",
    )
    .on_request();
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Vehicles,
        worst: Worst::Smallest,
        // A pair that was never in each other's way was not put to the test.
        absence: Absence::Open,
        range: MetricRange::NotNegative,
        stake: Stake::Vehicles,
        meters: meters(|context| {
            let others = match context.with {
                Some(Solid::Vehicle(other)) => Some((context.vehicle, other)),
                _ => None,
            };
            Box::new(VehicleTtc { pair: others, smallest: None, latest: None, since: 0.0 })
        }),
    }
}

struct VehicleTtc {
    pair: Option<(usize, usize)>,
    /// s, and when that was, s.
    smallest: Option<(f64, f64)>,
    /// At the end of the last step, s.
    latest: Option<f64>,
    /// When that step began, s.
    since: f64,
}

fn contact(pair: Option<(usize, usize)>, encounters: &Encounters) -> Option<Contact> {
    pair.and_then(|(one, other)| encounters.contact(one, Solid::Vehicle(other)))
}

impl Meter for VehicleTtc {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        let Some((one, other)) = self.pair else { return };
        let (one, other) = (&step.after.vehicles[one], &step.after.vehicles[other]);
        (self.latest, self.since) = (vehicles_meet(one, other), step.time);
        if let Some(time) = self.latest
            && self.smallest.is_none_or(|(smallest, _)| time < smallest)
        {
            self.smallest = Some((time, step.time + step.duration));
        }
    }

    fn value(&self, encounters: &Encounters) -> Option<f64> {
        match contact(self.pair, encounters) {
            Some(_) => Some(0.0),
            None => self.smallest.map(|(time, _)| time),
        }
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        match contact(self.pair, encounters) {
            Some(contact) => Some(contact.time),
            None => self.smallest.map(|(_, instant)| instant),
        }
    }

    fn in_step(&self, encounters: &Encounters) -> InStep {
        match contact(self.pair, encounters) {
            Some(contact) if contact.time >= self.since => InStep::Worst(0.0),
            _ => self.latest.into(),
        }
    }
}

pub fn vehicle_distance() -> Metric {
    let declaration = Declaration::new(
        "vehicle_distance",
        "Smallest distance between the footprints of two vehicles; 0 on a collision.",
    )
    .source("Euclidean distance of the footprints, also between the simulation's steps")
    .on_request();
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::LENGTH),
        scope: Scope::Vehicles,
        worst: Worst::Smallest,
        absence: Absence::Open,
        range: MetricRange::NotNegative,
        stake: Stake::Vehicles,
        meters: meters(|context| {
            let others = match context.with {
                Some(Solid::Vehicle(other)) => Some((context.vehicle, other)),
                _ => None,
            };
            Box::new(VehicleDistance { pair: others, smallest: None, latest: None, since: 0.0 })
        }),
    }
}

struct VehicleDistance {
    pair: Option<(usize, usize)>,
    /// m, and when that was, s.
    smallest: Option<(f64, f64)>,
    /// In the last step, m.
    latest: Option<f64>,
    /// When that began, s.
    since: f64,
}

fn between(one: &VehicleState, other: &VehicleState) -> f64 {
    apart(&Footprint::from(one), &Footprint::from(other))
}

/// How far any point of a vehicle came in a step, at most, m.
fn moved(before: &VehicleState, after: &VehicleState) -> f64 {
    let ((from, ahead), (to, turned)) = (before.pose(), after.pose());
    (to - from).norm() + (turned - ahead).norm() * libm::hypot(after.length, after.width) / 2.0
}

impl Meter for VehicleDistance {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        let Some((one, other)) = self.pair else { return };
        let (old_one, new_one) = (&step.before.vehicles[one], &step.after.vehicles[one]);
        let (old_other, new_other) = (&step.before.vehicles[other], &step.after.vehicles[other]);
        let (before, after) = (between(old_one, old_other), between(new_one, new_other));
        let mut smallest = self.smallest.unwrap_or((f64::INFINITY, step.time));
        let mut latest = f64::INFINITY;
        let mut consider = |distance: f64, part: f64| {
            latest = latest.min(distance);
            if distance < smallest.0 {
                smallest = (distance, step.time + part * step.duration);
            }
            smallest.0
        };
        consider(before, 0.0);
        let least = consider(after, 1.0);
        // Nothing comes nearer than it moves, so most steps need no look inside.
        if (before + after - moved(old_one, new_one) - moved(old_other, new_other)) / 2.0 < least {
            let mut at =
                |part: f64| between(&old_one.between(new_one, part), &old_other.between(new_other, part));
            let (distance, part) = least_of(&mut at);
            consider(distance, part);
        }
        self.smallest = Some(smallest);
        (self.latest, self.since) = (Some(latest), step.time);
    }

    fn value(&self, encounters: &Encounters) -> Option<f64> {
        match contact(self.pair, encounters) {
            Some(_) => Some(0.0),
            None => self.smallest.map(|(distance, _)| difference(distance, 0.0)),
        }
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        match contact(self.pair, encounters) {
            Some(contact) => Some(contact.time),
            None => self.smallest.map(|(_, instant)| instant),
        }
    }

    fn in_step(&self, encounters: &Encounters) -> InStep {
        match contact(self.pair, encounters) {
            Some(contact) if contact.time >= self.since => InStep::Worst(0.0),
            _ => self.latest.map(|distance| difference(distance, 0.0)).into(),
        }
    }
}
