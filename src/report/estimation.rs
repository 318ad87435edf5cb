//! What an estimate came to: two numbers for the terminal, and drawn.

use std::fmt::Write;

use super::columns::columns;
use super::wording::verdict_word;
use results::{ComparedEstimate, EstimateResult, EstimatedRun, EventsPerDistance};
use scenario::{EstimateMethod, significant};

const STRING: &str = "writing to a string cannot fail";

/// The bound and the estimate side by side, with what speaks against the estimate.
pub fn render_estimate(result: &EstimateResult) -> String {
    let mut text = format!(
        "estimate {}: probability of `{}` in a run of `{}`, by {} of {} runs\n",
        result.name,
        result.event,
        result.scenario,
        result.method.word(),
        result.runs
    );
    for sentence in sentences(result) {
        writeln!(text, "  {sentence}").expect(STRING);
    }
    if result.clusters.len() > 1 {
        writeln!(text, "  groups of hits, by their share of the estimate:").expect(STRING);
        let lines: Vec<_> = result.clusters.iter().map(|one| row(one.share, &one.run)).collect();
        text += &columns(&lines);
    }
    if !result.carrying.is_empty() {
        writeln!(text, "  the runs that carry the estimate, for `replay`:").expect(STRING);
        for run in result.carrying.iter().take(3) {
            writeln!(text, "    {} {}", percent(run.share), run.key).expect(STRING);
        }
    }
    for (alone, runs) in result.compared.iter().flat_map(|compared| alone(result, compared)) {
        writeln!(text, "  {alone}, for `replay`:").expect(STRING);
        for run in runs.iter().take(3) {
            writeln!(text, "    {} {}", percent(run.share), run.key).expect(STRING);
        }
    }
    for warning in &result.warnings {
        writeln!(text, "  warning: {warning}").expect(STRING);
    }
    for claim in &result.claims {
        writeln!(text, "  {}: {} ({})", claim.text, verdict_word(claim.verdict), claim.reason).expect(STRING);
    }
    text
}

/// What there is to know, the two numbers first.
pub(super) fn sentences(result: &EstimateResult) -> Vec<String> {
    let level = percent(result.confidence);
    let EstimateResult { nominal_runs, nominal_hits, .. } = result;
    let mut sentences = vec![format!(
        "guaranteed: at most {} at {level}, by {nominal_hits} of {nominal_runs} runs that are drawn as they are",
        number(result.guaranteed)
    )];
    let (low, high) = (number(result.interval.low), number(result.interval.high));
    let mut value = format!("{} [{low}, {high}] at {level}", number(result.value));
    if !result.refusals.is_empty() {
        value = format!("refused ({} would have been it)", number(result.value));
    }
    sentences.push(format!("estimate: {value}"));
    sentences.push(format!("  on the assumption: {}", result.assumption));
    sentences.extend(result.refusals.iter().map(|why| format!("  refused: {why}")));
    if result.method != EstimateMethod::Crude {
        sentences.push(format!(
            "unseen: a region that no run found may still have up to {} at {level}",
            number(result.unseen)
        ));
        sentences.push(format!(
            "{} hits worth {} of equal weight, the heaviest {} of all; {} replicates differ by {}",
            result.hits,
            significant(result.effective_size, 3),
            percent(result.largest_share),
            result.replicates.len(),
            percent(result.relative_deviation)
        ));
    }
    sentences.push(format!(
        "something was at stake in {} of {} runs that count",
        result.encounters,
        counted_runs(result)
    ));
    sentences.extend(result.per_1000_km.iter().flat_map(|along| per_distance(result, along)));
    sentences.extend(result.compared.iter().flat_map(|compared| comparison(result, compared)));
    sentences
}

/// The runs of the estimate's own scenario that do more than show where to look.
fn counted_runs(result: &EstimateResult) -> usize {
    let of_each = if result.compared.is_some() { 2 } else { 1 };
    ((result.runs - result.pilot_runs) / of_each).saturating_sub(result.left_out)
}

/// What it is compared with, how probable the event is there, and how the two differ.
fn comparison(result: &EstimateResult, compared: &ComparedEstimate) -> Vec<String> {
    let level = percent(result.confidence);
    let mut sentences = vec![format!(
        "compared with `{}` in the same encounters: {}",
        compared.scenario,
        if compared.differs.is_empty() { "nothing differs".to_string() } else { compared.differs.join(", ") }
    )];
    let value = number(compared.value);
    let there = if compared.refusals.is_empty() {
        let (low, high) = (number(compared.interval.low), number(compared.interval.high));
        format!("estimate {value} [{low}, {high}] at {level}")
    } else {
        format!("the estimate is refused ({value} would have been it)")
    };
    let (with, bound) = (&compared.scenario, number(compared.guaranteed));
    sentences.push(format!("  `{with}`: guaranteed at most {bound} at {level}; {there}"));
    sentences.extend(compared.refusals.iter().map(|why| format!("  `{with}` is refused: {why}")));
    let guaranteed = compared.guaranteed_difference;
    let guaranteed = format!("guaranteed from {} to {}", number(guaranteed.low), number(guaranteed.high));
    let difference = number(compared.difference);
    let estimated = if compared.difference_refusals.is_empty() {
        let (low, high) = (compared.difference_interval.low, compared.difference_interval.high);
        format!("estimate {difference} [{}, {}]", number(low), number(high))
    } else {
        format!("the estimate is refused ({difference} would have been it)")
    };
    sentences.push(format!("  difference: {guaranteed} at {level}; {estimated}"));
    sentences.extend(compared.difference_refusals.iter().map(|why| format!("  refused difference: {why}")));
    sentences.push(format!("  ratio: {}", ratio(compared)));
    let more = |one: &&String| !compared.difference_refusals.contains(one);
    sentences
        .extend(compared.ratio_refusals.iter().filter(more).map(|why| format!("  refused ratio: {why}")));
    sentences.push(format!(
        "  {} encounters with the event in `{}` alone and {} in `{with}` alone, worth {} of equal weight",
        compared.only_here,
        result.scenario,
        compared.only_there,
        significant(compared.effective_size, 3)
    ));
    sentences
}

/// The ratio with its interval, in words.
pub(super) fn ratio(compared: &ComparedEstimate) -> String {
    let Some(ratio) = compared.ratio else {
        return format!("none: the event never happened in `{}`", compared.scenario);
    };
    let ratio = significant(ratio, 3);
    if !compared.ratio_refusals.is_empty() {
        return format!("the estimate is refused ({ratio} would have been it)");
    }
    let high = compared.ratio_interval.high.map_or("without end".to_string(), |high| significant(high, 3));
    format!("estimate {ratio} [{}, {high}]", significant(compared.ratio_interval.low, 3))
}

/// Encounters in which one of two alone has the event, if there are any, with what is said of them.
pub(super) fn alone<'r>(
    result: &EstimateResult,
    compared: &'r ComparedEstimate,
) -> impl Iterator<Item = (String, &'r [EstimatedRun])> + use<'r> {
    let of = |name: &str| format!("runs with the event in `{name}` alone");
    let both = [(of(&result.scenario), &compared.here[..]), (of(&compared.scenario), &compared.there[..])];
    both.into_iter().filter(|(_, runs)| !runs.is_empty())
}

/// The same along a distance.
fn per_distance(result: &EstimateResult, along: &EventsPerDistance) -> Vec<String> {
    let EventsPerDistance { encounters, guaranteed, value, interval, unseen, .. } = along;
    let level = percent(along.confidence);
    let range = |low: f64, high: f64| match number(low) == number(high) {
        true => number(low),
        false => format!("{} to {}", number(low), number(high)),
    };
    let sure = match along.exposure_confidence {
        Some(sure) => format!(", at {}", percent(sure)),
        None => ", taken for granted".to_string(),
    };
    let estimate = if result.refusals.is_empty() {
        format!(
            "estimate {} [{}, {}] at {level}",
            range(value.low, value.high),
            number(interval.low),
            number(interval.high)
        )
    } else {
        "the estimate is refused".to_string()
    };
    let mut sentences = vec![
        format!(
            "exposure: {} encounters in 1,000 km{sure}, as given: {}",
            range(encounters.low, encounters.high),
            along.source
        ),
        format!(
            "per 1,000 km, events to be expected: guaranteed at most {} at {level}; {estimate}",
            number(*guaranteed)
        ),
    ];
    if result.method != EstimateMethod::Crude {
        sentences.push(format!("  unseen: up to {} at {level}", number(*unseen)));
    }
    sentences
}

/// A probability or a difference: with three digits, and with a power of ten where it is small.
pub(super) fn number(value: f64) -> String {
    if value != 0.0 && value.abs() < 1e-2 { format!("{value:.2e}") } else { significant(value, 3) }
}

pub(super) fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 3))
}

fn row(share: f64, run: &EstimatedRun) -> Vec<String> {
    vec![percent(share), values(run)]
}

/// Such as `tta 9.3s, pace 1.71m/s`.
pub(super) fn values(run: &EstimatedRun) -> String {
    let each: Vec<_> = run.drawn.iter().map(|(name, label)| format!("{name} {label}")).collect();
    each.join(", ")
}

/// The bound, what may be unseen and the estimate on one logarithmic scale, above the tail of the weights, as SVG.
pub fn draw_estimate(result: &EstimateResult) -> String {
    const WIDTH: f64 = 460.0;
    const LEFT: f64 = 110.0;
    const ROW: f64 = 34.0;
    let mut known =
        vec![result.value, result.interval.low, result.interval.high, result.guaranteed, result.unseen];
    let there = result.compared.as_ref().filter(|compared| compared.refusals.is_empty());
    known.extend(there.iter().flat_map(|one| [one.value, one.interval.low, one.interval.high]));
    let rows = if result.compared.is_some() { 4.0 } else { 3.0 };
    let positive = || known.iter().filter(|one| **one > 0.0).map(|one| libm::log10(*one));
    let low = positive().fold(0.0, f64::min).floor();
    let high = positive().fold(low, f64::max).ceil().max(low + 1.0);
    let x = |value: f64| {
        let place = if value > 0.0 { (libm::log10(value) - low) / (high - low) } else { 0.0 };
        LEFT + WIDTH * place.clamp(0.0, 1.0)
    };
    let (scale, tail_top) = ((rows + 0.4) * ROW, (rows + 1.6) * ROW);
    let tail = 110.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        LEFT + WIDTH + 40.0,
        tail_top + tail + 40.0
    );
    for decade in low as i32..=high as i32 {
        let at = LEFT + WIDTH * (f64::from(decade) - low) / (high - low);
        writeln!(
            svg,
            "<path d=\"M{at:.1} 6V{scale:.1}\" stroke=\"#ddd\"/><text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">1e{decade}</text>",
            scale + 16.0
        )
        .expect(STRING);
    }
    let mut bar = |row: f64, words: &str, from: f64, to: f64, at: Option<f64>, colour: &str| {
        let y = ROW * (row + 0.6);
        writeln!(svg, "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{words}</text>", LEFT - 8.0, y + 4.0)
            .expect(STRING);
        writeln!(
            svg,
            "<path d=\"M{from:.1} {y:.1}H{to:.1}\" stroke=\"{colour}\" stroke-width=\"8\" stroke-opacity=\"0.5\"/>"
        )
        .expect(STRING);
        if let Some(at) = at {
            writeln!(svg, "<circle cx=\"{at:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"{colour}\"/>").expect(STRING);
        }
    };
    bar(0.0, "guaranteed", LEFT, x(result.guaranteed), None, "#1b6ca8");
    bar(1.0, "may be unseen", LEFT, x(result.unseen), None, "#999999");
    if result.refusals.is_empty() {
        let (from, to) = (x(result.interval.low), x(result.interval.high));
        bar(2.0, "estimate", from, to, Some(x(result.value)), "#d95f02");
    } else {
        bar(2.0, "refused", LEFT, LEFT, None, "#d95f02");
    }
    if result.compared.is_some() {
        match there {
            Some(one) => {
                bar(3.0, "compared", x(one.interval.low), x(one.interval.high), Some(x(one.value)), "#7570b3")
            }
            None => bar(3.0, "compared: refused", LEFT, LEFT, None, "#7570b3"),
        }
    }
    let most = result.shares.first().copied().unwrap_or(0.0).max(0.05);
    let bottom = tail_top + tail;
    let width = WIDTH / result.shares.len().max(20) as f64;
    for (index, share) in result.shares.iter().enumerate() {
        let height = tail * share / most;
        writeln!(
            svg,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.2}\" fill=\"#d95f02\"/>",
            LEFT + width * index as f64,
            bottom - height,
            0.8 * width
        )
        .expect(STRING);
    }
    let limit = bottom - tail * 0.05 / most;
    writeln!(
        svg,
        "<path d=\"M{LEFT} {bottom:.1}h{WIDTH}\" stroke=\"#333\"/><path d=\"M{LEFT} {limit:.1}h{WIDTH}\" stroke=\"#333\" stroke-dasharray=\"4 3\"/>\
         <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">5 %: refused</text>\
         <text x=\"{LEFT}\" y=\"{:.1}\">weights of the heaviest hits, in the sum of all</text>\n</svg>",
        LEFT - 8.0,
        limit + 4.0,
        bottom + 18.0
    )
    .expect(STRING);
    svg
}
