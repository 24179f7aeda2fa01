//! What a process takes of the computer, as the kernel accounts it.

use std::time::Duration;

use onboard::cli::Failure;
use sim::rt::monotonic_ns;

use crate::bench::samples::Sample;
use crate::bench::windows::Contender;
use crate::process::usage::{locked_mib, processor_s, resident_mib};

/// From one look to the next. The kernel counts processor time in hundredths of a second.
const LOOK: Duration = Duration::from_millis(500);

/// Resident memory of this process, mebibytes.
pub(super) struct Memory(pub(super) u32);

/// Processor time of this process, in hundredths of one core.
pub(super) struct Processor(pub(super) u32);

impl Contender for Memory {
    fn name(&self) -> String {
        "onboard".to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        for _ in 0..looks(length) {
            std::thread::sleep(LOOK.min(length));
            into.push(Sample::sometime(resident_mib(self.0).ok_or_else(ended)?));
        }
        Ok(())
    }
}

impl Contender for Processor {
    fn name(&self) -> String {
        "onboard".to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        let look = || Some((monotonic_ns(), processor_s(self.0)?));
        let (mut before_ns, mut before_s) = look().ok_or_else(ended)?;
        for _ in 0..looks(length) {
            std::thread::sleep(LOOK.min(length));
            let (now_ns, now_s) = look().ok_or_else(ended)?;
            let percent = 100.0 * (now_s - before_s) / ((now_ns - before_ns) as f64 * 1e-9);
            into.push(Sample::during(percent, before_ns, now_ns));
            (before_ns, before_s) = (now_ns, now_s);
        }
        Ok(())
    }
}

/// Whether what a process has stays in memory, in words: only then is what is resident all that it takes.
///
/// # Errors
/// [`Failure::Failed`] when the process has ended.
pub(super) fn note(pid: u32) -> Result<String, Failure> {
    let locked_mib = locked_mib(pid).ok_or_else(ended)?;
    Ok(if locked_mib > 0.0 {
        format!(
            "the robot's memory is locked, {locked_mib:.0} MiB of addresses, also those that it has never touched"
        )
    } else {
        "the robot's memory is not locked, so that more of it may be in use than is resident: grant CAP_IPC_LOCK".to_owned()
    })
}

/// How often is looked in a time, at least once.
fn looks(length: Duration) -> u32 {
    (length.as_secs_f64() / LOOK.as_secs_f64()).max(1.0) as u32
}

fn ended() -> Failure {
    Failure::failed("the robot has ended")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_that_runs_takes_something_and_one_that_there_is_not_is_said() {
        let own = std::process::id();
        let mut samples = Vec::new();
        let measured = [
            Memory(own).window(Duration::from_millis(5), &mut samples),
            Processor(own).window(Duration::from_millis(5), &mut samples),
        ];
        assert!(measured.iter().all(Result::is_ok), "{measured:?}");
        assert_eq!(samples.len(), 2);
        assert!(samples[0].value > 0.1 && samples[1].value >= 0.0);
        assert!(note(own).is_ok_and(|note| note.contains("memory is")));
        assert!(note(u32::MAX).is_err());
        let mut nobody = Memory(u32::MAX);
        assert!(
            nobody
                .window(Duration::from_millis(5), &mut samples)
                .is_err()
        );
        assert_eq!(
            (looks(Duration::from_secs(2)), looks(Duration::ZERO)),
            (4, 1)
        );
    }
}
