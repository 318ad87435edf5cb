//! Seeded random streams: one per agent and purpose, portable and independent of execution order.
//!
//! ChaCha8 is seekable and named, so its bits are the same on every platform and in every version; the normal
//! deviates come from an inverse distribution function on `libm`, for the same reason.

use rand::Rng;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// Who draws: a pedestrian or a vehicle, by its [rank](ranks) among its kind. A draw added to one agent never shifts
/// another's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Agent {
    Pedestrian(usize),
    Vehicle(usize),
}

/// The place of each of `names` in alphabetical order, from 0, so that who draws what does not depend on the order in
/// which road users are declared. Equal names keep their order.
pub fn ranks(names: &[&str]) -> Vec<usize> {
    let place = |(index, name): (usize, &&str)| {
        names.iter().enumerate().filter(|(other, before)| (**before, *other) < (*name, index)).count()
    };
    names.iter().enumerate().map(place).collect()
}

/// What an agent draws for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Choices and parameters drawn once per run.
    Trait = 0,
    /// Choices made during the run.
    Decision = 1,
    /// Noise of what is seen.
    Perception = 2,
    /// Noise of movement.
    Motion = 3,
    /// Noise and losses of a vehicle's sensors, whoever drives it.
    Sensing = 4,
}

/// An endless sequence of draws.
#[derive(Debug)]
pub struct Stream(ChaCha8Rng);

/// The stream of one agent for one purpose in the run with seed `seed`.
pub fn stream(seed: u64, agent: Agent, purpose: Purpose) -> Stream {
    let (kind, index) = match agent {
        Agent::Pedestrian(index) => (1, index),
        Agent::Vehicle(index) => (2, index),
    };
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(kind << 56 | (index as u64) << 8 | purpose as u64);
    Stream(generator)
}

impl Stream {
    /// A stream that belongs to no agent, for planning and searching.
    pub fn seeded(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in the open interval (0, 1).
    pub fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 12) as f64 + 0.5) * (1.0 / (1u64 << 52) as f64)
    }

    /// Uniform in (low, high).
    pub fn uniform_in(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Uniform in 0..count; `count` must not be 0.
    pub fn index(&mut self, count: usize) -> usize {
        // The bias is below count / 2^52.
        ((self.uniform() * count as f64) as usize).min(count - 1)
    }

    /// Leaves `count` of the items (or all, if there are fewer), drawn without replacement, in the order of drawing. A
    /// smaller draw from the same stream is the beginning of a larger one.
    pub fn draw<T>(&mut self, items: &mut Vec<T>, count: usize) {
        let count = count.min(items.len());
        for place in 0..count {
            let other = place + self.index(items.len() - place);
            items.swap(place, other);
        }
        items.truncate(count);
    }

    /// 0..count in random order.
    pub fn shuffled(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            order.swap(last, self.index(last + 1));
        }
        order
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        normal_quantile(self.uniform())
    }
}

/// The standard normal quantile for 0 < p < 1, to about 1e-16 relative.
///
/// Source: M. J. Wichura, algorithm AS 241 (PPND16), Applied Statistics 37(3), 1988.
pub fn normal_quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180625 - q * q;
        return q * ratio(r, &CENTRE_ABOVE, &CENTRE_BELOW);
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

    fn cumulative(z: f64) -> f64 {
        0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
    }

    #[test]
    fn quantiles_agree_with_an_independent_distribution_function() {
        for exponent in 1..=300 {
            let p = 0.5 * libm::pow(10.0, -f64::from(exponent) / 20.0);
            let z = normal_quantile(p);
            assert!((cumulative(z) / p - 1.0).abs() < 1e-12, "p = {p}");
        }
        for k in 1..1000 {
            let p = f64::from(k) / 1000.0;
            assert!((cumulative(normal_quantile(p)) - p).abs() < 1e-15, "p = {p}");
        }
    }

    #[test]
    fn streams_are_golden() {
        let mut walker = stream(42, Agent::Pedestrian(0), Purpose::Perception);
        let draws: Vec<_> = (0..4).map(|_| walker.normal()).collect();
        insta::assert_debug_snapshot!(draws);
    }

    #[test]
    fn ranks_follow_the_names_in_whatever_order_they_stand() {
        assert_eq!(ranks(&["walker", "child", "aunt"]), [2, 1, 0]);
        assert_eq!(ranks(&["aunt", "walker", "child"]), [0, 2, 1]);
        assert_eq!(ranks(&["a", "b", "a"]), [0, 2, 1]);
        assert_eq!(ranks(&["av"]), [0]);
    }

    #[test]
    fn streams_differ_by_seed_agent_and_purpose() {
        let first = |seed, agent, purpose| stream(seed, agent, purpose).uniform();
        let base = first(1, Agent::Pedestrian(0), Purpose::Decision);
        assert_eq!(base, first(1, Agent::Pedestrian(0), Purpose::Decision));
        assert_ne!(base, first(2, Agent::Pedestrian(0), Purpose::Decision));
        assert_ne!(base, first(1, Agent::Pedestrian(1), Purpose::Decision));
        assert_ne!(base, first(1, Agent::Vehicle(0), Purpose::Decision));
        assert_ne!(base, first(1, Agent::Pedestrian(0), Purpose::Motion));
    }

    #[test]
    fn moments_of_the_normal_draws() {
        let mut stream = Stream::seeded(7);
        let n = 200_000;
        let draws: Vec<_> = (0..n).map(|_| stream.normal()).collect();
        let mean = draws.iter().sum::<f64>() / f64::from(n);
        let variance = draws.iter().map(|z| z * z).sum::<f64>() / f64::from(n);
        assert!(mean.abs() < 0.01 && (variance - 1.0).abs() < 0.01, "{mean} {variance}");
    }
}
