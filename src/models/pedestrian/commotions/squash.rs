//! Hyperbolic tangent and logistic function for many arguments at once, the same bits on every machine.
//!
//! Only multiplications, additions and divisions of IEEE arithmetic, so that the compiler may put the
//! arguments side by side in vector lanes. Absolute error below 3e-16.

use numbers::lanes::exp;

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
