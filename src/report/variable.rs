//! A variation as an axis: its numbers in the unit that the user wrote them in.

use super::chart::AxisQuantity;
use results::SuiteReport;
use scenario::Assignment;

/// A variation that takes numbers, over all the trials that have it.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    pub quantity: AxisQuantity,
    name: String,
    /// What the quantity's unit is in SI units.
    unit_size: f64,
}

impl Variable {
    /// The first variation of the suite that takes at least two different numbers.
    pub fn of(report: &SuiteReport) -> Option<Self> {
        let assignments = || report.trials.iter().flat_map(|trial| &trial.trial.variation);
        let mut names: Vec<&str> = Vec::new();
        for assignment in assignments() {
            if !names.contains(&assignment.name.as_str()) {
                names.push(&assignment.name);
            }
        }
        names.into_iter().find_map(|name| {
            let taken: Vec<&Assignment> = assignments().filter(|one| one.name == name).collect();
            let numbers: Vec<f64> = taken.iter().filter_map(|one| one.value.as_number()).collect();
            if numbers.len() < taken.len() || numbers.iter().all(|number| *number == numbers[0]) {
                return None;
            }
            let (unit, unit_size) = common_unit(&taken).unwrap_or_default();
            Some(Self {
                quantity: AxisQuantity::new(name, unit),
                name: name.to_string(),
                unit_size: if unit_size == 0.0 { 1.0 } else { unit_size },
            })
        })
    }

    /// Its value in a trial, in the quantity's unit.
    pub fn value(&self, variation: &[Assignment]) -> Option<f64> {
        let assignment = variation.iter().find(|one| one.name == self.name)?;
        assignment.value.as_number().map(|number| number / self.unit_size)
    }

    /// The other variations: `profile=cautious`; empty if there are none.
    pub fn others(&self, variation: &[Assignment]) -> String {
        let others = variation.iter().filter(|one| one.name != self.name);
        others.map(|one| format!("{}={}", one.name, one.label)).collect::<Vec<_>>().join(" ")
    }
}

/// The unit that all labels end in and its size in SI units, if there is one such.
pub(super) fn common_unit(taken: &[&Assignment]) -> Option<(String, f64)> {
    let mut common: Option<(&str, f64)> = None;
    for one in taken {
        let label = one.label.split('#').next().unwrap_or_default();
        let split =
            label.find(|letter: char| !matches!(letter, '0'..='9' | '.' | '-' | '+')).unwrap_or(label.len());
        let (number, unit) = label.split_at(split);
        let number: f64 = number.parse().ok()?;
        let value = one.value.as_number()?;
        if number == 0.0 {
            continue;
        }
        let size = value / number;
        match common {
            None => common = Some((unit.trim(), size)),
            // Labels are rounded, so sizes agree only nearly.
            Some((known, known_size)) if known == unit.trim() && (size / known_size - 1.0).abs() < 1e-3 => {}
            Some(_) => return None,
        }
    }
    // A size of about one is one: labels are rounded.
    common.map(|(unit, size)| (unit.to_string(), if (size - 1.0).abs() < 1e-3 { 1.0 } else { size }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::Value;

    fn unit(labels: &[(&str, f64)]) -> Option<(String, f64)> {
        let taken: Vec<Assignment> = labels
            .iter()
            .map(|(label, value)| Assignment {
                name: "x".into(),
                label: label.to_string(),
                value: Value::Number(*value),
            })
            .collect();
        common_unit(&taken.iter().collect::<Vec<_>>())
    }

    #[test]
    fn axes_are_in_the_unit_that_was_written() {
        assert_eq!(unit(&[("6s", 6.0), ("10 s", 10.0)]), Some(("s".into(), 1.0)));
        assert_eq!(unit(&[("36km/h", 10.0), ("0km/h", 0.0)]), Some(("km/h".into(), 1.0 / 3.6)));
        assert_eq!(unit(&[("6.1235s#2", 6.123456)]), Some(("s".into(), 1.0)));
        assert_eq!(unit(&[("6s", 6.0), ("200ms", 0.2)]), None);
        assert_eq!(unit(&[("fast", 6.0)]), None);
    }
}
