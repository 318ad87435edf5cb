//! What a calibration came to: for the terminal as a table, and drawn.

use std::fmt::Write;

use super::columns::columns;
use super::format::in_unit;
use super::svg::wrapped;
use files::escape::html;
use results::{
    CalibrateResult, CalibratedCondition, CalibratedParameter, CalibratedShare, ComparedPopulation,
};

const STRING: &str = "writing to a string cannot fail";

/// Shares and spreads of every condition, people beside candidates.
pub fn render_calibrate(result: &CalibrateResult) -> String {
    let mut text = format!("calibrate {}: {} to {}\n", result.name, result.matched, result.observations);
    writeln!(text, "  candidates: {}", result.candidates).expect(STRING);
    writeln!(
        text,
        "  effective size {:.0} of {}, digest {}, {} runs of each candidate and condition",
        result.effective_size,
        result.weights.len(),
        result.digest,
        result.runs
    )
    .expect(STRING);
    for (what, rows) in [("share", rows(result, true)), ("spread between individuals", rows(result, false))] {
        if !rows.is_empty() {
            let mut lines = vec![headings(result, what)];
            lines.extend(rows);
            text += &columns(&lines);
        }
    }
    text.push_str("  in %; fresh: runs whose noise no weight has seen; left out: by weights that do not know the condition; apart: fresh less people\n");
    if let Some(sentence) = counted_sentence(result) {
        writeln!(text, "  {sentence}").expect(STRING);
    }
    if !result.matched_parameters.is_empty() {
        let mut lines = vec![parameter_headings(result)];
        lines.extend(parameter_rows(result));
        text += &columns(&lines);
    }
    let parts = |text: &mut String, what: &str, error: Option<f64>| {
        if let Some(error) = error {
            writeln!(text, "  root mean square error {what}: {:.1} points", 100.0 * error).expect(STRING);
        }
    };
    parts(&mut text, "under fresh noise", Some(result.fresh_rms));
    parts(&mut text, "of conditions left out", result.left_out_rms);
    parts(&mut text, &format!("in {} folds", result.folds), result.folds_rms);
    for one in &result.compared {
        let ComparedPopulation { name, digest, individuals, runs, .. } = one;
        writeln!(text, "  {name}: {individuals} individuals, {runs} runs each, digest {digest}")
            .expect(STRING);
    }
    for warning in &result.warnings {
        writeln!(text, "  warning: {warning}").expect(STRING);
    }
    text
}

/// The headings of [`rows`].
pub(super) fn headings(result: &CalibrateResult, what: &str) -> Vec<String> {
    let own = [what, "people", "equal", "fitted", "fresh", "left out", "apart"].map(String::from);
    let counted = only_some_count(result).then(|| "counted (runs)".to_string());
    own.into_iter().chain(counted).chain(result.compared.iter().map(|one| one.name.clone())).collect()
}

/// Whether there are conditions in which not all runs count.
pub(super) fn only_some_count(result: &CalibrateResult) -> bool {
    result.conditions.iter().any(|one| one.counted.is_some())
}

/// A row for each condition, in %: the shares, or the spreads between individuals, as far as those of people are known.
pub(super) fn rows(result: &CalibrateResult, shares: bool) -> Vec<Vec<String>> {
    let row = |(index, one): (usize, &CalibratedCondition)| {
        let share = if shares { Some(one.share) } else { one.spread };
        let CalibratedShare { observed, error, equal, fitted, fresh, left_out, .. } = share?;
        let perhaps = |share: Option<f64>| share.map_or_else(|| "–".to_string(), points);
        let mut cells = vec![
            one.in_words(),
            format!("{} ± {}", points(observed), points(error)),
            points(equal),
            points(fitted),
            points(fresh),
            left_out.map_or_else(String::new, points),
            format!("{:+.1}", 100.0 * (fresh - observed)),
        ];
        if only_some_count(result) {
            let counted =
                one.counted.map(|counted| format!("{} ({:.0})", points(counted.share), counted.runs));
            cells.push(counted.unwrap_or_default());
        }
        cells.extend(result.compared.iter().map(|other| {
            let (share, spread) = other.shares[index];
            perhaps(if shares { share } else { spread })
        }));
        Some(cells)
    };
    result.conditions.iter().enumerate().filter_map(row).collect()
}

/// What the column of the runs that count is.
pub(super) fn counted_sentence(result: &CalibrateResult) -> Option<String> {
    only_some_count(result).then(|| {
        format!(
            "Not all runs count for {}: the share of those that do, by weight, and on how many of equal weight the fresh share rests.",
            result.matched
        )
    })
}

/// The headings of [`parameter_rows`].
pub(super) fn parameter_headings(result: &CalibrateResult) -> Vec<String> {
    let own = ["parameter", "wanted", "equal", "fitted"].map(String::from);
    own.into_iter().chain(result.compared.iter().map(|one| one.name.clone())).collect()
}

/// A row for each statistic of a parameter that was matched.
pub(super) fn parameter_rows(result: &CalibrateResult) -> Vec<Vec<String>> {
    let row = |(index, one): (usize, &CalibratedParameter)| {
        let CalibratedParameter { parameter, statistic, unit, wanted, within, equal, fitted } = one;
        let number = |value: f64| in_unit(value, unit);
        let mut cells = vec![
            format!("{statistic} of {parameter}"),
            format!("{} ± {}", number(*wanted), number(*within)),
            number(*equal),
            number(*fitted),
        ];
        cells.extend(result.compared.iter().map(|other| {
            let known = other.parameters.get(index).copied().flatten();
            known.map_or_else(|| "–".to_string(), number)
        }));
        cells
    };
    result.matched_parameters.iter().enumerate().map(row).collect()
}

fn points(share: f64) -> String {
    format!("{:.1}", 100.0 * share)
}

/// Shares against the conditions of every scenario, as SVG: people with their errors, the population, equal weights, and the populations
/// that it is compared with.
pub fn draw_calibration(result: &CalibrateResult) -> String {
    const WIDTH: f64 = 340.0;
    const HEIGHT: f64 = 300.0;
    const LEFT: f64 = 48.0;
    const TOP: f64 = 34.0;
    const LINE: f64 = 18.0;
    const ROW: f64 = TOP + HEIGHT + 2.0 * LINE;
    let drawn = drawn(result);
    let subject = |one: &CalibratedCondition| (one.scenario.clone(), one.rate.clone());
    let mut subjects = Vec::new();
    for one in &result.conditions {
        if !subjects.contains(&subject(one)) {
            subjects.push(subject(one));
        }
    }
    let width = LEFT + (WIDTH + 30.0) * subjects.len().min(PANELS) as f64;
    let legend = ROW * subjects.len().div_ceil(PANELS) as f64;
    let height = legend + LINE * (drawn.len() + 2) as f64;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for (panel, shown) in subjects.iter().enumerate() {
        let left = LEFT + (WIDTH + 30.0) * (panel % PANELS) as f64;
        let top = ROW * (panel / PANELS) as f64;
        let y = |share: f64| top + TOP + HEIGHT * (1.0 - share);
        let of: Vec<usize> = (0..result.conditions.len())
            .filter(|index| subject(&result.conditions[*index]) == *shown)
            .collect();
        let x = |place: usize| left + WIDTH * (place as f64 + 0.5) / of.len() as f64;
        svg += &heading(&shown.0, shown.1.as_deref(), left, top);
        for tenth in (0..=10).step_by(2) {
            let at = y(f64::from(tenth) / 10.0);
            writeln!(svg, "<path d=\"M{left} {at}h{WIDTH}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{}\" text-anchor=\"end\">{} %</text>", left - 4.0, at + 4.0, tenth * 10).expect(STRING);
        }
        for line in &drawn {
            let known =
                of.iter().enumerate().filter_map(|(place, index)| Some((place, line.shares[*index]?)));
            let points = known.map(|(place, share)| format!("{:.1},{:.1}", x(place), y(share)));
            let points = points.collect::<Vec<_>>().join(" ");
            writeln!(svg, "<polyline points=\"{points}\" fill=\"none\" {}/>", line.stroke()).expect(STRING);
        }
        for (place, index) in of.iter().enumerate() {
            let one = &result.conditions[*index];
            let CalibratedShare { observed, error, .. } = one.share;
            let (at, high, low) = (x(place), y((observed + error).min(1.0)), y((observed - error).max(0.0)));
            writeln!(svg, "<path d=\"M{at:.1} {high:.1}V{low:.1}\" stroke=\"black\"/><circle cx=\"{at:.1}\" cy=\"{:.1}\" r=\"4\"/>", y(observed)).expect(STRING);
            writeln!(
                svg,
                "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                top + TOP + HEIGHT + LINE,
                html(&one.values)
            )
            .expect(STRING);
        }
    }
    let entry = |svg: &mut String, line: usize, mark: &str, words: &str| {
        let (at, text) = (legend + LINE * line as f64, LEFT + 36.0);
        writeln!(
            svg,
            "<g transform=\"translate(0 {at})\">{mark}<text x=\"{text}\" y=\"4\">{}</text></g>",
            html(words)
        )
        .expect(STRING);
    };
    let dot = format!("<circle cx=\"{}\" cy=\"0\" r=\"4\"/>", LEFT + 14.0);
    entry(&mut svg, 0, &dot, &format!("people ± one standard error: {}", result.observations));
    for (line, one) in drawn.iter().enumerate() {
        let mark = format!("<path d=\"M{} 0h28\" {}/>", LEFT, one.stroke());
        entry(&mut svg, line + 1, &mark, &one.words);
    }
    svg + "</svg>\n"
}

/// Panels side by side.
const PANELS: usize = 3;
/// Width of a panel in small letters.
const SMALL_LETTERS: usize = 62;

/// The heading of a panel: its scenario, and below it in small letters its rate, where panels show several.
fn heading(scenario: &str, rate: Option<&str>, left: f64, top: f64) -> String {
    let Some(rate) = rate else {
        let y = top + 20.0;
        return format!("<text x=\"{left}\" y=\"{y}\" font-weight=\"bold\">{}</text>\n", html(scenario));
    };
    let mut svg =
        format!("<text x=\"{left}\" y=\"{}\" font-weight=\"bold\">{}</text>\n", top + 9.0, html(scenario));
    for (number, line) in wrapped(rate, SMALL_LETTERS, "").iter().enumerate() {
        let y = top + 19.0 + 9.0 * number as f64;
        svg += &format!("<text x=\"{left}\" y=\"{y}\" font-size=\"9\">{}</text>\n", html(line.trim_end()));
    }
    svg
}

/// Shares of the conditions, in their order, and how they are drawn.
struct Drawn {
    words: String,
    colour: &'static str,
    dashes: &'static str,
    /// `None` where nobody was left to do it.
    shares: Vec<Option<f64>>,
}

impl Drawn {
    fn stroke(&self) -> String {
        let Self { colour, dashes, .. } = self;
        format!("stroke=\"{colour}\" stroke-width=\"2\" stroke-dasharray=\"{dashes}\"")
    }
}

/// Colours that can be told apart by everybody, and dashes by whom no colour can.
const LOOKS: [(&str, &str); 3] = [("#d95f02", "7 3"), ("#7b3294", "2 3"), ("#008837", "9 3 2 3")];

fn drawn(result: &CalibrateResult) -> Vec<Drawn> {
    let own = |of: &dyn Fn(&CalibratedShare) -> f64| {
        result.conditions.iter().map(|one| Some(of(&one.share))).collect::<Vec<_>>()
    };
    let mut drawn = vec![Drawn {
        words: format!("{}, fresh noise", result.name),
        colour: "#1b6ca8",
        dashes: "none",
        shares: own(&|share| share.fresh),
    }];
    for (one, (colour, dashes)) in result.compared.iter().zip(LOOKS.iter().cycle()) {
        let shares = one.shares.iter().map(|(share, _)| *share).collect();
        drawn.push(Drawn { words: one.name.clone(), colour, dashes, shares });
    }
    let words = "candidates, equally weighed".to_string();
    drawn.push(Drawn { words, colour: "#999999", dashes: "1 4", shares: own(&|share| share.equal) });
    drawn
}
