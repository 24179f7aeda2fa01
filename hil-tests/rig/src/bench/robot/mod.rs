//! A whole robot, the real program on simulated devices: how soon it drives, how soon a scan reaches the wheels, and what all of it takes of
//! the computer. It has no rival.

mod chase;
mod eyes;
mod running;
mod starts;
mod usage;
mod wheel;

use std::cell::Cell;
use std::time::Duration;

use onboard::cli::Failure;

use self::running::Running;
use self::starts::Starts;
use self::usage::{Memory, Processor};
use self::wheel::ScanToWheel;
use super::place::{Place, last_core};
use super::promises::{Figure, Most, Promise};
use super::report::{PartReport, Unit, What};
use super::windows::Meter;
use crate::scenario::{Changes, load_shipped};

/// One robot on a floor without a mediator.
const SCENARIO: &str = "lap";

/// Priority of who watches the robot: above its own and its devices' threads.
const WATCHES: u8 = 95;

/// Measures for so long, and at least one start.
///
/// # Errors
/// [`Failure`] when the robot does not start or ends.
pub fn measure(meter: &Meter, time: Duration, part: &mut PartReport) -> Result<(), Failure> {
    let scenario = load_shipped(SCENARIO, &Changes::default())?;
    let promises = [Promise(Figure::Max, Most::Value(3.0))];
    let what = What::new("start of a robot to its first setpoint", Unit::S).promising(&promises);
    meter.alone(part, &what, time / 4, Starts(&scenario))?;
    if meter.is_over() {
        return Ok(());
    }
    let program = std::env::current_exe().map_err(Failure::refused)?;
    part.notes.push(running::note(&program));
    let robot = Running::start(&scenario)?;
    let missed = Cell::new(0);
    let promises = [Promise(Figure::P99, Most::Value(8.0))];
    let what = What::new("last byte of a scan to its setpoint", Unit::Ms).promising(&promises);
    let (place, without) = Place::wanted(WATCHES, last_core());
    part.notes.extend(without);
    let wheel = ScanToWheel::new(robot.eyes()?, place, &missed);
    meter.alone(part, &what, time / 2, wheel)?;
    if missed.get() > 0 {
        let missed = missed.get();
        let note = format!("of {missed} scans the setpoint was not seen before the next scan");
        part.notes.push(note);
    }
    let promises = [Promise(Figure::Max, Most::Value(40.0))];
    let what = What::new("resident memory of a robot that drives", Unit::MiB).promising(&promises);
    meter.alone(part, &what, time / 8, Memory(robot.id()))?;
    part.notes.push(usage::note(robot.id())?);
    let promises = [Promise(Figure::P50, Most::Value(10.0))];
    let what = What::new("processor time of a robot that drives", Unit::Percent);
    let what = what.promising(&promises);
    meter.alone(part, &what, time / 8, Processor(robot.id()))
}
