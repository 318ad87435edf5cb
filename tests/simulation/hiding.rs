//! Vehicles, buses and people hide others: from controllers that look, and vehicles from people.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use files::Memory;
use models::standard;
use proptest::prelude::*;
use runner::plan::plan;
use runner::run::road_users;
use scenario::registry::Registry;
use scenario::{Chance, CommandKind, ControllerModel, Declaration, World};
use sim::sight::sees_vehicle;
use sim::{
    Command, Controller, ControllerError, Happening, Observation, Observer, Scene, Schedule, Snapshot, Step,
    Timeline, Trace, TraceMark, simulate,
};

/// Who was seen at a moment: whether somebody on foot, and their number.
type Seen = BTreeMap<(bool, usize), [u64; 4]>;

/// A controller that keeps its speed and remembers what it saw at each decision.
struct Looks(Arc<Mutex<Vec<Seen>>>);

impl Controller for Looks {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.1)
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        let bits = |one: nalgebra::Vector2<f64>, other: nalgebra::Vector2<f64>| {
            [one.x, one.y, other.x, other.y].map(f64::to_bits)
        };
        let people = seen.pedestrians.iter().map(|one| ((true, one.id), bits(one.position, one.velocity)));
        let cars = seen.vehicles.iter().map(|one| ((false, one.id), bits(one.position, one.velocity)));
        if seen.time >= 0.0 {
            self.0.lock().unwrap().push(people.chain(cars).collect());
        }
        Ok(Command::Acceleration(0.0))
    }
}

/// Where everybody was after each step.
#[derive(Default)]
struct Course(Vec<Snapshot>);

impl Observer for Course {
    fn observe(&mut self, step: &Step) {
        self.0.push(step.after.clone());
    }
}

fn registry() -> (Registry, Arc<Mutex<Vec<Seen>>>) {
    let all = Arc::new(Mutex::new(Vec::new()));
    let seen = all.clone();
    let looks = ControllerModel::new(
        Declaration::new("looks", "Keeps its speed.").source("test"),
        CommandKind::Acceleration,
        move |_| Ok(Box::new(Looks(seen.clone()))),
    );
    (standard().with_controller(looks.chance(Chance::Never)).unwrap(), all)
}

/// The world of a scenario on this road with these road users, what the vehicle with the controller `looks` saw at each of its decisions, and the
/// course.
fn run_on(road: &str, users: &str) -> (World, Vec<Seen>, Vec<Snapshot>) {
    let (registry, all) = registry();
    let text = format!(
        "scenario street {{\n road {{ {road} lane_width 3.5 m; speed_limit 50 km/h; }}\n horizon 12 s\n{users}\n}}"
    );
    let files = Memory::default().with("a.scn", text.clone());
    let loaded = lang::load("a.scn".as_ref(), &registry, &files);
    let suite = loaded.unwrap_or_else(|failure| panic!("{text}\n{:?}", failure.diagnostics)).suite;
    let plan = plan(&suite).unwrap_or_else(|errors| panic!("{text}\n{}", errors[0]));
    let world = plan.trial(0).cases.first().world.clone();
    let mut course = Course::default();
    simulate(&world, road_users(&world, 1).unwrap(), &mut course).unwrap();
    let seen = all.lock().unwrap().clone();
    ((*world).clone(), seen, course.0)
}

const STREET: &str = "lanes 2; crossing unmarked;";

fn run(users: &str) -> (World, Vec<Seen>, Vec<Snapshot>) {
    run_on(STREET, users)
}

/// At which decisions somebody on foot was seen.
fn sees(seen: &[Seen], person: usize) -> Vec<bool> {
    seen.iter().map(|seen| seen.contains_key(&(true, person))).collect()
}

/// A bus that stands on lane 0, its front at 3 m before the crossing.
const BUS: &str = "vehicle bus { controller timeline { steps: \"when distance_to_crossing < d1 stop\", d1: 20 m, deceleration: 10 m/s^2 }
  size 12 m x 2.55 m; speed 36 km/h; start 28.5 m before crossing }";
const FAST: &str = "speed 36 km/h; lane 1; start 90 m before crossing";
const WALKER: &str =
    "pedestrian walker { model scripted { speed: 1 m/s, delay: 3.5 s }; start 0.5 m from kerb }";

#[test]
fn a_bus_hides_whoever_walks_before_it_until_they_come_out() {
    let av = |sees: &str| format!("vehicle av {{ controller looks; {FAST}; {sees} }}");
    let (_, seen, course) = run(&format!("{BUS}\n{}\n{WALKER}", av("sees { range: 500 m }")));
    let walker = sees(&seen, 0);
    // Once it stands. The eye is at the front bumper's middle, 10 m/s nearer to the crossing each second.
    for (k, sees) in walker.iter().enumerate().skip(25) {
        let now = &course[(k * 4).saturating_sub(1)];
        let (bus, eye, place) =
            (now.vehicles[0].position(), now.vehicles[1].position(), now.pedestrians[0].position);
        let (eye, corner) = (eye.x + 2.25, (bus.x + 6.0, bus.y + 1.275));
        let line = 3.5 + (place.y - 3.5) * (corner.0 - eye) / (0.0 - eye);
        if eye < corner.0 && (line - corner.1).abs() > 1e-6 {
            assert_eq!(*sees, line > corner.1, "{k} {eye} {line}");
        }
    }
    let first = walker.iter().rposition(|sees| !sees).unwrap() + 1;
    assert!((30..walker.len()).contains(&first), "{first}");
    assert!(walker[25..first].iter().all(|sees| !sees));
    assert!(seen[..first].iter().all(|seen| seen.contains_key(&(false, 0))), "the bus itself is seen");
    // Who sees everything does, and so does who looks through others.
    for through in ["", "sees { occlusion: false }"] {
        let (_, seen, _) = run(&format!("{BUS}\n{}\n{WALKER}", av(through)));
        assert!(sees(&seen, 0).iter().all(|sees| *sees), "{through}");
    }
}

/// What timelines and traces say is what the controller is shown, also late.
#[test]
fn timelines_and_traces_say_who_comes_into_sight() {
    for (sees, latency) in [("sees { range: 500 m }", 0), ("sees { range: 500 m, latency: 0.3 s }", 3)] {
        let users =
            format!("{BUS}\nvehicle av {{ controller looks; {FAST}; {sees} }}\n{WALKER}\nend on collision");
        let (world, seen, _) = run(&users);
        let seen = self::sees(&seen, 0);
        let changes = (1..seen.len()).filter(|k| seen[*k] != seen[k - 1]).map(|k| (k, seen[k]));
        let changes: Vec<_> = seen[0].then_some((0, true)).into_iter().chain(changes).collect();
        assert!(!changes.is_empty() && changes.iter().all(|(k, _)| *k >= latency), "{changes:?}");
        let world = Arc::new(world);
        let mut timeline = Timeline::new(&world);
        simulate(&world, road_users(&world, 1).unwrap(), &mut timeline).unwrap();
        let told = timeline.into_events().into_iter().filter(|event| event.who == "walker");
        let told: Vec<_> = told
            .filter_map(|event| match event.what {
                Happening::ComesIntoSight { of } if of == "av" => Some((event.time, true)),
                Happening::IsLostFromSight { of } if of == "av" => Some((event.time, false)),
                _ => None,
            })
            .collect();
        let rounded: Vec<_> =
            told.iter().map(|(time, seen)| ((time * 10.0).round() as usize, *seen)).collect();
        assert_eq!(rounded, changes, "{sees}");
        let mut trace = Trace::default();
        simulate(&world, road_users(&world, 1).unwrap(), &mut trace).unwrap();
        let marked: Vec<_> = trace
            .marks
            .iter()
            .filter(|(sample, _)| trace.samples[*sample].who == 2)
            .filter_map(|(sample, mark)| match mark {
                TraceMark::Seen(1) => Some((trace.samples[*sample].time, true)),
                TraceMark::Lost(1) => Some((trace.samples[*sample].time, false)),
                _ => None,
            })
            .collect();
        assert_eq!(marked.len(), told.len());
        assert!(
            marked.iter().zip(&told).all(|(one, other)| (one.0 - other.0).abs() < 1e-9 && one.1 == other.1)
        );
    }
}

#[test]
fn a_road_of_straight_pieces_hides_as_a_straight_road() {
    let users =
        format!("{BUS}\nvehicle av {{ controller looks; {FAST}; sees {{ range: 500 m }} }}\n{WALKER}");
    let bent = "path { straight 400 m }; lanes 2; crossing unmarked { at: 200 m };";
    let (_, straight, _) = run(&users);
    let (_, seen, _) = run_on(bent, &users);
    assert_eq!(sees(&straight, 0), sees(&seen, 0));
    assert!(sees(&seen, 0).contains(&false));
}

/// In a bend to the left the bus ahead stands beside the line of sight to who stands farther on; on a straight road before it.
#[test]
fn round_a_bend_it_hides_by_where_it_is_in_the_plane() {
    let av =
        "vehicle av { controller looks; speed 9 km/h; start 60 m before crossing; sees { range: 500 m } }
  pedestrian walker { model scripted { delay: 100 s }; start 1.75 m from lane centre }";
    let bus = |place: &str| {
        format!(
            "vehicle bus {{ controller constant_speed; speed 9 km/h; size 12 m x 2.55 m; start {place} before crossing }}\n{av}"
        )
    };
    let bent = "path { straight 40 m; arc 90 deg radius 40 m left; straight 60 m }; lanes forward, backward; crossing unmarked { at: 100 m };";
    let first = |road: &str| sees(&run_on(road, &bus("45 m")).1, 0)[0];
    assert!(!first("lanes forward, backward; crossing unmarked;") && first(bent));
}

#[test]
fn a_vehicle_is_hidden_from_who_follows_and_nobody_by_the_own_body() {
    let cars = "vehicle first { controller constant_speed; speed 36 km/h; start 20 m before crossing }
  vehicle second { controller constant_speed; speed 36 km/h; start 40 m before crossing }
  vehicle third { controller looks; speed 36 km/h; start 60 m before crossing; sees { sensor_setback: 2 m } }
  vehicle beside { controller constant_speed; speed 36 km/h; start 60 m before crossing; lane 1 }
  pedestrian walker { model scripted; start 0.5 m from kerb; along 80 m; appears at 0 s }";
    let (_, seen, _) = run(cars);
    assert!(seen.iter().all(|seen| !seen.contains_key(&(false, 0))), "whom the next one covers");
    assert!(seen.iter().all(|seen| seen.contains_key(&(false, 1)) && seen.contains_key(&(false, 3))));
    let (_, alone, _) = run("vehicle third { controller looks; speed 36 km/h; start 60 m before crossing; sees { sensor_setback: 3 m } }
  pedestrian walker { model scripted; start 0.5 m from kerb }");
    assert!(sees(&alone, 0).iter().all(|sees| *sees));
}

#[test]
fn people_hide_people_and_who_is_behind_somebody_narrow_is_seen() {
    let users = |near: &str| {
        format!(
            "vehicle av {{ controller looks; speed 36 km/h; start 60 m before crossing; sees {{ range: 500 m }} }}
  pedestrian near {{ model scripted {{ delay: 100 s }}; {near}; start 1.75 m from lane centre; along -1 m }}
  pedestrian far {{ model scripted {{ delay: 100 s }}; size 0.5 m x 0.5 m; start 1.75 m from lane centre; along 0 m }}"
        )
    };
    let first = |near: &str| run(&users(near)).1[0].contains_key(&(true, 1));
    assert!(!first("size 0.5 m x 0.5 m") && first("size 0.1 m x 0.5 m"));
}

/// Whether the first pedestrian moves, after each step.
fn walks(course: &[Snapshot]) -> Vec<bool> {
    course.iter().map(|now| now.pedestrians[0].velocity.norm() > 0.0).collect()
}

/// A car that a bus hides is as if it were not there, until it comes out: for every model that minds vehicles.
#[test]
fn people_do_not_see_a_car_behind_a_bus() {
    // The bus stands beside the way of who walks from the far side, between them and the car on the lane behind it.
    let users = |model: &str, car: &str| {
        format!(
            "vehicle bus {{ controller timeline {{ steps: \"when distance_to_crossing < d1 stop\", d1: 20 m, deceleration: 10 m/s^2 }}
  size 12 m x 2.55 m; speed 36 km/h; lane 1; start 24 m before crossing }}
  {car}
  pedestrian walker {{ model {model}; from far side; start 0.6 m from kerb; appears at 3 s }}"
        )
    };
    let car = "vehicle car { controller constant_speed; speed 36 km/h; start 82 m before crossing }";
    let beside = "vehicle car { controller constant_speed; speed 36 km/h; start 2000 m before crossing }";
    for model in [
        "commotions { variant: oVA }",
        "jaywalker { gap_model: brewer, risk: normal }",
        "social_force { desired_speed: 1.4 m/s }",
    ] {
        let step = if model.starts_with("jay") { "step 20 ms" } else { "" };
        let run = |car: &str| run(&format!("{step}\n{}", users(model, car))).2;
        let (hidden, alone) = (run(car), run(beside));
        let place = |course: &[Snapshot]| {
            course.iter().map(|now| now.pedestrians[0].position.y.to_bits()).collect::<Vec<_>>()
        };
        let (hidden_places, alone_places) = (place(&hidden), place(&alone));
        let same = hidden_places.iter().zip(&alone_places).take_while(|(one, other)| one == other).count();
        // They come out from behind the bus after some steps on the road, at the earliest.
        let started = walks(&alone).iter().position(|walks| *walks).unwrap();
        assert!(same > started + 10, "{model}: {same} {started}");
    }
}

/// Who has seen a car that a bus hides then believes that it goes on as it did.
#[test]
fn people_remember_a_car_that_they_have_seen() {
    let users = |bus: &str| {
        format!(
            "{bus}
  vehicle car {{ controller constant_speed; speed 36 km/h; start 80 m before crossing }}
  pedestrian walker {{ model commotions {{ variant: oVAoBEvoAI }}; from far side; start 0.6 m from kerb; appears at 3.5 s }}"
        )
    };
    // It drives between them and the car, on the lane of those who come the other way: as long as they just look over, and a little longer.
    let bus = |length: f64| {
        format!(
            "vehicle bus {{ controller constant_speed; speed 27 km/h; size {length} m x 2.55 m; lane 1; start 34 m before crossing }}"
        )
    };
    let street = "lanes forward, backward; crossing unmarked;";
    let (world, _, with) = run_on(street, &users(&bus(5.6)));
    let (_, _, without) = run_on(street, &users(&bus(5.5)));
    let sees = |now: &&Snapshot| {
        let goal = world.pedestrians[0].goal;
        let (vehicles, pedestrians) = (now.vehicles.as_slice(), now.pedestrians.as_slice());
        sees_vehicle(
            &Scene {
                time: 0.0,
                step: 0.025,
                road: &world.road,
                crossing: 0,
                me: 0,
                goal,
                legs: (0, 0),
                vehicles,
                pedestrians,
                held: false,
            },
            1,
        )
    };
    let present = |now: &&Snapshot| now.pedestrians[0].present && now.vehicles[1].motion.travelled < -3.0;
    let met: Vec<_> = with.iter().filter(present).collect();
    let first = met.iter().position(|now| !sees(now)).expect("hidden");
    let hidden = met.iter().filter(|now| !sees(now)).count();
    assert!(first > 10 && hidden > 15, "seen for {first} steps, then hidden for {hidden}");
    // As the car keeps its speed they are right about it, and go on as slowly as if they saw it: else they would be 1 m farther.
    for (one, other) in with.iter().zip(&without) {
        assert!((one.pedestrians[0].position - other.pedestrians[0].position).norm() < 0.1);
    }
    // Before the car they do not step into its lane, whether the bus hides it meanwhile or not.
    for course in [with, without] {
        let in_its_lane = |now: &&Snapshot| now.pedestrians[0].position.y < 1.5;
        let before = course.iter().take_while(|now| now.vehicles[1].motion.travelled < 0.0);
        assert_eq!(before.filter(in_its_lane).count(), 0);
        assert!(course.iter().any(|now| now.pedestrians[0].position.y < 1.5));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Who stands in nobody's line of sight changes nothing of what is seen of others, nor does the order in which they are declared.
    #[test]
    fn who_covers_nobody_changes_nothing(
        far in 30.0..200.0,
        speed in 20.0..40.0,
        along in -20.0..20.0,
        noise in prop::bool::ANY,
    ) {
        let noise = if noise { ", position_noise: 0.3 m, dropout: 0.1" } else { "" };
        let av = |occlusion: bool| format!(
            "vehicle av {{ controller looks; speed {speed} km/h; start 90 m before crossing; sees {{ occlusion: {occlusion}{noise} }} }}"
        );
        let walker = format!("pedestrian walker {{ model scripted; start 0.5 m from kerb; along {along} m }}");
        let behind = format!(
            "vehicle behind {{ controller constant_speed; speed {speed} km/h; lane 1; start {} m before crossing }}", 95.0 + far
        );
        let of = |users: &str| -> Vec<_> {
            run(users).1.iter().map(|seen| seen.get(&(true, 0)).copied()).collect()
        };
        let both = of(&format!("{}\n{walker}\n{behind}", av(true)));
        prop_assert_eq!(&of(&format!("{}\n{walker}\n{behind}", av(false))), &both);
        prop_assert_eq!(&of(&format!("{behind}\n{}\n{walker}", av(true))), &both);
        // Noise is drawn for everybody.
        if noise.is_empty() {
            prop_assert_eq!(&of(&format!("{}\n{walker}", av(true))), &both);
        }
    }
}
