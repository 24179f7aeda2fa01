//! SOEM, the Simple Open EtherCAT Master, as pysoem carries it: its own functions in C, called from Python.

use std::cell::Cell;
use std::process::Command;
use std::rc::Rc;
use std::time::Duration;

use onboard::cli::Failure;
use onboard::realtime::latency::keep_cores_awake;

use super::ours::DEADLINE;
use crate::bench::cycle::Cycle;
use crate::bench::samples::Sample;
use crate::bench::windows::Contender;
use crate::interfaces::said;

const SCRIPT: &str = include_str!("soem.py");
/// Names another Python than `python3`.
const PYTHON: &str = "RIG_PYTHON";

/// One Python for each window.
pub(super) struct Soem {
    python: String,
    cycle: Cycle,
    interface: String,
    /// What Python takes of each of its exchanges, nanoseconds, once it has measured that.
    pub(super) python_ns: Rc<Cell<Option<u64>>>,
}

impl Soem {
    /// Looks for pysoem.
    ///
    /// # Errors
    /// What to install.
    pub(super) fn find(cycle: Cycle, interface: &str) -> Result<Self, String> {
        let python = std::env::var(PYTHON).unwrap_or_else(|_| "python3".to_owned());
        let import = said(Command::new(&python).args(["-c", "import pysoem"]));
        import.map_err(|why| {
            format!(
                "SOEM is left out: {python} has no pysoem ({why}); pip install pysoem==1.1.13, and {PYTHON} names another Python"
            )
        })?;
        Ok(Self {
            python,
            cycle,
            interface: interface.to_owned(),
            python_ns: Rc::default(),
        })
    }
}

impl Contender for Soem {
    fn name(&self) -> String {
        "SOEM, called from Python".to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        let place = self.cycle.place;
        let mut command = Command::new(&self.python);
        command
            .args(["-c", SCRIPT, &self.interface])
            .arg(length.as_nanos().to_string())
            .arg(self.cycle.period.as_nanos().to_string())
            .arg(DEADLINE.as_micros().to_string())
            .arg(place.priority.unwrap_or(0).to_string())
            .arg(place.core.to_string());
        // As ours has it.
        let _awake = keep_cores_awake();
        let output = said(&mut command).map_err(Failure::failed)?;
        let said = String::from_utf8_lossy(&output.stdout);
        self.python_ns
            .set(said.lines().next().and_then(|first| first.parse().ok()));
        into.extend(samples(&said));
        Ok(())
    }
}

/// Each line of two numbers says when an exchange began and ended.
fn samples(text: &str) -> impl Iterator<Item = Sample> {
    text.lines().filter_map(|line| {
        let (began_ns, ended_ns) = line.split_once(' ')?;
        Some(Sample::from_to(
            began_ns.parse().ok()?,
            ended_ns.parse().ok()?,
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_two_times_are_samples() {
        let read: Vec<Sample> = samples("90\n100 150\nnothing\n200 290\n").collect();
        assert_eq!(read, [Sample::from_to(100, 150), Sample::from_to(200, 290)]);
    }
}
