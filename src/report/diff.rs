//! Two runs on the same noise, side by side: where they part, what both came to, and the same as JSON.

use std::collections::BTreeSet;
use std::fmt::Write;

use serde_json::{Value, json};

use super::format::{quantity, with_unit};
use super::replay::{RunReason, describe, run_reasons};
use super::why::{Standing, cut_off, ending_words};
use results::{
    AgainstBaseline, ContactMoment, Doing, MetricThen, OneOfTwo, Outcome, PartedIn, Parting, PartsBy,
    Requests, SharedMoment, TwoRuns,
};
use scenario::{Case, Criterion, Dimension, Metric, MetricKind, MetricReference, significant};
use sim::Command;

/// So many metrics that changed are told with their values.
const METRICS: usize = 10;
/// So many things that differ at one moment are told.
const DIFFERENCES: usize = 4;

/// Two runs that are told side by side.
pub struct RunDiff<'a> {
    /// The run that was asked for.
    pub key: &'a str,
    /// The one and the other.
    pub sides: [DiffSide<'a>; 2],
    /// What is measured in both.
    pub requests: &'a Requests,
    /// What came of them.
    pub two: &'a TwoRuns,
    /// What has to be known besides, a sentence each.
    pub remarks: &'a [String],
}

/// One of two runs.
pub struct DiffSide<'a> {
    /// What is otherwise in it: `controller av=carla_behavior`.
    pub otherwise: &'a str,
    /// The run.
    pub case: &'a Case,
    /// What it has of its own, as a scenario writes it.
    pub values: &'a [(String, String)],
    /// What is asked of it.
    pub criteria: &'a [Criterion],
}

impl RunDiff<'_> {
    fn outcomes(&self) -> [&Outcome; 2] {
        [&self.two.a.outcome, &self.two.b.outcome]
    }

    fn reasons(&self) -> [Vec<RunReason>; 2] {
        let [a, b] = self.outcomes();
        [(&self.sides[0], a), (&self.sides[1], b)]
            .map(|(side, outcome)| run_reasons(side.criteria, outcome, self.requests))
    }

    fn standings(&self) -> [Standing; 2] {
        let ([a, b], [in_a, in_b]) = (self.outcomes(), self.reasons());
        [Standing::of(&in_a, a), Standing::of(&in_b, b)]
    }
}

/// Two runs in words, in ten to thirty lines.
pub fn render_diff(run: &RunDiff) -> String {
    let mut text = String::new();
    let mut line = |content: &str| {
        text.push_str(content.trim_end());
        text.push('\n');
    };
    line(&format!("{}: {}", run.key, verdict(run.standings())));
    for (letter, side) in ["A", "B"].into_iter().zip(&run.sides) {
        let is_named = side.case.key != run.key;
        let named = if is_named { format!("  (as {})", side.case.key) } else { String::new() };
        line(&format!("  {letter}  {}{named}", side.otherwise));
    }
    line(&format!("  both with {}", shared(run)));
    if !run.two.differs.is_empty() {
        line(&format!("  what they are made of differs in {}", run.two.differs.join("; ")));
    }
    partings(run).iter().for_each(|said| line(&format!("  {said}")));
    table(run).iter().for_each(|row| line(&format!("  {row}")));
    line(&format!("  {}", contacts(run.two)));
    line(&format!("  {}", endings(run.outcomes())));
    criteria(run.reasons()).iter().for_each(|said| line(&format!("  {said}")));
    metrics(run).iter().for_each(|said| line(&format!("  {said}")));
    run.remarks.iter().for_each(|remark| line(&format!("  {remark}")));
    text
}

/// How a run stands, after its name.
fn alone(standing: Standing) -> &'static str {
    match standing {
        Standing::Failed => "fails",
        Standing::SpokenAgainst => "speaks against what its trial is to have",
        Standing::CutOff => "ends before somebody was met",
        Standing::Passed => "passes",
        Standing::NotJudged => "has nothing asked of it",
    }
}

/// Whether the verdict of the run changes.
fn verdict([a, b]: [Standing; 2]) -> String {
    match a == b {
        true => format!("the verdict is the same, each {}", alone(a)),
        false => format!("the verdict changes, A {}, B {}", alone(a), alone(b)),
    }
}

/// What both have alike: values, people and the seed.
fn shared(run: &RunDiff) -> String {
    let [a, b] = &run.sides;
    let both = a.values.iter().filter(|one| b.values.contains(one));
    let mut said: Vec<String> = both.map(|(name, value)| format!("{name} {value}")).collect();
    let people = a.case.individuals.iter().filter(|one| b.case.individuals.contains(one));
    said.extend(
        people.map(|one| format!("{} is individual {} of {}", one.pedestrian, one.number, one.population)),
    );
    said.push(format!("seed {}", a.case.seed));
    said.join(", ")
}

/// Where they part: in bits, then by what can be seen.
fn partings(run: &RunDiff) -> Vec<String> {
    let two = run.two;
    let end = with_unit(two.a.outcome.ending.time, Dimension::TIME);
    let is_cut = two.a.outcome.cut_off.is_some() && two.b.outcome.cut_off.is_some();
    let cut = if is_cut { ". Both are cut off: what would have come was not seen" } else { "" };
    let Some(first) = &two.first else {
        let why = match two.differs.is_empty() {
            true => ", since nothing that this run is made of depends on what is otherwise",
            false => "; what differs changes nothing in this run",
        };
        return vec![format!("they do not part: the same bit for bit until both end at {end}{why}{cut}")];
    };
    let parting = format!("they part at {:.3} s: {}", first.time, by(first));
    match &two.apart {
        Some(apart) if apart.time == first.time => {
            vec![format!("{parting}; at once by more than 0.1 m or 0.1 m/s")]
        }
        Some(apart) => {
            let seen = format!("by more than 0.1 m or 0.1 m/s at {:.3} s: {}", apart.time, by(apart));
            vec![parting, seen]
        }
        None => {
            vec![parting, format!("never by more than 0.1 m or 0.1 m/s until both end at {end}{cut}")]
        }
    }
}

/// What differs at the moment at which they part.
fn by(parting: &Parting) -> String {
    if parting.by.is_empty() {
        return "in bits, between the moments that both have".to_string();
    }
    let mut said: Vec<String> = parting.by.iter().take(DIFFERENCES).map(parted).collect();
    if parting.by.len() > DIFFERENCES {
        said.push(format!("{} more", parting.by.len() - DIFFERENCES));
    }
    said.join("; ")
}

fn parted(PartsBy { who, what }: &PartsBy) -> String {
    match what {
        PartedIn::Presence { in_a } => format!("{who} is there in {} only", if *in_a { "A" } else { "B" }),
        PartedIn::Motion { apart, relative_speed, a, b } => {
            let speed = |value: f64| with_unit(value, Dimension::SPEED);
            let apart = match (*apart > 0.0, *relative_speed > 0.0) {
                (true, _) => format!("is {} apart", with_unit(*apart, Dimension::LENGTH)),
                (false, true) => "is at one place".to_string(),
                (false, false) => "faces or accelerates otherwise at one place".to_string(),
            };
            match speed(*a) == speed(*b) {
                true => format!("{who} {apart}, with {} in both", speed(*a)),
                false => format!("{who} {apart}, with {} in A, {} in B", speed(*a), speed(*b)),
            }
        }
        PartedIn::Event { a: Some(a), b: Some(b) } => {
            format!("{who} {} in A, {} in B", describe(a), describe(b))
        }
        PartedIn::Event { a: Some(what), b: None } => format!("{who} {} in A only", describe(what)),
        PartedIn::Event { a: None, b: Some(what) } => format!("{who} {} in B only", describe(what)),
        PartedIn::Event { a: None, b: None } => String::new(),
        PartedIn::Decision { a, b } => {
            format!("{who} is told {} in A, {} in B", told(a.as_ref()), told(b.as_ref()))
        }
        PartedIn::Ending { a, b } if a.time == b.time => {
            format!("{} in A, {} in B", ending_words(a.reason), ending_words(b.reason))
        }
        PartedIn::Ending { a, b } => {
            let (letter, ending) = if a.time < b.time { ("A", a) } else { ("B", b) };
            format!("{letter} ends, {}, and the other goes on", ending_words(ending.reason))
        }
    }
}

/// A command: as many digits as tell near ones apart.
fn told(command: Option<&Command>) -> String {
    let number = |value: f64| significant(value, 6);
    match command {
        None => "nothing yet".to_string(),
        Some(Command::Acceleration(acceleration)) => format!("{} m/s^2", number(*acceleration)),
        Some(Command::Pedals { throttle, brake }) => {
            format!("throttle {} brake {}", number(*throttle), number(*brake))
        }
    }
}

/// Whom the table is about: those of the earliest contact, else whoever parts, with the first pedestrian.
fn about(run: &RunDiff) -> Vec<String> {
    let world = &run.sides[0].case.world;
    let contacts = run.two.a.contacts.iter().chain(&run.two.b.contacts);
    let earliest = contacts.min_by(|one, other| {
        one.time
            .total_cmp(&other.time)
            .then_with(|| (&one.vehicle, &one.with).cmp(&(&other.vehicle, &other.with)))
    });
    let is_there =
        |name: &String| run.two.moments.iter().any(|one| one.each.iter().any(|one| one.who == *name));
    if let Some(contact) = earliest {
        return [contact.vehicle.clone(), contact.with.clone()].into_iter().filter(is_there).collect();
    }
    let parts = run.two.apart.iter().chain(&run.two.first).flat_map(|parting| &parting.by);
    let parts: Vec<&String> = parts.map(|one| &one.who).collect();
    let cars = || world.vehicles.iter().map(|car| &car.name);
    let people = || world.pedestrians.iter().map(|person| &person.name);
    let car = cars().find(|name| parts.contains(name)).or_else(|| cars().next());
    let person = people().find(|name| parts.contains(name)).or_else(|| people().next());
    car.into_iter().chain(person).cloned().collect()
}

/// What they do over time, in columns.
fn table(run: &RunDiff) -> Vec<String> {
    let who = about(run);
    let mut rows = vec![vec!["time".to_string()]];
    for name in &who {
        rows[0].extend([format!("{name} A"), format!("{name} B")]);
    }
    if who.len() == 2 {
        rows[0].extend(["apart A".to_string(), "apart B".to_string()]);
    }
    for moment in &run.two.moments {
        let SharedMoment { time, each } = moment;
        let of = |name: &String| each.iter().find(|one| one.who == *name);
        let mut row = vec![format!("{time:.2} s")];
        for name in &who {
            row.extend(
                [of(name).and_then(|one| one.a.as_ref()), of(name).and_then(|one| one.b.as_ref())].map(cell),
            );
        }
        if let [one, other] = &who[..] {
            let both = [of(one), of(other)];
            let apart = |side: fn(&results::InBoth) -> Option<&Doing>| {
                let [one, other] = both.map(|one| one.and_then(side));
                match (one, other) {
                    (Some(one), Some(other)) => {
                        let (dx, dy) = (one.x - other.x, one.y - other.y);
                        format!("{:.1} m", (dx * dx + dy * dy).sqrt())
                    }
                    _ => "–".to_string(),
                }
            };
            row.extend([apart(|one| one.a.as_ref()), apart(|one| one.b.as_ref())]);
        }
        rows.push(row);
    }
    let columns = rows[0].len();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let padded = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        cells.collect::<Vec<_>>().join("  ")
    };
    rows.iter().map(padded).collect()
}

/// `8.33 m/s follow`; `–` where somebody is not there or the run is over.
fn cell(doing: Option<&Doing>) -> String {
    let Some(Doing { speed, activity, .. }) = doing else { return "–".to_string() };
    format!("{speed:.2} m/s {activity}").trim_end().to_string()
}

/// Every contact of a vehicle, of the one and of the other.
fn contacts(two: &TwoRuns) -> String {
    let of = |one: &OneOfTwo| {
        let each = one.contacts.iter().map(|contact| {
            let ContactMoment { time, vehicle, with, relative_speed, .. } = contact;
            format!("{vehicle} with {with} at {time:.2} s, {}", with_unit(*relative_speed, Dimension::SPEED))
        });
        let each: Vec<String> = each.collect();
        if each.is_empty() { "none".to_string() } else { each.join(", ") }
    };
    match (two.a.contacts.is_empty(), two.b.contacts.is_empty()) {
        (true, true) => "no contact of a vehicle in either".to_string(),
        _ => format!("contacts: in A {}; in B {}", of(&two.a), of(&two.b)),
    }
}

fn endings([a, b]: [&Outcome; 2]) -> String {
    let of = |outcome: &Outcome| {
        let words = ending_words(outcome.ending.reason);
        format!("at {:.2} s, {words}{}", outcome.ending.time, cut_off(outcome))
    };
    match of(a) == of(b) {
        true => format!("both end {}", of(a)),
        false => format!("A ends {}; B ends {}", of(a), of(b)),
    }
}

/// How both stand to each criterion.
fn criteria([a, b]: [Vec<RunReason>; 2]) -> Vec<String> {
    let find = |all: &[RunReason], text: &str| all.iter().position(|one| one.criterion == text);
    let words = |one: &RunReason| format!("{}, {}", one.verb, one.words);
    let mut said: Vec<(bool, String)> = a
        .iter()
        .map(|one| match find(&b, &one.criterion).map(|place| &b[place]) {
            None => (true, format!("`{}`: A {}; not asked of B", one.criterion, words(one))),
            Some(other) if words(one) == words(other) => {
                (false, format!("`{}`: each {}", one.criterion, words(one)))
            }
            Some(other) => (true, format!("`{}`: A {}; B {}", one.criterion, words(one), words(other))),
        })
        .collect();
    let only_b = b.iter().filter(|one| find(&a, &one.criterion).is_none());
    said.extend(only_b.map(|one| (true, format!("`{}`: not asked of A; B {}", one.criterion, words(one)))));
    // What changed first; a claim for each member of a group may be told in the same words.
    said.sort_by_key(|(changed, _)| !changed);
    let mut told = BTreeSet::new();
    said.retain(|(_, said)| told.insert(said.clone()));
    said.into_iter().map(|(_, said)| said).collect()
}

/// A metric with its value in both, and how it changed.
struct MetricPair<'a> {
    reference: &'a MetricReference,
    metric: &'a Metric,
    values: [Option<f64>; 2],
    /// Whether each is decided, or was cut off.
    decided: [bool; 2],
}

impl MetricPair<'_> {
    fn shown(&self) -> [String; 2] {
        [0, 1].map(|side| {
            let so_far = if self.decided[side] { "" } else { " so far" };
            format!("{}{so_far}", quantity(self.metric, self.values[side]))
        })
    }

    fn is_same(&self) -> bool {
        self.values.map(|value| value.map(f64::to_bits)).windows(2).all(|both| both[0] == both[1])
    }

    fn change(&self) -> Option<f64> {
        let [Some(a), Some(b)] = self.values else { return None };
        let is_number = matches!(self.metric.kind, MetricKind::Quantity(_));
        (is_number && a.is_finite() && b.is_finite()).then_some(b - a)
    }
}

fn metric_pairs<'a>(run: &'a RunDiff) -> Vec<MetricPair<'a>> {
    let outcomes = run.outcomes();
    let pair = |(index, reference): (usize, &'a MetricReference)| {
        let values = outcomes.map(|outcome| outcome.metrics[index]);
        let decided = outcomes.map(|outcome| outcome.open(index).is_none());
        Some(MetricPair { reference, metric: reference.known()?, values, decided })
    };
    run.requests.iter().enumerate().filter_map(pair).collect()
}

/// Every metric that changed, those of criteria first, and how many did not.
fn metrics(run: &RunDiff) -> Vec<String> {
    let criteria: Vec<&Criterion> = run.sides.iter().flat_map(|side| side.criteria).collect();
    metric_lines(&metric_pairs(run), &criteria)
}

fn metric_lines(pairs: &[MetricPair], criteria: &[&Criterion]) -> Vec<String> {
    let asked = |pair: &MetricPair| criteria.iter().any(|one| one.claim.metric().is_same(pair.reference));
    let mut changed: Vec<&MetricPair> =
        pairs.iter().filter(|pair| pair.shown()[0] != pair.shown()[1]).collect();
    changed.sort_by_key(|pair| !asked(pair));
    let in_bits = pairs.iter().filter(|pair| !pair.is_same()).count().saturating_sub(changed.len());
    let width = changed.iter().take(METRICS).map(|pair| pair.reference.label().chars().count()).max();
    let width = width.unwrap_or(0);
    let told = |pair: &&MetricPair| {
        let [a, b] = pair.shown();
        let mut said = format!("{:<width$}  {a} -> {b}", pair.reference.label());
        if let (Some(change), MetricKind::Quantity(dimension)) = (pair.change(), &pair.metric.kind) {
            let sign = if change > 0.0 { "+" } else { "" };
            write!(said, " ({sign}{})", with_unit(change, *dimension))
                .expect("writing to a string cannot fail");
        }
        said
    };
    let mut said: Vec<String> = changed.iter().take(METRICS).map(told).collect();
    if changed.len() > METRICS {
        let more: Vec<String> = changed[METRICS..].iter().map(|pair| pair.reference.label()).collect();
        said.push(format!("changed as well: {}; `--json` has them", more.join(", ")));
    }
    let (all, rest) = (pairs.len(), pairs.len() - changed.len());
    let but = if in_bits > 0 { format!(", {in_bits} of them but for bits") } else { String::new() };
    said.push(match changed.len() {
        0 => format!("all {all} metrics are the same in both{but}"),
        _ => format!("the other {rest} of {all} metrics are the same in both{but}"),
    });
    said
}

fn reason_json(one: &RunReason) -> Value {
    json!({ "criterion": one.criterion, "standing": one.verb.to_lowercase(), "words": one.words, "time": one.time })
}

/// The same as JSON: SI units, everything.
pub fn diff_json(run: &RunDiff) -> Value {
    let ([a, b], standings) = (run.reasons(), run.standings());
    let side = |index: usize, one: &OneOfTwo, reasons: &[RunReason]| {
        let DiffSide { otherwise, case, values, .. } = &run.sides[index];
        let values: serde_json::Map<String, Value> =
            values.iter().map(|(name, value)| (name.clone(), value.clone().into())).collect();
        let criteria: Vec<Value> = reasons.iter().map(reason_json).collect();
        json!({
            "otherwise": otherwise,
            "key": case.key,
            "values": values,
            "individuals": case.individuals,
            "fingerprint": format!("{:016x}", one.outcome.fingerprint),
            "standing": standings[index].word(),
            "ending": one.outcome.ending,
            "cut_off": one.outcome.cut_off,
            "contacts": one.contacts,
            "criteria": criteria,
        })
    };
    let metrics: Vec<Value> = metric_pairs(run)
        .iter()
        .map(|pair| {
            json!({
                "metric": pair.reference.label(),
                "a": pair.values[0],
                "b": pair.values[1],
                "decided": { "a": pair.decided[0], "b": pair.decided[1] },
                "same": pair.is_same(),
            })
        })
        .collect();
    json!({
        "layout": 1,
        "key": run.key,
        "seed": run.sides[0].case.seed,
        "same": run.two.are_one(),
        "verdict_changes": standings[0] != standings[1],
        "differs": run.two.differs,
        "parts": run.two.first,
        "parts_visibly": run.two.apart,
        "a": side(0, &run.two.a, &a),
        "b": side(1, &run.two.b, &b),
        "moments": run.two.moments,
        "metrics": metrics,
        "remarks": run.remarks,
    })
}

/// A run beside what a baseline keeps of it.
pub struct BaselineDiff<'a> {
    /// The baseline's file.
    pub baseline: &'a str,
    /// The run as it is now.
    pub now: DiffSide<'a>,
    /// What it came to now.
    pub outcome: &'a Outcome,
    /// What is measured in it now.
    pub requests: &'a Requests,
    /// What is not the same.
    pub against: &'a AgainstBaseline,
    /// What has to be known besides, a sentence each.
    pub remarks: &'a [String],
}

impl BaselineDiff<'_> {
    fn pairs(&self) -> Vec<MetricPair<'_>> {
        let pair = |one: &MetricThen| {
            let reference = &self.requests.as_slice()[one.index];
            // Whether what was then was decided is not kept, so that it is said of neither.
            let (values, decided) = ([one.then, one.now], [true; 2]);
            Some(MetricPair { reference, metric: reference.known()?, values, decided })
        };
        self.against.metrics.iter().filter_map(pair).collect()
    }
}

/// A run beside what a baseline keeps of it, in words.
pub fn render_baseline_diff(run: &BaselineDiff) -> String {
    let mut text = String::new();
    let mut line = |content: &str| {
        text.push_str(content.trim_end());
        text.push('\n');
    };
    let BaselineDiff { against, now, outcome, .. } = run;
    let reasons = run_reasons(now.criteria, outcome, run.requests);
    line(&format!("{}: now {}", now.case.key, alone(Standing::of(&reasons, outcome))));
    line(&format!(
        "  A  as {} keeps it: its metrics with nine digits, no course and no verdict",
        run.baseline
    ));
    line(&format!(
        "  B  now{}",
        if now.otherwise.is_empty() { String::new() } else { format!(", {}", now.otherwise) }
    ));
    let mut values: Vec<String> = now.values.iter().map(|(name, value)| format!("{name} {value}")).collect();
    values.push(format!("seed {}", now.case.seed));
    line(&format!("  with {}", values.join(", ")));
    match against.differs.is_empty() {
        true => line("  made of the same as then"),
        false => line(&format!("  what it is made of differs in {}", against.differs.join("; "))),
    }
    line(match against.same_course {
        Some(true) => "  the course is the same, bit for bit",
        Some(false) => "  the course is another; where they part is not kept",
        None => {
            "  whether the course is the same cannot be told: the baseline keeps one number for the courses of all runs of the trial"
        }
    });
    for reason in &reasons {
        line(&format!("  `{}`: now {}, {}", reason.criterion, reason.verb, reason.words));
    }
    let criteria: Vec<&Criterion> = now.criteria.iter().collect();
    metric_lines(&run.pairs(), &criteria).iter().for_each(|said| line(&format!("  {said}")));
    if !against.new.is_empty() {
        line(&format!("  not in the baseline, or measured otherwise: {}", against.new.join(", ")));
    }
    run.remarks.iter().for_each(|remark| line(&format!("  {remark}")));
    text
}

/// The same as JSON.
pub fn baseline_diff_json(run: &BaselineDiff) -> Value {
    let BaselineDiff { against, now, outcome, .. } = run;
    let reasons = run_reasons(now.criteria, outcome, run.requests);
    let metrics: Vec<Value> = run
        .pairs()
        .iter()
        .map(|pair| json!({ "metric": pair.reference.label(), "a": pair.values[0], "b": pair.values[1], "same": pair.is_same() }))
        .collect();
    json!({
        "layout": 1,
        "key": now.case.key,
        "seed": now.case.seed,
        "baseline": run.baseline,
        "same_course": against.same_course,
        "differs": against.differs,
        "standing": Standing::of(&reasons, outcome).word(),
        "criteria": reasons.iter().map(reason_json).collect::<Vec<_>>(),
        "metrics": metrics,
        "not_in_baseline": against.new,
        "remarks": run.remarks,
    })
}
