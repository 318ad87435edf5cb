//! The normal distribution: density, distribution function and quantile.

use std::f64::consts::{PI, SQRT_2};

/// A normal distribution; [`density`], [`cumulative`] and [`quantile`] are those of the standard one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal {
    /// Any finite number.
    pub mean: f64,
    /// Larger than 0.
    pub standard_deviation: f64,
}

impl Normal {
    /// The share of values below `value`.
    pub fn cumulative(self, value: f64) -> f64 {
        0.5 * libm::erfc((self.mean - value) / (self.standard_deviation * SQRT_2))
    }

    /// The value that a share of all lies below: 0 < `share` < 1.
    pub fn quantile(self, share: f64) -> f64 {
        self.mean + self.standard_deviation * quantile(share)
    }

    /// The value that a share of those in `low..=high` lies below.
    pub fn quantile_within(self, share: f64, low: f64, high: f64) -> f64 {
        let (below, above) = (self.cumulative(low), self.cumulative(high));
        let inside = below + (above - below) * share;
        // Far out in a tail the cumulative distribution is flat, and rounding may leave the interval.
        self.quantile(inside.clamp(1e-300, 1.0 - 1e-16)).clamp(low, high)
    }

    /// The share of values whose density is no higher than at `value`: those that lie as far from the mean.
    pub fn tail(self, value: f64) -> f64 {
        libm::erfc((value - self.mean).abs() / (self.standard_deviation * SQRT_2))
    }

    /// The same of those in `low..=high`: 0 outside of them.
    pub fn tail_within(self, value: f64, low: f64, high: f64) -> f64 {
        if !(low..=high).contains(&value) {
            return 0.0;
        }
        let apart = (value - self.mean).abs();
        let outside = self.between(low, self.mean - apart) + self.between(self.mean + apart, high);
        let inside = self.between(low, high);
        // Ends so far out in a tail that nothing is left between them to be seen.
        if inside > 0.0 { (outside / inside).min(1.0) } else { 0.0 }
    }

    /// The share of values between two ends, of whichever tail they are in without cancelling; none if they are in the wrong order.
    fn between(self, low: f64, high: f64) -> f64 {
        if low >= high {
            return 0.0;
        }
        let mirrored = Self { mean: -self.mean, ..self };
        match low > self.mean {
            true => mirrored.cumulative(-low) - mirrored.cumulative(-high),
            false => self.cumulative(high) - self.cumulative(low),
        }
    }
}

/// The density at `z`.
pub fn density(z: f64) -> f64 {
    libm::exp(-0.5 * z * z) / (2.0 * PI).sqrt()
}

/// The share of values below `z`.
pub fn cumulative(z: f64) -> f64 {
    Normal { mean: 0.0, standard_deviation: 1.0 }.cumulative(z)
}

/// The z below which a share `p` lies, to about 1e-16 relative; infinite at 0 and 1, not a number beyond.
///
/// Source: M. J. Wichura, algorithm AS 241 (PPND16), Applied Statistics 37(3), 1988.
pub fn quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180625 - q * q;
        return q * ratio(r, &CENTRE_ABOVE, &CENTRE_BELOW);
    }
    if p == 0.0 || p == 1.0 {
        return f64::INFINITY.copysign(q);
    }
    let r = libm::sqrt(-libm::log(if q < 0.0 { p } else { 1.0 - p }));
    let magnitude = if r <= 5.0 {
        ratio(r - 1.6, &MIDDLE_ABOVE, &MIDDLE_BELOW)
    } else {
        ratio(r - 5.0, &TAIL_ABOVE, &TAIL_BELOW)
    };
    if q < 0.0 { -magnitude } else { magnitude }
}

fn ratio(x: f64, above: &[f64; 8], below: &[f64; 8]) -> f64 {
    let polynomial = |coefficients: &[f64; 8]| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    polynomial(above) / polynomial(below)
}

const CENTRE_ABOVE: [f64; 8] = [
    3.387_132_872_796_366_5,
    1.331_416_678_917_843_8e2,
    1.971_590_950_306_551_3e3,
    1.373_169_376_550_946e4,
    4.592_195_393_154_987e4,
    6.726_577_092_700_87e4,
    3.343_057_558_358_813e4,
    2.509_080_928_730_122_7e3,
];
const CENTRE_BELOW: [f64; 8] = [
    1.0,
    4.231_333_070_160_091e1,
    6.871_870_074_920_579e2,
    5.394_196_021_424_751e3,
    2.121_379_430_158_659_7e4,
    3.930_789_580_009_271e4,
    2.872_908_573_572_194_3e4,
    5.226_495_278_852_854e3,
];
const MIDDLE_ABOVE: [f64; 8] = [
    1.423_437_110_749_683_5,
    4.630_337_846_156_546,
    5.769_497_221_460_691,
    3.647_848_324_763_204_5,
    1.270_458_252_452_368_4,
    2.417_807_251_774_506e-1,
    2.272_384_498_926_918_4e-2,
    7.745_450_142_783_414e-4,
];
const MIDDLE_BELOW: [f64; 8] = [
    1.0,
    2.053_191_626_637_759,
    1.676_384_830_183_803_8,
    6.897_673_349_851e-1,
    1.481_039_764_274_800_8e-1,
    1.519_866_656_361_645_7e-2,
    5.475_938_084_995_345e-4,
    1.050_750_071_644_416_9e-9,
];
const TAIL_ABOVE: [f64; 8] = [
    6.657_904_643_501_103,
    5.463_784_911_164_114,
    1.784_826_539_917_291_3,
    2.965_605_718_285_048_7e-1,
    2.653_218_952_657_612_4e-2,
    1.242_660_947_388_078_4e-3,
    2.711_555_568_743_487_6e-5,
    2.010_334_399_292_288_1e-7,
];
const TAIL_BELOW: [f64; 8] = [
    1.0,
    5.998_322_065_558_88e-1,
    1.369_298_809_227_358e-1,
    1.487_536_129_085_061_5e-2,
    7.868_691_311_456_133e-4,
    1.846_318_317_510_054_7e-5,
    1.421_511_758_316_446e-7,
    2.044_263_103_389_939_8e-15,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_agree_with_an_independent_distribution_function() {
        for exponent in 1..=300 {
            let p = 0.5 * libm::pow(10.0, -f64::from(exponent) / 20.0);
            let z = quantile(p);
            assert!((cumulative(z) / p - 1.0).abs() < 1e-12, "p = {p}");
        }
        for k in 1..1000 {
            let p = f64::from(k) / 1000.0;
            assert!((cumulative(quantile(p)) - p).abs() < 1e-15, "p = {p}");
        }
    }

    #[test]
    fn quantiles_have_their_digits() {
        // mpmath with 60 digits, of the floating-point numbers as they are, by Newton's method on the logarithm of erfc.
        for (p, expected) in [
            (1e-300, -37.047_096_299_361_2),
            (1e-100, -21.273_453_560_965_325),
            (1e-10, -6.361_340_902_404_056),
            (0.001, -3.090_232_306_167_813_5),
            (0.07, -1.475_791_028_179_170_7),
            (0.6, 0.253_347_103_135_799_7),
            (0.7, 0.524_400_512_708_040_6),
            (0.9, 1.281_551_565_544_600_6),
            (0.975, 1.959_963_984_540_053_9),
            (0.98, 2.053_748_910_631_822_7),
            (0.989_949_493_661_166_6, 2.324_457_017_891_941_6),
            (0.993_288_388_379_268_7, 2.472_338_809_204_97),
            (0.999_999, 4.753_424_308_817_088),
            (0.999_999_999_999, 7.034_486_910_047_835),
        ] {
            let found = quantile(p);
            assert!((found / expected - 1.0).abs() < 5e-16, "{p}: {found} {expected}");
        }
    }

    #[test]
    fn the_ends_are_infinite_and_nothing_is_beyond() {
        assert_eq!((quantile(0.0), quantile(1.0)), (f64::NEG_INFINITY, f64::INFINITY));
        assert!([-0.1, 1.1, f64::NAN].into_iter().all(|p| quantile(p).is_nan()));
    }

    #[test]
    fn the_distribution_function_is_the_area_below_the_density() {
        // Simpson's rule from far out on the left.
        let (steps, start) = (20_000, -9.0);
        let width = 12.0 / f64::from(steps);
        let mut area = 0.0;
        for step in 0..steps {
            let z = start + f64::from(step) * width;
            area += width / 6.0 * (density(z) + 4.0 * density(z + 0.5 * width) + density(z + width));
            if step % 1000 == 0 {
                assert!((cumulative(z + width) - area).abs() < 1e-13, "{z}");
            }
        }
    }

    #[test]
    fn what_is_truncated_keeps_its_shares() {
        let normal = Normal { mean: 1.3, standard_deviation: 0.2 };
        let (low, high) = (normal.cumulative(1.2), normal.cumulative(1.5));
        for k in 1..20 {
            let share = f64::from(k) / 20.0;
            let value = normal.quantile_within(share, 1.2, 1.5);
            assert!(((normal.cumulative(value) - low) / (high - low) - share).abs() < 1e-13, "{share}");
        }
        // So far out that all shares round to the same.
        assert_eq!(normal.tail_within(100.5, 100.0, 101.0), 0.0);
        let far = normal.quantile_within(0.5, 100.0, 101.0);
        assert!((100.0..=101.0).contains(&far));
    }
}
