//! Slurm: arrays of jobs are submitted, the queue is asked, and what tasks leave on the shared disk is read.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process;
use std::thread;
use std::time::{Duration, Instant};

use super::error::EngineError;
use super::jobs::{self, Queue};
use super::submission::{SlurmArray, Submission, digest};
use super::task::{EndedTask, Engine, EngineEvent, Ledger, MOST_ATTEMPTS, Task, TaskEnd};

/// Tasks of an array: Slurm takes indices below `MaxArraySize`, which is 1001 unless a cluster says otherwise.
const LARGEST_ARRAY: usize = 1000;

/// How soon a wish to stop is heard.
const TICK: Duration = Duration::from_millis(100);

/// Between two looks at the queue: at first, and at most.
const POLLS: [Duration; 2] = [Duration::from_millis(500), Duration::from_secs(5)];

/// For so long the queue may be out of reach.
const LONGEST_SILENCE: Duration = Duration::from_secs(600);

/// In which cancelled jobs are to have left the queue.
const TIME_TO_CANCEL: Duration = Duration::from_secs(60);

/// What clients of NFS remember of folders, at most a minute by default, and half of that again.
pub(super) const SETTLE: Duration = Duration::from_secs(90);

/// Options that would make something else of the array than what is watched here.
const TAKEN: [&str; 9] = [
    "--array",
    "--clusters",
    "--job-name",
    "--no-requeue",
    "--parsable",
    "--test-only",
    "--wait",
    "--wrap",
    "--output",
];

/// The same as single letters.
const TAKEN_LETTERS: [&str; 5] = ["-a", "-M", "-J", "-W", "-o"];

/// The cluster whose clients are on PATH.
#[derive(Debug, Clone)]
pub struct Slurm {
    /// For what drivers and tasks note, on a disk that all machines share under this path. One call at a time uses it.
    pub folder: PathBuf,
    /// Passed on to `sbatch`, such as `--partition=long`.
    pub options: Vec<String>,
    /// For so long a shared disk may show late what a task has left.
    pub settle: Duration,
}

impl Slurm {
    fn check(&self, tasks: &[Task]) -> Result<(), EngineError> {
        let is_taken = |option: &&String| {
            let name = option.split('=').next().unwrap_or_default();
            // Slurm takes the beginning of a long option for the whole.
            TAKEN.iter().any(|taken| name.len() > 2 && taken.starts_with(name))
                || TAKEN_LETTERS.iter().any(|taken| option.starts_with(taken) && !option.starts_with("--"))
        };
        if let Some(option) = self.options.iter().find(is_taken) {
            return Err(EngineError::Refused(format!(
                "Slurm's option `{option}` is set by scenario-runner itself"
            )));
        }
        let bare = |option: &&String| !option.starts_with('-');
        if let Some(option) = self.options.iter().find(bare) {
            return Err(EngineError::Refused(format!(
                "`{option}` is no option of Slurm: write it in one word, as `--partition=long`"
            )));
        }
        match tasks.iter().find(|task| !task.resources.is_empty()) {
            Some(task) => Err(EngineError::Refused(format!(
                "the task `{}` takes resources, which Slurm calls by its own names: pass them on, as `--gres=av_stack:1` or `--licenses=av_stack:1`",
                task.id
            ))),
            None => Ok(()),
        }
    }
}

impl Engine for Slurm {
    fn run(
        &self,
        tasks: &[Task],
        stop: &dyn Fn() -> bool,
        told: &mut dyn FnMut(EngineEvent),
    ) -> Result<Vec<EndedTask>, EngineError> {
        let ledger = Ledger::new(tasks)?;
        self.check(tasks)?;
        let version = jobs::version()?;
        files::make_folder(&self.folder).map_err(|error| EngineError::file(&self.folder, error))?;
        let folder =
            std::path::absolute(&self.folder).map_err(|error| EngineError::file(&self.folder, error))?;
        told(EngineEvent::Ready(version));
        let asked = digest(tasks, &self.options);
        let submission = begin(&folder, asked, told)?;
        let mut watch = Watch { slurm: self, folder: &folder, tasks, submission, ledger, silent_since: None };
        match watch.until_all_ended(stop, told) {
            Ok(()) => {
                watch.close()?;
                watch.ledger.finish()
            }
            Err(error) => {
                watch.cancel()?;
                watch.close()?;
                Err(error)
            }
        }
    }
}

/// The submission of a driver that was ended before it was over, if it is of the same tasks; otherwise a new one.
fn begin(folder: &Path, asked: String, told: &mut dyn FnMut(EngineEvent)) -> Result<Submission, EngineError> {
    let Some(mut earlier) = Submission::read(folder)?.filter(|earlier| !earlier.is_over) else {
        return Ok(Submission::new(asked));
    };
    for array in earlier.arrays.iter_mut().filter(|array| array.job.is_none()) {
        array.job = jobs::named(&array.name)?;
    }
    // What has no number and is not in the queue was never submitted, or has left what it came to.
    earlier.arrays.retain(|array| array.job.is_some());
    if earlier.asked == asked {
        let jobs = earlier.jobs().join(", ");
        told(EngineEvent::Notice(format!("goes on with what an earlier driver submitted: job {jobs}")));
        return Ok(earlier);
    }
    let queue = jobs::queue(&earlier.jobs())?.map_err(EngineError::Failed)?;
    match queue.is_empty() {
        true => Ok(Submission::new(asked)),
        false => Err(EngineError::Refused(format!(
            "other tasks of an earlier driver go on with {}: wait for them, or end them with `scancel {}`",
            folder.display(),
            earlier.jobs().join(" ")
        ))),
    }
}

/// The tasks of one call while they are done.
struct Watch<'a> {
    slurm: &'a Slurm,
    folder: &'a Path,
    tasks: &'a [Task],
    submission: Submission,
    ledger: Ledger<'a>,
    /// Since when the queue could not be read.
    silent_since: Option<Instant>,
}

impl Watch<'_> {
    fn until_all_ended(
        &mut self,
        stop: &dyn Fn() -> bool,
        told: &mut dyn FnMut(EngineEvent),
    ) -> Result<(), EngineError> {
        // Since when each that has not ended is not in the queue.
        let mut open: BTreeMap<usize, Option<Instant>> =
            (0..self.tasks.len()).map(|number| (number, None)).collect();
        let mut said = (EngineEvent::Standing { waiting: 0, running: 0 }, BTreeSet::new());
        let mut pause = POLLS[0];
        self.take_ended(&mut open, told)?;
        loop {
            let new: Vec<usize> =
                open.keys().copied().filter(|number| self.submission.attempts(*number) == 0).collect();
            self.submit(&new, stop)?;
            // The queue first: what left it before has left on the disk what it came to.
            let queue = self.queue()?;
            self.take_ended(&mut open, told)?;
            if self.ledger.is_complete() {
                return Ok(());
            }
            if let Some(queue) = queue {
                tell_standing(&queue, &mut said, told);
                let lost = self.lost(&queue, &mut open);
                self.again(&lost, &mut open, stop, told)?;
            }
            wait(pause, stop)?;
            pause = (pause * 5 / 4).min(POLLS[1]);
        }
    }

    /// What is in the queue, unless that cannot be known now.
    fn queue(&mut self) -> Result<Option<Queue>, EngineError> {
        match jobs::queue(&self.submission.jobs())? {
            Ok(queue) => {
                self.silent_since = None;
                Ok(Some(queue))
            }
            Err(why) => {
                let since = *self.silent_since.get_or_insert_with(Instant::now);
                match since.elapsed() > LONGEST_SILENCE {
                    true => Err(EngineError::Failed(format!(
                        "`squeue` could not be asked for {} minutes: {why}",
                        LONGEST_SILENCE.as_secs() / 60
                    ))),
                    false => Ok(None),
                }
            }
        }
    }

    /// Tells of those that have ended.
    fn take_ended(
        &mut self,
        open: &mut BTreeMap<usize, Option<Instant>>,
        told: &mut dyn FnMut(EngineEvent),
    ) -> Result<(), EngineError> {
        let numbers: Vec<usize> = open.keys().copied().collect();
        for number in numbers {
            if let Some(ended) = self.submission.ended(self.folder, number, &self.tasks[number]) {
                open.remove(&number);
                told(EngineEvent::Ended(self.ledger.note(ended)?.clone()));
            }
        }
        Ok(())
    }

    /// Those that have neither ended nor been in the queue for as long as a disk may show late what they left.
    fn lost(&self, queue: &Queue, open: &mut BTreeMap<usize, Option<Instant>>) -> Vec<usize> {
        let mut lost = Vec::new();
        for (number, absent) in open {
            let is_there =
                self.submission.last_place(*number).is_some_and(|place| queue.contains_key(&place));
            if is_there {
                *absent = None;
            } else if absent.get_or_insert_with(Instant::now).elapsed() >= self.slurm.settle {
                lost.push(*number);
            }
        }
        lost
    }

    /// Submits those again, unless they were lost too often.
    fn again(
        &mut self,
        lost: &[usize],
        open: &mut BTreeMap<usize, Option<Instant>>,
        stop: &dyn Fn() -> bool,
        told: &mut dyn FnMut(EngineEvent),
    ) -> Result<(), EngineError> {
        let (given_up, again): (Vec<usize>, Vec<usize>) =
            lost.iter().partition(|number| self.submission.attempts(**number) >= MOST_ATTEMPTS);
        for number in given_up {
            open.remove(&number);
            let task = &self.tasks[number];
            let why = format!(
                "it left the queue {MOST_ATTEMPTS} times without an exit code; see {} and {}",
                self.submission.log(self.folder).display(),
                task.out.display()
            );
            let ended =
                EndedTask { id: task.id.clone(), end: TaskEnd::Lost(why), node: String::new(), seconds: 0.0 };
            told(EngineEvent::Ended(self.ledger.note(ended)?.clone()));
        }
        for number in &again {
            open.insert(*number, None);
            let id = &self.tasks[*number].id;
            told(EngineEvent::Notice(format!(
                "the task `{id}` left the queue without an exit code: submitted again"
            )));
        }
        self.submit(&again, stop)
    }

    /// Submits those tasks, in arrays of equals.
    fn submit(&mut self, numbers: &[usize], stop: &dyn Fn() -> bool) -> Result<(), EngineError> {
        let mut of_cpus: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for number in numbers {
            of_cpus.entry(self.tasks[*number].cpus).or_default().push(*number);
        }
        for (cpus, numbers) in of_cpus {
            for chunk in numbers.chunks(LARGEST_ARRAY) {
                if stop() {
                    return Err(EngineError::Stopped);
                }
                self.submit_array(cpus, chunk.to_vec())?;
            }
        }
        Ok(())
    }

    fn submit_array(&mut self, cpus: u32, numbers: Vec<usize>) -> Result<(), EngineError> {
        // No driver that went on with it has had the same.
        let name = format!("{}-{}-{}", self.submission.run, self.submission.arrays.len(), process::id());
        let indices = format!("--array=0-{}", numbers.len() - 1);
        let array = SlurmArray { name: name.clone(), job: None, tasks: numbers };
        let script = self.submission.script(self.folder, &array, self.tasks)?;
        // Noted before it is there, so that nothing is ever there that is not noted.
        self.submission.arrays.push(array);
        self.submission.write(self.folder)?;
        let name = format!("--job-name={name}");
        let cpus = format!("--cpus-per-task={cpus}");
        let log = format!("--output={}", self.submission.log(self.folder).display());
        let mut arguments =
            vec!["--parsable", "--requeue", &name, &indices, &cpus, &log, "--open-mode=append"];
        arguments.extend(self.slurm.options.iter().map(String::as_str));
        arguments.extend(["--wrap", &script]);
        let job = jobs::submit(&arguments)?;
        if let Some(array) = self.submission.arrays.last_mut() {
            array.job = Some(job);
        }
        self.submission.write(self.folder)
    }

    /// Takes all of it out of the queue.
    fn cancel(&mut self) -> Result<(), EngineError> {
        for array in self.submission.arrays.iter_mut().filter(|array| array.job.is_none()) {
            array.job = jobs::named(&array.name)?;
        }
        let all = self.submission.jobs();
        let may_go_on = |why: String| {
            EngineError::Failed(format!("it may go on ({why}): end it with `scancel {}`", all.join(" ")))
        };
        let until = Instant::now() + TIME_TO_CANCEL;
        loop {
            let queue = jobs::queue(&all)?.map_err(may_go_on)?;
            // What is completing is being ended by Slurm.
            let there: BTreeSet<&str> = queue
                .iter()
                .filter(|(_, queued)| queued.state != "CG")
                .filter_map(|(place, _)| Some(place.split_once('_')?.0))
                .collect();
            if there.is_empty() {
                return Ok(());
            }
            if Instant::now() >= until {
                return Err(may_go_on("it stays in the queue".to_string()));
            }
            jobs::cancel(&there.into_iter().collect::<Vec<_>>())?.map_err(may_go_on)?;
            thread::sleep(POLLS[0]);
        }
    }

    /// Notes that nobody is to go on with it.
    fn close(&mut self) -> Result<(), EngineError> {
        self.submission.is_over = true;
        self.submission.write(self.folder)?;
        self.submission.remove_files(self.folder, self.tasks.len());
        Ok(())
    }
}

/// Says how the queue stands where that has changed, and what is held there, once.
fn tell_standing(
    queue: &Queue,
    said: &mut (EngineEvent, BTreeSet<String>),
    told: &mut dyn FnMut(EngineEvent),
) {
    let waiting = queue.values().filter(|queued| queued.state == "PD").count();
    let standing = EngineEvent::Standing { waiting, running: queue.len() - waiting };
    if said.0 != standing {
        said.0 = standing.clone();
        told(standing);
    }
    for (place, queued) in queue.iter().filter(|(_, queued)| queued.reason.to_lowercase().contains("held")) {
        let job = place.split('_').next().unwrap_or_default().to_string();
        if said.1.insert(job.clone()) {
            let reason = &queued.reason;
            told(EngineEvent::Notice(format!(
                "job {job} is held ({reason}) until somebody says `scontrol release {job}`"
            )));
        }
    }
}

fn wait(pause: Duration, stop: &dyn Fn() -> bool) -> Result<(), EngineError> {
    let until = Instant::now() + pause;
    loop {
        if stop() {
            return Err(EngineError::Stopped);
        }
        match until.saturating_duration_since(Instant::now()) {
            Duration::ZERO => return Ok(()),
            left => thread::sleep(left.min(TICK)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(option: &str) -> Slurm {
        Slurm { folder: "/shared/engine".into(), options: vec![option.to_string()], settle: SETTLE }
    }

    #[test]
    fn options_that_would_change_what_is_watched_are_refused() {
        for option in [
            "--array=0-3",
            "--arr=0-3",
            "-a0-3",
            "--wait",
            "-W",
            "--wrap=true",
            "--test-only",
            "-Mother",
            "--no-requeue",
            "long",
        ] {
            assert!(with(option).check(&[]).is_err(), "{option}");
        }
        for option in
            ["--partition=long", "--time=00:30:00", "-plong", "--mem=2G", "--gres=av_stack:1", "--account=a"]
        {
            with(option).check(&[]).unwrap_or_else(|error| panic!("{option}: {error}"));
        }
    }

    #[test]
    fn resources_are_slurm_s_own() {
        let resources = BTreeMap::from([("av_stack".to_string(), 1.0)]);
        let task = Task {
            id: "a".to_string(),
            argv: vec!["x".to_string()],
            out: PathBuf::new(),
            cpus: 1,
            resources,
        };
        let error = with("--time=5").check(&[task]).unwrap_err();
        assert!(error.to_string().contains("--gres=av_stack:1"), "{error}");
    }
}
