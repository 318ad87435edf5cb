//! What a registry refuses: names that scenarios cannot say, and declarations that contradict themselves.

use std::collections::HashSet;

use thiserror::Error;

use super::EntryKind;
use crate::{AggregateWord, Declaration, Metric, MetricKind, MetricRange, ParameterKind};

/// Why a registry does not take something in.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RegistryError {
    /// A name stands for one entry of a kind.
    #[error("there is a {kind} called `{name}` already")]
    Duplicate {
        /// Such as `controller`.
        kind: EntryKind,
        /// The name that two entries declare.
        name: String,
    },
    /// The language cannot say an entry's or a parameter's name.
    #[error(
        "`{name}` cannot be said in a scenario: a name begins with a letter, goes on with letters, digits and `_`, and is \
         no word of the language such as `when`"
    )]
    BadName {
        /// What was declared.
        name: String,
    },
    /// A declaration contradicts itself, as a default outside of its range does.
    #[error("`{owner}`: {message}")]
    BadDeclaration {
        /// The entry's name.
        owner: String,
        /// What is wrong, in a sentence without a full stop.
        message: String,
    },
    /// A controller drives dynamics that the registry does not have; these are added before it.
    #[error(
        "controller `{controller}` drives `{dynamics}`, but there are no vehicle dynamics of this name{}",
        nearest.as_ref().map(|nearest| format!("; did you mean `{nearest}`?")).unwrap_or_default()
    )]
    UnknownDynamics {
        /// The controller's name.
        controller: String,
        /// What it names.
        dynamics: String,
        /// The name of known dynamics that is most like it, if one is.
        nearest: Option<String>,
    },
    /// A controller gives pedals to what takes accelerations, or the other way round.
    #[error("controller `{controller}` drives `{dynamics}`, which do not take what it gives")]
    UnfitDynamics {
        /// The controller's name.
        controller: String,
        /// The name of its dynamics.
        dynamics: String,
    },
}

/// Words of the language that no name can be.
pub const RESERVED: [&str; 13] =
    ["in", "of", "from", "when", "with", "undefined", "and", "not", "true", "false", "step", "times", "by"];

fn is_identifier(name: &str) -> bool {
    name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.chars().all(|one| one.is_ascii_alphanumeric() || one == '_')
}

fn sayable(name: &str) -> Result<(), RegistryError> {
    if is_identifier(name) && !RESERVED.contains(&name) {
        Ok(())
    } else {
        Err(RegistryError::BadName { name: name.to_string() })
    }
}

/// Whether scenarios can speak of it: its name and those of its parameters, defaults within ranges, presets that set what there is.
pub fn declaration(declaration: &Declaration) -> Result<(), RegistryError> {
    let owner = &*declaration.name;
    let bad = |message: String| RegistryError::BadDeclaration { owner: owner.to_string(), message };
    sayable(owner)?;
    let mut names = HashSet::new();
    for parameter in &declaration.parameters {
        let name = &*parameter.name;
        if !is_identifier(name) {
            return Err(RegistryError::BadName { name: name.to_string() });
        }
        if !names.insert(name) {
            return Err(bad(format!("there are two parameters `{name}`")));
        }
        match &parameter.kind {
            ParameterKind::Number { range: (low, high), .. }
                if low > high || low.is_nan() || high.is_nan() =>
            {
                return Err(bad(format!("the range {low} .. {high} of `{name}` is empty")));
            }
            ParameterKind::Choice { options, .. } => {
                options.iter().try_for_each(|option| sayable(&option.name))?;
            }
            _ => {}
        }
        if let Some(default) = parameter.default_value() {
            parameter.check(owner, &default).map_err(|error| bad(format!("the default: {error}")))?;
        }
    }
    let Some(family) = &declaration.presets else { return Ok(()) };
    sayable(&family.word)?;
    if names.contains(&*family.word) {
        return Err(bad(format!("`{}` is a parameter and chooses presets", family.word)));
    }
    if declaration.preset(&family.default).is_none() {
        return Err(bad(format!("there is no preset `{}`, which is the default", family.default)));
    }
    for preset in &family.presets {
        sayable(&preset.name)?;
        for (name, value) in &preset.values {
            let parameter = declaration.parameter(name).ok_or_else(|| {
                bad(format!("preset `{}` sets `{name}`, which is no parameter", preset.name))
            })?;
            parameter
                .check(owner, value)
                .map_err(|error| bad(format!("preset `{}`: {error}", preset.name)))?;
        }
    }
    Ok(())
}

/// What is asked of a metric besides.
pub fn metric(metric: &Metric) -> Result<(), RegistryError> {
    let name = &*metric.declaration.name;
    let bad = |message: String| RegistryError::BadDeclaration { owner: name.to_string(), message };
    // Where a criterion expects a metric, these begin something else.
    if name == "no" || AggregateWord::find(name).is_some() {
        return Err(RegistryError::BadName { name: name.to_string() });
    }
    let is_flag = matches!(metric.range, MetricRange::YesOrNo | MetricRange::DropAbove { .. });
    if is_flag != (metric.kind == MetricKind::Flag) {
        return Err(bad(
            "what is true or false, and nothing else, lies in `YesOrNo` or `DropAbove`".to_string()
        ));
    }
    if let MetricKind::Category(words) = &metric.kind {
        words.iter().try_for_each(|word| sayable(word))?;
    }
    let parameters = match &metric.range {
        MetricRange::UpTo(parameter) => vec![parameter],
        MetricRange::DropWithin { window, floor } => vec![window, floor],
        MetricRange::DropAbove { threshold, window, floor } => vec![threshold, window, floor],
        // It need not be given.
        MetricRange::WithinRunUpTo(parameter) => {
            let is_number = metric
                .declaration
                .parameter(parameter)
                .is_some_and(|parameter| matches!(parameter.kind, ParameterKind::Number { .. }));
            if !is_number {
                return Err(bad(format!("its range names `{parameter}`, which is no number")));
            }
            Vec::new()
        }
        MetricRange::WithinRun
        | MetricRange::TwoSpeeds
        | MetricRange::YesOrNo
        | MetricRange::Share
        | MetricRange::NotNegative
        | MetricRange::Unlimited => Vec::new(),
    };
    for parameter in parameters {
        let is_number = metric.declaration.parameter(parameter).is_some_and(|parameter| {
            matches!(parameter.kind, ParameterKind::Number { default: Some(_), .. })
        });
        if !is_number {
            return Err(bad(format!("its range names `{parameter}`, which is no number with a default")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reserved_words_are_those_of_the_grammar() {
        let grammar = grammar::scn::TEXT;
        let line = grammar.lines().find(|line| line.starts_with("reserved ")).expect("the rule");
        let words: Vec<&str> = line.split('"').skip(1).step_by(2).collect();
        assert_eq!(words, RESERVED);
    }
}
