//! Where people drive on the left: a road of `lanes backward, forward`, on which everything is the mirror image of what it is on the other.

use crate::support::text::measured;

/// A road for one side of driving: who is on it, with `NEAR` for the side that the car drives on and `FAR` for the other.
fn street(left: bool, crossing: &str, users: &str) -> String {
    let (lanes, own, other) = if left { ("backward, forward", 1, 0) } else { ("forward, backward", 0, 1) };
    let (near, far) =
        if left { ("from far side", "from near side") } else { ("from near side", "from far side") };
    let users = users
        .replace("OWN", &own.to_string())
        .replace("OTHER", &other.to_string())
        .replace("NEAR", near)
        .replace("FAR", far);
    format!(
        "scenario a {{
  road {{ lanes {lanes}; lane_width 3.5 m; speed_limit 50 km/h; crossing {crossing} }}
  horizon 60 s; finish 60 m; {users}
}}"
    )
}

const CONTROLLERS: [&str; 9] = [
    "autoware",
    "careful_human",
    "carla_behavior",
    "commotions",
    "constant_deceleration { deceleration: 3 m/s^2, distance: 20 m }",
    "constant_speed",
    "idm_aeb",
    "yielding",
    "timeline { steps: \"at t1 stop; after t2 resume\", t1: 2 s, t2: 3 s }",
];

const PEOPLE: [&str; 5] = [
    "scripted { speed: 1.3 m/s }",
    "commotions { variant: \"oVA\" }",
    "jaywalker",
    "social_force { desired_speed: 1.3 m/s }",
    "carla_walker",
];

#[test]
fn driving_on_the_left_is_the_mirror_image_of_driving_on_the_right() {
    let mut compared = 0;
    for controller in CONTROLLERS {
        for person in PEOPLE {
            for (crossing, side) in [("zebra", "NEAR"), ("unmarked", "FAR"), ("zebra", "FAR")] {
                let users = format!(
                    "vehicle av {{ controller {controller}; speed 31 km/h; lane OWN; start 61.3 m before crossing; sees {{ range: 80 m }} }}
  vehicle other {{ controller constant_speed; speed 23 km/h; lane OTHER; start 43.7 m before crossing }}
  pedestrian walker {{ model {person}; {side}; start 1.3 m from kerb; goal 3 m beyond kerb; appears when time_to_arrival(av) = 4.03 s }}"
                );
                // Of actions that are worth the same to one who weighs them rounding chooses now and then, and a step decides.
                let tolerance =
                    if controller == "commotions" || person.starts_with("commotions") { 0.03 } else { 1e-6 };
                let [right, left] = [false, true].map(|left| measured(&street(left, crossing, &users)));
                for ((name, right), (_, left)) in right.values.iter().zip(&left.values) {
                    let same = match (right, left) {
                        (Some(right), Some(left)) => (right - left).abs() <= tolerance * right.abs().max(1.0),
                        (right, left) => right == left,
                    };
                    assert!(
                        same,
                        "{controller}, {person}, {crossing}, {side}: {name} is {right:?} on the right and {left:?} on the left"
                    );
                    compared += usize::from(right.is_some());
                }
            }
        }
    }
    assert!(compared > 1500, "{compared} values");
}
