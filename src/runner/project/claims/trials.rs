//! The trials that a finding is about, taken in one after the other: there may be a million, so that the first and how many
//! there are is all that is kept.

use crate::plan::Outline;
use lang::Diagnostic;
use scenario::Scenario;

/// Some of a scenario's trials.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct TrialsAbout {
    /// The first one's key.
    first: String,
    /// At least 1.
    count: usize,
}

impl TrialsAbout {
    fn first(trial: &Outline) -> Self {
        Self { first: trial.key.clone(), count: 1 }
    }

    /// Takes in one more, which may be the first.
    pub fn add(about: &mut Option<Self>, trial: &Outline) {
        match about {
            Some(about) => about.count += 1,
            None => *about = Some(Self::first(trial)),
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The diagnostic with these as the trials that it is about, of so many in all.
    pub fn note(&self, diagnostic: Diagnostic, scenario: &Scenario, trials: usize) -> Diagnostic {
        let Self { first, count } = self;
        diagnostic.note(match *count {
            1 => format!("in {first}"),
            all if all == trials => format!("in each of the {trials} trials of scenario `{}`", scenario.name),
            2 => format!("in {first} and one more trial"),
            some => format!("in {first} and {} more trials", some - 1),
        })
    }
}

/// What trials are about, each thing once, in the order in which it was first found.
#[derive(Debug)]
pub(super) struct ByFinding<T>(Vec<(T, TrialsAbout)>);

impl<T> Default for ByFinding<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> ByFinding<T> {
    /// Takes in one more trial of the finding that is the `same`, or else of what is `found` first in it.
    pub fn add(&mut self, trial: &Outline, same: impl Fn(&T) -> bool, found: impl FnOnce() -> T) {
        match self.0.iter_mut().find(|(known, _)| same(known)) {
            Some((_, about)) => about.count += 1,
            None => self.0.push((found(), TrialsAbout::first(trial))),
        }
    }
}

impl<T> IntoIterator for ByFinding<T> {
    type Item = (T, TrialsAbout);
    type IntoIter = std::vec::IntoIter<(T, TrialsAbout)>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use files::Disk;
    use lang::Code;
    use models::standard;

    fn notes(trials: &[&str], all: usize) -> String {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../suites/zebra_unsafe.suite"));
        let loaded = lang::load(path, &standard(), &Disk).unwrap_or_else(|_| panic!("it is a suite"));
        let mut about = None;
        for key in trials {
            let trial = Outline {
                key: key.to_string(),
                variation: Vec::new(),
                runs: 1,
                rounds: None,
                criteria: Default::default(),
            };
            TrialsAbout::add(&mut about, &trial);
        }
        let mut scenario = loaded.suite.scenarios[0].clone();
        scenario.name = "walk".into();
        let origin = &scenario.origin;
        let diagnostic = super::super::budget::at(Code::NothingClaimed, origin, "idle", &loaded.sources);
        about.expect("there are trials").note(diagnostic, &scenario, all).notes.join("; ")
    }

    #[test]
    fn the_first_is_named_and_the_others_counted() {
        assert_eq!(notes(&["a"], 1), "in a");
        assert_eq!(notes(&["a", "b"], 2), "in each of the 2 trials of scenario `walk`");
        assert_eq!(notes(&["a", "b"], 3), "in a and one more trial");
        assert_eq!(notes(&["a", "b", "c", "d"], 9), "in a and 3 more trials");
    }
}
