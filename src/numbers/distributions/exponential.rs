//! The exponential distribution: of the time between events that know nothing of each other.

/// The value that a share of all lies below where they are `mean` on average: 0 < `share` < 1.
pub fn exponential_quantile(share: f64, mean: f64) -> f64 {
    -mean * libm::log1p(-share)
}

/// The share of values that are no likelier than `value`: those that are as large.
pub fn exponential_tail(value: f64, mean: f64) -> f64 {
    if value < 0.0 { 0.0 } else { libm::exp(-value / mean) }
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{ContinuousCDF, Exp};

    use super::*;

    #[test]
    fn quantiles_are_where_another_implementation_has_its_shares() {
        for mean in [0.2, 1.0, 37.5] {
            let other = Exp::new(1.0 / mean).unwrap();
            for share in [1e-12, 1e-3, 0.1, 0.5, 0.8, 0.999, 1.0 - 1e-9] {
                let back = other.cdf(exponential_quantile(share, mean));
                assert!(
                    (back - share).abs() < 1e-12 * (1.0 + share / (1.0 - share) * 1e-3),
                    "{share} {back}"
                );
            }
        }
        // Half are below ln 2 of the mean.
        assert!((exponential_quantile(0.5, 2.0) - 2.0 * std::f64::consts::LN_2).abs() < 1e-15);
    }
}
