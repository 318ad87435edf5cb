//! Whether a claim holds, whatever the runs that were cut off would have come to.

use results::TrendPoint;
use results::judge::ValueSpan;
use scenario::{BinaryOperator, Measured, OutcomesOf, TrendDirection, significant};

/// A number with its unit, which plain numbers take from what they are compared with; or why there is none.
pub struct Operand {
    pub value: Result<f64, String>,
    /// What it could still have come to, where runs were cut off.
    pub span: Result<ValueSpan, String>,
    pub unit: Option<String>,
}

impl Operand {
    pub fn known(value: Result<f64, String>, unit: Option<String>) -> Self {
        Self { span: value.clone().map(ValueSpan::point), value, unit }
    }
}

/// What becomes of two numbers.
pub fn combine(operator: BinaryOperator, left: Operand, right: Operand) -> Operand {
    let unit = match operator {
        BinaryOperator::Add | BinaryOperator::Subtract => left.unit.or(right.unit),
        BinaryOperator::Multiply => match (left.unit, right.unit) {
            (None, unit) | (unit, None) => unit,
            (Some(left), Some(right)) => Some([left, right].join(" ").trim().to_string()),
        },
        BinaryOperator::Divide => match (left.unit, right.unit) {
            (unit, None) => unit,
            (Some(left), Some(right)) if left == right => Some(String::new()),
            (left, Some(right)) => Some(format!("{}/{right}", left.unwrap_or_else(|| "1".to_string()))),
        },
    };
    let apply = |left: f64, right: f64| match operator {
        BinaryOperator::Add => left + right,
        BinaryOperator::Subtract => left - right,
        BinaryOperator::Multiply => left * right,
        BinaryOperator::Divide => left / right,
    };
    let by_nothing = || "a division by 0".to_string();
    let value = left.value.and_then(|left| {
        let value = apply(left, right.value?);
        if value.is_finite() { Ok(value) } else { Err(by_nothing()) }
    });
    let span = left.span.and_then(|left| {
        let right = right.span?;
        if left.is_point() && right.is_point() {
            let value = apply(left.low, right.low);
            return if value.is_finite() { Ok(ValueSpan::point(value)) } else { Err(by_nothing()) };
        }
        if matches!(operator, BinaryOperator::Divide) && right.contains(0.0) {
            return if right.is_point() { Err(by_nothing()) } else { Ok(ValueSpan::ANYTHING) };
        }
        let ends =
            [(left.low, right.low), (left.low, right.high), (left.high, right.low), (left.high, right.high)];
        Ok(ValueSpan::around(ends.map(|(left, right)| apply(left, right))))
    });
    Operand { value, span, unit }
}

/// Whether the values never move the other way and end beyond where they began; `None` where that depends on what the runs
/// that were cut off would have come to.
pub fn follows(
    direction: TrendDirection,
    points: &[TrendPoint],
    spans: &[Option<ValueSpan>],
    variable: &str,
    measured: &Measured,
) -> Result<Option<bool>, String> {
    let of = name_of(&measured.of);
    if points.len() < 2 {
        return Err(format!("{of} has {} values of {variable}; a trend needs two", points.len()));
    }
    let mut upwards = Vec::with_capacity(points.len());
    for (point, span) in points.iter().zip(spans) {
        let missing = || {
            let metric = measured.aggregate.metric().label();
            let at = format!("{variable} {}", point.label);
            format!("`{metric}` exists in too few of the {} runs of {of} at {at}", point.runs)
        };
        let ValueSpan { low, high } = span.ok_or_else(missing)?;
        upwards.push(match direction {
            TrendDirection::Rises => ValueSpan { low, high },
            TrendDirection::Falls => ValueSpan { low: -high, high: -low },
        });
    }
    Ok(rises(&upwards))
}

/// Whether values within these spans never fall and end higher than they began.
fn rises(spans: &[ValueSpan]) -> Option<bool> {
    let [first, .., last] = spans else { return Some(false) };
    if spans.windows(2).all(|pair| pair[1].low >= pair[0].high) && last.low > first.high {
        return Some(true);
    }
    // The lowest that never fall.
    let mut least = f64::NEG_INFINITY;
    let steady = spans.iter().all(|span| {
        least = least.max(span.low);
        least <= span.high
    });
    if steady && last.high > first.low { None } else { Some(false) }
}

/// Such as `between 1 s and 3 s`.
pub fn in_words(span: ValueSpan, unit: &str) -> String {
    let show = |value: f64| match unit {
        "%" => format!("{} %", significant(100.0 * value, 4)),
        "" => significant(value, 4),
        _ => format!("{} {unit}", significant(value, 4)),
    };
    match span {
        ValueSpan { low, high } if low == high => show(low),
        ValueSpan { low, high } if low.is_finite() && high.is_finite() => {
            format!("anything between {} and {}", show(low), show(high))
        }
        ValueSpan { low, .. } if low.is_finite() => format!("anything from {} on", show(low)),
        ValueSpan { high, .. } if high.is_finite() => format!("anything up to {}", show(high)),
        _ => "anything".to_string(),
    }
}

/// As a claim would say it.
pub fn name_of(of: &OutcomesOf) -> String {
    match of {
        OutcomesOf::Scenario(name) | OutcomesOf::Search(name) => format!("`{name}`"),
        OutcomesOf::Condition { evaluate, condition } => format!("`{evaluate}.{condition}`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(low: f64, high: f64) -> ValueSpan {
        ValueSpan { low, high }
    }

    #[test]
    fn a_trend_is_known_where_nothing_that_is_open_could_bend_it() {
        let points = |values: &[f64]| values.iter().copied().map(ValueSpan::point).collect::<Vec<_>>();
        assert_eq!(rises(&points(&[1.0, 1.0, 2.0])), Some(true));
        assert_eq!(rises(&points(&[1.0, 1.0])), Some(false));
        assert_eq!(rises(&points(&[1.0, 3.0, 2.0])), Some(false));
        let open = |at: usize, low, high| {
            let mut all = points(&[1.0, 2.0, 3.0]);
            all[at] = span(low, high);
            rises(&all)
        };
        assert_eq!(open(1, 1.0, 3.0), Some(true));
        assert_eq!(open(1, 0.5, 2.0), None);
        assert_eq!(open(2, 2.0, f64::INFINITY), Some(true));
        assert_eq!(open(2, 0.0, f64::INFINITY), None);
        assert_eq!(open(2, 0.0, 1.5), Some(false));
        // Every two neighbours could still rise, but not all three.
        assert_eq!(rises(&[span(2.0, 3.0), span(0.0, 9.0), span(0.0, 1.0)]), Some(false));
        assert_eq!(rises(&[span(1.0, 2.0), span(1.0, 2.0)]), None);
    }

    #[test]
    fn calculations_keep_what_is_open() {
        let operand = |low, high| Operand { value: Ok(low), span: Ok(span(low, high)), unit: None };
        let of = |operator, left: (f64, f64), right: (f64, f64)| {
            combine(operator, operand(left.0, left.1), operand(right.0, right.1)).span
        };
        assert_eq!(of(BinaryOperator::Subtract, (1.0, 2.0), (0.5, 4.0)), Ok(span(-3.0, 1.5)));
        assert_eq!(of(BinaryOperator::Multiply, (-1.0, 2.0), (3.0, 4.0)), Ok(span(-4.0, 8.0)));
        assert_eq!(of(BinaryOperator::Divide, (1.0, 2.0), (2.0, 4.0)), Ok(span(0.25, 1.0)));
        assert_eq!(of(BinaryOperator::Divide, (1.0, 2.0), (0.0, 4.0)), Ok(ValueSpan::ANYTHING));
        assert_eq!(of(BinaryOperator::Multiply, (0.0, 1.0), (0.0, f64::INFINITY)), Ok(ValueSpan::ANYTHING));
        assert!(of(BinaryOperator::Divide, (1.0, 1.0), (0.0, 0.0)).is_err());
    }
}
