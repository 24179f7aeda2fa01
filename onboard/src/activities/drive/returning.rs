//! How the drive comes back: brought up again, and let go on by itself or by an operator.

use coordination::activity::LifeCycleEvent;
use drivers::ethercat::Bus;

use super::activity::Drive;
use super::health::Health;
use super::holding::Holding;
use super::settings::{GONE_NS, RETRY_NS, SWITCHED_ON_NS};
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
        if self.too_many_bring_ups(now_ns) {
            return;
        }
        let result = (self.open_link)().and_then(|link| {
            Bus::bring_up(link, &self.settings.expectation, self.settings.bring_up)
                .map_err(|error| error.to_string())
        });
        match result {
            Ok(bus) => {
                let identity = bus.identity();
                self.judge_return(identity.had_address);
                self.log.info(format!(
                    "bus is up on {}: {}, serial {}",
                    identity.link, identity.name, identity.serial
                ));
                // Without power its encoders forgot how far they had counted.
                self.encoder_epoch += u64::from(!identity.had_address);
                self.wheels = Wheels::default();
                self.bus = Some(bus);
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
    /// stop. One that is switched on together with this computer may take a while.
    fn judge_return(&mut self, kept_power: bool) {
        let now_ns = self.clock.now_ns();
        let (gone_since_ns, may_take_ns) = if self.status.bring_ups == 0 {
            (self.sought_ns.unwrap_or(now_ns), SWITCHED_ON_NS)
        } else {
            (self.answered_ns, if kept_power { GONE_NS } else { 0 })
        };
        let gone_ns = now_ns.saturating_sub(gone_since_ns);
        if gone_ns > may_take_ns {
            self.latch(Fault::DriveReturned, gone_ns as f64 * 1e-9);
        }
    }

    /// Whether an operator is needed before another bring-up.
    fn too_many_bring_ups(&mut self, now_ns: u64) -> bool {
        if self.status.bring_ups == 0 || !self.complaints.is_empty() {
            return false; // the first one, and further attempts at the same one, do not count
        }
        let too_many = !self.bring_ups.note(now_ns);
        if too_many {
            self.port
                .raise(Fault::BringUpLimit, self.bring_ups.per_minute() as f64);
            self.retry_ns = u64::MAX;
        }
        too_many
    }

    /// The operator has seen to the faults. One whose cause is still there stays.
    pub(super) fn reset(&mut self) {
        if self.bus.is_none() || self.health.is_good() {
            self.latched = false;
            for fault in [
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
            self.disobeys = false;
        }
        if self.bus.is_none() {
            // A drive that comes at once is the one that the operator expects.
            self.answered_ns = self.clock.now_ns();
        }
        self.port.clear(Fault::BringUpLimit);
        self.bring_ups.forget();
        self.retry_ns = 0;
    }
}
