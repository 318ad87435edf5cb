//! Hyperbolic tangent and logistic function for many arguments at once, the same bits on every machine.
//!
//! Only multiplications, additions and divisions of IEEE arithmetic, so that the compiler may put the
//! arguments side by side in vector lanes. Absolute error below 3e-16.

/// e^x for −700 ≤ x ≤ 700: a power of two times a series.
#[inline(always)]
fn exp(x: f64) -> f64 {
    // 1.5·2^52: adding it rounds to a whole number in the low bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
    const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let power = shifted - ROUND;
    let r = (x - power * LN2_HIGH) - power * LN2_LOW;
    // |r| ≤ ln 2 / 2: thirteen terms reach the last bit.
    let r2 = r * r;
    let odd = 1.0
        + r2 * (1.0 / 6.0
            + r2 * (1.0 / 120.0
                + r2 * (1.0 / 5_040.0
                    + r2 * (1.0 / 362_880.0 + r2 * (1.0 / 39_916_800.0 + r2 / 6_227_020_800.0)))));
    let even = 0.5
        + r2 * (1.0 / 24.0
            + r2 * (1.0 / 720.0 + r2 * (1.0 / 40_320.0 + r2 * (1.0 / 3_628_800.0 + r2 / 479_001_600.0))));
    let series = 1.0 + (r * odd + r2 * even);
    let scale = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    series * scale
}

/// tanh of every element; −∞ becomes −1.
#[inline]
pub fn tanh_in_place<const N: usize>(values: &mut [f64; N]) {
    for x in values {
        // Beyond 20 the tangent is 1 to the last bit; the clamp also keeps exp in its range.
        let clamped = x.clamp(-20.0, 20.0);
        let e = exp(-2.0 * clamped.abs());
        *x = ((1.0 - e) / (1.0 + e)).copysign(clamped);
    }
}

/// 1/(1 + e^−x) of every element.
#[inline]
pub fn logistic<const N: usize>(values: &[f64; N]) -> [f64; N] {
    values.map(|x| 1.0 / (1.0 + exp(-x.clamp(-700.0, 700.0))))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn tanh_is_tanh(x in prop_oneof![-25.0..25.0, -0.5..0.5]) {
            let mut found = [x];
            tanh_in_place(&mut found);
            prop_assert!((found[0] - libm::tanh(x)).abs() < 3e-16, "{}", found[0] - libm::tanh(x));
        }

        #[test]
        fn exp_is_exp(x in -700.0..700.0) {
            prop_assert!((exp(x) / libm::exp(x) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn the_ends_are_reached() {
        let mut ends = [f64::NEG_INFINITY, 0.0, f64::INFINITY, -1e300];
        tanh_in_place(&mut ends);
        assert_eq!(ends, [-1.0, 0.0, 1.0, -1.0]);
        assert!(logistic(&[-800.0])[0] > 0.0);
        assert_eq!(logistic(&[0.0, 800.0]), [0.5, 1.0]);
    }
}
