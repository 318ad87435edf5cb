//! The triangular distribution: between two ends, likeliest at a mode and less and less likely away from it.

/// A triangular distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangular {
    /// The low end.
    pub low: f64,
    /// The likeliest value, between the ends.
    pub mode: f64,
    /// The high end, at least `low`.
    pub high: f64,
}

impl Triangular {
    /// The value that a share of all lies below: 0 < `share` < 1.
    pub fn quantile(self, share: f64) -> f64 {
        let Self { low, mode, high } = self;
        let width = high - low;
        if width == 0.0 {
            return low;
        }
        // The density rises and falls in straight lines, so that shares grow as squares from either end.
        let value = if share * width < mode - low {
            low + (share * width * (mode - low)).sqrt()
        } else {
            high - ((1.0 - share) * width * (high - mode)).sqrt()
        };
        value.clamp(low, high)
    }

    /// The share of values whose density is no higher than at `value`: 0 outside of the ends, and all where these are one.
    pub fn tail(self, value: f64) -> f64 {
        let Self { low, mode, high } = self;
        if !(low..=high).contains(&value) {
            return 0.0;
        }
        // Of the height at the mode: below it lie two triangles that are smaller by as much in both directions.
        let height = if value < mode {
            (value - low) / (mode - low)
        } else if value > mode {
            (high - value) / (high - mode)
        } else {
            1.0
        };
        height * height
    }
}

#[cfg(test)]
mod tests {
    use statrs::distribution::{ContinuousCDF, Triangular as Other};

    use super::*;

    #[test]
    fn quantiles_are_where_another_implementation_has_its_shares() {
        for (low, mode, high) in [(0.0, 1.0, 4.0), (-3.0, -3.0, 2.0), (5.0, 9.0, 9.0), (1.0, 1.5, 2.0)] {
            let other = Other::new(low, high, mode).unwrap();
            for share in [1e-9, 1e-3, 0.1, 0.25, 0.5, 0.8, 0.999, 1.0 - 1e-9] {
                let back = other.cdf(Triangular { low, mode, high }.quantile(share));
                assert!((back - share).abs() < 1e-12, "{low} {mode} {high}: {share} {back}");
            }
        }
        assert_eq!(Triangular { low: 3.0, mode: 3.0, high: 3.0 }.quantile(0.3), 3.0);
    }
}
