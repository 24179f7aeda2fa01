//! The SubDevice controller (ESC): its state, and the side of the drive's processor.
//!
//! The bus side is `commands.rs`: datagram by datagram. Every time is monotonic nanoseconds and never goes back.

use super::clock::Clock;
use super::eeprom::Eeprom;
use super::fmmu::Fmmu;
use super::registers as reg;
use super::sync_manager::SyncManager;
use super::watchdog::{self, Watchdog};

/// One controller.
#[derive(Debug, Clone)]
pub struct Esc {
    pub(super) memory: Box<[u8]>,
    pub(super) eeprom: Eeprom,
    pub(super) clock: Clock,
    pub(super) watchdog: Watchdog,
    pub(super) sync_managers: [SyncManager; reg::SYNC_MANAGER_COUNT],
    pub(super) fmmus: [Fmmu; reg::FMMU_COUNT],
    /// SyncManagers (bits) whose buffer a MainDevice has begun to use and not finished.
    pub(super) opened: u8,
    /// Output SyncManagers (bits) completely written since the processor last looked.
    pub(super) written: u8,
    /// Input SyncManagers (bits) that the processor has filled.
    pub(super) filled: u8,
    pub(super) al_request: Option<u16>,
    pub(super) links: [bool; 2],
    /// Time of the frame being processed.
    pub(super) now_ns: u64,
    /// Time of the frame when it comes back through the last port.
    pub(super) returns_ns: u64,
    /// The data of the logical datagram that is being carried out, as it came.
    pub(super) sent: Vec<u8>,
    /// Logical datagrams pass by untouched.
    pub(super) process_data_withheld: bool,
    /// It is built without a process-data watchdog.
    pub(super) watchdog_missing: bool,
}

impl Esc {
    /// A controller after power-on.
    #[must_use]
    pub fn new(eeprom: Eeprom) -> Esc {
        let mut esc = Esc {
            memory: vec![0; reg::MEMORY].into_boxed_slice(),
            eeprom,
            clock: Clock::default(),
            watchdog: Watchdog::default(),
            sync_managers: Default::default(),
            fmmus: Default::default(),
            opened: 0,
            written: 0,
            filled: 0,
            al_request: None,
            links: [true, false],
            now_ns: 0,
            returns_ns: 0,
            sent: Vec::new(),
            process_data_withheld: false,
            watchdog_missing: false,
        };
        esc.power_on(0);
        esc
    }

    /// Everything back to its default, as after power-on.
    pub fn power_on(&mut self, now_ns: u64) {
        self.memory.fill(0);
        self.eeprom.power_on();
        self.clock = Clock::new(now_ns);
        self.watchdog = Watchdog::default();
        self.sync_managers = Default::default();
        self.fmmus = Default::default();
        (self.opened, self.written, self.filled) = (0, 0, 0);
        self.al_request = None;
        self.memory[..reg::INFORMATION_DEFAULT.len()].copy_from_slice(&reg::INFORMATION_DEFAULT);
        self.set(reg::STATION_ALIAS, &self.eeprom.alias().to_le_bytes());
        self.set(reg::DL_CONTROL, &reg::DL_CONTROL_DEFAULT.to_le_bytes());
        self.set(reg::PDI_CONTROL, &[0x05]);
        self.set(
            reg::WATCHDOG_DIVIDER,
            &reg::WATCHDOG_DIVIDER_DEFAULT.to_le_bytes(),
        );
        self.set(
            reg::WATCHDOG_TIME_PDI,
            &reg::WATCHDOG_TIME_DEFAULT.to_le_bytes(),
        );
        self.set(
            reg::WATCHDOG_TIME_PROCESS_DATA,
            &reg::WATCHDOG_TIME_DEFAULT.to_le_bytes(),
        );
        self.set(reg::DC_SPEED_START, &0x1000u16.to_le_bytes());
        self.set(reg::DC_FILTER, &0x0C00u16.to_le_bytes());
        self.begin_frame(now_ns, now_ns);
    }

    /// Tells which of ports 0 and 1 have a link.
    pub fn set_links(&mut self, links: [bool; 2]) {
        for (port, (old, new)) in self.links.into_iter().zip(links).enumerate() {
            if old && !new {
                let at = usize::from(reg::LOST_LINKS) + port;
                self.memory[at] = self.memory[at].saturating_add(1);
            }
        }
        self.links = links;
    }

    /// Lets logical datagrams pass by, or not.
    pub fn withhold_process_data(&mut self, withheld: bool) {
        self.process_data_withheld = withheld;
    }

    /// Counts a frame whose structure is broken.
    pub fn count_malformed(&mut self) {
        let at = usize::from(reg::PROCESSING_UNIT_ERRORS);
        self.memory[at] = self.memory[at].saturating_add(1);
    }

    /// Whether frames of other protocols are passed on.
    #[must_use]
    pub fn forwards_foreign_frames(&self) -> bool {
        self.memory[usize::from(reg::DL_CONTROL)] & 1 == 0
    }

    /// Brings the registers that change by themselves up to date: a frame arrives at `now_ns` and will come back
    /// through the last port at `returns_ns`.
    pub fn begin_frame(&mut self, now_ns: u64, returns_ns: u64) {
        self.now_ns = now_ns;
        self.returns_ns = returns_ns;
        self.set(
            reg::DC_SYSTEM_TIME,
            &self.clock.system_ns(now_ns).to_le_bytes(),
        );
        self.set(reg::DC_DIFFERENCE, &self.clock.difference().to_le_bytes());
        self.set(reg::SII_CONTROL, &self.eeprom.status(now_ns).to_le_bytes());
        self.set(reg::SII_DATA, &self.eeprom.data());
        self.set(
            reg::WATCHDOG_STATUS,
            &u16::from(self.watchdog.is_ok()).to_le_bytes(),
        );
        self.set(reg::WATCHDOG_COUNTER, &[self.watchdog.expirations()]);
        self.set(reg::DL_STATUS, &self.dl_status().to_le_bytes());
    }

    fn dl_status(&self) -> u16 {
        // Bit 0: the processor runs. Ports 2 and 3 do not exist: their loops are closed.
        let mut status = 0x0001 | 1 << 12 | 1 << 14;
        for (port, link) in self.links.into_iter().enumerate() {
            status |= if link {
                1 << (4 + port) | 1 << (9 + 2 * port)
            } else {
                1 << (8 + 2 * port)
            };
        }
        status
    }

    /// The last request for a state since the processor looked.
    pub fn take_al_request(&mut self) -> Option<u16> {
        self.al_request.take()
    }

    /// Publishes state and code.
    pub fn set_al_status(&mut self, status: u16, code: u16) {
        if self.get_u16(reg::AL_STATUS) != status {
            let events = self.get_u16(reg::EVENT_REQUEST) | reg::EVENT_AL_STATUS;
            self.set(reg::EVENT_REQUEST, &events.to_le_bytes());
        }
        self.set(reg::AL_STATUS, &status.to_le_bytes());
        self.set(reg::AL_STATUS_CODE, &code.to_le_bytes());
    }

    /// Starts the process data watchdog, if the SyncManager with this number feeds it; stops it otherwise.
    pub fn start_watchdog(&mut self, index: usize, now_ns: u64) {
        if self.sync_manager(index).feeds_watchdog() {
            self.watchdog.feed(now_ns);
        } else {
            self.watchdog.stop();
        }
    }

    /// Looks at the process data watchdog; true once, when it expires.
    pub fn check_watchdog(&mut self, now_ns: u64) -> bool {
        self.watchdog.check(now_ns, self.watchdog_timeout_ns())
    }

    /// From now on SyncManagers take no watchdog bit.
    pub fn have_no_watchdog(&mut self) {
        self.watchdog_missing = true;
    }

    /// Stops the clock or lets it go on.
    pub fn set_clock_stopped(&mut self, stopped: bool, now_ns: u64) {
        self.clock.set_stopped(stopped, now_ns);
    }

    /// How a SyncManager is set up; an inactive one for a number that does not exist.
    #[must_use]
    pub fn sync_manager(&self, index: usize) -> SyncManager {
        self.sync_managers.get(index).copied().unwrap_or_default()
    }

    /// Time of the process data watchdog as the registers say; `None` when it is off.
    #[must_use]
    pub fn watchdog_timeout_ns(&self) -> Option<u64> {
        watchdog::timeout_ns(
            self.get_u16(reg::WATCHDOG_DIVIDER),
            self.get_u16(reg::WATCHDOG_TIME_PROCESS_DATA),
        )
    }

    /// System time at `now_ns`.
    #[must_use]
    pub fn system_time_ns(&self, now_ns: u64) -> u64 {
        self.clock.system_ns(now_ns)
    }

    pub(super) fn set(&mut self, address: u16, bytes: &[u8]) {
        let at = usize::from(address);
        self.memory[at..at + bytes.len()].copy_from_slice(bytes);
    }

    pub(super) fn get_u16(&self, address: u16) -> u16 {
        u16::from_le_bytes(array(&self.memory, address.into()))
    }

    pub(super) fn get_u32(&self, address: u16) -> u32 {
        u32::from_le_bytes(array(&self.memory, address.into()))
    }
}

pub(super) fn array<const N: usize>(memory: &[u8], at: usize) -> [u8; N] {
    let mut bytes = [0; N];
    bytes.copy_from_slice(&memory[at..at + N]);
    bytes
}
