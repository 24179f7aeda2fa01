//! The SubDevice controller (ESC): registers, process memory, EEPROM, watchdog and clock.

pub mod clock;
mod commands;
pub mod eeprom;
mod effects;
pub mod esc;
pub mod fmmu;
mod memory;
pub mod registers;
pub mod sii;
pub mod sync_manager;
pub mod watchdog;
