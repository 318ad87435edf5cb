//! Names that many runs have in common.

use std::cell::RefCell;
use std::collections::HashSet;
use std::sync::Arc;

thread_local! {
    /// Those of all road users that this thread has run; no more than scenarios have.
    static KNOWN: RefCell<HashSet<Arc<str>>> = RefCell::default();
}

/// The name, which is held once however many runs speak of it.
pub(super) fn shared(name: &str) -> Arc<str> {
    KNOWN.with_borrow_mut(|known| {
        known.get(name).cloned().unwrap_or_else(|| {
            let name: Arc<str> = name.into();
            known.insert(name.clone());
            name
        })
    })
}
