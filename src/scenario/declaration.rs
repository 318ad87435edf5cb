//! How models, controllers, dynamics and metrics declare themselves: the one vocabulary of every registry.
//!
//! The checker, `scenario-runner models`, the documentation, the JSON Schema and the ranges of `tune` all read these.

use thiserror::Error;

use super::{Dimension, Settings, Value, show, show_both, show_outside};

/// What a registered thing says about itself.
#[derive(Debug, Clone, Copy)]
pub struct Declaration {
    /// The word used in scenario files.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Where it comes from: paper and equation, or file and version.
    pub source: &'static str,
    pub parameters: &'static [Parameter],
    pub presets: Option<PresetFamily>,
}

/// Whether a registered thing can draw from the run's random streams, so that its run may differ from one under another
/// seed. Where that is not sure, it can.
#[derive(Debug, Clone, Copy)]
pub enum Chance {
    Never,
    /// Whatever its settings.
    Always,
    /// Where this holds for its settings, resolved against its declaration.
    If(fn(&Settings) -> bool),
}

impl Chance {
    pub fn possible(self, settings: &Settings) -> bool {
        match self {
            Self::Never => false,
            Self::Always => true,
            Self::If(holds) => holds(settings),
        }
    }
}

/// Named sets of defaults, chosen by one word such as `profile: aggressive`.
#[derive(Debug, Clone, Copy)]
pub struct PresetFamily {
    /// The name that the preset is chosen by, such as `profile`.
    pub word: &'static str,
    pub default: &'static str,
    pub presets: &'static [Preset],
}

#[derive(Debug, Clone, Copy)]
pub struct Preset {
    pub name: &'static str,
    pub doc: &'static str,
    pub values: &'static [(&'static str, Literal)],
}

/// A [`Value`] that can stand in a constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Literal {
    Flag(bool),
    Number(f64),
    Word(&'static str),
}

impl From<Literal> for Value {
    fn from(literal: Literal) -> Self {
        match literal {
            Literal::Flag(flag) => Self::Flag(flag),
            Literal::Number(number) => Self::Number(number),
            Literal::Word(word) => Self::Word(word.to_string()),
        }
    }
}

/// One parameter of a registered thing.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    pub name: &'static str,
    /// One line.
    pub doc: &'static str,
    pub source: &'static str,
    pub kind: ParameterKind,
    /// The one value that was published beside the other settings, for a number that is no free choice: with another the
    /// model is another one, which nobody fitted to anything.
    pub published: Option<Published>,
}

/// Takes resolved settings.
pub type Published = fn(&Settings) -> f64;

/// The flag by which settings say that a number beside the published ones is meant.
pub const ANOTHER_MODEL: &str = "another_model";

/// A setting that makes another model than was published.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "`{parameter}` of `{owner}` is {} where {} was published, which makes it another model",
    show_both(*found, *published, *dimension).0,
    show_both(*found, *published, *dimension).1
)]
pub struct Departure {
    pub owner: &'static str,
    pub parameter: &'static str,
    pub found: f64,
    pub published: f64,
    pub dimension: Dimension,
}

#[derive(Debug, Clone, Copy)]
pub enum ParameterKind {
    /// A quantity in SI units within an inclusive range; without a default it may stay absent.
    Number {
        dimension: Dimension,
        default: Option<f64>,
        range: (f64, f64),
    },
    /// A whole number within an inclusive range.
    Whole {
        default: i64,
        range: (i64, i64),
    },
    Flag {
        default: bool,
    },
    Choice {
        default: &'static str,
        options: &'static [ChoiceOption],
    },
    /// Free text in a language of the model's own, such as a variant's name.
    Text {
        default: &'static str,
        check: TextCheck,
    },
}

/// Everything that is wrong with a text; `given` says which other parameters of the model have a value.
pub type TextCheck = fn(text: &str, given: &dyn Fn(&str) -> bool) -> Vec<TextError>;

/// Why a model does not understand a text.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct TextError {
    pub message: String,
    /// What to write instead.
    pub hint: Option<String>,
    /// The part of the text that is meant; empty for all of it.
    pub part: String,
}

/// One word that a [`ParameterKind::Choice`] may take.
#[derive(Debug, Clone, Copy)]
pub struct ChoiceOption {
    pub name: &'static str,
    pub doc: &'static str,
}

/// Why a setting does not fit its declaration.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SettingError {
    #[error("`{owner}` has no parameter `{name}`")]
    UnknownParameter { owner: &'static str, name: String },
    #[error("`{name}` of `{owner}` must be {expected}, but is {found}")]
    WrongType { owner: &'static str, name: String, expected: String, found: String },
    #[error("`{name}` of `{owner}` is {}, outside {low} .. {high}{unit}", show_outside(*found, (*low, *high)))]
    OutOfRange { owner: &'static str, name: String, found: f64, low: f64, high: f64, unit: String },
    #[error("`{name}` of `{owner}` has no option `{found}`")]
    UnknownOption { owner: &'static str, name: String, found: String, options: Vec<&'static str> },
}

impl Parameter {
    pub const fn number(
        name: &'static str,
        dimension: Dimension,
        default: f64,
        range: (f64, f64),
        doc: &'static str,
        source: &'static str,
    ) -> Self {
        let kind = ParameterKind::Number { dimension, default: Some(default), range };
        Self { name, doc, source, kind, published: None }
    }

    /// A number that may stay absent.
    pub const fn optional(
        name: &'static str,
        dimension: Dimension,
        range: (f64, f64),
        doc: &'static str,
        source: &'static str,
    ) -> Self {
        let kind = ParameterKind::Number { dimension, default: None, range };
        Self { name, doc, source, kind, published: None }
    }

    pub const fn whole(
        name: &'static str,
        default: i64,
        range: (i64, i64),
        doc: &'static str,
        source: &'static str,
    ) -> Self {
        Self { name, doc, source, kind: ParameterKind::Whole { default, range }, published: None }
    }

    pub const fn flag(name: &'static str, default: bool, doc: &'static str, source: &'static str) -> Self {
        Self { name, doc, source, kind: ParameterKind::Flag { default }, published: None }
    }

    pub const fn choice(
        name: &'static str,
        default: &'static str,
        options: &'static [ChoiceOption],
        doc: &'static str,
        source: &'static str,
    ) -> Self {
        Self { name, doc, source, kind: ParameterKind::Choice { default, options }, published: None }
    }

    pub const fn text(
        name: &'static str,
        default: &'static str,
        check: TextCheck,
        doc: &'static str,
        source: &'static str,
    ) -> Self {
        Self { name, doc, source, kind: ParameterKind::Text { default, check }, published: None }
    }

    /// The same, published with the value that `published` says.
    pub const fn published_with(self, published: Published) -> Self {
        Self { published: Some(published), ..self }
    }

    /// The value it has when nobody says otherwise.
    pub fn default_value(&self) -> Option<Value> {
        match self.kind {
            ParameterKind::Number { default, .. } => default.map(Value::Number),
            ParameterKind::Whole { default, .. } => Some(Value::Number(default as f64)),
            ParameterKind::Flag { default } => Some(Value::Flag(default)),
            ParameterKind::Choice { default, .. } | ParameterKind::Text { default, .. } => {
                Some(Value::Word(default.to_string()))
            }
        }
    }

    /// Checks type, range and options of one value; `owner` is named in the error.
    pub fn check(&self, owner: &'static str, value: &Value) -> Result<(), SettingError> {
        let wrong = |expected: String| SettingError::WrongType {
            owner,
            name: self.name.to_string(),
            expected,
            found: match value {
                Value::Number(number) => show(*number, None, Dimension::NUMBER),
                other => other.to_string(),
            },
        };
        let outside = |found: f64, low: f64, high: f64, unit: String| SettingError::OutOfRange {
            owner,
            name: self.name.to_string(),
            found,
            low,
            high,
            unit: if unit.is_empty() { unit } else { format!(" {unit}") },
        };
        match (self.kind, value) {
            (ParameterKind::Number { dimension, range: (low, high), .. }, Value::Number(number)) => {
                if (low..=high).contains(number) {
                    Ok(())
                } else {
                    Err(outside(*number, low, high, dimension.si_unit()))
                }
            }
            (ParameterKind::Whole { range: (low, high), .. }, Value::Number(number)) => {
                if number.fract() != 0.0 {
                    Err(wrong("a whole number".to_string()))
                } else if (low as f64..=high as f64).contains(number) {
                    Ok(())
                } else {
                    Err(outside(*number, low as f64, high as f64, String::new()))
                }
            }
            (ParameterKind::Flag { .. }, Value::Flag(_)) | (ParameterKind::Text { .. }, Value::Word(_)) => {
                Ok(())
            }
            (ParameterKind::Choice { options, .. }, Value::Word(word)) => {
                if options.iter().any(|option| option.name == word) {
                    Ok(())
                } else {
                    Err(SettingError::UnknownOption {
                        owner,
                        name: self.name.to_string(),
                        found: word.clone(),
                        options: options.iter().map(|option| option.name).collect(),
                    })
                }
            }
            (kind, _) => Err(wrong(kind.expectation())),
        }
    }
}

impl ParameterKind {
    /// What a value must be, for error messages: "a length in m", "true or false".
    pub fn expectation(&self) -> String {
        match self {
            Self::Number { dimension: Dimension::NUMBER, .. } => "a plain number".to_string(),
            Self::Number { dimension, .. } => format!("a {} in {}", dimension.name(), dimension.si_unit()),
            Self::Whole { .. } => "a whole number".to_string(),
            Self::Flag { .. } => "`true` or `false`".to_string(),
            Self::Choice { options, .. } => {
                let names: Vec<_> = options.iter().map(|option| format!("`{}`", option.name)).collect();
                format!("one of {}", names.join(", "))
            }
            Self::Text { .. } => "a word".to_string(),
        }
    }
}

impl Declaration {
    pub fn parameter(&self, name: &str) -> Option<&'static Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    pub fn preset(&self, name: &str) -> Option<&'static Preset> {
        self.presets?.presets.iter().find(|preset| preset.name == name)
    }

    /// Whatever of resolved `settings` makes another model than was published.
    pub fn departures(&self, settings: &Settings) -> Vec<Departure> {
        let departure = |parameter: &Parameter| {
            let (published, found) =
                (parameter.published?(settings), settings.optional_number(parameter.name)?);
            let dimension = match parameter.kind {
                ParameterKind::Number { dimension, .. } => dimension,
                _ => Dimension::NUMBER,
            };
            let differs = (found - published).abs() > 1e-9 * published.abs();
            differs.then_some(Departure {
                owner: self.name,
                parameter: parameter.name,
                found,
                published,
                dimension,
            })
        };
        self.parameters.iter().filter_map(departure).collect()
    }

    /// Fills in every parameter: defaults, then the chosen preset, then `given`. Every value is checked.
    pub fn resolve(&self, given: &Settings) -> Result<Settings, SettingError> {
        let resolved = self.fill_in(given)?;
        for parameter in self.parameters {
            given.get(parameter.name).map_or(Ok(()), |value| parameter.check(self.name, value))?;
        }
        Ok(resolved)
    }

    /// As [`Self::resolve`], but values are not checked; names are.
    pub fn fill_in(&self, given: &Settings) -> Result<Settings, SettingError> {
        let mut resolved = Settings::default();
        for parameter in self.parameters {
            if let Some(value) = parameter.default_value() {
                resolved.set(parameter.name, value);
            }
        }
        if let Some(family) = self.presets {
            let chosen = match given.get(family.word) {
                None => family.default.to_string(),
                Some(Value::Word(word)) => word.clone(),
                Some(other) => other.to_string(),
            };
            let preset = self.preset(&chosen).ok_or_else(|| SettingError::UnknownOption {
                owner: self.name,
                name: family.word.to_string(),
                found: chosen.clone(),
                options: family.presets.iter().map(|preset| preset.name).collect(),
            })?;
            for &(name, literal) in preset.values {
                resolved.set(name, literal.into());
            }
            resolved.set(family.word, Value::Word(chosen));
        }
        for (name, value) in &given.0 {
            if self.presets.is_some_and(|family| family.word == name) {
                continue;
            }
            if self.parameter(name).is_none() {
                return Err(SettingError::UnknownParameter { owner: self.name, name: name.clone() });
            }
            resolved.set(name.clone(), value.clone());
        }
        Ok(resolved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAR: Declaration = Declaration {
        name: "car",
        summary: "A car.",
        source: "none",
        parameters: &[
            Parameter::number("gap", Dimension::LENGTH, 5.0, (0.0, 50.0), "A gap.", "none"),
            Parameter::flag("careful", false, "Takes care.", "none"),
            Parameter::optional("speed", Dimension::SPEED, (0.0, 50.0), "A speed.", "none"),
        ],
        presets: Some(PresetFamily {
            word: "profile",
            default: "normal",
            presets: &[
                Preset { name: "normal", doc: "", values: &[] },
                Preset { name: "wild", doc: "", values: &[("gap", Literal::Number(1.0))] },
            ],
        }),
    };

    #[test]
    fn explicit_settings_win_over_presets_and_defaults() {
        let wild = Settings::from([("profile", Value::Word("wild".into()))]);
        assert_eq!(CAR.resolve(&Settings::default()).unwrap().number("gap"), 5.0);
        assert_eq!(CAR.resolve(&wild).unwrap().number("gap"), 1.0);
        let both = Settings::from([("profile", Value::Word("wild".into())), ("gap", Value::Number(7.0))]);
        assert_eq!(CAR.resolve(&both).unwrap().number("gap"), 7.0);
        assert_eq!(CAR.resolve(&both).unwrap().optional_number("speed"), None);
    }

    #[test]
    fn bad_settings_are_named() {
        let error =
            |name: &str, value: Value| CAR.resolve(&Settings::from([(name, value)])).unwrap_err().to_string();
        assert_eq!(error("gap", Value::Number(99.0)), "`gap` of `car` is 99, outside 0 .. 50 m");
        assert_eq!(error("gap", Value::Number(f64::NAN)), "`gap` of `car` is NaN, outside 0 .. 50 m");
        assert_eq!(error("gab", Value::Number(1.0)), "`car` has no parameter `gab`");
        assert_eq!(
            error("careful", Value::Number(1.0)),
            "`careful` of `car` must be `true` or `false`, but is 1"
        );
        assert_eq!(error("profile", Value::Word("x".into())), "`profile` of `car` has no option `x`");
    }
}
