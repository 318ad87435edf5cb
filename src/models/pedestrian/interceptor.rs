//! A pedestrian that wants to be hit: it lurks at the kerb and arrives on the vehicle's path together with the bumper.
//!
//! A script in place of the trained agent of Yang, Kujanpaa et al. 2023, of which neither policy nor speeds are public.

use nalgebra::Vector2;

use super::{PedestrianContext, PedestrianModel};
use crate::pedestrian::across::check_across;
use scenario::{
    Chance, ChoiceOption, Declaration, Dimension, Parameter, Position, Road, Side, SignalConduct,
    VehicleReference,
};
use sim::random::{Agent, Purpose, stream};
use sim::{Mode, ModelError, Motion, Pedestrian, Scene, Stated, StatedBy, VehicleState};

const IDEA: &str = "Yang, Kujanpaa et al. 2023, ITSC, arXiv 2309.00249";
const CHOICE: &str = "our choice; the paper's agent is learned";

pub fn interceptor() -> PedestrianModel {
    let declaration = Declaration::new(
        "interceptor",
        "Suicidal pedestrian: lurks at the kerb, then runs so as to meet the vehicle's \
         bumper.",
    )
    .source("after Yang, Kujanpaa et al. 2023, ITSC, arXiv 2309.00249, reduced to a script")
    .parameters([
        Parameter::choice(
            "mode",
            "fast",
            [
                ChoiceOption::new("fast", "Runs at the last moment, for a hit at high speed."),
                ChoiceOption::new("any", "Leaves early enough to walk, for any hit."),
            ],
            "What it is after.",
            IDEA,
        ),
        Parameter::number(
            "aim_offset",
            Dimension::LENGTH,
            0.0,
            (-1.5, 1.5),
            "Where across the vehicle's path it wants to be hit: beyond the lane's centre \
             if positive.",
            CHOICE,
        ),
        Parameter::number(
            "aim_spread",
            Dimension::NUMBER,
            0.0,
            (0.0, 1.0),
            "Adds to the aim a uniform draw from this share of the vehicle's half width, \
             to either side.",
            CHOICE,
        ),
        Parameter::number("max_speed", Dimension::SPEED, 3.0, (2.0, 4.0), "Its fastest run.", CHOICE),
        Parameter::number(
            "max_acceleration",
            Dimension::ACCELERATION,
            4.0,
            (2.0, 6.0),
            "Its largest change of speed.",
            CHOICE,
        ),
        Parameter::number(
            "lead",
            Dimension::TIME,
            0.1,
            (0.0, 0.3),
            "It wants to be in place this long before the bumper.",
            CHOICE,
        ),
        Parameter::number(
            "hold_time",
            Dimension::TIME,
            3.0,
            (0.0, 10.0),
            "It leaves a vehicle that has stood for this long.",
            CHOICE,
        ),
    ]);
    PedestrianModel::new(declaration, build)
        .chance(Chance::If(|settings| settings.number("aim_spread") > 0.0))
        .told_where_to_go()
        .signals(SignalConduct::Never {
            cure: "leave `obeys signals` out, or take `scripted`: it walks so as to be met",
        })
}

/// m/s
const WALKING_SPEED: f64 = 1.4;
/// Time that mode `any` allows besides walking, s.
const RESERVE: f64 = 0.6;
/// Where it lurks, before the kerb, m.
const LURKING_DISTANCE: f64 = 0.3;
/// Below this a vehicle stands, m/s.
const STANDING_SPEED: f64 = 0.1;
/// Nearer to its goal than this it has arrived, m.
const ARRIVAL: f64 = 0.2;
const TIME_TOLERANCE: f64 = 1e-9;

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Approach,
    Lurk,
    /// For the vehicle of this index.
    Commit(usize),
    Leave,
    Finished,
}

struct Interceptor {
    walks_in: bool,
    aim_offset: f64,
    /// Share of a vehicle's half width, -1 .. 1.
    aim_drawn: f64,
    max_speed: f64,
    max_acceleration: f64,
    lead: f64,
    hold_time: f64,
    side: Side,
    /// Since when its vehicle stands, s.
    held_since: Option<f64>,
    state: State,
}

fn build(context: &PedestrianContext) -> Result<Box<dyn Pedestrian>, ModelError> {
    let settings = context.settings;
    check_across(context, "interceptor")?;
    check_place(&context.world.road, context.setup.side, context.setup.start)?;
    let mut traits = stream(context.seed, Agent::Pedestrian(context.rank), Purpose::Trait);
    Ok(Box::new(Interceptor {
        walks_in: settings.word("mode") == "any",
        aim_offset: settings.number("aim_offset"),
        aim_drawn: settings.number("aim_spread") * traits.uniform_in(-1.0, 1.0),
        max_speed: settings.number("max_speed"),
        max_acceleration: settings.number("max_acceleration"),
        lead: settings.number("lead"),
        hold_time: settings.number("hold_time"),
        side: context.setup.side,
        held_since: None,
        state: State::Approach,
    }))
}

fn check_place(road: &Road, side: Side, start: Position) -> Result<(), ModelError> {
    if !road.kerbs {
        return Err(ModelError::with_hint(
            "`interceptor` needs a road with kerbs: it lurks before one",
            "take `no kerbs` out of the road, or take the model `scripted`",
        ));
    }
    let inside = side.walking_sign() * (road.across(start.into()) - road.kerb(side));
    if inside >= 0.0 {
        let inside = Stated { value: inside, dimension: Dimension::LENGTH, of: StatedBy::Start };
        return Err(ModelError::stating(
            "`interceptor` starts {} inside the kerb, but must start on the pavement",
            [inside],
            "start it 0.3 m or more from the kerb",
        ));
    }
    Ok(())
}

impl Interceptor {
    /// How far it still has to go to where it wants to be hit by `vehicle`, m.
    fn distance_to_aim(&self, vehicle: &VehicleState, place: Vector2<f64>) -> f64 {
        let aim = self.aim_offset + self.aim_drawn * vehicle.width / 2.0;
        aim - vehicle.path.beyond(place, self.side)
    }

    /// Time to cover a distance (m) from `speed` (m/s) as fast as it can, s.
    fn run_time(&self, distance: f64, speed: f64) -> f64 {
        if distance <= 0.0 {
            return 0.0;
        }
        let run_up = (self.max_speed * self.max_speed - speed * speed) / (2.0 * self.max_acceleration);
        if distance <= run_up {
            (libm::sqrt(speed * speed + 2.0 * self.max_acceleration * distance) - speed)
                / self.max_acceleration
        } else {
            (self.max_speed - speed) / self.max_acceleration + (distance - run_up) / self.max_speed
        }
    }

    /// The vehicle that it is now time to run for, if any: the one that arrives first.
    fn prey(&self, scene: &Scene, speed: f64) -> Option<usize> {
        let position = scene.ego().position;
        let arrivals = scene.vehicles.iter().enumerate().filter_map(|(index, vehicle)| {
            let arrival = arrival(vehicle, position)?;
            let distance = self.distance_to_aim(vehicle, position);
            let mut needed = self.run_time(distance, speed) + self.lead;
            if self.walks_in {
                needed = needed.max(distance / WALKING_SPEED + RESERVE);
            }
            (arrival <= needed).then_some((index, arrival, distance))
        });
        // Of those that arrive together the one on the nearest lane, in whatever order they come.
        let first = arrivals.min_by(|one, other| one.1.total_cmp(&other.1).then(one.2.total_cmp(&other.2)));
        first.map(|(index, ..)| index)
    }

    /// The speed that takes it a distance (m) and lets it stop there, at most `limit` (m/s).
    fn speed_to_stop(&self, distance: f64, limit: f64, step: f64) -> f64 {
        let braking = libm::sqrt(2.0 * self.max_acceleration * distance.abs());
        distance.signum() * limit.min(braking).min(distance.abs() / step)
    }
}

/// Time until the bumper is abreast of a point, s; infinite if the vehicle stands, `None` once past.
fn arrival(vehicle: &VehicleState, place: Vector2<f64>) -> Option<f64> {
    let distance = vehicle.distance_to(vehicle.path.along(place), VehicleReference::Front);
    if distance <= 0.0 {
        None
    } else if vehicle.motion.speed < STANDING_SPEED {
        Some(f64::INFINITY)
    } else {
        Some(distance / vehicle.motion.speed)
    }
}

impl Pedestrian for Interceptor {
    fn act(&mut self, scene: &Scene) -> Motion {
        let sign = self.side.walking_sign();
        let (position, step) = (scene.ego().position, scene.step);
        let (road, across) = (scene.road, scene.road.across(position));
        let speed = sign * road.speed_across(position, scene.ego().velocity);
        let lurking_place = sign * road.kerb(self.side) - LURKING_DISTANCE;
        let to_lurking_place = lurking_place - sign * across;
        let to_goal = sign * (road.across(scene.goal.into()) - across);

        if self.state == State::Approach && to_lurking_place <= 1e-6 {
            self.state = State::Lurk;
        }
        if let State::Approach | State::Lurk = self.state
            && let Some(index) = self.prey(scene, speed.max(0.0))
        {
            self.state = State::Commit(index);
        }
        if let State::Commit(index) = self.state {
            let vehicle = &scene.vehicles[index];
            let stands = vehicle.motion.speed < STANDING_SPEED;
            self.held_since = stands.then(|| self.held_since.unwrap_or(scene.time));
            let held = self.held_since.map_or(0.0, |since| scene.time - since);
            if arrival(vehicle, position).is_none() || (stands && held >= self.hold_time - TIME_TOLERANCE) {
                self.state = State::Leave;
            }
        }
        if to_goal < ARRIVAL {
            self.state = State::Finished;
        }

        let wanted = match self.state {
            State::Approach => self.speed_to_stop(to_lurking_place, WALKING_SPEED, step),
            State::Lurk | State::Finished => 0.0,
            State::Commit(index) => {
                let vehicle = &scene.vehicles[index];
                let distance = self.distance_to_aim(vehicle, position);
                match arrival(vehicle, position) {
                    Some(time) if time.is_finite() => {
                        (distance / (time - self.lead).max(step)).clamp(0.0, self.max_speed)
                    }
                    _ => self.speed_to_stop(distance, WALKING_SPEED, step),
                }
            }
            State::Leave => self.max_speed,
        };
        let most = self.max_acceleration * step;
        let faster = match self.state {
            State::Lurk | State::Finished => 0.0,
            _ => speed + (wanted - speed).clamp(-most, most),
        };
        Motion::Walk(road.crossing_velocity(position, self.side, faster))
    }

    fn mode(&self) -> Mode {
        Mode::new(match self.state {
            State::Approach => "approaching",
            State::Lurk => "lurking",
            State::Commit(_) => "committed",
            State::Leave => "leaving",
            State::Finished => "finished",
        })
    }

    fn free_speed(&self) -> f64 {
        WALKING_SPEED
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::test_walk::Walk;
    use scenario::Settings;

    #[test]
    fn it_needs_a_kerb_to_lurk_behind() {
        let mut walk = Walk::new(&interceptor(), Settings::default());
        walk.world.road.kerbs = false;
        assert!(walk.rebuild(&interceptor(), Settings::default()).expect_err("no kerb").hint.is_some());
        walk.world.road.kerbs = true;
        walk.world.pedestrians[0].start.y = 0.0;
        let error = walk.rebuild(&interceptor(), Settings::default()).expect_err("in the road");
        assert!(error.to_string().contains("2 m inside"));
    }

    #[test]
    fn it_lurks_where_it_should_without_a_vehicle() {
        let mut walk = Walk::new(&interceptor(), Settings::default());
        walk.go(20.0);
        assert_eq!(walk.pedestrian.mode(), "lurking");
        assert!((walk.position().y + 2.3).abs() < 1e-3, "{}", walk.position().y);
    }
}
