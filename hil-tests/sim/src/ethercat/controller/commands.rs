//! What each command of a datagram does to one controller, and what it counts.

use super::esc::Esc;
use super::registers as reg;
use crate::ethercat::frame::{Command, Datagram, MAX_PAYLOAD};

impl Esc {
    /// Carries out one datagram: data, address, working counter and events are changed as the chip does it.
    pub fn execute(&mut self, datagram: &mut Datagram<'_>) {
        let command = datagram.command();
        let offset = datagram.offset();
        match command {
            Command::Nop | Command::Unknown(_) => return,
            Command::Aprd | Command::Apwr | Command::Aprw => {
                if self.take_position(datagram) {
                    let (reads, writes) = (command != Command::Apwr, command != Command::Aprd);
                    self.access(datagram, offset, reads, writes, false);
                }
            }
            Command::Fprd | Command::Fpwr | Command::Fprw => {
                if self.is_addressed(datagram.device_address()) {
                    let (reads, writes) = (command != Command::Fpwr, command != Command::Fprd);
                    self.access(datagram, offset, reads, writes, false);
                }
            }
            Command::Brd | Command::Bwr | Command::Brw => {
                self.take_position(datagram);
                let (reads, writes) = (command != Command::Bwr, command != Command::Brd);
                self.access(datagram, offset, reads, writes, true);
            }
            Command::Armw => {
                let first = self.take_position(datagram);
                self.access(datagram, offset, first, !first, false);
            }
            Command::Frmw => {
                let addressed = self.is_addressed(datagram.device_address());
                self.access(datagram, offset, addressed, !addressed, false);
            }
            Command::Lrd | Command::Lwr | Command::Lrw => {
                if !self.process_data_withheld {
                    let (reads, writes) = (command != Command::Lwr, command != Command::Lrd);
                    self.execute_logical(datagram, reads, writes);
                }
            }
        }
        let events = self.get_u16(reg::EVENT_REQUEST) & self.get_u16(reg::EVENT_MASK);
        datagram.raise_events(events);
    }

    /// Increments the position and tells whether it was this SubDevice's.
    fn take_position(&self, datagram: &mut Datagram<'_>) -> bool {
        let position = datagram.device_address();
        datagram.set_device_address(position.wrapping_add(1));
        position == 0
    }

    fn is_addressed(&self, address: u16) -> bool {
        let by_alias = self.get_u32(reg::DL_CONTROL) & reg::DL_CONTROL_ALIAS != 0;
        address == self.get_u16(reg::STATION_ADDRESS)
            || by_alias && address != 0 && address == self.get_u16(reg::STATION_ALIAS)
    }

    /// Reads, writes or both, and counts: 1 for read, 1 for write, 3 for both.
    fn access(
        &mut self,
        datagram: &mut Datagram<'_>,
        offset: u16,
        reads: bool,
        writes: bool,
        broadcast: bool,
    ) {
        let mut counted = 0;
        if reads && writes {
            let mut old = [0; MAX_PAYLOAD];
            let Some(old) = old.get_mut(..datagram.data.len()) else {
                return;
            };
            if self.read(offset, old) {
                counted += 1;
            }
            if self.write(offset, datagram.data) {
                counted += 2;
            }
            merge(datagram.data, old, broadcast, counted & 1 != 0);
        } else if reads && !broadcast {
            counted += u16::from(self.read(offset, datagram.data));
        } else if reads {
            let mut old = [0; MAX_PAYLOAD];
            let Some(old) = old.get_mut(..datagram.data.len()) else {
                return;
            };
            let read = self.read(offset, old);
            counted += u16::from(read);
            merge(datagram.data, old, broadcast, read);
        } else if self.write(offset, datagram.data) {
            counted += 1;
        }
        datagram.count(counted);
    }
}

/// Puts what was read into a datagram: OR-ed for broadcasts, replaced otherwise, unchanged if nothing was read.
fn merge(data: &mut [u8], read: &[u8], broadcast: bool, success: bool) {
    if !success {
        return;
    }
    for (slot, byte) in data.iter_mut().zip(read) {
        *slot = if broadcast { *slot | byte } else { *byte };
    }
}
