//! Two runs on the same noise as a page: what parts, when, and which criterion flips; then both beside each other.

use minijinja::value::Serde;
use serde::Serialize;
use serde_json::json;

use super::asked::AskedOfRun;
use super::diff_plots::{DiffPlots, DrawnSide, looks};
use super::embed;
use super::rendered;
use super::still::still;
use super::told::{RunTold, Why, quoted};
use crate::diff::{self, LETTERS, RunDiff};
use crate::replay::describe;
use crate::why::Standing;
use results::{OneOfTwo, Parting, Program};

#[derive(Debug, Serialize)]
struct DiffPage {
    version: String,
    platform: String,
    key: String,
    /// In one sentence, with the class that colours it and the mark before it.
    verdict: String,
    class: &'static str,
    mark: &'static str,
    command: String,
    sides: Vec<ShownSide>,
    /// What controllers were told at the moment at which both are seen, and was not so.
    perceived: Vec<String>,
    /// The moments that matter, and what is not fulfilled.
    why: Vec<Why>,
    plots: DiffPlots,
    /// Which moment is marked in the plots, in words; empty if none is.
    moment: String,
    /// At which moment both are seen without the script.
    shown_at: String,
    events: Vec<String>,
    headings: Vec<String>,
    moments: Vec<Vec<String>>,
    facts: Vec<String>,
    criteria: Vec<CriterionRow>,
    metrics: Vec<MetricRow>,
    same_metrics: String,
    shared: String,
    remarks: Vec<String>,
    /// JSON for the script.
    runs: String,
}

/// One of the two as it is seen before the script draws it.
#[derive(Debug, Serialize)]
struct ShownSide {
    letter: &'static str,
    otherwise: String,
    key: String,
    fingerprint: String,
    sentence: String,
    swatch: String,
    view_box: String,
    /// SVG elements.
    still: String,
}

#[derive(Debug, Serialize)]
struct CriterionRow {
    criterion: String,
    a: String,
    b: String,
    changed: bool,
    flips: bool,
}

#[derive(Debug, Serialize)]
struct MetricRow {
    metric: String,
    a: String,
    b: String,
    change: String,
}

/// Two runs side by side as one HTML file that needs nothing else. `command` makes it again.
pub fn diff_to_html(run: &RunDiff, command: &str) -> String {
    let styles = [include_str!("page.css"), include_str!("player.css"), include_str!("diff.css")];
    rendered("diff.html", &styles, Serde(DiffPage::new(run, command)))
}

impl DiffPage {
    fn new(run: &RunDiff, command: &str) -> Self {
        let reasons = run.reasons();
        let criteria = diff::criteria(&reasons);
        let [in_a, in_b] = reasons;
        let told = [(in_a, &run.two.a), (in_b, &run.two.b)]
            .map(|(reasons, one)| RunTold::of(reasons, "", &one.recording));
        let (class, mark) = colour(run.standings());
        let parting = run.two.apart.as_ref().or(run.two.first.as_ref());
        let moment = first_failure(&told).or(parting.map(|parting| parting.time));
        let drawn = both(run).map(|(_, one, criteria)| DrawnSide {
            recording: &one.recording,
            asked: AskedOfRun::of_run(criteria, &one.outcome, run.requests, &one.recording),
        });
        let (headings, moments) = diff::course(run);
        let pairs = diff::metric_pairs(run);
        let metrics: Vec<MetricRow> = pairs
            .iter()
            .filter(|pair| pair.shown()[0] != pair.shown()[1])
            .map(|pair| {
                let ([a, b], change) = (pair.shown(), pair.change_words());
                MetricRow {
                    metric: pair.reference.label(),
                    a,
                    b,
                    change: change.unwrap_or_else(|| "–".into()),
                }
            })
            .collect();
        let same = pairs.len() - metrics.len();
        let why = why(run, &told, &criteria);
        let shown_at = moment.unwrap_or_default();
        let (sides, perceived) = shown(run, &told, shown_at);
        let program = Program::this();
        Self {
            version: program.version,
            platform: program.platform,
            key: run.key.to_string(),
            verdict: sentence(run, &criteria),
            class,
            mark,
            command: command.to_string(),
            runs: embedded(run, &told, &why, moment, command),
            plots: DiffPlots::new(&drawn, parting.map(|parting| parting.time)),
            moment: parting.map_or_else(String::new, |parting| {
                format!("upright line: {:.2} s, where they part", parting.time)
            }),
            shown_at: format!("{shown_at:.2} s"),
            events: events(run)
                .iter()
                .map(|(time, who, what)| format!("{time:.2} s  {who} {what}"))
                .collect(),
            headings,
            moments,
            facts: facts(run),
            criteria: criteria.iter().map(CriterionRow::new).collect(),
            same_metrics: match metrics.is_empty() {
                true => format!("All {} metrics are the same in both.", pairs.len()),
                false => format!("The other {same} of {} metrics are the same in both.", pairs.len()),
            },
            metrics,
            shared: diff::shared(run),
            remarks: run.remarks.iter().map(|remark| quoted(remark)).collect(),
            sides,
            perceived,
            why,
        }
    }
}

impl CriterionRow {
    fn new(one: &diff::CriterionInBoth) -> Self {
        let words = |side: &Option<String>| side.clone().unwrap_or_else(|| "not asked".into());
        let (changed, flips) = (one.changed(), one.flips);
        Self { criterion: one.criterion.clone(), a: words(&one.a), b: words(&one.b), changed, flips }
    }
}

/// Both with their letters and what is asked of them.
fn both<'r>(run: &'r RunDiff) -> [(&'static str, &'r OneOfTwo, &'r [scenario::Criterion]); 2] {
    let [a, b] = &run.sides;
    [(LETTERS[0], &run.two.a, a.criteria), (LETTERS[1], &run.two.b, b.criteria)]
}

/// Green where both have all that is asked of them, and where one has not, as that is.
fn colour(standings: [Standing; 2]) -> (&'static str, &'static str) {
    match standings {
        [Standing::Passed, Standing::Passed] => ("passed", "✓"),
        both if both.contains(&Standing::Failed) => ("failed", "✗"),
        _ => ("inconclusive", "?"),
    }
}

/// Whether the verdict changes and by which criteria, and where the two part.
fn sentence(run: &RunDiff, criteria: &[diff::CriterionInBoth]) -> String {
    let verdict = diff::verdict(run.standings());
    let flips: Vec<String> =
        criteria.iter().filter(|one| one.flips).map(|one| format!("“{}”", one.criterion)).collect();
    let flips = match flips.len() {
        0 => "no criterion flips".to_string(),
        1 => format!("{} flips", flips[0]),
        _ => format!("{} flip", flips.join(", ")),
    };
    let first = |parting: &Parting| format!("they part at {:.2} s ({})", parting.time, diff::by(parting));
    let parts = match (&run.two.first, &run.two.apart) {
        (None, _) => "they do not part".to_string(),
        (Some(parting), Some(apart)) if parting.time < apart.time => {
            format!("{}, visibly at {:.2} s", first(parting), apart.time)
        }
        (Some(parting), Some(_)) => first(parting),
        (Some(parting), None) => format!("{}, never by more than 0.1 m or 0.1 m/s", first(parting)),
    };
    let mut sentence = quoted(&format!("{verdict}; {flips}; {parts}."));
    sentence.get_mut(..1).into_iter().for_each(str::make_ascii_uppercase);
    sentence
}

/// The first moment at which one of the two fails something, s.
fn first_failure(told: &[RunTold; 2]) -> Option<f64> {
    told.iter().filter_map(|one| one.moment).min_by(f64::total_cmp)
}

/// The moments that matter, and how both stand to what changes or is not fulfilled.
fn why(run: &RunDiff, told: &[RunTold; 2], criteria: &[diff::CriterionInBoth]) -> Vec<Why> {
    let mut all: Vec<Why> = diff::partings(run)
        .into_iter()
        .map(|(text, time)| Why { class: "parts", text: quoted(&text), time })
        .collect();
    for (letter, one, _) in both(run) {
        all.extend(one.contacts.iter().map(|contact| Why {
            class: "failed",
            text: format!("{letter}: contact, {}", diff::contact_words(contact)),
            time: Some(contact.time),
        }));
    }
    let flips =
        |text: &str| criteria.iter().any(|one| one.flips && text.contains(&format!("“{}”", one.criterion)));
    for (letter, one) in LETTERS.into_iter().zip(told) {
        let matters = one.why.iter().filter(|one| one.class != "passed" || flips(&one.text));
        all.extend(matters.map(|one| Why {
            class: one.class,
            text: format!("{letter} {}", one.text),
            time: one.time,
        }));
    }
    all
}

/// What happens in both, in the order of time; what happens in both at once is told once.
fn events(run: &RunDiff) -> Vec<(f64, String, String)> {
    let of = |one: &OneOfTwo| -> Vec<(f64, String, String)> {
        let told =
            |event: &sim::TimelineEvent| (event.time, event.who.clone(), quoted(&describe(&event.what)));
        one.recording.events.iter().map(told).collect()
    };
    let (a, b) = (of(&run.two.a), of(&run.two.b));
    let named = |(time, who, what): &(f64, String, String), letters: &str| {
        (*time, format!("{letters}: {who}"), what.clone())
    };
    let in_a = a.iter().map(|event| named(event, if b.contains(event) { "A and B" } else { "A" }));
    let in_b = b.iter().filter(|event| !a.contains(event)).map(|event| named(event, "B"));
    let mut all: Vec<(f64, String, String)> = in_a.chain(in_b).collect();
    all.sort_by(|one, other| one.0.total_cmp(&other.0));
    all
}

/// What is to be known of both besides the tables.
fn facts(run: &RunDiff) -> Vec<String> {
    let differs = match run.two.differs.is_empty() {
        true => "what they are made of does not differ".to_string(),
        false => format!("what they are made of differs in {}", run.two.differs.join("; ")),
    };
    let all = [differs, diff::contacts(run.two), diff::endings(run.outcomes())];
    let sentence = |text: &String| {
        let mut text = quoted(text);
        text.get_mut(..1).into_iter().for_each(str::make_ascii_uppercase);
        text + "."
    };
    all.iter().map(sentence).collect()
}

/// Both at a time (s), and what controllers were told then that was not so.
fn shown(run: &RunDiff, told: &[RunTold; 2], time: f64) -> (Vec<ShownSide>, Vec<String>) {
    let each = both(run).into_iter().zip(&run.sides).zip(told).zip(looks());
    let mut perceived = Vec::new();
    let sides = each.map(|((((letter, one, _), side), told), look)| {
        let still = still(&one.recording, time);
        perceived.extend(still.perceived.iter().map(|words| format!("{letter}: {words}")));
        ShownSide {
            letter,
            otherwise: side.otherwise.to_string(),
            key: side.case.key.clone(),
            fingerprint: format!("{:016x}", one.outcome.fingerprint),
            sentence: side_sentence(letter, told),
            swatch: look.swatch(true, false),
            view_box: still.view_box,
            still: still.content,
        }
    });
    (sides.collect(), perceived)
}

fn side_sentence(letter: &str, told: &RunTold) -> String {
    format!("{letter}: {}", told.sentence)
}

/// Both as the script reads them: each has a name of its own beside the key, which may be the same. The first also has what is told of both.
fn embedded(run: &RunDiff, told: &[RunTold; 2], why: &[Why], moment: Option<f64>, command: &str) -> String {
    let each = both(run).into_iter().zip(told).map(|((letter, one, _), told)| {
        let mut run = embed::run(&one.recording, "", command, told);
        run["side"] = letter.into();
        run["sentence"] = side_sentence(letter, told).into();
        run["moment"] = moment.into();
        run
    });
    let mut sides: Vec<serde_json::Value> = each.collect();
    let told = events(run);
    sides[0]["why"] = why.iter().map(|one| json!([one.class, one.text, one.time])).collect();
    sides[0]["events"] =
        told.iter().map(|(time, who, what)| json!([embed::rounded(*time), who, what])).collect();
    sides[1]["why"] = json!([]);
    sides[1]["events"] = json!([]);
    let texts: Vec<String> = sides.into_iter().map(embed::script_text).collect();
    format!("[{}]", texts.join(",\n"))
}
