//! Where the journal of a block lies: in a file of its own for everything that decides what it holds, so that no stale one is ever gone on with.

use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};

use files::{LogError, hexadecimal};

/// The file of a block's journal in a folder, and the hash in its name: of `decisive`, which is everything that decides what is in it, the
/// program's version included.
///
/// # Errors
/// If a link is there.
pub fn journal_file(
    folder: &Path,
    name: &str,
    decisive: &impl Serialize,
) -> Result<(PathBuf, String), LogError> {
    let text = serde_json::to_vec(decisive).expect("plain data serialises");
    let hash = hexadecimal(&Sha256::digest(text)[..8]);
    let path = folder.join(format!("{}-{hash}.jsonl", name.replace('/', "-")));
    // Its name can be foretold, so somebody's project could have it lead anywhere.
    if path.is_symlink() {
        let error = io::Error::other("it is a link, which a journal never is; remove it");
        return Err(LogError::Io { path, error });
    }
    Ok((path, hash))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_decides_is_part_of_the_name() {
        let folder = tempfile::tempdir().unwrap();
        let file = |decisive: &[f64]| journal_file(folder.path(), "of/two", &decisive).unwrap();
        let (path, hash) = file(&[1.0, 2.0]);
        assert_eq!(path, folder.path().join(format!("of-two-{hash}.jsonl")));
        assert_eq!((hash.len(), file(&[1.0, 2.0]).0 == path, file(&[2.0, 1.0]).0 == path), (16, true, false));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let (path, _) = journal_file(folder.path(), "block", &1).unwrap();
        std::os::unix::fs::symlink(folder.path().join("elsewhere"), &path).unwrap();
        let refused = journal_file(folder.path(), "block", &1).unwrap_err().to_string();
        assert!(refused.contains("a link, which a journal never is; remove it"), "{refused}");
    }
}
