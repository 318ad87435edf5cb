//! Functions for many arguments at once, the same bits on every machine.
//!
//! Only multiplications, additions and divisions of IEEE arithmetic, so that the compiler may put the arguments side by side in
//! vector lanes.

/// e^x for −700 ≤ x ≤ 700: a power of two times a series. Relative error below 1e-15.
#[inline(always)]
pub fn exp(x: f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn exp_is_exp(x in -700.0..700.0) {
            prop_assert!((exp(x) / libm::exp(x) - 1.0).abs() < 1e-15);
        }
    }
}
