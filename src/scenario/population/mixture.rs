//! Populations as one: everybody of each, with the share of it that each is of the mixture.

use std::collections::BTreeMap;

use serde_json::json;
use thiserror::Error;

use super::{Population, VEHICLE_SPEEDS};

/// A population of a mixture.
#[derive(Debug, Clone, PartialEq)]
pub struct MixturePart {
    /// Its name or file, for messages and for where the mixture comes from.
    pub name: String,
    /// Who is in it.
    pub population: Population,
    /// What part of the mixture they are, above 0; of all equal parts where no part says so.
    pub share: Option<f64>,
}

/// Why populations do not mix.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MixtureError {
    /// One population is no mixture.
    #[error("{found} population is no mixture; name two at least")]
    TooFew {
        /// Populations.
        found: usize,
    },
    /// The same people stand there twice.
    #[error("`{second}` has the same people as `{first}`: they would count twice")]
    Repeated {
        /// The earlier one.
        first: String,
        /// The other.
        second: String,
    },
    /// They are of different models, variants or parameters.
    #[error("`{second}` has {found} where `{first}` has {expected}: they cannot stand in one population")]
    Other {
        /// The first of the mixture.
        first: String,
        /// The one that differs.
        second: String,
        /// Of the first, in words.
        expected: String,
        /// Of the other, in words.
        found: String,
    },
    /// Some parts say what share they are, and others do not.
    #[error("`{name}` says no share, and others do; say it of all or of none")]
    NoShare {
        /// The part.
        name: String,
    },
    /// A share is none.
    #[error("the share of `{name}` is {share}, but must be above 0 and below 1")]
    Share {
        /// The part.
        name: String,
        /// Its share.
        share: f64,
    },
    /// Shares do not add up to 1.
    #[error("the shares add up to {sum}, not to 1")]
    Sum {
        /// Of all shares.
        sum: f64,
    },
}

/// By how much shares may miss a sum of 1.
const ROUNDED: f64 = 1e-6;

impl Population {
    /// The populations as one: their rows one after the other, with weights that are those of each times its share. Where each comes from is
    /// kept, as are all speeds of vehicles that people of any of them were observed with.
    ///
    /// # Errors
    /// Where the populations are of different models, variants or parameters, and where shares are none or do not add up to 1.
    pub fn mixture(parts: &[MixturePart]) -> Result<Self, MixtureError> {
        let (first, others) = match parts {
            [first, others @ ..] if !others.is_empty() => (first, others),
            _ => return Err(MixtureError::TooFew { found: parts.len() }),
        };
        let shares = shares(parts)?;
        for (index, part) in parts.iter().enumerate() {
            let digest = part.population.digest();
            if let Some(same) = parts[..index].iter().find(|one| one.population.digest() == digest) {
                return Err(MixtureError::Repeated { first: same.name.clone(), second: part.name.clone() });
            }
        }
        for other in others {
            first.mixes_with(other)?;
        }
        let names = &first.population.parameters;
        let (mut individuals, mut weights, mut told) = (Vec::new(), Vec::new(), Vec::new());
        let mut speeds = Vec::new();
        for (MixturePart { name, population, .. }, share) in parts.iter().zip(&shares) {
            let columns: Vec<usize> = names
                .iter()
                .filter_map(|name| population.parameters.iter().position(|own| own == name))
                .collect();
            let row = |row: &Vec<f64>| columns.iter().map(|column| row[*column]).collect();
            individuals.extend(population.individuals.iter().map(row));
            let equal = 1.0 / population.individuals.len() as f64;
            let own =
                (0..population.individuals.len()).map(|at| population.weights.get(at).unwrap_or(&equal));
            weights.extend(own.map(|weight| weight * share));
            told.push(json!({
                "population": name,
                "digest": population.digest(),
                "share": share,
                "source": population.source,
                "provenance": population.provenance,
            }));
            let known = population.provenance.get(VEHICLE_SPEEDS).and_then(serde_json::Value::as_array);
            speeds.extend(known.into_iter().flatten().filter_map(serde_json::Value::as_f64));
        }
        let tool = format!("scenario-runner {} calibrate --mix", env!("CARGO_PKG_VERSION"));
        let mut provenance =
            BTreeMap::from([("tool".to_owned(), json!(tool)), ("mixture".to_owned(), json!(told))]);
        speeds.sort_by(f64::total_cmp);
        speeds.dedup();
        if !speeds.is_empty() {
            provenance.insert(VEHICLE_SPEEDS.to_owned(), json!(speeds));
        }
        let sources = parts.iter().zip(&shares).map(|(part, share)| {
            format!("{} % of {}: {}", crate::significant(100.0 * share, 6), part.name, part.population.source)
        });
        Ok(Self {
            model: first.population.model.clone(),
            variant: first.population.variant.clone(),
            source: format!("a mixture: {}", sources.collect::<Vec<_>>().join("; ")),
            provenance,
            parameters: names.clone(),
            individuals,
            weights,
        })
    }
}

fn shares(parts: &[MixturePart]) -> Result<Vec<f64>, MixtureError> {
    if parts.iter().all(|part| part.share.is_none()) {
        return Ok(vec![1.0 / parts.len() as f64; parts.len()]);
    }
    let share = |part: &MixturePart| {
        let share = part.share.ok_or_else(|| MixtureError::NoShare { name: part.name.clone() })?;
        if share > 0.0 && share < 1.0 {
            return Ok(share);
        }
        Err(MixtureError::Share { name: part.name.clone(), share })
    };
    let shares = parts.iter().map(share).collect::<Result<Vec<f64>, _>>()?;
    let sum: f64 = shares.iter().sum();
    if (sum - 1.0).abs() > ROUNDED {
        return Err(MixtureError::Sum { sum });
    }
    Ok(shares.iter().map(|share| share / sum).collect())
}

impl MixturePart {
    fn mixes_with(&self, other: &Self) -> Result<(), MixtureError> {
        let differ = |expected: String, found: String| MixtureError::Other {
            first: self.name.clone(),
            second: other.name.clone(),
            expected,
            found,
        };
        let (one, two) = (&self.population, &other.population);
        if one.model != two.model {
            return Err(differ(format!("the model `{}`", one.model), format!("the model `{}`", two.model)));
        }
        if one.variant != two.variant {
            let words = |variant: &Option<String>| {
                variant
                    .as_ref()
                    .map_or_else(|| "no variant".to_string(), |name| format!("the variant `{name}`"))
            };
            return Err(differ(words(&one.variant), words(&two.variant)));
        }
        let sorted = |population: &Population| {
            let mut names = population.parameters.clone();
            names.sort();
            names
        };
        if sorted(one) != sorted(two) {
            let words =
                |population: &Population| format!("the parameters `{}`", population.parameters.join("`, `"));
            return Err(differ(words(one), words(two)));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn people(source: &str, parameters: [&str; 2], rows: &[[f64; 2]], weights: &[f64]) -> Population {
        Population {
            model: "commotions".into(),
            variant: None,
            source: source.into(),
            provenance: BTreeMap::from([(VEHICLE_SPEEDS.to_owned(), json!([rows[0][0]]))]),
            parameters: parameters.map(String::from).to_vec(),
            individuals: rows.iter().map(|row| row.to_vec()).collect(),
            weights: weights.to_vec(),
        }
    }

    fn part(name: &str, population: Population, share: Option<f64>) -> MixturePart {
        MixturePart { name: name.into(), population, share }
    }

    fn two(shares: [Option<f64>; 2]) -> [MixturePart; 2] {
        let one = people("here", ["T", "beta_V"], &[[0.1, 10.0], [0.2, 20.0]], &[0.25, 0.75]);
        let other = people("there", ["beta_V", "T"], &[[30.0, 0.3], [40.0, 0.4], [50.0, 0.5]], &[]);
        [part("one.json", one, shares[0]), part("other.json", other, shares[1])]
    }

    #[test]
    fn everybody_is_in_it_with_weight_times_share() {
        let halves = Population::mixture(&two([None, None])).unwrap();
        assert_eq!(halves.parameters, ["T", "beta_V"]);
        assert_eq!(halves.individuals[1..3], [[0.2, 20.0], [0.3, 30.0]]);
        assert_eq!(halves.weights[..2], [0.125, 0.375]);
        assert!(halves.weights[2..].iter().all(|weight| (weight - 1.0 / 6.0).abs() < 1e-12));
        let parts = two([Some(0.2), Some(0.8)]);
        let unequal = Population::mixture(&parts).unwrap();
        assert!((unequal.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!((unequal.weights[..2].iter().sum::<f64>() - 0.2).abs() < 1e-12);
        assert_ne!(unequal.digest(), halves.digest());
        // Where both come from stands in it.
        assert_eq!(unequal.source, "a mixture: 20 % of one.json: here; 80 % of other.json: there");
        let told = unequal.provenance["mixture"].as_array().unwrap();
        assert_eq!(told[1]["digest"], json!(parts[1].population.digest()));
        assert_eq!((&told[0]["share"], &told[0]["source"]), (&json!(0.2), &json!("here")));
        assert_eq!(unequal.provenance[VEHICLE_SPEEDS], json!([0.1, 30.0]));
    }

    #[test]
    fn what_does_not_mix_says_so() {
        let said = |parts: &[MixturePart]| Population::mixture(parts).unwrap_err().to_string();
        let [one, other] = two([None, None]);
        let changed = |change: &dyn Fn(&mut Population)| {
            let mut part = other.clone();
            change(&mut part.population);
            said(&[one.clone(), part])
        };
        let all = [
            said(&[]),
            said(std::slice::from_ref(&one)),
            said(&[one.clone(), MixturePart { name: "copy.json".into(), ..one.clone() }]),
            said(&two([Some(0.5), None])),
            said(&two([Some(1.0), Some(0.5)])),
            said(&two([Some(f64::NAN), Some(0.5)])),
            said(&two([Some(0.5), Some(0.4)])),
            changed(&|population| population.model = "reactive".into()),
            changed(&|population| population.variant = Some("oVA".into())),
            changed(&|population| population.parameters[0] = "T_delta".into()),
        ];
        insta::assert_snapshot!(all.join("\n"));
    }
}
