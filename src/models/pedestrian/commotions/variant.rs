//! A variant of the model: which psychological assumptions it makes, and the published name that says so (§9).

use std::fmt;
use std::str::FromStr;

use scenario::TextError;

/// How the other's movement is perceived (§3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sensing {
    /// Exactly.
    #[default]
    Exact,
    /// `oSNc`: with noise of constant standard deviation on the distance.
    ConstantNoise,
    /// `oSNv`: with noise of constant angular size, so that it varies with the distance.
    AngularNoise,
}

/// How evidence grows into an action (§8.5, §8.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Accumulation {
    /// No memory: the best action of the moment is taken.
    #[default]
    None,
    /// `oEA`: value estimates are leaky integrals that have to pass a threshold.
    Evidence,
    /// `oDA`: the surplus of each action is accumulated to a threshold.
    Decision,
}

/// The assumptions of one variant.
///
/// Parsed from and printed as the published name, for example `oVAoBEvoAIoEAoSNvoPF`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Variant {
    /// `oVAa`: the other's acceleration is taken into account.
    pub other_acceleration: bool,
    /// `oVAl`: looming on a collision course costs value.
    pub looming: bool,
    /// `oBEo`: what the other does is evidence about its intention.
    pub observation_beliefs: bool,
    /// `oBEv`: what is good for the other is evidence about its intention.
    pub value_beliefs: bool,
    /// `oAI`: the other is assumed to react to one's own actions.
    pub anticipated_influence: bool,
    /// `oEA`, `oDA` or neither.
    pub accumulation: Accumulation,
    /// `oAN`: noise on the values.
    pub value_noise: bool,
    /// `oSNc`, `oSNv` or neither.
    pub sensing: Sensing,
    /// `oPF`: perception is filtered by what is known of the other's movement.
    pub perceptual_filtering: bool,
}

/// The published names of the assumptions, in the order a variant's name lists them.
const ASSUMPTIONS: [&str; 12] =
    ["oVA", "oVAa", "oVAl", "oBEo", "oBEv", "oAI", "oEA", "oDA", "oAN", "oSNc", "oSNv", "oPF"];

/// Pairs of assumptions that contradict each other, and why.
const CONTRADICTIONS: [(&str, &str, &str); 4] = [
    ("oEA", "oDA", "evidence is accumulated in one way or the other"),
    ("oSNc", "oSNv", "sensory noise is constant or angular"),
    ("oAN", "oSNc", "noise is on the values or on the senses"),
    ("oAN", "oSNv", "noise is on the values or on the senses"),
];

/// Why a name is not that of a variant.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum VariantError {
    /// A part of the name is no assumption.
    Unknown {
        /// The name given.
        name: String,
        /// The part that is not understood.
        found: String,
    },
    /// An assumption is made twice.
    Repeated {
        /// The name given.
        name: String,
        /// The assumption.
        assumption: &'static str,
    },
    /// Two assumptions contradict each other.
    Contradiction {
        /// The name given.
        name: String,
        /// One of the two.
        first: &'static str,
        /// The other.
        second: &'static str,
        /// Why not both.
        reason: &'static str,
    },
    /// An assumption needs another one.
    Missing {
        /// The name given.
        name: String,
        /// The assumption.
        assumption: &'static str,
        /// What is needed.
        needs: &'static str,
    },
}

impl std::error::Error for VariantError {}

impl fmt::Display for VariantError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.message(), self.hint())
    }
}

impl VariantError {
    /// What is wrong.
    pub fn message(&self) -> String {
        match self {
            Self::Unknown { name, found } => format!("unknown assumption `{found}` in the variant `{name}`"),
            Self::Repeated { name, assumption } => format!("the variant `{name}` says `{assumption}` twice"),
            Self::Contradiction { name, first, second, reason } => format!(
                "the variant `{name}` contradicts itself: `{first}` and `{second}` exclude each other ({reason})"
            ),
            Self::Missing { name, assumption, needs } => {
                format!("the variant `{name}` says `{assumption}` without {needs}")
            }
        }
    }

    /// What to write instead.
    pub fn hint(&self) -> String {
        match self {
            Self::Unknown { found, .. } => match nearest(found) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the assumptions are {}", ASSUMPTIONS.join(", ")),
            },
            Self::Repeated { .. } => "say it once".to_string(),
            Self::Contradiction { first, second, .. } => format!("leave out `{first}` or `{second}`"),
            Self::Missing { .. } => "add it".to_string(),
        }
    }
}

/// For [`Parameter::text`](scenario::Parameter::text).
pub fn check(name: &str, _: &dyn Fn(&str) -> bool) -> Vec<TextError> {
    let error = name.parse::<Variant>().err();
    let text_error = |error: VariantError| TextError {
        message: error.message(),
        hint: Some(error.hint()),
        part: String::new(),
    };
    error.map(text_error).into_iter().collect()
}

fn nearest(found: &str) -> Option<&'static str> {
    ASSUMPTIONS
        .iter()
        .map(|name| (strsim::damerau_levenshtein(found, name), *name))
        .min()
        .filter(|&(distance, _)| distance <= 2)
        .map(|(_, name)| name)
}

/// Cuts a name before every `o` that a capital follows.
fn parts(name: &str) -> impl Iterator<Item = &str> {
    let is_start =
        |i: usize| name[i..].starts_with('o') && name[i + 1..].starts_with(|c: char| c.is_ascii_uppercase());
    let mut starts: Vec<usize> =
        name.char_indices().map(|(i, _)| i).filter(|&i| i == 0 || is_start(i)).collect();
    starts.push(name.len());
    (1..starts.len()).map(move |i| &name[starts[i - 1]..starts[i]])
}

impl FromStr for Variant {
    type Err = VariantError;

    fn from_str(name: &str) -> Result<Self, VariantError> {
        let mut made: Vec<&'static str> = Vec::new();
        for part in parts(name) {
            let assumption = ASSUMPTIONS
                .iter()
                .copied()
                .find(|&a| a == part)
                .ok_or_else(|| VariantError::Unknown { name: name.to_owned(), found: part.to_owned() })?;
            if made.contains(&assumption) {
                return Err(VariantError::Repeated { name: name.to_owned(), assumption });
            }
            made.push(assumption);
        }
        let says = |assumption| made.contains(&assumption);
        for (first, second, reason) in CONTRADICTIONS {
            if says(first) && says(second) {
                return Err(VariantError::Contradiction { name: name.to_owned(), first, second, reason });
            }
        }
        let missing =
            |assumption, needs| Err(VariantError::Missing { name: name.to_owned(), assumption, needs });
        if says("oPF") && !says("oSNc") && !says("oSNv") {
            return missing("oPF", "the sensory noise it filters, `oSNc` or `oSNv`");
        }
        // `oVAa` is `oVA` with one thing more.
        if !says("oVA") && !says("oVAa") {
            let assumption = made.first().copied().unwrap_or("nothing");
            return missing(assumption, "the affordance-based values `oVA` or `oVAa`");
        }
        Ok(Self {
            other_acceleration: says("oVAa"),
            looming: says("oVAl"),
            observation_beliefs: says("oBEo"),
            value_beliefs: says("oBEv"),
            anticipated_influence: says("oAI"),
            accumulation: if says("oEA") {
                Accumulation::Evidence
            } else if says("oDA") {
                Accumulation::Decision
            } else {
                Accumulation::None
            },
            value_noise: says("oAN"),
            sensing: if says("oSNc") {
                Sensing::ConstantNoise
            } else if says("oSNv") {
                Sensing::AngularNoise
            } else {
                Sensing::Exact
            },
            perceptual_filtering: says("oPF"),
        })
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.other_acceleration { "oVAa" } else { "oVA" })?;
        let made = [
            (self.looming, "oVAl"),
            (self.observation_beliefs, "oBEo"),
            (self.value_beliefs, "oBEv"),
            (self.anticipated_influence, "oAI"),
            (self.accumulation == Accumulation::Evidence, "oEA"),
            (self.accumulation == Accumulation::Decision, "oDA"),
            (self.value_noise, "oAN"),
            (self.sensing == Sensing::ConstantNoise, "oSNc"),
            (self.sensing == Sensing::AngularNoise, "oSNv"),
            (self.perceptual_filtering, "oPF"),
        ];
        made.iter().filter(|(says, _)| *says).try_for_each(|(_, name)| f.write_str(name))
    }
}

impl Variant {
    /// The variant used for stochastic pedestrians by default: `oVAoBEvoAIoEAoSNvoPF`.
    pub const STANDARD: Self = Self {
        other_acceleration: false,
        looming: false,
        observation_beliefs: false,
        value_beliefs: true,
        anticipated_influence: true,
        accumulation: Accumulation::Evidence,
        value_noise: false,
        sensing: Sensing::AngularNoise,
        perceptual_filtering: true,
    };

    /// Whether the other's behaviour is estimated at all (`oBEo` or `oBEv`).
    pub fn estimates_behaviour(&self) -> bool {
        self.observation_beliefs || self.value_beliefs
    }

    /// Whether two runs with the same inputs differ only by their noise draws.
    pub fn is_stochastic(&self) -> bool {
        self.value_noise || self.sensing != Sensing::Exact
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_published_combination_is_understood_and_printed_back() {
        let mut count = 0;
        for values in ["oVA", "oVAoVAl", "oVAaoVAl", "oVAa"] {
            for beliefs in ["oBEvoAI", "oBEooBEvoAI", "oBEv", "oBEo", ""] {
                for accumulation in ["", "oEA", "oDA"] {
                    for noise in ["", "oAN", "oSNc", "oSNv", "oSNcoPF", "oSNvoPF"] {
                        let name = format!("{values}{beliefs}{accumulation}{noise}");
                        let variant: Variant = name.parse().unwrap();
                        assert_eq!(variant.to_string(), name);
                        count += 1;
                    }
                }
            }
        }
        assert_eq!(count, 4 * 5 * 3 * 6);
    }

    #[test]
    fn the_standard_variant_is_the_published_default() {
        assert_eq!("oVAoBEvoAIoEAoSNvoPF".parse(), Ok(Variant::STANDARD));
    }

    #[test]
    fn affordances_with_acceleration_imply_affordances() {
        assert_eq!("oVAoVAaoVAl".parse::<Variant>(), "oVAaoVAl".parse());
    }

    #[test]
    fn wrong_names_say_what_is_wrong() {
        let said: Vec<String> = [
            "oVAoBEvoPF",
            "oVAoBEvoANoSNv",
            "oVAoSNcoSNv",
            "oVAoEAoDA",
            "oBEvoAI",
            "oVAoBEvoBEv",
            "oVAoBExoAI",
            "OVA",
            "",
            "oVAßoAI",
        ]
        .iter()
        .map(|name| name.parse::<Variant>().unwrap_err().to_string())
        .collect();
        insta::assert_snapshot!(said.join("\n"));
    }
}
