//! The SubDevice information interface's content: what the EEPROM says about identity and process data.
//!
//! Layout (ETG.1000.6 table 16, ETG.2010 table 2): 128 bytes of fixed fields with a check sum over the first 14, then
//! categories, each with a type (ETG.1000.6 table 19) and a length in words, closed by 0xFFFF.

use super::sync_manager::SyncManager;

/// Word address of the station alias.
pub const ALIAS_WORD: u32 = 4;
/// Word address of the check sum.
const CHECKSUM_WORD: usize = 7;
/// Bytes that the check sum covers.
const CHECKED_BYTES: usize = 14;
/// Bytes before the first category.
const FIXED_BYTES: usize = 128;
/// Size of the EEPROM, which has 16 kbit.
const EEPROM_BYTES: usize = 2048;

const STRINGS: u16 = 10;
const GENERAL: u16 = 30;
const FMMUS: u16 = 40;
const SYNC_MANAGERS: u16 = 41;
const TX_PDO: u16 = 50;
const RX_PDO: u16 = 51;
const CLOCK: u16 = 60;
const END: u16 = 0xFFFF;

/// A PDO that cannot be switched off or changed.
const PDO_MANDATORY_FIXED: u16 = 0x0011;

/// A SubDevice's identity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity {
    /// Vendor.
    pub vendor_id: u32,
    /// Product.
    pub product_code: u32,
    /// Revision.
    pub revision: u32,
    /// Serial number.
    pub serial: u32,
}

/// Data type of a PDO entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EntryType {
    /// UNSIGNED16.
    U16,
    /// UNSIGNED64.
    U64,
    /// REAL32.
    F32,
}

impl EntryType {
    /// Bytes of a value.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            EntryType::U16 => 2,
            EntryType::F32 => 4,
            EntryType::U64 => 8,
        }
    }

    fn code(self) -> u8 {
        match self {
            EntryType::U16 => 0x06,
            EntryType::F32 => 0x08,
            EntryType::U64 => 0x1B,
        }
    }
}

/// One process data object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pdo {
    /// Object index: 0x16xx for outputs, 0x1Axx for inputs.
    pub index: u16,
    /// Object that the entries belong to.
    pub entry_index: u16,
    /// SyncManager that carries it.
    pub sync_manager: u8,
    /// Its fields, in order.
    pub entries: Vec<EntryType>,
}

impl Pdo {
    /// Bytes of all entries.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.entries.iter().map(|entry| entry.bytes()).sum()
    }
}

/// What a SyncManager is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum SyncManagerUse {
    /// Mailbox, MainDevice to SubDevice.
    MailboxOut = 1,
    /// Mailbox, SubDevice to MainDevice.
    MailboxIn = 2,
    /// Process data, MainDevice to SubDevice.
    Outputs = 3,
    /// Process data, SubDevice to MainDevice.
    Inputs = 4,
}

/// Everything the EEPROM is made from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sii {
    /// Vendor, product, revision, serial number.
    pub identity: Identity,
    /// Second station address, 0 for none.
    pub alias: u16,
    /// Device type, short; at most 64 ASCII characters.
    pub name: String,
    /// Product family.
    pub group: String,
    /// Device name, long.
    pub description: String,
    /// SyncManagers in order, with their use.
    pub sync_managers: Vec<(SyncManager, SyncManagerUse)>,
    /// Outputs of the MainDevice.
    pub outputs: Pdo,
    /// Inputs of the MainDevice.
    pub inputs: Pdo,
}

impl Sii {
    /// The EEPROM's content.
    #[must_use]
    pub fn build(&self) -> Vec<u8> {
        let mut bytes = self.fixed_fields();
        category(&mut bytes, STRINGS, &self.strings());
        category(&mut bytes, GENERAL, &general());
        // Order of use: outputs, inputs, mailbox state.
        category(&mut bytes, FMMUS, &[1, 2, 3, 0]);
        category(&mut bytes, SYNC_MANAGERS, &self.sync_manager_entries());
        category(&mut bytes, TX_PDO, &pdo(&self.inputs));
        category(&mut bytes, RX_PDO, &pdo(&self.outputs));
        category(&mut bytes, CLOCK, &free_run());
        bytes.extend(END.to_le_bytes());
        // An erased EEPROM reads as ones.
        bytes.resize(EEPROM_BYTES.max(bytes.len()), 0xFF);
        bytes
    }

    fn fixed_fields(&self) -> Vec<u8> {
        let mut bytes = vec![0; FIXED_BYTES];
        // Serial interface to the drive's processor, as in the PDI control register.
        bytes[0] = 0x05;
        bytes[8..10].copy_from_slice(&self.alias.to_le_bytes());
        let sum = checksum(&bytes[..CHECKED_BYTES]);
        bytes[2 * CHECKSUM_WORD] = sum;
        let id = &self.identity;
        for (i, value) in [id.vendor_id, id.product_code, id.revision, id.serial]
            .into_iter()
            .enumerate()
        {
            bytes[16 + 4 * i..20 + 4 * i].copy_from_slice(&value.to_le_bytes());
        }
        // No mailbox: words 0x14 to 0x1C stay 0. Size in kbit less one, then the layout's version.
        bytes[0x7C..0x7E].copy_from_slice(&((EEPROM_BYTES / 128 - 1) as u16).to_le_bytes());
        bytes[0x7E] = 1;
        bytes
    }

    fn strings(&self) -> Vec<u8> {
        let texts = [&self.name, &self.group, &self.description];
        let mut bytes = vec![texts.len() as u8];
        for text in texts {
            let text = &text.as_bytes()[..text.len().min(usize::from(u8::MAX))];
            bytes.push(text.len() as u8);
            bytes.extend(text);
        }
        bytes
    }

    fn sync_manager_entries(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (sm, used_for) in &self.sync_managers {
            bytes.extend(sm.start.to_le_bytes());
            bytes.extend(sm.length_bytes.to_le_bytes());
            bytes.extend([sm.control, 0, u8::from(sm.active), *used_for as u8]);
        }
        bytes
    }
}

/// Check sum of the first 14 bytes: CRC-8, polynomial x⁸ + x² + x + 1, start value 0xFF.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0xFF, |crc, byte| {
        (0..8).fold(crc ^ byte, |crc, _| {
            if crc & 0x80 != 0 {
                crc << 1 ^ 0x07
            } else {
                crc << 1
            }
        })
    })
}

/// Whether the check sum in an EEPROM's content is right.
#[must_use]
pub fn checksum_ok(content: &[u8]) -> bool {
    content.len() >= FIXED_BYTES
        && checksum(&content[..CHECKED_BYTES]) == content[2 * CHECKSUM_WORD]
}

fn category(bytes: &mut Vec<u8>, kind: u16, content: &[u8]) {
    bytes.extend(kind.to_le_bytes());
    bytes.extend((content.len().div_ceil(2) as u16).to_le_bytes());
    bytes.extend(content);
    if content.len() % 2 == 1 {
        bytes.push(0);
    }
}

fn general() -> [u8; 32] {
    let mut bytes = [0; 32];
    // String numbers: group, image, order (type), name.
    bytes[..4].copy_from_slice(&[2, 0, 1, 3]);
    // Two MII ports.
    bytes[0x10] = 0x11;
    bytes
}

fn pdo(pdo: &Pdo) -> Vec<u8> {
    let mut bytes = Vec::new();
    bytes.extend(pdo.index.to_le_bytes());
    bytes.extend([pdo.entries.len() as u8, pdo.sync_manager, 0, 0]);
    bytes.extend(PDO_MANDATORY_FIXED.to_le_bytes());
    for (i, entry) in pdo.entries.iter().enumerate() {
        bytes.extend(pdo.entry_index.to_le_bytes());
        bytes.extend([i as u8 + 1, 0, entry.code(), entry.bytes() as u8 * 8, 0, 0]);
    }
    bytes
}

/// One way to use the clock: none.
fn free_run() -> [u8; 24] {
    [0; 24]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Sii {
        Sii {
            identity: Identity {
                vendor_id: 1,
                product_code: 2,
                revision: 3,
                serial: 4,
            },
            alias: 0,
            name: "odd".into(),
            group: "group".into(),
            description: "description".into(),
            sync_managers: vec![(
                SyncManager {
                    start: 0x1100,
                    length_bytes: 2,
                    control: 0x64,
                    active: true,
                },
                SyncManagerUse::Outputs,
            )],
            outputs: Pdo {
                index: 0x1600,
                entry_index: 0x7000,
                sync_manager: 0,
                entries: vec![EntryType::U16],
            },
            inputs: Pdo {
                index: 0x1A00,
                entry_index: 0x6000,
                sync_manager: 1,
                entries: vec![EntryType::F32],
            },
        }
    }

    #[test]
    fn checksum_has_the_known_check_value() {
        // The catalogue's check value of CRC-8 with start value 0xFF over "123456789".
        assert_eq!(checksum(b"123456789"), 0xFB);
    }

    #[test]
    fn categories_can_be_walked_to_the_end() {
        let bytes = sample().build();
        assert!(checksum_ok(&bytes));
        let word = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let mut at = FIXED_BYTES;
        let mut kinds = Vec::new();
        while word(at) != END {
            kinds.push(word(at));
            at += 4 + 2 * usize::from(word(at + 2));
        }
        assert_eq!(
            kinds,
            [
                STRINGS,
                GENERAL,
                FMMUS,
                SYNC_MANAGERS,
                TX_PDO,
                RX_PDO,
                CLOCK
            ]
        );
        assert_eq!(bytes.len(), EEPROM_BYTES);
        assert_eq!(word(0x7C), 15);
    }

    #[test]
    fn a_changed_byte_breaks_the_checksum() {
        let mut bytes = sample().build();
        bytes[8] ^= 1;
        assert!(!checksum_ok(&bytes));
        assert!(!checksum_ok(&bytes[..20]));
    }
}
