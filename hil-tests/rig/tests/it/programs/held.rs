//! A thread of a robot is kept from its work.

use std::fs;
use std::time::{Duration, Instant};

use nix::libc;
use nix::sys::ptrace;
use nix::sys::wait::{WaitPidFlag, WaitStatus, waitpid};
use nix::unistd::Pid;

/// A thread that does not run, while the others of its process do.
pub struct HeldThread(Pid);

impl HeldThread {
    /// The thread of this name, wherever it is; until this is dropped.
    pub fn of(process: u32, name: &str) -> Self {
        let tasks = fs::read_dir(format!("/proc/{process}/task")).expect("it runs");
        let is_it = |task: &fs::DirEntry| {
            let comm = fs::read_to_string(task.path().join("comm"));
            comm.is_ok_and(|comm| comm.trim() == name)
        };
        let task = { tasks.flatten() }.find(is_it);
        let number = task.expect("it has such a thread").file_name();
        let thread = Pid::from_raw(number.to_string_lossy().parse().expect("a number"));
        ptrace::seize(thread, ptrace::Options::empty()).expect("ours");
        let held = Self(thread);
        ptrace::interrupt(held.0).expect("it runs");
        waitpid(held.0, Some(WaitPidFlag::__WALL)).expect("it stops");
        held
    }

    /// The same where it opens a file next, as if the disk would not answer. It waits for that.
    pub fn at_its_disk(process: u32, name: &str) -> Self {
        const PATIENCE: Duration = Duration::from_secs(20);
        let held = Self::of(process, name);
        let began = Instant::now();
        loop {
            ptrace::syscall(held.0, None).expect("it stands still");
            while waitpid(held.0, Some(WaitPidFlag::__WALL | WaitPidFlag::WNOHANG))
                .expect("it stops")
                == WaitStatus::StillAlive
            {
                assert!(began.elapsed() < PATIENCE, "{name} opens no file");
                std::thread::sleep(Duration::from_millis(1));
            }
            let call = fs::read_to_string(format!("/proc/{process}/task/{}/syscall", held.0));
            let call = call.expect("it stands still");
            if call.split(' ').next() == Some(&libc::SYS_openat.to_string()) {
                return held;
            }
        }
    }
}

impl Drop for HeldThread {
    /// A process whose thread is held cannot be waited for.
    fn drop(&mut self) {
        let _ = ptrace::detach(self.0, None);
    }
}
