//! Pieces of files that are too large to be held: a digest of all of one, or some bytes at a place.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use sha2::{Digest, Sha256};

use super::read::{ReadError, open};

/// The SHA-256 of a regular file of any size, which is never held whole.
///
/// # Errors
/// [`ReadError`].
pub fn digest(path: &Path) -> Result<[u8; 32], ReadError> {
    let mut file = open(path)?;
    let (mut hash, mut some) = (Sha256::new(), vec![0; 1 << 20]);
    loop {
        match file.read(&mut some)? {
            0 => return Ok(hash.finalize().into()),
            read => hash.update(&some[..read]),
        }
    }
}

/// A regular file of any size of which bytes are read at places.
#[derive(Debug)]
pub struct Places(File);

impl Places {
    /// Of the file at `path`, as it is now: what takes its name later is another file.
    ///
    /// # Errors
    /// [`ReadError`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        Ok(Self(open(path)?))
    }

    /// So many bytes from this place on.
    ///
    /// # Errors
    /// [`ReadError`], also where the file ends before.
    pub fn read(&mut self, place: u64, length: usize) -> Result<Vec<u8>, ReadError> {
        let mut bytes = vec![0; length];
        self.read_exact(place, &mut bytes)?;
        Ok(bytes)
    }

    #[cfg(unix)]
    fn read_exact(&mut self, place: u64, bytes: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.0, bytes, place)
    }

    #[cfg(not(unix))]
    fn read_exact(&mut self, place: u64, bytes: &mut [u8]) -> io::Result<()> {
        use std::io::{Seek, SeekFrom};
        self.0.seek(SeekFrom::Start(place))?;
        self.0.read_exact(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digest_is_of_all_bytes_and_a_place_gives_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let content: Vec<u8> = (0..3_000_000_u32).map(|number| (number % 251) as u8).collect();
        crate::write(&path, &content).unwrap();
        assert_eq!(digest(&path).unwrap(), <[u8; 32]>::from(Sha256::digest(&content)));
        let mut places = Places::open(&path).unwrap();
        assert_eq!(places.read(1_000_000, 10).unwrap(), content[1_000_000..1_000_010]);
        assert_eq!(places.read(0, 2).unwrap(), content[..2]);
        assert!(places.read(2_999_999, 2).is_err());
        assert!(digest(folder.path()).is_err() && digest(&folder.path().join("b")).is_err());
    }
}
