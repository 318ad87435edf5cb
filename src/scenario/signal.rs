//! Signals: what a functional mock-up unit may be told of what a vehicle sees, and what it may say the vehicle is to do.

use super::{Answer, Dimension};

/// A number that is told or said, at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SignalEntry {
    /// As the language says it; of an object, what stands behind its number.
    pub name: &'static str,
    /// Of its values, which are in SI units.
    pub dimension: Dimension,
    /// Whether it is 1 or 0.
    pub is_flag: bool,
    /// One line.
    pub doc: &'static str,
}

/// How many objects signals tell of.
pub const OBJECTS: usize = 8;

/// x of an object that is not there, and the gap to nobody, m.
pub const NOBODY_AT: f64 = 1000.0;

const fn signal(name: &'static str, dimension: Dimension, doc: &'static str) -> SignalEntry {
    SignalEntry { name, dimension, is_flag: false, doc }
}

const fn flag(name: &'static str, doc: &'static str) -> SignalEntry {
    SignalEntry { name, dimension: Dimension::NUMBER, is_flag: true, doc }
}

/// Those of which there is one.
pub const SEEN: [SignalEntry; 24] = [
    signal("time", Dimension::TIME, "Time of the scenario; negative while settling."),
    signal("cruise_speed", Dimension::SPEED, "The speed that the vehicle is wanted to cruise at."),
    signal(
        "ego.distance_to_crossing",
        Dimension::LENGTH,
        "To the middle of the crossing; negative once past it.",
    ),
    signal("ego.speed", Dimension::SPEED, "Of the vehicle."),
    signal("ego.acceleration", Dimension::ACCELERATION, "Of the vehicle."),
    signal("ego.length", Dimension::LENGTH, "Of the vehicle."),
    signal("ego.width", Dimension::LENGTH, "Of the vehicle."),
    signal("road.lane_width", Dimension::LENGTH, "Of the vehicle's lane."),
    signal("road.speed_limit", Dimension::SPEED, "Of the road."),
    signal("road.crossing_width", Dimension::LENGTH, "Extent of the crossing along the road."),
    flag("road.pedestrian_priority", "Whether pedestrians have priority at the crossing now."),
    flag(
        "road.signal",
        "0 while vehicles have red or amber; 1 while they have green, and where there is no signal.",
    ),
    signal("road.right_kerb", Dimension::LENGTH, "y of the kerb on the right; negative."),
    signal("road.left_kerb", Dimension::LENGTH, "y of the kerb on the left."),
    signal(
        "ego.travelled",
        Dimension::LENGTH,
        "Along the lane, 0 at the middle of the crossing; negative before it.",
    ),
    signal("ego.curvature", Dimension::PER_LENGTH, "Of the lane where the vehicle is, to the left."),
    signal("road.gradient", Dimension::NUMBER, "Rise per metre ahead; 0 where the road says none."),
    flag("road.amber", "Whether vehicles have amber; 0 where there is no signal."),
    signal(
        "road.stop_line",
        Dimension::LENGTH,
        "From the edge of the crossing back to the line at which vehicles stop; 0 where there is no signal.",
    ),
    signal(
        "ego.lateral_offset",
        Dimension::LENGTH,
        "Of the vehicle from the middle of its lane, to the left; 0 where nobody has steered.",
    ),
    signal(
        "ego.heading_error",
        Dimension::ANGLE,
        "From the direction of the lane to that of the vehicle, to the left; 0 where nobody has steered.",
    ),
    flag("ahead.present", "Whether somebody is ahead in the lane."),
    signal(
        "ahead.gap",
        Dimension::LENGTH,
        "From bumper to whoever is nearest ahead in the lane; 1000 m if nobody is.",
    ),
    signal("ahead.closing_speed", Dimension::SPEED, "By which that gap shrinks; 0 if nobody is ahead."),
];

/// Those of `object1` to `object8`, who are ahead, nearest first.
pub const OBJECT: [SignalEntry; 8] = [
    flag("present", "Whether there are so many ahead."),
    signal("x", Dimension::LENGTH, "Centre, ahead of the vehicle's centre; 1000 m if not present."),
    signal("y", Dimension::LENGTH, "Centre, to the left of the lane's centre line; 0 if not present."),
    signal("vx", Dimension::SPEED, "Over ground, along the lane; 0 if not present."),
    signal("vy", Dimension::SPEED, "Over ground, to the left; 0 if not present."),
    signal("length", Dimension::LENGTH, "Along the lane; 0 if not present."),
    signal("width", Dimension::LENGTH, "Across the lane; 0 if not present."),
    signal(
        "kind",
        Dimension::NUMBER,
        "1 on foot, 2 on a bicycle, 3 on an electric scooter, 4 a vehicle; 0 if not present.",
    ),
];

/// Every signal that may be told, by its whole name: [`SEEN`], then [`OBJECT`] of each of the [`OBJECTS`].
pub fn input_signals() -> impl Iterator<Item = (String, SignalEntry)> {
    let objects = (1..=OBJECTS)
        .flat_map(|number| OBJECT.iter().map(move |one| (format!("object{number}.{}", one.name), *one)));
    SEEN.iter().map(|one| (one.name.to_string(), *one)).chain(objects)
}

/// The signals that make up an answer; none where it is no number or two.
pub fn output_signals(gives: Answer) -> &'static [SignalEntry] {
    const ACCELERATION: [SignalEntry; 1] =
        [signal("acceleration", Dimension::ACCELERATION, "What the vehicle is to accelerate by.")];
    const PEDALS: [SignalEntry; 2] = [
        signal("throttle", Dimension::NUMBER, "How far the throttle is open, 0 .. 1."),
        signal("brake", Dimension::NUMBER, "How far the brake is pressed, 0 .. 1."),
    ];
    const SPEED: [SignalEntry; 1] = [signal("speed", Dimension::SPEED, "The speed that is to be reached.")];
    match gives {
        Answer::Acceleration => &ACCELERATION,
        Answer::Pedals => &PEDALS,
        Answer::Speed => &SPEED,
        Answer::SpeedPlan => &[],
    }
}

/// What may be part of any answer.
pub const STEERS: SignalEntry = signal(
    "curvature",
    Dimension::PER_LENGTH,
    "Of the way that the rear axle is to take, to the left; without it the vehicle keeps its lane.",
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_signal_has_a_name_of_its_own() {
        let mut names: Vec<String> = input_signals().map(|(name, _)| name).collect();
        assert_eq!(names.len(), 24 + 8 * 8);
        assert_eq!(names[3], "ego.speed");
        assert_eq!(names[24], "object1.present");
        assert_eq!(names.last().unwrap(), "object8.kind");
        names.sort();
        names.dedup();
        assert_eq!(names.len(), 24 + 8 * 8);
    }
}
