//! Scripted timelines: steps such as `at t1 speed v1; when distance < d1 stop; after t2 resume`.
//!
//! The same for vehicles and pedestrians. Steps name their numbers (`t1`, `v1`, …), which are parameters of their own
//! with units, so that they are checked where they are written, vary, and can be tuned. A step waits until its trigger
//! holds; only then does the next one count. Source: actions and conditions after ASAM OpenSCENARIO storyboards.

use scenario::agent::{ModelError, ScriptStep};
use scenario::{Dimension, Parameter, Settings, TextCheck, TextError};
use std::iter;
use std::sync::Arc;

/// What a step makes its road user do until the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Take this speed, m/s.
    Speed(f64),
    /// Keep this acceleration, m/s².
    Accelerate(f64),
    /// Come to a stand and stay there.
    Stop,
    /// Go on as before the first step.
    Resume,
}

/// A number that a step may compare, with its dimension; the road user knows its value.
pub type ScriptQuantity = (&'static str, Dimension);

/// Steps in their order, and how far they have come.
#[derive(Debug, Clone)]
pub struct Script {
    steps: Vec<(Trigger, Action)>,
    /// As they are written.
    texts: Vec<Arc<str>>,
    next: usize,
    /// When the last step's trigger held, s.
    last: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Trigger {
    /// s
    At(f64),
    /// s since the step before.
    After(f64),
    /// The quantity of this index is on this side of the bound.
    When { quantity: usize, below: bool, bound: f64 },
}

const FREE: &str = "free choice";
const STEPS: &str = "`at t1 speed v1; when distance < d1 stop; after t2 resume`: each step a trigger (`at`, `after`, `when quantity < or > bound`) and an action (`speed`, `accelerate`, `stop`, `resume`).";
const TIME: &str = "A time that a step may name.";
const LENGTH: &str = "A distance that a step may name.";
const SPEED: &str = "A speed that a step may name.";
const ACCELERATION: &str = "An acceleration that a step may name; negative to slow down.";

fn time(name: &'static str) -> Parameter {
    Parameter::optional(name, Dimension::TIME, (0.0, 3600.0), TIME, FREE)
}

fn length(name: &'static str) -> Parameter {
    Parameter::optional(name, Dimension::LENGTH, (-1000.0, 10_000.0), LENGTH, FREE)
}

fn speed(name: &'static str) -> Parameter {
    Parameter::optional(name, Dimension::SPEED, (0.0, 100.0), SPEED, FREE)
}

fn acceleration(name: &'static str) -> Parameter {
    Parameter::optional(name, Dimension::ACCELERATION, (-20.0, 20.0), ACCELERATION, FREE)
}

fn numbers() -> impl Iterator<Item = Parameter> {
    let times = ["t1", "t2", "t3", "t4"].map(time);
    let lengths = ["d1", "d2", "d3", "d4"].map(length);
    let speeds = ["v1", "v2", "v3", "v4"].map(speed);
    let accelerations = ["a1", "a2", "a3", "a4"].map(acceleration);
    [times, lengths, speeds, accelerations].into_iter().flatten()
}

/// The parameters of a timeline; those of the road user itself follow. `check` is [`Script::check`] with the road
/// user's quantities.
pub fn parameters(check: TextCheck) -> impl Iterator<Item = Parameter> {
    iter::once(Parameter::text("steps", "", check, STEPS, FREE)).chain(numbers())
}

impl Script {
    /// Reads the steps of `settings`; `owner` is named in errors, `quantities` are those that steps may compare.
    pub fn from_settings(
        settings: &Settings,
        owner: &str,
        quantities: &[ScriptQuantity],
    ) -> Result<Self, ModelError> {
        let number = |name: &str| settings.optional_number(name);
        let reader = Reader { number: &number, owner, quantities };
        let (steps, mut errors) = reader.steps(settings.word("steps"));
        let texts = written_steps(settings.word("steps")).map(Arc::from).collect();
        match errors.is_empty() {
            true => Ok(Self { steps, texts, next: 0, last: 0.0 }),
            false => {
                let TextError { message, hint, .. } = errors.swap_remove(0);
                Err(match hint {
                    Some(hint) => ModelError::with_hint(message, hint),
                    None => ModelError::new(message),
                })
            }
        }
    }

    /// Everything that is wrong with the steps of `owner`; `given` says which numbers have a value.
    pub fn check(
        steps: &str,
        owner: &str,
        quantities: &[ScriptQuantity],
        given: &dyn Fn(&str) -> bool,
    ) -> Vec<TextError> {
        let number = |name: &str| given(name).then_some(0.0);
        Reader { number: &number, owner, quantities }.steps(steps).1
    }

    /// The quantities that its steps compare, by their index.
    pub fn compares(&self) -> impl Iterator<Item = usize> {
        self.steps.iter().filter_map(|(trigger, _)| match trigger {
            Trigger::When { quantity, .. } => Some(*quantity),
            Trigger::At(_) | Trigger::After(_) => None,
        })
    }

    /// The action that begins at `time` (s), if one does: that of the last step whose trigger holds by now.
    pub fn due(&mut self, time: f64, quantity: impl Fn(usize) -> f64) -> Option<Action> {
        let mut begun = None;
        while let Some(&(trigger, action)) = self.steps.get(self.next) {
            if !self.holds(trigger, time, &quantity) {
                break;
            }
            begun = Some(action);
            self.next += 1;
            self.last = time;
        }
        begun
    }

    /// The steps that have not begun.
    pub fn waiting_steps(&self) -> Vec<ScriptStep> {
        let steps = self.texts.iter().enumerate().skip(self.next);
        steps.map(|(index, text)| ScriptStep { number: index + 1, text: text.clone() }).collect()
    }

    fn holds(&self, trigger: Trigger, time: f64, quantity: impl Fn(usize) -> f64) -> bool {
        /// Absorbs the rounding of summed times, s.
        const TOLERANCE: f64 = 1e-9;
        match trigger {
            Trigger::At(moment) => time >= moment - TOLERANCE,
            Trigger::After(pause) => time - self.last >= pause - TOLERANCE,
            Trigger::When { quantity: index, below: true, bound } => quantity(index) < bound,
            Trigger::When { quantity: index, below: false, bound } => quantity(index) > bound,
        }
    }
}

fn written_steps(text: &str) -> impl Iterator<Item = &str> {
    text.split(';').map(str::trim).filter(|step| !step.is_empty())
}

/// Reads one step after the other.
struct Reader<'a> {
    /// The value of the number of that name, if it has one.
    number: &'a dyn Fn(&str) -> Option<f64>,
    owner: &'a str,
    quantities: &'a [ScriptQuantity],
}

impl Reader<'_> {
    /// The steps that can be read, and what is wrong with the others.
    fn steps(&self, text: &str) -> (Vec<(Trigger, Action)>, Vec<TextError>) {
        let mut steps = Vec::new();
        let mut errors = Vec::new();
        for step in written_steps(text) {
            match self.step(step) {
                Ok(step) => steps.push(step),
                Err(error) => errors.push(error),
            }
        }
        if steps.is_empty() && errors.is_empty() {
            errors.push(TextError {
                message: format!("`{}` has no steps", self.owner),
                hint: Some(
                    "give it `steps: \"at t1 stop; after t2 resume\"` and the numbers `t1: 2 s`, `t2: 3 s`"
                        .to_string(),
                ),
                part: String::new(),
            });
        }
        (steps, errors)
    }

    fn step(&self, text: &str) -> Result<(Trigger, Action), TextError> {
        let words: Vec<&str> = text.split_whitespace().collect();
        let (trigger, rest) = match words.as_slice() {
            ["at", name, rest @ ..] => (Trigger::At(self.number(text, name, Dimension::TIME)?), rest),
            ["after", name, rest @ ..] => (Trigger::After(self.number(text, name, Dimension::TIME)?), rest),
            ["when", quantity, relation @ ("<" | ">"), name, rest @ ..] => {
                let known = self.quantities.iter().position(|(known, _)| known == quantity);
                let index = known.ok_or_else(|| {
                    let names: Vec<_> = self.quantities.iter().map(|(name, _)| format!("`{name}`")).collect();
                    self.error(
                        text,
                        &format!("`{quantity}` cannot be compared"),
                        &format!("compare one of {}", names.join(", ")),
                    )
                })?;
                let bound = self.number(text, name, self.quantities[index].1)?;
                (Trigger::When { quantity: index, below: *relation == "<", bound }, rest)
            }
            _ => {
                return Err(self.error(
                    text,
                    "no trigger",
                    "begin with `at t1`, `after t1` or `when distance < d1`",
                ));
            }
        };
        let action = match rest {
            ["speed", name] => Action::Speed(self.number(text, name, Dimension::SPEED)?),
            ["accelerate", name] => Action::Accelerate(self.number(text, name, Dimension::ACCELERATION)?),
            ["stop"] => Action::Stop,
            ["resume"] => Action::Resume,
            _ => {
                return Err(self.error(
                    text,
                    "no action",
                    "end with `speed v1`, `accelerate a1`, `stop` or `resume`",
                ));
            }
        };
        Ok((trigger, action))
    }

    fn number(&self, text: &str, name: &str, wanted: Dimension) -> Result<f64, TextError> {
        let letter = match wanted {
            Dimension::TIME => 't',
            Dimension::LENGTH => 'd',
            Dimension::SPEED => 'v',
            _ => 'a',
        };
        let declared = numbers().any(|parameter| parameter.name == name);
        if !declared || !name.starts_with(letter) {
            let message = format!("`{name}` is not the name of a {}", wanted.name());
            let hint = format!("write `{letter}1` there and say `{letter}1: …` beside `steps`");
            return Err(self.error(text, &message, &hint));
        }
        (self.number)(name).ok_or_else(|| {
            let hint = format!("say `{name}: …` beside `steps`");
            self.error(text, &format!("`{name}` has no value"), &hint)
        })
    }

    fn error(&self, step: &str, message: &str, hint: &str) -> TextError {
        TextError {
            message: format!("in step `{step}` of `{}`: {message}", self.owner),
            hint: Some(hint.to_string()),
            part: step.to_string(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::{Declaration, Value};

    fn declaration() -> Declaration {
        let check: TextCheck = |steps, given| Script::check(steps, "script", QUANTITIES, given);
        Declaration::new("script", "").parameters(parameters(check))
    }

    const QUANTITIES: &[ScriptQuantity] = &[("distance", Dimension::LENGTH), ("speed", Dimension::SPEED)];

    fn read(steps: &str, numbers: &[(&str, f64)]) -> Result<Script, ModelError> {
        let mut given = Settings::from([("steps", Value::Word(steps.into()))]);
        for (name, value) in numbers {
            given.set(*name, Value::Number(*value));
        }
        Script::from_settings(&declaration().resolve(&given).unwrap(), "script", QUANTITIES)
    }

    #[test]
    fn steps_come_one_after_the_other() {
        let steps = "at t1 speed v1; when distance < d1 stop; after t2 resume; when speed > v2 accelerate a1";
        let numbers = [("t1", 2.0), ("v1", 5.0), ("d1", 15.0), ("t2", 3.0), ("v2", 1.0), ("a1", -2.0)];
        let mut timeline = read(steps, &numbers).unwrap();
        let mut at =
            |time: f64, distance: f64, speed: f64| timeline.due(time, |index| [distance, speed][index]);
        // Being near already does not count before the first step is over.
        assert_eq!(at(0.0, 10.0, 0.0), None);
        assert_eq!(at(2.0, 20.0, 0.0), Some(Action::Speed(5.0)));
        assert_eq!(at(2.1, 15.0, 0.0), None);
        assert_eq!(at(4.0, 14.9, 0.0), Some(Action::Stop));
        assert_eq!(at(6.9, 14.9, 0.0), None);
        assert_eq!(at(7.0, 14.9, 0.0), Some(Action::Resume));
        assert_eq!(at(7.1, 14.9, 1.1), Some(Action::Accelerate(-2.0)));
        assert_eq!(at(9.0, 0.0, 9.0), None);
    }

    #[test]
    fn steps_that_hold_together_end_in_the_last() {
        let mut timeline =
            read("at t1 stop; when distance < d1 resume", &[("t1", 0.0), ("d1", 5.0)]).unwrap();
        assert_eq!(timeline.due(0.0, |_| 1.0), Some(Action::Resume));
    }

    #[test]
    fn mistakes_say_what_to_write() {
        let cases = [
            ("", "`script` has no steps"),
            ("soon stop", "no trigger"),
            ("at t1 jump", "no action"),
            ("at t1", "no action"),
            ("at v1 stop", "`v1` is not the name of a time"),
            ("at 2 stop", "`2` is not the name of a time"),
            ("at t2 stop", "`t2` has no value"),
            ("when height < d1 stop", "`height` cannot be compared"),
            ("when speed < d1 stop", "`d1` is not the name of a speed"),
        ];
        for (steps, message) in cases {
            let error = read(steps, &[("t1", 1.0), ("v1", 1.0), ("d1", 1.0)]).unwrap_err();
            assert!(error.to_string().contains(message), "{steps}: {error}");
            assert!(error.hint.is_some(), "{steps}");
        }
    }
}
