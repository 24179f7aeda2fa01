//! How late a thread wakes up that sleeps until absolute times: ours, beside `cyclictest` with the same period, priority and core, while
//! the machine has nothing else to do and under load.

mod cyclictest;
mod ours;

use std::time::Duration;

use onboard::cli::Failure;

use self::cyclictest::Cyclictest;
use self::ours::Ours;
use super::cycle::Cycle;
use super::load::Load;
use super::place::{Place, last_core};
use super::promises::{Figure, Most, Promise};
use super::report::{PartReport, Unit, What};
use super::windows::{Contender, Meter};

/// From one wake-up to the next: five times as often as the fieldbus thread, so that an hour has a million.
const PERIOD: Duration = Duration::from_micros(200);
/// That of the fieldbus thread.
const PRIORITY: u8 = 80;

/// Measures for so long.
///
/// # Errors
/// [`Failure`] when ours cannot be measured.
pub fn measure(meter: &Meter, time: Duration, part: &mut PartReport) -> Result<(), Failure> {
    let (place, without) = Place::wanted(PRIORITY, last_core());
    part.notes.extend(without);
    let cycle = Cycle {
        period: PERIOD,
        place,
    };
    let contenders = || -> (Vec<Box<dyn Contender>>, Option<String>) {
        match Cyclictest::find(cycle) {
            Ok(rival) => (vec![Box::new(Ours(cycle)), Box::new(rival)], None),
            Err(why) => (vec![Box::new(Ours(cycle))], Some(why)),
        }
    };
    let (idle, missing) = contenders();
    part.notes.extend(missing);
    let every = format!("every {} µs", PERIOD.as_micros());
    let promises = [Promise(Figure::P999, Most::TimesRival(1.2))];
    let compare = |what: &str, part: &mut PartReport, contenders| {
        let title = format!("wake-up {every}, {what}");
        let what = What::new(&title, Unit::Us).promising(&promises);
        meter.compare(part, &what, time / 2, contenders)
    };
    compare("idle", part, idle)?;
    let _load = Load::begin()?;
    let (loaded, _) = contenders();
    compare("loaded", part, loaded)
}
