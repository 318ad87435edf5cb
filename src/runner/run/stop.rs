//! The wish that no more runs begin.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Shared by whoever wishes it and whoever is to heed it. Runs that have begun come to their end.
#[derive(Debug, Clone, Default)]
pub struct Stop {
    wished: Arc<AtomicBool>,
    /// The wish for more than this.
    whole: Option<Arc<Stop>>,
}

impl Stop {
    /// One for a part of what this one is for: it ends with the whole, and the whole does not end with it.
    #[must_use]
    pub fn part(&self) -> Self {
        Self { wished: Arc::default(), whole: Some(Arc::new(self.clone())) }
    }

    /// From now on nothing begins.
    pub fn request(&self) {
        self.wished.store(true, Ordering::Relaxed);
    }

    /// Whether somebody wished it.
    pub fn is_requested(&self) -> bool {
        self.wished.load(Ordering::Relaxed) || self.whole.as_ref().is_some_and(|whole| whole.is_requested())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_ends_with_the_whole_and_not_the_other_way_round() {
        let whole = Stop::default();
        let (one, other) = (whole.part(), whole.part());
        one.request();
        assert!(one.is_requested() && !other.is_requested() && !whole.is_requested());
        whole.clone().request();
        assert!(other.is_requested() && other.part().is_requested());
    }
}
