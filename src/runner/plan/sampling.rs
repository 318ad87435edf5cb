//! Sampled variations: points of a design, through the quantile functions of the declared distributions.

use std::collections::HashMap;

use sha2::{Digest, Sha256};

use super::variables::Variables;
use numbers::design::{SOBOL_CELL, latin_hypercube, sobol_point, uniform};
use numbers::random::Stream;
use scenario::{Assignment, DistributionError, DrawnValue, Samples, SamplingScheme, Value, significant};

/// The samples of a variation: where each lies in the design, and how many before it read the same. What they are is worked
/// out again for whoever asks, so that a million take little memory.
#[derive(Debug)]
pub struct Drawn {
    /// One point of the open unit cube per sample, one after the other.
    points: Vec<f64>,
    /// Which of those that read the same each is, from 1.
    copies: Vec<u32>,
}

impl Drawn {
    /// The values of the sample with this index, which depend on the same `known` as when they were drawn.
    ///
    /// # Errors
    /// As for [`draw`].
    pub fn row(
        &self,
        index: usize,
        names: &[String],
        samples: &Samples,
        known: &Variables,
    ) -> Result<Vec<Assignment>, (String, DistributionError)> {
        let point = &self.points[index * names.len()..][..names.len()];
        let mut row = row(point, names, samples, &mut known.clone())?;
        if self.copies[index] > 1 {
            row[0].label += &format!("#{}", self.copies[index]);
        }
        Ok(row)
    }
}

/// Draws the samples of a variation. `known` are the variations that distributions may depend on; so they may on earlier names
/// of their row.
///
/// # Errors
/// If nothing can be drawn from a distribution with the numbers that it has there: its name, and why.
pub fn draw(
    seed: u64,
    names: &[String],
    samples: &Samples,
    known: &Variables,
) -> Result<Drawn, (String, DistributionError)> {
    let points = design(samples.scheme, samples.count as usize, names.len(), seed);
    let mut known = known.clone();
    // Two draws that round to the same words still need names of their own.
    let mut read: HashMap<[u8; 16], u32> = HashMap::new();
    let copies = points.chunks_exact(names.len()).map(|point| {
        let row = row(point, names, samples, &mut known)?;
        let copies = read.entry(digest(row.iter().map(|one| one.label.as_str()))).or_default();
        *copies += 1;
        Ok(*copies)
    });
    let copies = copies.collect::<Result<_, _>>()?;
    Ok(Drawn { points, copies })
}

/// What a point of the design is in words and values. Each is known to those after it.
fn row(
    point: &[f64],
    names: &[String],
    samples: &Samples,
    known: &mut Variables,
) -> Result<Vec<Assignment>, (String, DistributionError)> {
    let mut row = Vec::with_capacity(names.len());
    for (index, name) in names.iter().enumerate() {
        let distribution = samples.distributions[index].known(known);
        let distribution = distribution.map_err(|error| (name.clone(), error))?;
        let (value, label) = match distribution.quantile(point[index]) {
            DrawnValue::Number(number) => {
                (Value::Number(number), format!("{}{}", significant(number, 5), samples.units[index]))
            }
            DrawnValue::Listed(option) => (option.value.clone(), option.label.clone()),
        };
        known.insert(name.clone(), value.clone());
        row.push(Assignment { name: name.clone(), label, value });
    }
    Ok(row)
}

/// Stands for words where there may be a million of them.
pub fn digest<'w>(words: impl Iterator<Item = &'w str>) -> [u8; 16] {
    let mut digest = Sha256::new();
    for word in words {
        digest.update((word.len() as u64).to_le_bytes());
        digest.update(word);
    }
    let bytes: [u8; 32] = digest.finalize().into();
    std::array::from_fn(|index| bytes[index])
}

/// `count` points of the open unit cube, one after the other.
fn design(scheme: SamplingScheme, count: usize, dimensions: usize, seed: u64) -> Vec<f64> {
    let mut stream = Stream::seeded(seed);
    match scheme {
        SamplingScheme::Random => uniform(count, dimensions, &mut stream).concat(),
        SamplingScheme::LatinHypercube => latin_hypercube(count, dimensions, &mut stream).concat(),
        SamplingScheme::Sobol => {
            let scramble = (seed ^ (seed >> 32)) as u32;
            // In the middle of its cell, so never on the edge.
            let inside = |corner: f64| corner + 0.5 * SOBOL_CELL;
            let points = (0..count).flat_map(|index| sobol_point(index, dimensions, scramble));
            points.map(inside).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::Distribution;

    fn samples(scheme: SamplingScheme, distribution: Distribution) -> Samples {
        Samples { count: 256, scheme, distributions: vec![distribution], units: vec!["s".into()] }
    }

    fn rows(samples: &Samples) -> Vec<Vec<Assignment>> {
        let (names, known) = (["tta".to_string()], Variables::new());
        let drawn = draw(3, &names, samples, &known).unwrap();
        (0..samples.count as usize).map(|row| drawn.row(row, &names, samples, &known).unwrap()).collect()
    }

    fn numbers(samples: &Samples) -> Vec<f64> {
        rows(samples).iter().map(|row| row[0].value.as_number().unwrap()).collect()
    }

    #[test]
    fn every_scheme_fills_the_range() {
        for scheme in [SamplingScheme::Random, SamplingScheme::LatinHypercube, SamplingScheme::Sobol] {
            let drawn =
                numbers(&samples(scheme, Distribution::Uniform { low: 6.0.into(), high: 18.0.into() }));
            assert_eq!(drawn.len(), 256);
            assert!(drawn.iter().all(|value| (6.0..18.0).contains(value)));
            let mean = drawn.iter().sum::<f64>() / 256.0;
            assert!((mean - 12.0).abs() < 0.7, "{scheme:?} {mean}");
        }
    }

    #[test]
    fn stratified_schemes_hold_one_point_a_slice() {
        for scheme in [SamplingScheme::LatinHypercube, SamplingScheme::Sobol] {
            for dimension in 0..2 {
                let mut slices: Vec<_> = design(scheme, 64, 2, 9)
                    .chunks(2)
                    .map(|point| (point[dimension] * 64.0) as usize)
                    .collect();
                slices.sort_unstable();
                assert_eq!(slices, (0..64).collect::<Vec<_>>(), "{scheme:?}");
            }
        }
    }

    #[test]
    fn any_number_of_names_may_vary_together() {
        for scheme in [SamplingScheme::LatinHypercube, SamplingScheme::Sobol] {
            let points = design(scheme, 8, 300, 1);
            let slices = |dimension: usize| {
                let mut slices: Vec<_> =
                    points.chunks(300).map(|point| (8.0 * point[dimension]) as usize).collect();
                slices.sort_unstable();
                slices
            };
            assert!((0..300).all(|dimension| slices(dimension) == (0..8).collect::<Vec<_>>()), "{scheme:?}");
        }
    }

    #[test]
    fn normals_have_their_moments_and_limits() {
        let normal = Distribution::Normal { mean: 1.3.into(), standard_deviation: 0.2.into() };
        let drawn = numbers(&samples(SamplingScheme::LatinHypercube, normal));
        let mean = drawn.iter().sum::<f64>() / 256.0;
        let variance = drawn.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 255.0;
        assert!((mean - 1.3).abs() < 0.005 && (variance.sqrt() - 0.2).abs() < 0.01, "{mean} {variance}");
        let truncated = |standard_deviation: f64| Distribution::TruncatedNormal {
            mean: 1.3.into(),
            standard_deviation: standard_deviation.into(),
            low: 1.2.into(),
            high: 1.5.into(),
        };
        let drawn = numbers(&samples(SamplingScheme::Random, truncated(0.2)));
        assert!(drawn.iter().all(|value| (1.2..=1.5).contains(value)));
        let constant = numbers(&samples(SamplingScheme::Random, truncated(0.0)));
        assert!(constant.iter().all(|value| *value == 1.3));
    }

    #[test]
    fn equal_labels_are_told_apart() {
        let only = scenario::VariedValue { value: Value::Number(1.0), label: "1s".into() };
        let samples = samples(SamplingScheme::Random, Distribution::Choice(vec![only]));
        let rows = rows(&samples);
        assert_eq!([&rows[0][0].label, &rows[1][0].label, &rows[255][0].label], ["1s", "1s#2", "1s#256"]);
    }
}
