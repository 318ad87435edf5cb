//! What is known of a world before it runs: who starts where, and who is hidden from whom and meets whom if all keep their speed.

use nalgebra::Vector2;

use numbers::random::ranks;
use scenario::{Path, PedestrianContext, PedestrianSetup, Settings, VehicleSetup, World};
use sim::geometry::Footprint;
use sim::sight::{covers_part, is_hidden};
use sim::{
    Longitudinal, Pedestrian, Solid, VehicleState, appears_after, beginning, path_conflicts, walking_time,
};

/// Everything that is known beforehand.
pub(crate) struct Outlook {
    /// Where they start, in the order of the world.
    pub(crate) cars: Vec<VehicleState>,
    pub(crate) people: Vec<Person>,
    pub(crate) sights: Vec<Sight>,
    pub(crate) meetings: Vec<Meeting>,
}

/// Somebody as they start.
pub(crate) struct Person {
    pub(crate) outline: Footprint,
    pub(crate) goal: Vector2<f64>,
    /// What they follow who walk along a bend.
    follows: Option<Path>,
    /// s, as long as vehicles keep their speed; `None`: they never do.
    pub(crate) appears: Option<f64>,
    /// m/s, without traffic; `None` where nobody can tell.
    pub(crate) speed: Option<f64>,
    /// Times (s) after their appearance at which they have gone so far (m), if they mind nobody.
    walk: Vec<(f64, f64)>,
}

/// Whether a vehicle sees somebody when they appear.
pub(crate) struct Sight {
    pub(crate) vehicle: usize,
    pub(crate) pedestrian: usize,
    /// When that is, s.
    pub(crate) time: f64,
    /// Of the sensor, world frame, m.
    pub(crate) from: Vector2<f64>,
    pub(crate) to: Vector2<f64>,
    /// What hides them: boxes and, where they are if all keep their speed, vehicles and people.
    pub(crate) hidden_by: Vec<Solid>,
    /// From when on nothing is between them any more, if both go on, s; `None`: not before they meet.
    pub(crate) clear_from: Option<f64>,
    /// What this vehicle makes of it.
    pub(crate) kind: SightKind,
}

/// What a vehicle makes of what is between it and somebody.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SightKind {
    /// They hide others.
    Blocked,
    /// It has no `sees`, or one without occlusion: it looks through them.
    Through,
}

/// Where two courses meet.
pub(crate) struct Meeting {
    pub(crate) vehicle: usize,
    pub(crate) with: Solid,
    /// World frame, m.
    pub(crate) point: Vector2<f64>,
    /// When the centres of both are there, the vehicle's first, s.
    pub(crate) times: (f64, f64),
    /// From when to when the bodies of both are where the other's could be, the vehicle's first, s.
    pub(crate) between: ((f64, f64), (f64, f64)),
}

impl Meeting {
    /// Whether both are there at one time.
    pub(crate) fn touches(&self) -> bool {
        let ((one_from, one_to), (other_from, other_to)) = self.between;
        one_from < other_to && other_from < one_to
    }
}

impl Meeting {
    /// From when the one has left where both could be to when the other gets there, s.
    pub(crate) fn apart(&self) -> f64 {
        let (car, person) = self.between;
        (person.0 - car.1).max(car.0 - person.1)
    }

    /// Whether another is of a vehicle of the same stream with the same pedestrian.
    pub(crate) fn is_alike(&self, other: &Self, world: &World) -> bool {
        let stream = |vehicle| world.streams.iter().position(|stream| stream.vehicles.contains(&vehicle));
        self.with == other.with
            && stream(self.vehicle).is_some()
            && stream(self.vehicle) == stream(other.vehicle)
    }
}

/// A walk is looked at every so many metres.
const LOOKS: f64 = 0.25;

/// Whether somebody is hidden is looked at every so many seconds.
const MOMENTS: f64 = 0.02;

impl Outlook {
    /// Of a world whose models are known; what chance decides is taken from this seed.
    pub(crate) fn of(world: &World, seed: u64) -> Self {
        let start = beginning(world);
        let names: Vec<&str> = world.pedestrians.iter().map(|setup| setup.name.as_str()).collect();
        let people: Vec<Person> = (0..world.pedestrians.len())
            .map(|index| {
                let rank = ranks(&names)[index];
                person(
                    world,
                    &start.vehicles,
                    index,
                    Footprint::from(&start.pedestrians[index]),
                    (rank, seed),
                )
            })
            .collect();
        let mut outlook = Self { cars: start.vehicles, people, sights: Vec::new(), meetings: Vec::new() };
        for vehicle in 0..world.vehicles.len() {
            for pedestrian in 0..world.pedestrians.len() {
                outlook.meetings.extend(outlook.meeting(world, vehicle, pedestrian));
                outlook.sights.extend(outlook.sight(world, vehicle, pedestrian));
            }
            for other in 0..world.vehicles.len() {
                outlook.meetings.extend(outlook.catches(world, vehicle, other));
                if vehicle < other {
                    outlook.meetings.extend(outlook.cross(world, vehicle, other));
                }
            }
        }
        outlook
    }

    /// Where a vehicle's path and somebody's way cross, or where it runs into who walks along its lane.
    fn meeting(&self, world: &World, vehicle: usize, pedestrian: usize) -> Option<Meeting> {
        let (who, driven) = (&world.pedestrians[pedestrian], &world.vehicles[vehicle]);
        if world.crosses_from(who, driven).is_none() {
            return if driven.road == 0 { self.runs_into(world, vehicle, pedestrian) } else { None };
        }
        let (car, person) = (&self.cars[vehicle], &self.people[pedestrian]);
        let (appears, way) = (person.appears?, person.way()?);
        let size = (car.length, car.width);
        let place = car.motion.travelled;
        let area = car.path.conflict_area(
            (place, size),
            (person.outline.centre, way),
            person.outline.shape.extents(),
        )?;
        let far = (person.goal - person.outline.centre).norm();
        let speed = car.motion.speed;
        if speed <= 0.0 || area.point.place < place || !(0.0..=far).contains(&area.point.distance) {
            return None;
        }
        let arrives = |at: f64| (at - place) / speed;
        let walks = |distance: f64| person.after(distance.max(0.0)).map(|time| appears + time);
        // Whoever stops between has not left it.
        let leaves = walks(area.pedestrian.to.min(far)).filter(|_| area.pedestrian.to <= far);
        let times = (arrives(area.point.place), walks(area.point.distance)?);
        let person_between = (walks(area.pedestrian.from)?, leaves.unwrap_or(f64::INFINITY));
        (arrives(area.point.place) <= world.horizon).then_some(Meeting {
            vehicle,
            with: Solid::Pedestrian(pedestrian),
            point: car.path.point(area.point.place),
            times,
            between: ((arrives(area.vehicle.from), arrives(area.vehicle.to)), person_between),
        })
    }

    /// Where the front of a vehicle comes to somebody who walks along its lane.
    fn runs_into(&self, world: &World, vehicle: usize, pedestrian: usize) -> Option<Meeting> {
        let (car, person) = (&self.cars[vehicle], &self.people[pedestrian]);
        let (long, wide) = person.outline.shape.extents();
        let (appears, speed) = (person.appears?, car.motion.speed);
        let front = |time: f64| car.motion.travelled + speed * time + car.length / 2.0;
        let gap = |time: f64| car.path.along(person.at(time)) - long / 2.0 - front(time);
        let beside = car.path.beside(person.outline.centre).abs() - (car.width + wide) / 2.0;
        if beside >= 0.0 || gap(appears) <= 0.0 {
            return None;
        }
        let moments = ((world.horizon - appears) / MOMENTS).clamp(0.0, 1e6) as usize;
        let last =
            (1..=moments).map(|step| appears + MOMENTS * step as f64).find(|time| gap(*time) <= 0.0)?;
        let (before, after) = (gap(last - MOMENTS), gap(last));
        let time = last - MOMENTS * after / (after - before);
        (front(time) <= world.finish).then(|| Meeting {
            vehicle,
            with: Solid::Pedestrian(pedestrian),
            point: car.path.point(front(time)),
            times: (time, time),
            between: ((time, f64::INFINITY), (time, f64::INFINITY)),
        })
    }

    /// Where a vehicle would run into one before it in its lane.
    fn catches(&self, world: &World, vehicle: usize, other: usize) -> Option<Meeting> {
        let (car, before) = (&self.cars[vehicle], &self.cars[other]);
        let gap = before.motion.travelled - car.motion.travelled - (car.length + before.length) / 2.0;
        let closing = car.motion.speed - before.motion.speed;
        let on = |index: usize| (world.vehicles[index].road, world.vehicles[index].lane);
        let same = vehicle != other && on(vehicle) == on(other);
        if !same || gap < 0.0 || closing <= 0.0 {
            return None;
        }
        let time = gap / closing;
        let place = car.motion.travelled + car.motion.speed * time + car.length / 2.0;
        (place <= world.finish && time <= world.horizon).then(|| Meeting {
            vehicle,
            with: Solid::Vehicle(other),
            point: car.path.point(place),
            times: (time, time),
            between: ((time, f64::INFINITY), (time, f64::INFINITY)),
        })
    }

    /// Where the ways of two vehicles on different roads cross, if both come there.
    fn cross(&self, world: &World, vehicle: usize, other: usize) -> Vec<Meeting> {
        if world.vehicles[vehicle].road == world.vehicles[other].road {
            return Vec::new();
        }
        let (car, before) = (&self.cars[vehicle], &self.cars[other]);
        let comes = |car: &VehicleState, place: f64| (place - car.motion.travelled) / car.motion.speed;
        let met = path_conflicts(world, vehicle, other).into_iter().map(|met| Meeting {
            vehicle,
            with: Solid::Vehicle(other),
            point: car.path.point(met.places.0),
            times: (comes(car, met.places.0), comes(before, met.places.1)),
            between: (
                (comes(car, met.first.from), comes(car, met.first.to)),
                (comes(before, met.second.from), comes(before, met.second.to)),
            ),
        });
        met.filter(|met| met.times.0.max(met.times.1) <= world.horizon).collect()
    }

    fn sight(&self, world: &World, vehicle: usize, pedestrian: usize) -> Option<Sight> {
        let (setup, person) = (&world.vehicles[vehicle], &self.people[pedestrian]);
        let time = person.appears?;
        let ahead = setup.length / 2.0 - sensor_setback(setup);
        let boxes: Vec<Footprint> = world.road.boxes.iter().map(Footprint::from).collect();
        let between = |time: f64| {
            let from = self.sensor(vehicle, ahead, time);
            let to = person.at(time);
            let hides = |index: &usize| boxes[*index].is_crossed(from, to - from);
            let mut hidden_by: Vec<_> = (0..boxes.len()).filter(hides).map(Solid::Box).collect();
            hidden_by.extend(self.before(world, (vehicle, pedestrian), (from, to), time, &boxes));
            (from, to, hidden_by)
        };
        let (from, to, hidden_by) = between(time);
        let met = self
            .meetings
            .iter()
            .find(|one| (one.vehicle, one.with) == (vehicle, Solid::Pedestrian(pedestrian)));
        let last = met.map_or(world.horizon, |met| met.times.0.min(met.times.1)).min(world.horizon);
        let moments = ((last - time) / MOMENTS).clamp(0.0, 1e5) as usize;
        let clear_from = match hidden_by.is_empty() {
            true => Some(time),
            false => (1..=moments)
                .map(|step| time + MOMENTS * step as f64)
                .find(|time| between(*time).2.is_empty()),
        };
        let kind = if setup.sees.as_ref().is_some_and(|sees| flag(&sees.settings, "occlusion")) {
            SightKind::Blocked
        } else {
            SightKind::Through
        };
        Some(Sight { vehicle, pedestrian, time, from, to, hidden_by, clear_from, kind })
    }

    /// Those who would hide somebody at `to` from a vehicle whose sensor is at `from`.
    fn before(
        &self,
        world: &World,
        (vehicle, pedestrian): (usize, usize),
        (from, to): (Vector2<f64>, Vector2<f64>),
        time: f64,
        boxes: &[Footprint],
    ) -> Vec<Solid> {
        let body = Footprint { centre: to, ..self.people[pedestrian].outline };
        let cars = (0..world.vehicles.len()).filter(|car| *car != vehicle).map(|index| {
            let car = &self.cars[index];
            let place = car.motion.travelled + car.motion.speed * time;
            let motion = Longitudinal { travelled: place, ..car.motion };
            (Solid::Vehicle(index), Footprint::from(&car.in_motion(motion)))
        });
        let others = self.people.iter().enumerate().filter(|(index, person)| {
            *index != pedestrian && person.appears.is_some_and(|appears| appears <= time)
        });
        let others = others.map(|(index, person)| {
            (Solid::Pedestrian(index), Footprint { centre: person.at(time), ..person.outline })
        });
        let mut movers: Vec<_> = cars.chain(others).collect();
        if !is_hidden(from, &body, movers.iter().map(|(_, mover)| *mover), boxes.iter().copied()) {
            return Vec::new();
        }
        movers.retain(|(_, mover)| covers_part(from, &body, mover));
        movers.into_iter().map(|(who, _)| who).collect()
    }

    /// Where a vehicle's sensor is after so many seconds at the speed of the start.
    fn sensor(&self, vehicle: usize, ahead: f64, time: f64) -> Vector2<f64> {
        let car = &self.cars[vehicle];
        let (centre, heading) = car.path.pose(car.motion.travelled + car.motion.speed * time);
        centre + heading * ahead
    }
}

impl Person {
    fn way(&self) -> Option<Vector2<f64>> {
        (self.goal - self.outline.centre).try_normalize(0.0)
    }

    /// The time after their appearance at which they have gone so far (m), s.
    fn after(&self, distance: f64) -> Option<f64> {
        let next = self.walk.iter().position(|(gone, _)| *gone >= distance)?;
        let (gone, time) = self.walk[next];
        let Some((before, earlier)) = next.checked_sub(1).map(|index| self.walk[index]) else {
            return Some(time);
        };
        Some(earlier + (time - earlier) * (distance - before) / (gone - before))
    }

    /// Their way from start to goal, as points between which it is straight or nearly so.
    pub(crate) fn points(&self) -> Vec<Vector2<f64>> {
        let Some(path) = &self.follows else { return vec![self.outline.centre, self.goal] };
        let (from, to) = (path.along(self.outline.centre), path.along(self.goal));
        let steps = 100;
        (0..=steps).map(|step| path.point(from + (to - from) * f64::from(step) / f64::from(steps))).collect()
    }

    /// Where they are at a time, s.
    pub(crate) fn at(&self, time: f64) -> Vector2<f64> {
        let (Some(appears), Some(way)) = (self.appears, self.way()) else { return self.outline.centre };
        let since = time - appears;
        let next = self.walk.iter().position(|(_, reached)| *reached >= since);
        let gone = match next {
            Some(0) | None if self.walk.is_empty() || next == Some(0) => 0.0,
            None => self.walk[self.walk.len() - 1].0,
            Some(index) => {
                let ((before, earlier), (gone, later)) = (self.walk[index - 1], self.walk[index]);
                before + (gone - before) * (since - earlier) / (later - earlier)
            }
        };
        match &self.follows {
            Some(path) => path.point(path.along(self.outline.centre) + gone),
            None => self.outline.centre + way * gone,
        }
    }
}

fn person(
    world: &World,
    cars: &[VehicleState],
    index: usize,
    outline: Footprint,
    (rank, seed): (usize, u64),
) -> Person {
    let setup = &world.pedestrians[index];
    let appears = appears_after(world, setup, cars);
    let wait = setup.may_go.wait(|vehicle, reference| {
        let place = setup.met_by(&cars[vehicle].path);
        cars[vehicle].time_to_arrival(place, reference) - appears.unwrap_or(0.0)
    });
    let goal = Vector2::from(setup.goal);
    let far = match &setup.follows {
        Some(path) => path.along(goal) - path.along(outline.centre),
        None => (goal - outline.centre).norm(),
    };
    let alone = World { vehicles: Vec::new(), pedestrians: vec![setup.clone()], ..world.clone() };
    let mind = || build(&alone, setup, (rank, seed));
    let speed = mind().map(|mind| mind.free_speed()).filter(|speed| *speed > 0.0);
    let is_fixed = setup.model.model.known().is_some_and(|model| (model.is_fixed)(&setup.model.settings));
    let mut walk: Vec<(f64, f64)> = if is_fixed {
        let steps = (far / LOOKS).ceil().clamp(0.0, 1e4) as usize;
        let reached = |step: usize| {
            let distance = (LOOKS * step as f64).min(far);
            Some((distance, walking_time(&mut *mind()?, setup, &alone, distance, world.horizon)?))
        };
        std::iter::once(Some((0.0, 0.0))).chain((1..=steps).map(reached)).map_while(|one| one).collect()
    } else {
        speed.map_or_else(Vec::new, |speed| vec![(0.0, 0.0), (far, far / speed)])
    };
    if wait > 0.0 && !walk.is_empty() {
        walk.iter_mut().for_each(|(_, time)| *time += wait);
        walk.insert(0, (0.0, 0.0));
    }
    Person { outline, goal, follows: setup.follows.clone(), appears, speed, walk }
}

fn build(world: &World, setup: &PedestrianSetup, (rank, seed): (usize, u64)) -> Option<Box<dyn Pedestrian>> {
    let model = setup.model.model.known()?;
    let context = PedestrianContext { settings: &setup.model.settings, setup, world, rank, seed };
    (model.build)(&context).ok()
}

fn sensor_setback(setup: &VehicleSetup) -> f64 {
    let given = setup.sees.as_ref().filter(|sees| sees.settings.0.contains_key("sensor_setback"));
    given.map_or(0.0, |sees| sees.settings.number("sensor_setback"))
}

fn flag(settings: &Settings, name: &str) -> bool {
    settings.0.contains_key(name) && settings.flag(name)
}
