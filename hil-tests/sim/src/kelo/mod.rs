//! A KELO drive: two hub motors on a freely turning pivot, as one EtherCAT SubDevice.
//!
//! Turns process data into a [`DriveCommand`] and the plant's answer into process data. Motor 1 is the right wheel
//! with its sign inverted, motor 2 the left wheel. Motors have power only in OP, while outputs are written, the
//! motor is enabled, no emergency bit is set, the supply is in range and the motor has no fault.
//!
//! Known from the vendor: process data layout, command and status bits, healthy status values. Assumed here: the
//! vendor id, the supply range, the motors' electrical values, and the sign of the differential modes (a positive
//! difference speeds up the right wheel).

mod handle;
pub mod pdo;
mod sensors;

pub use handle::{DriveHandle, DriveStatistics, Extremes};

use crate::ethercat::eeprom::ReadSize;
use crate::ethercat::sii::{Identity, Pdo, Sii, SyncManagerUse};
use crate::ethercat::sync_manager::SyncManager;
use crate::ethercat::{Application, Cycle, FaultHandle, Segment, StatisticsHandle, SubDevice};
use crate::plant::{DriveCommand, DriveFeedback, Plant};
use handle::Injected;
use pdo::{Mode, Outputs, command, status};

/// Stands in for the vendor's number, which is not public; "KELO" in ASCII.
pub const VENDOR_ID: u32 = 0x4B45_4C4F;
/// The product code of current drives.
pub const PRODUCT_CODE: u32 = 0x0170_5011;
/// Fastest speed of a wheel.
pub const MAX_WHEEL_RAD_S: f64 = 35.0;

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

/// Supply below which the motors have no power.
const MIN_SUPPLY_V: f64 = 16.0;
/// Supply above which the motors have no power.
const MAX_SUPPLY_V: f64 = 60.0;

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
}

impl Kelo {
    /// A drive that moves `plant`.
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
        }
    }

    /// Injects faults and reads statistics.
    pub fn handle(&self) -> DriveHandle {
        self.handle.clone()
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
    }
}

/// What the outputs ask of the wheels, forward positive, before any limit of the drive.
fn drive_command(outputs: &Outputs) -> DriveCommand {
    let [first, second] = outputs.setpoint.map(f64::from);
    let upper = outputs.upper.map(f64::from);
    let lower = outputs.lower.map(f64::from);
    // A limit that is no number, or on the wrong side of 0, leaves nothing.
    let magnitude = |i: usize| upper[i].min(-lower[i]).max(0.0);
    let both = magnitude(0) + magnitude(1);
    // A current accelerates towards the speed limit on its side.
    let towards = |current_a: f64, limit_rad_s: f64| current_a.signum() * limit_rad_s;
    let (left, right, left_limit, right_limit) = match outputs.mode() {
        Mode::Velocity => (second, -first, magnitude(1), magnitude(0)),
        Mode::DifferentialVelocity => (first - second, first + second, both, both),
        Mode::Torque => (
            towards(second, magnitude(1)),
            -towards(first, magnitude(0)),
            second.abs(),
            first.abs(),
        ),
        Mode::DifferentialTorque => {
            let (left, right) = (first - second, first + second);
            (
                towards(left, both),
                towards(right, both),
                left.abs(),
                right.abs(),
            )
        }
    };
    DriveCommand {
        left_enabled: outputs.command1 & command::ENABLE_2 != 0,
        right_enabled: outputs.command1 & command::ENABLE_1 != 0,
        left_rad_s: left,
        right_rad_s: right,
        left_current_limit_a: left_limit,
        right_current_limit_a: right_limit,
    }
}

/// Takes the power from motors that must not have it.
fn permitted(mut wanted: DriveCommand, outputs: &Outputs, injected: &Injected) -> DriveCommand {
    let stopped = |emergency, faults| {
        injected.emergency_stop
            || outputs.command1 & emergency != 0
            || injected.status1_set & faults != 0
    };
    wanted.right_enabled &= !stopped(command::EMERGENCY_1, status::FAULTS_1);
    wanted.left_enabled &= !stopped(command::EMERGENCY_2, status::FAULTS_2);
    // A setpoint that is no number never reaches a motor.
    wanted.left_enabled &= wanted.left_rad_s.is_finite() && wanted.left_current_limit_a.is_finite();
    wanted.right_enabled &=
        wanted.right_rad_s.is_finite() && wanted.right_current_limit_a.is_finite();
    wanted
}

/// What the motors can do, and zeros for those without power.
fn limited(wanted: DriveCommand) -> DriveCommand {
    let wheel = |enabled: bool, speed: f64, limit: f64| {
        if enabled {
            (speed.clamp(-MAX_WHEEL_RAD_S, MAX_WHEEL_RAD_S), limit)
        } else {
            (0.0, 0.0)
        }
    };
    let (left_rad_s, left_current_limit_a) = wheel(
        wanted.left_enabled,
        wanted.left_rad_s,
        wanted.left_current_limit_a,
    );
    let (right_rad_s, right_current_limit_a) = wheel(
        wanted.right_enabled,
        wanted.right_rad_s,
        wanted.right_current_limit_a,
    );
    DriveCommand {
        left_rad_s,
        right_rad_s,
        left_current_limit_a,
        right_current_limit_a,
        ..wanted
    }
}

#[cfg(test)]
mod tests;
