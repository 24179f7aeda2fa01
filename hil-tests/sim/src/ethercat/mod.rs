//! A simulated EtherCAT segment at the level of registers and datagrams: any MainDevice can bring it up.
//!
//! | part | where |
//! |---|---|
//! | frames and datagrams | [`frame`] |
//! | state machine | [`al`] |
//! | SubDevice controller: registers, memory, FMMUs, SyncManagers, EEPROM, watchdog, clock | [`controller`] |
//! | SubDevice with its application, line of SubDevices | [`subdevice`], [`segment`] |
//! | faults | [`faults`] |
//! | a thread that serves a segment over UDP or a network interface | [`server`] |
//!
//! Not simulated: mailboxes (CoE and the like), SYNC0/SYNC1 and latch signals, clock drift, VLAN tags, redundancy,
//! BOOT, and protection of registers.

pub mod al;
pub mod controller;
pub mod faults;
pub mod frame;
pub mod segment;
pub mod server;
pub mod subdevice;

pub use controller::{clock, eeprom, esc, fmmu, registers, sii, sync_manager, watchdog};
pub use faults::FaultHandle;
pub use segment::{Reply, Segment, Statistics, StatisticsHandle};
pub use server::{ServeError, ServeOptions, ServerHandle, serve_raw, serve_udp};
pub use subdevice::{Application, Cycle, SubDevice};

#[cfg(test)]
mod tests;
