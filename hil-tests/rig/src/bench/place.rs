//! Cores and priorities of the threads that measure: alike for ours and for rivals.

use onboard::cli::Failure;
use onboard::realtime::scheduling::{CoreClass, Wanted, promote, try_out};
use rustix::thread::{CpuSet, sched_getaffinity};

/// How a measuring thread runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Of `SCHED_FIFO`; none for the normal policy.
    pub priority: Option<u8>,
    /// The core that it is bound to.
    pub core: usize,
}

impl Place {
    /// With this priority where it is granted; else without any, and a sentence that says what to grant.
    #[must_use]
    pub fn wanted(priority: u8, core: usize) -> (Self, Option<String>) {
        let wanted = Self {
            priority: Some(priority),
            core,
        };
        match try_out(&wanted.as_wanted()) {
            Ok(()) => (wanted, None),
            Err(why) => {
                let priority = None;
                (Self { priority, core }, Some(why))
            }
        }
    }

    /// Puts the calling thread there.
    ///
    /// # Errors
    /// [`Failure::Refused`] with what to grant.
    pub fn take(&self) -> Result<(), Failure> {
        let warnings = promote(&self.as_wanted());
        match warnings.is_empty() {
            true => Ok(()),
            false => Err(Failure::refused(warnings.join("; "))),
        }
    }

    fn as_wanted(self) -> Wanted {
        Wanted {
            fifo_priority: self.priority,
            cores: CoreClass::Number(self.core),
        }
    }
}

/// Numbers of the cores that this program may use, ascending; the first alone where the system does not tell.
#[must_use]
pub fn cores() -> Vec<usize> {
    let set = sched_getaffinity(None).unwrap_or_default();
    let cores: Vec<usize> = (0..CpuSet::MAX_CPU)
        .filter(|core| set.is_set(*core))
        .collect();
    if cores.is_empty() { vec![0] } else { cores }
}

/// The last of the cores: the first often has the machine's interrupts.
#[must_use]
pub fn last_core() -> usize {
    cores().last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_gets_its_core_and_priority_only_where_granted() {
        let core = last_core();
        let (place, why) = Place::wanted(10, core);
        assert_eq!(place.priority.is_none(), why.is_some());
        assert_eq!(place.core, core);
        let taken = std::thread::spawn(move || {
            let taken = place.take().is_ok();
            (taken, cores())
        });
        assert_eq!(taken.join().expect("it ends"), (true, vec![core]));
    }
}
