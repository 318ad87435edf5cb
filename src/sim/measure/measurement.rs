//! All requested metrics of one run at once: the worst over pairs, with whose it was.

use std::cell::RefCell;

use super::encounter::Encounters;
use super::followed::Followed;
use super::presence::{Closeness, Presence};
use super::stream_way::StreamWay;
use super::{Absence, BuildMeter, End, FreeFlow, InStep, Meter, MetricContext, Open, Scope, Worst};
use crate::arrival::StreamVehicles;
use crate::{Ending, Observer, Snapshot, Solid, Step, StopReason};
use scenario::{MetricReference, World};

/// Meters for every request and every pair of road users that it concerns.
pub struct Measurement {
    encounters: Encounters,
    /// Request by request.
    meters: Vec<Box<dyn Meter>>,
    requests: Vec<Request>,
    /// Of each stream and each pedestrian, by their indices.
    stream_ways: Vec<((usize, usize), StreamWay)>,
    streams: StreamVehicles,
    /// The vehicles of streams that a completed run did not wait for and that touched nothing: no metric of theirs is defined.
    not_awaited: Vec<usize>,
    /// When and in which state the run ended before everybody had arrived.
    cut_off: Option<(f64, Snapshot)>,
    /// Whether that was because somebody touched: for them everything is decided.
    contact: bool,
}

/// What one request came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The value that counts for the run and whose it is; `None` if it exists for nobody.
    pub worst: Option<SubjectValue>,
    /// Everybody that the metric was measured for.
    pub subjects: Vec<SubjectValue>,
    /// What it could still have come to, if the run ended before it was decided.
    pub open: Option<Open>,
}

/// A metric of one pair, vehicle or pedestrian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubjectValue {
    /// Its index in [`World::vehicles`]; `None` for a metric of pedestrians or of streams.
    pub vehicle: Option<usize>,
    /// Its index in [`World::streams`], for a metric of streams.
    pub stream: Option<usize>,
    /// Their index in [`World::pedestrians`]; `None` for a metric of vehicles.
    pub pedestrian: Option<usize>,
    /// What the vehicle touches, where that is no pedestrian.
    pub other: Option<Solid>,
    /// `None` when it does not exist in this run.
    pub value: Option<f64>,
    /// When it took that value, s.
    pub instant: Option<f64>,
    /// As [`Reading::open`].
    pub open: Option<Open>,
}

/// Whom a metric is measured for: a vehicle or a stream, by their indices, and with whom or what; or a pedestrian alone.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Subject {
    vehicle: Option<usize>,
    stream: Option<usize>,
    with: Option<Solid>,
}

struct Request {
    worst: Worst,
    absence: Absence,
    /// Whom each of its meters is of.
    subjects: Vec<Subject>,
}

impl Measurement {
    /// `requests` must have been checked against a registry. `free_flows` has one entry per vehicle, `free_speeds`
    /// (m/s) one per pedestrian; without them the metrics that compare to them do not exist.
    pub fn new(
        world: &World,
        requests: &[MetricReference],
        free_flows: &[FreeFlow],
        free_speeds: &[f64],
    ) -> Self {
        let followed = RefCell::new(Followed::default());
        let mut meters: Vec<Box<dyn Meter>> = Vec::new();
        let request = |reference: &MetricReference| {
            let metric = reference.known().expect("requests were checked against a registry");
            let build: &BuildMeter = metric.meters.get().expect("`meters` makes all that there are");
            let settings = metric.declaration.resolve(&reference.settings).expect("settings were checked");
            let concerned = subjects(metric.scope, world).filter(|one| concerns(reference, world, *one));
            let concerned: Vec<Subject> = concerned.collect();
            if let Some(pair) = named_vehicles(reference, world) {
                followed.borrow_mut().vehicle_pair(pair);
            }
            meters.extend(concerned.iter().map(|Subject { vehicle, stream, with }| {
                let pedestrian = pedestrian(*with);
                build(&MetricContext {
                    settings: &settings,
                    world,
                    vehicle: vehicle.unwrap_or(0),
                    stream: stream.unwrap_or(0),
                    pedestrian: pedestrian.unwrap_or(0),
                    with: *with,
                    free_flow: vehicle.and_then(|index| free_flows.get(index).copied()),
                    free_speed: pedestrian.and_then(|index| free_speeds.get(index).copied()),
                    followed: &followed,
                })
            }));
            Request { worst: metric.worst, absence: metric.absence, subjects: concerned }
        };
        let requests = requests.iter().map(request).collect();
        let encounters = Encounters::new(world, followed.into_inner());
        let people = world.pedestrians.len();
        let pairs = (0..world.streams.len()).flat_map(|stream| (0..people).map(move |one| (stream, one)));
        let stream_ways = pairs.map(|pair| (pair, StreamWay::new(world, pair.0, pair.1))).collect();
        Self {
            encounters,
            meters,
            requests,
            stream_ways,
            streams: StreamVehicles::new(world),
            not_awaited: Vec::new(),
            cut_off: None,
            contact: false,
        }
    }

    /// The worst value of every request, in order.
    pub fn values(&self) -> Vec<Option<f64>> {
        self.readings().into_iter().map(|reading| reading.worst.and_then(|worst| worst.value)).collect()
    }

    /// Every request in order, with whose values they are.
    pub fn readings(&self) -> Vec<Reading> {
        let end = self.cut_off.as_ref().map(|(time, state)| End { time: *time, state });
        let is_open = |subject: Subject| !self.contact || !self.has_touched(subject);
        self.with_meters()
            .map(|(request, meters)| {
                let is_seen = |subject: Subject| self.is_seen(subject);
                request.reading(meters, &self.encounters, end.as_ref(), (&is_open, &is_seen))
            })
            .collect()
    }

    /// Of every request in order the worst in the last step, over everybody that it is measured for.
    pub fn in_step(&self) -> Vec<InStep> {
        self.with_meters().map(|(request, meters)| request.in_step(meters, &self.encounters)).collect()
    }

    /// Every request in order, with its meters.
    fn with_meters(&self) -> impl Iterator<Item = (&Request, &[Box<dyn Meter>])> {
        let mut first = 0;
        self.requests.iter().map(move |request| {
            let all = first..first + request.subjects.len();
            first = all.end;
            (request, &self.meters[all])
        })
    }

    /// Whether a pair has touched, or a vehicle or pedestrian anything.
    fn has_touched(&self, subject: Subject) -> bool {
        match (subject.vehicle, subject.with) {
            (Some(vehicle), Some(with)) => self.touched(vehicle, with),
            (Some(vehicle), None) => self.encounters.has_touched(vehicle),
            (None, Some(Solid::Pedestrian(person))) => self.encounters.was_hit(person),
            (None, _) => false,
        }
    }

    /// Whether a metric of somebody is defined, as far as it does not say so itself: not where a vehicle is concerned that was not waited for.
    fn is_seen(&self, Subject { vehicle, with, .. }: Subject) -> bool {
        let awaited = |vehicle: usize| !self.not_awaited.contains(&vehicle);
        let with = with.is_none_or(|with| !matches!(with, Solid::Vehicle(other) if !awaited(other)));
        with && vehicle.is_none_or(awaited)
    }

    /// Whether a vehicle and something else have touched.
    pub fn touched(&self, vehicle: usize, with: Solid) -> bool {
        self.encounters.contact(vehicle, with).is_some()
    }

    /// The streams and pedestrians of which the last vehicle had passed before the pedestrian went, by their indices.
    pub fn outlasted(&self) -> impl Iterator<Item = (usize, usize)> {
        let ended = self.stream_ways.iter().filter(|(_, way)| way.is_outlasted(&self.encounters));
        ended.map(|(pair, _)| *pair)
    }

    /// The indices of the vehicles whose bodies left their carriageways.
    pub fn left_road(&self) -> impl Iterator<Item = usize> {
        self.encounters.left_road()
    }

    /// What every vehicle and pedestrian had to do with each other, and the vehicles that a request names together.
    pub fn presences(&self) -> Vec<(usize, Solid, Presence)> {
        let (vehicles, people) = self.encounters.counts();
        let pairs = (0..vehicles).flat_map(|vehicle| (0..people).map(move |person| (vehicle, person)));
        let people = pairs.map(|(vehicle, person)| {
            (vehicle, Solid::Pedestrian(person), self.encounters.presence(vehicle, person))
        });
        let named = self.encounters.vehicle_presences();
        let named = named.map(|((one, other), presence)| (one, Solid::Vehicle(other), presence));
        // What was not waited for puts nothing to the test.
        let seen = |(vehicle, with, presence): (usize, Solid, Presence)| match self.is_seen(Subject {
            vehicle: Some(vehicle),
            stream: None,
            with: Some(with),
        }) {
            true => (vehicle, with, presence),
            false => {
                let closest = presence.closest.min(Closeness::Apart);
                (vehicle, with, Presence { closest, moved: false, passed: false })
            }
        };
        people.chain(named).map(seen).collect()
    }
}

impl Request {
    /// `is_open` says of whom something may be left to come at the `end`, `is_seen` for whom the metric may be defined.
    fn reading(
        &self,
        meters: &[Box<dyn Meter>],
        encounters: &Encounters,
        end: Option<&End>,
        (is_open, is_seen): (impl Fn(Subject) -> bool, impl Fn(Subject) -> bool),
    ) -> Reading {
        let subjects: Vec<_> = self
            .subjects
            .iter()
            .zip(meters)
            .map(|(subject, meter)| SubjectValue {
                vehicle: subject.vehicle,
                stream: subject.stream,
                pedestrian: pedestrian(subject.with),
                other: subject.with.filter(|with| !matches!(with, Solid::Pedestrian(_))),
                value: meter.value(encounters).filter(|_| is_seen(*subject)),
                instant: meter.instant(encounters).filter(|_| is_seen(*subject)),
                open: end.filter(|_| is_open(*subject)).and_then(|end| meter.open(encounters, end)),
            })
            .collect();
        let badness = |subject: &SubjectValue| {
            let value = subject.value?;
            Some(if self.worst == Worst::Smallest { -value } else { value })
        };
        let mut worst: Option<(f64, SubjectValue)> = None;
        for subject in &subjects {
            if let Some(bad) = badness(subject).filter(|bad| worst.is_none_or(|(most, _)| *bad > most)) {
                worst = Some((bad, *subject));
            }
        }
        let worst = worst.map(|(_, subject)| subject);
        // Where somebody never got to the end, those who did are not the worst of all.
        let missing = |subject: &SubjectValue| subject.value.is_none() && subject.open.is_none();
        let both = subjects.iter().zip(&self.subjects);
        let mut lost =
            both.filter(|(subject, of)| missing(subject) && is_seen(**of)).map(|(subject, _)| *subject);
        let lost = lost.next().filter(|_| self.absence == Absence::Bad);
        let open = if lost.is_some() { None } else { self.open(&subjects) };
        let late = || subjects.iter().find(|subject| subject.open.is_some()).copied();
        let worst = lost.or(worst).or_else(|| late().filter(|_| open.is_some()));
        Reading { worst, subjects, open }
    }

    fn in_step(&self, meters: &[Box<dyn Meter>], encounters: &Encounters) -> InStep {
        let each = meters.iter().map(|meter| meter.in_step(encounters));
        let worse = |one: InStep, other: InStep| match (one, other) {
            (InStep::AtTheEnd, _) | (_, InStep::AtTheEnd) => InStep::AtTheEnd,
            (InStep::Nothing, other) => other,
            (one, InStep::Nothing) => one,
            (InStep::Worst(one), InStep::Worst(other)) => InStep::Worst(self.worse(one, other)),
        };
        each.reduce(worse).unwrap_or(InStep::Nothing)
    }

    fn worse(&self, one: f64, other: f64) -> f64 {
        match self.worst {
            Worst::Smallest => one.min(other),
            Worst::Largest | Worst::Neither => one.max(other),
        }
    }

    /// The range of the worst of all, if it is not decided.
    fn open(&self, subjects: &[SubjectValue]) -> Option<Open> {
        let ranges = subjects.iter().filter_map(|subject| {
            subject.open.or(subject.value.map(|value| Open { low: value, high: value }))
        });
        let worse = |one: Open, other: Open| Open {
            low: self.worse(one.low, other.low),
            high: self.worse(one.high, other.high),
        };
        let all = ranges.reduce(worse);
        // Of nobody's value nothing is decided, even where only one is left that it may come to.
        let no_value = subjects.iter().all(|one| one.value.is_none());
        all.filter(|all| subjects.iter().any(|one| one.open.is_some()) && (all.low < all.high || no_value))
    }
}

impl Observer for Measurement {
    fn observe(&mut self, step: &Step) {
        self.encounters.observe(step);
        for meter in &mut self.meters {
            meter.observe(step, &self.encounters);
        }
    }

    fn end(&mut self, ending: &Ending, last: &Snapshot) {
        self.encounters.end();
        self.contact = ending.reason == StopReason::Collision;
        let unseen = self.streams.not_awaited(ending, last);
        self.not_awaited = unseen.filter(|vehicle| !self.encounters.has_touched(*vehicle)).collect();
        self.cut_off = (ending.reason != StopReason::Completed).then(|| (ending.time, last.clone()));
    }
}

fn pedestrian(with: Option<Solid>) -> Option<usize> {
    match with {
        Some(Solid::Pedestrian(index)) => Some(index),
        _ => None,
    }
}

/// Whom a metric is measured for in a world.
fn subjects(scope: Scope, world: &World) -> impl Iterator<Item = Subject> {
    let vehicle = |index| Subject { vehicle: Some(index), stream: None, with: None };
    let stream = |index| Subject { vehicle: None, stream: Some(index), with: None };
    let whose: Vec<Subject> = match scope {
        Scope::Pedestrian => vec![Subject { vehicle: None, stream: None, with: None }],
        Scope::Stream => (0..world.streams.len()).map(stream).collect(),
        Scope::Pair | Scope::Vehicle | Scope::Vehicles | Scope::Contact => {
            (0..world.vehicles.len()).map(vehicle).collect()
        }
    };
    let with = move |vehicle: Option<usize>| -> Vec<Option<Solid>> {
        let people = (0..world.pedestrians.len()).map(Solid::Pedestrian);
        let cars = (0..world.vehicles.len()).filter(|other| Some(*other) != vehicle).map(Solid::Vehicle);
        match scope {
            Scope::Vehicle => vec![None],
            Scope::Pair | Scope::Stream | Scope::Pedestrian => people.map(Some).collect(),
            Scope::Vehicles => cars.map(Some).collect(),
            Scope::Contact => {
                let boxes = (0..world.road.boxes.len()).map(Solid::Box);
                let all: Vec<_> = people.chain(cars).chain(boxes).map(Some).collect();
                // Who is alone touches nothing, which is a value too.
                if all.is_empty() { vec![None] } else { all }
            }
        }
    };
    whose
        .into_iter()
        .flat_map(move |one| with(one.vehicle).into_iter().map(move |with| Subject { with, ..one }))
}

/// The two vehicles that a reference names together.
fn named_vehicles(reference: &MetricReference, world: &World) -> Option<(usize, usize)> {
    let (one, other) = reference.pair.as_ref()?;
    let index = |name: &str| world.vehicles.iter().position(|vehicle| vehicle.name == *name);
    Some((index(one)?, index(other)?))
}

fn concerns(reference: &MetricReference, world: &World, subject: Subject) -> bool {
    reference.pair.as_ref().is_none_or(|(first, _)| {
        let of_stream = |index: usize| {
            world.streams.iter().any(|stream| stream.name == *first && stream.vehicles.contains(&index))
        };
        subject.vehicle.is_none_or(|index| world.vehicles[index].name == *first || of_stream(index))
            && subject.stream.is_none_or(|index| world.streams[index].name == *first)
            && subject.with.is_none_or(|with| reference.is_of(with.name(world)))
    })
}
