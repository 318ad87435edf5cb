//! What every metric of a pair needs to know, worked out once: contact, passings, time in the lane, time to collision.

use nalgebra::Vector2;

use super::edges::EdgeContact;
use super::events::{Passing, Visit, half_extent, lerp, part_within, rising};
use super::followed::{Followed, FollowedDrop, FollowedJerk};
use super::jerk::Jerk;
use super::passage::Passage;
use super::presence::{Closeness, Presence, PresenceMeter, PresenceStep, STANDSTILL};
use super::speed_drop::SpeedDrop;
use super::steered_pair::{SteeredWay, WalkedWay};
use super::vehicle_pair::VehiclePair;
use crate::clear_ahead::ContactAhead;
use crate::geometry::Footprint;
use crate::turning::touched_between;
use crate::{PedestrianState, Solid, Step, VehicleState};
use scenario::{Located, Side, VehicleSetup, World};

/// The encounters of every vehicle with every pedestrian of a run.
pub struct Encounters {
    passages: Vec<Passage>,
    /// The largest speed that each vehicle has had, m/s.
    fastest: Vec<f64>,
    /// Whether each vehicle had moved by the beginning of the last step.
    had_moved: Vec<bool>,
    /// Vehicle by vehicle.
    pairs: Vec<Encounter>,
    pedestrians: usize,
    /// Vehicles that a criterion names together.
    vehicle_pairs: Vec<VehiclePair>,
    /// The ways of vehicles that may be steered; `None` of the others.
    steered: Vec<Option<SteeredWay>>,
    /// Those of pedestrians, where a vehicle may be steered.
    walked: Vec<WalkedWay>,
    /// Touches of a vehicle and another or a box, in order.
    others: Vec<(usize, Solid, Contact)>,
    followed: Followed,
    /// Whether the body of a vehicle leaves its carriageway, for vehicles on roads with kerbs.
    edges: Vec<EdgeContact>,
}

/// One vehicle and one pedestrian.
///
/// "The line" is the centre line of the vehicle's lane, which is the vehicle's path. "The strip" is what the
/// vehicle's footprint sweeps: its width along that line.
#[derive(Debug, Clone)]
pub struct Encounter {
    /// That the pedestrian comes from.
    side: Side,
    half_lane: f64,
    /// Whether the pedestrian's way leads across the vehicle's lane. Who walks along it passes nothing of it.
    pub crosses: bool,
    /// When the pedestrian appeared, s.
    pub appeared: Option<f64>,
    /// When the pedestrian might go, s.
    pub let_go: Option<f64>,
    /// The first touch of the footprints.
    pub contact: Option<Contact>,
    /// Every time the pedestrian's centre passes the line, in order, in either direction.
    pub passings: Vec<Passing>,
    /// Every stay of the pedestrian's footprint in the strip, in order.
    pub visits: Vec<Visit>,
    in_strip: bool,
    /// The first time that the pedestrian's centre enters the lane from its own side, or appears in it.
    pub first_entry: Option<Entry>,
    /// The last time that it does, s.
    pub last_entry: Option<f64>,
    /// The crossing of the lane that was carried through.
    pub crossing: Option<LaneCrossing>,
    /// `None` where nobody asks.
    ahead: Option<Ahead>,
    /// Where the pedestrian lies, seen from the vehicle's path, at the beginning and at the end of the last step in which they were
    /// there.
    pub places: Option<(Located, Located)>,
    /// The strip where the pedestrian lies at the end of that step, as distances beside the path as [`Located::beside`] counts them, m.
    pub strip: (f64, f64),
    presence: PresenceMeter,
}

/// How long it takes two to touch who go on as they do.
#[derive(Debug, Clone)]
struct Ahead {
    contact: ContactAhead,
    /// s
    time: Option<f64>,
}

/// The first touch of two footprints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// s
    pub time: f64,
    /// m/s
    pub relative_speed: f64,
    /// Of the other against the vehicle, m/s.
    pub relative_velocity: Vector2<f64>,
}

/// A pedestrian's centre comes into a vehicle's lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// s
    pub time: f64,
    /// From the vehicle's centre to the pedestrian, along the lane, m.
    pub distance: f64,
    /// Of the vehicle, m/s.
    pub speed: f64,
}

/// A pedestrian's way through a vehicle's lane, from one edge to the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaneCrossing {
    /// s
    pub entered: f64,
    /// s
    pub left: f64,
}

/// More visits or passings than this cost an allocation; nobody dithers that much.
const EXPECTED_EVENTS: usize = 16;

impl Encounters {
    /// Of a run of this world that has not begun, with what is to be followed; allocates what all of its steps need.
    pub fn new(world: &World, followed: Followed) -> Self {
        let steps = (world.horizon / world.step).ceil().clamp(0.0, 1e6) as usize + 1;
        let encounter = |(car, pedestrian): (&VehicleSetup, usize)| Encounter {
            side: world
                .crosses_from(&world.pedestrians[pedestrian], car)
                .unwrap_or(world.pedestrians[pedestrian].side),
            half_lane: world.road_of(car).lane_width / 2.0,
            crosses: world.crosses_from(&world.pedestrians[pedestrian], car).is_some(),
            appeared: None,
            let_go: None,
            contact: None,
            passings: Vec::with_capacity(EXPECTED_EVENTS),
            visits: Vec::with_capacity(EXPECTED_EVENTS),
            in_strip: false,
            first_entry: None,
            last_entry: None,
            crossing: None,
            ahead: followed.looks_ahead().then(|| Ahead {
                contact: ContactAhead::new(world.path_of(car).course().is_some()),
                time: None,
            }),
            places: None,
            strip: (0.0, 0.0),
            presence: PresenceMeter::default(),
        };
        let pedestrians = world.pedestrians.len();
        Self {
            passages: vec![Passage::with_capacity(steps); world.vehicles.len()],
            fastest: vec![0.0; world.vehicles.len()],
            had_moved: vec![false; world.vehicles.len()],
            pairs: world
                .vehicles
                .iter()
                .flat_map(|car| (0..pedestrians).map(move |person| (car, person)))
                .map(encounter)
                .collect(),
            pedestrians,
            vehicle_pairs: followed
                .vehicle_pairs()
                .iter()
                .map(|pair| VehiclePair::new(world, *pair))
                .collect(),
            steered: world.vehicles.iter().map(|car| car.may_steer().then(SteeredWay::default)).collect(),
            walked: match world.vehicles.iter().any(VehicleSetup::may_steer) {
                true => vec![WalkedWay::default(); pedestrians],
                false => Vec::new(),
            },
            others: Vec::new(),
            followed,
            edges: world
                .vehicles
                .iter()
                .enumerate()
                .filter(|(_, car)| world.road_of(car).kerbs)
                .map(|(index, car)| EdgeContact::new(world, index, car.length / 2.0))
                .collect(),
        }
    }

    /// The jerk that a meter asked for.
    pub fn jerk(&self, which: FollowedJerk) -> &Jerk {
        self.followed.of_jerk(which)
    }

    /// The drop of speed that a meter asked for.
    pub fn speed_drop(&self, which: FollowedDrop) -> &SpeedDrop {
        self.followed.of_drop(which)
    }

    /// By their indices in the world.
    pub fn pair(&self, vehicle: usize, pedestrian: usize) -> &Encounter {
        &self.pairs[vehicle * self.pedestrians + pedestrian]
    }

    /// How many vehicles and how many pedestrians there are.
    pub fn counts(&self) -> (usize, usize) {
        (self.passages.len(), self.pedestrians)
    }

    /// What a vehicle and a pedestrian had to do with each other, by their indices in the world.
    pub fn presence(&self, vehicle: usize, pedestrian: usize) -> Presence {
        let pair = self.pair(vehicle, pedestrian);
        let seen = pair.presence.presence();
        match pair.contact {
            Some(_) => Presence { closest: Closeness::Touched, ..seen },
            None => seen,
        }
    }

    /// What the vehicles had to do with each other that a criterion names together, with their indices in the world.
    pub fn vehicle_presences(&self) -> impl Iterator<Item = ((usize, usize), Presence)> {
        self.vehicle_pairs.iter().map(|pair| {
            let (one, other) = pair.vehicles;
            let touched = self.contact(one, Solid::Vehicle(other)).is_some();
            (pair.vehicles, pair.presence(&self.passages, touched))
        })
    }

    /// The indices of the vehicles whose bodies left their carriageways.
    pub fn left_road(&self) -> impl Iterator<Item = usize> {
        self.edges.iter().filter(|edge| edge.first().is_some()).map(EdgeContact::vehicle)
    }

    /// When the vehicle of this index reached which place.
    pub fn passage(&self, vehicle: usize) -> &Passage {
        &self.passages[vehicle]
    }

    /// The first touch of a vehicle and something else.
    pub fn contact(&self, vehicle: usize, with: Solid) -> Option<Contact> {
        match with {
            Solid::Pedestrian(pedestrian) => self.pair(vehicle, pedestrian).contact,
            _ => {
                let is_it = |(first, second, _): &&(usize, Solid, Contact)| {
                    (*first, *second) == (vehicle, with)
                        || (Solid::Vehicle(*first), *second) == (with, Solid::Vehicle(vehicle))
                };
                self.others.iter().find(is_it).map(|(first, _, contact)| Contact {
                    relative_velocity: if *first == vehicle {
                        contact.relative_velocity
                    } else {
                        -contact.relative_velocity
                    },
                    ..*contact
                })
            }
        }
    }

    /// Whether a vehicle has touched anything.
    pub fn has_touched(&self, vehicle: usize) -> bool {
        let people = &self.pairs[vehicle * self.pedestrians..(vehicle + 1) * self.pedestrians];
        let is_it = |(first, second, _): &(usize, Solid, Contact)| {
            *first == vehicle || *second == Solid::Vehicle(vehicle)
        };
        people.iter().any(|pair| pair.contact.is_some()) || self.others.iter().any(is_it)
    }

    /// Whether a vehicle has touched a pedestrian.
    pub fn was_hit(&self, pedestrian: usize) -> bool {
        let mut pairs = self.pairs.iter().skip(pedestrian).step_by(self.pedestrians);
        pairs.any(|pair| pair.contact.is_some())
    }

    /// Follows a step.
    pub fn observe(&mut self, step: &Step) {
        self.followed.observe(step);
        self.edges.iter_mut().for_each(|edge| edge.observe(step));
        for touch in step.contacts.iter().filter(|touch| touch.begins) {
            let Solid::Vehicle(vehicle) = touch.first else { continue };
            let contact = Contact {
                time: step.time + touch.moment,
                relative_speed: touch.relative_speed,
                relative_velocity: touch.relative_velocity,
            };
            match touch.second {
                Solid::Pedestrian(pedestrian) => {
                    let pair = &mut self.pairs[vehicle * self.pedestrians + pedestrian];
                    pair.contact.get_or_insert(contact);
                }
                other => self.others.push((vehicle, other, contact)),
            }
        }
        for (index, passage) in self.passages.iter_mut().enumerate() {
            let (before, after) = (&step.before.vehicles[index], &step.after.vehicles[index]);
            let end = step.time + step.duration;
            self.had_moved[index] = self.fastest[index] > STANDSTILL;
            self.fastest[index] = self.fastest[index].max(before.motion.speed).max(after.motion.speed);
            passage.observe((step.time, before.motion.travelled), (end, after.motion.travelled));
        }
        if self.steered.iter().any(Option::is_some) {
            self.follow_ways(step);
        }
        for (index, pair) in self.pairs.iter_mut().enumerate() {
            let (vehicle, pedestrian) = (index / self.pedestrians, index % self.pedestrians);
            if step.before.pedestrians[pedestrian].present {
                pair.observe(step, vehicle, pedestrian);
                let has_moved = (self.had_moved[vehicle], self.fastest[vehicle] > STANDSTILL);
                pair.follow_presence(step, (vehicle, has_moved), pedestrian);
            }
        }
        for pair in &mut self.vehicle_pairs {
            pair.observe(step, &self.fastest);
        }
    }

    /// Where everybody is, if a vehicle may be steered.
    fn follow_ways(&mut self, step: &Step) {
        for (index, way) in self.steered.iter_mut().enumerate() {
            let Some(way) = way else { continue };
            for state in [step.before, step.after] {
                way.observe(&state.vehicles[index]);
            }
        }
        for (index, way) in self.walked.iter_mut().enumerate() {
            if step.before.pedestrians[index].present {
                way.observe(step, index);
            }
        }
    }

    /// Whether a vehicle was steered so far, and so is not where its lane says.
    pub fn was_steered(&self, vehicle: usize) -> bool {
        self.steered[vehicle].as_ref().is_some_and(SteeredWay::was_steered)
    }

    /// The run is over: what is known of vehicles that were steered by their way as a whole.
    pub fn end(&mut self) {
        for (index, pair) in self.pairs.iter_mut().enumerate() {
            let (vehicle, pedestrian) = (index / self.pedestrians, index % self.pedestrians);
            let way = self.steered[vehicle].as_ref().filter(|way| way.was_steered());
            if let Some(way) = way.filter(|_| pair.crosses) {
                pair.passings = self.walked[pedestrian].passings(way, pair.side);
                pair.visits = self.walked[pedestrian].visits(way);
            }
        }
    }
}

impl Encounter {
    /// Time to collision of the footprints if both kept their velocities from the end of the step on, s; `None` if
    /// they are not on a collision course.
    ///
    /// # Panics
    /// If no meter asked for it by [`MetricContext::look_ahead`](super::MetricContext::look_ahead).
    pub fn time_to_collision(&self) -> Option<f64> {
        self.ahead.as_ref().expect("whoever reads times to collision has asked for them").time
    }

    /// Whether the pedestrian's centre was in the lane at the end of the last step in which they were there.
    pub fn is_in_lane(&self) -> bool {
        self.places.is_some_and(|(_, place)| place.beside.abs() < self.half_lane)
    }

    /// The last passing of the line if it is the one that the pedestrian carried through.
    pub fn final_passing(&self) -> Option<Passing> {
        self.passings.last().copied().filter(|passing| passing.towards_goal)
    }

    fn observe(&mut self, step: &Step, vehicle: usize, pedestrian: usize) {
        let (old_car, car) = (&step.before.vehicles[vehicle], &step.after.vehicles[vehicle]);
        let (old, new) = (&step.before.pedestrians[pedestrian], &step.after.pedestrians[pedestrian]);
        self.appeared.get_or_insert(step.time);
        if step.may_go(pedestrian) {
            self.let_go.get_or_insert(step.time);
        }
        if let Some(ahead) = &mut self.ahead {
            ahead.time = ahead.contact.look(step.time + step.duration, car, new);
        }
        // Where a step ends the next one begins.
        let locate = |position: Vector2<f64>| {
            let known = step.abreast.known(vehicle, pedestrian, position);
            known.unwrap_or_else(|| car.path.locate(position))
        };
        let before = self.places.map_or_else(|| locate(old.position), |(_, before)| before);
        let places = (before, locate(new.position));
        self.places = Some(places);
        self.strip = strip(car, &places.1);
        if !self.crosses {
            return;
        }
        // Who is so far inside a bend that nobody knows which part of it is meant passes nothing of it.
        if !places.0.ambiguous && !places.1.ambiguous {
            self.follow_lane(step, (old_car, car), places);
        }
        self.follow_strip(step, car, new, places);
    }

    /// Entering and leaving the lane and passing its centre line, by the pedestrian's centre.
    fn follow_lane(
        &mut self,
        step: &Step,
        (old_car, car): (&VehicleState, &VehicleState),
        (old, new): (Located, Located),
    ) {
        let across = |place: Located| self.side.walking_sign() * place.beside;
        let (before, after) = (across(old), across(new));
        let (start, half) = (-self.half_lane, self.half_lane);
        let appears_inside = self.last_entry.is_none() && before > start && before < half;
        let entry = if appears_inside { Some(0.0) } else { rising(before, after, start) };
        if let Some(part) = entry {
            let time = step.time + part * step.duration;
            self.last_entry = Some(time);
            self.first_entry.get_or_insert_with(|| {
                let travelled = lerp(old_car.motion.travelled, car.motion.travelled, part);
                Entry {
                    time,
                    distance: lerp(old.along, new.along, part) - travelled,
                    speed: lerp(old_car.motion.speed, car.motion.speed, part),
                }
            });
        }
        let up = rising(before, after, 0.0);
        let down = (before >= 0.0 && after < 0.0).then(|| before / (before - after));
        if let Some(part) = up.or(down) {
            self.passings.push(Passing {
                time: step.time + part * step.duration,
                place: lerp(old.along, new.along, part),
                towards_goal: up.is_some(),
            });
        }
        if let (Some(part), Some(entered)) = (rising(before, after, half), self.last_entry) {
            self.crossing.get_or_insert(LaneCrossing { entered, left: step.time + part * step.duration });
        }
    }

    fn follow_presence(
        &mut self,
        step: &Step,
        (vehicle, has_moved): (usize, (bool, bool)),
        pedestrian: usize,
    ) {
        let Some(places) = self.places else { return };
        self.presence.observe(&PresenceStep {
            vehicle: (&step.before.vehicles[vehicle], &step.after.vehicles[vehicle]),
            pedestrian: &step.after.pedestrians[pedestrian],
            places,
            half_lane: self.half_lane,
            strip: self.strip,
            has_moved,
            may_go: step.may_go(pedestrian),
        });
    }

    /// Stays of the footprint in the strip that the vehicle sweeps.
    fn follow_strip(
        &mut self,
        step: &Step,
        car: &VehicleState,
        person: &PedestrianState,
        (old, new): (Located, Located),
    ) {
        let reach = half_extent(person, &new);
        let (low, high) = self.strip;
        let Some((enter, leave)) = part_within(old.beside, new.beside, (low - reach.y, high + reach.y))
        else {
            self.leave_strip(step.time);
            return;
        };
        if !self.in_strip {
            self.in_strip = true;
            let from = step.time + enter * step.duration;
            let (to, low, high) = (f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY);
            self.visits.push(Visit { from, to, low, high });
        }
        if let Some(visit) = self.visits.last_mut() {
            if car.path.turns_about(new.along, car.length + reach.x) {
                // A rigid body that turns: where it first and last touches what is there, less its own half length. Only what is beyond
                // what was found before is looked for.
                let (size, half) = ((car.length, car.width), car.length / 2.0);
                let known = (visit.low <= visit.high).then_some((visit.low - half, visit.high + half));
                let outline = Footprint::from(person);
                let (first, last) = touched_between(&car.path, size, &outline, new.along, known);
                visit.low = first.map_or(visit.low, |first| visit.low.min(first + half));
                visit.high = last.map_or(visit.high, |last| visit.high.max(last - half));
            } else {
                for part in [enter, leave] {
                    let centre = lerp(old.along, new.along, part);
                    visit.low = visit.low.min(centre - reach.x);
                    visit.high = visit.high.max(centre + reach.x);
                }
            }
        }
        if leave < 1.0 {
            self.leave_strip(step.time + leave * step.duration);
        }
    }

    fn leave_strip(&mut self, time: f64) {
        if self.in_strip {
            self.in_strip = false;
            if let Some(visit) = self.visits.last_mut() {
                visit.to = time;
            }
        }
    }
}

/// What a vehicle sweeps where somebody is, as distances (m) beside its path, positive towards the far side of the road: half its width
/// to either side where it goes straight. In a bend its corners swing out, by the tightest bend that is under it.
#[inline]
pub fn strip(car: &VehicleState, place: &Located) -> (f64, f64) {
    let half = car.width / 2.0;
    if let Some(steered) = &car.steered {
        // The strip of the lane that its outline is over now.
        let (error, ahead) = (steered.heading_error, car.length / 2.0);
        let reach = half * libm::cos(error).abs() + ahead * libm::sin(error).abs();
        let left = car.path.locate(steered.centre).left();
        let (right, left) = (reach - left, reach + left);
        return place.borders(right, left);
    }
    if car.path.course().is_none() {
        return (-half, half);
    }
    let (right, left) = car.path.swept(place.along, (car.length, car.width));
    place.borders(right, left)
}
