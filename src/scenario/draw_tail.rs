//! How usual a drawn value is: the share of its distribution that is no denser, or of a list no likelier.

use std::collections::BTreeMap;

use numbers::distributions::normal::Normal;
use numbers::distributions::{LogNormal, Tail, Triangular, beta_tail, exponential_tail};

use super::{DeclaredDraw, DistributionError, DrawSource, KnownDistribution, Value, VariedValue};

impl DeclaredDraw {
    /// The share of what may be drawn that is no more usual than the values that its names have here, where the numbers of its distribution
    /// are those that follow from the other values: 0 of what is never drawn. Densities are those of the values as they are, in any unit;
    /// values of a table go together, a row of one weight being as usual as another of the same.
    ///
    /// # Errors
    /// If a name or a number of the distribution has no value, or nothing can be drawn with it.
    pub fn tail(&self, values: &BTreeMap<String, Value>) -> Result<Tail, DistributionError> {
        let own = self.names.iter().map(|name| {
            let missing = || super::EvaluationError::Unbound(name.clone());
            values.get(name).ok_or_else(missing)
        });
        let own: Vec<&Value> = own.collect::<Result<_, _>>()?;
        match &self.from {
            DrawSource::Distribution { distribution, .. } => Ok(distribution.known(values)?.tail(own[0])),
            DrawSource::Table(table) => {
                let rows = table.rows.iter().map(|row| row.iter().map(|one| &one.value).collect());
                Ok(of_list(rows.zip(table.weights.iter().copied()), &own))
            }
        }
    }
}

impl KnownDistribution<'_> {
    /// The share of it that is no more usual than `value`.
    pub fn tail(&self, value: &Value) -> Tail {
        let options = |options: &[VariedValue], weight: &dyn Fn(usize) -> f64| {
            let each = options.iter().enumerate().map(|(index, one)| (vec![&one.value], weight(index)));
            of_list(each, &[value])
        };
        match *self {
            Self::Choice(listed) => return options(listed, &|_| 1.0),
            Self::Weighted { options: listed, weights } => return options(listed, &|index| weights[index]),
            _ => {}
        }
        let Some(number) = value.as_number().filter(|number| !number.is_nan()) else {
            return Tail::of_equals(false);
        };
        if self.is_constant() {
            return Tail::of_equals(self.nominal().is_some_and(|(only, _)| only == number));
        }
        match *self {
            Self::Uniform { low, high } => Tail::of_equals((low..=high).contains(&number)),
            Self::Beta { alpha: 1.0, beta: 1.0, low, high } => {
                Tail::of_equals((low..=high).contains(&number))
            }
            Self::Normal { mean, standard_deviation } => {
                Tail::of_density(Normal { mean, standard_deviation }.tail(number))
            }
            Self::TruncatedNormal { mean, standard_deviation, low, high } => {
                Tail::of_density(Normal { mean, standard_deviation }.tail_within(number, low, high))
            }
            Self::LogNormal { median, sigma } => Tail::of_density(LogNormal { median, sigma }.tail(number)),
            Self::Triangular { low, mode, high } => {
                Tail::of_density(Triangular { low, mode, high }.tail(number))
            }
            Self::Beta { alpha, beta, low, high } => {
                Tail::of_density(beta_tail((number - low) / (high - low), alpha, beta))
            }
            Self::Exponential { mean } => Tail::of_density(exponential_tail(number, mean)),
            Self::Choice(_) | Self::Weighted { .. } => Tail::of_equals(false),
        }
    }
}

/// Of a list in which the same may stand several times.
fn of_list<'v>(listed: impl Iterator<Item = (Vec<&'v Value>, f64)>, own: &[&Value]) -> Tail {
    let mut weights: Vec<(Vec<&Value>, f64)> = Vec::new();
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    for (values, weight) in listed {
        let place = *places.entry(format!("{values:?}")).or_insert(weights.len());
        match weights.get_mut(place) {
            Some(known) => known.1 += weight,
            None => weights.push((values, weight)),
        }
    }
    let all: f64 = weights.iter().map(|one| one.1).sum();
    let probabilities: Vec<f64> = weights.iter().map(|one| one.1 / all).collect();
    Tail::of_list(&probabilities, weights.iter().position(|one| one.0 == own))
}

#[cfg(test)]
mod tests {
    use numbers::random::Stream;

    use super::*;
    use crate::{Distribution, DrawTable, DrawnValue, Expression, Origin};

    fn listed(count: u32) -> Vec<VariedValue> {
        (0..count)
            .map(|one| VariedValue { value: Value::Number(f64::from(one)), label: one.to_string() })
            .collect()
    }

    fn densities() -> Vec<KnownDistribution<'static>> {
        vec![
            KnownDistribution::Normal { mean: -3.0, standard_deviation: 2.0 },
            KnownDistribution::TruncatedNormal { mean: 1.3, standard_deviation: 0.3, low: 0.5, high: 1.5 },
            KnownDistribution::TruncatedNormal { mean: 9.0, standard_deviation: 2.0, low: 0.5, high: 4.0 },
            KnownDistribution::LogNormal { median: 3.0, sigma: 0.4 },
            KnownDistribution::LogNormal { median: 3.0, sigma: 1.7 },
            KnownDistribution::Triangular { low: 1.0, mode: 2.0, high: 6.0 },
            KnownDistribution::Triangular { low: 1.0, mode: 1.0, high: 6.0 },
            KnownDistribution::Beta { alpha: 2.0, beta: 5.0, low: 1.0, high: 8.0 },
            KnownDistribution::Beta { alpha: 0.5, beta: 0.7, low: 1.0, high: 8.0 },
            KnownDistribution::Beta { alpha: 0.5, beta: 3.0, low: 1.0, high: 8.0 },
            KnownDistribution::Beta { alpha: 3.0, beta: 1.0, low: 1.0, high: 8.0 },
            KnownDistribution::Exponential { mean: 2.5 },
        ]
    }

    fn drawn(of: &KnownDistribution, stream: &mut Stream) -> Value {
        match of.quantile(stream.uniform()) {
            DrawnValue::Number(number) => Value::Number(number),
            DrawnValue::Listed(option) => option.value.clone(),
        }
    }

    /// The tail of what is drawn is at or below any share in that share of draws: whatever the formula, and as exactly as they are counted.
    #[test]
    fn a_share_of_draws_is_at_or_below_that_share() {
        let mut stream = Stream::seeded(11);
        let draws = 20_000;
        for of in densities() {
            let tails: Vec<f64> = (0..draws).map(|_| of.tail(&drawn(&of, &mut stream)).share).collect();
            for share in [0.002, 0.01, 0.05, 0.25, 0.7] {
                let below = tails.iter().filter(|tail| **tail <= share).count() as f64 / f64::from(draws);
                let error = (share * (1.0 - share) / f64::from(draws)).sqrt();
                assert!((below - share).abs() < 4.5 * error, "{of:?}: {below} at or below {share}");
            }
        }
        let (options, weights) = (listed(4), [0.5, 0.3, 0.15, 0.05]);
        let lists = [
            KnownDistribution::Choice(&options),
            KnownDistribution::Weighted { options: &options, weights: &weights },
            KnownDistribution::Uniform { low: 2.0, high: 5.0 },
        ];
        for of in lists {
            let tails: Vec<f64> = (0..draws).map(|_| of.tail(&drawn(&of, &mut stream)).share).collect();
            for share in [0.01, 0.05, 0.2, 0.6] {
                let below = tails.iter().filter(|tail| **tail <= share).count() as f64 / f64::from(draws);
                assert!(below < share + 0.01, "{of:?}: {below} at or below {share}");
            }
        }
    }

    /// A second derivation: where the distribution function, as the quantile has it, is no steeper than at the value.
    #[test]
    fn tails_are_what_counting_densities_on_a_grid_gives() {
        let number = |of: &KnownDistribution, share: f64| match of.quantile(share) {
            DrawnValue::Number(number) => number,
            DrawnValue::Listed(_) => panic!("a number"),
        };
        let steps = 20_000;
        for of in densities() {
            // Inverse densities: how far apart equal shares lie.
            let sparse = |share: f64| {
                let half = 0.2 / f64::from(steps);
                number(&of, share + half) - number(&of, share - half)
            };
            let all: Vec<f64> =
                (0..steps).map(|step| sparse((f64::from(step) + 0.5) / f64::from(steps))).collect();
            for share in [0.003, 0.05, 0.31, 0.5, 0.77, 0.96] {
                let here = sparse(share);
                let counted = all.iter().filter(|one| **one >= here).count() as f64 / f64::from(steps);
                let found = of.tail(&Value::Number(number(&of, share))).share;
                assert!((found - counted).abs() < 2e-3, "{of:?} at {share}: {found}, {counted}");
            }
        }
    }

    #[test]
    fn what_is_never_drawn_has_none() {
        for (of, outside) in [
            (KnownDistribution::Uniform { low: 1.0, high: 2.0 }, 2.5),
            (
                KnownDistribution::TruncatedNormal {
                    mean: 1.0,
                    standard_deviation: 1.0,
                    low: 0.0,
                    high: 2.0,
                },
                -0.1,
            ),
            (KnownDistribution::LogNormal { median: 1.0, sigma: 0.5 }, 0.0),
            (KnownDistribution::Triangular { low: 0.0, mode: 1.0, high: 2.0 }, 2.1),
            (KnownDistribution::Beta { alpha: 2.0, beta: 2.0, low: 0.0, high: 2.0 }, 3.0),
            (KnownDistribution::Beta { alpha: 1.0, beta: 1.0, low: 0.0, high: 2.0 }, 3.0),
            (KnownDistribution::Exponential { mean: 2.0 }, -1.0),
            (KnownDistribution::Normal { mean: 2.0, standard_deviation: 0.0 }, 2.1),
            (KnownDistribution::Choice(&listed(3)), 0.5),
        ] {
            assert_eq!(of.tail(&Value::Number(outside)).share, 0.0, "{of:?}");
            assert_eq!(of.tail(&Value::from("a word")).share, 0.0, "{of:?}");
        }
        let constant = KnownDistribution::Normal { mean: 2.0, standard_deviation: 0.0 };
        assert_eq!(constant.tail(&Value::Number(2.0)).share, 1.0);
        // What is not a number of anything is no more usual than nothing.
        let normal = KnownDistribution::Normal { mean: 2.0, standard_deviation: 1.0 };
        assert_eq!(normal.tail(&Value::Number(f64::NAN)).share, 0.0);
    }

    #[test]
    fn units_do_not_matter() {
        let of = |factor: f64| {
            [
                KnownDistribution::Normal { mean: 3.0 * factor, standard_deviation: factor },
                KnownDistribution::LogNormal { median: 3.0 * factor, sigma: 0.6 },
                KnownDistribution::Exponential { mean: 2.0 * factor },
                KnownDistribution::Triangular { low: 0.0, mode: factor, high: 9.0 * factor },
            ]
        };
        for (metres, kilometres) in of(1.0).iter().zip(of(1e-3)) {
            let one = metres.tail(&Value::Number(4.5)).share;
            let other = kilometres.tail(&Value::Number(4.5e-3)).share;
            assert!((one - other).abs() < 1e-12, "{metres:?}: {one} {other}");
        }
    }

    #[test]
    fn numbers_follow_other_values_and_rows_go_together() {
        let origin = Origin::default();
        let gap = DeclaredDraw {
            names: vec!["gap".into()],
            from: DrawSource::Distribution {
                distribution: Distribution::Normal {
                    mean: Expression::Variable("speed".into()),
                    standard_deviation: 1.0.into(),
                },
                unit: "s".into(),
            },
            origin: origin.clone(),
        };
        let at = |gap: f64, speed: f64| {
            BTreeMap::from([("gap".to_string(), Value::Number(gap)), ("speed".into(), Value::Number(speed))])
        };
        assert_eq!(gap.tail(&at(5.0, 5.0)).unwrap().share, 1.0);
        assert!((gap.tail(&at(5.0, 6.959_964)).unwrap().share - 0.05).abs() < 1e-6);
        assert!(gap.tail(&BTreeMap::from([("gap".to_string(), Value::Number(1.0))])).is_err());
        let row = |gap: f64, speed: f64| {
            [gap, speed].map(|one| VariedValue { value: Value::Number(one), label: String::new() }).to_vec()
        };
        let table = DeclaredDraw {
            names: vec!["gap".into(), "speed".into()],
            from: DrawSource::Table(DrawTable {
                file: String::new(),
                stream: String::new(),
                rows: vec![row(1.0, 8.0), row(2.0, 9.0), row(1.0, 8.0), row(3.0, 9.0)],
                weights: vec![1.0, 3.0, 1.0, 5.0],
            }),
            origin,
        };
        let shares =
            [(1.0, 8.0), (2.0, 9.0), (3.0, 9.0), (1.0, 9.0)].map(|(gap, speed)| table.tail(&at(gap, speed)));
        let shares = shares.map(|one| one.unwrap().share);
        for (found, expected) in shares.into_iter().zip([0.2, 0.5, 1.0, 0.0]) {
            assert!((found - expected).abs() < 1e-12, "{shares:?}");
        }
    }
}
