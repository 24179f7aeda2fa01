//! Memory and processor time of a process, as the kernel accounts them.

use std::fs;
use std::time::{Duration, Instant};

/// Lines of `/proc/PID/status` (proc_pid_status(5)).
const RESIDENT: &str = "VmRSS:";
const LOCKED: &str = "VmLck:";

/// How often the memory is measured.
const PERIOD: Duration = Duration::from_millis(500);

/// Measures one process.
#[derive(Debug)]
pub struct Usage {
    pid: u32,
    began: Instant,
    looked: Option<Instant>,
    largest_rss_kib: u64,
    cpu_s: f64,
    elapsed_s: f64,
}

impl Usage {
    /// Starts to measure.
    #[must_use]
    pub fn of(pid: u32) -> Self {
        Self {
            pid,
            began: Instant::now(),
            looked: None,
            largest_rss_kib: 0,
            cpu_s: 0.0,
            elapsed_s: 0.0,
        }
    }

    /// Measures, if a period has passed. A process that has ended keeps its last figures.
    pub fn look(&mut self) {
        if self.looked.is_some_and(|looked| looked.elapsed() < PERIOD) {
            return;
        }
        self.looked = Some(Instant::now());
        let read = |file: &str| {
            fs::read_to_string(format!("/proc/{}/{file}", self.pid)).unwrap_or_default()
        };
        if let Some(rss_kib) = kib(&read("status"), RESIDENT) {
            self.largest_rss_kib = self.largest_rss_kib.max(rss_kib);
        }
        if let Some(ticks) = processor_ticks(&read("stat")) {
            self.cpu_s = seconds(ticks);
            self.elapsed_s = self.began.elapsed().as_secs_f64();
        }
    }

    /// Largest resident memory seen.
    #[must_use]
    pub fn largest_rss_mib(&self) -> f64 {
        self.largest_rss_kib as f64 / 1024.0
    }

    /// Share of one core since the beginning.
    #[must_use]
    pub fn cpu_percent(&self) -> f64 {
        if self.elapsed_s > 0.0 {
            100.0 * self.cpu_s / self.elapsed_s
        } else {
            0.0
        }
    }
}

/// Resident memory of a process now.
#[must_use]
pub fn resident_mib(pid: u32) -> Option<f64> {
    memory_mib(pid, RESIDENT)
}

/// How much of its address space a process has locked: all that is resident there stays.
#[must_use]
pub fn locked_mib(pid: u32) -> Option<f64> {
    memory_mib(pid, LOCKED)
}

fn memory_mib(pid: u32, what: &str) -> Option<f64> {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    Some(kib(&status, what)? as f64 / 1024.0)
}

/// Processor time that a process has had by now, seconds.
#[must_use]
pub fn processor_s(pid: u32) -> Option<f64> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    Some(seconds(processor_ticks(&stat)?))
}

fn seconds(ticks: u64) -> f64 {
    ticks as f64 / rustix::param::clock_ticks_per_second() as f64
}

fn kib(status: &str, what: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(what))?;
    line.split_whitespace().next()?.parse().ok()
}

/// User and system time: fields 14 and 15, counted behind the name in parentheses, which may hold spaces.
fn processor_ticks(stat: &str) -> Option<u64> {
    let fields: Vec<&str> = stat[stat.rfind(')')? + 1..].split_whitespace().collect();
    Some(fields.get(11)?.parse::<u64>().ok()? + fields.get(12)?.parse::<u64>().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernels_formats_are_read() {
        let status = "Name:\tx\nVmLck:\t 4096 kB\nVmRSS:\t   2048 kB\n";
        assert_eq!(kib(status, RESIDENT), Some(2048));
        assert_eq!(kib(status, LOCKED), Some(4096));
        assert_eq!(kib("Name:\tx\n", LOCKED), None);
        let stat = "12 (a b) c) S 1 2 3 4 5 6 7 8 9 10 30 12 0 0";
        assert_eq!(processor_ticks(stat), Some(42));
        assert_eq!(processor_ticks("nothing"), None);
    }

    #[test]
    fn this_process_uses_memory() {
        let mut usage = Usage::of(std::process::id());
        usage.look();
        assert!(usage.largest_rss_mib() > 0.1);
        assert!(resident_mib(std::process::id()).is_some_and(|now_mib| now_mib > 0.1));
        assert!(locked_mib(std::process::id()).is_some());
        assert!(processor_s(std::process::id()).is_some_and(|now_s| now_s >= 0.0));
    }
}
