//! SyncManagers (ETG.1000.4 section 6.7, table 59): who may access which part of process memory, and when.

/// Control byte: direction, set when the MainDevice writes.
const DIRECTION_WRITE: u8 = 0x04;
/// Control byte: bits of direction and buffer mode.
const KIND: u8 = 0x0F;
/// Control byte: a complete write feeds the process data watchdog.
pub(super) const WATCHDOG: u8 = 0x40;
/// Control byte: mode bits; 0 is three buffers.
const MODE: u8 = 0x03;

/// One SyncManager, decoded from its 8 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SyncManager {
    /// First byte in process memory.
    pub start: u16,
    /// Bytes of one buffer.
    pub length_bytes: u16,
    /// Mode, direction, events, watchdog.
    pub control: u8,
    /// In use.
    pub active: bool,
}

impl SyncManager {
    /// Decodes the registers of one SyncManager.
    #[must_use]
    pub fn decode(registers: &[u8; 8]) -> SyncManager {
        SyncManager {
            start: u16::from_le_bytes([registers[0], registers[1]]),
            length_bytes: u16::from_le_bytes([registers[2], registers[3]]),
            control: registers[4],
            active: registers[6] & 1 != 0,
        }
    }

    /// Its first bytes: where, how long, and control.
    #[must_use]
    pub fn settings(&self) -> [u8; 5] {
        let ([s0, s1], [l0, l1]) = (self.start.to_le_bytes(), self.length_bytes.to_le_bytes());
        [s0, s1, l0, l1, self.control]
    }

    /// The MainDevice writes and the SubDevice reads.
    #[must_use]
    pub fn is_output(&self) -> bool {
        self.control & DIRECTION_WRITE != 0
    }

    /// A complete write feeds the process data watchdog.
    #[must_use]
    pub fn feeds_watchdog(&self) -> bool {
        self.active && self.control & WATCHDOG != 0
    }

    /// The first buffer: the only addresses a MainDevice uses.
    #[must_use]
    pub fn area(&self) -> std::ops::Range<usize> {
        let start = usize::from(self.start);
        start..start + usize::from(self.length_bytes)
    }

    /// Every byte that this SyncManager occupies: three buffers in buffered mode.
    #[must_use]
    pub fn occupied(&self) -> std::ops::Range<usize> {
        let area = self.area();
        let buffers = if self.control & MODE == 0 { 3 } else { 1 };
        area.start..area.start + area.len() * buffers
    }

    /// Same place, size, mode and direction, and in use. Watchdog and event bits may differ.
    #[must_use]
    pub fn agrees_with(&self, expected: &SyncManager) -> bool {
        self.active
            && self.start == expected.start
            && self.length_bytes == expected.length_bytes
            && self.control & KIND == expected.control & KIND
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTPUTS: SyncManager = SyncManager {
        start: 0x1100,
        length_bytes: 36,
        control: 0x64,
        active: true,
    };

    #[test]
    fn decodes_its_registers() {
        let sm = SyncManager::decode(&[0x00, 0x11, 36, 0, 0x64, 0xFF, 0x01, 0]);
        assert_eq!(sm, OUTPUTS);
        assert!(sm.is_output() && sm.feeds_watchdog());
        assert_eq!(sm.occupied(), 0x1100..0x1100 + 108);
    }

    #[test]
    fn agreement_ignores_watchdog_and_event_bits() {
        assert!(
            SyncManager {
                control: 0x04,
                ..OUTPUTS
            }
            .agrees_with(&OUTPUTS)
        );
        assert!(
            !SyncManager {
                control: 0x60,
                ..OUTPUTS
            }
            .agrees_with(&OUTPUTS)
        );
        assert!(
            !SyncManager {
                control: 0x66,
                ..OUTPUTS
            }
            .agrees_with(&OUTPUTS)
        );
        assert!(
            !SyncManager {
                length_bytes: 35,
                ..OUTPUTS
            }
            .agrees_with(&OUTPUTS)
        );
        assert!(
            !SyncManager {
                start: 0x1101,
                ..OUTPUTS
            }
            .agrees_with(&OUTPUTS)
        );
        assert!(
            !SyncManager {
                active: false,
                ..OUTPUTS
            }
            .agrees_with(&OUTPUTS)
        );
    }
}
