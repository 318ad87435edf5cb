//! How the pedestrian crosses: when it sets off, how long it is in the lane, what waiting costs it.

use scenario::{Absence, Metric, MetricKind, MetricRange, Scope, Stake, Worst};
use scenario::{Declaration, Dimension, Parameter};
use sim::measure::rising;
use sim::measure::{Encounters, End, Meter, MetricContext, Open, difference, meters};
use sim::{Step, velocity_inside};

pub fn crossing_initiation_time() -> Metric {
    let declaration = Declaration::new(
        "crossing_initiation_time",
        "From the pedestrian's appearance, or from when it may go, to its first motion; \
         undefined if it never moves.",
    )
    .source("first moment at which it is faster than the parameter")
    .parameters([Parameter::number(
        "speed",
        Dimension::SPEED,
        0.01,
        (0.0, 10.0),
        "Above this speed the pedestrian moves.",
        "as in event timelines",
    )]);
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Pedestrian,
        worst: Worst::Largest,
        absence: Absence::Bad,
        range: MetricRange::WithinRun,
        stake: Stake::Company,
        meters: meters(|context| {
            let threshold = context.settings.number("speed");
            let pedestrian = context.pedestrian;
            Box::new(InitiationTime { pedestrian, threshold, let_go: None, moved: None })
        }),
    }
}

struct InitiationTime {
    pedestrian: usize,
    threshold: f64,
    let_go: Option<f64>,
    moved: Option<f64>,
}

impl Meter for InitiationTime {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        let (old, new) =
            (&step.before.pedestrians[self.pedestrian], &step.after.pedestrians[self.pedestrian]);
        if self.moved.is_some() || !old.present || !step.may_go(self.pedestrian) {
            return;
        }
        let let_go = *self.let_go.get_or_insert(step.time);
        let speed = |part| velocity_inside(step.duration, old, new, part).norm();
        let (before, after) = (speed(0.0), speed(1.0));
        let part = if before > self.threshold { Some(0.0) } else { rising(before, after, self.threshold) };
        if after > self.threshold || before > self.threshold {
            self.moved = part.map(|part| difference(step.time + part * step.duration, let_go));
        }
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.moved
    }

    fn open(&self, _: &Encounters, end: &End) -> Option<Open> {
        let let_go = self.let_go.filter(|_| self.moved.is_none())?;
        Some(Open::at_least(end.time - let_go))
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        Some(self.let_go? + self.moved?)
    }
}

pub fn crossing_duration() -> Metric {
    let declaration = Declaration::new(
        "crossing_duration",
        "From the pedestrian's entry into the vehicle's lane to its exit on the other \
         side, by its centre; after a retreat, from the last entry; undefined if it \
         never gets across.",
    )
    .source("entry to exit of the lane");
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Pair,
        worst: Worst::Largest,
        absence: Absence::Bad,
        range: MetricRange::WithinRun,
        stake: Stake::Entry,
        meters: meters(|context| Box::new(CrossingDuration { pair: (context.vehicle, context.pedestrian) })),
    }
}

struct CrossingDuration {
    pair: (usize, usize),
}

impl Meter for CrossingDuration {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        let crossing = encounters.pair(self.pair.0, self.pair.1).crossing?;
        Some(difference(crossing.left, crossing.entered))
    }

    fn open(&self, encounters: &Encounters, _: &End) -> Option<Open> {
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        // Who turns back may come again and cross as fast as ever.
        let crosses = encounter.crosses && encounter.appeared.is_some() && encounter.crossing.is_none();
        crosses.then(|| Open::at_least(0.0))
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        encounters.pair(self.pair.0, self.pair.1).crossing.map(|crossing| crossing.left)
    }
}

pub fn pedestrian_delay() -> Metric {
    let declaration = Declaration::new(
        "pedestrian_delay",
        "Time from appearance, or from when it may go, to the far edge of the vehicle's \
         lane beyond that of a free walk straight towards the goal. Negative is time saved, by going faster \
         than its free speed or by a shorter way than the straight one to the goal; 0 \
         is as if nobody else were there. Undefined if it never gets across.",
    )
    .source("free walk at the model's own free speed from the first moment on");
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Pair,
        worst: Worst::Largest,
        absence: Absence::Bad,
        range: MetricRange::Unlimited,
        stake: Stake::Company,
        meters: meters(|context| Box::new(PedestrianDelay::new(context))),
    }
}

struct PedestrianDelay {
    pair: (usize, usize),
    /// Of a free walk to the far edge of the lane, s; `None` if the way does not lead there.
    free_time: Option<f64>,
}

impl PedestrianDelay {
    fn new(context: &MetricContext) -> Self {
        let setup = &context.world.pedestrians[context.pedestrian];
        let car = &context.world.vehicles[context.vehicle];
        let (road, path) = (context.world.road_of(car), context.world.path_of(car));
        let way = (setup.start.into(), setup.goal.into());
        let side = context.world.crosses_from(setup, car).unwrap_or(setup.side);
        let length = path.way_to_far_edge(way, side, road.lane_width);
        let free_speed = context.free_speed.filter(|speed| *speed > 0.0);
        Self {
            pair: (context.vehicle, context.pedestrian),
            free_time: length.zip(free_speed).map(|(length, speed)| length / speed),
        }
    }
}

impl Meter for PedestrianDelay {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        Some(difference(encounter.crossing?.left - encounter.let_go?, self.free_time?))
    }

    fn open(&self, encounters: &Encounters, end: &End) -> Option<Open> {
        let encounter = encounters.pair(self.pair.0, self.pair.1);
        let let_go = encounter.let_go.filter(|_| encounter.crosses && encounter.crossing.is_none())?;
        Some(Open::at_least(end.time - let_go - self.free_time?))
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        encounters.pair(self.pair.0, self.pair.1).crossing.map(|crossing| crossing.left)
    }
}
