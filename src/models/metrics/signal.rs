//! Whether a vehicle drives over a stop line in red.

use scenario::{
    Absence, Crossing, CrossingKind, Declaration, Metric, MetricKind, MetricRange, Scope, SignalState, Stake,
    TrafficSignal, Worst,
};
use sim::Step;
use sim::measure::{Encounters, End, Meter, MetricContext, Open, lerp, meters, rising};

pub fn ran_red() -> Metric {
    let declaration = Declaration::new(
        "ran_red",
        "Whether the vehicle's front passes the stop line of a signal while that shows red to vehicles. Undefined if no red was at stake: if \
         it never came to a signal that was not green at such a speed that, keeping that, it would have passed the line in red.",
    )
    .source("the moment at which the front is at the line, interpolated within a step");
    Metric {
        declaration,
        kind: MetricKind::Flag,
        scope: Scope::Vehicle,
        worst: Worst::Largest,
        absence: Absence::Good,
        range: MetricRange::YesOrNo,
        stake: Stake::Value,
        meters: meters(|context| Box::new(RanRed::new(context))),
    }
}

/// A signal on a vehicle's way.
struct Line {
    /// The place of the vehicle's centre at which its front is at the stop line, m.
    place: f64,
    signal: TrafficSignal,
}

struct RanRed {
    vehicle: usize,
    lines: Vec<Line>,
    /// Whether it would have passed in red, had it kept its speed at some moment.
    at_stake: bool,
    /// When it first passed in red, s.
    ran: Option<f64>,
}

impl RanRed {
    fn new(context: &MetricContext) -> Self {
        let setup = &context.world.vehicles[context.vehicle];
        let (road, path) = (context.world.road_of(setup), context.world.path_of(setup));
        let line = |(along, crossing): (f64, &Crossing)| match crossing.kind {
            CrossingKind::Signalised(signal) => {
                let before = crossing.width / 2.0 + signal.stop_line + setup.length / 2.0;
                Some(Line { place: path.at_line(along) - before, signal })
            }
            _ => None,
        };
        let lines = road.crossings().filter_map(line).collect();
        Self { vehicle: context.vehicle, lines, at_stake: false, ran: None }
    }
}

impl Line {
    /// Whether a vehicle that is at a place (m) at `time` (s) and keeps its speed (m/s) passes the line in the red that is, or is next.
    fn is_passed_in_red(&self, time: f64, place: f64, speed: f64) -> bool {
        let left = self.place - place;
        let wait = self.signal.until_green(time);
        if left <= 0.0 || left >= speed * wait {
            return false;
        }
        self.signal.state(time + left / speed) == SignalState::Red
    }
}

impl Meter for RanRed {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        if self.lines.is_empty() || self.ran.is_some() {
            return;
        }
        let (before, after) =
            (step.before.vehicles[self.vehicle].motion, step.after.vehicles[self.vehicle].motion);
        for line in &self.lines {
            // At the beginning of a step, so that what begins in this one and is over at its end is seen, too.
            self.at_stake |= line.is_passed_in_red(step.time, before.travelled, before.speed);
            let Some(part) = rising(before.travelled, after.travelled, line.place) else { continue };
            let time = lerp(step.time, step.time + step.duration, part);
            if line.signal.state(time) == SignalState::Red {
                self.ran = Some(time);
                return;
            }
        }
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        match (self.ran, self.at_stake) {
            (Some(_), _) => Some(1.0),
            (None, true) => Some(0.0),
            (None, false) => None,
        }
    }

    fn open(&self, _: &Encounters, end: &End) -> Option<Open> {
        let place = end.state.vehicles[self.vehicle].motion.travelled;
        let comes_to_red = |line: &Line| line.place > place && line.signal.pedestrian_green > 0.0;
        (self.ran.is_none() && self.lines.iter().any(comes_to_red)).then_some(Open { low: 0.0, high: 1.0 })
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        self.ran
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use scenario::World;

    use super::super::fixture::{Profile, Walk, measure, request, world};
    use super::*;
    use sim::measure::Reading;

    /// People have green from 10 s to 14 s of every 40 s, vehicles amber before that and red until 16 s.
    const SIGNAL: TrafficSignal = TrafficSignal {
        cycle: 40.0,
        pedestrian_green_from: 10.0,
        pedestrian_green: 4.0,
        amber: 3.0,
        clearance: 2.0,
        stop_line: 1.0,
    };

    fn street(kind: CrossingKind, step: f64) -> World {
        let mut world = world(step, 40.0);
        world.road.crossing.kind = kind;
        world
    }

    /// What a car comes to that is so far before the line with its front at the beginning (m), and drives like this.
    fn reading(world: &World, (gap, speed): (f64, f64), stretches: &[(f64, f64)]) -> Reading {
        let beyond = world.road.crossing.width / 2.0 + SIGNAL.stop_line + world.vehicles[0].length / 2.0;
        let nobody = Walk(vec![(0.0, 0.0, -50.0), (1.0, 0.0, -50.0)]);
        let car = Profile::new(-gap - beyond, speed, stretches);
        measure(world, &[request("ran_red", [])], &car, &nobody).remove(0)
    }

    fn value(start: (f64, f64), stretches: &[(f64, f64)]) -> Option<f64> {
        let world = street(CrossingKind::Signalised(SIGNAL), 0.05);
        reading(&world, start, stretches).worst.and_then(|worst| worst.value)
    }

    #[test]
    fn red_is_run_from_its_first_moment_to_its_last() {
        for (arrives, ran) in [(9.9, None), (10.01, Some(1.0)), (15.9, Some(1.0)), (16.1, None), (5.0, None)]
        {
            assert_eq!(value((10.0 * arrives, 10.0), &[]), ran, "{arrives}");
        }
        let world = street(CrossingKind::Signalised(SIGNAL), 0.05);
        let instant = reading(&world, (120.02, 10.0), &[]).worst.unwrap().instant.unwrap();
        assert!((instant - 12.002).abs() < 1e-9, "{instant}");
    }

    #[test]
    fn who_stops_for_red_has_not_run_it_and_who_met_none_says_nothing() {
        // From amber on at 7 s it would arrive at 12 s; it stops 10 m before the line, waits and goes on.
        let stops = [(8.0, 0.0), (4.0, -2.5), (6.0, 0.0), (10.0, 2.0)];
        assert_eq!(value((120.0, 10.0), &stops), Some(0.0));
        // It stopped in green already, and never came towards red.
        assert_eq!(value((120.0, 10.0), &[(2.0, 0.0), (2.0, -5.0)]), None);
        // It creeps on in red.
        assert_eq!(value((104.0, 10.0), &[(8.0, 0.0), (4.0, -2.25), (20.0, 0.0)]), Some(1.0));
        // Far before the signal red is over until it comes.
        assert_eq!(value((350.0, 10.0), &[]), None);
    }

    #[test]
    fn without_a_signal_or_without_red_nothing_is_at_stake() {
        let never = TrafficSignal { pedestrian_green: 0.0, ..SIGNAL };
        for kind in [CrossingKind::Zebra, CrossingKind::Unmarked, CrossingKind::Signalised(never)] {
            let found = reading(&street(kind, 0.05), (120.0, 10.0), &[]);
            assert_eq!((found.worst.and_then(|worst| worst.value), found.open), (None, None), "{kind:?}");
        }
    }

    #[test]
    fn who_waits_at_the_end_may_still_run_it() {
        let world = street(CrossingKind::Signalised(SIGNAL), 0.05);
        let waits = reading(&world, (120.0, 10.0), &[(8.0, 0.0), (4.0, -2.5)]);
        assert_eq!(waits.worst.unwrap().value, Some(0.0));
        assert_eq!(waits.open, Some(Open { low: 0.0, high: 1.0 }));
    }

    proptest! {
        /// Derived again from the moment at which the front is at the line.
        #[test]
        fn at_constant_speed_it_is_what_the_signal_shows_on_arrival(
            gap in 1.0..380.0_f64, speed in 1.0..20.0_f64, fine in 0.01..0.2_f64,
        ) {
            let arrives = gap / speed;
            prop_assume!(arrives < 39.0);
            let red = SIGNAL.state(arrives) == SignalState::Red;
            let world = street(CrossingKind::Signalised(SIGNAL), fine);
            let found = reading(&world, (gap, speed), &[]).worst.and_then(|worst| worst.value);
            prop_assert_eq!(found, red.then_some(1.0));
        }
    }
}
