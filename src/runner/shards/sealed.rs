//! Files of JSON lines whose last line is a digest of all before it: what was cut off or changed is seen.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::error::ShardError;
use files::{Lines, ReadError, WholeFile};
use scenario::sha256;

/// Longer lines are of something else, bytes.
const LONGEST: u64 = 64 << 20;

/// How a last line begins, and no other.
const SEAL: &[u8] = b"{\"sha256\":";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Seal {
    sha256: String,
}

/// Writes one, which has its name when it is whole.
pub struct SealedWriter {
    file: WholeFile,
    hash: Sha256,
}

impl SealedWriter {
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self { file: WholeFile::create(path)?, hash: Sha256::new() })
    }

    pub fn line(&mut self, data: &impl Serialize) -> io::Result<()> {
        let mut line = serde_json::to_vec(data)?;
        line.push(b'\n');
        self.hash.update(&line);
        self.file.write_all(&line)
    }

    /// Writes the last line, and returns what stands in it.
    pub fn finish(mut self) -> io::Result<String> {
        let sha256: String = self.hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        let mut line = serde_json::to_vec(&Seal { sha256: sha256.clone() })?;
        line.push(b'\n');
        self.file.write_all(&line)?;
        self.file.commit()?;
        Ok(sha256)
    }
}

/// Reads one, a line after the other. Only at its end is it known that it is whole.
pub struct SealedReader {
    path: PathBuf,
    lines: Lines,
    line: Vec<u8>,
    hash: Sha256,
    /// Where the next line is, bytes.
    place: u64,
}

/// A line but the last.
pub struct SealedLine<'l> {
    pub text: &'l [u8],
    /// Where it begins, bytes.
    pub place: u64,
}

impl SealedReader {
    pub fn open(path: &Path) -> Result<Self, ShardError> {
        let lines = Lines::open(path, LONGEST).map_err(|error| unreadable(path, &error))?;
        Ok(Self { path: path.to_path_buf(), lines, line: Vec::new(), hash: Sha256::new(), place: 0 })
    }

    /// The next line, or the digest of all.
    pub fn next_line(&mut self) -> Result<Result<SealedLine<'_>, String>, ShardError> {
        let Self { path, lines, line: known, hash, place } = self;
        let cut_off = || ShardError::CutOff { path: path.clone() };
        let line = lines.next_line().map_err(|error| unreadable(path, &error))?;
        known.clear();
        known.extend_from_slice(line.filter(|line| line.ends_with(b"\n")).ok_or_else(cut_off)?);
        let line = &known[..];
        if line.starts_with(SEAL) {
            let seal: Seal = parse(path, line)?;
            let found = std::mem::take(hash).finalize();
            let found: String = found.iter().map(|byte| format!("{byte:02x}")).collect();
            if seal.sha256 != found {
                return Err(wrong(
                    path,
                    "it is damaged or was changed: its lines have another digest than its last line says",
                ));
            }
            return match lines.next_line().map_err(|error| unreadable(path, &error))? {
                None => Ok(Err(found)),
                Some(_) => Err(wrong(path, "there is more behind its last line")),
            };
        }
        hash.update(line);
        let begins = *place;
        *place += line.len() as u64;
        Ok(Ok(SealedLine { text: line, place: begins }))
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// What a line of a file says.
pub fn parse<T: for<'d> Deserialize<'d>>(path: &Path, line: &[u8]) -> Result<T, ShardError> {
    serde_json::from_slice(line).map_err(|error| wrong(path, format!("a line of it means nothing: {error}")))
}

pub fn wrong(path: &Path, message: impl Into<String>) -> ShardError {
    ShardError::File { path: path.to_path_buf(), message: message.into() }
}

fn unreadable(path: &Path, error: &ReadError) -> ShardError {
    wrong(path, format!("it cannot be read: {error}"))
}

/// That of some bytes, hexadecimal.
pub fn digest_of(parts: impl Iterator<Item = impl AsRef<[u8]>>) -> String {
    let all: Vec<u8> = parts.flat_map(|part| part.as_ref().to_vec()).collect();
    sha256(&all)
}
