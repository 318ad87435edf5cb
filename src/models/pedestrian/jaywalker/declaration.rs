//! The jaywalker's entry in the registry: parameters, presets and sources.

use scenario::{ChoiceOption, Declaration, Dimension, Parameter, Preset, PresetFamily, Settings};
use sim::{ModelError, Stated, StatedBy};

const CODE: &str = "observed behaviour of the research code behind Muktadir & Whitehead 2022";
const BREWER: &str = "Brewer et al. 2006, TRR 1982:132-140, coefficients as observed in the \
                      research code";
const YANG: &str = "Yang, Ozguner & Redmill 2020, ACM TSAS 6(2), table 2";
const CHOICE: &str = "our choice";
const DECISION: &str = "observed behaviour, completed by our choice";

pub fn declaration() -> Declaration {
    Declaration::new(
        "jaywalker",
        "Adversarial jaywalker: starts so as to meet the vehicle, then dashes, freezes \
         in the lane or turns back.",
    )
    .source(
        "Muktadir & Whitehead, IEEE IV 2022, restated from the observed behaviour of \
         the research code",
    )
    .parameters([
        Parameter::number(
            "initialising_time",
            Dimension::TIME,
            0.8,
            (0.0, 2.0),
            "Time from its appearance in which it neither moves nor decides.",
            "observed behaviour: 20 ticks of 0.04 s",
        ),
        Parameter::choice(
            "gap_model",
            "anti_survival",
            [
                ChoiceOption::new(
                    "anti_survival",
                    "Starts when crossing takes as long as the vehicle needs.",
                ),
                ChoiceOption::new(
                    "brewer",
                    "Accepts by a logistic probability of the time gap, modified by `risk`.",
                ),
                ChoiceOption::new("always_go", "Accepts at the first ask."),
            ],
            "How it decides to leave the pavement.",
            CODE,
        ),
        Parameter::choice(
            "risk",
            "risky",
            [
                ChoiceOption::new("cautious", "0.8 times Brewer's probability."),
                ChoiceOption::new("normal", "Brewer's probability."),
                ChoiceOption::new("risky", "Twice Brewer's probability."),
                ChoiceOption::new("extreme", "Always accepts."),
            ],
            "Risk level; only with `gap_model: brewer`.",
            CODE,
        ),
        Parameter::number(
            "brewer_intercept",
            Dimension::NUMBER,
            6.2064,
            (6.2064, 6.2064),
            "Intercept of Brewer's logit; fixed by its source.",
            BREWER,
        ),
        Parameter::number(
            "brewer_slope",
            Dimension::PER_TIME,
            -0.9420,
            (-0.9420, -0.9420),
            "Slope of Brewer's logit over the time gap; fixed by its source.",
            BREWER,
        ),
        Parameter::number(
            "crossing_distance",
            Dimension::LENGTH,
            5.0,
            (4.0, 6.0),
            "Distance that it believes to have to cross; only with `gap_model: \
             anti_survival`.",
            CODE,
        ),
        Parameter::optional(
            "timing_error",
            Dimension::NUMBER,
            (0.9, 1.1),
            "Factor by which it misjudges the time gap at the start; without it, drawn \
             once per run from 0.9 .. 1.1.",
            DECISION,
        ),
        Parameter::choice(
            "tactic",
            "drawn",
            [
                ChoiceOption::new("drawn", "One of the three, drawn once per run."),
                ChoiceOption::new("dash", "Speeds up before an oncoming vehicle."),
                ChoiceOption::new("freeze", "Stops dead in the vehicle's lane."),
                ChoiceOption::new("rewind", "Speeds up, then turns back before the lane's centre."),
            ],
            "Decides whatever `oncoming`, `retreat` and `stop` leave to it.",
            CHOICE,
        ),
        Parameter::choice(
            "oncoming",
            "by_tactic",
            [
                ChoiceOption::new("by_tactic", "`speedup` when dashing or rewinding, else `off`."),
                ChoiceOption::new("off", "None."),
                ChoiceOption::new("speedup", "A constant push towards its goal."),
                ChoiceOption::new("yang", "Repulsion by a contour ahead of the vehicle."),
            ],
            "The force of an oncoming vehicle on it while it crosses.",
            CODE,
        ),
        Parameter::choice(
            "retreat",
            "by_tactic",
            [
                ChoiceOption::new("by_tactic", "`on` when rewinding, else `off`."),
                ChoiceOption::new("off", "Never turns back."),
                ChoiceOption::new(
                    "on",
                    "Turns back when the vehicle will arrive just after it, or far before.",
                ),
            ],
            "Whether it may turn back on its way (state survival).",
            CODE,
        ),
        Parameter::choice(
            "stop",
            "by_tactic",
            [
                ChoiceOption::new("by_tactic", "`on` when freezing, else `off`."),
                ChoiceOption::new("off", "Never stops."),
                ChoiceOption::new("on", "Stops in the lane of a vehicle that is about to arrive."),
            ],
            "Whether it may stop on its way (state frozen).",
            CODE,
        ),
        Parameter::number(
            "time_gap_multiplier",
            Dimension::NUMBER,
            1.0,
            (0.8, 1.2),
            "Factor on every time gap that it perceives; above 1 it overestimates.",
            CODE,
        ),
        Parameter::optional(
            "time_gap_margin",
            Dimension::LENGTH,
            (0.0, 10.0),
            "Length taken off the vehicle's distance besides its half length; without it, \
             half the vehicle's diagonal. 0 is the true gap to the bumper.",
            CODE,
        ),
        Parameter::number(
            "desired_speed",
            Dimension::SPEED,
            2.0,
            (0.7, 3.0),
            "Speed at which it wants to cross.",
            CODE,
        ),
        Parameter::number(
            "relaxation_time",
            Dimension::TIME,
            0.5,
            (0.07, 2.0),
            "Time in which it reaches its desired speed.",
            CODE,
        ),
        Parameter::number(
            "max_speed",
            Dimension::SPEED,
            10.0,
            (2.0, 10.0),
            "Its speed never exceeds this.",
            CODE,
        ),
        Parameter::number(
            "max_acceleration",
            Dimension::ACCELERATION,
            9.5,
            (9.5, 1000.0),
            "Its acceleration never exceeds this, but for standing still at once when it \
             waits or has arrived.",
            CODE,
        ),
        Parameter::number(
            "speedup_push",
            Dimension::ACCELERATION,
            5.0,
            (0.0, 2000.0),
            "Push towards its goal with `oncoming: speedup`.",
            CODE,
        ),
        Parameter::number(
            "yang_strength",
            Dimension::ACCELERATION,
            777.5852,
            (777.5852, 777.5852),
            "Repulsion at the contour, per unit of mass (in newtons with `yang_original`); \
             fixed by its source.",
            YANG,
        ),
        Parameter::number(
            "yang_decay",
            Dimension::PER_LENGTH,
            2.613755,
            (2.613755, 2.613755),
            "Decay of the repulsion over the distance from the contour; fixed by its \
             source.",
            YANG,
        ),
        Parameter::number(
            "yang_anisotropy",
            Dimension::NUMBER,
            0.3119132,
            (0.3119132, 0.3119132),
            "Share of the repulsion that comes from behind; fixed by its source.",
            YANG,
        ),
        Parameter::number(
            "yang_rear_margin",
            Dimension::LENGTH,
            0.2151011,
            (0.2151011, 0.2151011),
            "Margin of the contour around the vehicle; fixed by its source.",
            YANG,
        ),
        Parameter::number(
            "yang_front_margin",
            Dimension::LENGTH,
            0.510985,
            (0.510985, 0.510985),
            "Additional margin of the contour before the vehicle; fixed by its source.",
            YANG,
        ),
        Parameter::number(
            "yang_front_time",
            Dimension::TIME,
            1.394358,
            (1.394358, 1.394358),
            "Driving time by which the contour's nose reaches ahead; fixed by its source.",
            YANG,
        ),
        Parameter::flag(
            "yang_original",
            false,
            "Yang's own mass (75 kg), wider contour and body radius instead of the \
             jaywalker's.",
            YANG,
        ),
        Parameter::number(
            "survival_band",
            Dimension::TIME,
            1.0,
            (0.5, 2.0),
            "Turns back if the vehicle arrives less than this after it would be across.",
            CODE,
        ),
        Parameter::number(
            "far_late_bound",
            Dimension::TIME,
            -2.0,
            (-2.0, -0.5),
            "Turns back if the vehicle arrives earlier than this relative to it being \
             across; negative.",
            CODE,
        ),
        Parameter::number(
            "retreat_distance",
            Dimension::LENGTH,
            3.0,
            (2.0, 5.0),
            "How far it turns back.",
            CODE,
        ),
        Parameter::number(
            "freeze_time_gap",
            Dimension::TIME,
            0.5,
            (0.3, 2.0),
            "Stops when the time gap is below this.",
            CODE,
        ),
        Parameter::number(
            "unfreeze_time_gap",
            Dimension::TIME,
            1.0,
            (0.3, 2.0),
            "May go on when the time gap is at least this again.",
            "documentation of the research code; its code has 0.5 s",
        ),
        Parameter::number(
            "unfreeze_gap",
            Dimension::LENGTH,
            0.5,
            (0.3, 2.0),
            "May go on when the gap is at least this as well.",
            CODE,
        ),
        Parameter::optional(
            "stop_time",
            Dimension::TIME,
            (0.05, 5.0),
            "Time that it takes to stop; without it, drawn once per run between the two \
             below.",
            CODE,
        ),
        Parameter::number(
            "stop_time_min",
            Dimension::TIME,
            0.15,
            (0.05, 5.0),
            "Shortest time drawn for stopping.",
            "observed behaviour; the documentation of the research code says 0.5 s",
        ),
        Parameter::number(
            "stop_time_max",
            Dimension::TIME,
            1.5,
            (0.05, 5.0),
            "Longest time drawn for stopping; uniform in between.",
            CODE,
        ),
        Parameter::flag(
            "reference_quirks",
            false,
            "Ends a retreat as the research code does: at a time gap of zero, or within 1 \
             mm of its end.",
            CODE,
        ),
    ])
    .presets(PresetFamily::new(
        "preset",
        "adversarial",
        [
            Preset::new(
                "adversarial",
                "Starts late, then dashes, freezes or rewinds, drawn once per run: all six \
                 states occur.",
                [],
            ),
            Preset::new(
                "risky_literal",
                "The research code's default risk mode taken literally; crosses first whenever \
                 the vehicle is 6 s away.",
                [
                    ("gap_model", "brewer".into()),
                    ("risk", "risky".into()),
                    ("oncoming", "off".into()),
                    ("retreat", "on".into()),
                    ("stop", "on".into()),
                ],
            ),
            Preset::new(
                "head_2024",
                "The research code as of 2024: goes at once, is repelled by vehicles, never \
                 retreats or stops.",
                [
                    ("gap_model", "always_go".into()),
                    ("oncoming", "yang".into()),
                    ("retreat", "off".into()),
                    ("stop", "off".into()),
                ],
            ),
            Preset::new(
                "all_on",
                "Starts late, speeds up, retreats and stops, whichever triggers first.",
                [
                    ("gap_model", "anti_survival".into()),
                    ("oncoming", "speedup".into()),
                    ("retreat", "on".into()),
                    ("stop", "on".into()),
                ],
            ),
        ],
    ))
}

/// Limits of acceleration and speed, and how it walks undisturbed.
#[derive(Debug, Clone, Copy)]
pub struct Walking {
    /// m/s
    pub desired_speed: f64,
    /// s
    pub relaxation_time: f64,
    /// m/s
    pub max_speed: f64,
    /// m/s²
    pub max_acceleration: f64,
}

/// When it turns back or stops, and when it goes on.
#[derive(Debug, Clone, Copy)]
pub struct Triggers {
    pub survival_band: f64,
    pub far_late_bound: f64,
    pub freeze_time_gap: f64,
    pub unfreeze_time_gap: f64,
    pub unfreeze_gap: f64,
    pub reference_quirks: bool,
}

impl Walking {
    pub fn new(settings: &Settings) -> Self {
        Self {
            desired_speed: settings.number("desired_speed"),
            relaxation_time: settings.number("relaxation_time"),
            max_speed: settings.number("max_speed"),
            max_acceleration: settings.number("max_acceleration"),
        }
    }
}

impl Triggers {
    pub fn new(settings: &Settings) -> Self {
        Self {
            survival_band: settings.number("survival_band"),
            far_late_bound: settings.number("far_late_bound"),
            freeze_time_gap: settings.number("freeze_time_gap"),
            unfreeze_time_gap: settings.number("unfreeze_time_gap"),
            unfreeze_gap: settings.number("unfreeze_gap"),
            reference_quirks: settings.flag("reference_quirks"),
        }
    }
}

/// The range that the stopping time is drawn from, s.
pub fn stop_times(settings: &Settings) -> Result<(f64, f64), ModelError> {
    let (low, high) = (settings.number("stop_time_min"), settings.number("stop_time_max"));
    if low > high {
        let stated = |value, name: &'static str| Stated {
            value,
            dimension: Dimension::TIME,
            of: StatedBy::Setting(name.into()),
        };
        return Err(ModelError::stating(
            "`stop_time_min` of `jaywalker` ({}) is above `stop_time_max` ({})",
            [stated(low, "stop_time_min"), stated(high, "stop_time_max")],
            "swap them, or give one `stop_time`",
        ));
    }
    Ok((low, high))
}
