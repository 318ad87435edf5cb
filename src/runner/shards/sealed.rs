//! Files of JSON lines whose last line is a digest of all before it: what was cut off or changed is seen.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::error::ShardError;
use files::{Lines, ReadError, WholeFile, hexadecimal};

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
        let sha256 = hexadecimal(&self.hash.finalize());
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
            let found = hexadecimal(&std::mem::take(hash).finalize());
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
pub fn parse<'l, T: Deserialize<'l>>(path: &Path, line: &'l [u8]) -> Result<T, ShardError> {
    serde_json::from_slice(line).map_err(|error| wrong(path, format!("a line of it means nothing: {error}")))
}

pub fn wrong(path: &Path, message: impl Into<String>) -> ShardError {
    ShardError::File { path: path.to_path_buf(), message: message.into() }
}

fn unreadable(path: &Path, error: &ReadError) -> ShardError {
    wrong(path, format!("it cannot be read: {error}"))
}

/// Which kind of file a first line is of.
#[derive(Deserialize)]
struct Format {
    format: String,
    version: u32,
}

/// What the first line says, if it is of that `format` and `version`; `other` says what it is not, and `what` what it is.
pub fn parse_first<T: for<'d> Deserialize<'d>>(
    lines: &mut SealedReader,
    (format, version): (&str, u32),
    (other, what): (&str, &str),
) -> Result<T, ShardError> {
    let path = lines.path.clone();
    let none = || wrong(&path, other);
    let Ok(line) = lines.next_line()? else { return Err(none()) };
    let found: Format = serde_json::from_slice(line.text).map_err(|_| none())?;
    if found.format != format {
        return Err(none());
    }
    if found.version != version {
        let message =
            format!("{what} of version {}, and this program reads version {version}", found.version);
        return Err(wrong(&path, message));
    }
    parse(&path, line.text)
}

/// That of some bytes one after the other, hexadecimal.
pub fn digest_of(parts: impl Iterator<Item = impl AsRef<[u8]>>) -> String {
    hexadecimal(&parts.fold(Sha256::new(), |hash, part| hash.chain_update(part)).finalize())
}
