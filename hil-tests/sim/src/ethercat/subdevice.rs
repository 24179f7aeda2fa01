//! One SubDevice: controller, state machine and the application behind it.

use super::al::{AlCode, AlState, AlStatus};
use super::controller::eeprom::{Eeprom, ReadSize};
use super::controller::esc::Esc;
use super::controller::sii::{Sii, SyncManagerUse};
use super::controller::sync_manager::SyncManager;
use super::frame::Datagram;

/// Longest time between two cycles of an application while it is being served.
const APPLICATION_PERIOD_NS: u64 = 1_000_000;
/// Time that the EEPROM takes for a read.
const EEPROM_READ_NS: u64 = 50_000;

/// What a SubDevice does with its process data.
pub trait Application: Send {
    /// What its EEPROM holds. It must be the same at every call.
    fn sii(&self) -> Sii;

    /// One cycle: after outputs were written, and at least every few milliseconds.
    fn cycle(&mut self, cycle: Cycle<'_>);

    /// Power came back.
    fn power_on(&mut self) {}
}

/// What an application sees in one cycle.
#[derive(Debug)]
pub struct Cycle<'c> {
    /// Monotonic time.
    pub now_ns: u64,
    /// Distributed clock's system time.
    pub system_time_ns: u64,
    /// State.
    pub state: AlState,
    /// The last outputs, while they are valid: in OP, after they were written. `None` asks for the safe state.
    pub outputs: Option<&'c [u8]>,
    /// The outputs were written since the last cycle.
    pub outputs_are_new: bool,
    /// Inputs, to be filled completely.
    pub inputs: &'c mut [u8],
}

/// A process image's SyncManager and its content.
#[derive(Debug)]
struct Image {
    index: usize,
    expected: SyncManager,
    bytes: Vec<u8>,
}

/// One SubDevice.
pub struct SubDevice {
    esc: Esc,
    al: AlStatus,
    application: Box<dyn Application>,
    mailboxes: Vec<(usize, SyncManager)>,
    outputs: Option<Image>,
    inputs: Option<Image>,
    outputs_valid: bool,
    last_cycle_ns: u64,
    powered: bool,
    watchdog_trips: u64,
}

impl SubDevice {
    /// A SubDevice with this application; reads of its EEPROM return `read_size` bytes.
    #[must_use]
    pub fn new(application: Box<dyn Application>, read_size: ReadSize) -> SubDevice {
        let sii = application.sii();
        let find = |wanted| {
            let mut all = sii.sync_managers.iter().enumerate();
            all.find(|(_, (_, used_for))| *used_for == wanted)
                .map(|(index, (expected, _))| Image {
                    index,
                    expected: *expected,
                    bytes: vec![0; usize::from(expected.length_bytes)],
                })
        };
        let is_mailbox = |used_for| {
            matches!(
                used_for,
                SyncManagerUse::MailboxOut | SyncManagerUse::MailboxIn
            )
        };
        let mailboxes = sii.sync_managers.iter().enumerate();
        let mailboxes = mailboxes.filter(|(_, (sm, used_for))| sm.active && is_mailbox(*used_for));
        let mut subdevice = SubDevice {
            esc: Esc::new(Eeprom::new(sii.build(), read_size, EEPROM_READ_NS)),
            al: AlStatus::default(),
            mailboxes: mailboxes.map(|(index, (sm, _))| (index, *sm)).collect(),
            outputs: find(SyncManagerUse::Outputs),
            inputs: find(SyncManagerUse::Inputs),
            application,
            outputs_valid: false,
            last_cycle_ns: 0,
            powered: true,
            watchdog_trips: 0,
        };
        subdevice.publish();
        subdevice
    }

    /// The controller.
    pub fn esc(&mut self) -> &mut Esc {
        &mut self.esc
    }

    /// State and error.
    #[must_use]
    pub fn al_status(&self) -> AlStatus {
        self.al
    }

    /// How often the process data watchdog took it out of OP.
    #[must_use]
    pub fn watchdog_trips(&self) -> u64 {
        self.watchdog_trips
    }

    /// Whether it has power.
    #[must_use]
    pub fn is_powered(&self) -> bool {
        self.powered
    }

    /// A frame arrives at `now_ns` and will come back at `returns_ns`.
    pub fn begin_frame(&mut self, now_ns: u64, returns_ns: u64) {
        self.check_watchdog(now_ns);
        self.esc.begin_frame(now_ns, returns_ns);
    }

    /// Carries out one datagram.
    pub fn execute(&mut self, datagram: &mut Datagram<'_>) {
        self.esc.execute(datagram);
    }

    /// The side of the drive's processor: state requests, checks, watchdog, application.
    pub fn cycle(&mut self, now_ns: u64) {
        if !self.powered {
            // The mechanics move without power too.
            if now_ns.saturating_sub(self.last_cycle_ns) >= APPLICATION_PERIOD_NS {
                self.call_application(now_ns, AlState::Init, false);
            }
            return;
        }
        self.check_watchdog(now_ns);
        if let Some(control) = self.esc.take_al_request() {
            let before = self.al.state();
            let verdict = |wanted| {
                self.check_settings(wanted)?;
                self.check_watchdog_time(wanted)
            };
            let mut al = self.al;
            al.request(control, verdict);
            self.al = al;
            if self.al.state() == AlState::Op && before != AlState::Op {
                self.outputs_valid = false;
                if let Some(outputs) = &self.outputs {
                    self.esc.start_watchdog(outputs.index, now_ns);
                }
            }
            self.publish();
        }
        if self.al.state() >= AlState::SafeOp
            && let Err(code) = self.check_settings(AlState::SafeOp)
        {
            self.fall(AlState::PreOp, code);
        }
        self.run_application(now_ns);
    }

    /// Leaves its state for a lower one with an error, as after an internal fault.
    pub fn fall(&mut self, state: AlState, code: AlCode) {
        self.al.fall(state, code);
        self.publish();
    }

    /// The controller restarts: INIT, registers at their defaults. The application keeps running.
    pub fn reset(&mut self, now_ns: u64) {
        self.esc.power_on(now_ns);
        self.al = AlStatus::default();
        self.publish();
    }

    /// Takes its power away or gives it back.
    pub fn set_powered(&mut self, powered: bool, now_ns: u64) {
        if powered && !self.powered {
            self.reset(now_ns);
            self.application.power_on();
        }
        self.powered = powered;
        if !powered {
            self.outputs_valid = false;
            self.call_application(now_ns, AlState::Init, false);
        }
    }

    fn check_watchdog(&mut self, now_ns: u64) {
        if self.powered && self.esc.check_watchdog(now_ns) && self.al.state() == AlState::Op {
            self.watchdog_trips += 1;
            self.fall(AlState::SafeOp, AlCode::WATCHDOG);
        }
    }

    fn check_settings(&self, wanted: AlState) -> Result<(), AlCode> {
        for (index, expected) in &self.mailboxes {
            if !self.esc.sync_manager(*index).agrees_with(expected) {
                return Err(AlCode::INVALID_MAILBOX);
            }
        }
        if wanted >= AlState::SafeOp {
            for (image, code) in [
                (&self.outputs, AlCode::INVALID_OUTPUTS),
                (&self.inputs, AlCode::INVALID_INPUTS),
            ] {
                if let Some(image) = image
                    && !self
                        .esc
                        .sync_manager(image.index)
                        .agrees_with(&image.expected)
                {
                    return Err(code);
                }
            }
        }
        Ok(())
    }

    /// On the way into SAFEOP, as the common slave stack does; afterwards nobody looks.
    fn check_watchdog_time(&self, wanted: AlState) -> Result<(), AlCode> {
        let feeds = { self.outputs.as_ref() }
            .is_some_and(|image| self.esc.sync_manager(image.index).feeds_watchdog());
        if wanted == AlState::SafeOp && feeds && self.esc.watchdog_timeout_ns().is_none() {
            return Err(AlCode::INVALID_WATCHDOG);
        }
        Ok(())
    }

    /// Brings the registers and the validity of process data in line with the state.
    fn publish(&mut self) {
        if self.al.state() < AlState::Op {
            self.outputs_valid = false;
        }
        if self.al.state() < AlState::SafeOp {
            self.esc.forget_process_data();
        }
        self.esc.set_al_status(self.al.register(), self.al.code().0);
    }

    fn run_application(&mut self, now_ns: u64) {
        let mut new = false;
        if let Some(outputs) = &mut self.outputs
            && self.esc.take_outputs(outputs.index, &mut outputs.bytes)
            && self.al.state() == AlState::Op
        {
            new = true;
            self.outputs_valid = true;
        }
        if new
            || now_ns.saturating_sub(self.last_cycle_ns) >= APPLICATION_PERIOD_NS
            || !self.inputs_filled()
        {
            self.call_application(now_ns, self.al.state(), new);
        }
    }

    fn inputs_filled(&self) -> bool {
        self.al.state() < AlState::SafeOp
            || self
                .inputs
                .as_ref()
                .is_none_or(|inputs| self.esc.is_filled(inputs.index))
    }

    fn call_application(&mut self, now_ns: u64, state: AlState, outputs_are_new: bool) {
        self.last_cycle_ns = now_ns;
        let valid = self.outputs_valid;
        let outputs = self
            .outputs
            .as_ref()
            .filter(|_| valid)
            .map(|image| &image.bytes[..]);
        let inputs = self
            .inputs
            .as_mut()
            .map(|image| &mut image.bytes[..])
            .unwrap_or_default();
        let system_time_ns = self.esc.system_time_ns(now_ns);
        self.application.cycle(Cycle {
            now_ns,
            system_time_ns,
            state,
            outputs,
            outputs_are_new,
            inputs,
        });
        if state >= AlState::SafeOp
            && let Some(inputs) = &self.inputs
        {
            self.esc.put_inputs(inputs.index, &inputs.bytes);
        }
    }
}
