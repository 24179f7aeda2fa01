//! Our MainDevice.

use std::net::SocketAddr;
use std::time::Duration;

use drivers::ethercat::{BringUpOptions, Bus, ExchangeError, Expectation, Link, RawLink, UdpLink};
use drivers::kelo;
use onboard::cli::Failure;
use onboard::realtime::clock::sleep_until;
use onboard::realtime::latency::keep_cores_awake;
use sim::kelo::VENDOR_ID;
use sim::rt::monotonic_ns;

use crate::bench::cycle::Cycle;
use crate::bench::measuring::Measuring;
use crate::bench::samples::Sample;
use crate::bench::windows::Contender;

/// An answer that comes later is lost, to the rival as well.
pub(super) const DEADLINE: Duration = Duration::from_millis(5);
/// Time without outputs after which the drive stops by itself.
const WATCHDOG_MS: u32 = 100;

/// Where the segment is.
#[derive(Clone, Debug)]
pub(super) enum Place {
    /// Behind a network interface.
    Interface(String),
    /// Behind a port.
    Udp(SocketAddr),
}

impl Place {
    fn link(&self) -> Result<Box<dyn Link>, Failure> {
        Ok(match self {
            Self::Interface(name) => Box::new(RawLink::open(name).map_err(Failure::refused)?),
            Self::Udp(address) => Box::new(UdpLink::open(*address).map_err(Failure::refused)?),
        })
    }
}

/// Brings its bus up for each window.
pub(super) struct Ours {
    cycle: Cycle,
    bus: Place,
}

impl Ours {
    pub(super) fn new(cycle: Cycle, bus: Place) -> Self {
        Self { cycle, bus }
    }
}

impl Contender for Ours {
    fn name(&self) -> String {
        "drivers::ethercat".to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        let expected = Expectation {
            vendor_id: VENDOR_ID,
            product_codes: kelo::PRODUCT_CODES.to_vec(),
            outputs_bytes: kelo::OUTPUTS_BYTES,
            inputs_bytes: kelo::INPUTS_BYTES,
            watchdog_ms: WATCHDOG_MS,
        };
        let (link, cycle) = (self.bus.link()?, self.cycle);
        let _awake = keep_cores_awake();
        let measuring = Measuring::spawn("fieldbus", move || {
            // First: a thread that has to wait for others once the bus is up may be too late for the drive's watchdog.
            cycle.place.take()?;
            let bus = Bus::bring_up(link, &expected, BringUpOptions::default());
            exchanges(bus.map_err(Failure::failed)?, cycle, length)
        })?;
        into.extend(measuring.end()?);
        Ok(())
    }
}

/// Exchanges process data; a frame that is lost took until its deadline.
fn exchanges(mut bus: Bus, cycle: Cycle, length: Duration) -> Result<Vec<Sample>, Failure> {
    let (period_ns, cycles) = (cycle.period.as_nanos() as u64, cycle.count(length));
    let mut samples = Vec::with_capacity(cycles as usize);
    let (outputs, mut inputs) = ([0; kelo::OUTPUTS_BYTES], [0; kelo::INPUTS_BYTES]);
    let mut next_ns = monotonic_ns();
    for _ in 0..cycles {
        let began_ns = monotonic_ns();
        let deadline_ns = began_ns + DEADLINE.as_nanos() as u64;
        match bus.exchange(&outputs, &mut inputs, deadline_ns) {
            Ok(_) | Err(ExchangeError::Lost) => {}
            Err(error) => return Err(Failure::failed(error)),
        }
        samples.push(Sample::from_to(began_ns, monotonic_ns()));
        next_ns = (next_ns + period_ns).max(monotonic_ns());
        sleep_until(next_ns);
    }
    // The drive's watchdog does it as well.
    let _ = bus.shut_down(monotonic_ns() + DEADLINE.as_nanos() as u64);
    Ok(samples)
}
