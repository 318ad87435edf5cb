//! Programs under test in words: which they are, how fast they answered, and whether the same run came out the same.

use anstyle::AnsiColor;

use super::format::share;
use super::table::paint;
use files::escape::terminal_line;
use results::{AnswerTimes, SuiteReport, TestedController};

/// Which program it was, and how fast it answered; `None` if it was not asked. Nothing is judged by it.
pub fn in_words(tested: &TestedController) -> Option<String> {
    let AnswerTimes { answers, median, percentile_99, worst, late } = tested.answers.as_ref()?;
    let program = if tested.program.is_empty() { String::new() } else { format!(" is {}", tested.program) };
    let slow = match *late {
        0.0 => String::new(),
        late => format!(
            "; {} took longer than the time between two decisions: would not keep up in real time on this machine",
            share(late)
        ),
    };
    let second = match tested.second_runs {
        0 => String::new(),
        1 => "; 1 run made twice".to_string(),
        runs => format!("; {runs} runs made twice"),
    };
    Some(format!(
        "controller `{}`{program}: {answers} answers, each run's in {} (median), {} (99 %), {} (worst){slow}{second}",
        tested.name,
        seconds(*median),
        seconds(*percentile_99),
        seconds(*worst)
    ))
}

/// Such as `12.3 µs`.
fn seconds(seconds: f64) -> String {
    match seconds {
        long if long >= 1.0 => format!("{long:.2} s"),
        short if short >= 1e-3 => format!("{:.2} ms", 1e3 * short),
        tiny => format!("{:.1} µs", 1e6 * tiny),
    }
}

/// All that is to be said of the programs under test of these suites, for the terminal; empty without any.
pub fn render_controllers(suites: &[SuiteReport], colour: bool) -> String {
    let mut text = String::new();
    for tested in suites.iter().flat_map(|report| &report.controllers) {
        if let Some(said) = in_words(tested) {
            text.push_str(&format!("{}\n", terminal_line(&said)));
        }
        if let Some(warning) = tested.nondeterminism() {
            let label = paint("warning: ", AnsiColor::Yellow.on_default().bold(), colour);
            text.push_str(&format!("{label}{}\n", terminal_line(&warning)));
        }
    }
    if text.is_empty() { text } else { format!("\n{text}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use results::DifferingRun;

    #[test]
    fn what_is_known_of_a_program_is_said_in_two_lines() {
        let answers =
            AnswerTimes { answers: 1200, median: 21e-6, percentile_99: 1.5e-3, worst: 1.25, late: 0.002 };
        let differing = vec![DifferingRun {
            run: "a/b/rep=1".into(),
            difference: "at 3.2 s -1.2 m/s^2, then -1.15 m/s^2".into(),
        }];
        let mut tested = TestedController {
            name: "my_av".into(),
            program: "planner 2026.3".into(),
            answers: Some(answers),
            second_runs: 3,
            differing,
            ..TestedController::default()
        };
        insta::assert_snapshot!([in_words(&tested), tested.nondeterminism()].map(Option::unwrap).join("\n"), @r"
        controller `my_av` is planner 2026.3: 1200 answers, each run's in 21.0 µs (median), 1.50 ms (99 %), 1.25 s (worst); 0.2 % took longer than the time between two decisions: would not keep up in real time on this machine; 3 runs made twice
        W1102: `my_av` is not deterministic: at 3.2 s -1.2 m/s^2, then -1.15 m/s^2 (a/b/rep=1; 1 of 3 runs that were made twice came out differently)
        ");
        tested.answers = None;
        assert_eq!(in_words(&tested), None);
        assert_eq!(render_controllers(&[], true), "");
    }
}
