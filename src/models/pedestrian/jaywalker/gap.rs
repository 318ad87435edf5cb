//! Whether the jaywalker takes a gap: Brewer's logistic acceptance, always, or the late start that seeks a conflict.

use super::declaration::Walking;
use numbers::random::Stream;
use scenario::Settings;

/// The tick that Brewer's acceptance probability belongs to, s.
const REFERENCE_TICK: f64 = 0.04;
/// Above this probability a gap is accepted with certainty.
const CERTAIN: f64 = 0.85;
/// Time without any time gap after which the late starter goes, s.
const PATIENCE: f64 = 1.0;
const TIME_TOLERANCE: f64 = 1e-9;

/// How it decides to start.
#[derive(Debug, Clone, Copy)]
pub enum GapModel {
    Brewer(Brewer),
    AlwaysGo,
    AntiSurvival {
        /// Time that it expects the crossing to take, s.
        crossing_time: f64,
        /// Factor by which it misjudges the time gap.
        timing_error: f64,
    },
}

/// Gap acceptance by a logit of the time gap.
#[derive(Debug, Clone, Copy)]
pub struct Brewer {
    intercept: f64,
    slope: f64,
    risk: Risk,
}

#[derive(Debug, Clone, Copy)]
enum Risk {
    /// Multiplies the probability.
    Factor(f64),
    Extreme,
}

/// What the gap models look at.
#[derive(Debug, Clone, Copy)]
pub struct Opportunity {
    /// s; `None` if no vehicle comes.
    pub time_gap: Option<f64>,
    /// Time since which there was no time gap, s.
    pub undisturbed: f64,
    /// Whether every vehicle is past.
    pub passed: bool,
    /// Time until it will be asked again, s.
    pub step: f64,
}

impl GapModel {
    pub fn new(settings: &Settings, walking: &Walking, timing_error: f64) -> Self {
        match settings.word("gap_model") {
            "brewer" => Self::Brewer(Brewer::new(settings)),
            "always_go" => Self::AlwaysGo,
            _ => {
                let Walking { desired_speed, relaxation_time, .. } = *walking;
                let steady = settings.number("crossing_distance") - desired_speed * relaxation_time / 2.0;
                let crossing_time = relaxation_time + (steady / desired_speed).max(0.0);
                Self::AntiSurvival { crossing_time, timing_error }
            }
        }
    }

    pub fn accepts(&self, opportunity: &Opportunity, draws: &mut Stream) -> bool {
        match *self {
            Self::AlwaysGo => true,
            Self::Brewer(brewer) => {
                let Some(time_gap) = opportunity.time_gap else { return true };
                let probability = brewer.probability(time_gap);
                if probability > CERTAIN {
                    return true;
                }
                // The same chance per second at every step size.
                let per_step = 1.0 - libm::pow(1.0 - probability.min(1.0), opportunity.step / REFERENCE_TICK);
                draws.uniform() < per_step
            }
            Self::AntiSurvival { crossing_time, timing_error } => match opportunity.time_gap {
                Some(time_gap) => crossing_time >= time_gap * timing_error,
                None => opportunity.passed || opportunity.undisturbed >= PATIENCE - TIME_TOLERANCE,
            },
        }
    }
}

impl Brewer {
    fn new(settings: &Settings) -> Self {
        Self {
            intercept: settings.number("brewer_intercept"),
            slope: settings.number("brewer_slope"),
            risk: match settings.word("risk") {
                "cautious" => Risk::Factor(0.8),
                "normal" => Risk::Factor(1.0),
                "risky" => Risk::Factor(2.0),
                _ => Risk::Extreme,
            },
        }
    }

    /// Of accepting a time gap (s) within one reference tick, at its risk level; may exceed 1.
    fn probability(&self, time_gap: f64) -> f64 {
        let accepted = 1.0 / (1.0 + libm::exp(self.intercept + self.slope * time_gap));
        match self.risk {
            Risk::Factor(factor) => factor * accepted,
            Risk::Extreme => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::jaywalker::declaration::declaration;
    use scenario::Value;

    fn brewer(risk: &str) -> Brewer {
        let given = Settings::from([("risk", Value::Word(risk.into()))]);
        Brewer::new(&declaration().resolve(&given).unwrap())
    }

    fn asked(time_gap: Option<f64>, step: f64) -> Opportunity {
        Opportunity { time_gap, undisturbed: 0.0, passed: false, step }
    }

    /// Specification, check 2.
    #[test]
    fn brewer_probabilities() {
        let normal = brewer("normal");
        for (time_gap, expected) in [(2.0, 0.0131), (4.0, 0.0803), (6.0, 0.3648), (6.588, 0.5)] {
            let probability = normal.probability(time_gap);
            assert!((probability - expected).abs() < 5e-4, "{time_gap} s: {probability}");
        }
        assert!((brewer("cautious").probability(8.0) - 0.633).abs() < 5e-4);
        assert_eq!(brewer("extreme").probability(0.0), 1.0);
        assert!(brewer("risky").probability(6.27) > CERTAIN && brewer("risky").probability(6.26) < CERTAIN);
    }

    /// Specification, check 2: certain decisions need no draw.
    #[test]
    fn risky_is_certain_from_6_27_s_and_without_a_vehicle() {
        let model = GapModel::Brewer(brewer("risky"));
        let (mut draws, mut untouched) = (Stream::seeded(1), Stream::seeded(1));
        for time_gap in [Some(6.27), Some(20.0), None] {
            assert!(model.accepts(&asked(time_gap, 0.02), &mut draws));
        }
        assert_eq!(draws.uniform(), untouched.uniform());
    }

    /// Specification §3: "risky" accepts within one second with probability 0.82, 0.987 and 0.99999.
    #[test]
    fn acceptance_within_a_second_does_not_depend_on_the_step() {
        let model = GapModel::Brewer(brewer("risky"));
        let mut draws = Stream::seeded(3);
        let trials = 4000;
        for step in [0.01_f64, 0.02, 0.04, 0.05] {
            for (time_gap, expected) in [(3.0, 0.82), (4.0, 0.987), (5.0, 0.99999)] {
                let asks = (1.0 / step).round() as usize;
                let accepted = (0..trials)
                    .filter(|_| (0..asks).any(|_| model.accepts(&asked(Some(time_gap), step), &mut draws)))
                    .count() as f64
                    / f64::from(trials);
                // Four standard errors of 4000 trials at 0.82, and the rounding of the expected number.
                assert!((accepted - expected).abs() < 0.03, "{step} {time_gap}: {accepted}");
            }
        }
    }

    #[test]
    fn the_late_start_times_the_crossing_to_the_vehicle() {
        let settings = declaration().resolve(&Settings::default()).unwrap();
        let model = GapModel::new(&settings, &Walking::new(&settings), 1.0);
        let mut draws = Stream::seeded(1);
        let mut accepts = |time_gap, undisturbed, passed| {
            model.accepts(&Opportunity { time_gap, undisturbed, passed, step: 0.02 }, &mut draws)
        };
        assert!(accepts(Some(2.75), 0.0, false) && !accepts(Some(2.76), 0.0, false));
        assert!(!accepts(None, 0.98, false) && accepts(None, 1.0, false) && accepts(None, 0.0, true));
    }
}
