//! The drive as a SubDevice: what its EEPROM holds, and its cycle.

use super::demand::{MAX_SUPPLY_V, MIN_SUPPLY_V, drive_command, limited, permitted};
use super::handle::DriveHandle;
use super::pdo::{self, Outputs, command};
use super::sensors;
use crate::ethercat::eeprom::ReadSize;
use crate::ethercat::sii::{Identity, Pdo, Sii, SyncManagerUse};
use crate::ethercat::sync_manager::SyncManager;
use crate::ethercat::{Application, Cycle, FaultHandle, Segment, StatisticsHandle, SubDevice};
use crate::plant::{DriveCommand, DriveFeedback, Plant};

/// Stands in for the vendor's number, which is not public; "KELO" in ASCII.
pub const VENDOR_ID: u32 = 0x4B45_4C4F;
/// The product code of current drives.
pub const PRODUCT_CODE: u32 = 0x0170_5011;

/// SyncManager of the outputs: buffered, watchdog enabled. 0 and 1 are left to a mailbox.
const OUTPUTS_SM: (u8, SyncManager) = (
    2,
    SyncManager {
        start: 0x1100,
        length_bytes: pdo::OUTPUT_BYTES as u16,
        control: 0x64,
        active: true,
    },
);
/// SyncManager of the inputs: buffered.
const INPUTS_SM: (u8, SyncManager) = (
    3,
    SyncManager {
        start: 0x1200,
        length_bytes: pdo::INPUT_BYTES as u16,
        control: 0x20,
        active: true,
    },
);
/// Where a mailbox would be.
const MAILBOX_SM: [SyncManager; 2] = [
    SyncManager {
        start: 0x1000,
        length_bytes: 0,
        control: 0x26,
        active: false,
    },
    SyncManager {
        start: 0x1080,
        length_bytes: 0,
        control: 0x22,
        active: false,
    },
];

/// What differs from drive to drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KeloOptions {
    /// Vendor, product, revision, serial number.
    pub identity: Identity,
    /// Second station address, 0 for none.
    pub alias: u16,
    /// Bytes that a read of the EEPROM returns.
    pub eeprom_read_size: ReadSize,
}

impl Default for KeloOptions {
    fn default() -> KeloOptions {
        KeloOptions {
            identity: Identity {
                vendor_id: VENDOR_ID,
                product_code: PRODUCT_CODE,
                revision: 1,
                serial: 1,
            },
            alias: 0,
            eeprom_read_size: ReadSize::Eight,
        }
    }
}

/// A segment of one KELO drive, with everything to watch and disturb it.
pub struct SimulatedDrive {
    /// The segment, to be served.
    pub segment: Segment,
    /// Faults of the bus.
    pub faults: FaultHandle,
    /// What the bus has seen.
    pub statistics: StatisticsHandle,
    /// Faults of the drive, and the setpoints it received.
    pub drive: DriveHandle,
}

impl SimulatedDrive {
    /// A drive that moves `plant`, alone on its bus.
    #[must_use]
    pub fn new(plant: Box<dyn Plant>, options: KeloOptions) -> SimulatedDrive {
        let kelo = Kelo::new(plant, options);
        let drive = kelo.handle();
        let segment = Segment::new(vec![SubDevice::new(
            Box::new(kelo),
            options.eeprom_read_size,
        )]);
        SimulatedDrive {
            faults: segment.faults(),
            statistics: segment.statistics(),
            segment,
            drive,
        }
    }
}

/// The drive's application.
pub struct Kelo {
    plant: Box<dyn Plant>,
    options: KeloOptions,
    handle: DriveHandle,
    /// Setpoints that wait for their time.
    waiting: Option<Outputs>,
    applied: Option<Outputs>,
    setpoint_ts_ns: u64,
    /// Wheel angles (left, right) that the encoders call 0.
    zero_rad: Option<(f64, f64)>,
    frozen: Option<(u64, DriveFeedback)>,
    /// Where the encoders of the left and the right wheel and of the pivot got stuck.
    stuck_rad: [Option<f64>; 3],
}

impl Kelo {
    /// A drive that moves `plant`.
    #[must_use]
    pub fn new(plant: Box<dyn Plant>, options: KeloOptions) -> Kelo {
        Kelo {
            plant,
            options,
            handle: DriveHandle::default(),
            waiting: None,
            applied: None,
            setpoint_ts_ns: 0,
            zero_rad: Some((0.0, 0.0)),
            frozen: None,
            stuck_rad: [None; 3],
        }
    }

    /// Injects faults and reads statistics.
    #[must_use]
    pub fn handle(&self) -> DriveHandle {
        self.handle.clone()
    }

    /// What the encoders of the left and the right wheel and of the pivot say, those that are stuck included.
    fn read_encoders(&mut self, feedback: &DriveFeedback, stuck: [bool; 3]) -> [f64; 3] {
        let mut read_rad = [feedback.left_rad, feedback.right_rad, feedback.pivot_rad];
        for ((read_rad, stuck), at_rad) in read_rad.iter_mut().zip(stuck).zip(&mut self.stuck_rad) {
            if stuck {
                *read_rad = *at_rad.get_or_insert(*read_rad);
            } else {
                *at_rad = None;
            }
        }
        read_rad
    }

    /// Takes new setpoints, now or at their time, and forgets all when outputs are not valid.
    fn take_outputs(&mut self, cycle: &Cycle<'_>) {
        let Some(bytes) = cycle.outputs else {
            (self.waiting, self.applied) = (None, None);
            return;
        };
        if cycle.outputs_are_new {
            let outputs = Outputs::decode(bytes);
            self.handle.record(&outputs);
            self.setpoint_ts_ns = cycle.system_time_ns;
            self.waiting = Some(outputs);
        }
        if let Some(outputs) = self.waiting {
            let timed = outputs.command1 & command::USE_TIMESTAMP != 0;
            if !timed || outputs.timestamp_ns <= cycle.system_time_ns {
                self.applied = self.waiting.take();
            }
        }
    }
}

impl Application for Kelo {
    fn sii(&self) -> Sii {
        let pdo = |index, entry_index, sync_manager, entries| Pdo {
            index,
            entry_index,
            sync_manager,
            entries,
        };
        Sii {
            identity: self.options.identity,
            alias: self.options.alias,
            name: "KELO Drive".into(),
            group: "Drives".into(),
            description: "KELO Drive (simulated)".into(),
            sync_managers: vec![
                (MAILBOX_SM[0], SyncManagerUse::MailboxOut),
                (MAILBOX_SM[1], SyncManagerUse::MailboxIn),
                (OUTPUTS_SM.1, SyncManagerUse::Outputs),
                (INPUTS_SM.1, SyncManagerUse::Inputs),
            ],
            outputs: pdo(0x1600, 0x7000, OUTPUTS_SM.0, pdo::output_entries()),
            inputs: pdo(0x1A00, 0x6000, INPUTS_SM.0, pdo::input_entries()),
        }
    }

    fn cycle(&mut self, cycle: Cycle<'_>) {
        self.take_outputs(&cycle);
        let injected = self.handle.injected();
        let supply_v = |measured: f64| injected.bus_voltage_v.unwrap_or(measured);
        // The supply is known only after the exchange; an injected one is known before.
        let in_range = (MIN_SUPPLY_V..=MAX_SUPPLY_V).contains(&supply_v(24.0));
        let command = match &self.applied {
            Some(outputs) if in_range => {
                limited(permitted(drive_command(outputs), outputs, &injected))
            }
            _ => DriveCommand::OFF,
        };
        let mut feedback = self.plant.exchange(cycle.now_ns, &command);
        feedback.bus_voltage_v = supply_v(feedback.bus_voltage_v);
        let sample = (cycle.system_time_ns, feedback);
        let (sensor_ts_ns, feedback) = if injected.sensors_frozen {
            *self.frozen.get_or_insert(sample)
        } else {
            sample
        };
        if !injected.sensors_frozen {
            self.frozen = None;
        }
        let zero = *self
            .zero_rad
            .get_or_insert((feedback.left_rad, feedback.right_rad));
        let ahead_rad = injected.encoders_ahead_rad;
        let zero = (zero.0 - ahead_rad, zero.1 - ahead_rad);
        let [left_rad, right_rad, pivot_rad] =
            self.read_encoders(&feedback, injected.encoder_stuck);
        let feedback = DriveFeedback {
            left_rad,
            right_rad,
            pivot_rad,
            ..feedback
        };
        let mut inputs = sensors::inputs(&feedback, &command, zero);
        inputs.status1 = (inputs.status1 | injected.status1_set) & !injected.status1_cleared;
        inputs.status2 = injected.status2.unwrap_or(inputs.status2);
        inputs.sensor_ts_ns = sensor_ts_ns;
        inputs.imu_ts_ns = sensor_ts_ns;
        inputs.setpoint_ts_ns = self.setpoint_ts_ns;
        inputs.encode(cycle.inputs);
    }

    fn power_on(&mut self) {
        (self.waiting, self.applied, self.setpoint_ts_ns) = (None, None, 0);
        // Wheel encoders count from here; the pivot's is absolute.
        self.zero_rad = None;
        self.handle.set_encoders_ahead(0.0);
    }
}
