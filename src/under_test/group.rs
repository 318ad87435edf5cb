//! A program and all that it has started, which are ended together: on Unix a process group, on Windows a job object.

pub use system::Group;

#[cfg(unix)]
mod system {
    use std::io;
    use std::process::Child;

    use rustix::process::{Pid, Signal, kill_process_group};

    /// The group that a child leads.
    #[derive(Debug)]
    pub struct Group(Option<Pid>);

    impl Group {
        /// That of a child that leads one, for as long as nobody has waited for it: from then on its number may be another's.
        pub fn of(child: &mut Child) -> io::Result<Self> {
            Ok(Self(i32::try_from(child.id()).ok().and_then(Pid::from_raw)))
        }

        /// Ends all of it.
        pub fn kill(&mut self) {
            if let Some(leader) = self.0 {
                // There may be nobody left in it.
                let _ = kill_process_group(leader, Signal::KILL);
            }
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
    #[derive(Debug)]
    pub struct Group(Option<Job>);

    impl Group {
        /// The child from now on, with all that it starts. A child that cannot be taken into one is ended.
        ///
        /// # Errors
        /// If the system makes no job.
        pub fn of(child: &mut Child) -> io::Result<Self> {
            let mut limits = ExtendedLimitInfo::new();
            limits.limit_kill_on_job_close();
            let job = Job::create_with_limit_info(&limits)
                .and_then(|job| job.assign_process(child.as_raw_handle() as isize).map(|()| job));
            if job.is_err() {
                // Nobody else would.
                let _ = child.kill();
            }
            Ok(Self(Some(job.map_err(io::Error::other)?)))
        }

        /// Ends all of it.
        pub fn kill(&mut self) {
            self.0 = None;
        }
    }
}
