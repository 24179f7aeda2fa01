//! How soon a mediator answers when nothing is in its way: from a robot's request to the grant of a free area, and from a robot's flag to
//! the command that a net has been waiting to give. It has no rival.
//!
//! The mediator is the real program, with its journal on disk, and hears two robots without wheels over zenoh on the loopback. The fast one
//! goes round, and each time the shipped net lets it overtake the slow one, which stays in area 1. So every lap has requests of free areas,
//! and all flags and commands of that net.

mod clocks;
mod floor;
mod robot;
mod wire;

use std::time::Duration;

use onboard::cli::Failure;

use self::floor::Floor;
use super::promises::{Figure, Most, Promise};
use super::report::{PartReport, Unit, What};
use super::samples::Sample;
use super::windows::{Contender, Meter};

/// Measures for so long.
///
/// # Errors
/// [`Failure`] when the mediator does not run, or nobody overtakes.
pub fn measure(meter: &Meter, time: Duration, part: &mut PartReport) -> Result<(), Failure> {
    let mut floor = Floor::start()?;
    floor.warm_up(meter.asked_to_end)?;
    let promises = [Promise(Figure::P99, Most::Value(1.0))];
    let what = What::new("request of a robot to its grant", Unit::Ms).promising(&promises);
    meter.alone(part, &what, time / 2, Grants(&mut floor))?;
    let promises = [Promise(Figure::P99, Most::Value(2.0))];
    let what = What::new("flag of a robot to the command", Unit::Ms).promising(&promises);
    meter.alone(part, &what, time / 2, Commands(&mut floor))
}

/// From requests to grants.
struct Grants<'a>(&'a mut Floor);

/// From flags to commands.
struct Commands<'a>(&'a mut Floor);

impl Contender for Grants<'_> {
    fn name(&self) -> String {
        "mediator".to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        self.0.run(length, |clocks| !clocks.grants.is_empty())?;
        into.append(&mut self.0.clocks.grants);
        Ok(())
    }
}

impl Contender for Commands<'_> {
    fn name(&self) -> String {
        "mediator".to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        self.0.run(length, |clocks| !clocks.commands.is_empty())?;
        into.append(&mut self.0.clocks.commands);
        Ok(())
    }
}
