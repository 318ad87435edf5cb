//! Between what limits a metric lies, whatever happens in a run: what bounds on its mean rest on.

use super::metric;
use crate::scenario::{MetricReference, Settings};

/// How a metric is limited. Limits are those of what can happen, not of what is likely.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// A time within the run: 0 up to where it ends.
    WithinRun,
    /// 0 up to what this parameter says.
    UpTo(&'static str),
    /// A difference of two speeds: 0 up to twice the fastest.
    TwoSpeeds,
    /// A drop of speed, down to what one parameter says, over the time that another says: 0 up to that of the fastest.
    DropWithin { window: &'static str, floor: &'static str },
    /// Whether such a drop is above what a parameter says: 0 or 1, or always 0 where none can be.
    DropAbove { threshold: &'static str, window: &'static str, floor: &'static str },
    /// 0 or 1.
    YesOrNo,
    /// 0 or more: nothing keeps it from being as large as one likes.
    NotNegative,
    /// Nothing keeps it from being as large as one likes, or as small.
    Unlimited,
}

/// No road user of a scenario may be faster, m/s.
const FASTEST: f64 = 100.0;

impl Range {
    /// In words, with the names of parameters in backquotes; `None` where there are no limits.
    pub fn in_words(self) -> Option<String> {
        match self {
            Self::WithinRun => Some("0 s to the horizon of the scenario".to_string()),
            Self::UpTo(parameter) => Some(format!("0 to `{parameter}`")),
            Self::TwoSpeeds => Some(format!("0 m/s to {} m/s", 2.0 * FASTEST)),
            Self::DropWithin { window, floor } => {
                Some(format!("0 to what lies between {FASTEST} m/s and `{floor}`, over `{window}`"))
            }
            Self::YesOrNo | Self::DropAbove { .. } | Self::NotNegative | Self::Unlimited => None,
        }
    }
}

/// The limits of a metric in runs of at most `longest` s, in its own unit; `None` if it has none.
pub fn limits(reference: &MetricReference, longest: f64) -> Option<(f64, f64)> {
    let metric = metric(&reference.name)?;
    let settings = metric.declaration.resolve(&reference.settings).ok()?;
    let high = match metric.range {
        Range::WithinRun => longest,
        Range::UpTo(parameter) => settings.number(parameter),
        Range::TwoSpeeds => 2.0 * FASTEST,
        Range::DropWithin { window, floor } => hardest(&settings, window, floor),
        Range::DropAbove { threshold, window, floor } => {
            f64::from(hardest(&settings, window, floor) > settings.number(threshold))
        }
        Range::YesOrNo => 1.0,
        Range::NotNegative | Range::Unlimited => return None,
    };
    Some((0.0, high))
}

/// The hardest braking that there can be, m/s².
fn hardest(settings: &Settings, window: &str, floor: &str) -> f64 {
    (FASTEST - settings.number(floor)).max(0.0) / settings.number(window)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::{METRICS, MetricKind};
    use crate::scenario::Value;

    fn of(name: &str, settings: Settings) -> Option<(f64, f64)> {
        limits(&MetricReference { name: name.into(), settings, pair: None }, 60.0)
    }

    #[test]
    fn limits_follow_the_run_and_the_parameters() {
        assert_eq!(of("stopped_time", Settings::default()), Some((0.0, 60.0)));
        assert_eq!(of("drac", Settings::default()), Some((0.0, 20.0)));
        assert_eq!(of("drac", Settings::from([("ceiling", Value::Number(9.0))])), Some((0.0, 9.0)));
        assert_eq!(of("max_deceleration", Settings::default()), Some((0.0, 495.0)));
        assert_eq!(of("min_ttc", Settings::default()), None);
    }

    #[test]
    fn what_a_metric_is_blind_to_by_its_parameters_is_no_value_of_it() {
        let number = |name: &'static str, value| Settings::from([(name, Value::Number(value))]);
        assert_eq!(of("max_deceleration", number("standstill", 100.0)), Some((0.0, 0.0)));
        assert_eq!(of("sudden_speed_change", number("standstill", 100.0)), Some((0.0, 0.0)));
        assert_eq!(of("sudden_speed_change", number("window", 10.0)), Some((0.0, 1.0)));
        let slow = Settings::from([("window", Value::Number(10.0)), ("threshold", Value::Number(9.9))]);
        assert_eq!(of("sudden_speed_change", slow), Some((0.0, 0.0)));
        assert_eq!(of("sudden_speed_change", Settings::default()), Some((0.0, 1.0)));
    }

    #[test]
    fn every_metric_has_limits_of_its_kind() {
        for metric in METRICS {
            let yes_or_no = matches!(metric.range, Range::YesOrNo | Range::DropAbove { .. });
            assert_eq!(yes_or_no, metric.kind == MetricKind::Flag, "{}", metric.declaration.name);
        }
    }
}
