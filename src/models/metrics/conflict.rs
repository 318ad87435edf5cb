//! Who passes the conflict point when: post-encroachment times, order and accepted gaps.
//!
//! The conflict point is where the vehicle's path (the centre line of its lane) and the pedestrian's actual path
//! cross. A pedestrian who retreats passes the line several times, each time at a conflict point of its own.

use super::travel::standing;
use scenario::{Absence, Metric, MetricKind, MetricRange, Scope, Stake, Worst};
use scenario::{ChoiceOption, Declaration, Dimension, Parameter};
use sim::measure::Reached;
use sim::measure::{
    Encounter, Encounters, End, Meter, MetricContext, Open, Passing, Visit, difference, meters,
};

fn zero_on_collision_parameter() -> Parameter {
    Parameter::flag(
        "zero_on_collision",
        true,
        "Whether a collision counts as 0 s, though the run may end before anybody \
         passes; otherwise as undefined.",
        "both were at one place at one time",
    )
}

/// The parameter that says how large a time may count.
const AT_MOST: &str = "at_most";

fn at_most_parameter() -> Parameter {
    Parameter::optional(
        AT_MOST,
        Dimension::TIME,
        (0.1, 600.0),
        "Larger times count as this one; without it, each as what it is.",
        "times beyond a few seconds say nothing of safety; a mean over them would be about nothing else",
    )
}

pub fn pet() -> Metric {
    let declaration = Declaration::new(
        "pet",
        "Post-encroachment time: between the centres of the two passing the conflict \
         point. The smallest over all passings if the pedestrian retreats; undefined \
         if one of them never passes.",
    )
    .source("|t_ped - t_veh| by centres; Peesapati et al. 2018")
    .parameters([zero_on_collision_parameter(), at_most_parameter()]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Pair,
        worst: Worst::Smallest,
        absence: Absence::Open,
        range: MetricRange::WithinRunUpTo(AT_MOST.into()),
        stake: Stake::MeetingInTime,
        meters: meters(|context| {
            Box::new(Pet {
                pair: pair(context),
                zero_on_collision: zero_on_collision(context),
                at_most: at_most(context),
            })
        }),
    }
}

struct Pet {
    pair: (usize, usize),
    zero_on_collision: bool,
    /// s; infinite where nothing is said.
    at_most: f64,
}

impl Pet {
    /// The smallest time between the two, and when the second of them passed.
    fn closest(&self, encounters: &Encounters) -> Option<(f64, f64)> {
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        if let Some(contact) = encounter.contact {
            return self.zero_on_collision.then_some((0.0, contact.time));
        }
        let between = |passing: &Passing| {
            let vehicle = encounters.passage(self.pair.0).reached(passing.place).time()?;
            Some((difference(vehicle, passing.time).abs(), vehicle.max(passing.time)))
        };
        encounter.passings.iter().filter_map(between).reduce(smaller)
    }
}

impl Meter for Pet {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        self.closest(encounters).map(|(time, _)| time.min(self.at_most))
    }

    fn open(&self, encounters: &Encounters, end: &End) -> Option<Open> {
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        let passage = encounters.passage(self.pair.0);
        let coming = |place: f64, since: f64| match passage.reached(place) {
            Reached::NotYet => Some(end.time - since),
            Reached::At(_) | Reached::BeforeStart => None,
        };
        let low = match encounter.final_passing() {
            Some(passing) => coming(passing.place, passing.time)?,
            // Who passes later passes where it is now, for all that is known.
            None => match passage.reached(here(self.pair, end)) {
                Reached::NotYet => 0.0,
                Reached::At(time) => end.time - time,
                Reached::BeforeStart => return None,
            },
        };
        still_open(encounter, low, self.value(encounters), self.at_most)
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.closest(encounters).map(|(_, instant)| instant)
    }
}

/// Where the pedestrian stands when time is up, along the vehicle's lane, m.
fn here((vehicle, pedestrian): (usize, usize), end: &End) -> f64 {
    end.state.vehicles[vehicle].path.along(end.state.pedestrians[pedestrian].position)
}

/// A time between two of which one has yet to come, at least `low` and counted as no more than `at_most` (s), unless a smaller one was
/// seen or they have met.
fn still_open(encounter: &Encounter, low: f64, value: Option<f64>, at_most: f64) -> Option<Open> {
    let high = value.unwrap_or(f64::INFINITY);
    let open = encounter.crosses && encounter.appeared.is_some() && encounter.contact.is_none() && low < high;
    open.then_some(Open { low: low.min(at_most), high: high.min(at_most) })
}

/// The first of the smaller values.
fn smaller(one: (f64, f64), other: (f64, f64)) -> (f64, f64) {
    if other.0 < one.0 { other } else { one }
}

pub fn pet_area() -> Metric {
    let declaration = Declaration::new(
        "pet_area",
        "Post-encroachment time by footprints: from the rear of the first leaving the \
         shared area to the front of the second entering it; 0 on overlap in time, \
         undefined if one of them never enters.",
    )
    .source(
        "Allen, Shin & Cooper 1978; Varhelyi 1998. The shared area is the strip that \
         the vehicle sweeps, as far along the road as the pedestrian's footprint \
         reaches while in it; every visit counts, the smallest time wins",
    )
    .parameters([zero_on_collision_parameter(), at_most_parameter()]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Pair,
        worst: Worst::Smallest,
        absence: Absence::Open,
        range: MetricRange::WithinRunUpTo(AT_MOST.into()),
        stake: Stake::MeetingInTime,
        meters: meters(|context| {
            let half_length = context.world.vehicles[context.vehicle].length / 2.0;
            let zero_on_collision = zero_on_collision(context);
            Box::new(PetArea {
                pair: pair(context),
                half_length,
                zero_on_collision,
                at_most: at_most(context),
            })
        }),
    }
}

struct PetArea {
    pair: (usize, usize),
    half_length: f64,
    zero_on_collision: bool,
    /// s; infinite where nothing is said.
    at_most: f64,
}

impl PetArea {
    /// The smallest time between the two, and when the second of them entered.
    fn closest(&self, encounters: &Encounters) -> Option<(f64, f64)> {
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        if let Some(contact) = encounter.contact {
            return self.zero_on_collision.then_some((0.0, contact.time));
        }
        let passage = encounters.passage(self.pair.0);
        let between = |visit: &Visit| {
            let enters = passage.reached(visit.low - self.half_length).moment();
            let leaves = passage.reached(visit.high + self.half_length).moment();
            let was_there = enters < f64::INFINITY && leaves > f64::NEG_INFINITY;
            let time = difference(enters, visit.to).max(difference(visit.from, leaves)).max(0.0);
            was_there.then(|| (time, enters.max(visit.from)))
        };
        encounter.visits.iter().filter_map(between).reduce(smaller)
    }
}

impl Meter for PetArea {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        self.closest(encounters).map(|(time, _)| time.min(self.at_most))
    }

    fn open(&self, encounters: &Encounters, end: &End) -> Option<Open> {
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        let passage = encounters.passage(self.pair.0);
        let low = match (encounter.final_passing(), encounter.visits.last()) {
            (Some(_), Some(visit)) => match passage.reached(visit.low - self.half_length) {
                Reached::NotYet if visit.to < f64::INFINITY => end.time - visit.to,
                Reached::NotYet => 0.0,
                Reached::At(_) | Reached::BeforeStart => return None,
            },
            _ => match passage.reached(here(self.pair, end) + self.half_length) {
                Reached::NotYet => 0.0,
                Reached::At(time) => end.time - time,
                Reached::BeforeStart => return None,
            },
        };
        still_open(encounter, low, self.value(encounters), self.at_most)
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.closest(encounters).map(|(_, instant)| instant)
    }
}

const NOBODY: f64 = 0.0;
const PEDESTRIAN: f64 = 1.0;
const VEHICLE: f64 = 2.0;

pub fn passed_first() -> Metric {
    let declaration = Declaration::new(
        "passed_first",
        "Whose centre passed the conflict point first; of a pedestrian who retreats, \
         the passing that was carried through counts.",
    )
    .source(
        "order at the conflict point as in pet; where the pedestrian never passes, the \
         vehicle does so opposite its start",
    );
    Metric {
        declaration,
        kind: MetricKind::Category(vec!["none".into(), "pedestrian".into(), "vehicle".into()]),
        scope: Scope::Pair,
        worst: Worst::Largest,
        absence: Absence::Open,
        range: MetricRange::Unlimited,
        stake: Stake::Order,
        meters: meters(|context| Box::new(PassedFirst(Order::new(context)))),
    }
}

struct PassedFirst(Order);

impl Meter for PassedFirst {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        Some(self.0.first(encounters).0)
    }

    fn open(&self, encounters: &Encounters, _: &End) -> Option<Open> {
        self.0.is_open(encounters).then_some(Open { low: PEDESTRIAN, high: VEHICLE })
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.0.first(encounters).1
    }
}

pub fn gap_accepted() -> Metric {
    let declaration = Declaration::new(
        "gap_accepted",
        "Whether the pedestrian passed the conflict point before the vehicle reached \
         it; undefined if neither ever did or nobody appeared, false on a collision \
         before the pedestrian passed.",
    )
    .source("order at the conflict point as in passed_first");
    Metric {
        declaration,
        kind: MetricKind::Flag,
        scope: Scope::Pair,
        worst: Worst::Smallest,
        absence: Absence::Open,
        range: MetricRange::YesOrNo,
        stake: Stake::Order,
        meters: meters(|context| Box::new(GapAccepted(Order::new(context)))),
    }
}

struct GapAccepted(Order);

impl Meter for GapAccepted {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        let collided = encounters.pair(self.0.pair.0, self.0.pair.1).contact.is_some();
        match self.0.first(encounters).0 {
            PEDESTRIAN => Some(1.0),
            VEHICLE => Some(0.0),
            _ => collided.then_some(0.0),
        }
    }

    fn open(&self, encounters: &Encounters, _: &End) -> Option<Open> {
        self.0.is_open(encounters).then_some(Open { low: 0.0, high: 1.0 })
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        let contact = encounters.pair(self.0.pair.0, self.0.pair.1).contact;
        self.0.first(encounters).1.or(contact.map(|contact| contact.time))
    }
}

/// The order in which a pair passes its conflict point.
struct Order {
    pair: (usize, usize),
    /// Where the paths would cross if the pedestrian walked straight across, m along the vehicle's lane.
    expected_place: f64,
}

impl Order {
    fn new(context: &MetricContext) -> Self {
        let path = context.world.path_of(&context.world.vehicles[context.vehicle]);
        let person = &context.world.pedestrians[context.pedestrian];
        Self { pair: pair(context), expected_place: person.met_by(&path) }
    }

    /// Whether somebody is there of whom it is not known yet.
    fn is_open(&self, encounters: &Encounters) -> bool {
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        let there = encounter.crosses && encounter.appeared.is_some();
        there && encounter.contact.is_none() && self.first(encounters).0 == NOBODY
    }

    /// Who, and when, if that was during the run.
    fn first(&self, encounters: &Encounters) -> (f64, Option<f64>) {
        let passage = encounters.passage(self.pair.0);
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        let reached = passage.reached(encounter.final_passing().map_or(self.expected_place, |it| it.place));
        match encounter.final_passing() {
            _ if encounter.appeared.is_none() || !encounter.crosses => (NOBODY, None),
            Some(passing) if passing.time < reached.moment() => (PEDESTRIAN, Some(passing.time)),
            Some(_) => (VEHICLE, reached.time()),
            None if reached.moment() < f64::INFINITY => (VEHICLE, reached.time()),
            None => (NOBODY, None),
        }
    }
}

pub fn tta_at_entry() -> Metric {
    let declaration = Declaration::new(
        "tta_at_entry",
        "The vehicle's time to arrival at the pedestrian when its centre first enters \
         the lane; undefined if it never does, or if the vehicle stands or is past it.",
    )
    .source("distance along the lane over speed at that moment")
    .parameters([
        Parameter::choice(
            "reference",
            "centre",
            [
                ChoiceOption::new("centre", "from the vehicle's centre"),
                ChoiceOption::new("front", "from the vehicle's front"),
            ],
            "The part of the vehicle that arrives.",
            "centre as for pet",
        ),
        standing("standing"),
    ]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Pair,
        worst: Worst::Smallest,
        absence: Absence::Open,
        range: MetricRange::NotNegative,
        stake: Stake::Entry,
        meters: meters(|context| {
            let from_front = context.settings.word("reference") == "front";
            let ahead = if from_front { context.world.vehicles[context.vehicle].length / 2.0 } else { 0.0 };
            Box::new(TtaAtEntry { pair: pair(context), ahead, standing: context.settings.number("standing") })
        }),
    }
}

struct TtaAtEntry {
    pair: (usize, usize),
    /// From the vehicle's centre to the part that arrives, m.
    ahead: f64,
    /// At or below this speed the vehicle stands, m/s.
    standing: f64,
}

impl Meter for TtaAtEntry {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        let entry = encounters.pair(self.pair.0, self.pair.1).first_entry?;
        let distance = difference(entry.distance, self.ahead);
        (distance >= 0.0 && entry.speed > self.standing).then(|| distance / entry.speed)
    }

    fn open(&self, encounters: &Encounters, _: &End) -> Option<Open> {
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        let comes = encounter.crosses && encounter.appeared.is_some() && encounter.first_entry.is_none();
        comes.then(|| Open::at_least(0.0))
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        encounters.pair(self.pair.0, self.pair.1).first_entry.map(|entry| entry.time)
    }
}

fn pair(context: &MetricContext) -> (usize, usize) {
    (context.vehicle, context.pedestrian)
}

fn zero_on_collision(context: &MetricContext) -> bool {
    context.settings.flag("zero_on_collision")
}

fn at_most(context: &MetricContext) -> f64 {
    context.settings.optional_number(AT_MOST).unwrap_or(f64::INFINITY)
}
