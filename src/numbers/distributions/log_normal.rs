//! The log-normal distribution: of positive numbers whose logarithms are normal.

use super::normal;

/// A log-normal distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogNormal {
    /// Half of all values lie below: larger than 0.
    pub median: f64,
    /// Standard deviation of the natural logarithm: at least 0.
    pub sigma: f64,
}

impl LogNormal {
    /// The value that a share of all lies below: 0 < `share` < 1.
    pub fn quantile(self, share: f64) -> f64 {
        self.median * libm::exp(self.sigma * normal::quantile(share))
    }

    /// The share of values whose density is no higher than at `value`; `sigma` is above 0. The densest value is median · exp(−sigma²), and
    /// as dense as another is the one whose logarithm lies as far on its other side.
    pub fn tail(self, value: f64) -> f64 {
        let Self { median, sigma } = self;
        if value <= 0.0 {
            return 0.0;
        }
        let apart = (libm::log(value / median) / sigma + sigma).abs();
        (normal::cumulative(-apart - sigma) + normal::cumulative(sigma - apart)).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{ContinuousCDF, LogNormal as Other};

    use super::*;

    #[test]
    fn quantiles_are_where_another_implementation_has_its_shares() {
        for (median, sigma) in [(1.0_f64, 0.25_f64), (3.5, 1.0), (0.02, 2.0)] {
            let other = Other::new(median.ln(), sigma).unwrap();
            for share in [1e-9, 1e-3, 0.1, 0.5, 0.8, 0.999, 1.0 - 1e-9] {
                let back = other.cdf(LogNormal { median, sigma }.quantile(share));
                assert!((back - share).abs() < 1e-9 * share.min(1.0 - share).max(1e-3), "{share} {back}");
            }
        }
        assert_eq!(LogNormal { median: 2.0, sigma: 0.7 }.quantile(0.5), 2.0);
    }
}
