//! How something went so far, as a row of small bars.

const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// A bar for each value, of many for as many as there are columns the last of each share; the lowest is lowest and the highest highest, and
/// where all are the same all are low. Of fewer than two different numbers of values there is nothing to see: it is empty.
pub(super) fn sparkline(values: &[f64], columns: usize) -> String {
    let values: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    let columns = columns.min(values.len());
    if columns < 2 {
        return String::new();
    }
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let bar = |value: f64| {
        // Halves, since the whole of two large numbers may be infinite.
        let share = if high > low { (value / 2.0 - low / 2.0) / (high / 2.0 - low / 2.0) } else { 0.0 };
        BARS[((share * (BARS.len() - 1) as f64).round() as usize).min(BARS.len() - 1)]
    };
    (1..=columns).map(|column| bar(values[(column * values.len()).div_ceil(columns) - 1])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_bars() {
        assert_eq!(sparkline(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], 8), "▁▂▃▄▅▆▇█");
        assert_eq!(sparkline(&[3.0, 2.0, 1.0], 12), "█▅▁");
        assert_eq!(sparkline(&[2.0, 2.0], 12), "▁▁");
        assert_eq!(sparkline(&[-1e308, 1e308], 2), "▁█");
    }

    #[test]
    fn of_many_values_the_last_is_seen() {
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        let line = sparkline(&values, 10);
        assert_eq!((line.chars().count(), line.chars().last()), (10, Some('█')));
        assert!(line.chars().collect::<Vec<_>>().is_sorted(), "{line}");
    }

    #[test]
    fn of_what_is_no_number_nothing_is_drawn() {
        assert_eq!(sparkline(&[], 8), "");
        assert_eq!(sparkline(&[1.0], 8), "");
        assert_eq!(sparkline(&[f64::NAN, 1.0, f64::INFINITY], 8), "");
        assert_eq!(sparkline(&[f64::NAN, 1.0, 2.0], 8), "▁█");
    }
}
