//! The standard normal distribution in logarithms, as far out in its tail as anybody asks, where the plain numbers underflow.

use std::f64::consts::{LN_2, SQRT_2};

use super::normal::{cumulative, density};

const LN_SQRT_2_PI: f64 = 0.918_938_533_204_672_8;

/// Below this the erfc-based formulas lose their last digits and the asymptotic series are exact.
const TAIL: f64 = -25.0;

/// Natural logarithm of the distribution function, accurate for any `z`.
pub fn log_cumulative(z: f64) -> f64 {
    if z > TAIL {
        return libm::log(libm::erfc(-z / SQRT_2)) - LN_2;
    }
    let t = 1.0 / (z * z);
    -0.5 * z * z - LN_SQRT_2_PI - libm::log(-z) + libm::log1p(-t + 3.0 * t * t - 15.0 * t * t * t)
}

/// h(z) = φ(z) + z Φ(z), the mean of max(z + Z, 0) over standard normal Z: expected improvement in standard deviations.
pub fn improvement(z: f64) -> f64 {
    density(z) + z * cumulative(z)
}

/// ln h(z), accurate where h itself underflows (Ament et al. 2023, "Unexpected improvements to expected improvement", eq. 9).
pub fn log_improvement(z: f64) -> f64 {
    if z > -1.0 {
        return libm::log(improvement(z));
    }
    let log_density = -0.5 * z * z - LN_SQRT_2_PI;
    if z > TAIL {
        // 1 - |z| Φ(z)/φ(z), the Mills ratio taken so that nothing underflows
        let mills = 0.5 * libm::erfc(-z / SQRT_2) / libm::exp(log_density);
        return log_density + libm::log1p(z * mills);
    }
    let t = 1.0 / (z * z);
    log_density + libm::log(t) + libm::log1p(-3.0 * t + 15.0 * t * t - 105.0 * t * t * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log_improvement_agrees_with_published_digits_and_joins_its_branches() {
        // scipy 1.17: pdf(z) (1 - |z| sqrt(π/2) erfcx(|z|/√2)) for negative z, pdf(z) + z cdf(z) otherwise
        for (z, expected) in [
            (0.0, -0.918_938_533_204_672_8),
            (2.0, 0.697_383_545_788_228_4),
            (-1.5, -3.529_935_920_805_711),
            (-5.0, -16.744_301_162_660_985),
            (-20.0, -206.917_838_509_425_05),
        ] {
            let got = log_improvement(z);
            assert!((got - expected).abs() < 1e-11 * expected.abs().max(1.0), "{z}: {got} {expected}");
        }
        for edge in [-1.0, TAIL] {
            let (below, above) = (log_improvement(edge - 1e-9), log_improvement(edge + 1e-9));
            assert!((below - above).abs() < 1e-6, "{edge}: {below} {above}");
        }
        assert!(log_improvement(-1e6).is_finite() && log_improvement(-1e6) < log_improvement(-1e5));
    }

    #[test]
    fn improvement_is_the_mean_of_what_is_left() {
        // By the midpoint rule over Z.
        let (steps, end) = (20_000, 9.0);
        let width = 2.0 * end / f64::from(steps);
        for z in [-2.0, -0.3, 0.0, 1.7] {
            let at = |step: i32| -end + width * (f64::from(step) + 0.5);
            let mean: f64 = (0..steps).map(at).map(|x| (z + x).max(0.0) * density(x) * width).sum();
            assert!(
                (improvement(z) - mean).abs() < 1e-6 && (log_improvement(z) - libm::log(mean)).abs() < 1e-5
            );
        }
    }

    #[test]
    fn log_cumulative_joins_its_branches_and_stays_finite() {
        assert!((log_cumulative(0.0) + LN_2).abs() < 1e-15);
        assert!((log_cumulative(-1.0) - libm::log(0.158_655_253_931_457_05)).abs() < 1e-14);
        assert!((log_cumulative(TAIL - 1e-9) - log_cumulative(TAIL + 1e-9)).abs() < 1e-6);
        assert!(log_cumulative(-1e8).is_finite());
        assert_eq!(log_cumulative(40.0), 0.0);
    }
}
