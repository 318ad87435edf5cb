//! Summaries of values: mean, spread, median and quantiles.

/// `None` of no values.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The sample standard deviation (divisor n - 1); `None` of fewer than two values.
pub fn std(values: &[f64]) -> Option<f64> {
    variance(values).map(f64::sqrt)
}

/// The square of the standard error of the mean; `None` of fewer than two values.
pub fn variance_of_mean(values: &[f64]) -> Option<f64> {
    variance(values).map(|variance| variance / values.len() as f64)
}

fn variance(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    Some(squares / (values.len() - 1) as f64)
}

/// The median of sorted values: the middle one, or the middle of both, rounded once; `None` of none.
pub fn median(sorted: &[f64]) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let (low, high) = (sorted[last / 2], sorted[sorted.len() / 2]);
    // Halves first: the sum of two large numbers may be too large.
    Some(if low == high { low } else { 0.5 * low + 0.5 * high })
}

/// The median of values in any order.
pub fn median_of(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    median(&sorted)
}

/// The quantile at `level` (0..1) of sorted values, linear between order statistics, at 0.5 the [`median`]; `None` of none.
///
/// Source: type 7 of R. J. Hyndman & Y. Fan, Am. Stat. 50, 1996.
pub fn quantile(sorted: &[f64], level: f64) -> Option<f64> {
    if level == 0.5 {
        return median(sorted);
    }
    let last = sorted.len().checked_sub(1)?;
    let place = level * last as f64;
    let below = place.floor() as usize;
    let (low, high) = (sorted[below], sorted[(below + 1).min(last)]);
    // Values may be infinite, as those of runs that never got to the end.
    Some(if low == high || place == below as f64 { low } else { low + (place - below as f64) * (high - low) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    #[test]
    fn aggregates_of_few_values() {
        assert_eq!((mean(&[]), std(&[1.0]), median(&[])), (None, None, None));
        assert_eq!(mean(&[1.0, 2.0, 6.0]), Some(3.0));
        assert_eq!(std(&[1.0, 3.0]), Some(2.0_f64.sqrt()));
        assert_eq!(median(&[1.0, 2.0, 4.0, 9.0]), Some(3.0));
        assert_eq!(quantile(&[1.0, 2.0, 3.0, 4.0, 5.0], 0.9), Some(4.6));
        assert_eq!(quantile(&[7.0], 1.0), Some(7.0));
    }

    #[test]
    fn spreads_by_hand() {
        // Squares of -2, -1, 3 add up to 14.
        assert_eq!(variance_of_mean(&[1.0, 2.0, 6.0]), Some(7.0 / 3.0));
        assert_eq!((variance_of_mean(&[1.0]), variance_of_mean(&[])), (None, None));
    }

    #[test]
    fn the_median_is_the_nearest_number_to_the_middle() {
        assert_eq!(median_of(&[9.0, 1.0, 4.0, 2.0]), Some(3.0));
        assert_eq!(median_of(&[5.0, -1.0, 2.0]), Some(2.0));
        // Numbers of [1/4, 1) are whole at 2^54, where their sum is exact and converted with one rounding.
        let mut stream = Stream::seeded(2);
        let mut rounded_twice = 0;
        for _ in 0..1000 {
            let (low, high) =
                (0.5 * stream.uniform_in(0.25, 1.0).sqrt(), stream.uniform_in(0.25, 1.0).sqrt());
            let whole = |number: f64| (number * 2f64.powi(54)) as i64;
            let exact = (whole(low) + whole(high)) as f64 / 2f64.powi(55);
            assert_eq!(median(&[low, high]), Some(exact));
            rounded_twice += i32::from(low + 0.5 * (high - low) != exact);
        }
        assert!(rounded_twice > 0);
        assert_eq!(median(&[-f64::MAX, f64::MAX]), Some(0.0));
        assert_eq!(median(&[f64::MAX, f64::MAX]), Some(f64::MAX));
        assert_eq!(median(&[1.0, f64::INFINITY]), Some(f64::INFINITY));
        assert_eq!(median(&[f64::INFINITY, f64::INFINITY]), Some(f64::INFINITY));
    }

    #[test]
    fn the_median_is_the_quantile_at_one_half() {
        let mut stream = Stream::seeded(6);
        for count in 1..40 {
            let mut values: Vec<f64> = (0..count).map(|_| stream.normal()).collect();
            values.sort_by(f64::total_cmp);
            assert_eq!(quantile(&values, 0.5), median(&values));
            // As many on either side.
            let middle = median(&values).unwrap();
            let below = values.iter().filter(|value| **value < middle).count();
            assert_eq!(below, values.iter().filter(|value| **value > middle).count());
        }
    }
}
