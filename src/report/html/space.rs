//! What an optimiser varies and what it looks at, as tables and charts show them.

use crate::metrics::{MetricKind, metric, unit_of};
use crate::optimise::{self, SlicePoint};
use crate::report::chart::{Along, Belief, Quantity};
use crate::report::format::in_unit;
use crate::scenario::{Goal, MetricReference, Objective, Range, RangeValues, Target, significant};

/// An objective or a metric with its unit. Shares are shown in per cent.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    pub name: String,
    unit: String,
}

impl Measured {
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }

    /// Without the word that says which way it is better.
    pub fn objective(objective: &Objective) -> Self {
        let text = objective.text.as_str();
        let name = text.split_once(' ').map_or(text, |(_, aggregate)| aggregate);
        Self::new(name, unit_of(&objective.aggregate))
    }

    /// Single values of a metric; flags are plain numbers.
    pub fn metric(reference: &MetricReference) -> Self {
        let unit = match metric(&reference.name).map(|metric| metric.kind) {
            Some(MetricKind::Quantity(dimension)) => dimension.si_unit(),
            _ => String::new(),
        };
        Self::new(reference.label(), unit)
    }

    /// For the axis of a chart of [`Self::charted`] values.
    pub fn quantity(&self) -> Quantity {
        Quantity::new(&self.name, &self.unit)
    }

    pub fn charted(&self, value: f64) -> f64 {
        if self.unit == "%" { value * 100.0 } else { value }
    }

    /// With its unit; `–` where there is none.
    pub fn text(&self, value: Option<f64>) -> String {
        value.map_or("–".to_string(), |value| in_unit(value, &self.unit))
    }

    /// Without its unit, for a column whose heading has it.
    pub fn number(&self, value: Option<f64>) -> String {
        value.map_or("–".to_string(), |value| significant(self.charted(value), 4))
    }

    /// A difference, with its sign; of shares in percentage points.
    pub fn change(&self, value: f64) -> String {
        let sign = if value > 0.0 { "+" } else { "" };
        let unit = if self.unit == "%" { "points" } else { &self.unit };
        format!("{sign}{} {unit}", significant(self.charted(value), 3)).trim_end().to_string()
    }

    /// In few digits without its unit, for what is less certain than an observed value.
    pub fn rough(&self, value: f64, digits: i32) -> String {
        significant(self.charted(value), digits)
    }

    /// The heading of a column of [`Self::number`]s.
    pub fn heading(&self) -> String {
        self.quantity().label()
    }
}

/// One dimension of a search space.
#[derive(Debug, Clone, PartialEq)]
pub struct Dimension {
    /// As a scenario would name it, such as `av.controller.braking_distance`.
    pub full_name: String,
    /// Without what it belongs to, if that tells it from the others.
    pub name: String,
    unit: String,
    pub along: Along,
}

impl Dimension {
    fn new(range: &Range) -> Self {
        let along = match &range.values {
            RangeValues::Real { low, high } => Along::Numbers { low: *low, high: *high },
            RangeValues::Logarithmic { low, high } => Along::Logarithmic { low: *low, high: *high },
            RangeValues::Whole { low, high } => Along::Numbers { low: *low as f64, high: *high as f64 },
            RangeValues::Words(words) => Along::Words(words.clone()),
        };
        let name = range.target.to_string();
        Self { full_name: name.clone(), name, unit: range.unit.clone(), along }
    }

    pub fn all(over: &[Range]) -> Vec<Self> {
        let names = short_names(&over.iter().map(|range| range.target.clone()).collect::<Vec<_>>());
        over.iter().zip(names).map(|(range, name)| Self { name, ..Self::new(range) }).collect()
    }

    pub fn quantity(&self) -> Quantity {
        Quantity::new(&self.name, &self.unit)
    }

    /// Where a value lies along it; a word at its index.
    pub fn place(&self, value: &optimise::Value) -> Option<f64> {
        match (&self.along, value) {
            (Along::Words(words), optimise::Value::Category(word)) => {
                words.iter().position(|known| known == word).map(|index| index as f64)
            }
            _ => value.number(),
        }
    }

    /// Without its unit, for a column whose heading has it.
    pub fn number(&self, value: &optimise::Value) -> String {
        value.number().map_or_else(|| value.to_string(), |number| significant(number, 4))
    }

    /// Such as `tta 6.5 s`.
    pub fn text(&self, value: &optimise::Value) -> String {
        format!("{} {}", self.name, self.quantity_of(value))
    }

    fn quantity_of(&self, value: &optimise::Value) -> String {
        value.number().map_or_else(|| value.to_string(), |number| in_unit(number, &self.unit))
    }

    /// Such as `tta from 6 s to 18 s`.
    pub fn range(&self) -> String {
        let Self { full_name: name, unit, along, .. } = self;
        match along {
            Along::Numbers { low, high } => {
                format!("{name} from {} to {}", in_unit(*low, unit), in_unit(*high, unit))
            }
            Along::Logarithmic { low, high } => {
                format!("{name} from {} to {} by factors", in_unit(*low, unit), in_unit(*high, unit))
            }
            Along::Words(words) => format!("{name} among {}", words.join(", ")),
        }
    }

    /// A slice along it as a chart shows it.
    pub fn beliefs(&self, slice: &[SlicePoint], of: &Measured) -> Vec<Belief> {
        let belief = |point: &SlicePoint| {
            Some(Belief {
                x: self.place(&point.value)?,
                mean: of.charted(point.mean),
                lower: of.charted(point.lower),
                upper: of.charted(point.upper),
                feasibility: point.feasibility,
            })
        };
        slice.iter().filter_map(belief).collect()
    }
}

/// The names of targets, those of parameters without what they belong to where that tells them apart.
pub fn short_names(targets: &[Target]) -> Vec<String> {
    let short = |target: &Target| match target {
        Target::Variation(name) => name.clone(),
        Target::Setting { parameter, .. } => parameter.clone(),
    };
    let name = |target: &Target| {
        let alone = targets.iter().filter(|other| short(other) == short(target)).count() == 1;
        if alone { short(target) } else { target.to_string() }
    };
    targets.iter().map(name).collect()
}

/// Every dimension of a point in words.
pub fn point_text(dimensions: &[Dimension], point: &[optimise::Value]) -> String {
    let words: Vec<_> = dimensions.iter().zip(point).map(|(one, value)| one.text(value)).collect();
    words.join(", ")
}

/// `1.0` if less of the objective is worth more, `-1.0` if more is: what it is multiplied by, the smallest is best.
pub fn sign(goal: Goal) -> f64 {
    match goal {
        Goal::Minimise => 1.0,
        Goal::Maximise => -1.0,
    }
}
