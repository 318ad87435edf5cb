//! A metric of a run, and its comparison with a bound.

use serde::{Deserialize, Serialize};

use super::{Dimension, Expression, Metric, Notation, Reference, Settings, TrafficStream, Value, show};

/// A metric of one run compared to a bound.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// What is measured.
    pub metric: MetricReference,
    /// How the two must compare.
    pub relation: Relation,
    /// SI units; flags compare to 0 and 1, categories to the index of their word.
    pub bound: Expression,
    /// What it says of a run in which the metric does not exist.
    pub when_undefined: WhenUndefined,
}

/// What a comparison says of a run in which its metric does not exist.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WhenUndefined {
    /// What the metric says of itself: better than any value, worse than any, or, where neither is sure, whatever speaks
    /// against the criterion.
    #[default]
    AsDeclared,
    /// It does not hold there.
    Fails,
    /// It holds there.
    Passes,
}

/// A metric, with what it is measured with and for whom.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MetricReference {
    /// The entry of the registry.
    #[serde(rename = "name")]
    pub metric: Reference<Metric>,
    /// Given parameters only; the metric's declaration has the defaults.
    #[serde(default)]
    pub settings: Settings,
    /// Restricts to one vehicle and one pedestrian by name; otherwise the worst pair counts. Of a vehicle and what it
    /// touches, the second may also be a vehicle or a box, or empty: whatever it touches.
    #[serde(default)]
    pub pair: Option<(String, String)>,
    /// Where it is about several people, such as a group, their names: the worst of them counts, and the second name of the pair
    /// is what they are called together. Else empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub several: Vec<String>,
    /// Whether the first name of the pair is that of a stream: of its vehicles the worst counts, unless the metric is of streams.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub of_stream: bool,
}

/// How two numbers compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    /// `<`
    Less,
    /// `<=`
    LessOrEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterOrEqual,
    /// `==`
    Equal,
    /// `!=`
    NotEqual,
}

impl Relation {
    /// Whether `left` compares to `right` so; with NaN nothing but [`Self::NotEqual`] holds.
    pub fn holds(self, left: f64, right: f64) -> bool {
        match self {
            Self::Less => left < right,
            Self::LessOrEqual => left <= right,
            Self::Greater => left > right,
            Self::GreaterOrEqual => left >= right,
            Self::Equal => left == right,
            Self::NotEqual => left != right,
        }
    }

    /// The relation that holds exactly where this one does not.
    pub fn opposite(self) -> Self {
        match self {
            Self::Less => Self::GreaterOrEqual,
            Self::LessOrEqual => Self::Greater,
            Self::Greater => Self::LessOrEqual,
            Self::GreaterOrEqual => Self::Less,
            Self::Equal => Self::NotEqual,
            Self::NotEqual => Self::Equal,
        }
    }

    /// As scenarios write it: `<=`.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Less => "<",
            Self::LessOrEqual => "<=",
            Self::Greater => ">",
            Self::GreaterOrEqual => ">=",
            Self::Equal => "=",
            Self::NotEqual => "!=",
        }
    }

    /// How far `value` is on the passing side of `bound` (negative: failing), in the metric's unit; `None` for
    /// equality, which has no distance.
    pub fn margin(self, value: f64, bound: f64) -> Option<f64> {
        match self {
            Self::Less | Self::LessOrEqual => Some(bound - value),
            Self::Greater | Self::GreaterOrEqual => Some(value - bound),
            Self::Equal | Self::NotEqual => None,
        }
    }
}

impl MetricReference {
    /// A metric with its defaults, for everybody.
    pub fn plain(metric: impl Into<Reference<Metric>>) -> Self {
        let settings = Settings::default();
        Self { metric: metric.into(), settings, pair: None, several: Vec::new(), of_stream: false }
    }

    /// As scenarios call the metric.
    pub fn name(&self) -> &str {
        self.metric.name()
    }

    /// What is known of the metric; `None` if it is only a name yet.
    pub fn known(&self) -> Option<&Metric> {
        self.metric.known()
    }

    /// The SI unit of its values; nothing for those that are no quantities.
    pub fn unit(&self) -> String {
        self.known().map(Metric::unit).unwrap_or_default()
    }

    /// Whether it is about a vehicle of this name: the one that it names, one of the stream that it names, or any.
    pub fn is_of_vehicle(&self, name: &str) -> bool {
        let Some((first, _)) = &self.pair else { return true };
        if self.of_stream {
            TrafficStream::of_member(name).is_some_and(|(stream, _)| stream == first)
        } else {
            first == name
        }
    }

    /// The name of the stream that it names.
    pub fn stream(&self) -> Option<&str> {
        self.pair.as_ref().filter(|_| self.of_stream).map(|(stream, _)| stream.as_str())
    }

    /// Whether it is about somebody or something of this name where it is about a pair, or about everybody.
    pub fn is_of(&self, other: &str) -> bool {
        let Some((_, second)) = &self.pair else { return true };
        if self.several.is_empty() {
            second.is_empty() || second == other
        } else {
            self.several.iter().any(|one| one == other)
        }
    }

    /// Whether it is the same metric of those who are called the same: a group may have other members in another scenario, and
    /// a stream there be a vehicle here.
    pub fn is_same(&self, other: &Self) -> bool {
        let Self { metric, settings, pair, several: _, of_stream: _ } = self;
        *metric == other.metric && *settings == other.settings && *pair == other.pair
    }

    /// Makes it about those as well whom another reference, [the same](Self::is_same) but for them, is about.
    pub fn join(&mut self, other: &Self) {
        if self.several == other.several {
            return;
        }
        let lone = |one: &Self| {
            one.pair.iter().filter(|_| one.several.is_empty()).map(|(_, name)| name.clone()).next()
        };
        let (own, theirs) = (lone(self), lone(other));
        for name in own.iter().chain(&theirs).chain(&other.several) {
            if !self.several.contains(name) {
                self.several.push(name.clone());
            }
        }
    }

    /// The name that reports give it: `pet`, `max_deceleration(window=0.5)` or `pet(av, walker)`.
    pub fn label(&self) -> String {
        let settings = self.settings.0.iter().map(|(name, value)| format!("{name}={value}"));
        let pair = self.pair.iter().flat_map(|(vehicle, other)| [vehicle.clone(), other.clone()]);
        let pair = pair.filter(|name| !name.is_empty());
        let inside: Vec<_> = pair.chain(settings).collect();
        if inside.is_empty() {
            self.name().to_string()
        } else {
            format!("{}({})", self.name(), inside.join(", "))
        }
    }
}

impl Comparison {
    /// In words, with the bound in `unit`, such as `pet >= 1.5 s`; without a unit in SI units.
    pub fn text(&self, unit: Option<Notation>) -> String {
        let bound = show(self.constant_bound(), unit, Dimension::NUMBER);
        format!("{} {} {bound}", self.metric.label(), self.relation.symbol())
    }

    /// The bound once it is a constant, as it is in every plan and in `search` and `tune` blocks; flags as 0 and 1.
    pub fn constant_bound(&self) -> f64 {
        constant(&self.bound)
    }
}

/// The number of an expression that is a constant.
///
/// # Panics
/// If it is not: evaluating bounds before they are used is the plan's and the checker's promise.
pub fn constant(bound: &Expression) -> f64 {
    match bound {
        Expression::Constant(Value::Number(number)) => *number,
        Expression::Constant(Value::Flag(flag)) => f64::from(*flag),
        other => panic!("every bound is evaluated before it is used, but this is left: {other:?}"),
    }
}
