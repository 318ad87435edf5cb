//! What names a run on every machine: a digest over all that decides it.

use std::fmt;
use std::str::FromStr;
use std::sync::{Arc, Mutex, PoisonError};

use sha2::{Digest, Sha256};

use super::job::{Job, MeasuredMetrics, programs};
use super::messagepack::to_messagepack;
use files::hexadecimal;
use scenario::DeclaredProgram;

/// SHA-256 over the build, the case with its world and seed, what is measured and what is changed, and the files of programs that decide: equal
/// digests, equal results. Neither when nor where a run is made is in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RunDigest(pub [u8; 32]);

impl fmt::Display for RunDigest {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&hexadecimal(&self.0))
    }
}

impl FromStr for RunDigest {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        let digits = text.as_bytes();
        if digits.len() != 64 {
            return Err(());
        }
        let mut bytes = [0; 32];
        for (byte, pair) in bytes.iter_mut().zip(digits.chunks(2)) {
            // As it is written: capital letters would be another name of the same.
            let digit = |digit: u8| match digit {
                b'0'..=b'9' => Ok(digit - b'0'),
                b'a'..=b'f' => Ok(digit - b'a' + 10),
                _ => Err(()),
            };
            *byte = digit(pair[0])? << 4 | digit(pair[1])?;
        }
        Ok(Self(bytes))
    }
}

/// Gives runs their digests.
pub struct RunDigests {
    /// Of what all runs have in common.
    base: Sha256,
    programs: Vec<(Arc<DeclaredProgram>, String)>,
    /// That of the last, since most runs are measured alike.
    measured: Mutex<Option<(Arc<MeasuredMetrics>, [u8; 32])>>,
}

impl RunDigests {
    /// Of runs that this `build` makes, where the files of these programs have these digests.
    pub fn new(build: &str, programs: Vec<(Arc<DeclaredProgram>, String)>) -> Self {
        let base = Sha256::new().chain_update("scenario-runner run 1\n").chain_update(build);
        Self { base, programs, measured: Mutex::default() }
    }

    /// That of the run of a job, whatever is told of it.
    pub fn of(&self, job: &Job) -> RunDigest {
        let Job { place: _, case, measured, wanted: _, alone, change } = job;
        let mut hash = self.base.clone();
        hash.update(self.measured(measured));
        hash.update(to_messagepack(&(case, alone, change)));
        programs(case).iter().for_each(|program| hash.update(self.program(program)));
        RunDigest(hash.finalize().into())
    }

    /// Over some data and all that the runs have in common that any program of these decides in.
    pub fn of_all(&self, measured: &Arc<MeasuredMetrics>, data: &impl serde::Serialize) -> RunDigest {
        let mut hash = self.base.clone();
        hash.update(self.measured(measured));
        hash.update(to_messagepack(data));
        self.programs.iter().for_each(|(program, _)| hash.update(self.program(program)));
        RunDigest(hash.finalize().into())
    }

    /// Whether no program decides in these runs that may decide otherwise another time.
    pub(crate) fn are_repeatable(&self) -> bool {
        self.programs.iter().all(|(program, _)| program.is_known_whole())
    }

    fn program(&self, program: &Arc<DeclaredProgram>) -> String {
        let known = self.programs.iter().find(|(known, _)| known == program);
        // One that nobody has looked at is told by its declaration.
        known.map_or_else(|| format!("{program:?}\n"), |(_, digest)| format!("{} {digest}\n", program.name))
    }

    fn measured(&self, measured: &Arc<MeasuredMetrics>) -> [u8; 32] {
        let mut last = self.measured.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((known, digest)) = &*last
            && Arc::ptr_eq(known, measured)
        {
            return *digest;
        }
        let digest = Sha256::digest(to_messagepack(&measured.requests)).into();
        *last = Some((measured.clone(), digest));
        digest
    }
}
