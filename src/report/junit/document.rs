//! JUnit's elements and attributes, written as they come.

use std::io::{self, Write};
use std::time::{Duration, SystemTime};

use chrono::{DateTime, Utc};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};

use files::escape::{xml, xml_line};

/// What a testcase counts as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TestOutcome {
    #[default]
    Passed,
    Skipped,
    Failure,
    Error,
}

/// How many testcases count as what.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    tests: usize,
    skipped: usize,
    failures: usize,
    errors: usize,
}

impl Counts {
    pub fn add(&mut self, kind: TestOutcome) {
        self.tests += 1;
        match kind {
            TestOutcome::Passed => {}
            TestOutcome::Skipped => self.skipped += 1,
            TestOutcome::Failure => self.failures += 1,
            TestOutcome::Error => self.errors += 1,
        }
    }
}

/// A testsuite without its testcases.
pub struct TestSuite<'s> {
    pub name: &'s str,
    pub counts: Counts,
    pub started: SystemTime,
    pub time: Option<Duration>,
    pub properties: Vec<(String, String)>,
}

/// A testcase.
#[derive(Default)]
pub struct TestCase {
    name: String,
    pub class: String,
    pub kind: TestOutcome,
    pub time: Option<Duration>,
    /// File and line.
    pub place: Option<(String, usize)>,
    properties: Vec<(String, String)>,
    problem: Option<Problem>,
    pub output: Option<String>,
    /// What a program under test wrote to its standard error.
    pub errors: Option<String>,
}

impl TestCase {
    /// One that passed unless there is a problem.
    pub fn new(name: &str, problem: Option<Problem>) -> Self {
        Self { name: name.to_string(), problem, ..Self::default() }
    }

    pub fn property(&mut self, name: &str, value: &str) {
        self.properties.push((name.to_string(), value.to_string()));
    }
}

/// Why a testcase did not pass.
pub struct Problem {
    /// What kind of problem it is, in a word; nothing for what was not run.
    name: Option<&'static str>,
    /// What it is about, in a line.
    message: String,
    /// All there is to say.
    text: Option<String>,
}

impl Problem {
    pub fn new(name: &'static str, message: &str, text: String) -> Self {
        Self { name: Some(name), message: message.to_string(), text: Some(text) }
    }

    pub fn skipped(reason: &str) -> Self {
        Self { name: None, message: reason.to_string(), text: None }
    }
}

/// A document that is being written.
pub struct JunitReport<W: Write>(Writer<W>);

impl<W: Write> JunitReport<W> {
    pub fn begin(out: W, counts: Counts, started: Option<SystemTime>, time: Duration) -> io::Result<Self> {
        let mut writer = Writer::new_with_indent(out, b' ', 4);
        writer.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        let mut tag = BytesStart::new("testsuites");
        attribute(&mut tag, "name", "scenario-runner");
        attribute(&mut tag, "tests", &counts.tests.to_string());
        attribute(&mut tag, "skipped", &counts.skipped.to_string());
        attribute(&mut tag, "failures", &counts.failures.to_string());
        attribute(&mut tag, "errors", &counts.errors.to_string());
        if let Some(started) = started {
            attribute(&mut tag, "timestamp", &timestamp(started));
        }
        attribute(&mut tag, "time", &seconds(time));
        writer.write_event(Event::Start(tag))?;
        Ok(Self(writer))
    }

    /// Begins a testsuite; its testcases come next.
    pub fn suite(&mut self, suite: &TestSuite) -> io::Result<()> {
        let mut tag = BytesStart::new("testsuite");
        attribute(&mut tag, "name", suite.name);
        attribute(&mut tag, "tests", &suite.counts.tests.to_string());
        attribute(&mut tag, "skipped", &suite.counts.skipped.to_string());
        attribute(&mut tag, "errors", &suite.counts.errors.to_string());
        attribute(&mut tag, "failures", &suite.counts.failures.to_string());
        attribute(&mut tag, "timestamp", &timestamp(suite.started));
        if let Some(time) = suite.time {
            attribute(&mut tag, "time", &seconds(time));
        }
        self.0.write_event(Event::Start(tag))?;
        self.properties(&suite.properties)
    }

    pub fn case(&mut self, case: &TestCase) -> io::Result<()> {
        let mut tag = BytesStart::new("testcase");
        attribute(&mut tag, "name", &case.name);
        attribute(&mut tag, "classname", &case.class);
        if let Some(time) = case.time {
            attribute(&mut tag, "time", &seconds(time));
        }
        if let Some((file, line)) = &case.place {
            attribute(&mut tag, "file", file);
            attribute(&mut tag, "line", &line.to_string());
        }
        if case.properties.is_empty()
            && case.problem.is_none()
            && case.output.is_none()
            && case.errors.is_none()
        {
            return self.0.write_event(Event::Empty(tag));
        }
        self.0.write_event(Event::Start(tag))?;
        self.properties(&case.properties)?;
        if let Some(problem) = &case.problem {
            self.problem(case.kind, problem)?;
        }
        if let Some(output) = &case.output {
            self.text(BytesStart::new("system-out"), output)?;
        }
        if let Some(errors) = &case.errors {
            self.text(BytesStart::new("system-err"), errors)?;
        }
        self.close("testcase")
    }

    pub fn end_suite(&mut self) -> io::Result<()> {
        self.close("testsuite")
    }

    /// Ends the document with a line end.
    pub fn end(mut self) -> io::Result<()> {
        self.close("testsuites")?;
        self.0.write_indent()
    }

    fn properties(&mut self, properties: &[(String, String)]) -> io::Result<()> {
        if properties.is_empty() {
            return Ok(());
        }
        self.0.write_event(Event::Start(BytesStart::new("properties")))?;
        for (name, value) in properties {
            let mut tag = BytesStart::new("property");
            attribute(&mut tag, "name", name);
            attribute(&mut tag, "value", value);
            self.0.write_event(Event::Empty(tag))?;
        }
        self.close("properties")
    }

    fn problem(&mut self, kind: TestOutcome, problem: &Problem) -> io::Result<()> {
        let mut tag = BytesStart::new(match kind {
            TestOutcome::Error => "error",
            TestOutcome::Skipped => "skipped",
            TestOutcome::Failure | TestOutcome::Passed => "failure",
        });
        attribute(&mut tag, "message", &problem.message);
        if let Some(name) = problem.name {
            attribute(&mut tag, "type", name);
        }
        match &problem.text {
            Some(text) => self.text(tag, text),
            None => self.0.write_event(Event::Empty(tag)),
        }
    }

    fn text(&mut self, tag: BytesStart, text: &str) -> io::Result<()> {
        let end = tag.to_end().into_owned();
        self.0.write_event(Event::Start(tag))?;
        self.0.write_event(Event::Text(BytesText::new(&xml(text))))?;
        self.0.write_event(Event::End(end))
    }

    fn close(&mut self, name: &str) -> io::Result<()> {
        self.0.write_event(Event::End(BytesEnd::new(name)))
    }
}

fn attribute(tag: &mut BytesStart, name: &str, value: &str) {
    tag.push_attribute((name, xml_line(value).as_str()));
}

fn timestamp(time: SystemTime) -> String {
    DateTime::<Utc>::from(time).format("%Y-%m-%dT%H:%M:%S%.3f%:z").to_string()
}

/// s
fn seconds(time: Duration) -> String {
    format!("{:.3}", time.as_secs_f64())
}
