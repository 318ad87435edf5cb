//! How urgent it gets: time to collision and the deceleration that would avoid a crash.

use scenario::{Absence, Located, Metric, MetricKind, MetricRange, Scope, Stake, Worst};
use scenario::{ChoiceOption, Declaration, Dimension, Parameter, Settings, Value};
use sim::geometry::first_contact;
use sim::measure::{Encounter, Encounters, InStep, Meter, MetricContext, meters};
use sim::measure::{half_extent, strip};
use sim::{PedestrianState, Step, VehicleState};

/// How the vehicle is taken to go on.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Prediction {
    Course,
    Straight,
}

impl Prediction {
    fn of(settings: &Settings) -> Self {
        if settings.word("prediction") == "straight" { Self::Straight } else { Self::Course }
    }

    /// Time to collision from the end of the step on, s.
    fn time(self, encounter: &Encounter, car: &VehicleState, person: &PedestrianState) -> Option<f64> {
        match self {
            Self::Straight if !car.keeps_straight() => {
                first_contact(car, person, person.velocity - car.velocity())
            }
            _ => encounter.time_to_collision(),
        }
    }
}

fn prediction_parameter() -> Parameter {
    Parameter::choice(
        "prediction",
        "course",
        [
            ChoiceOption::new("course", "it keeps its speed along its lane, round bends as well"),
            ChoiceOption::new("straight", "it goes straight on from where it is, as is usual"),
        ],
        "How the vehicle is taken to go on; on straight roads both are the same.",
        "straight on from a bend it would meet people on the pavement, and miss those round the bend",
    )
    .was(Value::Word("course".to_string()))
}

pub fn min_ttc() -> Metric {
    let declaration = Declaration::new(
        "min_ttc",
        "Smallest time to collision of the footprints if both kept their velocities; 0 \
         on collision, undefined if they are never on a collision course.",
    )
    .source(
        "Hayward 1972; exact contact time of the moving footprints, looked at after \
         every step; in bends to 1e-9 m, by steps that no contact can hide in, for no \
         longer than 10 s",
    )
    .parameters([prediction_parameter()]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Pair,
        worst: Worst::Smallest,
        absence: Absence::Good,
        range: MetricRange::NotNegative,
        stake: Stake::Meeting,
        meters: meters(|context| {
            context.look_ahead();
            Box::new(MinTtc {
                pair: (context.vehicle, context.pedestrian),
                prediction: Prediction::of(context.settings),
                smallest: None,
                instant: 0.0,
                latest: None,
                since: 0.0,
            })
        }),
    }
}

struct MinTtc {
    pair: (usize, usize),
    prediction: Prediction,
    smallest: Option<f64>,
    /// When that was, s.
    instant: f64,
    /// At the end of the last step, s.
    latest: Option<f64>,
    /// When that step began, s.
    since: f64,
}

impl Meter for MinTtc {
    fn observe(&mut self, step: &Step, encounters: &Encounters) {
        (self.latest, self.since) = (None, step.time);
        let (car, person) = (&step.after.vehicles[self.pair.0], &step.after.pedestrians[self.pair.1]);
        // Who is not there yet is on no course.
        if !step.before.pedestrians[self.pair.1].present {
            return;
        }
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        self.latest = self.prediction.time(encounter, car, person);
        if let Some(time) = self.latest
            && self.smallest.is_none_or(|smallest| time < smallest)
        {
            self.smallest = Some(time);
            self.instant = step.time + step.duration;
        }
    }

    fn value(&self, encounters: &Encounters) -> Option<f64> {
        if encounters.pair(self.pair.0, self.pair.1).contact.is_some() { Some(0.0) } else { self.smallest }
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        match encounters.pair(self.pair.0, self.pair.1).contact {
            Some(contact) => Some(contact.time),
            None => self.smallest.map(|_| self.instant),
        }
    }

    fn in_step(&self, encounters: &Encounters) -> InStep {
        match encounters.pair(self.pair.0, self.pair.1).contact {
            Some(contact) if contact.time >= self.since => InStep::Worst(0.0),
            _ => self.latest.into(),
        }
    }
}

pub fn drac() -> Metric {
    let declaration = Declaration::new(
        "drac",
        "Largest deceleration rate to avoid a crash: what the vehicle would have had \
         to brake by, from then on, while on a collision course with the pedestrian \
         ahead of its front; undefined if never.",
    )
    .source(
        "Cooper & Ferguson 1976, v^2/(2 g) with the gap g along the lane and the \
         relative speed v; where the pedestrian leaves the vehicle's strip at t < 2 \
         g/v, the smaller 2 (v t - g)/t^2 that lets it pass",
    )
    .parameters([
        Parameter::number(
            "ceiling",
            Dimension::ACCELERATION,
            20.0,
            (1.0, 1000.0),
            "Reported where no deceleration up to this one would do, as when the front is \
             about to hit.",
            "the rate grows without bound as the gap closes; twice what tyres can do",
        ),
        prediction_parameter(),
    ]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::ACCELERATION),
        scope: Scope::Pair,
        worst: Worst::Largest,
        absence: Absence::Good,
        range: MetricRange::UpTo("ceiling".into()),
        stake: Stake::Meeting,
        meters: meters(|context| Box::new(Drac::new(context))),
    }
}

struct Drac {
    pair: (usize, usize),
    ceiling: f64,
    prediction: Prediction,
    largest: Option<f64>,
    /// When that was, s.
    instant: f64,
    /// At the end of the last step, m/s².
    latest: Option<f64>,
    /// Whether they were on a collision course with the pedestrian ahead of the front.
    was_ahead: bool,
}

impl Drac {
    fn new(context: &MetricContext) -> Self {
        context.look_ahead();
        Self {
            pair: (context.vehicle, context.pedestrian),
            ceiling: context.settings.number("ceiling"),
            prediction: Prediction::of(context.settings),
            largest: None,
            instant: 0.0,
            latest: None,
            was_ahead: false,
        }
    }
}

impl Meter for Drac {
    fn observe(&mut self, step: &Step, encounters: &Encounters) {
        self.latest = None;
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        let (car, person) = (&step.after.vehicles[self.pair.0], &step.after.pedestrians[self.pair.1]);
        // Who is not there yet is nowhere.
        let Some((_, place)) = encounter.places else { return };
        let on_course = self.prediction.time(encounter, car, person).is_some() || encounter.contact.is_some();
        let gap = gap_ahead(car, person, &place);
        // Contact with the front closes the gap up to rounding.
        let ahead = gap > 1e-9;
        let rate = match (on_course, ahead) {
            (true, true) => Some(avoiding_rate(car, person, &place, gap)),
            (true, false) if self.was_ahead => Some(f64::INFINITY),
            _ => None,
        };
        self.latest = rate.map(|rate| rate.min(self.ceiling));
        if let Some(rate) = self.latest
            && self.largest.is_none_or(|largest| rate > largest)
        {
            self.largest = Some(rate);
            self.instant = step.time + step.duration;
        }
        self.was_ahead = on_course && ahead;
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.largest
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        self.largest.map(|_| self.instant)
    }

    fn in_step(&self, _: &Encounters) -> InStep {
        self.latest.into()
    }
}

/// From the front to the pedestrian's footprint along the lane, m.
fn gap_ahead(car: &VehicleState, person: &PedestrianState, place: &Located) -> f64 {
    place.along - half_extent(person, place).x - car.motion.travelled - car.length / 2.0
}

/// The constant deceleration that keeps the front `gap` behind the pedestrian until it has left the strip that the
/// vehicle sweeps, m/s².
fn avoiding_rate(car: &VehicleState, person: &PedestrianState, place: &Located, gap: f64) -> f64 {
    let (along, sideways) = place.speeds(person.velocity);
    let closing = car.motion.speed - along;
    if closing <= 0.0 {
        return 0.0;
    }
    let (reach, (low, high)) = (half_extent(person, place).y, strip(car, place));
    let edge = if sideways > 0.0 { high + reach } else { low - reach };
    let clear = if sideways == 0.0 { f64::INFINITY } else { (edge - place.beside) / sideways };
    if clear * closing >= 2.0 * gap {
        closing * closing / (2.0 * gap)
    } else {
        (2.0 * (closing * clear - gap) / (clear * clear)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use scenario::{Direction, Path, Shape};
    use sim::Longitudinal;

    fn rate(speed: f64, gap: f64, offset: f64, sideways: f64) -> f64 {
        let car = VehicleState::new(
            Path::straight(0.0, Direction::Forward),
            Longitudinal { travelled: 0.0, speed, acceleration: 0.0 },
            (4.0, 1.5),
        );
        let person = PedestrianState {
            position: Vector2::new(2.0 + gap + 0.25, offset),
            velocity: Vector2::new(0.0, sideways),
            acceleration: Vector2::zeros(),
            heading: Vector2::y(),
            shape: Shape::Disc { radius: 0.25 },
            present: true,
        };
        let place = car.path.locate(person.position);
        avoiding_rate(&car, &person, &place, gap_ahead(&car, &person, &place))
    }

    #[test]
    fn stops_before_a_standing_pedestrian_and_lets_a_walking_one_pass() {
        assert!((rate(10.0, 20.0, 0.0, 0.0) - 2.5).abs() < 1e-12);
        // Clear of the strip (0.75 m and the disc) in 1 s, or in 3 s: by then the vehicle may be at the gap.
        assert!((rate(10.0, 8.0, 0.0, 1.0) - 4.0).abs() < 1e-12);
        assert!((rate(10.0, 20.0, -2.0, 1.0) - 20.0 / 9.0).abs() < 1e-12);
        // Still there when a vehicle that brakes just enough has stopped.
        assert!((rate(10.0, 10.0, -2.0, 1.0) - 5.0).abs() < 1e-12);
    }
}
