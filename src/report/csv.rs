//! Every run as a row of CSV (RFC 4180), for spreadsheets and data frames. No wall times: the same suites and seeds give
//! the same bytes, on any number of threads.

use std::io::{self, Write};

use ::csv::{Terminator, Writer, WriterBuilder};

use super::rows::{Row, What, each_row};
use super::{need_every_trial, verdict_word};
use files::escape::csv_cell;
use results::judge::{PerRun, per_run};
use results::{Outcome, Requests, Results, SuiteReport};
use scenario::{Individual, Metric, MetricKind, Value};
use sim::StopReason;

/// Columns of every file, before those that depend on the suites.
const FIRST: [&str; 10] = [
    "suite",
    "scenario",
    "trial",
    "run",
    "state",
    "verdict",
    "seed",
    "individuals",
    "ending",
    "ending_time [s]",
];
/// Columns after those.
const LAST: [&str; 2] = ["fingerprint", "message"];

/// Which columns stand between the first and the last: all that any of the suites has, in the order of the plan.
struct Columns<'r> {
    variations: Vec<&'r str>,
    /// What runs draw.
    drawn: Vec<&'r str>,
    /// Index in the outcomes, metric and heading.
    metrics: Vec<(usize, &'r Metric, String)>,
    criteria: Vec<&'r str>,
}

/// Writes a header and a row for each run.
///
/// # Errors
/// Those of `out`; or the results do not hold every trial.
pub fn write_csv(results: &Results, out: impl Write) -> io::Result<()> {
    need_every_trial(results)?;
    let Results { requests, suites: reports, recordings: _, denies_untested: _ } = results;
    let columns = Columns::of(reports, requests);
    let mut writer = WriterBuilder::new().terminator(Terminator::CRLF).from_writer(out);
    columns.write_header(&mut writer)?;
    for report in reports {
        each_row(report, |row, criteria| columns.write(row, criteria, requests, &mut writer))?;
    }
    writer.flush()
}

impl<'r> Columns<'r> {
    fn of(reports: &'r [SuiteReport], requests: &'r Requests) -> Self {
        let mut variations: Vec<&str> = Vec::new();
        let mut criteria: Vec<&str> = Vec::new();
        let mut drawn: Vec<&str> = Vec::new();
        let add = |columns: &mut Vec<&'r str>, name: &'r str| {
            if !columns.contains(&name) {
                columns.push(name);
            }
        };
        for trial in reports.iter().flat_map(|report| &report.trials) {
            trial.trial.variation.iter().for_each(|one| add(&mut variations, &one.name));
            trial.outcomes.iter().flat_map(|run| &run.drawn).for_each(|one| add(&mut drawn, &one.name));
            let judged = trial.trial.criteria.iter().filter(|criterion| per_run(criterion).is_some());
            judged.for_each(|criterion| add(&mut criteria, &criterion.text));
        }
        let metric = |(index, reference): (usize, &'r scenario::MetricReference)| {
            let metric = reference.known()?;
            let unit = metric.unit();
            let label = reference.label();
            let heading = if unit.is_empty() { label } else { format!("{label} [{unit}]") };
            Some((index, metric, heading))
        };
        Self {
            variations,
            drawn,
            metrics: requests.iter().enumerate().filter_map(metric).collect(),
            criteria,
        }
    }

    fn write_header(&self, writer: &mut Writer<impl Write>) -> io::Result<()> {
        FIRST.iter().try_for_each(|name| writer.write_field(name))?;
        for name in &self.variations {
            writer.write_field(csv_cell(&format!("variation {name}")))?;
        }
        for name in &self.drawn {
            writer.write_field(csv_cell(&format!("drawn {name}")))?;
        }
        for (_, _, heading) in &self.metrics {
            writer.write_field(csv_cell(heading))?;
        }
        for text in &self.criteria {
            writer.write_field(csv_cell(&format!("criterion {text}")))?;
        }
        LAST.iter().try_for_each(|name| writer.write_field(name))?;
        Ok(writer.write_record(None::<&[u8]>)?)
    }

    fn write(
        &self,
        row: &Row,
        criteria: &[PerRun],
        requests: &Requests,
        writer: &mut Writer<impl Write>,
    ) -> io::Result<()> {
        let outcome = match &row.what {
            What::Run(outcome) => Some(*outcome),
            What::Nothing(..) => None,
        };
        for name in [row.suite, row.scenario, row.trial] {
            writer.write_field(csv_cell(name))?;
        }
        let of = |cell: &dyn Fn(&Outcome) -> String| outcome.map(cell).unwrap_or_default();
        writer.write_field(of(&|run| csv_cell(&run.key)))?;
        writer.write_field(row.state())?;
        writer.write_field(row.verdict.map_or("", verdict_word))?;
        writer.write_field(of(&|run| run.seed.to_string()))?;
        writer.write_field(of(&|run| csv_cell(&people(&run.individuals))))?;
        writer.write_field(of(&|run| ending(run.ending.reason).to_string()))?;
        writer.write_field(of(&|run| run.ending.time.to_string()))?;
        let cell = |value: &Value| match value {
            Value::Word(word) => csv_cell(word),
            value => value.to_string(),
        };
        for name in &self.variations {
            let value = row.variation.iter().find(|one| one.name == *name).map(|one| cell(&one.value));
            writer.write_field(value.unwrap_or_default())?;
        }
        for name in &self.drawn {
            writer.write_field(of(&|run| {
                let value = run.drawn.iter().find(|one| one.name == *name).map(|one| cell(&one.value));
                value.unwrap_or_default()
            }))?;
        }
        for (index, metric, _) in &self.metrics {
            writer.write_field(of(&|run| {
                run.metrics[*index].map_or(String::new(), |value| number(metric, value))
            }))?;
        }
        for text in &self.criteria {
            let one = criteria.iter().find(|one| one.criterion.text == *text);
            let holds = one.zip(outcome).map(|(one, run)| one.standing(run, requests).holds);
            writer.write_field(holds.map_or("", |holds| if holds { "holds" } else { "fails" }))?;
        }
        writer.write_field(of(&|run| format!("0x{:016x}", run.fingerprint)))?;
        writer.write_field(match &row.what {
            What::Run(_) => String::new(),
            What::Nothing(_, message) => csv_cell(message),
        })?;
        Ok(writer.write_record(None::<&[u8]>)?)
    }
}

/// In SI units with all digits; flags as 0 and 1, words as words.
fn number(metric: &Metric, value: f64) -> String {
    match &metric.kind {
        MetricKind::Category(words) => {
            words.get(value as usize).map(|word| word.to_string()).unwrap_or_default()
        }
        MetricKind::Flag | MetricKind::Quantity(_) => value.to_string(),
    }
}

fn people(individuals: &[Individual]) -> String {
    let one = |one: &Individual| format!("{}: {} of {}", one.pedestrian, one.number, one.population);
    individuals.iter().map(one).collect::<Vec<_>>().join("; ")
}

fn ending(reason: StopReason) -> &'static str {
    match reason {
        StopReason::Completed => "completed",
        StopReason::Collision => "collision",
        StopReason::Horizon => "horizon",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Session;

    fn text() -> String {
        let session = Session::new();
        let mut text = Vec::new();
        write_csv(&session.unrecorded(session.report()), &mut text).unwrap();
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn a_row_for_each_run_and_for_what_has_none() {
        let text = text();
        let lines: Vec<_> = text.lines().collect();
        insta::assert_snapshot!([&lines[..5], &lines[lines.len() - 2..]].concat().join("\n"));
        assert_eq!(text.matches("\r\n").count(), 1 + 2 + 4 * 6 + 2 + 1, "{text}");
    }

    #[test]
    fn every_row_has_every_column_and_reads_back() {
        let text = text();
        let mut reader = ::csv::Reader::from_reader(text.as_bytes());
        let headings = reader.headers().unwrap().clone();
        let at = |name: &str| headings.iter().position(|known| known == name).unwrap();
        let session = Session::new();
        let report = session.report();
        let runs: Vec<_> = report.trials.iter().flat_map(|trial| &trial.outcomes).collect();
        let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
        let read = rows.iter().filter(|row| &row[at("state")] == "finished").skip(report.recorded.len() - 1);
        let index = session.requests.iter().position(|one| one.name() == "pet").unwrap();
        for (row, run) in read.zip(&runs) {
            assert_eq!(row[at("run")], run.key);
            assert_eq!(row[at("pet [s]")].parse().ok(), run.metrics[index]);
            assert_eq!(row[at("seed")].parse(), Ok(run.seed));
        }
    }
}
