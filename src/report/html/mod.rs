//! The report as one HTML file that needs nothing else: no network, no fonts, and no JavaScript but for the animation.

mod asked;
mod block;
mod calibrate;
mod command;
mod diff;
mod diff_plots;
#[cfg(test)]
mod diff_tests;
mod embed;
mod estimate;
mod evaluate;
mod failures;
mod figure;
mod gate;
mod ghosts;
mod margins;
mod minds;
mod pairs;
mod plots;
#[cfg(test)]
mod plots_tests;
mod policy;
mod rating;
mod search;
mod shared_area;
mod space;
mod statement;
mod still;
mod told;
mod tune;
mod usual;
mod view;

use std::time::SystemTime;

pub use diff::diff_to_html;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::{Serde, Value};
use minijinja::{Environment, UndefinedBehavior, context};

use super::{chart, expect_every_trial};
use files::escape::html_characters;
use results::Results;

/// The pages and their parts.
const TEMPLATES: [(&str, &str); 17] = [
    ("head.html", include_str!("head.html")),
    ("controls.html", include_str!("controls.html")),
    ("diff.html", include_str!("diff.html")),
    ("page.html", include_str!("page.html")),
    ("failures.html", include_str!("failures.html")),
    ("player.html", include_str!("player.html")),
    ("perceived.html", include_str!("perceived.html")),
    ("figure.html", include_str!("figure.html")),
    ("statements.html", include_str!("statements.html")),
    ("search.html", include_str!("search.html")),
    ("tune.html", include_str!("tune.html")),
    ("evaluate.html", include_str!("evaluate.html")),
    ("calibrate.html", include_str!("calibrate.html")),
    ("estimate.html", include_str!("estimate.html")),
    ("gate.html", include_str!("gate.html")),
    ("rating.html", include_str!("rating.html")),
    ("comparisons.html", include_str!("comparisons.html")),
];

/// The page. `recordings` are runs of [`results::choose_runs`], recorded again.
///
/// # Panics
/// If the results do not hold every trial.
pub fn to_html(results: &Results) -> String {
    expect_every_trial(results);
    let Results { requests, suites: reports, recordings, denies_untested: _ } = results;
    let started = reports.first().map_or(SystemTime::UNIX_EPOCH, |report| report.started);
    let page = view::Page::new(reports, requests, recordings, started);
    rendered("page.html", &[include_str!("page.css"), include_str!("player.css")], Serde(page))
}

/// The page of that name, with these style sheets and those of charts.
fn rendered(name: &str, styles: &[&str], page: impl Into<Value>) -> String {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build();
    environment.set_syntax(syntax.expect("only white space is set"));
    environment.set_formatter(|out, state, value| match value.as_str() {
        // What is safe was made here and escaped there.
        Some(text) if !value.is_safe() => {
            minijinja::escape_formatter(out, state, &Value::from(html_characters(text)))
        }
        _ => minijinja::escape_formatter(out, state, value),
    });
    for (name, text) in TEMPLATES {
        environment.add_template(name, text).expect("the template is valid");
    }
    let template = environment.get_template(name).expect("it was added above");
    let style = format!("{}\n{}", styles.join("\n"), chart::STYLE);
    let script = include_str!("page.js");
    template
        .render(context! {
            page => page.into(),
            policy => policy::content_security_policy(&style, script),
            style,
            script,
        })
        .expect("the template fits the page")
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::fixture::{self, Session};
    use results::{BlockReport, BlockState, TrialReport};
    use results::{BlockResult, Conclusion};
    use results::{Results, choose_runs};
    use scenario::Block;
    use scenario::{CaseSet, Condition, DeclaredStanding, Evaluate, Origin, ParameterSet, Statement};

    fn page() -> String {
        let session = Session::new();
        let report = session.report();
        let recordings = session.record(choose_runs(&report));
        to_html(&Results { recordings, ..session.unrecorded(report) })
    }

    /// The page without what has snapshots of its own or is the same for all pages.
    fn skeleton(page: &str) -> String {
        let mut rest = page.replace(env!("CARGO_PKG_VERSION"), "[version]");
        let platform = format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
        rest = rest.replace(&platform, "[platform]");
        let policy = policy_of(page).to_string();
        rest = rest.replace(&policy, "[policy]");
        for (begin, end) in
            [("<style", "</style>"), ("<script", "</script>"), ("<svg class", "</svg>\n</div>")]
        {
            let mut from = 0;
            while let Some(start) = rest[from..].find(begin).map(|index| from + index) {
                let stop = rest[start..].find(end).map_or(rest.len(), |index| start + index);
                let inner = rest[start..].find('>').map_or(stop, |index| start + index + 1);
                rest.replace_range(inner.min(stop)..stop, "…");
                from = start + begin.len();
            }
        }
        rest
    }

    /// As it stands in the page.
    pub(super) fn policy_of(page: &str) -> &str {
        let content = part(page, "http-equiv=\"Content-Security-Policy\" content=\"", "\">");
        content.split_once("content=\"").expect("it was found with that").1
    }

    #[test]
    fn browsers_run_our_script_and_no_other() {
        assert_runs_our_script_alone(&page());
    }

    pub(super) fn assert_runs_our_script_alone(page: &str) {
        let policy = policy_of(page).replace("&#x27;", "'").replace("&#x2f;", "/");
        let inner = |from: &str, to: &str| {
            let element = part(page, from, to);
            element[from.len()..].to_string()
        };
        let (style, script) = (inner("<style>", "</style>"), inner("<script>", "</script>"));
        assert_eq!(policy, policy::content_security_policy(&style, &script));
        assert!(!policy.contains("unsafe"));
        // What the policy forbids is not asked for.
        for forbidden in [" style=", " onclick=", "javascript:", ".innerHTML", "eval("] {
            assert!(!page.contains(forbidden), "{forbidden}");
        }
    }

    #[test]
    fn the_worst_failure_stands_before_everything_else() {
        let page = page();
        let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("no {text}"));
        let order = [
            "class=\"verdict failed\"",
            "<h2>Worst failure</h2>",
            "<h2>What did not pass</h2>",
            "id=\"suite-1\"",
            "id=\"about\"",
        ];
        assert!(order.windows(2).all(|pair| place(pair[0]) < place(pair[1])));
        // What is embedded first is what is told of without the script.
        let key = part(&page, "id=\"command\">", "</code>")
            .split("&#x27;")
            .nth(1)
            .expect("a key")
            .replace("&#x2f;", "/");
        assert!(
            part(&page, "id=\"data\">", "\"kind\"").contains(&key)
                && page.matches("class=\"plots\"").count() > 1
        );
    }

    /// The words and the class of a page's verdict.
    fn verdict_of(report: results::SuiteReport) -> String {
        let page = to_html(&Session::new().unrecorded(report));
        part(&page, "<p class=\"verdict ", "</p>").to_string()
    }

    #[test]
    fn nothing_that_is_not_well_looks_so() {
        let empty = || {
            let mut report = Session::new().report();
            (report.blocks, report.gates, report.ratings, report.recorded) = Default::default();
            report
        };
        let only = |index: usize| {
            let mut report = empty();
            report.trials = vec![report.trials.remove(index)];
            report
        };
        let passed = |verdict: &str| verdict.starts_with("<p class=\"verdict passed");
        let count = empty().trials.len();
        assert!(!passed(&verdict_of(only(count - 2))), "an error");
        assert!(!passed(&verdict_of(only(count - 1))), "skipped");
        let mut nothing = empty();
        nothing.trials.clear();
        assert!(!passed(&verdict_of(nothing)), "nothing");
        let passes = |index: &usize| only(*index).trials[0].verdict() == Some(results::Verdict::Passed);
        let good = || only((0..count).find(passes).expect("one passes"));
        assert!(passed(&verdict_of(good())), "a trial that passes");
        // A recorded run that still fails, beside trials that pass.
        let mut good = good();
        good.recorded = Session::new().report().recorded;
        let verdict = verdict_of(good);
        assert!(!passed(&verdict) && verdict.contains("recorded runs do not pass: 1"), "{verdict}");
        let mut cut = Session::new().interrupted();
        cut.trials.remove(0);
        assert!(!passed(&verdict_of(cut)), "cut off");
    }

    #[test]
    fn shows_every_state_of_a_trial() {
        insta::assert_snapshot!(skeleton(&page()));
    }

    /// A page whose suite also has an evaluation and statements of every kind.
    fn page_of_a_paper() -> String {
        let session = Session::new();
        let mut report = session.report();
        let (evaluate, statement) = (an_evaluate(), a_statement());
        let differs = DeclaredStanding::Differs("the car is <heavier>".into());
        let unknown = Conclusion::NotComparable("nobody was run".into());
        let results = [
            BlockResult::Evaluate(fixture::evaluation()),
            BlockResult::Statement(fixture::statement(DeclaredStanding::Reproduced, Conclusion::Reproduced)),
            BlockResult::Statement(fixture::statement(differs.clone(), Conclusion::NotReproduced)),
            BlockResult::Statement(fixture::statement(differs, Conclusion::Reproduced)),
            BlockResult::Statement(fixture::statement(
                DeclaredStanding::NotComparable("no renderer".into()),
                unknown,
            )),
        ];
        for (index, result) in results.into_iter().enumerate() {
            let block = match &result {
                BlockResult::Evaluate(_) => Block::Evaluate(evaluate.clone()),
                _ => Block::Statement(statement.clone()),
            };
            let (key, state) = (format!("zebra/{index}"), BlockState::Finished(Box::new(result)));
            report.blocks.push(BlockReport { block: block.into(), key, state, wall_time: Duration::ZERO });
        }
        to_html(&session.unrecorded(report))
    }

    fn an_evaluate() -> Evaluate {
        let condition =
            |name: &str, parameters| Condition { name: name.into(), parameters, origin: Origin::default() };
        Evaluate {
            name: "final".into(),
            doc: Some("Parameters on the same cases.".into()),
            on: CaseSet::Bests("low_pet".into()),
            conditions: vec![
                condition("default", ParameterSet::Declared),
                condition("tuned", ParameterSet::Tuned("braking_distance".into())),
            ],
            fresh: 0,
            measures: Vec::new(),
            source: None,
            reported: Vec::new(),
            given_in: Vec::new(),
            origin: Origin::default(),
        }
    }

    fn a_statement() -> Statement {
        Statement {
            name: "gaps_rise".into(),
            doc: None,
            source: None,
            reported: None,
            claims: Vec::new(),
            standing: DeclaredStanding::Reproduced,
            origin: Origin::default(),
        }
    }

    /// The part of a page from one text to another.
    pub(super) fn part<'a>(page: &'a str, from: &str, to: &str) -> &'a str {
        let start = page.find(from).unwrap_or_else(|| panic!("no {from}"));
        let length = page[start..].find(to).unwrap_or_else(|| panic!("no {to} after {from}"));
        &page[start..start + length]
    }

    #[test]
    fn statements_stand_beside_their_source() {
        let page = page_of_a_paper();
        insta::assert_snapshot!(part(&page, "<h3>Statements</h3>", "</article>"));
    }

    #[test]
    fn ours_stands_beside_what_is_reported() {
        let page = skeleton(&page_of_a_paper());
        insta::assert_snapshot!(part(&page, "<table class=\"conditions\">", "</article>"));
    }

    #[test]
    fn pages_are_well_formed() {
        [page(), page_of_a_paper()].iter().for_each(|page| assert_well_formed(page));
    }

    /// Every element that is opened is closed, in order.
    pub(super) fn assert_well_formed(page: &str) {
        const VOID: [&str; 4] = ["meta", "input", "br", "!DOCTYPE"];
        let mut open: Vec<&str> = Vec::new();
        let mut rest = page;
        while let Some(start) = rest.find('<') {
            let end = start + rest[start..].find('>').expect("every tag ends");
            let tag = &rest[start + 1..end];
            rest = &rest[end + 1..];
            let name = tag.trim_start_matches('/').split([' ', '/', '\n']).next().unwrap_or_default();
            if let Some(closed) = tag.strip_prefix('/') {
                assert_eq!(open.pop(), Some(closed), "before {}", &rest[..rest.len().min(80)]);
            } else if !tag.ends_with('/') && !VOID.contains(&name) {
                open.push(name);
            }
            // Scripts and styles are not markup.
            if ["script", "style"].contains(&name) && !tag.starts_with('/') {
                rest = &rest[rest.find(&format!("</{name}")).expect("it is closed")..];
            }
        }
        assert!(open.is_empty(), "{open:?} are not closed");
    }

    #[test]
    fn the_same_report_gives_the_same_bytes() {
        assert!(page() == page());
        assert!(page_of_a_paper() == page_of_a_paper());
    }

    #[test]
    fn a_thousand_individuals_fit() {
        let session = Session::new();
        let mut report = session.report();
        let BlockState::Finished(result) = &mut report.blocks[0].state else { panic!("it is finished") };
        let BlockResult::Search(search) = result.as_mut() else { panic!("it is a search") };
        let mut template = search.found[0].clone();
        template.evaluations = (0..60)
            .map(|step| {
                let tta = 6.0 + 0.2 * f64::from(step);
                (vec![optimise::Coordinate::Real(tta)], Some((tta * 7.0).sin() + tta / 4.0))
            })
            .collect();
        search.found = vec![template; 1000];
        for (index, found) in search.found.iter_mut().enumerate() {
            found.individuals[0].number = index as u32 + 1;
        }
        let page = to_html(&session.unrecorded(report));
        assert!(page.len() < 2_000_000, "{} bytes", page.len());
        assert!(page.contains("880 more individuals are not drawn"));
        assert_eq!(part(&page, "<table class=\"sortable found\">", "</table>").matches("<tr").count(), 1001);
    }

    #[test]
    fn a_page_of_very_many_trials_shows_the_bad_ones_and_says_what_is_left_out() {
        let session = Session::new();
        let mut report = session.report();
        let of = |index: usize| TrialReport {
            departures: Vec::new(),
            trial: report.trials[index].trial.clone(),
            outcomes: report.trials[index].outcomes.clone(),
            state: report.trials[index].state.clone(),
            wall_time: Duration::ZERO,
        };
        // The first fails, the second passes.
        let many: Vec<_> = (0..4000).map(|number| of(usize::from(number < 3900))).collect();
        report.trials.extend(many);
        let page = to_html(&session.unrecorded(report));
        assert!(page.len() < 4_000_000, "{} bytes", page.len());
        assert!(page.contains("3503 more trials are not shown here, 0 of which did not pass"), "no note");
        assert!(page.contains("41 more trials did not pass and are not written out"), "no note");
        assert!(page.matches("<details class=\"failure\"").count() < 70);
    }

    #[test]
    fn needs_nothing_from_elsewhere_and_escapes_names() {
        let page = page();
        for forbidden in ["http://", "https://", "<link", "src=", "@import", "walker_<carla>", "url("] {
            let harmless = page.replace("http://www.w3.org/2000/svg", "");
            assert!(!harmless.contains(forbidden), "{forbidden} stands in the page");
        }
    }

    #[test]
    fn charts_are_drawn_for_every_kind_of_figure() {
        let page = page();
        for title in [
            "Convergence",
            "Surrogates",
            "Margins of the constraints",
            "Rates against tta",
            "pet per scenario and variation",
            "pet against tta",
            "pet per scenario",
            "Trajectories",
        ] {
            assert!(page.contains(&format!("<b>{title}</b>")), "no figure `{title}`");
        }
        assert!(!page.contains("NaN") && !page.contains(">inf<"));
    }
}
