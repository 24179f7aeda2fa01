//! How soon a robot drives: from the start of its process to the first frame that turns its wheels' motors on.

use std::time::Duration;

use onboard::cli::Failure;

use super::running::Running;
use crate::bench::samples::Sample;
use crate::bench::windows::Contender;
use crate::scenario::Scenario;

/// Starts it again and again, each time where the site says.
pub(super) struct Starts<'a>(pub(super) &'a Scenario);

impl Contender for Starts<'_> {
    fn name(&self) -> String {
        "onboard".to_owned()
    }

    /// One start, however long it takes.
    fn window(&mut self, _length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        let (began_ns, ended_ns) = Running::start(self.0)?.started_ns;
        into.push(Sample::from_to(began_ns, ended_ns));
        Ok(())
    }
}
