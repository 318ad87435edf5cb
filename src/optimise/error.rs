//! What can go wrong in the optimiser.

/// What can go wrong in the optimiser. Bad numbers told by evaluations are not among it: they count as undefined.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The space or a point has a wrong number of dimensions, or two of one name.
    #[error("{0}")]
    Dimensions(String),
    /// A dimension's range holds no choice.
    #[error("the range of dimension `{dimension}` is unusable: {reason}")]
    Range {
        /// Its name.
        dimension: String,
        /// What is wrong with the range, in words.
        reason: String,
    },
    /// A value is not in its dimension's range.
    #[error("dimension `{dimension}` is given {value}, expected {expected}")]
    Value {
        /// Its name.
        dimension: String,
        /// The value, as text.
        value: String,
        /// The values that fit, in words.
        expected: String,
    },
    /// A setting makes no sense.
    #[error("the optimisation cannot be run: {0}")]
    Definition(String),
    /// An evaluation does not fit the definition.
    #[error("the evaluation does not fit: {0}")]
    Evaluation(String),
    /// An evaluation of something that was not asked for, or was told already.
    #[error("proposal {0} is not pending: it was never asked for or is told already")]
    Unasked(u64),
    /// The surrogate cannot be fitted to these data.
    #[error("the surrogate cannot be fitted: {0}")]
    Surrogate(String),
    /// The journal cannot be read or written.
    #[error("journal {0}")]
    Journal(#[from] files::LogError),
    /// The journal holds something else than this run's evaluations.
    #[error("journal {path}, line {line}: {reason}")]
    JournalContent {
        /// The journal.
        path: String,
        /// Counted from 1; the header is the first.
        line: usize,
        /// What does not fit, in words.
        reason: String,
    },
}
