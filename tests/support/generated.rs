//! Files of the repository that are generated: they have to be what would be generated now.

use std::fs;

/// Fails where the file says anything else; with `UPDATE_DOCS` it is rewritten first.
pub fn stands_in(path: &str, current: &str) {
    if std::env::var_os("UPDATE_DOCS").is_some() {
        fs::write(path, current).unwrap();
    }
    let stored = fs::read_to_string(path).unwrap_or_default();
    assert!(stored == current, "{path} is out of date; run the tests once with UPDATE_DOCS=1");
}
