//! Parameters that candidates have from a distribution: `ped_free_speed=truncated_normal(1.34, 0.26, 0.5, 2.2)`.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use super::candidates::{CandidateError, Candidates, six_digits};
use numbers::design::Slices;
use numbers::random::{Stream, derive_seed};
use scenario::{
    DISTRIBUTIONS, Declaration, Distribution, DistributionOf, DrawnValue, Expression, NumberOf, Value,
};

/// A parameter and what candidates have it from, SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnParameter {
    /// The parameter.
    pub name: String,
    distribution: Distribution,
    /// As it is written.
    words: String,
}

impl fmt::Display for DrawnParameter {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} from {}", self.name, self.words)
    }
}

impl FromStr for DrawnParameter {
    type Err = String;

    /// Reads `NAME=DISTRIBUTION(NUMBER, …)`.
    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "`{text}` is no draw; write it like ped_free_speed=truncated_normal(1.34, 0.26, 0.5, 2.2), in SI units"
            )
        };
        let (name, distribution) = text.split_once('=').ok_or_else(expected)?;
        let (word, rest) = distribution.trim().split_once('(').ok_or_else(expected)?;
        let given = rest.strip_suffix(')').ok_or_else(expected)?;
        let word = word.trim();
        let known = DISTRIBUTIONS.iter().filter_map(|known| match known.of {
            DistributionOf::Numbers(names, make) => Some((known.word, names, make)),
            DistributionOf::Values => None,
        });
        let Some((_, names, make)) = known.clone().find(|(known, ..)| *known == word) else {
            let all: Vec<_> = known.map(|(word, names, _)| usage(word, names)).collect();
            return Err(format!("there is no distribution `{word}` here; there are {}", all.join(", ")));
        };
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
        let numbers: Option<Vec<Expression>> =
            given.split(',').map(|one| number(one).map(Expression::number)).collect();
        let made = numbers.filter(|numbers| numbers.len() == names.len()).and_then(make);
        let distribution = made.ok_or_else(|| {
            format!("`{word}` takes {} numbers in SI units: {}", names.len(), usage(word, names))
        })?;
        distribution.known(&BTreeMap::new()).map_err(|error| match error.hint() {
            Some(hint) => format!("`{word}`: {error}; {hint}"),
            None => format!("`{word}`: {error}"),
        })?;
        let given: Vec<&str> = given.split(',').map(str::trim).collect();
        let words = format!("{word}({})", given.join(", "));
        Ok(Self { name: name.trim().to_string(), distribution, words })
    }
}

/// Such as `normal(mean, standard deviation)`.
fn usage(word: &str, names: &[NumberOf]) -> String {
    let names: Vec<&str> = names.iter().map(|number| number.name).collect();
    format!("`{word}({})`", names.join(", "))
}

impl Candidates {
    /// The same candidates with more parameters, each in strata of its distribution, equally likely: who has which value is drawn by
    /// `seed`.
    ///
    /// # Errors
    /// For parameters that there are not or that the candidates have, and for values that a parameter may not have.
    pub fn with_draws(
        mut self,
        draws: &[DrawnParameter],
        seed: u64,
        model: &Declaration,
    ) -> Result<Self, CandidateError> {
        for drawn in draws {
            let DrawnParameter { name, distribution, .. } = drawn;
            let parameter =
                model.parameter(name).ok_or_else(|| CandidateError::UnknownParameter(name.clone()))?;
            if self.names.contains(name) {
                return Err(CandidateError::Given(parameter.name.clone()));
            }
            let impossible = |error: &dyn fmt::Display| CandidateError::BadDraw {
                draw: drawn.to_string(),
                reason: error.to_string(),
            };
            let known = distribution.known(&BTreeMap::new()).map_err(|error| impossible(&error))?;
            let mut stream = Stream::seeded(derive_seed(seed, &format!("candidates/{name}")));
            let slices = Slices::drawn(self.rows.len(), &mut stream);
            for (index, row) in self.rows.iter_mut().enumerate() {
                let DrawnValue::Number(value) = known.quantile(slices.place(index, &mut stream)) else {
                    return Err(impossible(&"it has no numbers"));
                };
                let value = six_digits(value);
                parameter.check(&model.name, &Value::Number(value)).map_err(|error| impossible(&error))?;
                row.push(value);
            }
            self.names.push(name.clone());
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::commotions::model::commotions;

    fn hundred() -> Candidates {
        Candidates { names: vec!["T_delta".into()], rows: (0..100).map(|_| vec![20.0]).collect() }
    }

    fn drawn(text: &str) -> Result<Candidates, String> {
        let draw: DrawnParameter = text.parse()?;
        hundred().with_draws(&[draw], 1, &commotions().declaration).map_err(|error| error.to_string())
    }

    #[test]
    fn each_stratum_has_one_and_the_moments_are_those_of_the_distribution() {
        let found = drawn("ped_free_speed=normal(1.34, 0.26)").unwrap();
        assert_eq!(found.names, ["T_delta", "ped_free_speed"]);
        let mut speeds: Vec<f64> = found.rows.iter().map(|row| row[1]).collect();
        speeds.sort_by(f64::total_cmp);
        // Half of them below the mean, and a quarter 0.6745 deviations below it.
        assert!(speeds[49] <= 1.34 && speeds[50] >= 1.34);
        let quarter = 1.34 - 0.674_49 * 0.26;
        assert!(speeds[24] <= quarter && speeds[25] >= quarter, "{} {}", speeds[24], speeds[25]);
        let mean = speeds.iter().sum::<f64>() / 100.0;
        let square = speeds.iter().map(|one| (one - mean) * (one - mean)).sum::<f64>() / 100.0;
        assert!((mean - 1.34).abs() < 0.005 && (square.sqrt() - 0.26).abs() < 0.01, "{mean} {square}");
        // Who has which is drawn.
        assert_ne!(found.rows.iter().map(|row| row[1]).collect::<Vec<_>>(), speeds);
        assert_eq!(found, drawn("ped_free_speed = normal( 1.34 ,0.26 )").unwrap());
    }

    #[test]
    fn what_cannot_be_drawn_says_why() {
        let said = |text: &str| drawn(text).unwrap_err();
        assert!(said("ped_free_speed").contains("write it like ped_free_speed=truncated_normal("));
        assert!(said("ped_free_speed=normal 1.34").contains("write it like"));
        assert!(said("ped_free_speed=gauss(1.34, 0.26)").contains("there is no distribution `gauss` here"));
        assert!(
            said("ped_free_speed=normal(1.34)")
                .contains("takes 2 numbers in SI units: `normal(mean, standard deviation)`")
        );
        assert!(said("ped_free_speed=normal(1.34, 0.26 m/s)").contains("takes 2 numbers in SI units"));
        assert!(said("ped_free_speed=normal(1.34, -1)").contains("give a standard deviation of at least 0"));
        assert!(said("ped_free_speed=normal(1.34, nan)").contains("takes 2 numbers"));
        assert_eq!(said("speed=normal(1.34, 0.26)"), "there is no parameter `speed`");
        assert!(said("T_delta=normal(20, 1)").contains("leave out its range or draw"));
        let outside = said("ped_free_speed=normal(1.34, 5)");
        assert!(outside.contains("`ped_free_speed` of `commotions` is"), "{outside}");
        assert!(outside.contains("truncated_normal(mean, standard deviation, low, high)"), "{outside}");
    }
}
