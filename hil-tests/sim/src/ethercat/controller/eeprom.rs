//! The SII interface (ETG.1000.4 section 6.4): commands at 0x0502 read and write the EEPROM, a few bytes at a time,
//! with the delays of a real one.

use super::sii;

/// Low byte: writing is enabled for the command in the same access.
const WRITE_ENABLE: u16 = 0x0001;
/// Low byte: reads return eight bytes.
const READS_8_BYTES: u16 = 0x0040;
/// Read command.
const READ: u16 = 0x0100;
/// Write command.
const WRITE: u16 = 0x0200;
/// Reload command.
const RELOAD: u16 = 0x0400;
/// All command bits.
const COMMANDS: u16 = READ | WRITE | RELOAD;
/// The check sum is wrong.
const CHECKSUM_ERROR: u16 = 0x0800;
/// The content was not loaded.
const NOT_LOADED: u16 = 0x1000;
/// The last command was not accepted.
const COMMAND_ERROR: u16 = 0x2000;
/// A write command came without its enable bit.
const WRITE_ENABLE_ERROR: u16 = 0x4000;
/// A command is running.
const BUSY: u16 = 0x8000;

/// Bytes that a read returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ReadSize {
    /// Four, as small chips do.
    Four,
    /// Eight.
    #[default]
    Eight,
}

impl ReadSize {
    fn bytes(self) -> usize {
        match self {
            ReadSize::Four => 4,
            ReadSize::Eight => 8,
        }
    }
}

/// EEPROM and its interface.
#[derive(Debug, Clone)]
pub struct Eeprom {
    content: Vec<u8>,
    read_size: ReadSize,
    read_time_ns: u64,
    write_time_ns: u64,
    errors: u16,
    busy_until_ns: u64,
    data: [u8; 8],
    reloaded: bool,
}

impl Eeprom {
    /// An EEPROM with this content, loaded as after power-on. A write takes 40 times as long as a read.
    #[must_use]
    pub fn new(content: Vec<u8>, read_size: ReadSize, read_time_ns: u64) -> Eeprom {
        let mut eeprom = Eeprom {
            content,
            read_size,
            read_time_ns,
            write_time_ns: read_time_ns.saturating_mul(40),
            errors: 0,
            busy_until_ns: 0,
            data: [0; 8],
            reloaded: false,
        };
        eeprom.load();
        eeprom
    }

    /// Resets the interface, as after power-on. The content stays.
    pub fn power_on(&mut self) {
        self.busy_until_ns = 0;
        self.data = [0; 8];
        self.load();
    }

    /// The station alias that the content holds; 0 when the check sum is wrong.
    #[must_use]
    pub fn alias(&self) -> u16 {
        let at = 2 * sii::ALIAS_WORD as usize;
        if self.errors & CHECKSUM_ERROR != 0 || self.content.len() < at + 2 {
            return 0;
        }
        u16::from_le_bytes([self.content[at], self.content[at + 1]])
    }

    /// The control and status register at `now_ns`.
    #[must_use]
    pub fn status(&self, now_ns: u64) -> u16 {
        let size = if self.read_size == ReadSize::Eight {
            READS_8_BYTES
        } else {
            0
        };
        let busy = if now_ns < self.busy_until_ns { BUSY } else { 0 };
        size | self.errors | busy
    }

    /// The data register.
    #[must_use]
    pub fn data(&self) -> [u8; 8] {
        self.data
    }

    /// Tells once that a reload has happened.
    pub fn take_reloaded(&mut self) -> bool {
        std::mem::take(&mut self.reloaded)
    }

    /// Takes a write to the data register.
    pub fn set_data(&mut self, data: [u8; 8]) {
        self.data = data;
    }

    /// Takes a write to the control register; `address` is the address register as it stands then.
    pub fn command(&mut self, control: u16, address: u32, now_ns: u64) {
        if now_ns < self.busy_until_ns {
            return;
        }
        self.errors &= CHECKSUM_ERROR | NOT_LOADED;
        let byte = (address as usize).saturating_mul(2);
        match control & COMMANDS {
            0 => {}
            READ => {
                let size = self.read_size.bytes();
                for (i, slot) in self.data.iter_mut().enumerate().take(size) {
                    *slot = self
                        .content
                        .get(byte.saturating_add(i))
                        .copied()
                        .unwrap_or(0xFF);
                }
                self.busy_until_ns = now_ns.saturating_add(self.read_time_ns);
            }
            WRITE if control & WRITE_ENABLE == 0 => {
                self.errors |= COMMAND_ERROR | WRITE_ENABLE_ERROR
            }
            WRITE => match self.content.get_mut(byte..byte.saturating_add(2)) {
                Some(word) => {
                    word.copy_from_slice(&self.data[..2]);
                    self.busy_until_ns = now_ns.saturating_add(self.write_time_ns);
                }
                None => self.errors |= COMMAND_ERROR,
            },
            RELOAD => {
                self.load();
                self.busy_until_ns = now_ns.saturating_add(self.read_time_ns);
                self.reloaded = true;
            }
            _ => self.errors |= COMMAND_ERROR,
        }
    }

    fn load(&mut self) {
        self.errors = if sii::checksum_ok(&self.content) {
            0
        } else {
            CHECKSUM_ERROR | NOT_LOADED
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const READ_NS: u64 = 50_000;

    fn eeprom(read_size: ReadSize) -> Eeprom {
        let mut content: Vec<u8> = (0..=255).collect();
        content[14] = sii::checksum(&content[..14]);
        Eeprom::new(content, read_size, READ_NS)
    }

    #[test]
    fn reads_take_time_and_have_a_size() {
        let mut four = eeprom(ReadSize::Four);
        four.command(READ, 0x20, 1000);
        assert_eq!(four.status(1000) & (BUSY | READS_8_BYTES), BUSY);
        assert_eq!(four.status(1000 + READ_NS) & BUSY, 0);
        assert_eq!(four.data(), [64, 65, 66, 67, 0, 0, 0, 0]);
        let mut eight = eeprom(ReadSize::Eight);
        eight.command(READ, 0x20, 0);
        assert_eq!(eight.status(READ_NS) & READS_8_BYTES, READS_8_BYTES);
        assert_eq!(eight.data(), [64, 65, 66, 67, 68, 69, 70, 71]);
    }

    #[test]
    fn a_command_while_busy_has_no_effect() {
        let mut eeprom = eeprom(ReadSize::Four);
        eeprom.command(READ, 0x20, 0);
        eeprom.command(READ, 0x30, READ_NS - 1);
        assert_eq!(eeprom.data()[0], 64);
    }

    #[test]
    fn beyond_the_end_is_blank() {
        let mut eeprom = eeprom(ReadSize::Eight);
        eeprom.command(READ, 0x7E, 0);
        assert_eq!(eeprom.data(), [252, 253, 254, 255, 0xFF, 0xFF, 0xFF, 0xFF]);
        eeprom.command(READ, u32::MAX, READ_NS);
        assert_eq!(eeprom.data(), [0xFF; 8]);
    }

    #[test]
    fn writes_need_their_enable_bit() {
        let mut eeprom = eeprom(ReadSize::Four);
        eeprom.set_data([7; 8]);
        eeprom.command(WRITE, 0x20, 0);
        assert_eq!(
            eeprom.status(0) & (COMMAND_ERROR | WRITE_ENABLE_ERROR),
            COMMAND_ERROR | WRITE_ENABLE_ERROR
        );
        eeprom.command(WRITE | WRITE_ENABLE, 0x20, 0);
        assert_eq!(eeprom.status(0) & COMMAND_ERROR, 0);
        eeprom.command(READ, 0x20, 40 * READ_NS);
        assert_eq!(eeprom.data()[..4], [7, 7, 66, 67]);
        eeprom.command(WRITE | WRITE_ENABLE, 0x80, 41 * READ_NS);
        assert_ne!(
            eeprom.status(41 * READ_NS) & COMMAND_ERROR,
            0,
            "no such word"
        );
    }

    #[test]
    fn two_commands_at_once_are_an_error() {
        let mut eeprom = eeprom(ReadSize::Four);
        eeprom.command(READ | RELOAD, 0, 0);
        assert_ne!(eeprom.status(0) & COMMAND_ERROR, 0);
    }

    #[test]
    fn a_broken_content_shows_at_reload() {
        let mut eeprom = eeprom(ReadSize::Four);
        assert_eq!(eeprom.alias(), 0x0908);
        eeprom.set_data([1, 2, 0, 0, 0, 0, 0, 0]);
        eeprom.command(WRITE | WRITE_ENABLE, 4, 0);
        let later = 40 * READ_NS;
        eeprom.command(RELOAD, 0, later);
        assert!(eeprom.take_reloaded() && !eeprom.take_reloaded());
        assert_eq!(
            eeprom.status(later) & (CHECKSUM_ERROR | NOT_LOADED),
            CHECKSUM_ERROR | NOT_LOADED
        );
        assert_eq!(eeprom.alias(), 0);
    }
}
