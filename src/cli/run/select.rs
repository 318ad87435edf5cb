//! Which of the units are to run: filters first, then the share of this machine.

use std::collections::BTreeSet;

use clap::Args;

use super::partition::Partition;
use crate::dispatch::Unit;

#[derive(Debug, Args)]
pub struct SelectArguments {
    /// The filter is the whole name of a trial or block.
    #[arg(long)]
    pub exact: bool,

    /// Leave out trials and blocks whose name contains this; may be repeated.
    #[arg(long, value_name = "FILTER")]
    pub skip: Vec<String>,

    /// Only what did not pass when it was last run.
    #[arg(long)]
    pub last_failed: bool,

    /// Run only one of several shares of what is selected: `slice:1/4` takes every fourth one, `hash:1/4` chooses by
    /// name, so that nothing changes its share when others come and go.
    #[arg(long, value_name = "slice:M/N|hash:M/N")]
    pub partition: Option<Partition>,
}

/// Whether each unit is asked for; `failed` are those that did not pass when they were last run. What units need is not
/// looked at: see [`crate::dispatch::with_needs`].
pub fn select(
    units: &[Unit],
    filter: Option<&str>,
    arguments: &SelectArguments,
    failed: &BTreeSet<String>,
) -> Vec<bool> {
    let matches = |key: &str, filter: &str| {
        if arguments.exact { key == filter } else { key.contains(filter) }
    };
    let wanted = |unit: &Unit| {
        filter.is_none_or(|filter| matches(&unit.key, filter))
            && (!arguments.last_failed || failed.contains(&*unit.key))
            && !arguments.skip.iter().any(|skip| matches(&unit.key, skip))
    };
    let mut place = 0;
    units
        .iter()
        .map(|unit| {
            let wanted = wanted(unit);
            let mine = arguments.partition.is_none_or(|partition| partition.holds(place, &unit.key));
            place += usize::from(wanted);
            wanted && mine
        })
        .collect()
}
