//! Sketches of cases: before a run, and at moments of one.

use nalgebra::Vector2;

use super::facts::facts;
use super::moment::{Moment, end_of};
use super::outlook::Outlook;
use super::picture::{Body, Picture, Sketch, names};
use super::plane::Frame;
use super::road::is_on;
use super::view::view;
use super::{svg_sketch, text_sketch};
use scenario::{Case, Road, TrafficStream, World};
use sim::Trace;
use sim::geometry::Footprint;

/// A sketch is to show a moment at which its run is over.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the run ends after {end:.3} s, so that there is nothing to draw at {time:.3} s")]
pub struct AfterTheEnd {
    /// s
    pub time: f64,
    /// s
    pub end: f64,
}

/// From one arrow on a lane to the next, m.
const ARROWS: f64 = 9.0;

/// Pictures of a strip, …
const STRIP: usize = 6;

/// … which goes on while a vehicle is so near to the crossing, m.
const STRIP_NEAR: f64 = 20.0;

impl Sketch {
    /// Of a case before its run: nothing runs for it. Vehicles and pedestrians are taken to keep their speeds.
    pub fn of(case: &Case) -> Self {
        let world = &case.world;
        let outlook = Outlook::of(world, case.seed);
        let cars = outlook
            .cars
            .iter()
            .map(|car| Some(Body { outline: Footprint::from(car), trail: Vec::new(), ghost: false }));
        let people = outlook.people.iter().map(|person| {
            let ghost = person.appears.is_none_or(|time| time > 0.0);
            Some(Body { outline: person.outline, trail: Vec::new(), ghost })
        });
        let bodies: Vec<_> = cars.chain(people).collect();
        let frame = view(
            world,
            outlook.cars.iter().map(sim::VehicleState::position),
            outlook.meetings.iter().map(|met| met.point),
        );
        let facts = facts(world, &outlook);
        let caption = "at the start; who is not there yet is pale".to_string();
        let picture = Picture { caption, bodies, outlook: Some(outlook) };
        Self::new(case, frame, vec![picture], facts)
    }

    /// Of a case at moments (s) of its run.
    ///
    /// # Errors
    /// Where one of them lies behind the end of the run.
    pub fn of_moments(case: &Case, trace: &Trace, times: &[f64]) -> Result<Self, AfterTheEnd> {
        let (world, end) = (&case.world, end_of(trace));
        if let Some(time) = times.iter().copied().find(|time| *time > end + 1e-9) {
            return Err(AfterTheEnd { time, end });
        }
        let moments: Vec<Moment> = times.iter().map(|time| Moment::of(world, trace, *time)).collect();
        let places = |which: std::ops::Range<usize>| {
            let users = moments.iter().flat_map(move |moment| moment.users[which.clone()].iter().flatten());
            users.map(|seen| seen.outline.centre).collect::<Vec<_>>()
        };
        let (cars, all) = (world.vehicles.len(), world.vehicles.len() + world.pedestrians.len());
        let frame = view(world, places(0..cars), places(cars..all));
        let pictures = moments.into_iter().map(|moment| {
            let caption = format!("after {:.2} s: {}", moment.time, speeds(world, &moment).join(", "));
            let body =
                |seen: super::moment::Seen| Body { outline: seen.outline, trail: seen.trail, ghost: false };
            let bodies = moment.users.into_iter().map(|seen| seen.map(body)).collect();
            Picture { caption, bodies, outlook: None }
        });
        let facts = vec![format!("the run ends after {end:.2} s")];
        Ok(Self::new(case, frame, pictures.collect(), facts))
    }

    /// Moments (s) of a run, evenly from the first at which a pedestrian is there to the last at which a vehicle is near the crossing, or
    /// the end where none is.
    pub fn strip(case: &Case, trace: &Trace) -> Vec<f64> {
        let cars = case.world.vehicles.len();
        let origin = |road: &Road| {
            road.bend.as_ref().map_or(Vector2::zeros(), |bend| bend.line.pose(bend.crossing).point)
        };
        let middles: Vec<_> = case.world.roads().map(origin).collect();
        let first = trace.samples.iter().find(|sample| sample.who >= cars).map_or(0.0, |sample| sample.time);
        let mut near = trace.samples.iter().rev().filter(|sample| sample.who < cars);
        let near =
            near.find(|sample| middles.iter().any(|middle| (sample.position - middle).norm() <= STRIP_NEAR));
        let end = near.map(|sample| sample.time).filter(|time| *time > first).unwrap_or(end_of(trace));
        let part = |index: usize| first + (end - first) * index as f64 / (STRIP - 1) as f64;
        (0..STRIP).map(|index| if index + 1 == STRIP { end } else { part(index) }).collect()
    }

    fn new(case: &Case, frame: Frame, pictures: Vec<Picture>, facts: Vec<String>) -> Self {
        let world = case.world.clone();
        let reach = match &world.road.bend {
            None => (frame.low.x - 1.0, frame.high.x + 1.0),
            Some(bend) => (-bend.crossing - 100.0, bend.line.length() - bend.crossing + 100.0),
        };
        let arrows = arrows(&world, &frame, reach);
        Self { title: case.key.clone(), world, frame, reach, arrows, pictures, facts }
    }

    /// An SVG file, for light and for dark.
    pub fn to_svg(&self) -> String {
        svg_sketch::to_svg(self, &self.world)
    }

    /// Text that is no wider than so many columns, and no higher than so many rows where that is possible.
    pub fn to_text(&self, columns: usize, rows: usize) -> String {
        text_sketch::to_text(self, &self.world, columns, rows)
    }
}

/// Everybody at a moment (s) of a run, or at its end if that is before, as lines of text that are no wider than so many columns and no higher
/// than so many rows where that is possible, with who they are in the last.
pub(crate) fn moment_text(case: &Case, trace: &Trace, time: f64, columns: usize, rows: usize) -> Vec<String> {
    let sketch =
        Sketch::of_moments(case, trace, &[time.min(end_of(trace))]).expect("it is not after the end");
    text_sketch::moment(&sketch, &case.world, columns, rows)
}

/// The speed of each, and of a stream whose vehicles are all as fast that of the stream.
fn speeds(world: &World, moment: &Moment) -> Vec<String> {
    let speed = |who: usize| Some(format!("{:.1} m/s", moment.users[who].as_ref()?.speed));
    let steady = |stream: &&TrafficStream| {
        let mut each = stream.vehicles.iter().filter_map(|car| speed(*car));
        let first = each.next();
        each.all(|one| Some(one) == first)
    };
    let steady: Vec<&TrafficStream> = world.streams.iter().filter(steady).collect();
    let of = |(who, name): (usize, &str)| {
        let Some(stream) = steady.iter().find(|stream| stream.vehicles.contains(&who)) else {
            return Some(format!("{name} {}", speed(who)?));
        };
        let told = stream.vehicles.iter().find(|car| speed(**car).is_some());
        if told == Some(&who) { Some(format!("{} {}", stream.name, speed(who)?)) } else { None }
    };
    names(world).enumerate().filter_map(of).collect()
}

fn arrows(world: &World, frame: &Frame, (from, to): (f64, f64)) -> Vec<(Vector2<f64>, Vector2<f64>)> {
    let mut arrows = Vec::new();
    let roads: Vec<&Road> = world.roads().collect();
    let lanes = roads.iter().enumerate().flat_map(|(number, road)| {
        let others: Vec<&Road> =
            roads.iter().enumerate().filter(|(other, _)| *other != number).map(|(_, road)| *road).collect();
        (0..road.lanes.len()).map(move |lane| (*road, lane, others.clone()))
    });
    for (road, lane, others) in lanes {
        let path = road.path(lane);
        let on_a_crossing = |place: f64| {
            road.crossings()
                .any(|(along, crossing)| (place - path.at_line(along)).abs() <= crossing.width / 2.0 + 2.0)
        };
        let reach = from.abs().max(to.abs());
        let count = (reach / ARROWS).ceil() as i32;
        for index in -count..=count {
            let (point, heading) = path.pose(ARROWS * (f64::from(index) + 0.5));
            let place = ARROWS * (f64::from(index) + 0.5);
            let crossed = others.iter().any(|other| is_on(other, point));
            if !on_a_crossing(place) && !crossed && frame.holds(point) {
                arrows.push((point, heading));
            }
        }
    }
    arrows
}
