//! How usual the encounters of a search are: in words, and the front of how bad they are against that for the terminal.

use std::fmt::Write;

use super::columns::columns;
use super::shown_value::value;
use results::{Found, FrontPoint, SearchResult, UsualEncounters};
use scenario::significant;

const STRING: &str = "writing to a string cannot fail";
/// So many of the front stand in the terminal.
const MOST_LINES: usize = 12;
/// The commands of so many.
const MOST_COMMANDS: usize = 3;

/// Such as `1 in 400`: one in so many is at least as unusual.
pub fn one_in(share: f64) -> String {
    if share <= 0.0 { "never".to_string() } else { format!("1 in {}", significant(1.0 / share, 3)) }
}

/// How usual somebody is: such as `12 %`, and of the rarest `0.3 %`.
pub fn tail_text(share: f64) -> String {
    match 100.0 * share {
        0.0 => "0 %".to_string(),
        rare if rare < 0.1 => "< 0.1 %".to_string(),
        rare if rare < 10.0 => format!("{rare:.1} %"),
        usual => format!("{usual:.0} %"),
    }
}

/// What a plausibility is of, and what it says nothing of.
pub fn basis(usual: &UsualEncounters) -> Vec<String> {
    let mut sentences = vec![format!(
        "Plausibility: the share of encounters, as they are declared to be drawn, that are no more usual in {} together.",
        listed(&usual.of)
    )];
    if !usual.undeclared.is_empty() {
        sentences.push(format!(
            "It says nothing of {}, which the search chooses and nothing says the distribution of.",
            listed(&usual.undeclared)
        ));
    }
    let UsualEncounters { possible, impossible, unknown, wanted, front, .. } = usual;
    match wanted {
        None => {}
        Some(0) => sentences.push(
            "No evaluated encounter is as plausible as is asked: nothing was found among such.".to_string(),
        ),
        Some(wanted) => sentences.push(format!(
            "{wanted} evaluated encounters are as plausible as is asked; the worst was looked for among them."
        )),
    }
    if *impossible > 0 {
        sentences.push(format!(
            "{impossible} evaluated encounters have plausibility 0: they lie outside of what is drawn, and are not on the front."
        ));
    }
    if *unknown > 0 {
        sentences.push(format!(
            "Of {unknown} evaluated encounters nobody knows how usual they are; they are neither kept for it nor on the front."
        ));
    }
    if front.is_empty() {
        sentences.push(format!(
            "There is no front: {possible} evaluated encounters are possible and have a value."
        ));
    }
    sentences
}

/// `gap`, `gap and pace`, `gap, pace and walker`, as code.
fn listed(names: &[String]) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        None => String::new(),
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
    }
}

/// The plausibility of the parts of an encounter, where there are several.
pub fn parts(point: &FrontPoint) -> String {
    if point.parts.len() < 2 {
        return String::new();
    }
    let each: Vec<String> =
        point.parts.iter().map(|(name, share)| format!("{name} {}", tail_text(*share))).collect();
    each.join(", ")
}

/// Whose encounter it is: `17` or `all`.
pub fn who(found: &Found) -> String {
    let numbers: Vec<_> = found.individuals.iter().map(|person| person.number.to_string()).collect();
    match numbers.as_slice() {
        [] => "all".to_string(),
        [one] => one.clone(),
        several => format!("{} people", several.len()),
    }
}

/// The front and how to see its runs again; nothing where nothing says how encounters are drawn.
pub fn render_usual(result: &SearchResult) -> String {
    let Some(usual) = &result.usual else { return String::new() };
    let mut text = String::new();
    for sentence in basis(usual) {
        writeln!(text, "{sentence}").expect(STRING);
    }
    if usual.front.is_empty() {
        return text;
    }
    writeln!(text, "The front: of encounters that are at least as usual as one of these, none that was evaluated is worse.")
        .expect(STRING);
    let unit = &result.objective_in;
    let shown = |value: Option<f64>| value.map_or("–".to_string(), |value| unit.show(value));
    let mut lines = vec![
        ["", "observed", "fresh seeds", "at least as unusual", "plausibility", "where", "of it"]
            .map(String::from)
            .to_vec(),
    ];
    for one in usual.front.iter().take(MOST_LINES) {
        let found = &result.found[one.found];
        let point = found.evaluations[one.evaluation].0.iter().enumerate();
        let names = found.best.iter().flatten().map(|(name, _)| name.as_str()).chain(std::iter::repeat(""));
        let at = point.zip(names);
        let at: Vec<_> = at
            .map(|((index, at), name)| format!("{name} {}", value(result.shown_in.get(index), at)))
            .collect();
        lines.push(vec![
            who(found),
            shown(Some(one.value)),
            format!("{} ({})", shown(one.fresh), one.fresh_runs),
            one_in(one.plausibility),
            tail_text(one.plausibility),
            at.join(", "),
            parts(one),
        ]);
    }
    text += &columns(&lines);
    if usual.front.len() > MOST_LINES {
        writeln!(text, "{} more are in the HTML and JSON reports", usual.front.len() - MOST_LINES)
            .expect(STRING);
    }
    writeln!(text, "their runs, for `replay`:").expect(STRING);
    for one in usual.front.iter().take(MOST_COMMANDS) {
        writeln!(text, "  {}", one.key).expect(STRING);
    }
    text
}
