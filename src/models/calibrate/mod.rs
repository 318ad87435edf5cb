//! Calibration: which parameter sets of the COMMOTIONS model behave as criteria demand (retention, §9.1).
//!
//! Candidates come from a grid, from a random design over ranges, or from a file; every candidate goes through the
//! meetings that the criteria name, several times each; those that meet all criteria are retained and become a
//! population.

mod candidates;
mod criteria;
mod drawn;
mod journal;
mod published;
mod retention;

pub use candidates::{CandidateError, Candidates, Design, ParameterRange, published_grid};
pub use criteria::{
    CriteriaError, Demand, Drives, RetentionCriterion, RetentionVerdict, published_criteria, read_criteria,
};
pub use drawn::DrawnParameter;
pub use journal::{CalibrationJournal, JournalError};
pub use published::{PUBLISHED_SHARE, PublishedError, published_candidates};
pub use retention::{CalibrateError, Calibration, Report, Request, calibrate};
