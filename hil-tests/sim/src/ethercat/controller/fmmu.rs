//! Fieldbus memory management units (ETG.1000.4 section 6.6, tables 56 and 57): which bits of the logical memory lie
//! where in a SubDevice.

/// One unit, decoded from its 16 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Fmmu {
    /// First byte in logical memory.
    pub logical_start: u32,
    /// Bytes touched in logical memory, partly mapped ones included.
    pub length_bytes: u16,
    /// First mapped bit of the first byte.
    pub start_bit: u8,
    /// Last mapped bit of the last byte.
    pub end_bit: u8,
    /// First byte in the SubDevice.
    pub physical_start: u16,
    /// First bit of that byte.
    pub physical_start_bit: u8,
    /// Maps reads.
    pub read: bool,
    /// Maps writes.
    pub write: bool,
    /// In use.
    pub active: bool,
}

/// A run of bits that a unit maps out of one datagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BitSpan {
    /// First bit, counted from the start of the datagram's data.
    pub data_bit: u64,
    /// First bit, counted from the start of the SubDevice's memory.
    pub physical_bit: u64,
    /// Bits.
    pub bits: u64,
}

impl BitSpan {
    /// Start in data, start in memory and length, if all are whole bytes.
    #[must_use]
    pub fn bytes(&self) -> Option<(usize, u64, usize)> {
        let aligned = [self.data_bit, self.physical_bit, self.bits]
            .into_iter()
            .all(|bits| bits.is_multiple_of(8));
        let whole = (
            (self.data_bit / 8) as usize,
            self.physical_bit / 8,
            (self.bits / 8) as usize,
        );
        aligned.then_some(whole)
    }
}

impl Fmmu {
    /// Decodes the registers of one unit.
    #[must_use]
    pub fn decode(registers: &[u8; 16]) -> Fmmu {
        let r = registers;
        Fmmu {
            logical_start: u32::from_le_bytes([r[0], r[1], r[2], r[3]]),
            length_bytes: u16::from_le_bytes([r[4], r[5]]),
            start_bit: r[6] & 7,
            end_bit: r[7] & 7,
            physical_start: u16::from_le_bytes([r[8], r[9]]),
            physical_start_bit: r[10] & 7,
            read: r[11] & 1 != 0,
            write: r[11] & 2 != 0,
            active: r[12] & 1 != 0,
        }
    }

    /// The bits that this unit maps out of `data_bytes` at `logical_address`; `None` if there are none.
    #[must_use]
    pub fn map(&self, logical_address: u32, data_bytes: usize) -> Option<BitSpan> {
        if !self.active || self.length_bytes == 0 {
            return None;
        }
        let first = u64::from(self.logical_start) * 8 + u64::from(self.start_bit);
        let last_byte = u64::from(self.logical_start) + u64::from(self.length_bytes) - 1;
        let end = last_byte * 8 + u64::from(self.end_bit) + 1;
        let data_first = u64::from(logical_address) * 8;
        let data_end = data_first + data_bytes as u64 * 8;
        let from = first.max(data_first);
        let to = end.min(data_end);
        if from >= to {
            return None;
        }
        let physical_first =
            u64::from(self.physical_start) * 8 + u64::from(self.physical_start_bit);
        Some(BitSpan {
            data_bit: from - data_first,
            physical_bit: physical_first + (from - first),
            bits: to - from,
        })
    }
}

/// Copies `bits` bits from `source`, starting at `source_bit`, into `target` at `target_bit`; other bits stay.
/// Bits beyond either end are left out.
pub fn copy_bits(source: &[u8], source_bit: u64, target: &mut [u8], target_bit: u64, bits: u64) {
    for i in 0..bits {
        let (from, to) = (source_bit + i, target_bit + i);
        let (Some(byte), Some(slot)) = (
            source.get((from / 8) as usize),
            target.get_mut((to / 8) as usize),
        ) else {
            return;
        };
        let bit = byte >> (from % 8) & 1;
        *slot = *slot & !(1 << (to % 8)) | bit << (to % 8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BYTES: Fmmu = Fmmu {
        logical_start: 0x1_0000,
        length_bytes: 4,
        start_bit: 0,
        end_bit: 7,
        physical_start: 0x1100,
        physical_start_bit: 0,
        read: true,
        write: false,
        active: true,
    };

    #[test]
    fn decodes_its_registers() {
        let registers = [0, 0, 1, 0, 4, 0, 0, 7, 0, 0x11, 0, 1, 1, 0, 0, 0];
        assert_eq!(Fmmu::decode(&registers), BYTES);
        assert_eq!(Fmmu::decode(&[0; 16]), Fmmu::default());
    }

    #[test]
    fn maps_whole_partial_and_nothing() {
        let bytes = |address, length| BYTES.map(address, length).and_then(|run| run.bytes());
        assert_eq!(bytes(0x1_0000, 4), Some((0, 0x1100, 4)));
        assert_eq!(bytes(0xFFFE, 4), Some((2, 0x1100, 2)));
        assert_eq!(bytes(0x1_0002, 100), Some((0, 0x1102, 2)));
        assert_eq!(bytes(0x1_0004, 1), None);
        assert_eq!(bytes(0xFFFF, 1), None);
        assert_eq!(bytes(0x1_0001, 0), None);
        assert_eq!(
            Fmmu {
                active: false,
                ..BYTES
            }
            .map(0x1_0000, 4),
            None
        );
        assert_eq!(
            Fmmu {
                length_bytes: 0,
                ..BYTES
            }
            .map(0x1_0000, 4),
            None
        );
    }

    #[test]
    fn maps_at_the_end_of_logical_memory() {
        let top = Fmmu {
            logical_start: u32::MAX,
            length_bytes: u16::MAX,
            ..BYTES
        };
        assert_eq!(
            top.map(u32::MAX, 8).and_then(|run| run.bytes()),
            Some((0, 0x1100, 8))
        );
    }

    #[test]
    fn maps_bits() {
        // Three bits, from bit 6 of the first byte to bit 0 of the second, lie at bits 1 to 3 of the memory's byte.
        let bits = Fmmu {
            length_bytes: 2,
            start_bit: 6,
            end_bit: 0,
            physical_start_bit: 1,
            ..BYTES
        };
        let run = bits.map(0x1_0000, 2).unwrap();
        assert_eq!(
            run,
            BitSpan {
                data_bit: 6,
                physical_bit: 0x1100 * 8 + 1,
                bits: 3
            }
        );
        assert_eq!(run.bytes(), None);
        let mut data = [0xFF, 0xFF];
        copy_bits(&[0b0000_1010], 1, &mut data, run.data_bit, run.bits);
        assert_eq!(data, [0b0111_1111, 0xFF]);
        // An end bit before the start bit of the only byte maps nothing.
        assert_eq!(
            Fmmu {
                length_bytes: 1,
                start_bit: 6,
                end_bit: 1,
                ..BYTES
            }
            .map(0x1_0000, 4),
            None
        );
    }
}
