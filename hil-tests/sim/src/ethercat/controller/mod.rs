//! The SubDevice controller (ESC): registers, process memory, EEPROM, watchdog and clock.

pub mod clock;
pub mod eeprom;
pub mod esc;
pub mod fmmu;
mod memory;
pub mod registers;
pub mod sii;
pub mod sync_manager;
pub mod watchdog;
