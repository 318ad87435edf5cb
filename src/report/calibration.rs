//! What a calibration came to: for the terminal as a table, and drawn.

use std::fmt::Write;

use super::columns::columns;
use files::escape::html;
use results::{CalibrateResult, CalibratedShare};

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
    let headings = ["", "people", "equal", "fitted", "fresh", "left out", "apart"];
    for (what, of) in [("share", true), ("spread between individuals", false)] {
        let mut lines = vec![headings.map(String::from).to_vec()];
        lines[0][0] = what.to_string();
        for one in &result.conditions {
            let CalibratedShare { observed, error, equal, fitted, fresh, left_out, .. } =
                if of { one.share } else { one.spread };
            lines.push(vec![
                format!("{} {}", one.scenario, one.values).trim_end().to_string(),
                format!("{} ± {}", points(observed), points(error)),
                points(equal),
                points(fitted),
                points(fresh),
                left_out.map_or_else(String::new, points),
                format!("{:+.1}", 100.0 * (fresh - observed)),
            ]);
        }
        text += &columns(&lines);
    }
    text.push_str("  in %; fresh: runs whose noise no weight has seen; left out: by weights that do not know the condition; apart: fresh less people\n");
    let parts = |text: &mut String, what: &str, error: Option<f64>| {
        if let Some(error) = error {
            writeln!(text, "  root mean square error {what}: {:.1} points", 100.0 * error).expect(STRING);
        }
    };
    parts(&mut text, "under fresh noise", Some(result.fresh_rms));
    parts(&mut text, "of conditions left out", result.left_out_rms);
    parts(&mut text, &format!("in {} folds", result.folds), result.folds_rms);
    for warning in &result.warnings {
        writeln!(text, "  warning: {warning}").expect(STRING);
    }
    text
}

fn points(share: f64) -> String {
    format!("{:.1}", 100.0 * share)
}

/// Shares against the conditions of every scenario, as SVG: people with their errors, equal weights and the population.
pub fn draw_calibration(result: &CalibrateResult) -> String {
    const WIDTH: f64 = 340.0;
    const HEIGHT: f64 = 300.0;
    const LEFT: f64 = 48.0;
    const TOP: f64 = 44.0;
    let mut scenarios: Vec<&str> = Vec::new();
    for one in &result.conditions {
        if !scenarios.contains(&one.scenario.as_str()) {
            scenarios.push(&one.scenario);
        }
    }
    let width = LEFT + (WIDTH + 30.0) * scenarios.len() as f64;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} 420\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    let y = |share: f64| TOP + HEIGHT * (1.0 - share);
    for (panel, scenario) in scenarios.iter().enumerate() {
        let left = LEFT + (WIDTH + 30.0) * panel as f64;
        let of: Vec<_> = result.conditions.iter().filter(|one| one.scenario == *scenario).collect();
        let x = |index: usize| left + WIDTH * (index as f64 + 0.5) / of.len() as f64;
        writeln!(svg, "<text x=\"{left}\" y=\"20\" font-weight=\"bold\">{}</text>", html(scenario))
            .expect(STRING);
        for tenth in (0..=10).step_by(2) {
            let at = y(f64::from(tenth) / 10.0);
            writeln!(svg, "<path d=\"M{left} {at}h{WIDTH}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{}\" text-anchor=\"end\">{} %</text>", left - 4.0, at + 4.0, tenth * 10).expect(STRING);
        }
        let line = |value: &dyn Fn(&CalibratedShare) -> f64| {
            let places = of
                .iter()
                .enumerate()
                .map(|(index, one)| format!("{:.1},{:.1}", x(index), y(value(&one.share))));
            places.collect::<Vec<_>>().join(" ")
        };
        for (colour, dash, places) in
            [("#d95f02", "6 4", line(&|share| share.equal)), ("#1b6ca8", "none", line(&|share| share.fresh))]
        {
            writeln!(svg, "<polyline points=\"{places}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\" stroke-dasharray=\"{dash}\"/>").expect(STRING);
        }
        for (index, one) in of.iter().enumerate() {
            let CalibratedShare { observed, error, .. } = one.share;
            let (at, high, low) = (x(index), y((observed + error).min(1.0)), y((observed - error).max(0.0)));
            writeln!(svg, "<path d=\"M{at:.1} {high:.1}V{low:.1}\" stroke=\"black\"/><circle cx=\"{at:.1}\" cy=\"{:.1}\" r=\"4\"/>", y(observed)).expect(STRING);
            writeln!(
                svg,
                "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                TOP + HEIGHT + 18.0,
                html(&one.values)
            )
            .expect(STRING);
        }
    }
    writeln!(
        svg,
        "<g><circle cx=\"{LEFT}\" cy=\"392\" r=\"4\"/><text x=\"{}\" y=\"396\">people ± one standard error</text>\
         <path d=\"M{} 392h24\" stroke=\"#1b6ca8\" stroke-width=\"2\"/><text x=\"{}\" y=\"396\">{}, fresh noise</text>\
         <path d=\"M{} 392h24\" stroke=\"#d95f02\" stroke-width=\"2\" stroke-dasharray=\"6 4\"/><text x=\"{}\" y=\"396\">candidates, equally weighed</text></g>",
        LEFT + 10.0, LEFT + 200.0, LEFT + 230.0, html(&result.name), LEFT + 400.0, LEFT + 430.0
    )
    .expect(STRING);
    svg + "</svg>\n"
}
