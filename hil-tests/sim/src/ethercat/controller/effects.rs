//! What a write to registers sets off beside changing them.

use super::esc::{Esc, array};
use super::fmmu::Fmmu;
use super::registers as reg;
use super::sync_manager::{SyncManager, WATCHDOG};

impl Esc {
    /// What happens beside the memory when registers were written.
    pub(super) fn registers_written(&mut self, first: u16, end: u16) {
        let touches = |address: u16, bytes: u16| first < address + bytes && address < end;
        if touches(reg::AL_CONTROL, 1) {
            self.al_request = Some(self.get_u16(reg::AL_CONTROL));
        }
        if touches(reg::RX_ERRORS, 8) {
            self.set(reg::RX_ERRORS, &[0; 8]);
        }
        if touches(reg::PROCESSING_UNIT_ERRORS, 2) {
            self.set(reg::PROCESSING_UNIT_ERRORS, &[0; 2]);
        }
        if touches(reg::LOST_LINKS, 4) {
            self.set(reg::LOST_LINKS, &[0; 4]);
        }
        if touches(reg::WATCHDOG_COUNTER, 2) {
            self.watchdog.clear_expirations();
            self.set(reg::WATCHDOG_COUNTER, &[0; 2]);
        }
        let times_the_watchdog =
            touches(reg::WATCHDOG_DIVIDER, 2) || touches(reg::WATCHDOG_TIME_PROCESS_DATA, 2);
        if times_the_watchdog {
            self.watchdog.set(self.watchdog_timeout_ns(), self.now_ns);
        }
        if touches(reg::SII_DATA, 8) {
            self.eeprom
                .set_data(array(&self.memory, reg::SII_DATA.into()));
        }
        if touches(reg::SII_CONTROL, 2) {
            self.sii_command(end);
        }
        if touches(reg::FMMU, 16 * reg::FMMU_COUNT as u16) {
            for (i, fmmu) in self.fmmus.iter_mut().enumerate() {
                *fmmu = Fmmu::decode(&array(&self.memory, reg::FMMU as usize + 16 * i));
            }
        }
        if touches(reg::SYNC_MANAGER, 8 * reg::SYNC_MANAGER_COUNT as u16) {
            self.sync_managers_written();
        }
        if touches(reg::DC_RECEIVE_TIMES, 4) {
            self.latch_receive_times();
        }
        if touches(reg::DC_SYSTEM_TIME, 4) {
            let received = self.get_u32(reg::DC_SYSTEM_TIME);
            self.clock.follow(received, self.now_ns);
        }
        if touches(reg::DC_OFFSET, 12) {
            self.clock.offset_ns = u64::from_le_bytes(array(&self.memory, reg::DC_OFFSET.into()));
            self.clock.delay_ns = self.get_u32(reg::DC_DELAY);
        }
        if touches(reg::DC_SPEED_START, 2) {
            self.clock.reset_loop();
        }
        if times_the_watchdog
            || touches(reg::DC_SYSTEM_TIME, 8)
            || touches(reg::DC_OFFSET, 12)
            || touches(reg::SII_CONTROL, 14)
        {
            self.begin_frame(self.now_ns, self.returns_ns);
        }
    }

    fn sii_command(&mut self, written_end: u16) {
        let control = self.get_u16(reg::SII_CONTROL);
        // Only the control word carries out a command, and only while the MainDevice owns the interface.
        if written_end < reg::SII_CONTROL + 2 || self.memory[usize::from(reg::SII_ACCESS)] & 1 != 0
        {
            return;
        }
        self.eeprom
            .command(control, self.get_u32(reg::SII_ADDRESS), self.now_ns);
        if self.eeprom.take_reloaded() {
            self.set(reg::STATION_ALIAS, &self.eeprom.alias().to_le_bytes());
        }
    }

    fn sync_managers_written(&mut self) {
        for i in 0..reg::SYNC_MANAGER_COUNT {
            let old = self.sync_managers[i];
            let first = reg::SYNC_MANAGER + 8 * i as u16;
            if old.active {
                // It takes no settings then.
                self.set(first, &old.settings());
            }
            if self.watchdog_missing {
                self.memory[usize::from(first) + 4] &= !WATCHDOG;
            }
            let new = SyncManager::decode(&array(&self.memory, reg::SYNC_MANAGER as usize + 8 * i));
            if new != self.sync_managers[i] {
                self.sync_managers[i] = new;
                let others = !(1 << i);
                self.opened &= others;
                self.written &= others;
                self.filled &= others;
            }
        }
    }

    fn latch_receive_times(&mut self) {
        let arrived = self.clock.local_ns(self.now_ns);
        let returned = self.clock.local_ns(self.returns_ns) as u32;
        self.set(reg::DC_RECEIVE_TIMES, &(arrived as u32).to_le_bytes());
        let port_1 = if self.links[1] { returned } else { 0 };
        self.set(reg::DC_RECEIVE_TIMES + 4, &port_1.to_le_bytes());
        self.set(reg::DC_RECEIVE_TIME_UNIT, &arrived.to_le_bytes());
    }
}
