//! How near the footprints come: collision and impact speed with anything, smallest distance of a vehicle and a pedestrian.

use nalgebra::Vector2;
use scenario::{Absence, Metric, MetricKind, MetricRange, Scope, Shape, Side, Stake, Worst};
use scenario::{ChoiceOption, Declaration, Dimension, Parameter, Value};
use sim::geometry::{Footprint, apart, distance};
use sim::measure::{
    Contact, Encounters, InStep, Meter, MetricContext, difference, half_extent_along, least_of, lerp, meters,
};
use sim::{PedestrianState, Solid, Step, VehicleState};

pub fn collision() -> Metric {
    let declaration = Declaration::new(
        "collision",
        "Whether the vehicle touches anything solid at any time: a pedestrian, another \
         vehicle or a box.",
    )
    .source(
        "footprints as in the scenario: vehicles and boxes rectangles, pedestrians \
         discs or rectangles",
    );
    Metric {
        declaration,
        kind: MetricKind::Flag,
        scope: Scope::Contact,
        worst: Worst::Largest,
        absence: Absence::Open,
        range: MetricRange::YesOrNo,
        stake: Stake::Meeting,
        meters: meters(|context| Box::new(Collision(Contacted::new(context)))),
    }
}

/// A vehicle and what it may touch; nothing, if it is alone.
struct Contacted {
    vehicle: usize,
    with: Option<Solid>,
}

impl Contacted {
    fn new(context: &MetricContext) -> Self {
        Self { vehicle: context.vehicle, with: context.with }
    }

    fn contact(&self, encounters: &Encounters) -> Option<Contact> {
        encounters.contact(self.vehicle, self.with?)
    }
}

struct Collision(Contacted);

impl Meter for Collision {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        Some(f64::from(self.0.contact(encounters).is_some()))
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.0.contact(encounters).map(|contact| contact.time)
    }
}

pub fn impact_speed() -> Metric {
    let declaration = Declaration::new(
        "impact_speed",
        "Relative speed of the vehicle and what it touches (a pedestrian, another \
         vehicle or a box) when their footprints first touch; undefined without \
         collision.",
    )
    .source("length of the difference of the velocities at that moment")
    .parameters([Parameter::choice(
        "component",
        "relative",
        [
            ChoiceOption::new("relative", "of both directions"),
            ChoiceOption::new(
                "along",
                "along the vehicle's lane, and 0 where the vehicle is not the faster one there",
            ),
        ],
        "Which part of the difference of the velocities counts.",
        "along: relative impact speed of Euro NCAP's protocols",
    )
    .was(Value::Word("relative".to_string()))]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::SPEED),
        scope: Scope::Contact,
        worst: Worst::Largest,
        absence: Absence::Good,
        range: MetricRange::TwoSpeeds,
        stake: Stake::Meeting,
        meters: meters(|context| match context.settings.word("component") {
            "along" => Box::new(ImpactAlong { contacted: Contacted::new(context), found: None }),
            _ => Box::new(ImpactSpeed(Contacted::new(context))),
        }),
    }
}

/// The impact along the vehicle's lane.
struct ImpactAlong {
    contacted: Contacted,
    /// m/s
    found: Option<f64>,
}

impl Meter for ImpactAlong {
    fn observe(&mut self, step: &Step, encounters: &Encounters) {
        if self.found.is_some() {
            return;
        }
        if let Some(contact) = self.contacted.contact(encounters) {
            let heading = step.after.vehicles[self.contacted.vehicle].heading();
            self.found = Some((-contact.relative_velocity.dot(&heading)).max(0.0));
        }
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.found
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.contacted.contact(encounters).map(|contact| contact.time)
    }
}

struct ImpactSpeed(Contacted);

impl Meter for ImpactSpeed {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        self.0.contact(encounters).map(|contact| contact.relative_speed)
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.0.contact(encounters).map(|contact| contact.time)
    }
}

pub fn impact_point() -> Metric {
    let declaration = Declaration::new(
        "impact_point",
        "Where on the vehicle's front a pedestrian is hit: 0 at the side that they come from, 1 at the other; undefined without collision, and \
         where they run into its flank.",
    )
    .source("share of the vehicle's width at which the pedestrian's reference point is when the footprints first touch, as Euro NCAP's impact point");
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::NUMBER),
        scope: Scope::Pair,
        worst: Worst::Neither,
        absence: Absence::Open,
        range: MetricRange::Unlimited,
        stake: Stake::Meeting,
        meters: meters(|context| {
            let setup = &context.world.pedestrians[context.pedestrian];
            Box::new(ImpactPoint {
                pair: (context.vehicle, context.pedestrian),
                way: Vector2::from(setup.goal) - Vector2::from(setup.start),
                side: (!setup.crosses(&context.world.road)).then_some(setup.side),
                reference: setup.reference,
                is_over: false,
                found: None,
            })
        }),
    }
}

struct ImpactPoint {
    pair: (usize, usize),
    /// From the pedestrian's start to the goal, m.
    way: Vector2<f64>,
    /// The side of the road that who walks along a lane is on.
    side: Option<Side>,
    /// m
    reference: f64,
    /// Once they have touched.
    is_over: bool,
    found: Option<f64>,
}

/// A front that is so near to a body is what it touched, m.
const AT_THE_FRONT: f64 = 1e-4;

/// Ways at a cosine of at most this meet at a right angle but for rounding.
const RIGHT_ANGLE: f64 = 1e-9;

impl Meter for ImpactPoint {
    fn observe(&mut self, step: &Step, encounters: &Encounters) {
        let (vehicle, pedestrian) = self.pair;
        if self.is_over {
            return;
        }
        let Some(contact) = encounters.pair(vehicle, pedestrian).contact else { return };
        self.is_over = true;
        // A run that ends with a touch at the very beginning of a step has a last one of no duration.
        let part = match step.duration {
            0.0 => 1.0,
            duration => (contact.time - step.time) / duration,
        };
        let car = &step.after.vehicles[vehicle];
        let travelled = lerp(step.before.vehicles[vehicle].motion.travelled, car.motion.travelled, part);
        let (centre, ahead) = match car.steered {
            None => (car.path.point(travelled), car.path.heading(travelled)),
            Some(_) => step.before.vehicles[vehicle].between(car, part).pose(),
        };
        let (before, person) = (&step.before.pedestrians[pedestrian], &step.after.pedestrians[pedestrian]);
        let place = before.position.lerp(&person.position, part);
        let left = Vector2::new(-ahead.y, ahead.x);
        // Who turns within a step touches as they stood at its beginning.
        let reach = half_extent_along(before, ahead).x;
        let front = (place - centre).dot(&ahead) - car.length / 2.0 - reach;
        // Where ways meet at another than a right angle the corner of the front may touch a side of a body.
        let meets_aslant = self.way.dot(&ahead).abs() > RIGHT_ANGLE * self.way.norm();
        let aslant = meets_aslant && matches!(before.shape, Shape::Rectangle { .. });
        let corner = || {
            let shape =
                Shape::Rectangle { length: 2.0 * AT_THE_FRONT, width: car.width + 2.0 * AT_THE_FRONT };
            let edge = Footprint { centre: centre + ahead * (car.length / 2.0), heading: ahead, shape };
            let body = Footprint { centre: place, ..Footprint::from(before) };
            edge.first_contact(&body, Vector2::zeros()).is_some()
        };
        if front.abs() > AT_THE_FRONT && !(aslant && corner()) {
            return;
        }
        let reference = place + before.heading * self.reference;
        let beyond = match self.side {
            Some(side) if car.keeps_straight() => car.path.beyond(reference, side),
            // Of the front itself, which in a bend is beside the lane's centre.
            Some(side) => {
                let far = car.path.locate(reference).far();
                side.walking_sign() * far * (reference - centre).dot(&left)
            }
            None => self.way.dot(&left).signum() * (reference - centre).dot(&left),
        };
        self.found = Some(0.5 + beyond / car.width);
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.found
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        let contact = encounters.pair(self.pair.0, self.pair.1).contact;
        contact.filter(|_| self.found.is_some()).map(|contact| contact.time)
    }
}

pub fn min_distance() -> Metric {
    let declaration = Declaration::new(
        "min_distance",
        "Smallest distance between the footprints; 0 on collision, undefined if the \
         pedestrian never appears.",
    )
    .source("Euclidean distance of the footprints, also between the simulation's steps");
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::LENGTH),
        scope: Scope::Pair,
        worst: Worst::Smallest,
        absence: Absence::Open,
        range: MetricRange::NotNegative,
        stake: Stake::MeetingOrPassing,
        meters: meters(|context| Box::new(MinDistance::new(context))),
    }
}

struct MinDistance {
    pair: (usize, usize),
    last: Option<f64>,
    /// Of the vehicle at the end of the step before.
    pose: Option<(Vector2<f64>, Vector2<f64>)>,
    smallest: Option<Smallest>,
    /// In the last step, m.
    latest: Option<f64>,
    /// When that began, s.
    since: f64,
}

/// A distance (m) and when it was (s).
#[derive(Clone, Copy)]
struct Smallest {
    distance: f64,
    time: f64,
}

impl MinDistance {
    fn new(context: &MetricContext) -> Self {
        let pair = (context.vehicle, context.pedestrian);
        Self { pair, last: None, pose: None, smallest: None, latest: None, since: 0.0 }
    }
}

impl Meter for MinDistance {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        let (old_car, car) = (&step.before.vehicles[self.pair.0], &step.after.vehicles[self.pair.0]);
        let (old, new) = (&step.before.pedestrians[self.pair.1], &step.after.pedestrians[self.pair.1]);
        (self.latest, self.since) = (None, step.time);
        if !old.present {
            return;
        }
        let before = self.last.unwrap_or_else(|| distance(old_car, old));
        let ((centre, heading), now) = (self.pose.unwrap_or_else(|| pose(old_car)), pose(car));
        let after = match car.keeps_straight() {
            true => distance(car, new),
            false => {
                let shape = Shape::Rectangle { length: car.length, width: car.width };
                apart(&Footprint { centre: now.0, heading: now.1, shape }, &new.into())
            }
        };
        let mut smallest = self.smallest.unwrap_or(Smallest { distance: f64::INFINITY, time: step.time });
        let mut latest = f64::INFINITY;
        let mut consider = |distance: f64, part: f64| {
            latest = latest.min(distance);
            if distance < smallest.distance {
                smallest = Smallest { distance, time: step.time + part * step.duration };
            }
            smallest.distance
        };
        consider(before, 0.0);
        let least = consider(after, 1.0);
        // Nothing comes nearer than it moves, so most steps need no look inside.
        let moved = ((new.position - old.position) - (now.0 - centre)).norm();
        let moved = moved + turned(car, heading, now.1);
        if (before + after - moved) / 2.0 < least {
            let (distance, part) = smallest_inside((old_car, car), (old, new));
            consider(distance, part);
        }
        self.last = Some(after);
        self.pose = Some(now);
        self.smallest = Some(smallest);
        self.latest = Some(latest);
    }

    fn value(&self, encounters: &Encounters) -> Option<f64> {
        match encounters.pair(self.pair.0, self.pair.1).contact {
            Some(_) => Some(0.0),
            None => self.smallest.map(|smallest| difference(smallest.distance, 0.0)),
        }
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        match encounters.pair(self.pair.0, self.pair.1).contact {
            Some(contact) => Some(contact.time),
            None => self.smallest.map(|smallest| smallest.time),
        }
    }

    fn in_step(&self, encounters: &Encounters) -> InStep {
        match encounters.pair(self.pair.0, self.pair.1).contact {
            Some(contact) if contact.time >= self.since => InStep::Worst(0.0),
            _ => self.latest.map(|distance| difference(distance, 0.0)).into(),
        }
    }
}

/// The centre of a vehicle (m) and the unit vector in which it drives.
fn pose(car: &VehicleState) -> (Vector2<f64>, Vector2<f64>) {
    car.pose()
}

/// How far turning alone from one heading to another takes a corner of a vehicle on a bend, at most, m.
fn turned(car: &VehicleState, before: Vector2<f64>, after: Vector2<f64>) -> f64 {
    if car.keeps_straight() {
        return 0.0;
    }
    (after - before).norm() * libm::hypot(car.length, car.width) / 2.0
}

/// The smallest distance inside a step, and after which share of it: a convex function of time, as the footprints are
/// convex and do not turn; on a bend they turn by so little that it is one but for that.
fn smallest_inside(
    (old_car, car): (&VehicleState, &VehicleState),
    (old, new): (&PedestrianState, &PedestrianState),
) -> (f64, f64) {
    let mut vehicle = car.clone();
    let mut at = |part: f64| {
        if car.steered.is_some() {
            vehicle = old_car.between(car, part);
        }
        vehicle.motion.travelled =
            old_car.motion.travelled + part * (car.motion.travelled - old_car.motion.travelled);
        let person = PedestrianState { position: old.position.lerp(&new.position, part), ..*new };
        distance(&vehicle, &person)
    };
    least_of(&mut at)
}
