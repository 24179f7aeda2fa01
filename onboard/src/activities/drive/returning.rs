//! How the drive comes back: brought up again, and let go on by itself or by an operator.

use coordination::activity::LifeCycleEvent;
use drivers::ethercat::Bus;

use super::activity::Drive;
use super::health::Health;
use super::holding::Holding;
use super::settings::{GONE_NS, RETRY_NS};
use super::wheels::Wheels;
use crate::symbols::faults::Fault;

impl Drive {
    /// Brings the bus up. The real-time rules are suspended: the activity is in state *configuring*.
    pub(super) fn bring_up(&mut self, now_ns: u64) {
        if now_ns < self.retry_ns {
            return;
        }
        // The old socket goes first, and what was counted on it is kept.
        if let Some(bus) = self.bus.take() {
            self.counted = self.total(bus.counters());
        }
        // What the drive itself says of it is gone once it was brought up.
        if let Some(why) = self.trouble.take() {
            self.log.warn(format!("the bus was lost: {why}"));
        }
        self.count_bring_up(now_ns);
        let result = (self.open_link)().and_then(|link| {
            let settings = &self.settings;
            let (expectation, options) = (&settings.expectation, settings.bring_up);
            Bus::bring_up_noting(link, expectation, options, &mut self.lost_power)
                .map_err(|error| error.to_string())
        });
        match result {
            Ok(bus) => {
                let identity = bus.identity();
                let lost_power = std::mem::take(&mut self.lost_power);
                self.log.info(format!(
                    "bus is up on {}: {}, serial {}",
                    identity.link, identity.name, identity.serial
                ));
                // Without power its encoders forgot how far they had counted.
                self.encoder_epoch += u64::from(lost_power);
                self.judge_return(lost_power);
                self.wheels = Wheels::default();
                self.bus = Some(bus);
                self.is_just_up = true;
                self.ramp.reset();
                self.answered_ns = self.clock.now_ns();
                self.lost_since_ns = 0;
                self.health = Health::default();
                self.obedience.forget();
                self.holding = Holding::default();
                self.status.bring_ups += 1;
                self.complaints.forget();
                self.port.clear(Fault::BusLost);
                self.port.step(LifeCycleEvent::Configured);
            }
            Err(complaint) => {
                self.sought_ns.get_or_insert(now_ns);
                self.complaints
                    .say(&self.log, "bus cannot be brought up", complaint);
                self.port.raise(Fault::BusLost, 0.0);
            }
        }
        self.retry_ns = self.clock.now_ns() + RETRY_NS;
    }

    /// A drive that was without power, or gone for long, does not go on by itself: somebody may have released an emergency
    /// stop. One that is switched on together with this computer may take as long as its file allows; but where this process goes
    /// on from another one's checkpoint, the drive was on before, and must have stayed so.
    fn judge_return(&mut self, lost_power: bool) {
        let now_ns = self.clock.now_ns();
        let (gone_since_ns, returned_after_ns) = if self.status.bring_ups > 0 {
            (self.answered_ns, GONE_NS)
        } else {
            // A first attempt that was good has not sought it at all.
            let returned_after_ns = if self.goes_on {
                0
            } else {
                self.settings.awaited_ns
            };
            (self.sought_ns.unwrap_or(now_ns), returned_after_ns)
        };
        let was_on = self.status.bring_ups > 0 || self.goes_on;
        let gone_ns = now_ns.saturating_sub(gone_since_ns);
        if was_on && lost_power || gone_ns > returned_after_ns {
            self.latch(Fault::DriveReturned, gone_ns as f64 * 1e-9);
        }
    }

    /// Counts an attempt to bring the bus up again, good or not; with too many in a minute the robot waits for an operator,
    /// for whom the bus is brought up all the same.
    fn count_bring_up(&mut self, now_ns: u64) {
        // While the drive is sought for the first time, nothing was lost.
        if self.status.bring_ups > 0 && !self.bring_ups.note(now_ns) {
            let per_minute = self.bring_ups.most();
            self.latch(Fault::BringUpLimit, per_minute as f64);
        }
    }

    /// Its last frame has come back.
    fn answers(&self) -> bool {
        self.powers() && self.bus.is_some() && self.lost_since_ns == 0
    }

    /// The operator has seen to the faults. One whose cause is still there stays; so do all of them while the drive does not answer, since
    /// nobody knows what it will say, nor when it comes back.
    pub(super) fn reset(&mut self) {
        if self.answers() && self.health.is_good() {
            self.latched = false;
            for fault in [
                Fault::BringUpLimit,
                Fault::BusVoltage,
                Fault::DriveFault,
                Fault::DriveStalled,
                Fault::MotorsOff,
                Fault::DriveReturned,
                Fault::WheelsDisobey,
                Fault::EncoderBroken,
            ] {
                self.port.clear(fault);
            }
            (self.disobeys, self.contradicted) = (false, false);
            (self.ails, self.emergency) = (false, false);
        }
        self.bring_ups.forget();
        self.retry_ns = 0;
    }
}
