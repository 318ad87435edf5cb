//! A program and all that it has started, which are ended together: on Unix a process group, on Windows a job object.

use std::io;
use std::process::Child;

/// That of a child, for as long as nobody has waited for it: from then on its number may be another's.
#[derive(Debug)]
pub struct ProcessGroup(system::Handle);

impl ProcessGroup {
    /// On Unix the group that the child leads; on Windows a job that it is in from now on, with all that it starts. A child that cannot be taken
    /// into one is ended.
    ///
    /// # Errors
    /// If the system makes no job.
    pub fn of(child: &mut Child) -> io::Result<Self> {
        system::take(child).map(Self)
    }

    /// Ends all of it.
    pub fn kill(&mut self) {
        system::end(&mut self.0);
    }
}

#[cfg(unix)]
mod system {
    use std::io;
    use std::process::Child;

    use rustix::process::{Pid, Signal, kill_process_group};

    pub type Handle = Option<Pid>;

    #[expect(clippy::unnecessary_wraps, reason = "elsewhere the system may refuse")]
    pub fn take(child: &mut Child) -> io::Result<Handle> {
        Ok(i32::try_from(child.id()).ok().and_then(Pid::from_raw))
    }

    pub fn end(group: &mut Handle) {
        if let Some(leader) = group {
            // There may be nobody left in it.
            let _ = kill_process_group(*leader, Signal::KILL);
        }
    }
}

#[cfg(windows)]
mod system {
    use std::io;
    use std::os::windows::io::AsRawHandle;
    use std::process::Child;

    use win32job::{ExtendedLimitInfo, Job};

    /// What is in a job is ended by the system once the job is closed, also where that is since its owner is gone, however it went.
    pub type Handle = Option<Job>;

    pub fn take(child: &mut Child) -> io::Result<Handle> {
        let mut limits = ExtendedLimitInfo::new();
        limits.limit_kill_on_job_close();
        let job = Job::create_with_limit_info(&limits)
            .and_then(|job| job.assign_process(child.as_raw_handle() as isize).map(|()| job));
        if job.is_err() {
            // Nobody else would.
            let _ = child.kill();
        }
        job.map(Some).map_err(io::Error::other)
    }

    pub fn end(group: &mut Handle) {
        *group = None;
    }
}
