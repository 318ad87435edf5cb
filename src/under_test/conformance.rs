//! Whether a program keeps to the protocol: the same answers alone and among others, in this process and the next, at every end of its parameters.

use std::sync::Arc;
use std::time::Duration;

use serde_json::{Map, Value as Json, json};

use super::conversation::{Conversation, Spoken, converse, first_line};
use super::hello::Hello;
use super::pool::ProcessPool;
use super::process::Process;
use super::scenes::scenes;
use super::start::StartError;
use scenario::{Declaration, DeclaredProgram, Parameter, ParameterKind};

/// Of a simulation, s, where a controller does not say how often it decides.
const STEP: f64 = 0.025;

/// How often a program is started again in the place of a process that is gone.
const MOST_RESTARTS: u32 = 5;

/// The most runs that are asked for at once here.
const MOST: usize = 64;

/// What came of trying a program.
#[derive(Debug)]
pub struct Conformance {
    /// What it said of itself.
    pub hello: Hello,
    /// What it does that it must not, one after the other.
    pub findings: Vec<String>,
    /// Scenes that it was shown.
    pub scenes: usize,
    /// Settings in which it was shown them.
    pub settings: usize,
    /// Asked for one run at once.
    pub alone: TriedTimes,
    /// Asked for many.
    pub together: TriedTimes,
    /// How many that were.
    pub at_once: usize,
}

/// In which wall time answers came.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TriedTimes {
    /// Decisions.
    pub decisions: usize,
    /// Of a request.
    pub median: Duration,
    /// 99 of 100 requests took no longer.
    pub most: Duration,
    /// Of a request.
    pub worst: Duration,
    /// Of all of them.
    pub total: Duration,
}

impl TriedTimes {
    /// Decisions in a second of waiting for them.
    pub fn per_second(&self) -> f64 {
        self.decisions as f64 / self.total.as_secs_f64().max(1e-9)
    }
}

/// Shows the ten scenes to a program that may be started.
///
/// # Errors
/// If it may not be started, or does not start.
pub fn conformance(
    pool: &ProcessPool,
    program: &Arc<DeclaredProgram>,
    declaration: &Declaration,
) -> Result<Conformance, StartError> {
    let process = pool.start(program)?;
    let hello = process.hello().clone();
    let at_once = hello.runs_at_once.min(MOST);
    let mut trying = Trying { pool, program, process: Some(process), restarts: 0, findings: Vec::new() };
    let known = variants(declaration);
    let shown = |settings: &Json| scenes(&program.name, settings, trying_period(program), STEP);

    let defaults = &known[0];
    let first = trying.each_alone(&shown(&defaults.settings), "");
    let alone = times(first.iter().flatten(), 1);
    let expected: Vec<Conversation> = shown(&defaults.settings)
        .into_iter()
        .zip(&first)
        .filter_map(|(one, said)| with(one, said.as_ref()))
        .collect();

    let again = trying.each_alone(&expected, "asked once more");
    trying.compare(&expected, &again, "once more in the same process");
    trying.leave();
    let many = trying.together(&expected, at_once);
    let together = times(many.iter().filter_map(|(_, said)| said.as_ref()), at_once);
    let (which, many): (Vec<usize>, Vec<Option<Spoken>>) = many.into_iter().unzip();
    let asked: Vec<Conversation> = which.iter().map(|which| expected[*which].clone()).collect();
    trying.compare(&asked, &many, &format!("in another process, {at_once} runs at once"));
    for TriedSettings { name, settings } in &known[1..] {
        trying.each_alone(&shown(settings), name);
    }
    trying.leave();
    let Trying { findings, .. } = trying;
    Ok(Conformance {
        hello,
        findings,
        scenes: shown(&known[0].settings).len(),
        settings: known.len(),
        alone,
        together,
        at_once,
    })
}

/// Has a program asked again what it was asked in these conversations; where it differs, and what it must not do besides.
///
/// # Errors
/// If it may not be started, or does not start.
pub fn again(
    pool: &ProcessPool,
    program: &Arc<DeclaredProgram>,
    conversations: &[Conversation],
) -> Result<Vec<super::AnswerDifference>, StartError> {
    let period = trying_period(program);
    let mut found = Vec::new();
    for one in conversations {
        let mut process = pool.start(program)?;
        match converse(&mut process, &[(one, 0)], period) {
            Ok(spoken) => found.extend(one.difference(&spoken[0])),
            Err(fault) => found.extend(one.failed(&fault)),
        }
    }
    Ok(found)
}

fn trying_period(program: &DeclaredProgram) -> f64 {
    program.period.unwrap_or(STEP)
}

/// Settings of a controller, and what is special about them.
struct TriedSettings {
    name: String,
    settings: Json,
}

/// The defaults, then every parameter at the ends of its range or at each of its options, the others at their defaults.
fn variants(declaration: &Declaration) -> Vec<TriedSettings> {
    let defaults: Map<String, Json> =
        declaration.parameters.iter().filter_map(|one| Some((one.name.to_string(), default(one)?))).collect();
    let mut all = vec![TriedSettings { name: String::new(), settings: Json::Object(defaults.clone()) }];
    for parameter in &declaration.parameters {
        for value in ends(parameter).into_iter().filter(|value| default(parameter).as_ref() != Some(value)) {
            let name = format!(
                "with `{}: {}`",
                parameter.name,
                value.as_str().map_or(value.to_string(), str::to_string)
            );
            let mut settings = defaults.clone();
            settings.insert(parameter.name.to_string(), value);
            all.push(TriedSettings { name, settings: Json::Object(settings) });
        }
    }
    all
}

fn default(parameter: &Parameter) -> Option<Json> {
    Some(match &parameter.kind {
        ParameterKind::Number { default, .. } => json!((*default)?),
        ParameterKind::Whole { default, .. } => json!(default),
        ParameterKind::Flag { default } => json!(default),
        ParameterKind::Choice { default, .. } | ParameterKind::Text { default, .. } => {
            json!(default.to_string())
        }
        ParameterKind::Pedestrian => return None,
    })
}

fn ends(parameter: &Parameter) -> Vec<Json> {
    match &parameter.kind {
        ParameterKind::Number { range: (low, high), .. } => vec![json!(low), json!(high)],
        ParameterKind::Whole { range: (low, high), .. } => vec![json!(low), json!(high)],
        ParameterKind::Flag { .. } => vec![json!(false), json!(true)],
        ParameterKind::Choice { options, .. } => {
            options.iter().map(|one| json!(one.name.to_string())).collect()
        }
        ParameterKind::Text { .. } | ParameterKind::Pedestrian => Vec::new(),
    }
}

/// A conversation with what was said in it; nothing if it did not come to its end.
fn with(mut one: Conversation, spoken: Option<&Spoken>) -> Option<Conversation> {
    let spoken = spoken?;
    if spoken.refused.is_some() || spoken.said.len() < one.turns.len() {
        return None;
    }
    for (turn, said) in one.turns.iter_mut().zip(&spoken.said) {
        turn.said = Some(said.as_ref().ok()?.clone());
    }
    Some(one)
}

fn times<'s>(spoken: impl Iterator<Item = &'s Spoken>, at_once: usize) -> TriedTimes {
    let mut times: Vec<Duration> = spoken.flat_map(|one| one.times.iter().copied()).collect();
    let total = times.iter().sum::<Duration>() / at_once.max(1) as u32;
    times.sort_unstable();
    let at =
        |share: f64| times.get(((times.len() as f64 * share) as usize).min(times.len().saturating_sub(1)));
    let at = |share: f64| at(share).copied().unwrap_or_default() / at_once.max(1) as u32;
    TriedTimes { decisions: times.len(), median: at(0.5), most: at(0.99), worst: at(1.0), total }
}

/// A program under trial, with the process that is asked now.
struct Trying<'a> {
    pool: &'a ProcessPool,
    program: &'a Arc<DeclaredProgram>,
    process: Option<Process>,
    restarts: u32,
    findings: Vec<String>,
}

impl Trying<'_> {
    fn process(&mut self) -> Option<&mut Process> {
        if self.process.as_ref().is_none_or(Process::has_ended) {
            let is_gone = self.process.take().is_some();
            self.restarts += u32::from(is_gone);
            if self.restarts > MOST_RESTARTS {
                self.find(format!("given up after {MOST_RESTARTS} processes that ended or were ended"));
                return None;
            }
            match self.pool.start(self.program) {
                Ok(process) => self.process = Some(process),
                Err(error) => {
                    self.find(format!("it does not start again: {error}"));
                    self.process = None;
                }
            }
        }
        self.process.as_mut()
    }

    fn find(&mut self, finding: String) {
        if !self.findings.contains(&finding) {
            self.findings.push(finding);
        }
    }

    /// Each conversation by itself in slot 0, one after the other; what is wrong is a finding.
    fn each_alone(&mut self, conversations: &[Conversation], how: &str) -> Vec<Option<Spoken>> {
        let period = trying_period(self.program);
        let how = if how.is_empty() { String::new() } else { format!(", {how}") };
        let mut all = Vec::new();
        for one in conversations {
            let Some(process) = self.process() else { break };
            let spoken = converse(process, &[(one, 0)], period).map(|mut all| all.swap_remove(0));
            let wrong = match &spoken {
                Err(fault) => Some(first_line(fault)),
                Ok(spoken) => {
                    let refused = spoken
                        .refused
                        .as_ref()
                        .map(|fault| format!("it does not open the run: {}", first_line(fault)));
                    let failed = spoken
                        .said
                        .iter()
                        .enumerate()
                        .find_map(|(turn, said)| Some((turn, said.as_ref().err()?)));
                    refused.or_else(|| failed.map(|(turn, fault)| at_time(one, turn, &first_line(fault))))
                }
            };
            if let Some(wrong) = wrong {
                self.find(format!("{}{how}: {wrong}", one.name));
            }
            let is_gone = spoken.is_err();
            all.push(spoken.ok());
            // What ends a process in one scene says enough of these settings.
            if is_gone {
                break;
            }
        }
        all
    }

    /// All of them side by side, so often that `at_once` runs are asked for, in slots from the last to the first; which it is, with what was said.
    fn together(&mut self, conversations: &[Conversation], at_once: usize) -> Vec<(usize, Option<Spoken>)> {
        let mut all = Vec::new();
        if conversations.is_empty() {
            return all;
        }
        let runs: Vec<usize> =
            (0..at_once.max(conversations.len())).map(|run| run % conversations.len()).collect();
        let period = trying_period(self.program);
        for some in runs.chunks(at_once) {
            let Some(process) = self.process() else { break };
            let slots = (0..at_once).rev();
            let asked: Vec<(&Conversation, usize)> =
                some.iter().map(|which| &conversations[*which]).zip(slots).collect();
            match converse(process, &asked, period) {
                Ok(spoken) => all.extend(some.iter().copied().zip(spoken.into_iter().map(Some))),
                Err(fault) => self.find(format!("{} runs at once: {}", some.len(), first_line(&fault))),
            }
        }
        all
    }

    /// What was said otherwise than before is a finding, unless it is known that it may be.
    fn compare(&mut self, expected: &[Conversation], said: &[Option<Spoken>], how: &str) {
        if self.program.is_nondeterministic {
            return;
        }
        for (one, spoken) in expected.iter().zip(said) {
            let Some(difference) = spoken.as_ref().and_then(|spoken| one.difference(spoken)) else {
                continue;
            };
            let time = difference.time.map_or_else(String::new, |time| format!(" at {} s", shown(time)));
            let finding =
                format!("{}{time}: {} at first, and {how} {}", one.name, difference.before, difference.now);
            // What differs once differs often.
            return self.find(finding);
        }
    }

    /// Says goodbye to the process.
    fn leave(&mut self) {
        if let Some(mut process) = self.process.take()
            && !process.leave()
        {
            self.find("it does not end within 2 s after `bye` and the end of its input".to_string());
        }
    }
}

fn at_time(one: &Conversation, turn: usize, what: &str) -> String {
    format!("at {} s {what}", shown(one.turns[turn].seen.time))
}

/// Without the noise of binary fractions.
fn shown(time: f64) -> f64 {
    (time * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::{ChoiceOption, Dimension};

    #[test]
    fn every_end_of_every_parameter_is_tried_once() {
        let declaration = Declaration::new("my_av", "")
            .number("gap", Dimension::LENGTH, 5.0, (1.0, 30.0), "")
            .with(Parameter::choice(
                "profile",
                "a",
                [ChoiceOption::new("a", ""), ChoiceOption::new("b", "")],
                "",
                "",
            ))
            .with(Parameter::flag("yields", true, "", ""))
            .with(Parameter::whole("horizon", 5, (5, 80), "", ""));
        let names: Vec<String> = variants(&declaration).into_iter().map(|one| one.name).collect();
        assert_eq!(
            names,
            [
                "",
                "with `gap: 1.0`",
                "with `gap: 30.0`",
                "with `profile: b`",
                "with `yields: false`",
                "with `horizon: 80`"
            ]
        );
        let last = &variants(&declaration)[5].settings;
        assert_eq!(last, &json!({"gap": 5.0, "profile": "a", "yields": true, "horizon": 80}));
    }
}
