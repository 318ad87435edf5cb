//! Every run as JSON, one a line: for programs that read results as they come.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde_json::{Value, json};

use super::json::{outcome_value, plain, variation_value};
use super::rows::{Row, What, each_row, recorded_row, trial_rows};
use super::{need_every_trial, verdict_word};
use results::judge::PerRun;
use results::{Event, Reporter, Requests, Results, UnitReport};

/// Writes a line for each run. The same suites and seeds give the same bytes, on any number of threads.
///
/// # Errors
/// Those of `out`; or the results do not hold every trial.
pub fn write_runs(results: &Results, out: &mut dyn Write) -> io::Result<()> {
    need_every_trial(results)?;
    let Results { requests, suites, recordings: _, denies_untested: _ } = results;
    for report in suites {
        each_row(report, |row, criteria| write_line(row, criteria, requests, out))?;
    }
    Ok(())
}

/// Writes the same while suites run, so that nobody has to hold all runs until the end.
#[derive(Debug)]
pub struct RunLines<W> {
    out: W,
    /// Units that have lines and are not written yet, in the order of the plan.
    next: std::vec::IntoIter<usize>,
    /// The first of them.
    first: Option<usize>,
    /// Lines of those that were over before others that come first.
    waiting: BTreeMap<usize, Vec<u8>>,
    error: Option<io::Error>,
}

impl<W: Write> RunLines<W> {
    /// Of these units, in ascending order: all that are run but blocks.
    pub fn new(out: W, units: Vec<usize>) -> Self {
        let mut next = units.into_iter();
        let first = next.next();
        Self { out, next, first, waiting: BTreeMap::new(), error: None }
    }

    /// What was written to, with the lines of all units.
    ///
    /// # Errors
    /// The first that there was; or a unit was never told to be over.
    pub fn finish(self) -> io::Result<W> {
        match (self.error, self.first) {
            (Some(error), _) => Err(error),
            (None, Some(unit)) => Err(io::Error::other(format!("nothing was told of unit {unit}"))),
            (None, None) => Ok(self.out),
        }
    }

    fn write_what_is_next(&mut self) -> io::Result<()> {
        while let Some(lines) = self.first.and_then(|first| self.waiting.remove(&first)) {
            self.first = self.next.next();
            self.out.write_all(&lines)?;
        }
        Ok(())
    }
}

impl<W: Write> Reporter for RunLines<W> {
    fn tell(&mut self, event: &Event) {
        let Event::Finished { unit, suite, report, requests } = event else { return };
        if self.error.is_some() {
            return;
        }
        let (suite, mut lines) = (suite.suite.as_str(), Vec::new());
        let mut write = |row: &Row, criteria: &[PerRun]| write_line(row, criteria, requests, &mut lines);
        let written = match report {
            UnitReport::Recorded(recorded) => recorded_row(suite, recorded, &mut write),
            UnitReport::Trial(trial) => trial_rows(suite, trial, &mut write),
            UnitReport::Block(_) => return,
        };
        self.waiting.insert(*unit, lines);
        self.error = written.and_then(|()| self.write_what_is_next()).err();
    }
}

fn write_line(row: &Row, criteria: &[PerRun], requests: &Requests, out: &mut dyn Write) -> io::Result<()> {
    serde_json::to_writer(&mut *out, &line(row, criteria, requests))?;
    out.write_all(b"\n")
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

    /// Told in an order in which units are over, and not that of the plan.
    #[test]
    fn lines_that_are_written_as_units_end_are_those_that_are_written_at_the_end() {
        let session = Session::new();
        let results = session.unrecorded(session.report());
        let mut whole = Vec::new();
        write_runs(&results, &mut whole).unwrap();
        let suite = session.report();
        let identity = suite.identity.clone();
        let recorded = suite.recorded.into_iter().map(UnitReport::Recorded);
        let units: Vec<UnitReport> =
            recorded.chain(suite.trials.into_iter().map(UnitReport::Trial)).collect();
        let told = |order: &[usize]| {
            let mut lines = RunLines::new(Vec::new(), (0..units.len()).collect());
            for unit in order {
                let (report, requests) = (&units[*unit], &results.requests);
                lines.tell(&Event::Finished { unit: *unit, suite: &identity, report, requests });
            }
            lines.finish()
        };
        let mut order: Vec<usize> = (0..units.len()).collect();
        assert_eq!(told(&order).unwrap(), whole);
        order.reverse();
        assert_eq!(told(&order).unwrap(), whole);
        order.rotate_left(1);
        assert_eq!(told(&order).unwrap(), whole);
        // What is not told of is missing, and that is no whole file.
        order.pop();
        assert!(told(&order).unwrap_err().to_string().starts_with("nothing was told of unit"));
    }

    #[test]
    fn a_disk_that_is_full_is_said_at_the_end() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::StorageFull.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let session = Session::new();
        let results = session.unrecorded(session.report());
        let suite = session.report();
        let identity = suite.identity.clone();
        let mut lines = RunLines::new(Full, (0..suite.trials.len()).collect());
        for (unit, trial) in suite.trials.into_iter().enumerate() {
            let (report, requests) = (&UnitReport::Trial(trial), &results.requests);
            lines.tell(&Event::Finished { unit, suite: &identity, report, requests });
        }
        assert_eq!(lines.finish().err().map(|error| error.kind()), Some(io::ErrorKind::StorageFull));
    }
}
