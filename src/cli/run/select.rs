//! Which of the units are to run: filters first, then the share of this machine.

use std::collections::BTreeSet;

use clap::Args;

use super::partition::Partition;
use crate::cli::filter::{self, FilterArguments};
use lang::filter::{Filters, Subject};
use runner::project::PlannedSuite;
use runner::session::{Unit, Units, Work};

/// What is selected, by expressions and by name.
#[derive(Debug, Args)]
pub struct SubjectArguments {
    #[command(flatten)]
    pub expressions: FilterArguments,

    /// The filter is the whole name of a trial or block.
    #[arg(long)]
    pub exact: bool,

    /// Leave out trials and blocks whose name contains this; may be repeated.
    #[arg(long, value_name = "FILTER")]
    pub skip: Vec<String>,
}

#[derive(Debug, Args)]
pub struct SelectArguments {
    #[command(flatten)]
    pub subjects: SubjectArguments,

    /// Only what did not pass when it was last run.
    #[arg(long)]
    pub last_failed: bool,

    /// Run only one of several shares of what is selected: `slice:1/4` takes every fourth one, `hash:1/4` chooses by
    /// name, so that nothing changes its share when others come and go.
    #[arg(long, value_name = "slice:M/N|hash:M/N")]
    pub partition: Option<Partition>,
}

/// Shows what filter expressions may ask about a unit.
pub fn with_subject<T>(suites: &[PlannedSuite], unit: &Unit, show: impl FnOnce(&Subject) -> T) -> T {
    let PlannedSuite { file, suite, .. } = &suites[unit.suite];
    match &unit.work {
        Work::Trial(trial) => filter::with_trial(&suite.name, file, trial, show),
        Work::Block(block) => show(&filter::block(suite, file, block)),
        Work::Recorded(recorded) => show(&filter::recorded(suite, file, recorded)),
    }
}

/// Whether each unit is asked for, by the filter expressions and by its name; if `failed` are given, only those of them; of these the share of a
/// `partition`. What units need is not looked at: see [`runner::session::with_needs`].
pub fn select(
    suites: &[PlannedSuite],
    units: &Units,
    filters: &Filters,
    filter: Option<&str>,
    (arguments, partition): (&SubjectArguments, Option<Partition>),
    failed: Option<&BTreeSet<String>>,
) -> Vec<bool> {
    let matches = |key: &str, filter: &str| {
        if arguments.exact { key == filter } else { key.contains(filter) }
    };
    let is_all = filter.is_none() && failed.is_none() && arguments.skip.is_empty() && filters.is_empty();
    if is_all && partition.is_none() {
        return vec![true; units.len()];
    }
    let wanted = |index: usize, key: &str| {
        filter.is_none_or(|filter| matches(key, filter))
            && failed.is_none_or(|failed| failed.contains(key))
            && !arguments.skip.iter().any(|skip| matches(key, skip))
            && (filters.is_empty()
                || with_subject(suites, &units.get(index), |subject| filters.matches(subject)))
    };
    let mut place = 0;
    units
        .keys()
        .enumerate()
        .map(|(index, key)| {
            let wanted = wanted(index, &key);
            let mine = partition.is_none_or(|partition| partition.holds(place, &key));
            place += usize::from(wanted);
            wanted && mine
        })
        .collect()
}
