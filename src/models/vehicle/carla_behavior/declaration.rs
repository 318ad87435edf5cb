//! What the behaviour agent declares: every constant of its code as a parameter.

use scenario::{ChoiceOption, Declaration, Dimension, Parameter, Preset, PresetFamily, Value};

const TYPES: &str = "CARLA behavior_types.py";
const AGENT: &str = "CARLA behavior_agent.py (0.9.13 and later)";
const BASIC: &str = "CARLA basic_agent.py";
const CONTROL: &str = "CARLA controller.py, local_planner.py";
const DERIVED: &str = "derived from the CARLA sources";

/// 1 m/s in km/h, the unit that the agent thinks in.
pub(super) const KMH: f64 = 3.6;

const fn kmh(speed: f64) -> f64 {
    speed / KMH
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

pub fn declaration() -> Declaration {
    Declaration::new(
        "carla_behavior",
        "CARLA's BehaviorAgent: brakes hard when an obstacle in its lane is nearer \
         than a distance, else drives on.",
    )
    .source("CARLA 0.9.13 to 0.9.15, PythonAPI/carla/agents/navigation")
    .parameters([
        Parameter::number(
            "braking_distance",
            Dimension::LENGTH,
            5.0,
            (0.0, 100.0),
            "Believed distance to an obstacle below which it brakes; what it means depends \
             on `obstacle_distance`.",
            TYPES,
        ),
        Parameter::choice(
            "obstacle_distance",
            "extended",
            [
                ChoiceOption::new(
                    "stock",
                    "Unmodified: walkers farther than 10 m from the ego's centre are not looked at \
                     and half the ego's length is subtracted twice, so it brakes from \
                     `braking_distance` + about 2.5 m before the bumper, and no `braking_distance` \
                     beyond about 5.3 m changes anything.",
                ),
                ChoiceOption::new(
                    "extended",
                    "As stock, but it looks as far as `braking_distance` needs, so every \
                     `braking_distance` has an effect.",
                ),
                ChoiceOption::new(
                    "clean",
                    "Brakes when the gap between front bumper and walker is below \
                     `braking_distance`; looks any distance, and at the nearest of several walkers.",
                ),
            ],
            "How the distance to an obstacle is measured and how far it looks.",
            DERIVED,
        ),
        Parameter::choice(
            "lateral",
            "lane",
            [
                ChoiceOption::new("lane", "A walker whose centre is in the ego's lane counts."),
                ChoiceOption::new("polygon", "A walker who touches the strip that the ego sweeps counts."),
            ],
            "Which walkers are in the way.",
            BASIC,
        ),
        Parameter::choice(
            "target_speed",
            "cruise",
            [
                ChoiceOption::new("cruise", "The vehicle's declared speed."),
                ChoiceOption::new(
                    "stock",
                    "min(`max_speed`, speed limit - `speed_limit_distance`): 27 km/h at a limit of \
                     30 with the normal profile.",
                ),
            ],
            "The speed that it drives at.",
            AGENT,
        ),
        Parameter::number(
            "max_speed",
            Dimension::SPEED,
            kmh(50.0),
            (0.0, kmh(250.0)),
            "Highest speed; only with `target_speed: stock`.",
            TYPES,
        ),
        Parameter::number(
            "speed_limit_distance",
            Dimension::SPEED,
            kmh(3.0),
            (kmh(-50.0), kmh(50.0)),
            "How far below the speed limit it drives; only with `target_speed: stock`.",
            TYPES,
        ),
        Parameter::number(
            "speed_decrease",
            Dimension::SPEED,
            kmh(10.0),
            (0.0, kmh(100.0)),
            "How much slower than a vehicle ahead it gets when the time to collision is \
             below `safety_time`.",
            TYPES,
        ),
        Parameter::number(
            "safety_time",
            Dimension::TIME,
            3.0,
            (0.0, 60.0),
            "Time to collision with a vehicle ahead below which it slows down; up to twice \
             as long it keeps that vehicle's speed.",
            TYPES,
        ),
        Parameter::number(
            "min_following_speed",
            Dimension::SPEED,
            kmh(5.0),
            (0.0, kmh(50.0)),
            "Lowest speed that it keeps behind a vehicle ahead.",
            AGENT,
        ),
        Parameter::number(
            "min_proximity_threshold",
            Dimension::LENGTH,
            10.0,
            (0.0, 200.0),
            "Reach of the obstacle test in stock mode, unless a third of the speed limit \
             in km/h is more.",
            TYPES,
        ),
        Parameter::number(
            "walker_radius",
            Dimension::LENGTH,
            10.0,
            (0.0, 1000.0),
            "Distance from the ego's centre within which walkers are looked at; only in \
             stock mode.",
            AGENT,
        ),
        Parameter::number(
            "walker_origin_height",
            Dimension::LENGTH,
            0.9,
            (0.0, 2.0),
            "Height of a walker's origin above the road, which counts in `walker_radius`.",
            DERIVED,
        ),
        Parameter::number(
            "walker_cone",
            Dimension::ANGLE,
            60.0 * DEGREE,
            (0.0, std::f64::consts::PI),
            "Half angle of the cone before the bumper in which walkers count.",
            AGENT,
        ),
        Parameter::optional(
            "walker_extent",
            Dimension::LENGTH,
            (0.0, 2.0),
            "Half size that it takes a walker to have; without it that of the pedestrian's \
             footprint. CARLA's adults have 0.188 m.",
            "CARLA blueprint bounding boxes",
        ),
        Parameter::number(
            "vehicle_radius",
            Dimension::LENGTH,
            45.0,
            (0.0, 1000.0),
            "Distance within which other vehicles are looked at.",
            AGENT,
        ),
        Parameter::number(
            "vehicle_cone",
            Dimension::ANGLE,
            30.0 * DEGREE,
            (0.0, std::f64::consts::PI),
            "Half angle of the cone before the bumper in which other vehicles count.",
            AGENT,
        ),
        Parameter::number(
            "emergency_brake",
            Dimension::NUMBER,
            0.5,
            (0.0, 1.0),
            "Brake pedal of an emergency stop.",
            BASIC,
        ),
        Parameter::number(
            "proportional",
            Dimension::NUMBER,
            1.0,
            (0.0, 100.0),
            "Proportional gain, pedal per km/h.",
            CONTROL,
        ),
        Parameter::number(
            "integral",
            Dimension::NUMBER,
            0.05,
            (0.0, 100.0),
            "Integral gain over the remembered errors, pedal per km/h and s.",
            CONTROL,
        ),
        Parameter::number(
            "derivative",
            Dimension::NUMBER,
            0.0,
            (0.0, 100.0),
            "Derivative gain, pedal s per km/h.",
            CONTROL,
        ),
        Parameter::whole("buffer", 10, (1, 1000), "Number of errors that are remembered.", CONTROL),
        Parameter::number(
            "max_throttle",
            Dimension::NUMBER,
            0.75,
            (0.0, 1.0),
            "Highest throttle of the speed controller.",
            CONTROL,
        ),
        Parameter::number(
            "max_brake",
            Dimension::NUMBER,
            0.3,
            (0.0, 1.0),
            "Highest brake of the speed controller.",
            CONTROL,
        ),
        Parameter::number(
            "period",
            Dimension::TIME,
            0.05,
            (0.001, 1.0),
            "Time between decisions.",
            "usual fixed time step of CARLA",
        ),
        Parameter::number(
            "settling_time",
            Dimension::TIME,
            10.0,
            (0.0, 600.0),
            "Free driving before the start, in which the speed controller settles.",
            "free choice",
        ),
    ])
    .presets(PresetFamily::new(
        "profile",
        "normal",
        [
            Preset::new(
                "cautious",
                "Slower, looks farther, brakes earlier.",
                [
                    ("max_speed", Value::Number(kmh(40.0))),
                    ("speed_limit_distance", Value::Number(kmh(6.0))),
                    ("speed_decrease", Value::Number(kmh(12.0))),
                    ("safety_time", Value::Number(3.0)),
                    ("min_proximity_threshold", Value::Number(12.0)),
                    ("braking_distance", Value::Number(6.0)),
                ],
            ),
            Preset::new("normal", "CARLA's default.", []),
            Preset::new(
                "aggressive",
                "Faster, brakes later.",
                [
                    ("max_speed", Value::Number(kmh(70.0))),
                    ("speed_limit_distance", Value::Number(kmh(1.0))),
                    ("speed_decrease", Value::Number(kmh(8.0))),
                    ("safety_time", Value::Number(3.0)),
                    ("min_proximity_threshold", Value::Number(8.0)),
                    ("braking_distance", Value::Number(4.0)),
                ],
            ),
        ],
    ))
}
