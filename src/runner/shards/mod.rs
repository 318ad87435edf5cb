//! Runs on many machines without a scheduler: a manifest of units, results in batches of files, and a session that reads them.
//!
//! A manifest says once what there is to be run; whoever is given a share of its batches makes their runs and writes down what came of each,
//! and judges nothing. A session over the results is the same session as on one machine, with an executor that answers from files.

mod batch_file;
mod canary;
mod error;
mod execute;
mod joining;
mod manifest;
mod planned_unit;
mod result_files;
mod sealed;
mod slices;
#[cfg(test)]
mod tests;
mod unit_journal;
mod unit_runs;
mod whole_units;

pub use crate::run::Build;
pub use canary::canary;
pub use error::ShardError;
pub use execute::{BatchProgress, Executed, Execution};
pub use manifest::{
    Batches, ManifestHeader, ManifestReader, ManifestUnit, PlannedProgram, UnitBatch, WrittenManifest,
    write_manifest,
};
pub use planned_unit::{PlannedUnit, Planner, UnitPart};
pub use result_files::{ResultFiles, chosen};
