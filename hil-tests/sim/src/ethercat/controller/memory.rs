//! How datagrams reach a controller's memory: registers byte by byte, process memory through SyncManagers, logical
//! addresses through FMMUs.

use super::esc::Esc;
use super::fmmu::copy_bits;
use super::registers as reg;
use crate::ethercat::frame::{Datagram, MAX_PAYLOAD};

#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    Read,
    Write,
}

impl Esc {
    /// Reads memory for a datagram. False if no byte could be read; the buffer then stays as it was.
    pub(super) fn read(&mut self, address: u16, buffer: &mut [u8]) -> bool {
        let start = usize::from(address);
        let end = (start + buffer.len()).min(self.memory.len());
        if start >= end || !self.pass_sync_managers(start, end, Direction::Read) {
            return false;
        }
        let (inside, beyond) = buffer.split_at_mut(end - start);
        inside.copy_from_slice(&self.memory[start..end]);
        beyond.fill(0);
        let event = usize::from(reg::AL_STATUS);
        if start < event + 2 && event < end {
            let events = self.get_u16(reg::EVENT_REQUEST) & !reg::EVENT_AL_STATUS;
            self.set(reg::EVENT_REQUEST, &events.to_le_bytes());
        }
        true
    }

    /// Writes memory for a datagram. False if no byte could be written.
    pub(super) fn write(&mut self, address: u16, data: &[u8]) -> bool {
        let start = usize::from(address);
        let end = (start + data.len()).min(self.memory.len());
        if start >= end || !self.pass_sync_managers(start, end, Direction::Write) {
            return false;
        }
        let registers_end = end.min(usize::from(reg::PROCESS_MEMORY));
        let mut written = end > usize::from(reg::PROCESS_MEMORY);
        for at in start..registers_end {
            if reg::writable(at as u16) && !self.sii_is_locked(at) {
                self.memory[at] = data[at - start];
                written = true;
            }
        }
        let ram = start.max(usize::from(reg::PROCESS_MEMORY));
        if ram < end {
            self.memory[ram..end].copy_from_slice(&data[ram - start..end - start]);
        }
        if start < registers_end && written {
            self.registers_written(address, registers_end as u16);
        }
        written
    }

    /// While the processor owns the SII, its command registers do not take writes.
    fn sii_is_locked(&self, at: usize) -> bool {
        (0x0502..0x0510).contains(&at) && self.memory[usize::from(reg::SII_ACCESS)] & 1 != 0
    }

    /// Whether the SyncManagers let a MainDevice access the bytes from `start` to `end`. Buffers open with their
    /// first byte and close with their last; a complete write is then handed to the processor.
    fn pass_sync_managers(&mut self, start: usize, end: usize, direction: Direction) -> bool {
        if end <= usize::from(reg::PROCESS_MEMORY) {
            return true;
        }
        let (mut opened, mut written, mut fed) = (self.opened, self.written, false);
        for (i, sm) in self.sync_managers.iter().enumerate() {
            let (area, occupied) = (sm.area(), sm.occupied());
            if !sm.active || area.is_empty() || end <= occupied.start || occupied.end <= start {
                continue;
            }
            let bit = 1 << i;
            let right_way = sm.is_output() == (direction == Direction::Write);
            let has_data = sm.is_output() || self.filled & bit != 0;
            if end > area.end || !right_way || !has_data {
                return false;
            }
            if start <= area.start {
                opened |= bit;
            }
            if opened & bit == 0 {
                return false;
            }
            if end == area.end {
                opened &= !bit;
                if sm.is_output() {
                    written |= bit;
                    fed |= sm.feeds_watchdog();
                }
            }
        }
        (self.opened, self.written) = (opened, written);
        if fed {
            self.watchdog.feed(self.now_ns);
        }
        true
    }

    /// Carries out LRD, LWR or LRW through the FMMUs.
    pub(super) fn execute_logical(
        &mut self,
        datagram: &mut Datagram<'_>,
        reads: bool,
        writes: bool,
    ) {
        let length = datagram.data.len();
        let logical = datagram.logical_address();
        if length > MAX_PAYLOAD {
            return;
        }
        let mut sent = std::mem::take(&mut self.sent);
        sent.clear();
        sent.extend_from_slice(datagram.data);
        let (mut read, mut written) = (false, false);
        // Downwards, so that the unit with the lowest number wins where several map the same bit.
        for i in (0..self.fmmus.len()).rev() {
            let fmmu = self.fmmus[i];
            let Some(run) = fmmu.map(logical, length) else {
                continue;
            };
            let first = run.physical_bit / 8;
            let last = (run.physical_bit + run.bits - 1) / 8;
            if last >= self.memory.len() as u64 {
                continue;
            }
            let (address, bytes) = (first as u16, (last - first + 1) as usize);
            if let Some((at, _, count)) = run.bytes() {
                let place = at..at + count;
                if writes && fmmu.write {
                    written |= self.write(address, &sent[place.clone()]);
                }
                if reads && fmmu.read {
                    read |= self.read(address, &mut datagram.data[place]);
                }
                continue;
            }
            let mut scratch = [0; MAX_PAYLOAD + 1];
            let scratch = &mut scratch[..bytes];
            if writes && fmmu.write {
                // Bits beside the mapped ones keep their value.
                scratch.copy_from_slice(&self.memory[first as usize..=last as usize]);
                copy_bits(&sent, run.data_bit, scratch, run.physical_bit % 8, run.bits);
                written |= self.write(address, scratch);
            }
            if reads && fmmu.read && self.read(address, scratch) {
                read = true;
                copy_bits(
                    scratch,
                    run.physical_bit % 8,
                    datagram.data,
                    run.data_bit,
                    run.bits,
                );
            }
        }
        self.sent = sent;
        let write_counts = if reads { 2 } else { 1 };
        datagram.count(u16::from(read) + if written { write_counts } else { 0 });
    }

    /// The processor takes an output buffer, if it was completely written since the last call.
    pub fn take_outputs(&mut self, index: usize, buffer: &mut [u8]) -> bool {
        let Some(sm) = self.sync_managers.get(index) else {
            return false;
        };
        let area = sm.area();
        if self.written & 1 << index == 0
            || area.len() != buffer.len()
            || area.end > self.memory.len()
        {
            return false;
        }
        buffer.copy_from_slice(&self.memory[area]);
        self.written &= !(1 << index);
        true
    }

    /// The processor fills an input buffer.
    pub fn put_inputs(&mut self, index: usize, data: &[u8]) {
        let Some(sm) = self.sync_managers.get(index) else {
            return;
        };
        let area = sm.area();
        if sm.active && !sm.is_output() && area.len() == data.len() && area.end <= self.memory.len()
        {
            self.memory[area].copy_from_slice(data);
            self.filled |= 1 << index;
        }
    }

    /// Whether the processor has filled an input buffer since it was set up.
    #[must_use]
    pub fn is_filled(&self, index: usize) -> bool {
        self.filled & 1 << index != 0
    }

    /// The processor gives up the process data: nothing is filled, nothing was written.
    pub fn forget_process_data(&mut self) {
        (self.opened, self.written, self.filled) = (0, 0, 0);
    }
}
