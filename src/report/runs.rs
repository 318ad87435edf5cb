//! Every run as JSON, one a line: for programs that read results as they come.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::json::{outcome_value, plain, variation_value};
use super::rows::{Row, What, each_row};
use super::{need_every_trial, verdict_word};
use results::judge::PerRun;
use results::{Requests, Results};

/// Writes a line for each run. The same suites and seeds give the same bytes, on any number of threads.
///
/// # Errors
/// Those of `out`; or the results do not hold every trial.
pub fn write_runs(results: &Results, out: &mut dyn Write) -> io::Result<()> {
    need_every_trial(results)?;
    let Results { requests, suites, recordings: _ } = results;
    for report in suites {
        each_row(report, |row, criteria| {
            serde_json::to_writer(&mut *out, &line(row, criteria, requests))?;
            out.write_all(b"\n")
        })?;
    }
    Ok(())
}

fn line(row: &Row, criteria: &[PerRun], requests: &Requests) -> Value {
    let mut value = match &row.what {
        What::Run(outcome) => {
            let standings: Vec<_> = criteria.iter().map(|one| one.standing(outcome, requests)).collect();
            let mut value = outcome_value(outcome, requests);
            value["criteria"] = plain(&standings);
            value
        }
        What::Nothing(_, message) => json!({ "message": message }),
    };
    value["suite"] = row.suite.into();
    value["scenario"] = row.scenario.into();
    value["trial"] = row.trial.into();
    value["variation"] = variation_value(row.variation);
    value["verdict"] = row.verdict.map_or(Value::Null, |verdict| verdict_word(verdict).into());
    value["state"] = row.state().into();
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Session;

    fn lines() -> Vec<Value> {
        let session = Session::new();
        let mut text = Vec::new();
        write_runs(&session.unrecorded(session.report()), &mut text).unwrap();
        String::from_utf8(text).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    #[test]
    fn a_line_says_all_about_its_run() {
        insta::assert_json_snapshot!(lines()[3]);
    }

    #[test]
    fn what_has_no_runs_has_a_line_that_says_so() {
        let lines = lines();
        let states: Vec<_> = lines.iter().map(|line| line["state"].as_str().unwrap()).collect();
        assert_eq!(states.iter().filter(|state| **state == "finished").count(), 2 + 4 * 6);
        assert_eq!(states[states.len() - 2..], ["error", "not run"]);
        let last = lines.last().unwrap();
        assert_eq!(last["message"], "stopped after 2 failures (--max-fail 2)");
        assert_eq!((&last["verdict"], &last["fingerprint"]), (&Value::Null, &Value::Null));
    }
}
