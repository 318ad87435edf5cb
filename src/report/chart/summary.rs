//! The few statistics that charts show. Verdicts rest on none of them.

/// The quantile at `level` of sorted values, linear between order statistics (type 7 of Hyndman & Fan 1996).
///
/// `None` of nothing.
pub fn quantile(sorted: &[f64], level: f64) -> Option<f64> {
    let place = level * sorted.len().checked_sub(1)? as f64;
    let below = place.floor() as usize;
    let upper = sorted[(below + 1).min(sorted.len() - 1)];
    Some(sorted[below] + (place - below as f64) * (upper - sorted[below]))
}

/// The 95 % score interval of a share (Wilson 1927), for display: `(low, high)` in 0..1.
///
/// `(0, 1)` if nothing was counted.
pub fn wilson(holding: usize, runs: usize) -> (f64, f64) {
    /// The 97.5 % quantile of the standard normal distribution.
    const Z: f64 = 1.959963984540054;
    if runs == 0 {
        return (0.0, 1.0);
    }
    let (n, share) = (runs as f64, holding as f64 / runs as f64);
    let scale = 1.0 + Z * Z / n;
    let middle = (share + Z * Z / (2.0 * n)) / scale;
    let reach = Z / scale * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    let low = if holding == 0 { 0.0 } else { (middle - reach).max(0.0) };
    let high = if holding == runs { 1.0 } else { (middle + reach).min(1.0) };
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_order_statistics() {
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(quantile(&[3.0], 0.9), Some(3.0));
        assert_eq!(quantile(&[1.0, 2.0, 3.0, 4.0], 0.25), Some(1.75));
        assert_eq!(quantile(&[1.0, 2.0, 3.0, 4.0], 1.0), Some(4.0));
    }

    #[test]
    fn wilson_matches_published_values() {
        // Newcombe (1998), Statistics in Medicine 17:857-872, table I, method 3.
        for (holding, runs, low, high) in [
            (81, 263, 0.2553, 0.3662),
            (15, 148, 0.0624, 0.1605),
            (0, 20, 0.0, 0.1611),
            (1, 29, 0.0061, 0.1718),
        ] {
            let interval = wilson(holding, runs);
            assert!(
                (interval.0 - low).abs() < 5e-5 && (interval.1 - high).abs() < 5e-5,
                "{holding} of {runs}: {interval:?}"
            );
        }
    }
}
