//! What the reduced Autoware declares: every parameter of its specification, and the two presets.
//!
//! Decelerations and downward jerks are positive numbers here; Autoware writes them negative.

use scenario::{Declaration, Dimension, Parameter, Preset, PresetFamily, Value};

const CROSSWALK: &str = "autoware_launch 0.52.0, crosswalk.param.yaml";
const OBSTACLE_STOP: &str = "autoware_launch 0.52.0, obstacle_stop.param.yaml; 0.41.0, \
                             obstacle_cruise_planner.param.yaml";
const COMMON: &str = "autoware_launch 0.52.0, common.param.yaml";
const SMOOTHER: &str = "autoware_launch 0.52.0, velocity_smoother.param.yaml";
const AEB: &str = "autoware_launch 0.52.0, autonomous_emergency_braking.param.yaml";
const MRM: &str = "autoware_launch 0.52.0, mrm_emergency_stop_operator.param.yaml";
const PID: &str = "autoware_launch 0.52.0, pid.param.yaml";
const TRACKER: &str = "autoware_launch 0.41.0, multi_object_tracker_node.param.yaml";
const PREDICTION: &str = "autoware_launch 0.52.0, map_based_prediction.param.yaml";
const RATES: &str = "autoware_launch 0.52.0, behavior_path_planner.param.yaml and pid.param.yaml";
const ASSUMED: &str = "assumption of the reduced model";

fn length(name: &'static str, default: f64, high: f64, doc: &'static str, source: &'static str) -> Parameter {
    Parameter::number(name, Dimension::LENGTH, default, (0.0, high), doc, source)
}

fn time(name: &'static str, default: f64, high: f64, doc: &'static str, source: &'static str) -> Parameter {
    Parameter::number(name, Dimension::TIME, default, (0.0, high), doc, source)
}

fn speed(name: &'static str, default: f64, high: f64, doc: &'static str, source: &'static str) -> Parameter {
    Parameter::number(name, Dimension::SPEED, default, (0.01, high), doc, source)
}

fn acceleration(
    name: &'static str,
    default: f64,
    high: f64,
    doc: &'static str,
    source: &'static str,
) -> Parameter {
    Parameter::number(name, Dimension::ACCELERATION, default, (0.1, high), doc, source)
}

fn jerk(name: &'static str, default: f64, high: f64, doc: &'static str, source: &'static str) -> Parameter {
    Parameter::number(name, Dimension::JERK, default, (0.1, high), doc, source)
}

fn plain(
    name: &'static str,
    default: f64,
    range: (f64, f64),
    doc: &'static str,
    source: &'static str,
) -> Parameter {
    Parameter::number(name, Dimension::NUMBER, default, range, doc, source)
}

pub fn declaration() -> Declaration {
    Declaration::new(
        "autoware",
        "A reduced Autoware: tracker, crosswalk yield decision, in-lane stop, \
         jerk-limited profile, PID; longitudinal only.",
    )
    .source(
        "Autoware core 1.9.0, launch 0.52.0 and 0.41.0, universe; reduced as \
         docs/models/controller-autoware.md says",
    )
    .parameters([
        Parameter::flag(
            "crosswalk_mapped",
            true,
            "Whether the map holds the crossing as a crosswalk; without it only the \
             in-lane stop reacts. Worth tuning.",
            "property of the map",
        ),
        Parameter::optional(
            "max_speed",
            Dimension::SPEED,
            (0.5, 50.0),
            "Cruise speed (max_vel); absent: the vehicle's declared speed. Autoware ships \
             4.17 m/s. Worth tuning.",
            COMMON,
        ),
        time(
            "ego_pass_first_margin",
            4.0,
            30.0,
            "Passes first if it clears this long before the pedestrian arrives. Worth \
             tuning first.",
            CROSSWALK,
        ),
        time(
            "ego_pass_first_additional_margin",
            0.5,
            10.0,
            "Added to the pass-first margin unless it passes first already. Worth tuning \
             first.",
            CROSSWALK,
        ),
        time(
            "ego_pass_later_margin",
            13.0,
            60.0,
            "Need not stop yet if the pedestrian arrives this long before it clears. Worth \
             tuning first.",
            CROSSWALK,
        ),
        time(
            "ego_pass_later_additional_margin",
            0.5,
            10.0,
            "Added to the pass-later margin unless it passes later already. Worth tuning \
             first.",
            CROSSWALK,
        ),
        speed(
            "ego_min_assumed_speed",
            2.0,
            20.0,
            "Least speed that the ego is assumed to drive at in its time to clear the \
             collision point.",
            CROSSWALK,
        ),
        speed(
            "min_object_velocity",
            1.39,
            5.0,
            "Least speed that a pedestrian is assumed to walk at. Worth tuning.",
            CROSSWALK,
        ),
        speed(
            "stop_object_velocity_threshold",
            0.25,
            2.0,
            "Below this speed a pedestrian counts as standing.",
            CROSSWALK,
        ),
        length(
            "no_intention_near_distance",
            1.0,
            20.0,
            "Distance to the crosswalk up to which the near no-intention timeout holds. \
             Worth tuning first.",
            CROSSWALK,
        ),
        length(
            "no_intention_far_distance",
            5.0,
            20.0,
            "Distance to the crosswalk from which the far no-intention timeout holds; \
             linear in between. Worth tuning first.",
            CROSSWALK,
        ),
        time(
            "no_intention_near_timeout",
            1.0,
            60.0,
            "A pedestrian near the crosswalk who stands this long before the standing ego \
             is ignored. Worth tuning first.",
            CROSSWALK,
        ),
        time(
            "no_intention_far_timeout",
            0.0,
            60.0,
            "As the near timeout, far from the crosswalk. Worth tuning first.",
            CROSSWALK,
        ),
        time(
            "timeout_ego_stop_for_yield",
            1.0,
            30.0,
            "The ego counts as yielding once it has stood this long at the stop line. \
             Worth tuning first.",
            CROSSWALK,
        ),
        length(
            "stop_distance_from_crosswalk",
            3.5,
            20.0,
            "From the bumper to the near edge of the crosswalk at the preferred stop. \
             Worth tuning first.",
            CROSSWALK,
        ),
        length(
            "stop_distance_from_object",
            3.0,
            20.0,
            "From the bumper to the collision point at the preferred stop. Worth tuning \
             first.",
            CROSSWALK,
        ),
        length(
            "stop_distance_from_crosswalk_limit",
            3.0,
            20.0,
            "From the bumper to the near edge at the last acceptable stop. Worth tuning \
             first.",
            CROSSWALK,
        ),
        acceleration(
            "preferred_deceleration",
            1.2,
            10.0,
            "Deceleration up to which the preferred stop is kept (min_acc_preferred; 1.0 \
             in 0.41.0). Worth tuning.",
            CROSSWALK,
        ),
        jerk(
            "preferred_jerk",
            1.2,
            20.0,
            "Jerk up to which the preferred stop is kept (min_jerk_preferred; 1.0 in \
             0.41.0). Worth tuning.",
            CROSSWALK,
        ),
        Parameter::flag(
            "no_stop_enabled",
            true,
            "Whether it drives on when the stop needs more than the no-stop limits. Worth \
             tuning first.",
            CROSSWALK,
        ),
        acceleration(
            "no_stop_deceleration",
            1.5,
            10.0,
            "Deceleration beyond which it does not stop for the crosswalk at all. Worth \
             tuning first.",
            CROSSWALK,
        ),
        jerk(
            "no_stop_jerk",
            1.5,
            20.0,
            "Jerk beyond which it does not stop for the crosswalk at all. Worth tuning \
             first.",
            CROSSWALK,
        ),
        length(
            "attention_range",
            2.0,
            20.0,
            "How far before and after the crosswalk pedestrians' paths count.",
            CROSSWALK,
        ),
        acceleration(
            "normal_acceleration",
            1.0,
            5.0,
            "Acceleration of the planned profile (normal.max_acc). Worth tuning first.",
            COMMON,
        ),
        acceleration(
            "normal_deceleration",
            1.0,
            5.0,
            "Deceleration of the planned profile when it suffices (normal.min_acc). Worth \
             tuning first.",
            COMMON,
        ),
        jerk(
            "normal_positive_jerk",
            1.0,
            10.0,
            "Upward jerk of the planned profile (normal.max_jerk). Worth tuning first.",
            COMMON,
        ),
        jerk(
            "normal_negative_jerk",
            1.0,
            10.0,
            "Downward jerk of the planned profile when it suffices (normal.min_jerk). \
             Worth tuning first.",
            COMMON,
        ),
        acceleration(
            "limit_deceleration",
            2.5,
            10.0,
            "Planned deceleration that an in-lane stop is capped at with \
             `suppress_sudden_stop` (limit.min_acc). Worth tuning first.",
            COMMON,
        ),
        length(
            "lane_stop_margin",
            5.0,
            20.0,
            "In-lane stop: from the bumper to the pedestrian (4.0 m in 0.41.0). Worth \
             tuning.",
            OBSTACLE_STOP,
        ),
        length(
            "lane_stop_margin_at_crosswalk",
            3.0,
            20.0,
            "The same where a crosswalk stop lies between the in-lane stop and the \
             pedestrian. Worth tuning.",
            OBSTACLE_STOP,
        ),
        length(
            "lane_lateral_margin",
            0.3,
            3.0,
            "In-lane stop: how much wider than the ego its path is on each side. Worth \
             tuning.",
            OBSTACLE_STOP,
        ),
        time(
            "lane_on_delay",
            0.3,
            5.0,
            "How long a pedestrian must be in the way before the in-lane stop.",
            OBSTACLE_STOP,
        ),
        time(
            "lane_off_delay",
            1.0,
            10.0,
            "How long the in-lane stop stays after the way is free.",
            OBSTACLE_STOP,
        ),
        Parameter::flag(
            "suppress_sudden_stop",
            true,
            "Whether in-lane stops are capped at `limit_deceleration` even if it hits the \
             pedestrian (true up to early 2025). Worth tuning first.",
            OBSTACLE_STOP,
        ),
        Parameter::flag(
            "aeb",
            false,
            "Whether autonomous emergency braking is on. Off here because the original \
             works on point clouds. Worth tuning.",
            ASSUMED,
        ),
        time(
            "aeb_response_time",
            1.0,
            5.0,
            "Response time in the distance that triggers emergency braking. Worth tuning.",
            AEB,
        ),
        acceleration(
            "aeb_deceleration",
            3.0,
            10.0,
            "Ego deceleration in the distance that triggers emergency braking. Worth \
             tuning.",
            AEB,
        ),
        acceleration(
            "aeb_object_deceleration",
            1.0,
            10.0,
            "The pedestrian's deceleration in the distance that triggers emergency braking.",
            AEB,
        ),
        length(
            "aeb_offset",
            1.0,
            10.0,
            "Distance added to what triggers emergency braking. Worth tuning.",
            AEB,
        ),
        time("aeb_hold", 3.0, 20.0, "How long emergency braking stays after its trigger has cleared.", AEB),
        acceleration(
            "mrm_deceleration",
            2.5,
            10.0,
            "Deceleration of the emergency stop (minimum risk manoeuvre). Worth tuning.",
            MRM,
        ),
        jerk("mrm_jerk", 1.5, 20.0, "Jerk of the emergency stop. Worth tuning.", MRM),
        plain(
            "proportional_gain",
            1.0,
            (0.0, 10.0),
            "Speed feedback: acceleration per speed error (kp, 1/s).",
            PID,
        ),
        plain(
            "integral_gain",
            0.1,
            (0.0, 10.0),
            "Speed feedback: acceleration per integrated error (ki, 1/s²).",
            PID,
        ),
        acceleration("feedback_limit", 1.0, 10.0, "Limit of the speed feedback, up and down.", PID),
        plain(
            "feedforward_scale_min",
            0.5,
            (0.0, 1.0),
            "Least factor (actual over planned speed) on the planned acceleration.",
            PID,
        ),
        plain("feedforward_scale_max", 2.0, (1.0, 10.0), "Greatest factor on the planned acceleration.", PID),
        acceleration(
            "command_deceleration_limit",
            5.0,
            10.0,
            "Hardest braking that is commanded (min_acc). Worth tuning.",
            PID,
        ),
        acceleration(
            "command_acceleration_limit",
            3.0,
            10.0,
            "Greatest acceleration that is commanded (max_acc). Worth tuning.",
            PID,
        ),
        jerk(
            "command_negative_jerk_limit",
            5.0,
            100.0,
            "How fast the command may fall (min_jerk). Worth tuning.",
            PID,
        ),
        jerk(
            "command_positive_jerk_limit",
            2.0,
            100.0,
            "How fast the command may rise (max_jerk). Worth tuning.",
            PID,
        ),
        time(
            "delay_compensation",
            0.1,
            1.0,
            "How far ahead the controller reads the plan, for the vehicle's delay.",
            PID,
        ),
        speed("engage_speed", 0.25, 2.0, "Planned speed from standstill.", SMOOTHER),
        acceleration("engage_acceleration", 0.5, 3.0, "Planned acceleration from standstill.", SMOOTHER),
        time(
            "sensor_delay",
            0.1,
            2.0,
            "From a measurement to the tracker; positions are extrapolated over it. Worth \
             tuning.",
            ASSUMED,
        ),
        time(
            "velocity_time_constant",
            0.4,
            5.0,
            "Time constant of the tracked velocity, derived from the tracker's noise \
             settings. Worth tuning.",
            "derived from object_model.hpp (process and position noise at 10 Hz)",
        ),
        Parameter::whole(
            "confirmation_hits",
            3,
            (1, 100),
            "Detections in a row that make a target (3 in 0.41.0). Worth tuning.",
            TRACKER,
        ),
        length(
            "detection_range",
            76.8,
            500.0,
            "Distance from the ego's centre up to which pedestrians are detected. Worth \
             tuning.",
            "lidar_centerpoint ml_package.param.yaml (point cloud range)",
        ),
        plain(
            "miss_probability",
            0.0,
            (0.0, 1.0),
            "Probability that a detection fails, for each pedestrian and tick. Worth \
             tuning.",
            ASSUMED,
        ),
        time(
            "track_lifetime",
            1.0,
            10.0,
            "How long a target is extrapolated when it is not detected any more.",
            TRACKER,
        ),
        time(
            "intention_on_delay",
            0.3,
            5.0,
            "How long a pedestrian must look like crossing before it counts (0 in 0.41.0).",
            PREDICTION,
        ),
        time(
            "intention_off_delay",
            1.0,
            10.0,
            "How long a crossing intention stays after its signs have gone (0 in 0.41.0).",
            PREDICTION,
        ),
        Parameter::number(
            "planning_period",
            Dimension::TIME,
            0.1,
            (0.01, 1.0),
            "Time between two runs of tracker, decisions and profile.",
            RATES,
        ),
        Parameter::number(
            "control_period",
            Dimension::TIME,
            0.03,
            (0.005, 1.0),
            "Time between two commands.",
            RATES,
        ),
        Parameter::number(
            "vehicle_period",
            Dimension::TIME,
            0.025,
            (0.001, 1.0),
            "Time between two states that the vehicle publishes: commands are computed \
             from one, and begin to act with it.",
            "simple_planning_simulator, 40 Hz",
        ),
    ])
    .presets(PresetFamily::new(
        "preset",
        "mapped",
        [
            Preset::new(
                "mapped",
                "Intended behaviour: the map holds the crosswalk and it yields to everybody \
                 who may cross.",
                [("crosswalk_mapped", Value::Flag(true))],
            ),
            Preset::new(
                "lane_only",
                "No crosswalk in the map: it reacts to pedestrians in its lane only. Seems \
                 nearer to published closed-loop results.",
                [("crosswalk_mapped", Value::Flag(false))],
            ),
        ],
    ))
}
