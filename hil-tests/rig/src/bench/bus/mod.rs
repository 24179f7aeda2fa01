//! One cycle of the fieldbus, from the outputs to the inputs: our EtherCAT MainDevice beside SOEM, on the same simulated drive behind a
//! virtual pair of interfaces, at the period of a robot.

mod ours;
mod soem;

use std::time::Duration;

use onboard::cli::Failure;
use sim::ethercat::{Segment, ServeOptions, ServerHandle, serve_raw, serve_udp};
use sim::kelo::{KeloOptions, SimulatedDrive};
use sim::plant::TestStand;

use self::ours::{Ours, Place as Bus};
use self::soem::Soem;
use super::cycle::Cycle;
use super::place::{Place, last_core};
use super::promises::{Figure, Most, Promise};
use super::report::{PartReport, Unit, What};
use super::windows::{Contender, Meter};
use crate::interfaces::Pair;

/// From one exchange to the next: that of the fieldbus thread, and a little more. What else comes by the millisecond, the kernel's ticks and
/// the watch for stalls, so meets each window at all its phases. Else it meets every cycle of some windows and none of others, by chance.
const PERIOD: Duration = Duration::from_micros(1_003);
/// That of the fieldbus thread.
const PRIORITY: u8 = 80;
/// Of the simulated segment, above the MainDevices'.
const SEGMENT_PRIORITY: u8 = 90;

/// No slower than SOEM.
const PROMISES: [Promise; 2] = [
    Promise(Figure::P50, Most::TimesRival(1.0)),
    Promise(Figure::P99, Most::TimesRival(1.0)),
];

/// Measures for so long. Without a pair of interfaces ours is measured over UDP, and alone.
///
/// # Errors
/// [`Failure`] when ours cannot be measured.
pub fn measure(meter: &Meter, time: Duration, part: &mut PartReport) -> Result<(), Failure> {
    let (place, without) = Place::wanted(PRIORITY, last_core());
    part.notes.extend(without);
    let period = PERIOD;
    let cycle = Cycle { period, place };
    let pair = Pair::new("rb");
    let raw = { pair.as_ref().ok() }.map(|pair| serve_raw(&pair.near, segment(), options()));
    let (served, bus): (ServerHandle, Bus) = match (&pair, raw) {
        (Ok(pair), Some(Ok(served))) => (served, Bus::Interface(pair.far.clone())),
        (pair, raw) => {
            let why = { pair.as_ref().err().cloned() }
                .or_else(|| Some(raw?.err()?.to_string()))
                .unwrap_or_default();
            part.notes.push(format!(
                "SOEM is left out, and ours goes over UDP: no virtual pair of interfaces, which needs CAP_NET_ADMIN and CAP_NET_RAW \
                 ({why})"
            ));
            over_udp()?
        }
    };
    let mut pythons = None;
    let mut contenders: Vec<Box<dyn Contender>> = vec![Box::new(Ours::new(cycle, bus.clone()))];
    if let Bus::Interface(interface) = &bus {
        match Soem::find(cycle, interface) {
            Ok(rival) => {
                pythons = Some(rival.python_ns.clone());
                contenders.push(Box::new(rival));
            }
            Err(why) => part.notes.push(why),
        }
    }
    let title = format!("bus cycle every {} ms", PERIOD.as_millis());
    let what = What::new(&title, Unit::Us).promising(&PROMISES);
    let result = meter.compare(part, &what, time, contenders);
    if let Some(own_ns) = pythons.and_then(|own_ns| own_ns.get()) {
        part.notes
            .push(format!("Python takes {own_ns} ns of each cycle of SOEM"));
    }
    // Before the interfaces go.
    drop(served);
    result
}

/// A drive on a test stand.
fn segment() -> Segment {
    let stand = Box::new(TestStand::new());
    SimulatedDrive::new(stand, KeloOptions::default()).segment
}

fn options() -> ServeOptions {
    ServeOptions {
        priority: Some(SEGMENT_PRIORITY),
    }
}

fn over_udp() -> Result<(ServerHandle, Bus), Failure> {
    let any_port = ([127, 0, 0, 1], 0).into();
    let served = serve_udp(any_port, segment(), options()).map_err(Failure::refused)?;
    let address = served.local_addr();
    let address = address.ok_or_else(|| Failure::failed("the segment has no address"))?;
    Ok((served, Bus::Udp(address)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn our_cycles_are_measured_again_and_again_on_one_segment() {
        let Ok((_served, bus)) = over_udp() else {
            panic!("no segment")
        };
        let (place, _) = Place::wanted(10, last_core());
        let period = PERIOD;
        let mut ours = Ours::new(Cycle { period, place }, bus);
        for _ in 0..2 {
            let mut samples = Vec::new();
            // On a machine that stalls the drive's watchdog trips.
            let mut tries = 0;
            while let Err(failure) = ours.window(20 * PERIOD, &mut samples) {
                tries += 1;
                assert!(tries < 5, "{failure:?}");
            }
            assert_eq!(samples.len(), 20);
        }
    }
}
