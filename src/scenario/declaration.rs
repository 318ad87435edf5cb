//! How models, controllers, dynamics and metrics declare themselves: the one vocabulary of every registry.
//!
//! The checker, `scenario-runner models`, the documentation, the JSON Schema and the ranges of `tune` all read these.
//! A declaration owns what it says, so that it may be made at run time, from a file or from another language.

use std::borrow::Cow;

use thiserror::Error;

use super::{Dimension, Settings, Value, show, show_both, show_outside};

/// What a declaration says: in the program, or read at run time.
pub type Text = Cow<'static, str>;

/// What a registered thing says about itself.
#[derive(Debug, Clone)]
pub struct Declaration {
    /// The word used in scenario files.
    pub name: Text,
    /// One line.
    pub summary: Text,
    /// Where it comes from: paper and equation, or file and version.
    pub source: Text,
    /// In the order in which pages and completion show them.
    pub parameters: Vec<Parameter>,
    /// `None`: nothing but its defaults.
    pub presets: Option<PresetFamily>,
    /// Of a metric: it is measured only where somebody asks for it, and not in every run.
    pub on_request: bool,
}

/// Whether a registered thing can draw from the run's random streams, so that its run may differ from one under another
/// seed. Where that is not sure, it can.
#[derive(Debug, Clone, Copy)]
pub enum Chance {
    /// Two runs that differ in the seed alone are the same.
    Never,
    /// Whatever its settings.
    Always,
    /// Where this holds for its settings, resolved against its declaration.
    If(fn(&Settings) -> bool),
}

impl Chance {
    /// Whether it can draw under these settings, resolved against its declaration.
    pub fn possible(self, settings: &Settings) -> bool {
        match self {
            Self::Never => false,
            Self::Always => true,
            Self::If(holds) => holds(settings),
        }
    }
}

/// Named sets of defaults, chosen by one word such as `profile: aggressive`.
#[derive(Debug, Clone)]
pub struct PresetFamily {
    /// The name that the preset is chosen by, such as `profile`.
    pub word: Text,
    /// The preset where none is named, one of `presets`.
    pub default: Text,
    /// In the order in which pages show them.
    pub presets: Vec<Preset>,
}

impl PresetFamily {
    /// `word` chooses among `presets`, and stands for `default` where it is missing.
    pub fn new(
        word: impl Into<Text>,
        default: impl Into<Text>,
        presets: impl IntoIterator<Item = Preset>,
    ) -> Self {
        Self { word: word.into(), default: default.into(), presets: presets.into_iter().collect() }
    }
}

/// A set of defaults with a name.
#[derive(Debug, Clone)]
pub struct Preset {
    /// The word that chooses it, such as `aggressive`.
    pub name: Text,
    /// One line.
    pub doc: Text,
    /// Values by the names of parameters.
    pub values: Vec<(Text, Value)>,
}

impl Preset {
    /// `values` are defaults by the names of parameters, SI units.
    pub fn new(
        name: impl Into<Text>,
        doc: impl Into<Text>,
        values: impl IntoIterator<Item = (&'static str, Value)>,
    ) -> Self {
        let values = values.into_iter().map(|(name, value)| (name.into(), value)).collect();
        Self { name: name.into(), doc: doc.into(), values }
    }
}

/// One parameter of a registered thing.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// As scenarios call it.
    pub name: Text,
    /// One line.
    pub doc: Text,
    /// Where the default and the range come from: paper and equation, or file and version.
    pub source: Text,
    /// What it may be set to.
    pub kind: ParameterKind,
    /// The one value that was published beside the other settings, for a number that is no free choice: with another the
    /// model is another one, which nobody fitted to anything.
    pub published: Option<Published>,
    /// What it was before it could be set: what was recorded without it was made with this. `None` where that is not so.
    pub before: Option<Value>,
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
    /// The model or controller that declares the parameter.
    pub owner: String,
    /// As scenarios call it.
    pub parameter: String,
    /// What it is set to, SI units.
    pub found: f64,
    /// What was published beside the other settings, SI units.
    pub published: f64,
    /// Of both.
    pub dimension: Dimension,
}

/// What a parameter may be set to.
#[derive(Debug, Clone)]
pub enum ParameterKind {
    /// A quantity in SI units within an inclusive range; without a default it may stay absent.
    Number {
        /// A setting in another one is refused.
        dimension: Dimension,
        /// SI units.
        default: Option<f64>,
        /// SI units, both ends included.
        range: (f64, f64),
    },
    /// A whole number within an inclusive range.
    Whole {
        /// Within `range`.
        default: i64,
        /// Both ends included.
        range: (i64, i64),
    },
    /// A truth value.
    Flag {
        /// Where nothing is set.
        default: bool,
    },
    /// One of several words.
    Choice {
        /// The name of one of the `options`.
        default: Text,
        /// At least one.
        options: Vec<ChoiceOption>,
    },
    /// Free text in a language of the model's own, such as a variant's name.
    Text {
        /// Where nothing is set.
        default: Text,
        /// What is wrong with a text, asked when the scenario is checked.
        check: TextCheck,
    },
    /// The name of a pedestrian of the scenario whose model has the same name as who declares this: whatever is not set is as that
    /// pedestrian has it. Without a default.
    Pedestrian,
}

/// Everything that is wrong with a text; `given` says which other parameters of the model have a value.
pub type TextCheck = fn(text: &str, given: &dyn Fn(&str) -> bool) -> Vec<TextError>;

/// Why a model does not understand a text.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct TextError {
    /// What is wrong, in a sentence without a full stop.
    pub message: String,
    /// What to write instead.
    pub hint: Option<String>,
    /// The part of the text that is meant; empty for all of it.
    pub part: String,
}

/// One word that a [`ParameterKind::Choice`] may take.
#[derive(Debug, Clone)]
pub struct ChoiceOption {
    /// The word.
    pub name: Text,
    /// One line.
    pub doc: Text,
}

impl ChoiceOption {
    /// A word with its line.
    pub fn new(name: impl Into<Text>, doc: impl Into<Text>) -> Self {
        Self { name: name.into(), doc: doc.into() }
    }
}

/// Why a setting does not fit its declaration.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SettingError {
    /// Nothing is declared under the name.
    #[error("`{owner}` has no parameter `{name}`")]
    UnknownParameter {
        /// Whose settings they are.
        owner: String,
        /// What was set.
        name: String,
    },
    /// It is no number, flag or word where one is declared.
    #[error("`{name}` of `{owner}` must be {expected}, but is {found}")]
    WrongType {
        /// Whose settings they are.
        owner: String,
        /// Of the parameter.
        name: String,
        /// What is declared, in words.
        expected: String,
        /// What was set, as text.
        found: String,
    },
    /// The number is outside of the declared range.
    #[error("`{name}` of `{owner}` is {}, outside {low} .. {high}{unit}", show_outside(*found, (*low, *high)))]
    OutOfRange {
        /// Whose settings they are.
        owner: String,
        /// Of the parameter.
        name: String,
        /// What was set, SI units.
        found: f64,
        /// The smallest that is allowed, SI units.
        low: f64,
        /// The largest that is allowed, SI units.
        high: f64,
        /// The SI unit, with a space before it; empty for plain numbers.
        unit: String,
    },
    /// The word is none of the declared ones.
    #[error("`{name}` of `{owner}` has no option `{found}`")]
    UnknownOption {
        /// Whose settings they are.
        owner: String,
        /// Of the parameter.
        name: String,
        /// What was set.
        found: String,
        /// What may be set.
        options: Vec<String>,
    },
}

impl Parameter {
    fn new(
        name: impl Into<Text>,
        kind: ParameterKind,
        doc: impl Into<Text>,
        source: impl Into<Text>,
    ) -> Self {
        Self {
            name: name.into(),
            doc: doc.into(),
            source: source.into(),
            kind,
            published: None,
            before: None,
        }
    }

    /// A quantity: its default and the ends of its range, which belong to it, in SI units.
    pub fn number(
        name: impl Into<Text>,
        dimension: Dimension,
        default: f64,
        range: (f64, f64),
        doc: impl Into<Text>,
        source: impl Into<Text>,
    ) -> Self {
        Self::new(name, ParameterKind::Number { dimension, default: Some(default), range }, doc, source)
    }

    /// A number that may stay absent.
    pub fn optional(
        name: impl Into<Text>,
        dimension: Dimension,
        range: (f64, f64),
        doc: impl Into<Text>,
        source: impl Into<Text>,
    ) -> Self {
        Self::new(name, ParameterKind::Number { dimension, default: None, range }, doc, source)
    }

    /// A whole number; the ends of the range belong to it.
    pub fn whole(
        name: impl Into<Text>,
        default: i64,
        range: (i64, i64),
        doc: impl Into<Text>,
        source: impl Into<Text>,
    ) -> Self {
        Self::new(name, ParameterKind::Whole { default, range }, doc, source)
    }

    /// A truth value.
    pub fn flag(name: impl Into<Text>, default: bool, doc: impl Into<Text>, source: impl Into<Text>) -> Self {
        Self::new(name, ParameterKind::Flag { default }, doc, source)
    }

    /// One of several words; `default` is one of them.
    pub fn choice(
        name: impl Into<Text>,
        default: impl Into<Text>,
        options: impl IntoIterator<Item = ChoiceOption>,
        doc: impl Into<Text>,
        source: impl Into<Text>,
    ) -> Self {
        let kind = ParameterKind::Choice { default: default.into(), options: options.into_iter().collect() };
        Self::new(name, kind, doc, source)
    }

    /// A word that the model itself understands; `check` says what is wrong with others.
    pub fn text(
        name: impl Into<Text>,
        default: impl Into<Text>,
        check: TextCheck,
        doc: impl Into<Text>,
        source: impl Into<Text>,
    ) -> Self {
        Self::new(name, ParameterKind::Text { default: default.into(), check }, doc, source)
    }

    /// A pedestrian of the scenario, whose parameters are taken over; nobody where nothing is set.
    pub fn pedestrian(name: impl Into<Text>, doc: impl Into<Text>, source: impl Into<Text>) -> Self {
        Self::new(name, ParameterKind::Pedestrian, doc, source)
    }

    /// The same, published with the value that `published` says.
    pub fn published_with(self, published: Published) -> Self {
        Self { published: Some(published), ..self }
    }

    /// The same, which was this before it could be set.
    pub fn was(self, before: Value) -> Self {
        Self { before: Some(before), ..self }
    }

    /// The value it has when nobody says otherwise.
    pub fn default_value(&self) -> Option<Value> {
        match &self.kind {
            ParameterKind::Number { default, .. } => default.map(Value::Number),
            ParameterKind::Whole { default, .. } => Some(Value::Number(*default as f64)),
            ParameterKind::Flag { default } => Some(Value::Flag(*default)),
            ParameterKind::Choice { default, .. } | ParameterKind::Text { default, .. } => {
                Some(Value::Word(default.to_string()))
            }
            ParameterKind::Pedestrian => None,
        }
    }

    /// Checks type, range and options of one value; `owner` is named in the error.
    pub fn check(&self, owner: &str, value: &Value) -> Result<(), SettingError> {
        let wrong = |expected: String| SettingError::WrongType {
            owner: owner.to_string(),
            name: self.name.to_string(),
            expected,
            found: match value {
                Value::Number(number) => show(*number, None, Dimension::NUMBER),
                other => other.to_string(),
            },
        };
        let outside = |found: f64, low: f64, high: f64, unit: String| SettingError::OutOfRange {
            owner: owner.to_string(),
            name: self.name.to_string(),
            found,
            low,
            high,
            unit: if unit.is_empty() { unit } else { format!(" {unit}") },
        };
        match (&self.kind, value) {
            (ParameterKind::Number { dimension, range: (low, high), .. }, Value::Number(number)) => {
                if (low..=high).contains(&number) {
                    Ok(())
                } else {
                    Err(outside(*number, *low, *high, dimension.si_unit()))
                }
            }
            (ParameterKind::Whole { range: (low, high), .. }, Value::Number(number)) => {
                if number.fract() != 0.0 {
                    Err(wrong("a whole number".to_string()))
                } else if (*low as f64..=*high as f64).contains(number) {
                    Ok(())
                } else {
                    Err(outside(*number, *low as f64, *high as f64, String::new()))
                }
            }
            (ParameterKind::Flag { .. }, Value::Flag(_))
            | (ParameterKind::Text { .. } | ParameterKind::Pedestrian, Value::Word(_)) => Ok(()),
            (ParameterKind::Choice { options, .. }, Value::Word(word)) => {
                if options.iter().any(|option| option.name == word.as_str()) {
                    Ok(())
                } else {
                    Err(SettingError::UnknownOption {
                        owner: owner.to_string(),
                        name: self.name.to_string(),
                        found: word.clone(),
                        options: options.iter().map(|option| option.name.to_string()).collect(),
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
            Self::Pedestrian => "the name of a pedestrian".to_string(),
        }
    }
}

impl Declaration {
    /// Without parameters; each of the methods below adds one.
    pub fn new(name: impl Into<Text>, summary: impl Into<Text>) -> Self {
        Self {
            name: name.into(),
            summary: summary.into(),
            source: Text::default(),
            parameters: Vec::new(),
            presets: None,
            on_request: false,
        }
    }

    /// The same of a metric that is measured only where somebody asks for it.
    pub fn on_request(self) -> Self {
        Self { on_request: true, ..self }
    }

    /// Where it comes from: paper and equation, or file and version. [`Self::number`] takes it for the parameters that follow.
    pub fn source(self, source: impl Into<Text>) -> Self {
        Self { source: source.into(), ..self }
    }

    /// With one parameter more.
    pub fn with(mut self, parameter: Parameter) -> Self {
        self.parameters.push(parameter);
        self
    }

    /// With these parameters more.
    pub fn parameters(mut self, parameters: impl IntoIterator<Item = Parameter>) -> Self {
        self.parameters.extend(parameters);
        self
    }

    /// A quantity in SI units within an inclusive range, from the declaration's own source.
    pub fn number(
        self,
        name: impl Into<Text>,
        dimension: Dimension,
        default: f64,
        range: (f64, f64),
        doc: impl Into<Text>,
    ) -> Self {
        let source = self.source.clone();
        self.with(Parameter::number(name, dimension, default, range, doc, source))
    }

    /// With presets; a registry refuses those that set what is not declared.
    pub fn presets(self, presets: PresetFamily) -> Self {
        Self { presets: Some(presets), ..self }
    }

    /// The parameter of that name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// The preset of that name.
    pub fn preset(&self, name: &str) -> Option<&Preset> {
        self.presets.as_ref()?.presets.iter().find(|preset| preset.name == name)
    }

    /// Whatever of resolved `settings` makes another model than was published.
    pub fn departures(&self, settings: &Settings) -> Vec<Departure> {
        let departure = |parameter: &Parameter| {
            let (published, found) =
                (parameter.published?(settings), settings.optional_number(&parameter.name)?);
            let dimension = match parameter.kind {
                ParameterKind::Number { dimension, .. } => dimension,
                _ => Dimension::NUMBER,
            };
            let differs = (found - published).abs() > 1e-9 * published.abs();
            differs.then_some(Departure {
                owner: self.name.to_string(),
                parameter: parameter.name.to_string(),
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
        for parameter in &self.parameters {
            given.get(&parameter.name).map_or(Ok(()), |value| parameter.check(&self.name, value))?;
        }
        Ok(resolved)
    }

    /// As [`Self::resolve`], but values are not checked; names are.
    pub fn fill_in(&self, given: &Settings) -> Result<Settings, SettingError> {
        let mut resolved = Settings::default();
        for parameter in &self.parameters {
            if let Some(value) = parameter.default_value() {
                resolved.set(&*parameter.name, value);
            }
        }
        if let Some(family) = &self.presets {
            let chosen = match given.get(&family.word) {
                None => family.default.to_string(),
                Some(Value::Word(word)) => word.clone(),
                Some(other) => other.to_string(),
            };
            let preset = self.preset(&chosen).ok_or_else(|| SettingError::UnknownOption {
                owner: self.name.to_string(),
                name: family.word.to_string(),
                found: chosen.clone(),
                options: family.presets.iter().map(|preset| preset.name.to_string()).collect(),
            })?;
            for (name, value) in &preset.values {
                resolved.set(&**name, value.clone());
            }
            resolved.set(&*family.word, Value::Word(chosen));
        }
        for (name, value) in &given.0 {
            if self.presets.as_ref().is_some_and(|family| family.word == name.as_str()) {
                continue;
            }
            if self.parameter(name).is_none() {
                let owner = self.name.to_string();
                return Err(SettingError::UnknownParameter { owner, name: name.clone() });
            }
            resolved.set(name.clone(), value.clone());
        }
        Ok(resolved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn car() -> Declaration {
        let presets = [
            Preset::new("normal", "", [("gap", Value::Number(5.0))]),
            Preset::new("wild", "", [("gap", Value::Number(1.0))]),
        ];
        Declaration::new("car", "A car.")
            .number("gap", Dimension::LENGTH, 5.0, (0.0, 50.0), "A gap.")
            .with(Parameter::flag("careful", false, "Takes care.", "none"))
            .with(Parameter::optional("speed", Dimension::SPEED, (0.0, 50.0), "A speed.", "none"))
            .presets(PresetFamily::new("profile", "normal", presets))
    }

    #[test]
    fn explicit_settings_win_over_presets_and_defaults() {
        let wild = Settings::from([("profile", Value::Word("wild".into()))]);
        assert_eq!(car().resolve(&Settings::default()).unwrap().number("gap"), 5.0);
        assert_eq!(car().resolve(&wild).unwrap().number("gap"), 1.0);
        let both = Settings::from([("profile", Value::Word("wild".into())), ("gap", Value::Number(7.0))]);
        assert_eq!(car().resolve(&both).unwrap().number("gap"), 7.0);
        assert_eq!(car().resolve(&both).unwrap().optional_number("speed"), None);
    }

    #[test]
    fn bad_settings_are_named() {
        let error = |name: &str, value: Value| {
            car().resolve(&Settings::from([(name, value)])).unwrap_err().to_string()
        };
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
