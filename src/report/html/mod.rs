//! The report as one HTML file that needs nothing else: no network, no fonts, and no JavaScript but for the animation.

mod block;
mod choose;
mod embed;
mod evaluate;
mod figure;
mod search;
mod space;
mod statement;
mod tune;
mod view;

use std::time::SystemTime;

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, UndefinedBehavior, context};

use super::SuiteReport;
use super::chart;
use super::recording::Recording;
use crate::run::Requests;

pub use choose::{Chosen, choose_runs};

/// The page and its parts.
const TEMPLATES: [(&str, &str); 6] = [
    ("page.html", include_str!("page.html")),
    ("figure.html", include_str!("figure.html")),
    ("statements.html", include_str!("statements.html")),
    ("search.html", include_str!("search.html")),
    ("tune.html", include_str!("tune.html")),
    ("evaluate.html", include_str!("evaluate.html")),
];

/// The page. `recordings` are runs of [`choose_runs`], recorded again.
pub fn to_html(reports: &[SuiteReport], requests: &Requests, recordings: &[(Chosen, Recording)]) -> String {
    let started = reports.first().map_or(SystemTime::UNIX_EPOCH, |report| report.started);
    let page = view::Page::new(reports, requests, recordings, started);
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build();
    environment.set_syntax(syntax.expect("only white space is set"));
    for (name, text) in TEMPLATES {
        environment.add_template(name, text).expect("the template is valid");
    }
    let template = environment.get_template("page.html").expect("it was added above");
    let style = concat!(include_str!("page.css"), "\n");
    template
        .render(context! {
            page => Serde(page),
            style => format!("{style}{}", chart::STYLE),
            script => include_str!("page.js"),
        })
        .expect("the template fits the page")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::fixture::Session;

    fn page() -> String {
        let session = Session::new();
        let report = session.report();
        let recordings = session.record(choose_runs(&report));
        to_html(&[report], &session.requests, &recordings)
    }

    /// The page without what has snapshots of its own or is the same for all pages.
    fn skeleton(page: &str) -> String {
        let mut rest = page.replace(env!("CARGO_PKG_VERSION"), "[version]");
        let platform = format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
        rest = rest.replace(&platform, "[platform]");
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

    #[test]
    fn shows_every_state_of_a_trial() {
        insta::assert_snapshot!(skeleton(&page()));
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
            "Rates against tta",
            "pet per scenario and variation",
            "pet against tta",
            "pet per scenario",
            "Trajectories",
        ] {
            assert!(page.contains(&format!("<b>{title}</b>")), "no figure `{title}`");
        }
        assert!(!page.contains("NaN") && !page.contains(">inf"));
    }
}
