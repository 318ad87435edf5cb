//! What is known of a metric without measuring it: what its number means, for whom, and between what limits it lies.

use serde::{Deserialize, Serialize};
use std::any::Any;
use std::fmt;
use std::sync::Arc;

use super::{Declaration, Dimension, Registered, Settings, Text};

/// A metric as those see it who judge, compare and show its values.
#[derive(Debug, Clone)]
pub struct Metric {
    /// Its name and parameters.
    pub declaration: Declaration,
    /// What its number means.
    pub kind: MetricKind,
    /// Whom it is measured for.
    pub scope: Scope,
    /// Which of several values, one per pair, is the one that counts for the run.
    pub worst: Worst,
    /// What it says of a run that the metric does not exist in it.
    pub absence: Absence,
    /// Between what limits its values lie.
    pub range: MetricRange,
    /// What has to happen in a run before its values say anything of a vehicle.
    pub stake: Stake,
    /// How it is measured.
    pub meters: Meters,
}

/// How a metric is measured: known to those who measure, and to nobody who judges, compares or shows its values.
#[derive(Clone)]
pub struct Meters(Arc<dyn Any + Send + Sync>);

impl Meters {
    /// What [`Self::get`] gives out again. See `sim::measure::meters`, which makes all that there are.
    pub fn new<T: Any + Send + Sync>(build: T) -> Self {
        Self(Arc::new(build))
    }

    /// What it was made of, if that is a `T`.
    pub fn get<T: Any>(&self) -> Option<&T> {
        self.0.downcast_ref()
    }
}

impl fmt::Debug for Meters {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("Meters")
    }
}

/// What a metric's number means.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MetricKind {
    /// In the SI unit of this dimension.
    Quantity(Dimension),
    /// 1 for true, 0 for false.
    Flag,
    /// The index of one of these words.
    Category(Vec<Text>),
}

/// Whom a metric is measured for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// A vehicle and a pedestrian.
    Pair,
    /// A stream and a pedestrian.
    Stream,
    /// A vehicle and anything solid: a pedestrian, another vehicle or a box.
    Contact,
    /// A vehicle and another vehicle.
    Vehicles,
    /// Each vehicle.
    Vehicle,
    /// Each pedestrian.
    Pedestrian,
}

/// Which of two values counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Worst {
    /// The smaller.
    Smallest,
    /// The larger.
    Largest,
    /// Neither is worse: no gate compares it, and the larger is named.
    Neither,
}

/// What it says of a run that a metric does not exist in it, for criteria and for comparisons of runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Absence {
    /// The danger that it measures never arose.
    Good,
    /// Somebody never got to the end.
    Bad,
    /// Neither for sure, or it exists in every run.
    Open,
}

/// What has to happen in a run before a value of a metric puts anything to the test: between a vehicle and a pedestrian, unless said
/// otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stake {
    /// They met.
    Meeting,
    /// They met; where a claim demands a bound of 5 s or more, the pedestrian was in the vehicle's way.
    MeetingInTime,
    /// They met, or the vehicle passed the pedestrian.
    MeetingOrPassing,
    /// The pedestrian was in the vehicle's way.
    Entry,
    /// Both were there together, and the metric says which of them goes first: what holds of it says that the pedestrian may stay away.
    Order,
    /// Both were there together.
    Company,
    /// The vehicle moved while it was together with a pedestrian, or its scenario has none.
    Motion,
    /// The metric exists: it says by itself whether anything was at stake.
    Value,
    /// Two vehicles that are named together had to do with each other.
    Vehicles,
    /// The pedestrian appeared.
    Appearance,
}

/// How a metric is limited: by what can happen, not by what is likely.
#[derive(Debug, Clone, PartialEq)]
pub enum MetricRange {
    /// A time within the run: 0 up to where it ends.
    WithinRun,
    /// The same, up to what this parameter says, if it says anything.
    WithinRunUpTo(Text),
    /// 0 up to what this parameter says.
    UpTo(Text),
    /// A difference of two speeds: 0 up to twice the fastest.
    TwoSpeeds,
    /// A drop of speed, down to what one parameter says, over the time that another says: 0 up to that of the fastest.
    DropWithin {
        /// The parameter that says over which time, s.
        window: Text,
        /// The parameter that says down to which speed, m/s.
        floor: Text,
    },
    /// Whether such a drop is above what a parameter says: 0 or 1, or always 0 where none can be.
    DropAbove {
        /// The parameter that says what it must be above, m/s.
        threshold: Text,
        /// The parameter that says over which time, s.
        window: Text,
        /// The parameter that says down to which speed, m/s.
        floor: Text,
    },
    /// 0 or 1.
    YesOrNo,
    /// From 0 to 1.
    Share,
    /// 0 or more: nothing keeps it from being as large as one likes.
    NotNegative,
    /// Nothing keeps it from being as large as one likes, or as small.
    Unlimited,
}

/// No road user of a scenario may be faster, m/s.
const FASTEST: f64 = 100.0;

impl MetricRange {
    /// In words, with the names of parameters in backquotes; `None` where there are no limits.
    pub fn in_words(&self) -> Option<String> {
        match self {
            Self::WithinRun => Some("0 s to the horizon of the scenario".to_string()),
            Self::WithinRunUpTo(parameter) => {
                Some(format!("0 s to the horizon of the scenario, or to `{parameter}`"))
            }
            Self::UpTo(parameter) => Some(format!("0 to `{parameter}`")),
            Self::TwoSpeeds => Some(format!("0 m/s to {} m/s", 2.0 * FASTEST)),
            Self::DropWithin { window, floor } => {
                Some(format!("0 to what lies between {FASTEST} m/s and `{floor}`, over `{window}`"))
            }
            Self::Share => Some("0 to 1".to_string()),
            Self::YesOrNo | Self::DropAbove { .. } | Self::NotNegative | Self::Unlimited => None,
        }
    }
}

impl Metric {
    /// Whether it says how one vehicle and one pedestrian came one after the other. Among many vehicles the worst of such values is of
    /// one that nobody meant.
    pub fn tells_order(&self) -> bool {
        self.scope == Scope::Pair
            && match self.stake {
                Stake::Order | Stake::MeetingInTime => true,
                // How near the vehicle was then, but not how long something took.
                Stake::Entry => self.worst == Worst::Smallest,
                _ => false,
            }
    }

    /// The SI unit of its values; nothing for those that are no quantities.
    pub fn unit(&self) -> String {
        match &self.kind {
            MetricKind::Quantity(dimension) => dimension.si_unit(),
            MetricKind::Flag | MetricKind::Category(_) => String::new(),
        }
    }

    /// Between what limits it lies with these settings in runs of at most `longest` s, in its own unit; `None` if it
    /// has none.
    pub fn limits(&self, given: &Settings, longest: f64) -> Option<(f64, f64)> {
        let settings = self.declaration.resolve(given).ok()?;
        let high = match &self.range {
            MetricRange::WithinRun => longest,
            MetricRange::WithinRunUpTo(parameter) => {
                settings.optional_number(parameter).map_or(longest, |most| most.min(longest))
            }
            MetricRange::UpTo(parameter) => settings.number(parameter),
            MetricRange::TwoSpeeds => 2.0 * FASTEST,
            MetricRange::DropWithin { window, floor } => hardest(&settings, window, floor),
            MetricRange::DropAbove { threshold, window, floor } => {
                f64::from(hardest(&settings, window, floor) > settings.number(threshold))
            }
            MetricRange::YesOrNo | MetricRange::Share => 1.0,
            MetricRange::NotNegative | MetricRange::Unlimited => return None,
        };
        Some((0.0, high))
    }
}

/// The hardest braking that there can be, m/s².
fn hardest(settings: &Settings, window: &str, floor: &str) -> f64 {
    (FASTEST - settings.number(floor)).max(0.0) / settings.number(window)
}

impl Registered for Metric {
    fn declaration(&self) -> &Declaration {
        &self.declaration
    }
}
