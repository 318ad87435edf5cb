//! What a driver notes on the shared disk of the arrays that it submits: one that is started again goes on with them.

use std::path::{Path, PathBuf};
use std::process;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::error::EngineError;
use super::quote::quoted;
use super::task::{EndedTask, Task, TaskEnd};
use files::hexadecimal;

/// Raised when the file has another meaning.
const FORMAT: u32 = 1;

/// What a task leaves is one short line.
const MOST: u64 = 4096;

/// The arrays of one call.
#[derive(Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct Submission {
    format: u32,
    /// The digest of what was asked for.
    pub asked: String,
    /// Begins the names of its files and jobs; no other call has it.
    pub run: String,
    /// Whether its driver came to an end: then nobody goes on with it.
    pub is_over: bool,
    /// In the order in which they were submitted.
    pub arrays: Vec<SlurmArray>,
}

/// An array that is, or is about to be, in the queue.
#[derive(Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(deny_unknown_fields)]
pub struct SlurmArray {
    /// By which the job is found where a driver was ended before it could note its number.
    pub name: String,
    /// The job's number, once it is known.
    pub job: Option<String>,
    /// The numbers of its tasks among those of the call, by their index in the array.
    pub tasks: Vec<usize>,
}

/// The digest of what is asked for: of equal tasks with equal options it is equal.
pub fn digest(tasks: &[Task], options: &[String]) -> String {
    let text = serde_json::to_vec(&(tasks, options)).unwrap_or_default();
    hexadecimal(&Sha256::digest(text))
}

impl Submission {
    /// A new one.
    pub fn new(asked: String) -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let own = hexadecimal(&Sha256::digest(format!("{asked} {} {}", process::id(), now.as_nanos())));
        let run = format!("scenario-runner-{}", &own[..16]);
        Self { format: FORMAT, asked, run, is_over: false, arrays: Vec::new() }
    }

    /// The one that was noted last in this folder, if there is one.
    ///
    /// # Errors
    /// If what is there cannot be read: jobs may be in the queue of which nothing is known.
    pub fn read(folder: &Path) -> Result<Option<Self>, EngineError> {
        let path = path(folder);
        let wrong = |why: String| {
            EngineError::Failed(format!(
                "{}: {why}; once no job of it is in the queue (`squeue --me`), it may be removed",
                path.display()
            ))
        };
        let text = match files::read_text(&path) {
            Ok(text) => text,
            Err(error) if error.is_missing() => return Ok(None),
            Err(error) => return Err(wrong(error.to_string())),
        };
        let read: Self = serde_json::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        match read.format {
            FORMAT => Ok(Some(read)),
            other => Err(wrong(format!("it is of format {other}, and this program writes {FORMAT}"))),
        }
    }

    /// Notes it.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), EngineError> {
        let path = path(folder);
        let text = serde_json::to_string(self).map_err(|error| EngineError::file(&path, error.into()))?;
        files::write(&path, text + "\n").map_err(|error| EngineError::file(&path, error))
    }

    /// Its jobs whose numbers are known.
    pub fn jobs(&self) -> Vec<&str> {
        self.arrays.iter().filter_map(|array| array.job.as_deref()).collect()
    }

    /// How often that task was submitted.
    pub fn attempts(&self, task: usize) -> usize {
        self.arrays.iter().filter(|array| array.tasks.contains(&task)).count()
    }

    /// As what that task was submitted last, `JOB_INDEX`.
    pub fn last_place(&self, task: usize) -> Option<String> {
        self.arrays.iter().rev().find_map(|array| {
            let index = array.tasks.iter().position(|one| *one == task)?;
            Some(format!("{}_{index}", array.job.as_deref()?))
        })
    }

    /// How that task ended, once it has left that.
    pub fn ended(&self, folder: &Path, number: usize, task: &Task) -> Option<EndedTask> {
        let bytes = files::read_bytes(&self.left(folder, number), MOST).ok()?;
        read_left(&String::from_utf8(bytes).ok()?, &task.id)
    }

    /// What a task leaves once it has ended.
    fn left(&self, folder: &Path, task: usize) -> PathBuf {
        folder.join(format!("{}.{task}.rc", self.run))
    }

    /// The commands of an array, a line each.
    fn commands(&self, folder: &Path, array: &SlurmArray) -> PathBuf {
        folder.join(format!("{}.tasks", array.name))
    }

    /// To which Slurm writes what goes wrong before a task begins.
    pub fn log(&self, folder: &Path) -> PathBuf {
        folder.join(format!("{}.log", self.run))
    }

    /// Writes the commands of an array, and gives the shell script that does one of them.
    ///
    /// # Errors
    /// If a word cannot be said to a shell, or the file cannot be written.
    pub fn script(&self, folder: &Path, array: &SlurmArray, tasks: &[Task]) -> Result<String, EngineError> {
        let line = |number: &usize| {
            let task = &tasks[*number];
            let left = quoted(&self.left(folder, *number).to_string_lossy())?;
            let out = quoted(&task.out.to_string_lossy())?;
            let argv = task.argv.iter().map(|text| quoted(text)).collect::<Result<Vec<_>, _>>()?;
            Ok(format!("{left} {out} {}\n", argv.join(" ")))
        };
        let lines = array.tasks.iter().map(line).collect::<Result<String, EngineError>>()?;
        let path = self.commands(folder, array);
        files::write(&path, lines).map_err(|error| EngineError::file(&path, error))?;
        Ok(SCRIPT.replace("COMMANDS", &quoted(&path.to_string_lossy())?))
    }

    /// Removes the files of a submission that is over; its log stays.
    pub fn remove_files(&self, folder: &Path, tasks: usize) {
        let commands = self.arrays.iter().map(|array| self.commands(folder, array));
        // What stays is of no meaning to another submission.
        commands
            .chain((0..tasks).map(|task| self.left(folder, task)))
            .for_each(|path| _ = files::remove(&path));
    }
}

fn path(folder: &Path) -> PathBuf {
    folder.join("slurm.json")
}

/// Does the task of its index. One that is ended together with this shell (a time limit, `scancel`) has no exit code: it did not come to its end.
/// Where a signal ended it, that may yet be on its way to the shell. Whatever the exit code, it ends with 0, since a cluster may be set up to do again what did not; one that Slurm
/// does again though it had ended does nothing.
const SCRIPT: &str = r#"line=$(sed -n "$((SLURM_ARRAY_TASK_ID + 1))p" COMMANDS)
[ -n "$line" ] || exit 125
eval "set -- $line"
left=$1
out=$2
shift 2
[ -e "$left" ] && exit 0
trap 'exit 125' TERM
: >"$out" || exit 125
begun=$(date +%s.%N)
"$@" </dev/null >"$out" 2>&1
code=$?
[ "$code" -le 128 ] || sleep 1
new=$left.$SLURM_JOB_ID.new
printf '%s %s %s %s end\n' "$code" "$begun" "$(date +%s.%N)" "$(uname -n)" >"$new" && mv -f "$new" "$left" || exit 125
exit 0"#;

/// What a task left, if it is whole.
fn read_left(text: &str, id: &str) -> Option<EndedTask> {
    let words: Vec<&str> = text.strip_suffix('\n')?.split(' ').collect();
    let [code, begun, ended, node, "end"] = words[..] else { return None };
    let (code, begun, ended): (u8, f64, f64) = (code.parse().ok()?, begun.parse().ok()?, ended.parse().ok()?);
    // A clock may be set meanwhile.
    let seconds = (ended - begun).max(0.0);
    Some(EndedTask { id: id.to_string(), end: TaskEnd::Exited(code.into()), node: node.to_string(), seconds })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::slice::from_ref;

    use super::*;

    pub(super) fn task(id: &str, argv: &[&str], folder: &Path) -> Task {
        let argv = argv.iter().map(ToString::to_string).collect();
        Task {
            id: id.to_string(),
            argv,
            out: folder.join(format!("{id}.out")),
            cpus: 1,
            resources: BTreeMap::new(),
        }
    }

    #[test]
    fn what_is_noted_is_read_back_and_what_is_cut_off_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Submission::read(folder.path()).unwrap().is_none());
        let mut submission = Submission::new(digest(&[task("a", &["true"], folder.path())], &[]));
        submission.arrays.push(SlurmArray {
            name: "n".to_string(),
            job: Some("7".to_string()),
            tasks: vec![0],
        });
        submission.write(folder.path()).unwrap();
        assert_eq!(Submission::read(folder.path()).unwrap().unwrap(), submission);

        let path = folder.path().join("slurm.json");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() / 2]).unwrap();
        assert!(Submission::read(folder.path()).unwrap_err().to_string().contains("slurm.json"));
        std::fs::write(&path, text.replace("\"format\":1", "\"format\":2")).unwrap();
        assert!(Submission::read(folder.path()).unwrap_err().to_string().contains("format 2"));
    }

    #[test]
    fn other_tasks_and_other_options_are_something_else() {
        let folder = Path::new("/shared");
        let (one, other) = (task("a", &["true"], folder), task("a", &["true", "x"], folder));
        let long = vec!["--partition=long".to_string()];
        let all = [digest(from_ref(&one), &[]), digest(&[other], &[]), digest(from_ref(&one), &long)];
        assert!(all[0] != all[1] && all[0] != all[2] && all[1] != all[2]);
    }

    #[test]
    fn a_task_is_where_it_was_submitted_last() {
        let mut submission = Submission::new(String::new());
        let array = |job: Option<&str>, tasks: &[usize]| SlurmArray {
            name: String::new(),
            job: job.map(str::to_string),
            tasks: tasks.to_vec(),
        };
        submission.arrays = vec![array(Some("7"), &[0, 1, 2]), array(Some("9"), &[2])];
        assert_eq!(submission.last_place(1).as_deref(), Some("7_1"));
        assert_eq!(submission.last_place(2).as_deref(), Some("9_0"));
        assert_eq!((submission.attempts(1), submission.attempts(2), submission.attempts(3)), (1, 2, 0));
    }

    #[test]
    fn what_is_not_whole_is_no_end() {
        assert_eq!(read_left("0 10.5 12.0 one end\n", "a").unwrap().seconds, 1.5);
        assert_eq!(read_left("137 12 10 one end\n", "a").unwrap().seconds, 0.0);
        for text in [
            "",
            "0",
            "0 10 12 one end",
            "0 10 12 one\n",
            "0 10 12 one en\n",
            "x 10 12 one end\n",
            "300 1 2 o end\n",
        ] {
            assert_eq!(read_left(text, "a"), None, "{text:?}");
        }
    }

    #[cfg(unix)]
    mod script {
        use std::process::Command;

        use super::*;

        fn run(script: &str, index: usize) -> Option<i32> {
            let mut command = Command::new("sh");
            command
                .args(["-c", script])
                .env("SLURM_ARRAY_TASK_ID", index.to_string())
                .env("SLURM_JOB_ID", "7");
            command.output().unwrap().status.code()
        }

        #[test]
        fn the_script_does_one_task_and_leaves_its_exit_code() {
            let folder = tempfile::tempdir().unwrap();
            let folder = folder.path();
            let fails =
                task("fails", &["sh", "-c", "echo 'it''s' \"$0\"; echo no >&2; exit 3", "a b$c"], folder);
            let killed = task("killed", &["sh", "-c", "kill -9 $$"], folder);
            let missing = task("missing", &["/no/such/program"], folder);
            let tasks = [fails, killed, missing];
            let submission = Submission::new(digest(&tasks, &[]));
            let array = SlurmArray { name: format!("{}-0", submission.run), job: None, tasks: vec![2, 1, 0] };
            let script = submission.script(folder, &array, &tasks).unwrap();
            let codes = [(0, 2, 127), (1, 1, 137), (2, 0, 3)];
            for (index, number, code) in codes {
                assert_eq!(submission.ended(folder, number, &tasks[number]), None);
                assert_eq!(run(&script, index), Some(0));
                let ended = submission.ended(folder, number, &tasks[number]).unwrap();
                assert_eq!(
                    (ended.id.as_str(), ended.end),
                    (tasks[number].id.as_str(), TaskEnd::Exited(code))
                );
            }
            assert_eq!(std::fs::read_to_string(&tasks[0].out).unwrap(), "its a b$c\nno\n");

            // One that is done again though it had ended does nothing, and one that is none says so.
            std::fs::write(&tasks[0].out, "as it was").unwrap();
            assert_eq!(run(&script, 2), Some(0));
            assert_eq!(std::fs::read_to_string(&tasks[0].out).unwrap(), "as it was");
            assert_eq!(run(&script, 3), Some(125));

            submission.remove_files(folder, tasks.len());
            assert_eq!(submission.ended(folder, 0, &tasks[0]), None);
        }

        #[test]
        fn a_task_that_is_ended_together_with_its_shell_has_not_ended() {
            let folder = tempfile::tempdir().unwrap();
            // The signal comes to the task first.
            let ends = ["sh", "-c", "(sleep 0.3; kill -TERM $PPID) & kill -TERM $$"];
            let tasks = [task("a", &ends, folder.path())];
            let submission = Submission::new(digest(&tasks, &[]));
            let array = SlurmArray { name: "n".to_string(), job: None, tasks: vec![0] };
            let script = submission.script(folder.path(), &array, &tasks).unwrap();
            assert_eq!(run(&script, 0), Some(125));
            assert_eq!(submission.ended(folder.path(), 0, &tasks[0]), None);
        }

        #[test]
        fn a_task_whose_output_cannot_be_written_has_not_ended() {
            let folder = tempfile::tempdir().unwrap();
            let nowhere =
                Task { out: folder.path().join("no/such/folder"), ..task("a", &["true"], folder.path()) };
            let tasks = [nowhere];
            let submission = Submission::new(digest(&tasks, &[]));
            let array = SlurmArray { name: "n".to_string(), job: None, tasks: vec![0] };
            let script = submission.script(folder.path(), &array, &tasks).unwrap();
            assert_ne!(run(&script, 0), Some(0));
            assert_eq!(submission.ended(folder.path(), 0, &tasks[0]), None);
        }
    }
}
