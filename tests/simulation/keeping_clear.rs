//! People among people: whoever keeps clear touches nobody, and whoever is told where to go goes there.

use crate::support::street::{self, Course, car, model, person, run, street};
use models::standard;
use proptest::prelude::*;
use scenario::{
    Body, ModelSetup, PedestrianModel, PedestrianSetup, Settings, Shape, Side, Value, VehicleStart, World,
};

/// m
const RADIUS: f64 = 0.25;

/// Along the road (m), whether from the near side, and how far from their kerb (m).
type Place = (f64, bool, f64);

fn told(name: &str) -> bool {
    ["scripted", "timeline", "interceptor"].contains(&name)
}

/// Those of every model as they keep clear, the `number`-th of them.
fn clear(name: &str, number: usize) -> ModelSetup<PedestrianModel> {
    let mut settings = match name {
        "commotions" => person(1 + 150 * number),
        "timeline" => Settings::from([
            ("steps", Value::Word("at t1 stop; at t2 resume".into())),
            ("t1", Value::Number(2.0)),
            ("t2", Value::Number(3.0)),
        ]),
        _ => Settings::default(),
    };
    if told(name) {
        settings.0.insert("keeps_clear".into(), Value::Number(0.0));
    }
    model(name, &settings)
}

fn somebody(
    number: usize,
    model: ModelSetup<PedestrianModel>,
    (along, near, before): Place,
) -> PedestrianSetup {
    let (from, to) = if near { (-2.0 - before, 8.0) } else { (6.0 + before, -4.0) };
    let mut walker = street::walker(&format!("walker_{number}"), model, from, to);
    walker.shape = Shape::Disc { radius: RADIUS };
    walker.side = if near { Side::Near } else { Side::Far };
    (walker.start.x, walker.goal.x) = (along, along);
    walker
}

/// They walk over a street on which a car has passed, and perhaps another is parked.
fn among(people: Vec<PedestrianSetup>, parked: Option<f64>) -> World {
    let mut world = street(10.0, vec![car("past", 0, 10.0, VehicleStart::Distance(-60.0))], people);
    world.road.boxes.extend(parked.map(|x| Body {
        name: "parked".into(),
        x,
        y: 5.0,
        length: 4.0,
        width: 1.8,
        heading: 0.0,
    }));
    world
}

/// The least distance of the outlines of two of them, m.
fn least(course: &Course, count: usize) -> f64 {
    let points = |index: usize| course.points(&format!("walker_{index}")).collect::<Vec<_>>();
    let all: Vec<_> = (0..count).map(points).collect();
    let pairs = (0..count).flat_map(|one| (0..one).map(move |other| (one, other)));
    let apart = |(one, other): (usize, usize)| {
        all[one]
            .iter()
            .zip(&all[other])
            .map(|(a, b)| libm::hypot(a[0] - b[0], a[1] - b[1]) - 2.0 * RADIUS)
            .fold(f64::INFINITY, f64::min)
    };
    pairs.map(apart).fold(f64::INFINITY, f64::min)
}

fn outside(course: &Course, who: &str, parked: f64) -> bool {
    course.points(who).all(|[x, y]| {
        let beyond = |distance: f64, half: f64| (distance.abs() - half).max(0.0);
        libm::hypot(beyond(x - parked, 2.0), beyond(y - 5.0, 0.9)) >= RADIUS
    })
}

fn group() -> impl Strategy<Value = Vec<Place>> {
    let one = (-3.0..3.0, any::<bool>(), 0.5..3.0);
    prop::collection::vec(one, 2..6).prop_filter("they start apart", |places| {
        let place =
            |(along, near, before): &Place| (*along, if *near { -2.0 - before } else { 6.0 + before });
        let apart = |one: (f64, f64), other: (f64, f64)| libm::hypot(one.0 - other.0, one.1 - other.1);
        let pairs = |index: usize| {
            places[..index].iter().map(move |other| apart(place(&places[index]), place(other)))
        };
        (0..places.len()).flat_map(pairs).all(|apart| apart > 2.0 * RADIUS + 0.01)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn nobody_who_keeps_clear_walks_through_anybody(places in group(), parked in prop::option::of(-6.0..6.0), seed: u64) {
        // The far pavement begins at 6 m, where nobody starts within the box.
        for name in standard().pedestrians().names() {
            let people = places.iter().enumerate().map(|(number, place)| somebody(number, clear(name, number), *place));
            let course = run(&among(people.collect(), parked), seed);
            prop_assert!(least(&course, places.len()) > 0.0, "{name}: {}", least(&course, places.len()));
            for number in 0..places.len() {
                prop_assert!(parked.is_none_or(|parked| outside(&course, &format!("walker_{number}"), parked)), "{name}");
            }
        }
    }

    /// Nobody blocks anybody for good: the lane on which the car has passed is left after some 6 s alone.
    #[test]
    fn everybody_arrives(places in group(), parked in prop::option::of(-6.0..6.0), seed: u64) {
        for name in ["scripted", "social_force"] {
            let mut people: Vec<_> = places.iter().enumerate().map(|(number, place)| somebody(number, clear(name, number), *place)).collect();
            people.iter_mut().filter(|_| name == "social_force").for_each(|one| _ = one.model.settings.0.insert("desired_speed".into(), Value::Number(1.4)));
            let course = run(&among(people, parked), seed);
            for (number, place) in places.iter().enumerate() {
                let last = course.points(&format!("walker_{number}")).last().unwrap();
                prop_assert!(if place.1 { last[1] > 2.0 } else { last[1] < -2.0 }, "{name} {number} {last:?}");
            }
        }
    }

    /// People that react or keep clear step around a box at their own pace: within 30 s they are on the other side.
    #[test]
    fn any_box_is_passed(
        (along, across) in (-4.0..4.0, -7.0..9.0), (length, width) in (0.3..9.0, 0.3..3.0), before in 0.5..3.0, near: bool, round: bool, seed: u64,
    ) {
        let place: Place = (0.0, near, before);
        for name in standard().pedestrians().names().filter(|name| *name != "interceptor") {
            let mut one = somebody(0, clear(name, 0), place);
            // As fast as others, and without a wait that has nothing to do with the box.
            for (of, setting, value) in [("social_force", "desired_speed", 1.4), ("carla_walker", "kerb_wait", 0.0)] {
                if of == name {
                    one.model.settings.0.insert(setting.into(), Value::Number(value));
                }
            }
            if !round && name != "yielding_cyclist" {
                one.shape = Shape::Rectangle { length: 0.35, width: 0.5 };
            }
            let body = Body { name: "van".into(), x: along, y: across, length, width, heading: 0.0 };
            let gap = |y: f64| {
                let beyond = |distance: f64, half: f64| (distance.abs() - half).max(0.0);
                libm::hypot(beyond(along, length / 2.0), beyond(y - across, width / 2.0))
            };
            // No person starts in it or wants to go into it.
            prop_assume!(gap(one.start.y) > 0.4 && gap(one.goal.y) > 0.5);
            let mut world = among(vec![one], None);
            world.road.boxes.push(body);
            world.horizon = 30.0;
            // They are past once the lanes of both cars are behind them.
            world.vehicles.push(car("past_too", 1, 10.0, VehicleStart::Distance(-60.0)));
            let course = run(&world, seed);
            let last = course.points("walker_0").last().unwrap();
            prop_assert!(if near { last[1] >= 6.0 } else { last[1] <= -2.0 }, "{name}: {last:?}");
        }
    }

    #[test]
    fn somebody_far_down_the_road_changes_nothing(place in (-1.0..1.0, any::<bool>(), 0.5..3.0), far in 30.0..90.0, seed: u64) {
        for name in standard().pedestrians().names() {
            let me = || somebody(0, clear(name, 0), place);
            let alone = run(&among(vec![me()], None), seed);
            let other = somebody(1, clear(name, 1), (place.0 + far, place.1, place.2));
            let together = run(&among(vec![me(), other], None), seed);
            let same = alone.points("walker_0").zip(together.points("walker_0")).all(|(one, other)| {
                // The social force reaches everywhere, by exp(-distance / 0.3 m).
                one == other || name == "social_force" && (one[1] - other[1]).abs() < 1e-9
            });
            prop_assert!(same, "{name}");
        }
    }
}

/// As they ever did; and so they would without the rule: what is not told to keep clear walks through others.
#[test]
fn whoever_is_told_where_to_go_goes_there() {
    for name in ["scripted", "timeline"] {
        let mut free = clear(name, 0);
        free.settings.0.remove("keeps_clear");
        let towards = |model: &ModelSetup<PedestrianModel>| {
            [true, false].map(|near| somebody(usize::from(near), model.clone(), (0.0, near, 1.0))).to_vec()
        };
        let course = run(&among(towards(&free), None), 1);
        assert!(least(&course, 2) < 0.0, "{name}: {}", least(&course, 2));
        let alone = run(&among(towards(&free)[..1].to_vec(), None), 1);
        assert!(alone.points("walker_1").zip(course.points("walker_1")).all(|(one, other)| one == other));
        // They pass, and both arrive.
        let course = run(&among(towards(&clear(name, 0)), None), 1);
        assert!(least(&course, 2) > 0.0);
        let ends: Vec<_> = ["walker_0", "walker_1"].map(|who| course.points(who).last().unwrap()[1]).to_vec();
        assert!(ends[0] < -2.0 && ends[1] > 6.0, "{name}: {ends:?}");
    }
}

/// Two who cross the same street in the same track: the published model knows no others, and walked on through them.
#[test]
fn commotions_people_follow_each_other() {
    let own = |number, model| somebody(number, model, (0.0, true, 3.0 - number as f64));
    let slow = model("scripted", &Settings::from([("speed", Value::Number(0.6))]));
    let people = vec![own(1, slow), own(0, model("commotions", &person(300)))];
    let course = run(&among(people, None), 3);
    let behind: Vec<_> = course.points("walker_0").collect();
    let gaps: Vec<f64> =
        course.points("walker_1").zip(&behind).map(|(one, other)| one[1] - other[1]).collect();
    // At 0.6 m/s people take 0.36 m + 0.64 m.
    let settled = gaps[gaps.len() / 3];
    assert!((settled - 1.0).abs() < 0.02, "{settled}");
    assert!(behind.iter().all(|place| place[0] == 0.0));
}

/// Two who follow each other come head on to one, exactly and nearly: nobody is walked backwards, and all arrive.
#[test]
fn nobody_is_pushed_back_by_those_who_come() {
    for aside in [0.0, 1e-9, 0.03, 0.2] {
        let places = [(0.0, true, 1.0), (aside, false, 0.7), (aside, false, 1.5)];
        let mut people: Vec<_> = places
            .iter()
            .enumerate()
            .map(|(number, place)| somebody(number, clear("social_force", number), *place))
            .collect();
        people.iter_mut().for_each(|one| {
            one.model.settings.0.insert("desired_speed".into(), Value::Number(1.4));
        });
        let course = run(&among(people, None), 0);
        assert!(least(&course, 3) > 0.0, "{aside}");
        for (number, place) in places.iter().enumerate() {
            let way = if place.1 { 1.0 } else { -1.0 };
            let along: Vec<_> =
                course.points(&format!("walker_{number}")).map(|point| way * point[1]).collect();
            assert!(along.last().is_some_and(|last| *last > 2.0), "{aside} {number} {:?}", along.last());
            // Who evades may lead a step back round another, which is no way back.
            let most = along.iter().fold((f64::NEG_INFINITY, 0.0_f64), |(far, back), place| {
                (far.max(*place), back.max(far.max(*place) - place))
            });
            assert!(most.1 < 0.3, "{aside} {number}: {} m back", most.1);
        }
    }
}
