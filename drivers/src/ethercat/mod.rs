//! EtherCAT MainDevice for one SubDevice: bring-up, cyclic exchange, and the links that carry frames.
//!
//! [`Bus::bring_up`] takes a [`Link`] from nothing to OP and checks on the way that the right SubDevice is there,
//! that it maps the expected process data, and that its watchdog is armed. [`Bus::exchange`] then moves process data.
//!
//! # Background
//! ethercrab holds the protocol. Its futures are polled in place, in the caller's thread, with a waker that does
//! nothing; between two polls the frame they asked for is sent through the link and the answer waited for. There is
//! no second thread, no channel and no timer but the deadline given to `ppoll`. ethercrab's own timeouts are set to
//! infinity, because its timers run on a thread of their own.
//!
//! Every frame leaves with one more datagram, a NOP that carries a number used once. SubDevices hand it on untouched,
//! so an answer is taken only for the frame it answers: late, duplicated and foreign frames are counted and dropped.
//!
//! # Real-time contract
//! [`Bus::exchange`], [`Bus::al_status`] and [`Link::send`]/[`Link::receive`] of both links do not allocate, lock or
//! log, and make no system call but `send`, `recv` and `ppoll` on the link's socket (and reading the clock). They
//! return at their deadline. Everything else may allocate and takes bounded time.
//!
//! # Units
//! Times are nanoseconds of `CLOCK_BOOTTIME` ([`monotonic_ns`](crate::monotonic_ns)). Distributed-clock time is set to the same clock at
//! bring-up and runs free after it.
//!
//! # Example
//! ```no_run
//! use description::wheels::WheelSpeeds;
//! use drivers::ethercat::{BringUpOptions, Bus, Expectation, RawLink};
//! use drivers::{kelo, monotonic_ns};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let expected = Expectation {
//!     vendor_id: 0x0000_0001,
//!     product_codes: kelo::PRODUCT_CODES.to_vec(),
//!     outputs_bytes: kelo::OUTPUTS_BYTES,
//!     inputs_bytes: kelo::INPUTS_BYTES,
//!     watchdog_ms: 100,
//! };
//! let link = Box::new(RawLink::open("eth0")?);
//! let mut bus = Bus::bring_up(link, &expected, BringUpOptions::default())?;
//! let (mut inputs, limits) = ([0; kelo::INPUTS_BYTES], kelo::SetpointLimits::default());
//! for _cycle in 0..1000 {
//!     let setpoint = kelo::Setpoint::Speeds { speeds: WheelSpeeds::new(1.0, 1.0), current_a: 20.0 };
//!     let outputs = setpoint.to_outputs(&limits).to_bytes();
//!     match bus.exchange(&outputs, &mut inputs, monotonic_ns() + 500_000) {
//!         Ok(_) => println!("{:?}", kelo::Feedback::from(&kelo::Inputs::from_bytes(&inputs))),
//!         Err(error) => println!("{error}"),
//!     }
//!     std::thread::sleep(std::time::Duration::from_millis(1));
//! }
//! # Ok(())
//! # }
//! ```

mod al;
mod bring_up;
mod bus;
mod error;
mod expectation;
mod links;
mod sub_device;
mod transport;
mod watchdog;

pub use al::{AlState, AlStatus};
pub use bus::{Bus, Exchange};
pub use error::{BringUpError, ExchangeError, Phase, ProcessData};
pub use expectation::{BringUpOptions, Expectation, FoundSubDevice};
pub use links::{Link, LinkError, RawLink, UdpLink, refused};
pub use transport::BusCounters;
