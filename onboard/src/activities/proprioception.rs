//! Proprioception: dead reckoning from the drive's encoders.

use coordination::activity::{Activity, LifeCycle, LifeCycleEvent};
use coordination::symbols::Stamped;
use skills::history::OdometrySample;
use skills::odometry::{DeadReckoning, EncoderSample};

use crate::activities::port::{Command, Port, Report};
use crate::activities::robot_activity::RobotActivity;
use crate::realtime::clock::MILLISECOND_NS;
use crate::symbols::faults::Fault;
use crate::symbols::values::{Encoders, OdometryTrace};
use crate::symbols::wiring::ProprioceptionSymbols;

/// Refused readings are reported no more often than this; all are counted.
const NOTE_NS: u64 = 200 * MILLISECOND_NS;

/// The activity.
pub struct Proprioception {
    port: Port,
    symbols: ProprioceptionSymbols,
    reckoning: DeadReckoning,
    sample: Stamped<Encoders>,
    trace: Box<OdometryTrace>,
    epoch: u64,
    noted_ns: u64,
    /// It was said which wheel slips.
    slips: bool,
}

impl Proprioception {
    /// An activity in state *created*.
    #[must_use]
    pub fn new(port: Port, symbols: ProprioceptionSymbols, reckoning: DeadReckoning) -> Self {
        Self {
            port,
            symbols,
            reckoning,
            sample: Stamped::default(),
            trace: Box::default(),
            epoch: 0,
            noted_ns: 0,
            slips: false,
        }
    }
}

impl Activity for Proprioception {
    fn name(&self) -> &'static str {
        "proprioception"
    }

    fn life_cycle(&self) -> &LifeCycle {
        self.port.life_cycle()
    }

    fn communicate_in(&mut self, _now_ns: u64) {
        self.sample = self.symbols.encoders.read();
    }

    fn coordinate(&mut self, _now_ns: u64) {
        while let Some(command) = self.port.next_command() {
            if command == Command::Reset {
                self.reckoning.forget_slip();
                self.port.clear(Fault::WheelSlip);
                self.slips = false;
            }
        }
    }

    fn configure(&mut self, _now_ns: u64) {
        self.port.step(LifeCycleEvent::Configured); // nothing to acquire
    }

    fn compute(&mut self, now_ns: u64) {
        if self.sample.stamp_ns == 0 || self.sample.stamp_ns == self.reckoning.odometry().stamp_ns {
            return;
        }
        if self.sample.value.epoch != self.epoch {
            // A drive that lost power counts from zero again: the jump is not motion.
            self.epoch = self.sample.value.epoch;
            self.reckoning.rebase();
        }
        let sample = EncoderSample {
            stamp_ns: self.sample.stamp_ns,
            angles: self.sample.value.angles,
        };
        if self.reckoning.update(&sample).is_err() {
            if now_ns >= self.noted_ns + NOTE_NS {
                self.noted_ns = now_ns;
                let rejected = self.reckoning.counters().rejected();
                self.port.note(Fault::EncoderImplausible, rejected as f64);
            }
            return;
        }
        if let Some(slip) = self.reckoning.slip() {
            if !std::mem::replace(&mut self.slips, true) {
                self.port.report(Report::Slipped(slip));
            }
            self.port
                .raise(Fault::WheelSlip, slip.found_m - slip.expected_m);
        }
        let odometry = self.reckoning.odometry();
        self.trace.push(OdometrySample {
            stamp_ns: odometry.stamp_ns,
            pose: odometry.pose,
            twist: odometry.twist,
        });
        self.symbols.odometry.write(odometry.stamp_ns, odometry);
        self.symbols.trace.write(odometry.stamp_ns, &self.trace);
    }

    fn communicate_out(&mut self, now_ns: u64) {
        self.port.publish(now_ns);
    }
}

impl RobotActivity for Proprioception {}
