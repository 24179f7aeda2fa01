//! Hardware protocols: EtherCAT bring-up and links, the KELO drive, the Hokuyo lidar; no policy.
//!
//! The crate moves bytes and says what they mean. What follows from a lost frame or a dropped scan is for the caller to
//! decide.
//!
//! | module | holds |
//! |---|---|
//! | [`ethercat`] | a MainDevice for one SubDevice: links, bring-up to OP, cyclic exchange |
//! | [`kelo`] | the KELO drive's process data, and the same in the robot's terms |
//! | [`hokuyo`] | the lidar: finding its bit rate, SCIP, scans |
//!
//! # Real-time contract
//! Opening a link, bringing a bus up and connecting to a lidar allocate and take bounded time; they are not for real-time
//! threads. Afterwards [`ethercat::Bus::exchange`], [`hokuyo::Hokuyo::read_scan`] and everything in [`kelo`] do not
//! allocate, lock or log, make no system call but those of their own device and the clock, and return at their deadline.
//! Tests count allocations and threads to hold this.
//!
//! # Units
//! A number carries its unit in its name (`_rad_s`, `_mm`, `_ns`), or is a `Duration`. Times are nanoseconds of
//! `CLOCK_BOOTTIME` ([`monotonic_ns`]), unless a link or line brings another [`Clock`]. Signs follow ROS REP 103: forward
//! and left (counter-clockwise) are positive.
//!
//! # What is supported
//! *Supported*: works, and tests hold it against a simulated device. *Partial*: works within the limits given.
//! *Planned*: missing.
//!
//! | feature | state | limits |
//! |---|---|---|
//! | EtherCAT on a network interface ([`ethercat::RawLink`]) | supported | Linux; needs CAP_NET_RAW |
//! | EtherCAT over UDP ([`ethercat::UdpLink`]) | supported | no privileges needed |
//! | SubDevices on a bus | partial | exactly one |
//! | bring-up INIT to OP | supported | identity, sizes and watchdog are checked |
//! | process data | supported | one frame per cycle; late, duplicated and foreign frames are recognised |
//! | distributed clocks | partial | the SubDevice's clock is set at bring-up, then runs free; no SYNC0/SYNC1 |
//! | mailbox protocols (CoE, FoE, EoE) | planned | |
//! | cable redundancy, hot connect | planned | |
//! | KELO drive, velocity mode | supported | [`kelo::Setpoint`] |
//! | KELO drive, torque and differential modes | partial | as process data only, [`kelo::Outputs`] |
//! | Hokuyo URG-04LX, streams (`MD`, `MS`) | supported | any bit rate of [`description::robot::BIT_RATES`], SCIP 1.1 switched to 2.0 |
//! | other SCIP 2.0 lidars | partial | up to 768 beams; no intensities (`ME`) |
//! | single scans (`GD`, `GS`) | planned | |
//!
//! # Examples
//! A drive, brought to OP and told to turn its wheels. The link is a simulated segment in memory; on a robot it is
//! [`ethercat::RawLink`]:
//!
//! ```
//! use description::wheels::WheelSpeeds;
//! use drivers::ethercat::{BringUpOptions, Bus, Expectation, Link};
//! use drivers::{kelo, monotonic_ns};
//! use sim::kelo::{KeloOptions, SimulatedDrive, VENDOR_ID};
//! use std::{collections::VecDeque, error::Error, io};
//!
//! struct InMemory(sim::ethercat::Segment, VecDeque<Vec<u8>>);
//!
//! impl Link for InMemory {
//!     fn send(&mut self, ethernet_frame: &[u8]) -> io::Result<()> {
//!         let mut frame = ethernet_frame.to_vec();
//!         let reply = self.0.process_frame(&mut frame, monotonic_ns());
//!         self.1.extend(reply.map(|_| frame));
//!         self.0.cycle(monotonic_ns());
//!         Ok(())
//!     }
//!
//!     fn receive(&mut self, buffer: &mut [u8], _deadline_ns: u64) -> io::Result<Option<usize>> {
//!         self.0.cycle(monotonic_ns());
//!         Ok(self.1.pop_front().map(|frame| {
//!             buffer[..frame.len()].copy_from_slice(&frame);
//!             frame.len()
//!         }))
//!     }
//!
//!     fn describe(&self) -> String {
//!         "a segment in memory".to_owned()
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn Error>> {
//! let drive = SimulatedDrive::new(Box::new(sim::plant::TestStand::new()), KeloOptions::default());
//! let expected = Expectation {
//!     vendor_id: VENDOR_ID,
//!     product_codes: kelo::PRODUCT_CODES.to_vec(),
//!     outputs_bytes: kelo::OUTPUTS_BYTES,
//!     inputs_bytes: kelo::INPUTS_BYTES,
//!     watchdog_ms: 100,
//! };
//! let link = Box::new(InMemory(drive.segment, VecDeque::new()));
//! let mut bus = Bus::bring_up(link, &expected, BringUpOptions::default())?;
//!
//! let setpoint = kelo::Setpoint::Speeds { speeds: WheelSpeeds::new(2.0, 2.0), current_a: 20.0 };
//! let outputs = setpoint.to_outputs(&kelo::SetpointLimits::default()).to_bytes();
//! let mut inputs = [0; kelo::INPUTS_BYTES];
//! let mut feedback = kelo::Feedback::default();
//! while feedback.left_rad_s < 1.0 {
//!     bus.exchange(&outputs, &mut inputs, monotonic_ns() + 50_000_000)?;
//!     feedback = kelo::Feedback::from(&kelo::Inputs::from_bytes(&inputs));
//! }
//! assert!(feedback.enabled && feedback.right_rad_s > 0.0);
//! # Ok(())
//! # }
//! ```
//!
//! A line of a lidar's scan: three characters for each reading, then a checksum.
//!
//! ```
//! use drivers::hokuyo::{Reading, codec};
//!
//! let line = codec::verify(b"0CB1DhB").expect("the checksum is right");
//! let readings: Vec<Reading> = line
//!     .chunks(3)
//!     .map(|characters| Reading::from(codec::decode(characters).unwrap() as u16))
//!     .collect();
//! assert_eq!(readings, [Reading::Millimetres(1234), Reading::Millimetres(5432)]);
//! ```

mod clock;
pub mod ethercat;
pub mod hokuyo;
pub mod kelo;

pub use clock::{Clock, Monotonic, RelativeSleep, check_absolute_sleep, monotonic_ns, slept_ns};
