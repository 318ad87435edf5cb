//! Slurm's clients: `sbatch`, `squeue` and `scancel`, and what they say.

use std::collections::BTreeMap;
use std::process::Command;

use super::client::{ClientOutput, ask};
use super::error::EngineError;

const INSTALL: &str =
    "run it where Slurm's clients are, such as a login node (Debian and Ubuntu: apt install slurm-client)";

/// What of the environment would change which jobs are shown, or that `sbatch` comes back at once.
const FORGOTTEN: [&str; 15] = [
    "SBATCH_ARRAY_INX",
    "SBATCH_CLUSTERS",
    "SBATCH_WAIT",
    "SCANCEL_ACCOUNT",
    "SCANCEL_NAME",
    "SCANCEL_PARTITION",
    "SCANCEL_STATE",
    "SLURM_CLUSTERS",
    "SQUEUE_ACCOUNT",
    "SQUEUE_FORMAT",
    "SQUEUE_FORMAT2",
    "SQUEUE_NAMES",
    "SQUEUE_PARTITION",
    "SQUEUE_STATES",
    "SQUEUE_USERS",
];

/// How one task of an array stands in the queue.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Queued {
    /// Slurm's letters, such as `PD` and `R`.
    pub state: String,
    /// Why it does not run.
    pub reason: String,
}

/// Which tasks of arrays are in the queue, by `JOB_INDEX`.
pub type Queue = BTreeMap<String, Queued>;

fn run(client: &str, arguments: &[&str]) -> Result<ClientOutput, EngineError> {
    let mut command = Command::new(client);
    FORGOTTEN.iter().for_each(|name| _ = command.env_remove(name));
    ask(command.args(arguments), INSTALL)
}

/// What Slurm calls itself.
///
/// # Errors
/// If it is not there.
pub fn version() -> Result<String, EngineError> {
    let said = run("sbatch", &["--version"])?;
    match said.is_success {
        true => Ok(said.stdout.trim().to_string()),
        false => Err(EngineError::Failed(format!("`sbatch --version`: {}", said.stderr.trim()))),
    }
}

/// The number of the job that `sbatch` makes of these arguments.
///
/// # Errors
/// If it makes none, with what it says.
pub fn submit(arguments: &[&str]) -> Result<String, EngineError> {
    let said = run("sbatch", arguments)?;
    let id = said.stdout.trim();
    if said.is_success && is_number(id) {
        return Ok(id.to_string());
    }
    Err(EngineError::Refused(format!("`sbatch` made no job: {}", either(&said))))
}

/// What is in the queue of these jobs, or why that cannot be known now.
///
/// # Errors
/// If the client is missing.
pub fn queue(jobs: &[&str]) -> Result<Result<Queue, String>, EngineError> {
    if jobs.is_empty() {
        return Ok(Ok(Queue::new()));
    }
    let said = run("squeue", &["-h", "-j", &jobs.join(","), "-r", "-o", "%i %t %r"])?;
    // Of one job that it has forgotten, it says so.
    if !said.is_success && said.stderr.contains("Invalid job id specified") {
        return Ok(Ok(Queue::new()));
    }
    Ok(if said.is_success { read_queue(&said.stdout) } else { Err(either(&said)) })
}

/// The job of that name, if there is one in the queue.
///
/// # Errors
/// If the client is missing, or the queue cannot be read.
pub fn named(name: &str) -> Result<Option<String>, EngineError> {
    let said = run("squeue", &["-h", "-n", name, "-o", "%F"])?;
    let id = said.stdout.lines().next().unwrap_or_default().trim();
    match said.is_success && (id.is_empty() || is_number(id)) {
        true => Ok(Some(id.to_string()).filter(|id| !id.is_empty())),
        false => Err(EngineError::Failed(format!(
            "`squeue` does not say whether {name} is there: {}",
            either(&said)
        ))),
    }
}

/// Cancels these jobs, or says why not.
///
/// # Errors
/// If the client is missing.
pub fn cancel(jobs: &[&str]) -> Result<Result<(), String>, EngineError> {
    let said = run("scancel", jobs)?;
    Ok(if said.is_success { Ok(()) } else { Err(either(&said)) })
}

fn read_queue(text: &str) -> Result<Queue, String> {
    let line = |line: &str| {
        let mut words = line.trim().splitn(3, ' ');
        let (id, state) = (words.next()?, words.next()?);
        let (job, index) = id.split_once('_')?;
        let reason = words.next().unwrap_or_default().to_string();
        (is_number(job) && is_number(index))
            .then(|| (id.to_string(), Queued { state: state.to_string(), reason }))
    };
    let read = |text| line(text).ok_or_else(|| format!("`squeue` said what cannot be read: {text:?}"));
    text.lines().filter(|line| !line.trim().is_empty()).map(read).collect()
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

fn either(said: &ClientOutput) -> String {
    let text = if said.stderr.trim().is_empty() { &said.stdout } else { &said.stderr };
    text.trim().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_queue_is_read_line_by_line() {
        let queue =
            read_queue("5_3 PD BeginTime\n5_2 R None\n\n6_0 PD (launch failed requeued held)\n").unwrap();
        assert_eq!(queue.keys().collect::<Vec<_>>(), ["5_2", "5_3", "6_0"]);
        assert_eq!(queue["6_0"].reason, "(launch failed requeued held)");
        assert_eq!(queue["5_2"].state, "R");
    }

    #[test]
    fn what_cannot_be_read_is_not_taken_for_an_empty_queue() {
        for text in ["5_[0-3] PD None", "slurm is away", "5 R", "_3 R None"] {
            assert!(read_queue(text).is_err(), "{text}");
        }
    }
}
