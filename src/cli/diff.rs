//! `scenario-runner diff KEY`: one run with two controllers or two values, on the same noise, and where the two part.

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;

use super::Exit;
use super::load;
use super::one_case::{FoundCase, KeyArguments, could_not_run, look_for, values};
use super::run::targets;
use super::set::SetArguments;
use files::escape::{shell_path, shell_word};
use lang::{Override, Replacement, Style};
use report::console::{stderr, stdout};
use report::{
    BaselineDiff, DiffSide, RunDiff, baseline_diff_json, diff_json, diff_to_html, render_baseline_diff,
    render_diff,
};
use results::Requests;
use results::judge::baseline::Baseline;
use runner::baseline::{NotKept, against_baseline};
use runner::diff::{NoCounterpart, counterpart, two_runs};
use runner::plan::PlannedTrial;
use runner::project::{PlannedSuite, Project};
use runner::run::{MeasuredMetrics, RunBatch, Stop, Wanted, programs};
use scenario::registry::Registry;
use scenario::{Case, Criterion};

/// One run with two controllers or two values, on the same noise: where the two part, and what both came to
///
/// Makes the run twice, as A and as B, with the same people, the same draws and the same random numbers, and says at which moment the two
/// part and by what: what a vehicle is told, who is shown to it, where somebody is. Then what everybody does over time in both, every
/// contact, every criterion and metric that changed, and whether the verdict did. An option with one value holds for both runs, one with two
/// values gives the first to A and the second to B. Programs that decide run with the permission that `replay` needs.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  scenario-runner diff zebra/scripted/tta=6s/rep=1 --controller av=carla_behavior,idm_aeb
  scenario-runner diff KEY --controller 'av=my_av { gap: 4 m },my_av { gap: 5 m }' --use my_av.scn
  scenario-runner diff KEY --set tta=4s,5s                     two values of a variation, `let` or parameter
  scenario-runner diff KEY --set av.controller.braking_distance=4m,6m --set av.speed=40km/h
  scenario-runner diff KEY --baseline zebra.json               what a baseline keeps of the run, and what it is now
  scenario-runner diff KEY --set tta=4s,5s --json              as JSON, with everybody at every moment told
  scenario-runner diff KEY --set tta=4s,5s --html parts.html   and as a page, side by side

A page opens in any browser, from the file: one sentence says what parts, when, and which criterion
flips; both runs move under one slider; in the plots A is drawn through and B dashed. It needs no
network, and no JavaScript to be read.

The noise is that of KEY as the files have it: with another value the run may have another name, and a seed
of its own when its suite is run.

Exit codes: 0 told, whether they part or not, 3 the files have errors, 4 no such run, 103 not in the baseline, 100 one does not come to its end, 110 the page cannot be written")]
pub struct DiffArguments {
    #[command(flatten)]
    run: KeyArguments,

    /// Two values of what `--set` of other commands gives one: `tta=4s,5s`. With one value it holds for both; may be repeated.
    #[arg(long, value_name = "NAME=A,B")]
    set: Vec<Alternatives<Override>>,

    /// Two controllers in the place of that of every vehicle of this name: `av=carla_behavior,idm_aeb`. With one it drives in both; may
    /// be repeated.
    #[arg(long, value_name = "VEHICLE=A,B")]
    controller: Vec<Alternatives<Replacement>>,

    /// Reads a file in which controllers for `--controller` are declared, as if `use` said so; may be repeated.
    #[arg(long = "use", value_name = "FILE")]
    uses: Vec<PathBuf>,

    /// Lay the run beside what this baseline keeps of it: its metrics, with nine digits. A baseline has no courses, so that where they part
    /// cannot be said.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,

    /// Say it as JSON, with everybody at every moment that is told, and every metric.
    #[arg(long)]
    json: bool,

    /// Write a page, too, with both runs side by side. A baseline has no courses that could be drawn.
    #[arg(long, value_name = "FILE", conflicts_with = "baseline")]
    html: Option<PathBuf>,
}

/// What is said of both runs, or one thing for each.
#[derive(Debug, Clone)]
enum Alternatives<T> {
    Both(T),
    Each([T; 2]),
}

impl<T: FromStr<Err = String>> FromStr for Alternatives<T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((name, values)) = text.split_once('=') else {
            return text.parse().map(Self::Both);
        };
        let one = |value: &str| format!("{name}={value}").parse::<T>();
        match apart(values)[..] {
            [only] => one(only).map(Self::Both),
            [first, second] => Ok(Self::Each([one(first)?, one(second)?])),
            ref more => Err(format!("`{text}` has {} values: give one for A and one for B", more.len())),
        }
    }
}

/// What stands between commas that are in no brackets and no quotes.
fn apart(text: &str) -> Vec<&str> {
    let (mut depth, mut quoted, mut begin) = (0_usize, false, 0);
    let mut parts = Vec::new();
    for (place, letter) in text.char_indices() {
        match letter {
            '"' => quoted = !quoted,
            _ if quoted => {}
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(&text[begin..place]);
                begin = place + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[begin..]);
    parts
}

/// As it is written: `tta=4s,5s`.
impl<T: fmt::Display> fmt::Display for Alternatives<T> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Both(both) => write!(out, "{both}"),
            Self::Each([a, b]) => {
                let b = b.to_string();
                write!(out, "{a},{}", b.split_once('=').map_or(&*b, |(_, value)| value))
            }
        }
    }
}

impl<T> Alternatives<T> {
    fn of(&self, side: usize) -> &T {
        match self {
            Self::Both(both) => both,
            Self::Each(each) => &each[side],
        }
    }

    fn is_each(&self) -> bool {
        matches!(self, Self::Each(_))
    }
}

impl DiffArguments {
    /// What is said of the run: of one of the two, or of neither what only one of them has.
    fn said(&self, side: Option<usize>) -> SetArguments {
        let set = self.set.iter().filter(|one| side.is_some() || !one.is_each());
        let controllers = self.controller.iter().filter(|one| side.is_some() || !one.is_each());
        let side = side.unwrap_or_default();
        SetArguments::of(
            set.map(|one| one.of(side).clone()).collect(),
            controllers.map(|one| one.of(side).clone()).collect(),
            self.uses.clone(),
        )
    }

    /// What one of the two has and the other has otherwise, in words.
    fn otherwise(&self, side: usize) -> String {
        let controllers = self.controller.iter().filter(|one| one.is_each());
        let controllers = controllers.map(|one| format!("controller {}", one.of(side)));
        let set = self.set.iter().filter(|one| one.is_each()).map(|one| one.of(side).to_string());
        controllers.chain(set).collect::<Vec<_>>().join(", ")
    }

    /// The names that are set in one of the two runs or in both.
    fn names(&self) -> Vec<&str> {
        self.set.iter().map(|one| one.of(0).name.as_str()).collect()
    }

    /// What to type to lay the two side by side again.
    fn command(&self, files: &[String]) -> String {
        let mut command = format!("scenario-runner diff {}", shell_word(&self.run.key));
        files.iter().for_each(|file| command += &format!(" {}", shell_word(file)));
        self.run.seed.iter().for_each(|seed| command += &format!(" --seed {seed}"));
        let mut option = |name: &str, said: &str| command += &format!(" --{name} {}", shell_word(said));
        self.controller.iter().for_each(|one| option("controller", &one.to_string()));
        self.uses.iter().for_each(|file| option("use", &file.to_string_lossy()));
        self.set.iter().for_each(|one| option("set", &one.to_string()));
        command
    }

    /// What cannot be asked; it goes to stderr.
    fn check(&self) -> Result<(), Exit> {
        let refused = |message: String, help: &str| {
            writeln!(stderr(), "error: {message}");
            writeln!(stderr(), "help: {help}");
            Err(Exit::Usage)
        };
        let has_each =
            self.set.iter().any(Alternatives::is_each) || self.controller.iter().any(Alternatives::is_each);
        if self.baseline.is_some() && has_each {
            let help = "with a baseline there is one run to make: give every option one value";
            return refused("a baseline is one of the two, and an option has two values".into(), help);
        }
        if !has_each && self.baseline.is_none() {
            let help = "give two values of something: `--controller av=carla_behavior,idm_aeb` or `--set tta=4s,5s`; or a baseline, `--baseline FILE`";
            return refused("there is nothing to lay side by side: no option has two values".into(), help);
        }
        let sides = || self.set.iter().flat_map(|one| [one.of(0), one.of(1)]);
        if sides().any(|one| one.name == "seed") {
            let help = "`--seed` gives the suite another seed, for both runs";
            return refused("both runs are made with the seed of the run, which is not set".into(), help);
        }
        if self.set.iter().any(|one| one.is_each() && one.of(0).name == "repeat") {
            let help = "every run is made by itself, however many its trial has: name another with KEY, as in `…/rep=2`, or give two values of \
                        what it is made of: `--controller av=carla_behavior,idm_aeb`, `--set tta=4s,5s`. `--set repeat=30` of both makes keys \
                        up to `…/rep=30` known";
            return refused(
                "`repeat` says how many runs a trial has, and makes none of them otherwise".into(),
                help,
            );
        }
        if let Some(list) = sides().find(|one| one.is_list()) {
            let help = "give each of the two runs one value, as in `tta=4s,5s`";
            return refused(format!("`{list}` gives several values, and a run has one"), help);
        }
        Ok(())
    }
}

pub fn diff(arguments: &DiffArguments, registry: &Registry) -> Exit {
    tell(arguments, registry).unwrap_or_else(|exit| exit)
}

fn tell(arguments: &DiffArguments, registry: &Registry) -> Result<Exit, Exit> {
    arguments.check()?;
    let run = &arguments.run;
    let files = run.files("diff")?;
    if let Some(complaint) = arguments.html.as_deref().and_then(|path| page_refused(path, &files)) {
        writeln!(stderr(), "error: {complaint}");
        return Err(Exit::Usage);
    }
    if let Some(path) = &arguments.baseline {
        return beside_baseline(arguments, &files, path, registry);
    }
    let mut shown = BTreeSet::new();
    let mut open = |side: Option<usize>| opened(arguments, &files, side, registry, &mut shown);
    let [as_it_is, a, b] = [open(None)?, open(Some(0))?, open(Some(1))?];
    let (place, reference) = reference(run, [&as_it_is, &a, &b])?;
    let names = arguments.names();
    let found = |side: usize, project: &Project| {
        counterpart(&project.suites()[place].suite, &reference, &names)
            .map_err(|error| no_counterpart(&error, arguments, side))
    };
    let found: [(Case, Vec<Criterion>); 2] = [found(0, &a)?, found(1, &b)?];
    let suites = [&a.suites()[place], &b.suites()[place]];
    let mut requests = Requests::defaults(registry);
    found.iter().for_each(|(_, criteria)| requests.include(criteria));
    let threads = run.programs.threads(Some(1), suites.map(|suite| &suite.suite))?;
    let (measured, stop) = (MeasuredMetrics::new(requests), Stop::default());
    let batch = RunBatch { executor: &threads, measured: &measured, stop: &stop };
    let two = match two_runs(batch, &found[0].0, &found[1].0) {
        Ok(two) => two,
        Err(error) => return Ok(could_not_run(&error)),
    };
    let mut remarks = Vec::new();
    for (side, (letter, outcome)) in [("A", &two.a.outcome), ("B", &two.b.outcome)].into_iter().enumerate() {
        let (case, _) = &found[side];
        let planned = look_for(&case.key, std::slice::from_ref(suites[side]));
        if let Some(Ok(planned)) = planned
            && planned.case.seed != case.seed
        {
            remarks.push(format!(
                "{letter} is made on the noise of {}: when its suite is run, {} has another seed",
                reference.key, case.key
            ));
        }
        if !programs(case).is_empty() {
            match batch.one(case, Wanted::Outcome) {
                Ok(again) if again.outcome.fingerprint == outcome.fingerprint => {}
                Ok(_) => remarks.push(format!(
                    "{letter} went differently when it was repeated: what differs may come from the chance of its program"
                )),
                Err(error) => return Ok(could_not_run(&error)),
            }
        }
    }
    let otherwise = [arguments.otherwise(0), arguments.otherwise(1)];
    let values = [values(suites[0], &found[0].0), values(suites[1], &found[1].0)];
    let side = |side: usize| DiffSide {
        otherwise: &otherwise[side],
        case: &found[side].0,
        values: &values[side],
        criteria: &found[side].1,
    };
    let told = RunDiff {
        key: &run.key,
        sides: [side(0), side(1)],
        requests: &measured.requests,
        two: &two,
        remarks: &remarks,
    };
    if arguments.json {
        writeln!(stdout(), "{:#}", diff_json(&told));
    } else {
        write!(stdout(), "{}", render_diff(&told));
    }
    if let Some(path) = &arguments.html {
        files::write(path, diff_to_html(&told, &arguments.command(&files))).map_err(|error| {
            writeln!(stderr(), "error: cannot write {}: {error}", path.display());
            Exit::Output
        })?;
    }
    Ok(Exit::Success)
}

/// Why a page may not be written there.
fn page_refused(path: &Path, files: &[String]) -> Option<String> {
    let read: Vec<&str> = files.iter().map(String::as_str).collect();
    targets::check(&[("--html", path)], &read).err()
}

/// The run as it is now, beside what a baseline keeps of it.
fn beside_baseline(
    arguments: &DiffArguments,
    files: &[String],
    path: &Path,
    registry: &Registry,
) -> Result<Exit, Exit> {
    let run = &arguments.run;
    let refused = |message: String, help: String| {
        writeln!(stderr(), "error: {message}");
        writeln!(stderr(), "help: {help}");
        Exit::Baseline
    };
    let named = || shell_path(&path.to_string_lossy());
    let record = || format!("scenario-runner baseline save {} --out {}", paths(files), named());
    let baseline = Baseline::read(path).map_err(|error| refused(error.to_string(), error.hint(&record())))?;
    let baseline = baseline.resolved(registry);
    let project = opened(arguments, files, Some(1), registry, &mut BTreeSet::new())?;
    let (place, case) = reference(run, [&project; 3])?;
    let suite = &project.suites()[place];
    let is_of = |trial: &PlannedTrial| trial.cases.named(&case.key).is_some();
    let Some(trial) = suite.plan.trials().find(is_of) else {
        let help = "name a run of a trial, as `baseline show` lists them".to_string();
        return Err(refused(
            format!("`{}` is no run of a trial, and a baseline keeps no other", case.key),
            help,
        ));
    };
    let mut requests = Requests::defaults(registry);
    requests.include(&trial.criteria);
    let threads = run.programs.threads(Some(1), [&suite.suite])?;
    let (measured, stop) = (MeasuredMetrics::new(requests), Stop::default());
    let batch = RunBatch { executor: &threads, measured: &measured, stop: &stop };
    let outcome = match batch.one(&case, Wanted::Outcome) {
        Ok(ran) => ran.outcome,
        Err(error) => return Ok(could_not_run(&error)),
    };
    // As it is called where its suite is alone.
    let outcome = results::Outcome { key: suite.suite.own_key(&outcome.key).to_string(), ..outcome };
    let against = against_baseline(&baseline, &suite.plan.suite, &trial, &outcome, &measured.requests);
    let against = against.map_err(|error| {
        let help = match &error {
            NotKept::Noise { seed, .. } => {
                format!("`--seed {seed}` runs it on that noise; or record anew with `{}`", record())
            }
            _ => format!("`scenario-runner baseline show {}` lists its runs", named()),
        };
        refused(format!("{}: {error}", path.display()), help)
    })?;
    let mut remarks = Vec::new();
    if baseline.set != suite.suite.set {
        let said = |set: &[String]| if set.is_empty() { "nothing".to_string() } else { set.join(", ") };
        remarks.push(format!("set then: {}; set now: {}", said(&baseline.set), said(&suite.suite.set)));
    }
    if !baseline.nondeterministic.is_empty() {
        remarks.push(
            "a program of the baseline is not deterministic: what differs may come from chance".to_string(),
        );
    }
    let (values, otherwise) = (values(suite, &case), String::new());
    let now = DiffSide { otherwise: &otherwise, case: &case, values: &values, criteria: &trial.criteria };
    let told = BaselineDiff {
        baseline: &path.display().to_string(),
        now,
        outcome: &outcome,
        requests: &measured.requests,
        against: &against,
        remarks: &remarks,
    };
    if arguments.json {
        writeln!(stdout(), "{:#}", baseline_diff_json(&told));
    } else {
        write!(stdout(), "{}", render_baseline_diff(&told));
    }
    Ok(Exit::Success)
}

/// The files as they are, or as one of the two runs has them; what there is to say goes to stderr, once.
fn opened(
    arguments: &DiffArguments,
    files: &[String],
    side: Option<usize>,
    registry: &Registry,
    shown: &mut BTreeSet<String>,
) -> Result<Project, Exit> {
    let opened = load::open_all(files, arguments.run.seed, &arguments.said(side), registry)?;
    let (project, notices, exit) = match opened {
        Ok(project) => {
            let notices = project.notices().to_vec();
            (Some(project), notices, Exit::Success)
        }
        Err(problems) => (None, problems.0, Exit::Scenario),
    };
    for notice in notices {
        let said = notice.render(Style { colour: false });
        if shown.insert(said.clone()) {
            stderr().styled(&said);
        }
    }
    project.ok_or(exit)
}

/// The run that was asked for as the files have it, else as one of the two has it, with the place of its suite.
fn reference(run: &KeyArguments, projects: [&Project; 3]) -> Result<(usize, Case), Exit> {
    for project in projects {
        let suites = project.suites();
        let found = |(place, suite): (usize, &PlannedSuite)| {
            let found = look_for(&run.key, std::slice::from_ref(suite))?;
            Some(found.map(|FoundCase { case, .. }| (place, case)))
        };
        let mut found: Vec<(usize, Case)> =
            suites.iter().enumerate().filter_map(found).collect::<Result<_, Exit>>()?;
        if let [(first, _), (second, _), ..] = found[..] {
            let files = [&suites[first].file, &suites[second].file];
            writeln!(stderr(), "error: {} and {} both have a run `{}`", files[0], files[1], run.key);
            writeln!(stderr(), "help: name one of the two files");
            return Err(Exit::NothingSelected);
        }
        if let Some(found) = found.pop() {
            return Ok(found);
        }
    }
    match run.find(projects[0].suites()) {
        Err(exit) => Err(exit),
        Ok(_) => unreachable!("it was looked for before"),
    }
}

fn no_counterpart(error: &NoCounterpart, arguments: &DiffArguments, side: usize) -> Exit {
    let letter = ["A", "B"][side];
    writeln!(stderr(), "error: there is no run {letter} ({}): {error}", arguments.otherwise(side));
    match error {
        NoCounterpart::Plan(_) => Exit::Scenario,
        NoCounterpart::AtPoint(_) => {
            writeln!(stderr(), "help: with `--controller` it can; or name a run of a trial");
            Exit::NothingSelected
        }
        _ => {
            let file = paths(&arguments.run.files("diff").unwrap_or_default());
            writeln!(
                stderr(),
                "help: `scenario-runner {file} --list` with the same `--set` lists its trials"
            );
            Exit::NothingSelected
        }
    }
}

/// Files as words of a command.
fn paths(files: &[String]) -> String {
    files.iter().map(|file| shell_path(file)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_of_each_is_apart_by_commas_outside_of_brackets() {
        let both = |text: &str| match text.parse::<Alternatives<Replacement>>() {
            Ok(Alternatives::Each([a, b])) => vec![a.to_string(), b.to_string()],
            Ok(Alternatives::Both(both)) => vec![both.to_string()],
            Err(error) => vec![error],
        };
        assert_eq!(both("av=a,b"), ["av=a", "av=b"]);
        assert_eq!(both("av=a { x: 1 m, y: 2 m }"), ["av=a { x: 1 m, y: 2 m }"]);
        let parts = apart("av=a{x: f(1, 2)},b{word: \"c,d\"}");
        assert_eq!(parts, ["av=a{x: f(1, 2)}", "b{word: \"c,d\"}"]);
        assert!(both("av=a,b,c")[0].contains("has 3 values"), "{:?}", both("av=a,b,c"));
        assert!(both("av=a,")[0].contains("names no controller"));
        assert!(both("av")[0].contains("names no controller"));
        // What is written again is what was said.
        for said in ["av=a,b", "av=a { x: 1 m, y: 2 m }", "av=a { x: 1 m },b { word: \"c,d\" }"] {
            assert_eq!(said.parse::<Alternatives<Replacement>>().unwrap().to_string(), said);
        }
    }
}
