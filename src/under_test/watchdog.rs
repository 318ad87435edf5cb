//! One thread that ends programs past their deadline, and with a program all that it has started.

use std::io;
use std::process::{Child, ExitStatus};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread;
use std::time::{Duration, Instant};

use super::process_group::ProcessGroup;

/// How often deadlines are checked. A deadline is wall time, of which nothing depends but whether there is a fault.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);

/// A child with a deadline.
#[derive(Debug)]
pub struct Watched {
    child: Mutex<WatchedChild>,
    deadline: Mutex<Option<Instant>>,
    expired: AtomicBool,
}

/// A child, and how it ended once somebody has waited for it: from then on its number may be another's.
#[derive(Debug)]
struct WatchedChild {
    child: Child,
    group: ProcessGroup,
    ended: Option<ExitStatus>,
}

/// Watches children, as long as it is there.
#[derive(Debug, Default)]
pub struct Watchdog {
    children: Arc<Mutex<Vec<Weak<Watched>>>>,
    runs: Mutex<bool>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Watchdog {
    /// Watches a child from now on, which leads a group of its own.
    pub fn watch(&self, mut child: Child) -> io::Result<Arc<Watched>> {
        let group = ProcessGroup::of(&mut child)?;
        let watched = Arc::new(Watched {
            child: Mutex::new(WatchedChild { child, group, ended: None }),
            deadline: Mutex::new(None),
            expired: AtomicBool::new(false),
        });
        lock(&self.children).push(Arc::downgrade(&watched));
        let mut runs = lock(&self.runs);
        if !*runs {
            let children = Arc::downgrade(&self.children);
            let check = move || {
                while let Some(children) = children.upgrade() {
                    let all: Vec<Arc<Watched>> = {
                        let mut all = lock(&children);
                        all.retain(|child| child.strong_count() > 0);
                        all.iter().filter_map(Weak::upgrade).collect()
                    };
                    all.iter().for_each(|child| child.check());
                    drop((all, children));
                    thread::sleep(CHECK_INTERVAL);
                }
            };
            if let Err(error) = thread::Builder::new().name("watchdog".into()).spawn(check) {
                watched.kill();
                return Err(error);
            }
            *runs = true;
        }
        Ok(watched)
    }
}

impl Watched {
    /// It is to have answered until then; without one it may take its time.
    pub fn set_deadline(&self, deadline: Option<Instant>) {
        *lock(&self.deadline) = deadline;
    }

    /// Whether it was ended since it did not answer in time.
    pub fn has_expired(&self) -> bool {
        self.expired.load(Ordering::Acquire)
    }

    fn check(&self) {
        let Some(deadline) = *lock(&self.deadline) else { return };
        if Instant::now() >= deadline {
            self.expired.store(true, Ordering::Release);
            self.kill();
        } else if lock(&self.child).has_ended() {
            // What it has started may still hold its pipes.
            self.kill();
        }
    }

    /// Ends it and all of its group.
    pub fn kill(&self) {
        lock(&self.child).kill();
    }

    /// How it ended, once it has, if that is within `time`. What it has started and is still there is ended.
    pub fn wait(&self, time: Duration) -> Option<ExitStatus> {
        let until = Instant::now() + time;
        loop {
            let mut child = lock(&self.child);
            if child.has_ended() {
                return child.end_and_wait();
            }
            drop(child);
            if Instant::now() >= until {
                return None;
            }
            thread::sleep(Duration::from_millis(2));
        }
    }

    /// Ends it if it is still there, so that nothing of it stays.
    pub fn end_and_wait(&self) -> Option<ExitStatus> {
        lock(&self.child).end_and_wait()
    }
}

impl WatchedChild {
    fn has_ended(&mut self) -> bool {
        self.ended.is_some() || has_ended(&mut self.child)
    }

    fn kill(&mut self) {
        if self.ended.is_none() {
            self.group.kill();
            // It may be gone already.
            let _ = self.child.kill();
        }
    }

    fn end_and_wait(&mut self) -> Option<ExitStatus> {
        self.kill();
        if self.ended.is_none() {
            self.ended = self.child.wait().ok();
        }
        self.ended
    }
}

/// Whether the leader has ended; it keeps its number, which is that of its group, until somebody waits for it.
#[cfg(unix)]
fn has_ended(child: &mut Child) -> bool {
    use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
    let Some(id) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) else { return true };
    let look = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    !matches!(waitid(WaitId::Pid(id), look), Ok(None))
}

#[cfg(not(unix))]
fn has_ended(child: &mut Child) -> bool {
    !matches!(child.try_wait(), Ok(None))
}
