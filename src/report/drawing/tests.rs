//! Sketches of worlds whose numbers are worked out by hand.

use std::sync::Arc;

use nalgebra::Vector2;

use super::outlook::{Outlook, SightKind};
use super::plane::Frame;
use super::{AfterTheEnd, Sketch};
use models::standard;
use scenario::geometry::{Piece, Pose, ReferenceLine};
use scenario::{
    Appearance, Bend, Case, ModelSetup, Position, Settings, TrafficStream, Value, VehicleReference,
    VehicleSetup, VehicleStart, World,
};
use sim::{Mode, Sample, Solid, Trace};

/// A car of 4 m by 2 m that comes at 10 m/s from 40 m away, and somebody who walks at 1 m/s from y = -4 m to 4 m.
fn world() -> World {
    let mut world = sim::fixture::world();
    world.vehicles[0].start = VehicleStart::Distance(40.0);
    let scripted = standard().pedestrians().get("scripted").unwrap().clone();
    let settings = Settings::from([("speed", Value::Number(1.0))]);
    world.pedestrians[0].model = ModelSetup::resolved(&scripted, &settings).unwrap();
    world
}

/// The same in a turn of Euro NCAP, the crossing in its middle.
fn turning() -> World {
    let [one, arc, other] = Piece::turn(1500.0, 9.0, 0.36, 0.85);
    let crossing = 30.0 + one.length + arc.length / 2.0;
    let pieces = [Piece::line(30.0), one, arc, other, Piece::line(40.0)];
    let line = ReferenceLine::new(Pose::origin(), &pieces).unwrap();
    let mut world = world();
    let pose = line.pose(crossing);
    let person = &mut world.pedestrians[0];
    for place in [&mut person.start, &mut person.goal] {
        let at = pose.point + pose.normal() * place.y;
        *place = Position { x: at.x, y: at.y };
    }
    (world.vehicles[0].start, world.vehicles[0].speed) = (VehicleStart::Distance(25.0), 5.0);
    world.road.bend = Some(Bend { line: Arc::new(line), crossing });
    world
}

fn case(world: World) -> Case {
    Case {
        key: "streets/<walk>/rep=1".into(),
        scenario: "<walk>".into(),
        variation: Vec::new(),
        individuals: Vec::new(),
        drawn: Vec::new(),
        impossible: None,
        repetition: 1,
        seed: 1,
        world: Arc::new(world),
    }
}

#[test]
fn courses_meet_where_and_when_they_do() {
    let outlook = Outlook::of(&world(), 1);
    let [met] = &outlook.meetings[..] else { panic!("{} meetings", outlook.meetings.len()) };
    assert_eq!((met.vehicle, met.with), (0, Solid::Pedestrian(0)));
    assert!(met.point.norm() < 1e-12 && (met.times.0 - 4.0).abs() < 1e-9 && (met.times.1 - 4.0).abs() < 1e-9);
    // The car over the band of 0.5 m, and the person over the car's 2 m.
    let ((car_in, car_out), (person_in, person_out)) = met.between;
    assert!((car_in - 3.775).abs() < 1e-9 && (car_out - 4.225).abs() < 1e-9);
    assert!((person_in - 2.75).abs() < 1e-9 && (person_out - 5.25).abs() < 1e-9, "{person_in} {person_out}");
    assert!(met.touches());
    // Who appears for the car waits until it is so far away.
    let mut later = world();
    later.pedestrians[0].appears =
        Appearance::TimeToArrival { vehicle: 0, reference: VehicleReference::Front, time: 2.0 };
    let outlook = Outlook::of(&later, 1);
    assert!((outlook.people[0].appears.unwrap() - 1.8).abs() < 1e-9);
    assert!((outlook.meetings[0].times.1 - 5.8).abs() < 1e-9);
    // One who stands meets nobody, and nobody appears for it.
    later.vehicles[0].speed = 0.0;
    let outlook = Outlook::of(&later, 1);
    assert_eq!((outlook.people[0].appears, outlook.meetings.len()), (None, 0));
}

#[test]
fn in_a_turn_courses_meet_along_it() {
    let world = turning();
    let outlook = Outlook::of(&world, 1);
    let met = &outlook.meetings[0];
    let middle = world.road.bend.as_ref().unwrap();
    assert!((met.point - middle.line.pose(middle.crossing).point).norm() < 1e-9);
    assert!((met.times.0 - 5.0).abs() < 1e-9 && (met.times.1 - 4.0).abs() < 1e-9);
}

#[test]
fn whoever_has_a_box_before_them_is_hidden_until_they_have_passed_it() {
    let mut world = world();
    let van = |name: &str, x: f64, y: f64| {
        serde_json::from_value(
            serde_json::json!({ "name": name, "x": x, "y": y, "length": 4.0, "width": 1.8 }),
        )
        .unwrap()
    };
    world.road.boxes = vec![van("van", -4.0, -3.0), van("far", 14.0, -3.0)];
    let outlook = Outlook::of(&world, 1);
    let [sight] = &outlook.sights[..] else { panic!() };
    // From the front, 38 m before; the line to (0, -4) goes through the van at x in [-6, -2], y in [-3.9, -2.1].
    assert_eq!(
        (sight.from, sight.hidden_by.as_slice()),
        (Vector2::new(-38.0, 0.0), [Solid::Box(0)].as_slice())
    );
    assert_eq!(sight.kind, SightKind::Through, "without `sees` it looks through boxes");
    // Clear once the line passes the corner (-2, -2.1): y = -4 + t and the sensor at -38 + 10 t.
    let clear = sight.clear_from.unwrap();
    let hidden = |time: f64| {
        let (x, y) = (-38.0 + 10.0 * time, -4.0 + time);
        let at = |corner: f64| y * (corner - x) / -x;
        at(-2.0).min(at(-6.0)) < -2.1
    };
    assert!(hidden(clear - 0.05) && !hidden(clear), "{clear} s");
    world.road.boxes.remove(0);
    assert!(Outlook::of(&world, 1).sights[0].hidden_by.is_empty());
}

#[test]
fn a_straight_road_as_text() {
    insta::assert_snapshot!(Sketch::of(&case(world())).to_text(90, 40));
}

#[test]
fn a_bend_as_text() {
    insta::assert_snapshot!(Sketch::of(&case(turning())).to_text(90, 50));
}

#[test]
fn a_straight_road_as_svg() {
    insta::assert_snapshot!(Sketch::of(&case(world())).to_svg());
}

#[test]
fn a_bend_as_svg() {
    insta::assert_snapshot!(Sketch::of(&case(turning())).to_svg());
}

#[test]
fn names_stay_names() {
    let mut world = world();
    world.pedestrians[0].name = "<script>\u{1b}[31m\u{202e}".into();
    let sketch = Sketch::of(&case(world));
    let (svg, text) = (sketch.to_svg(), sketch.to_text(80, 40));
    assert!(!svg.contains("<script") && !svg.contains('\u{1b}') && !svg.contains('\u{202e}'));
    assert!(!text.contains('\u{1b}') && !text.contains('\u{202e}'));
    assert!(svg.contains("&lt;script&gt;") && text.contains("<script>"));
}

/// The car at 10 m/s and the person at 1 m/s, who appears after 1 s.
fn trace() -> Trace {
    let mut trace = Trace::default();
    for step in 0..=120 {
        let time = f64::from(step) * 0.025;
        let mut sample = |who, position, velocity: Vector2<f64>| {
            trace.samples.push(Sample {
                time,
                who,
                position,
                heading: velocity.normalize(),
                travelled: None,
                velocity,
                acceleration: 0.0,
                mode: Mode::NONE,
            });
        };
        sample(0, Vector2::new(-40.0 + 10.0 * time, 0.0), Vector2::new(10.0, 0.0));
        if time >= 1.0 {
            sample(1, Vector2::new(0.0, -5.0 + time), Vector2::new(0.0, 1.0));
        }
    }
    trace
}

#[test]
fn a_moment_shows_everybody_where_they_are_then() {
    let case = case(world());
    let bodies = |time: f64| {
        let sketch = Sketch::of_moments(&case, &trace(), &[time]).unwrap();
        let users = sketch.pictures[0].bodies.iter();
        users.map(|body| body.as_ref().map(|body| body.outline.centre)).collect::<Vec<_>>()
    };
    // Between two samples as far between, and nobody before they appear.
    let near =
        |found: Option<Vector2<f64>>, x: f64, y: f64| (found.unwrap() - Vector2::new(x, y)).norm() < 1e-9;
    let found = bodies(2.01);
    assert!(near(found[0], -19.9, 0.0) && near(found[1], 0.0, -2.99), "{found:?}");
    let found = bodies(0.99);
    assert!(near(found[0], -30.1, 0.0) && found[1].is_none(), "{found:?}");
    assert!(bodies(1.0)[1].is_some() && bodies(3.0)[1].is_some());
    // After the end nobody is anywhere.
    let error = Sketch::of_moments(&case, &trace(), &[1.0, 3.1]).map(|_| ()).unwrap_err();
    assert_eq!(error, AfterTheEnd { time: 3.1, end: 3.0 });
    assert_eq!(Sketch::strip(&case, &trace()).first().copied(), Some(1.0));
    assert_eq!(Sketch::strip(&case, &trace()).last().copied(), Some(3.0));
}

#[test]
fn whoever_is_outside_the_picture_is_announced_and_not_drawn() {
    let mut far = world();
    far.vehicles[0].start = VehicleStart::Distance(90.0);
    let sketch = Sketch::of(&case(far));
    let text = sketch.to_text(80, 40);
    assert!(!text.lines().take(12).any(|line| line.contains('A')), "{text}");
    let beyond = -90.0 - sketch.frame.low.x;
    assert!(text.contains(&format!("A av (◀ {:.0} m beyond the edge)", -beyond)), "{text}");
    assert!(text.contains("av: starts 90.0 m before the crossing"), "{text}");
}

#[test]
fn a_stream_is_told_once_where_its_vehicles_are_alike() {
    let mut world = world();
    world.pedestrians.clear();
    world.vehicles = (0..4)
        .map(|index| VehicleSetup { name: format!("cars_{}", index + 1), ..world.vehicles[0].clone() })
        .collect();
    world.streams = vec![TrafficStream {
        name: "cars".into(),
        vehicles: vec![0, 1, 2, 3],
        arrivals: vec![0.0, 2.0, 9.0, 11.0],
    }];
    let case = case(world);
    let trace = |last: f64| {
        let sample = |(who, (x, speed)): (usize, (f64, f64))| Sample {
            time: 0.0,
            who,
            position: Vector2::new(x, 0.0),
            heading: Vector2::new(1.0, 0.0),
            travelled: None,
            velocity: Vector2::new(speed, 0.0),
            acceleration: 0.0,
            mode: Mode::NONE,
        };
        let samples = [(0.0, 10.0), (-20.0, 10.0), (-90.0, 10.0), (-110.0, last)];
        let mut trace = Trace::default();
        trace.samples.extend(samples.into_iter().enumerate().map(sample));
        trace
    };
    let sketch = |last: f64| Sketch::of_moments(&case, &trace(last), &[0.0]).unwrap();
    assert_eq!(sketch(10.0).pictures[0].caption, "after 0.00 s: cars 10.0 m/s");
    let each = "after 0.00 s: cars_1 10.0 m/s, cars_2 10.0 m/s, cars_3 10.0 m/s, cars_4 2.0 m/s";
    assert_eq!(sketch(2.0).pictures[0].caption, each);
    // Beyond an edge the nearest is named.
    let sketch = sketch(10.0);
    let labels = sketch.pictures[0]
        .labels(&sketch.world, &Frame { low: Vector2::new(-30.0, -5.0), high: Vector2::new(30.0, 5.0) });
    let named: Vec<_> = labels.iter().map(|label| (label.name.as_str(), label.outside)).collect();
    assert_eq!(named, [("cars_1", false), ("cars_2", false), ("cars_3", true)]);
}
