//! A cyclist who lets vehicles go first where there is no time to go before them.

use nalgebra::Vector2;

use super::across::check_on_bicycle;
use super::{PedestrianContext, PedestrianModel};
use scenario::{Chance, Declaration, Dimension, Parameter, Shape, Side};
use sim::sight::sees_vehicle;
use sim::{Mode, ModelError, Motion, Pedestrian, Scene, VehicleState};

const SUMO: &str = "SUMO's default for bicycles (SUMOVTypeParameter.cpp)";
const GUIDE: &str = "AASHTO, Guide for the Development of Bicycle Facilities, 1999: 2.5 s (remembered)";
const CHOICE: &str = "free choice";

pub fn yielding_cyclist() -> PedestrianModel {
    let declaration = Declaration::new(
        "yielding_cyclist",
        "Rides to its goal; brakes for vehicles that would be where its way crosses theirs when it is, and for what is before it, if it \
         still can.",
    )
    .source("braking after a reaction, with values of design guides; the decision is ours")
    .parameters([
        Parameter::number("speed", Dimension::SPEED, 20.0 / 3.6, (0.5, 12.0), "Speed at which it rides.", SUMO),
        Parameter::number(
            "acceleration",
            Dimension::ACCELERATION,
            0.5,
            (0.05, 3.0),
            "With which it gets to its speed.",
            "AASHTO 1999: 0.5 to 1 m/s^2; FHWA-HRT-04-103, table 10: 0.5 m/s^2 over the first 12.2 m",
        ),
        Parameter::number(
            "reaction_time",
            Dimension::TIME,
            2.5,
            (0.0, 10.0),
            "Time from when there is something to brake for until it brakes. A value for design, which covers almost everybody.",
            GUIDE,
        ),
        Parameter::number(
            "deceleration",
            Dimension::ACCELERATION,
            2.45,
            (0.5, 8.0),
            "With which it brakes if there is room for that.",
            "AASHTO 1999: coefficient of friction 0.25 (remembered)",
        ),
        Parameter::number(
            "max_deceleration",
            Dimension::ACCELERATION,
            3.4,
            (0.5, 8.0),
            "With which it can brake; where that is not enough it rides on.",
            "AASHTO, A Policy on Geometric Design: 3.4 m/s^2 (remembered)",
        ),
        Parameter::number(
            "time_margin",
            Dimension::TIME,
            1.0,
            (0.0, 10.0),
            "Time that it wants to lie between it and a vehicle in the place that both come to.",
            CHOICE,
        ),
        Parameter::number(
            "room",
            Dimension::LENGTH,
            0.5,
            (0.0, 10.0),
            "What it leaves between it and what it stops for.",
            SUMO,
        ),
        Parameter::flag(
            "rolling",
            true,
            "Whether it rides at its speed when it appears; otherwise it sets off from standing.",
            CHOICE,
        ),
        Parameter::optional(
            "expects_deceleration",
            Dimension::ACCELERATION,
            (0.0, 10.0),
            "Does not mind vehicles that could stop for it with this deceleration, as on a cycle crossing on which it has priority; without \
             it, it counts on none to brake.",
            CHOICE,
        ),
    ]);
    PedestrianModel::new(declaration, build).chance(Chance::Never)
}

/// Below this speed it stands, m/s.
const STANDS: f64 = 1e-6;

/// Absorbs the rounding of summed times, s.
const TIME_TOLERANCE: f64 = 1e-9;

/// Looks along its way for where a kerb is as far as this, m.
const KERB_PROBE: f64 = 1.0;

struct YieldingCyclist {
    speed: f64,
    acceleration: f64,
    reaction_time: f64,
    deceleration: f64,
    max_deceleration: f64,
    time_margin: f64,
    room: f64,
    expects_deceleration: Option<f64>,
    side: Side,
    obeys_signals: bool,
    /// Length and width, m.
    body: (f64, f64),
    /// Whether it is yet to appear at its speed.
    appears_rolling: bool,
    /// Since when there is something to brake for, s.
    since: Option<f64>,
    brakes: bool,
    mode: &'static str,
}

fn build(context: &PedestrianContext) -> Result<Box<dyn Pedestrian>, ModelError> {
    check_on_bicycle(context, "yielding_cyclist")?;
    let (settings, setup) = (context.settings, context.setup);
    let (deceleration, max_deceleration) =
        (settings.number("deceleration"), settings.number("max_deceleration"));
    if deceleration > max_deceleration {
        return Err(ModelError::with_hint(
            "`deceleration` of `yielding_cyclist` is larger than `max_deceleration`",
            "let `deceleration`, with which it brakes, be at most `max_deceleration`, with which it can brake",
        ));
    }
    Ok(Box::new(YieldingCyclist {
        speed: settings.number("speed"),
        acceleration: settings.number("acceleration"),
        reaction_time: settings.number("reaction_time"),
        deceleration,
        max_deceleration,
        time_margin: settings.number("time_margin"),
        room: settings.number("room"),
        expects_deceleration: settings.optional_number("expects_deceleration"),
        side: setup.side,
        obeys_signals: setup.obeys_signals && setup.meets_signal(&context.world.road),
        body: match setup.shape {
            Shape::Rectangle { length, width } => (length, width),
            Shape::Disc { radius } => (2.0 * radius, 2.0 * radius),
        },
        appears_rolling: settings.flag("rolling"),
        since: None,
        brakes: false,
        mode: "riding",
    }))
}

/// What it would have to stop for.
#[derive(Clone, Copy)]
struct Stop {
    /// From where it is to where it would stand, m.
    gap: f64,
    /// How fast that goes on along its way, m/s.
    recedes: f64,
}

impl Stop {
    /// The deceleration that this takes from a speed (m/s) on, m/s².
    fn needs(&self, speed: f64) -> f64 {
        let closing = (speed - self.recedes).max(0.0);
        if closing == 0.0 { 0.0 } else { closing * closing / (2.0 * self.gap.max(0.0)) }
    }
}

impl YieldingCyclist {
    /// How long it takes for a way (m) from this speed (m/s) on if nothing keeps it from its own, s.
    fn time_for(&self, way: f64, speed: f64) -> f64 {
        if way <= 0.0 {
            return 0.0;
        }
        let speed = speed.min(self.speed);
        let speeding_up = (self.speed - speed) / self.acceleration;
        let way_speeding_up = (self.speed + speed) / 2.0 * speeding_up;
        if way >= way_speeding_up {
            return speeding_up + (way - way_speeding_up) / self.speed;
        }
        2.0 * way / (speed + (speed * speed + 2.0 * self.acceleration * way).sqrt())
    }

    /// What it has to do about a vehicle, if anything.
    fn stop_for(&self, scene: &Scene, vehicle: &VehicleState, way: Vector2<f64>, speed: f64) -> Option<Stop> {
        let ego = scene.ego();
        let car = (vehicle.motion.travelled, (vehicle.length, vehicle.width));
        let Some(area) = vehicle.path.conflict_area(car, (ego.position, way), self.body) else {
            return self.stop_behind(scene, vehicle, way);
        };
        if area.pedestrian.from <= 0.0 {
            // Who is there leaves it.
            return None;
        }
        let (to_area, out_of_it) =
            (area.vehicle.from - vehicle.motion.travelled, area.vehicle.to - vehicle.motion.travelled);
        if out_of_it <= 0.0 {
            return None;
        }
        let stop = Stop { gap: area.pedestrian.from - self.room, recedes: 0.0 };
        if to_area <= 0.0 && vehicle.motion.speed < STANDS {
            return Some(stop);
        }
        let (arrives, leaves) = (to_area.max(0.0) / vehicle.motion.speed, out_of_it / vehicle.motion.speed);
        let (enters, is_out) =
            (self.time_for(area.pedestrian.from, speed), self.time_for(area.pedestrian.to, speed));
        if is_out + self.time_margin <= arrives || leaves + self.time_margin <= enters {
            return None;
        }
        let could_stop =
            |deceleration: f64| vehicle.motion.speed * vehicle.motion.speed <= 2.0 * deceleration * to_area;
        match self.expects_deceleration {
            Some(deceleration) if to_area > 0.0 && could_stop(deceleration) => None,
            _ => Some(stop),
        }
    }

    /// What it has to do about a vehicle on whose path it rides, if that is before it.
    fn stop_behind(&self, scene: &Scene, vehicle: &VehicleState, way: Vector2<f64>) -> Option<Stop> {
        let apart = vehicle.position() - scene.ego().position;
        let heading = vehicle.heading();
        let (along, across) = (heading.dot(&way).abs(), heading.perp(&way).abs());
        let reach = (vehicle.length * along + vehicle.width * across + self.body.0) / 2.0;
        let beside = (vehicle.length * across + vehicle.width * along + self.body.1) / 2.0;
        let ahead = apart.dot(&way);
        (ahead > 0.0 && apart.perp(&way).abs() < beside)
            .then(|| Stop { gap: ahead - reach - self.room, recedes: vehicle.velocity().dot(&way) })
    }

    /// The kerb that it comes to, if it has no green there.
    fn stop_at_red(&self, scene: &Scene, way: Vector2<f64>) -> Option<Stop> {
        if !self.obeys_signals || scene.pedestrian_priority() {
            return None;
        }
        let place = scene.ego().position;
        let before = |place: Vector2<f64>| {
            (scene.road.kerb(self.side) - scene.road.across(place)) * self.side.walking_sign()
        };
        let (here, nearer) = (before(place), before(place) - before(place + way * KERB_PROBE));
        // Who is on the road leaves it.
        (here >= 0.0 && nearer > 0.0)
            .then(|| Stop { gap: here * KERB_PROBE / nearer - self.body.0 / 2.0 - self.room, recedes: 0.0 })
    }

    /// The stop that takes the hardest braking.
    fn nearest_stop(&self, scene: &Scene, way: Vector2<f64>, speed: f64) -> Option<Stop> {
        let seen = (0..scene.vehicles.len()).filter(|index| sees_vehicle(scene, *index));
        let vehicles = seen.filter_map(|index| self.stop_for(scene, &scene.vehicles[index], way, speed));
        let hardest = |one: &Stop, other: &Stop| {
            one.needs(speed).total_cmp(&other.needs(speed)).then(other.gap.total_cmp(&one.gap))
        };
        vehicles.chain(self.stop_at_red(scene, way)).max_by(hardest)
    }
}

impl Pedestrian for YieldingCyclist {
    fn act(&mut self, scene: &Scene) -> Motion {
        let ego = scene.ego();
        let to_goal = Vector2::new(scene.goal.x, scene.goal.y) - ego.position;
        let way = match to_goal.try_normalize(1e-9) {
            // Past its goal it goes on as it came.
            Some(way) if way.dot(&ego.heading) > 0.0 => way,
            _ => ego.heading,
        };
        if std::mem::take(&mut self.appears_rolling) {
            return Motion::Walk(way * self.speed);
        }
        let speed = ego.velocity.dot(&way).max(0.0);
        let speeds_up = Motion::Accelerate(self.acceleration.min((self.speed - speed) / scene.step));
        let Some(stop) = self.nearest_stop(scene, way, speed) else {
            (self.since, self.brakes, self.mode) = (None, false, "riding");
            return speeds_up;
        };
        let since = *self.since.get_or_insert(scene.time);
        if speed < STANDS && stop.recedes < STANDS {
            self.mode = "waiting";
            return Motion::Walk(Vector2::zeros());
        }
        if scene.time - since < self.reaction_time - TIME_TOLERANCE && !self.brakes {
            return speeds_up;
        }
        let needed = stop.needs(speed);
        // Where it cannot stop any more it had better be across soon.
        if !self.brakes && needed > self.max_deceleration {
            self.mode = "riding";
            return speeds_up;
        }
        self.brakes = self.brakes || needed >= self.deceleration;
        if self.brakes {
            self.mode = "braking";
            return Motion::Accelerate(-needed.clamp(self.deceleration, self.max_deceleration));
        }
        speeds_up
    }

    fn mode(&self) -> Mode {
        Mode::new(self.mode)
    }

    fn free_speed(&self) -> f64 {
        self.speed
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use scenario::{RoadUserKind, Settings, Value};

    use super::*;
    use crate::pedestrian::test_walk::{Walk, world};

    /// On a bicycle, with the middle so far before the centre of the lane (m).
    fn rides(from: f64, settings: &[(&str, Value)]) -> Walk {
        let mut walk = Walk::new(&crate::pedestrian::scripted::scripted(), Settings::default());
        let setup = &mut walk.world.pedestrians[0];
        (setup.kind, setup.shape) = (RoadUserKind::Cyclist, RoadUserKind::Cyclist.body());
        setup.start.y = -from;
        walk.rebuild(&yielding_cyclist(), Settings::from(settings)).unwrap();
        let shape = walk.world.pedestrians[0].shape;
        (walk.state().position.y, walk.state().shape) = (-from, shape);
        walk
    }

    /// Half of what a car of the fixture and the bicycle fill of each other's way, m.
    const ALONG_THE_WAY: f64 = (1.89 + 2.007) / 2.0;
    const ALONG_THE_LANE: f64 = (4.514 + 0.5) / 2.0;

    fn touches(walk: &mut Walk) -> bool {
        let place = walk.state().position.y;
        let car = &walk.vehicles[0];
        place.abs() < ALONG_THE_WAY && car.motion.travelled.abs() < ALONG_THE_LANE
    }

    /// The hardest braking and whether it was hit.
    fn ride(walk: &mut Walk, duration: f64) -> (f64, bool) {
        let (mut hardest, mut hit) = (0.0_f64, false);
        while walk.time < duration {
            if let Motion::Accelerate(acceleration) = walk.step() {
                hardest = hardest.max(-acceleration);
            }
            hit |= touches(walk);
        }
        (hardest, hit)
    }

    #[test]
    fn alone_it_rides_at_its_speed_or_gets_to_it() {
        let mut rolling = rides(20.0, &[]);
        assert!((rolling.time_to_reach(0.0) - 20.0 / (20.0 / 3.6)).abs() < 1e-9);
        let mut standing = rides(20.0, &[("rolling", Value::Flag(false))]);
        // 0.5 m/s² over 20 m: t = √(2 · 20 / 0.5).
        assert!((standing.time_to_reach(0.0) - 80.0_f64.sqrt()).abs() < 0.01);
        standing.go(30.0);
        assert!((standing.state().velocity.y - 20.0 / 3.6).abs() < 1e-9);
    }

    #[test]
    fn it_lets_a_car_pass_for_which_it_has_to_wait() {
        let mut walk = rides(40.0, &[]);
        // At 40 / 5.56 = 7.2 s both would be there.
        walk.add_car(-72.0, 10.0);
        let (hardest, hit) = ride(&mut walk, 30.0);
        assert!(!hit && (2.45..=2.6).contains(&hardest), "{hardest}");
        assert!(walk.position().y > 20.0);
    }

    #[test]
    fn it_goes_first_where_there_is_time_and_brakes_for_nobody_then() {
        let margin = |car: f64| {
            let mut walk = rides(40.0, &[]);
            walk.add_car(car, 10.0);
            ride(&mut walk, 30.0)
        };
        // It is out of the way after (40 + 1.95) / 5.56 = 7.55 s; the car comes 1 s later, or little before that.
        assert_eq!(margin(-(7.551 + 1.0) * 10.0 - ALONG_THE_LANE), (0.0, false));
        assert!(margin(-(7.551 + 0.98) * 10.0 - ALONG_THE_LANE).0 >= 2.45);
        // It comes after (40 - 1.95) / 5.56 = 6.85 s.
        assert_eq!(margin(-(6.849 - 1.0) * 10.0 + ALONG_THE_LANE), (0.0, false));
        assert!(margin(-(6.849 - 0.98) * 10.0 + ALONG_THE_LANE).0 >= 2.45);
    }

    #[test]
    fn too_late_to_stop_it_rides_on() {
        // Reaction takes 13.9 m, braking 4.5 m.
        let mut walk = rides(15.0, &[]);
        walk.add_car(-27.0, 10.0);
        assert_eq!(ride(&mut walk, 10.0), (0.0, true));
    }

    #[test]
    fn it_minds_nobody_who_could_stop_where_it_expects_that() {
        let expects = [("expects_deceleration", Value::Number(2.0))];
        let mut walk = rides(40.0, &expects);
        walk.add_car(-72.0, 10.0);
        // Once the car can no longer stop (25 m before it), reaction takes longer than the way that is left.
        assert_eq!(ride(&mut walk, 12.0), (0.0, true));
        let mut alert = rides(40.0, &[expects[0].clone(), ("reaction_time", Value::Number(0.2))]);
        alert.add_car(-72.0, 10.0);
        assert!(!ride(&mut alert, 30.0).1);
    }

    #[test]
    fn it_stops_behind_what_stands_in_its_way() {
        let mut walk = rides(60.0, &[]);
        walk.add_car(0.0, 0.0);
        let (hardest, hit) = ride(&mut walk, 40.0);
        assert!(!hit && hardest < 2.6, "{hardest}");
        let place = walk.position().y;
        assert!((-ALONG_THE_WAY - 0.9..=-ALONG_THE_WAY - 0.5 + 1e-9).contains(&place), "{place}");
    }

    #[test]
    fn only_cyclists_ride() {
        let refused = Walk::try_new(&yielding_cyclist(), Settings::default()).err().unwrap();
        assert!(refused.to_string().contains("people on bicycles"), "{refused}");
        assert_eq!(world().pedestrians[0].kind, RoadUserKind::Pedestrian);
        let harder = [("deceleration", Value::Number(4.0))];
        let mut walk = rides(20.0, &[]);
        assert!(walk.rebuild(&yielding_cyclist(), Settings::from(&harder[..])).is_err());
    }

    proptest! {
        #[test]
        fn who_can_stop_is_not_hit_by_a_car_that_keeps_its_speed(
            from in 24.0..80.0_f64, // reaction 13.9 m, braking 4.6 m, bodies 2 m, room 0.5 m
            car in -150.0..-5.0_f64,
            speed in 3.0..25.0_f64,
        ) {
            let mut walk = rides(from, &[]);
            walk.add_car(car, speed);
            let (hardest, hit) = ride(&mut walk, 60.0);
            prop_assert!(!hit && hardest <= 3.4, "{hardest} {hit}");
            prop_assert!(walk.position().y > 10.0);
        }

        #[test]
        fn whom_it_does_not_meet_does_not_matter_nor_does_the_order(
            car in -150.0..-5.0_f64,
            speed in 3.0..25.0_f64,
            far in 300.0..900.0_f64,
        ) {
            let course = |others: &[(f64, f64)]| {
                let mut walk = rides(40.0, &[]);
                others.iter().for_each(|(x, speed)| walk.add_car(*x, *speed));
                let places: Vec<f64> = (0..800).map(|_| { walk.step(); walk.position().y }).collect();
                places
            };
            let alone = course(&[(car, speed)]);
            prop_assert_eq!(&alone, &course(&[(car, speed), (far, speed)]));
            prop_assert_eq!(&alone, &course(&[(-far - 700.0, 1.0), (car, speed)]));
        }
    }
}
