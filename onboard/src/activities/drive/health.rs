//! What the drive says of itself, judged.

use drivers::kelo::{Faults, Inputs, StampWatch, Status, VoltageLimits};

use crate::realtime::clock::MILLISECOND_NS;
use crate::symbols::faults::Fault;

/// How long a fault that the drive reports is taken for noise.
const FAULT_NS: u64 = 50 * MILLISECOND_NS;
/// A drive whose sensor time stands still for `STALL_NS` has failed.
const STALL_NS: u64 = 200 * MILLISECOND_NS;
/// How long a drive may take to power its motors when told to; after that, an emergency stop is assumed.
const POWER_NS: u64 = 200 * MILLISECOND_NS;
/// One that has powered them says so in each frame: how long it may say otherwise, at once or bit by bit,
const UNPOWERED_NS: u64 = 20 * MILLISECOND_NS;
/// of which this share of the time with power is forgiven: a contact that is loose takes a part of the brakes, and goes on doing so.
const FORGIVEN: u64 = 4;

/// What is known of a drive since its bus came up.
#[derive(Debug)]
pub(super) struct Health {
    /// It was told to power its motors.
    pub(super) told_to_power: bool,
    stamps: StampWatch,
    bad_since_ns: u64,
    /// It has powered them since it was told to.
    powered: bool,
    /// They have no power now,
    unpowered: bool,
    /// and had none for so long, less what is forgiven.
    unpowered_ns: u64,
    /// Too long for no emergency stop, with this figure, while something else was wrong.
    cut: Option<f64>,
    judged_ns: u64,
}

impl Default for Health {
    fn default() -> Self {
        Self {
            told_to_power: false,
            stamps: StampWatch::new(),
            bad_since_ns: 0,
            powered: false,
            unpowered: false,
            unpowered_ns: 0,
            cut: None,
            judged_ns: 0,
        }
    }
}

impl Health {
    /// Whether nothing is wrong, not even for so short a time that it may be noise.
    pub(super) fn is_good(&self) -> bool {
        self.bad_since_ns == 0 && !self.unpowered
    }

    /// Whether its sensors have shown that they are alive. What they say may be of before: a robot that takes it for how fast it is
    /// would ramp down from there.
    pub(super) fn senses(&self) -> bool {
        self.stamps.advances()
    }

    /// The fault that has lasted long enough for the robot to stand until an operator resets it, with its figure.
    pub(super) fn judge(
        &mut self,
        inputs: &Inputs,
        voltage: VoltageLimits,
        now_ns: u64,
    ) -> Option<(Fault, f64)> {
        let elapsed_ns = now_ns.saturating_sub(self.judged_ns);
        self.judged_ns = now_ns;
        let stalled = self.stamps.stalled_ns(inputs.sensor_stamp_ns, now_ns) > STALL_NS;
        let faults = Faults::of(inputs, voltage);
        // Also while something is wrong: an emergency stop may take the voltage down with the motors' power.
        let unpowered = self.judge_power(inputs, elapsed_ns);
        if faults.is_empty() && !stalled {
            self.bad_since_ns = 0;
            let cut = self.cut.take();
            return unpowered.or(cut.map(|lasted_ms| (Fault::MotorsOff, lasted_ms)));
        }
        self.cut = { self.cut }.or(unpowered.map(|(_, lasted_ms)| lasted_ms));
        if self.bad_since_ns == 0 {
            self.bad_since_ns = now_ns;
        }
        let lasts = now_ns - self.bad_since_ns >= FAULT_NS;
        // Sensors that stand still have done so for long enough. Whether it was noise decides what had taken the motors' power.
        if !lasts && !stalled {
            return None;
        }
        self.cut = None;
        // What a fault that waits for an operator takes from the motors, they have back a while after it.
        (self.unpowered, self.unpowered_ns) = (false, 0);
        self.powered &= inputs.status1.all(Status::ENABLED_BOTH);
        // What to do about them differs.
        let good_v = voltage.min_v..=voltage.max_v;
        Some(if faults.is_empty() || !lasts {
            let stalled_ns = self.stamps.stalled_ns(inputs.sensor_stamp_ns, now_ns);
            (
                Fault::DriveStalled,
                stalled_ns as f64 / MILLISECOND_NS as f64,
            )
        } else if good_v.contains(&inputs.bus_voltage_v) {
            (Fault::DriveFault, f64::from(faults.bits()))
        } else {
            (Fault::BusVoltage, f64::from(inputs.bus_voltage_v))
        })
    }

    /// An emergency stop cuts the motors' power, and no other status bit shows it: without a latch, its release would set
    /// the robot in motion.
    fn judge_power(&mut self, inputs: &Inputs, elapsed_ns: u64) -> Option<(Fault, f64)> {
        let powers = inputs.status1.all(Status::ENABLED_BOTH);
        self.powered = self.told_to_power && (powers || self.powered);
        let most_ns = if self.powered { UNPOWERED_NS } else { POWER_NS };
        let began = !std::mem::replace(&mut self.unpowered, self.told_to_power && !powers);
        if !self.told_to_power {
            self.unpowered_ns = 0;
        } else if powers {
            let left_ns = self.unpowered_ns.min(UNPOWERED_NS);
            self.unpowered_ns = left_ns.saturating_sub(elapsed_ns / FORGIVEN);
        } else if !began {
            self.unpowered_ns += elapsed_ns;
        }
        (self.unpowered && self.unpowered_ns > most_ns).then(|| {
            let lasted_ms = self.unpowered_ns / MILLISECOND_NS;
            (Fault::MotorsOff, lasted_ms as f64)
        })
    }
}
