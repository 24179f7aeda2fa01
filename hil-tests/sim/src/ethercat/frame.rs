//! EtherCAT frames (ETG.1000.4 section 5): Ethernet header, EtherCAT header, datagrams; read and changed in place.
//!
//! Nothing here copies or allocates. A frame is checked as a whole before any datagram is handed out, so that a
//! frame with a broken length field has no effect at all, as if its check sum had been wrong.

/// EtherType of EtherCAT frames, and the UDP port of the same datagrams.
pub const ETHERTYPE: u16 = 0x88A4;
/// Bytes before the EtherCAT header in an Ethernet frame without VLAN tag.
pub const ETHERNET_HEADER: usize = 14;
/// Bytes of the EtherCAT header: length and type of the protocol data unit.
pub const ETHERCAT_HEADER: usize = 2;
/// Bytes of a datagram's header.
pub const DATAGRAM_HEADER: usize = 10;
/// Bytes of a datagram's working counter.
pub const WORKING_COUNTER: usize = 2;
/// Largest Ethernet payload, and so the largest data of one datagram is below this.
pub const MAX_PAYLOAD: usize = 1500;

/// Bit in the first byte of a source address that the first SubDevice sets: locally administered.
const LOCALLY_ADMINISTERED: u8 = 0x02;
/// EtherCAT header type that carries datagrams.
const TYPE_DATAGRAMS: u16 = 1;
/// Bit of the length word: another datagram follows.
const MORE: u16 = 0x8000;
/// Bits of the length word that hold the length.
const LENGTH: u16 = 0x07FF;

/// What a datagram asks a SubDevice to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// Nothing.
    Nop,
    /// Read by position (auto-increment).
    Aprd,
    /// Write by position.
    Apwr,
    /// Read and write by position.
    Aprw,
    /// Read by station address.
    Fprd,
    /// Write by station address.
    Fpwr,
    /// Read and write by station address.
    Fprw,
    /// Read from all, OR-ed.
    Brd,
    /// Write to all.
    Bwr,
    /// Read from and write to all.
    Brw,
    /// Read by logical address.
    Lrd,
    /// Write by logical address.
    Lwr,
    /// Read and write by logical address.
    Lrw,
    /// Read from one by position, write to all others.
    Armw,
    /// Read from one by station address, write to all others.
    Frmw,
    /// A number without a meaning; SubDevices pass it on.
    Unknown(u8),
}

impl Command {
    /// The command with this number on the wire.
    #[must_use]
    pub fn from_wire(number: u8) -> Command {
        match number {
            0 => Command::Nop,
            1 => Command::Aprd,
            2 => Command::Apwr,
            3 => Command::Aprw,
            4 => Command::Fprd,
            5 => Command::Fpwr,
            6 => Command::Fprw,
            7 => Command::Brd,
            8 => Command::Bwr,
            9 => Command::Brw,
            10 => Command::Lrd,
            11 => Command::Lwr,
            12 => Command::Lrw,
            13 => Command::Armw,
            14 => Command::Frmw,
            other => Command::Unknown(other),
        }
    }
}

/// Why a frame was not processed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum FrameError {
    /// Another protocol's frame, or an EtherCAT frame without datagrams.
    #[error("not a frame of EtherCAT datagrams")]
    Foreign,
    /// A length field points beyond the frame.
    #[error("frame of {available} bytes is too short: {needed} needed")]
    TooShort {
        /// Bytes that the length fields ask for.
        needed: usize,
        available: usize,
    },
}

/// One datagram, in place.
#[derive(Debug)]
pub struct Datagram<'f> {
    header: &'f mut [u8],
    /// The data.
    pub data: &'f mut [u8],
    counter: &'f mut [u8],
}

impl Datagram<'_> {
    /// The command.
    #[must_use]
    pub fn command(&self) -> Command {
        Command::from_wire(self.header[0])
    }

    /// Position or station address.
    #[must_use]
    pub fn device_address(&self) -> u16 {
        u16::from_le_bytes([self.header[2], self.header[3]])
    }

    /// Replaces position or station address.
    pub fn set_device_address(&mut self, address: u16) {
        self.header[2..4].copy_from_slice(&address.to_le_bytes());
    }

    /// Address in the SubDevice's memory.
    #[must_use]
    pub fn offset(&self) -> u16 {
        u16::from_le_bytes([self.header[4], self.header[5]])
    }

    /// Address in the logical memory.
    #[must_use]
    pub fn logical_address(&self) -> u32 {
        u32::from_le_bytes([
            self.header[2],
            self.header[3],
            self.header[4],
            self.header[5],
        ])
    }

    /// Adds a SubDevice's events to the interrupt field.
    pub fn raise_events(&mut self, events: u16) {
        let old = u16::from_le_bytes([self.header[8], self.header[9]]);
        self.header[8..10].copy_from_slice(&(old | events).to_le_bytes());
    }

    /// The working counter.
    #[must_use]
    pub fn working_counter(&self) -> u16 {
        u16::from_le_bytes([self.counter[0], self.counter[1]])
    }

    /// Adds to the working counter.
    pub fn count(&mut self, increment: u16) {
        let sum = self.working_counter().wrapping_add(increment);
        self.counter.copy_from_slice(&sum.to_le_bytes());
    }
}

/// The EtherCAT part of an Ethernet frame.
///
/// # Errors
/// [`FrameError::Foreign`] for another EtherType, [`FrameError::TooShort`] for less than an Ethernet header.
pub fn ethernet_payload(frame: &mut [u8]) -> Result<&mut [u8], FrameError> {
    if frame.len() < ETHERNET_HEADER {
        return Err(FrameError::TooShort {
            needed: ETHERNET_HEADER,
            available: frame.len(),
        });
    }
    if u16::from_be_bytes([frame[12], frame[13]]) != ETHERTYPE {
        return Err(FrameError::Foreign);
    }
    Ok(&mut frame[ETHERNET_HEADER..])
}

/// Marks the source address the way the first SubDevice does, so that a MainDevice can tell answers from its own
/// frames.
pub fn mark_processed(frame: &mut [u8]) {
    if let Some(first) = frame.get_mut(6) {
        *first |= LOCALLY_ADMINISTERED;
    }
}

/// Checks the structure of a payload (EtherCAT header and datagrams) and returns the number of datagrams.
///
/// # Errors
/// [`FrameError`] at the first length field that does not fit.
pub fn check(payload: &[u8]) -> Result<usize, FrameError> {
    let available = payload.len();
    if available < ETHERCAT_HEADER {
        return Err(FrameError::TooShort {
            needed: ETHERCAT_HEADER,
            available,
        });
    }
    let header = u16::from_le_bytes([payload[0], payload[1]]);
    if header >> 12 != TYPE_DATAGRAMS {
        return Err(FrameError::Foreign);
    }
    let end = ETHERCAT_HEADER + usize::from(header & LENGTH);
    if end > available {
        return Err(FrameError::TooShort {
            needed: end,
            available,
        });
    }
    let mut at = ETHERCAT_HEADER;
    let mut count = 0;
    loop {
        let needed = at + DATAGRAM_HEADER + WORKING_COUNTER;
        if needed > end {
            return Err(FrameError::TooShort {
                needed,
                available: end,
            });
        }
        let word = u16::from_le_bytes([payload[at + 6], payload[at + 7]]);
        let next = needed + usize::from(word & LENGTH);
        if next > end {
            return Err(FrameError::TooShort {
                needed: next,
                available: end,
            });
        }
        count += 1;
        at = next;
        if word & MORE == 0 {
            return Ok(count);
        }
    }
}

/// Hands out every datagram of a payload that [`check`] has accepted; of any other, those before the break.
pub fn for_each_datagram(payload: &mut [u8], mut visit: impl FnMut(Datagram<'_>)) {
    let mut rest = payload.get_mut(ETHERCAT_HEADER..).unwrap_or_default();
    loop {
        let Some((header, tail)) = rest.split_at_mut_checked(DATAGRAM_HEADER) else {
            return;
        };
        let word = u16::from_le_bytes([header[6], header[7]]);
        let Some((data, tail)) = tail.split_at_mut_checked(usize::from(word & LENGTH)) else {
            return;
        };
        let Some((counter, tail)) = tail.split_at_mut_checked(WORKING_COUNTER) else {
            return;
        };
        visit(Datagram {
            header,
            data,
            counter,
        });
        if word & MORE == 0 {
            return;
        }
        rest = tail;
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A payload of datagrams (command, address, data), for tests of this crate.
    pub(crate) fn payload(datagrams: &[(u8, u32, &[u8])]) -> Vec<u8> {
        let mut bytes = vec![0, 0];
        for (i, (command, address, data)) in datagrams.iter().enumerate() {
            let more = if i + 1 < datagrams.len() { MORE } else { 0 };
            bytes.extend([*command, i as u8]);
            bytes.extend(address.to_le_bytes());
            bytes.extend((data.len() as u16 | more).to_le_bytes());
            bytes.extend([0, 0]);
            bytes.extend(*data);
            bytes.extend([0, 0]);
        }
        let header = (bytes.len() - ETHERCAT_HEADER) as u16 | TYPE_DATAGRAMS << 12;
        bytes[..2].copy_from_slice(&header.to_le_bytes());
        bytes
    }

    #[test]
    fn datagrams_are_found_and_changed_in_place() {
        let mut bytes = payload(&[(1, 0x0130_0000, &[1, 2]), (12, 0x1234_5678, &[3; 5])]);
        assert_eq!(check(&bytes), Ok(2));
        let mut seen = Vec::new();
        for_each_datagram(&mut bytes, |mut d| {
            seen.push((
                d.command(),
                d.device_address(),
                d.offset(),
                d.logical_address(),
                d.data.len(),
            ));
            d.count(3);
            d.data[0] = 9;
        });
        assert_eq!(seen[0], (Command::Aprd, 0, 0x0130, 0x0130_0000, 2));
        assert_eq!(seen[1], (Command::Lrw, 0x5678, 0x1234, 0x1234_5678, 5));
        for_each_datagram(&mut bytes, |d| {
            assert_eq!((d.working_counter(), d.data[0]), (3, 9));
        });
    }

    #[test]
    fn broken_lengths_are_refused() {
        let good = payload(&[(1, 0, &[0; 8])]);
        for cut in 0..good.len() {
            assert!(check(&good[..cut]).is_err(), "cut at {cut}");
        }
        let mut too_long = good.clone();
        too_long[8] = 9;
        assert!(matches!(check(&too_long), Err(FrameError::TooShort { .. })));
        let mut other_type = good.clone();
        other_type[1] = 0x40;
        assert_eq!(check(&other_type), Err(FrameError::Foreign));
        let mut endless = good;
        endless[9] |= 0x80;
        assert!(matches!(check(&endless), Err(FrameError::TooShort { .. })));
    }
}
