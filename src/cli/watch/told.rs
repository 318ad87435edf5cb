//! What is said of suites that are watched.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anstyle::{AnsiColor, Style};

use files::escape::terminal_line;
use report::count;
use results::Overall;
use runner::watch::SuiteState;

/// More changed files are counted, not named.
const MOST_NAMED: usize = 3;

/// What is known of a suite: `suites/zebra.suite: passed, 12 units`.
pub fn state(file: &str, state: SuiteState, colour: bool) -> String {
    let (words, good) = match state {
        SuiteState::Open => ("not known".to_string(), false),
        SuiteState::DoesNotLoad => ("does not load".to_string(), false),
        SuiteState::NothingSelected => ("nothing is selected".to_string(), false),
        SuiteState::Judged { overall, units, of } => {
            let words = match overall {
                Overall::Passed => "passed",
                Overall::Failed => "failed",
                Overall::Regressed => "worse than the baseline",
                Overall::NotComparable => "cannot be compared with the baseline",
                Overall::Inconclusive => "inconclusive",
                Overall::NothingJudged => "nothing was judged",
            };
            let units =
                if units == of { count(of, "unit") } else { format!("{units} of {}", count(of, "unit")) };
            (format!("{words}, {units}"), overall == Overall::Passed)
        }
    };
    let style = match (colour, good) {
        (false, _) => Style::new(),
        (true, true) => AnsiColor::Green.on_default(),
        (true, false) => AnsiColor::Red.on_default(),
    };
    format!("{}: {style}{words}{style:#}", terminal_line(file))
}

/// `a.scn, b.scn and 2 more`
pub fn paths(paths: &BTreeSet<PathBuf>) -> String {
    let named: Vec<String> = paths.iter().take(MOST_NAMED).map(|path| shown(path)).collect();
    match paths.len() - named.len() {
        0 => named.join(", "),
        more => format!("{} and {more} more", named.join(", ")),
    }
}

/// A path in one line.
pub fn shown(path: &Path) -> String {
    terminal_line(&path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_passed_is_no_whole() {
        let said =
            |units| state("a.suite", SuiteState::Judged { overall: Overall::Passed, units, of: 12 }, false);
        assert_eq!(said(12), "a.suite: passed, 12 units");
        assert_eq!(said(3), "a.suite: passed, 3 of 12 units");
        assert_eq!(state("a\n.suite", SuiteState::DoesNotLoad, false).lines().count(), 1);
    }

    #[test]
    fn many_changes_are_counted() {
        let some = |number: usize| paths(&(0..number).map(|file| format!("{file}.scn").into()).collect());
        assert_eq!(some(1), "0.scn");
        assert_eq!(some(3), "0.scn, 1.scn, 2.scn");
        assert_eq!(some(5), "0.scn, 1.scn, 2.scn and 2 more");
    }
}
