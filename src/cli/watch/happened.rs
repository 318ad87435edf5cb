//! What may happen while is watched.

use std::any::Any;

use super::keys::Key;
use super::one_run::Ended;

/// What may happen.
pub enum Happened {
    Key(Key),
    /// Some file may have changed.
    Hint,
    /// A run has ended, or panicked.
    Ended(Result<Box<Ended>, Box<dyn Any + Send>>),
    Interrupted,
}
