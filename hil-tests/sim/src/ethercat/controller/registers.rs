//! Addresses and fixed contents of the register file, and which bytes of it a MainDevice may write: ETG.1000.4 tables
//! 31 (information), 32 (station address), 34 (DL status), 35 (AL control and status), 48 (SII), 57 (FMMU), 59
//! (SyncManager), 60 (distributed clock); section 6.3 (watchdogs).

/// Bytes of registers and process memory together.
pub const MEMORY: usize = 0x3000;
/// Where process memory begins.
pub const PROCESS_MEMORY: u16 = 0x1000;
/// Fieldbus memory management units.
pub const FMMU_COUNT: usize = 8;
/// SyncManagers.
pub const SYNC_MANAGER_COUNT: usize = 8;

/// Configured station address.
pub const STATION_ADDRESS: u16 = 0x0010;
/// Station alias, from the SII.
pub const STATION_ALIAS: u16 = 0x0012;
/// Data link control.
pub const DL_CONTROL: u16 = 0x0100;
/// Data link status: links and loops of the ports.
pub const DL_STATUS: u16 = 0x0110;
/// Requested application layer state.
pub const AL_CONTROL: u16 = 0x0120;
/// Actual application layer state.
pub const AL_STATUS: u16 = 0x0130;
/// Why the last request or check failed.
pub const AL_STATUS_CODE: u16 = 0x0134;
/// Kind of the interface between this chip and the drive's processor.
pub const PDI_CONTROL: u16 = 0x0140;
/// Events that may appear in a datagram's interrupt field.
pub const EVENT_MASK: u16 = 0x0200;
/// Events for the MainDevice.
pub const EVENT_REQUEST: u16 = 0x0210;
/// Receive errors, two bytes per port.
pub const RX_ERRORS: u16 = 0x0300;
/// Frames whose structure the processing unit rejected.
pub const PROCESSING_UNIT_ERRORS: u16 = 0x030C;
/// Lost links, one byte per port.
pub const LOST_LINKS: u16 = 0x0310;
/// Watchdog divider, in units of 40 ns, less 2.
pub const WATCHDOG_DIVIDER: u16 = 0x0400;
/// Time of the processor watchdog, in divided ticks.
pub const WATCHDOG_TIME_PDI: u16 = 0x0410;
/// Time of the process data watchdog, in divided ticks; 0 switches it off.
pub const WATCHDOG_TIME_PROCESS_DATA: u16 = 0x0420;
/// Bit 0: process data watchdog has not expired.
pub const WATCHDOG_STATUS: u16 = 0x0440;
/// Expirations of the process data watchdog.
pub const WATCHDOG_COUNTER: u16 = 0x0442;
/// Who may use the SII: MainDevice or processor.
pub const SII_ACCESS: u16 = 0x0500;
/// SII command and status.
pub const SII_CONTROL: u16 = 0x0502;
/// SII word address.
pub const SII_ADDRESS: u16 = 0x0504;
/// SII data.
pub const SII_DATA: u16 = 0x0508;
/// First FMMU, 16 bytes each.
pub const FMMU: u16 = 0x0600;
/// First SyncManager, 8 bytes each.
pub const SYNC_MANAGER: u16 = 0x0800;
/// Receive times of the ports, four bytes each.
pub const DC_RECEIVE_TIMES: u16 = 0x0900;
/// System time.
pub const DC_SYSTEM_TIME: u16 = 0x0910;
/// Local time at which the processing unit saw the latching frame.
pub const DC_RECEIVE_TIME_UNIT: u16 = 0x0918;
/// What is added to the local time to get the system time.
pub const DC_OFFSET: u16 = 0x0920;
/// Delay between reference clock and this SubDevice.
pub const DC_DELAY: u16 = 0x0928;
/// Mean difference to the reference clock.
pub const DC_DIFFERENCE: u16 = 0x092C;
/// Start value of the control loop; writing it resets the loop.
pub const DC_SPEED_START: u16 = 0x0930;
/// Depths of the control loop's filters.
pub const DC_FILTER: u16 = 0x0934;

/// DL control at power-on: foreign frames are destroyed, loops are automatic.
pub const DL_CONTROL_DEFAULT: u32 = 0x0000_C001;
/// DL control: the alias may be used as a station address.
pub const DL_CONTROL_ALIAS: u32 = 1 << 24;
/// 100 µs at 25 MHz.
pub const WATCHDOG_DIVIDER_DEFAULT: u16 = 0x09C2;
/// 100 ms at the default divider.
pub const WATCHDOG_TIME_DEFAULT: u16 = 1000;
/// Event: the AL status changed.
pub const EVENT_AL_STATUS: u16 = 1 << 3;

/// Contents at address 0: an ET1100-like chip with two MII ports, 8 kB of process memory and distributed clocks of
/// 64 bits; bit operations in FMMUs are possible (feature bit 0 clear).
pub const INFORMATION_DEFAULT: [u8; 10] = [
    0x11,
    0x00,
    0x02,
    0x00,
    FMMU_COUNT as u8,
    SYNC_MANAGER_COUNT as u8,
    8,
    0x0F,
    0x0C,
    0x00,
];

/// Address ranges (first, end) that a MainDevice may write, below process memory.
const WRITABLE: [(u16, u16); 19] = [
    (0x0010, 0x0012),
    (0x0100, 0x0104),
    (0x0120, 0x0122),
    (0x0200, 0x0202),
    (0x0300, 0x0308),
    (0x030C, 0x030E),
    (0x0310, 0x0314),
    (0x0400, 0x0402),
    (0x0410, 0x0412),
    (0x0420, 0x0422),
    (0x0442, 0x0444),
    (0x0500, 0x0501),
    (0x0502, 0x0510),
    (0x0600, 0x0600 + 16 * FMMU_COUNT as u16),
    (0x0900, 0x0904),
    (0x0910, 0x0918),
    (0x0920, 0x092C),
    (0x0930, 0x0936),
    (0x0980, 0x09A8),
];

/// Whether a MainDevice may write the byte at `address`. Process memory is not covered: SyncManagers decide there.
#[must_use]
pub fn writable(address: u16) -> bool {
    if (SYNC_MANAGER..SYNC_MANAGER + 8 * SYNC_MANAGER_COUNT as u16).contains(&address) {
        // Bytes 5 (status) and 7 (processor control) of each SyncManager belong to the SubDevice.
        return !matches!(address % 8, 5 | 7);
    }
    // User memory at the end of the register file.
    if (0x0F80..PROCESS_MEMORY).contains(&address) {
        return true;
    }
    WRITABLE
        .iter()
        .any(|(first, end)| (*first..*end).contains(&address))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn status_registers_are_read_only() {
        for address in [
            0x0000,
            0x0012,
            DL_STATUS,
            AL_STATUS,
            AL_STATUS_CODE,
            0x0805,
            0x081F,
            DC_DIFFERENCE,
            0x0440,
        ] {
            assert!(!writable(address), "{address:#06x}");
        }
        for address in [
            STATION_ADDRESS,
            AL_CONTROL,
            0x0600,
            0x067F,
            0x0800,
            0x0806,
            0x0900,
            DC_OFFSET,
            0x0FFF,
        ] {
            assert!(writable(address), "{address:#06x}");
        }
        assert!(!writable(0x0680));
    }
}
