//! What an optimiser varies and what it looks at, as tables and charts show them.

use crate::chart::{Along, AxisQuantity, Belief, Rule};
use crate::format::in_written_unit;
use crate::wording::comparison_rule;
use optimise::{self, SlicePoint};
use scenario::{
    Aggregate, Goal, MetricReference, Notation, Objective, RangeValues, Search, SearchRange, Target,
    significant,
};

/// An objective or a metric with its unit. Shares are shown in per cent.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredQuantity {
    pub name: String,
    /// SI unit.
    unit: String,
    /// The unit that it is shown in, if that is another one.
    written: Option<Notation>,
}

impl MeasuredQuantity {
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into(), written: None }
    }

    /// The same, shown in the unit that somebody wrote.
    pub fn written_in(self, written: Option<Notation>) -> Self {
        Self { written, ..self }
    }

    fn symbol(&self) -> &str {
        self.written.as_ref().map_or(&self.unit, |written| written.symbol.as_str())
    }

    /// Without the word that says which way it is better.
    pub fn objective(objective: &Objective) -> Self {
        let text = objective.text.as_str();
        let name = text.split_once(' ').map_or(text, |(_, aggregate)| aggregate);
        Self::new(name, objective.aggregate.unit()).written_in(objective.notation)
    }

    /// Single values of a metric; flags are plain numbers.
    pub fn metric(reference: &MetricReference) -> Self {
        Self::new(reference.label(), reference.unit())
    }

    /// For the axis of a chart of [`Self::charted`] values.
    pub fn quantity(&self) -> AxisQuantity {
        AxisQuantity::new(&self.name, self.symbol())
    }

    pub fn charted(&self, value: f64) -> f64 {
        match self.written {
            Some(written) => written.of_si(value),
            None if self.unit == "%" => value * 100.0,
            None => value,
        }
    }

    /// The bounds of what a search keeps of its objective, as lines among [`Self::charted`] values of that.
    pub fn kept(&self, search: &Search) -> Vec<Rule> {
        let aggregate = &search.objective.aggregate;
        // A share of runs lies on another axis than what is compared in each.
        if matches!(aggregate, Aggregate::Rate(_) | Aggregate::Count(_)) {
            return Vec::new();
        }
        let about = search.kept_metrics().filter(|(keep, _)| keep.metric == *aggregate.metric());
        let rule = |(keep, written_in)| {
            let Rule { value, label } = comparison_rule(keep, written_in);
            // What is written in a unit is in it already.
            Rule { value: if written_in.is_some() { value } else { self.charted(value) }, label }
        };
        about.map(rule).collect()
    }

    /// With its unit; `–` where there is none.
    pub fn text(&self, value: Option<f64>) -> String {
        value.map_or("–".to_string(), |value| in_written_unit(value, self.written, &self.unit))
    }

    /// Without its unit, for a column whose heading has it.
    pub fn number(&self, value: Option<f64>) -> String {
        value.map_or("–".to_string(), |value| significant(self.charted(value), 4))
    }

    /// A difference, with its sign; of shares in percentage points.
    pub fn change(&self, value: f64) -> String {
        let sign = if value > 0.0 { "+" } else { "" };
        let unit = if self.symbol() == "%" { "points" } else { self.symbol() };
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
pub struct SpaceDimension {
    /// As a scenario would name it, such as `av.controller.braking_distance`.
    pub full_name: String,
    /// Without what it belongs to, if that tells it from the others.
    pub name: String,
    /// SI unit.
    unit: String,
    /// The unit that it is shown in, if that is another one.
    written: Option<Notation>,
    /// In the unit that it is shown in.
    pub along: Along,
}

impl SpaceDimension {
    fn new(range: &SearchRange) -> Self {
        let written = range.notation;
        let shown = |si: f64| written.map_or(si, |written| written.of_si(si));
        let along = match &range.values {
            RangeValues::Real { low, high } => Along::Numbers { low: shown(*low), high: shown(*high) },
            RangeValues::Logarithmic { low, high } => {
                Along::Logarithmic { low: shown(*low), high: shown(*high) }
            }
            RangeValues::Whole { low, high } => Along::Numbers { low: *low as f64, high: *high as f64 },
            RangeValues::Words(words) => Along::Words(words.clone()),
        };
        let name = range.target.to_string();
        Self { full_name: name.clone(), name, unit: range.unit.clone(), written, along }
    }

    pub fn all(over: &[SearchRange]) -> Vec<Self> {
        let names = short_names(&over.iter().map(|range| range.target.clone()).collect::<Vec<_>>());
        over.iter().zip(names).map(|(range, name)| Self { name, ..Self::new(range) }).collect()
    }

    pub fn quantity(&self) -> AxisQuantity {
        AxisQuantity::new(&self.name, self.symbol())
    }

    fn symbol(&self) -> &str {
        self.written.as_ref().map_or(&self.unit, |written| written.symbol.as_str())
    }

    /// In the unit that it is shown in.
    fn shown(&self, value: &optimise::Coordinate) -> Option<f64> {
        let si = value.number()?;
        Some(self.written.map_or(si, |written| written.of_si(si)))
    }

    /// Where a value lies along it; a word at its index.
    pub fn place(&self, value: &optimise::Coordinate) -> Option<f64> {
        match (&self.along, value) {
            (Along::Words(words), optimise::Coordinate::Category(word)) => {
                words.iter().position(|known| known == word).map(|index| index as f64)
            }
            _ => self.shown(value),
        }
    }

    /// As [`Self::place`]; `None` of numbers outside of the range, which charts have no place for.
    pub fn place_within(&self, value: &optimise::Coordinate) -> Option<f64> {
        self.place(value).filter(|place| match self.along {
            Along::Words(_) => true,
            Along::Numbers { low, high } | Along::Logarithmic { low, high } => {
                let rounding = 1e-9 * (high - low);
                (low - rounding..=high + rounding).contains(place)
            }
        })
    }

    /// Without its unit, for a column whose heading has it.
    pub fn number(&self, value: &optimise::Coordinate) -> String {
        self.shown(value).map_or_else(|| value.to_string(), |number| significant(number, 4))
    }

    /// Such as `tta 6.5 s`.
    pub fn text(&self, value: &optimise::Coordinate) -> String {
        format!("{} {}", self.name, self.quantity_of(value))
    }

    fn quantity_of(&self, value: &optimise::Coordinate) -> String {
        self.shown(value).map_or_else(|| value.to_string(), |number| self.with_symbol(number))
    }

    fn with_symbol(&self, shown: f64) -> String {
        format!("{} {}", significant(shown, 4), self.symbol()).trim_end().to_string()
    }

    /// Such as `tta from 6 s to 18 s`.
    pub fn range(&self) -> String {
        let Self { full_name: name, along, .. } = self;
        let ends = |low: f64, high: f64| {
            format!("{name} from {} to {}", self.with_symbol(low), self.with_symbol(high))
        };
        match along {
            Along::Numbers { low, high } => ends(*low, *high),
            Along::Logarithmic { low, high } => ends(*low, *high) + " by factors",
            Along::Words(words) => format!("{name} among {}", words.join(", ")),
        }
    }

    /// A slice along it as a chart shows it.
    pub fn beliefs(&self, slice: &[SlicePoint], of: &MeasuredQuantity) -> Vec<Belief> {
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
pub fn point_text(dimensions: &[SpaceDimension], point: &[optimise::Coordinate]) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::Origin;

    const KMH: Notation =
        Notation { symbol: scenario::Symbol::new("km/h"), numerator: 5.0, denominator: 18.0 };

    #[test]
    fn a_range_is_charted_and_told_in_the_unit_that_it_is_written_in() {
        let range = SearchRange {
            target: Target::Variation("speed".into()),
            values: RangeValues::Real { low: 30.0 / 3.6, high: 60.0 / 3.6 },
            unit: "m/s".into(),
            notation: Some(KMH),
            origin: Origin::default(),
        };
        let dimension = SpaceDimension::new(&range);
        let value = optimise::Coordinate::Real(50.0 / 3.6);
        assert_eq!(dimension.range(), "speed from 30 km/h to 60 km/h");
        assert_eq!((dimension.text(&value), dimension.number(&value)), ("speed 50 km/h".into(), "50".into()));
        assert_eq!(dimension.quantity().label(), "speed (km/h)");
        let Along::Numbers { low, high } = dimension.along else { panic!("{:?}", dimension.along) };
        let place = dimension.place(&value).unwrap();
        assert!((place - 50.0).abs() < 1e-9 && (low - 30.0).abs() < 1e-9 && (high - 60.0).abs() < 1e-9);
    }

    #[test]
    fn a_measure_is_charted_and_told_in_the_unit_that_it_is_compared_in() {
        let speed = MeasuredQuantity::new("mean(impact_speed)", "m/s").written_in(Some(KMH));
        assert_eq!((speed.text(Some(10.0)), speed.number(Some(10.0))), ("36 km/h".into(), "36".into()));
        assert_eq!(
            (speed.change(-1.0), speed.heading()),
            ("-3.6 km/h".into(), "mean(impact_speed) (km/h)".into())
        );
        assert_eq!(speed.charted(10.0), 36.0);
        let share = MeasuredQuantity::new("rate(collision)", "%");
        assert_eq!((share.text(Some(0.85)), share.change(0.05)), ("85 %".into(), "+5 points".into()));
    }
}
