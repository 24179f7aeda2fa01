//! Adaptive motion tube: lets a wanted motion through as far as the floor ahead is free.

use coordination::activity::{Activity, LifeCycle, LifeCycleEvent, LifeCycleState};
use coordination::symbols::Stamped;
use skills::odometry::Odometry;
use skills::tubes::{Adapted, FloorCheckpoint, MotionTubes, Reason, Verdict};

use super::scans::ScanIntake;
use super::unknown_floor::UnknownFloor;
use crate::activities::exchange::Exchange;
use crate::activities::port::{Command, Port};
use crate::activities::robot_activity::RobotActivity;
use crate::realtime::clock::{MILLISECOND_NS, SECOND_NS, now_ns};
use crate::symbols::faults::Fault;
use crate::symbols::values::{SafeCommand, TubeState, WantedMotion};
use crate::symbols::wiring::MotionTubeSymbols;

/// A robot whose supervisor was not heard for longer stops: nobody could tell it to.
const SUPERVISOR_SILENT_NS: u64 = SECOND_NS;

/// Scans that came this recently without odometry are why there is none to judge: three turns of the lidar.
const UNPLACED_NS: u64 = 300 * MILLISECOND_NS;

/// The activity.
pub struct MotionTube {
    port: Port,
    symbols: MotionTubeSymbols,
    scans: Option<Box<ScanIntake>>,
    exchange: Exchange<MotionTubes>,
    tubes: Box<MotionTubes>,
    command_timeout_ns: u64,
    wanted: Stamped<WantedMotion>,
    odometry: Stamped<Odometry>,
    /// The supervisor says that the robot is to stand.
    halted: bool,
    unknown_floor: UnknownFloor,
    /// When the supervisor was heard.
    supervised_ns: u64,
    /// When a scan came last that could not be placed for want of odometry; 0 for never.
    unplaced_ns: u64,
    /// It stopped for want of odometry, and not of scans.
    unplaced: bool,
    safe: SafeCommand,
    state: TubeState,
    floor: Box<FloorCheckpoint>,
    /// Of dead reckoning when the tubes began to remember.
    breaks: u64,
}

impl MotionTube {
    /// An activity in state *created*. A wanted command older than `command_timeout_ns` stops the robot.
    #[must_use]
    pub fn new(
        port: Port,
        symbols: MotionTubeSymbols,
        tubes: Box<MotionTubes>,
        exchange: Exchange<MotionTubes>,
        command_timeout_ns: u64,
    ) -> Self {
        Self {
            port,
            symbols,
            scans: None,
            exchange,
            tubes,
            command_timeout_ns,
            wanted: Stamped::default(),
            odometry: Stamped::default(),
            halted: false,
            unknown_floor: UnknownFloor::default(),
            supervised_ns: 0,
            unplaced_ns: 0,
            unplaced: false,
            safe: SafeCommand::default(),
            state: TubeState::default(),
            floor: Box::default(),
            breaks: 0,
        }
    }

    /// With tubes that remember the floor in `odom` from when dead reckoning had broken this often.
    #[must_use]
    pub fn remembering(self, breaks: u64) -> Self {
        Self { breaks, ..self }
    }

    /// What the tubes remember is worth nothing once the robot may have moved without being measured.
    fn forget_after_break(&mut self, now_ns: u64) {
        let breaks = self.odometry.value.breaks;
        if self.odometry.stamp_ns != 0 && breaks != self.breaks {
            self.breaks = breaks;
            self.forget(now_ns);
        }
    }

    /// The floor is as unknown as at the start, also for a process that goes on from here.
    fn forget(&mut self, now_ns: u64) {
        self.tubes.reset();
        self.publish_floor(now_ns);
    }

    fn publish_floor(&mut self, now_ns: u64) {
        self.tubes.save(&mut self.floor);
        self.symbols.floor.write(now_ns, &self.floor);
    }

    fn observe(&mut self, now_ns: u64) {
        // Navigation has looked at the same scan before: only it knows where walls should be. What has no echo would pass for
        // free floor here. It counts such scans, and says so.
        if self.wanted.value.blind != 0 {
            return;
        }
        let Some(scan) = self.scans.as_ref().and_then(|scans| scans.fresh()) else {
            return;
        };
        let begin_ns = self::now_ns();
        // A refused scan is counted by the tubes; when they get no other, they stop.
        if self.tubes.observe(scan, now_ns).is_ok() {
            self.state.evaluation_ns = self::now_ns() - begin_ns;
            self.publish_floor(now_ns);
            let set = self.tubes.set();
            self.state.free_tubes =
                set.ids().filter(|&tube| self.tubes.is_free(tube)).count() as u64;
        }
    }

    fn adapt(&mut self, now_ns: u64) {
        self.tubes.keep_within(Some(self.wanted.value.room));
        let by_hand = self.wanted.value.by_hand != 0;
        self.tubes.drive_by_hand(by_hand);
        let adapted =
            self.tubes
                .adapt(self.wanted.value.command, self.odometry.value.twist, now_ns);
        if by_hand {
            self.unknown_floor.told();
        }
        let waits_for_people = self.unknown_floor.judge(adapted.reason, now_ns);
        self.port.set(Fault::FloorUnknown, waits_for_people, 0.0);
        self.report(&adapted, waits_for_people, now_ns);
        let old = |stamp_ns: u64| now_ns.saturating_sub(stamp_ns) > self.command_timeout_ns;
        let stale = old(self.wanted.stamp_ns) || old(self.odometry.stamp_ns);
        let silent_ns = now_ns.saturating_sub(self.supervised_ns);
        let unsupervised = silent_ns > SUPERVISOR_SILENT_NS;
        self.port.set(
            Fault::SupervisorSilent,
            unsupervised,
            silent_ns as f64 / 1e6,
        );
        let halt = stale || unsupervised || self.halted || waits_for_people;
        self.safe = if halt || must_stop_hard(&adapted) {
            SafeCommand::stop(adapted.command.curvature_1_m)
        } else {
            SafeCommand::drive(adapted.command)
        };
    }

    fn report(&mut self, adapted: &Adapted, waits_for_people: bool, now_ns: u64) {
        let blind = matches!(adapted.reason, Reason::NoScan | Reason::AwaitingScans);
        // Letting something pass or backing out does not mean that the way is blocked. Floor that is not known is said by itself.
        let waits = waits_for_people
            || matches!(
                adapted.reason,
                Reason::None | Reason::Moving | Reason::Reversing | Reason::UnknownFloor
            );
        let blocked = adapted.verdict == Verdict::Stopped && !blind && !waits;
        // Before the first scan there is no age.
        let age_ms = if adapted.scan_age_ns == u64::MAX {
            0.0
        } else {
            adapted.scan_age_ns as f64 / 1e6
        };
        // The lidar is not to blame for scans that odometry does not place. After that it waits for good scans, for the same reason.
        let comes = self.unplaced_ns != 0 && now_ns - self.unplaced_ns < UNPLACED_NS;
        let waits_after = self.unplaced && adapted.reason == Reason::AwaitingScans;
        self.unplaced = blind && (comes || waits_after);
        self.port.set(Fault::OdometrySilent, self.unplaced, age_ms);
        self.port
            .set(Fault::ScanSilent, blind && !self.unplaced, age_ms);
        self.port
            .set(Fault::NoFreeTube, blocked, adapted.clearance_m);
        self.state.verdict = adapted.verdict as u64;
        self.state.reason = adapted.reason as u64;
        self.state.tube = adapted.tube.map_or(u64::MAX, |tube| u64::from(tube.0));
        self.state.scan_age_ns = adapted.scan_age_ns;
        self.state.clearance_m = adapted.clearance_m;
    }
}

/// A stop for lack of sight or space is a hard one; a stop that was asked for is not.
fn must_stop_hard(adapted: &Adapted) -> bool {
    let wanted = matches!(adapted.reason, Reason::None | Reason::Reversing);
    adapted.verdict == Verdict::Stopped && !wanted
}

impl Activity for MotionTube {
    fn name(&self) -> &'static str {
        "motion-tube"
    }

    fn life_cycle(&self) -> &LifeCycle {
        self.port.life_cycle()
    }

    fn communicate_in(&mut self, now_ns: u64) {
        self.wanted = self.symbols.wanted.read();
        self.odometry = self.symbols.odometry.read();
        let mode = self.symbols.mode.read();
        (self.supervised_ns, self.halted) = (mode.stamp_ns, mode.value.halt != 0);
        self.forget_after_break(now_ns);
        if self.scans.as_ref().is_some_and(|scans| scans.is_unplaced()) {
            self.unplaced_ns = now_ns;
        }
        if let Some(sequence) = self.scans.as_ref().and_then(|scans| scans.broken()) {
            self.port.note(Fault::ScanBroken, sequence as f64);
        }
        if let Some(sequence) = self.scans.as_ref().and_then(|scans| scans.frozen()) {
            self.state.frozen_scan = sequence;
        }
    }

    fn coordinate(&mut self, now_ns: u64) {
        while let Some(command) = self.port.next_command() {
            match command {
                Command::Reset => self.unknown_floor.reset(),
                // Whoever says where it stands may have carried it there.
                Command::Place(_) => self.forget(now_ns),
                Command::FreeBehind(way_m) => {
                    self.tubes.trust_behind(way_m);
                    self.unknown_floor.told();
                }
                Command::LimitSpeed(_) | Command::LifeCycle(_) | Command::Instruct(_) => {}
            }
        }
    }

    fn configure(&mut self, now_ns: u64) {
        if self.port.state() == LifeCycleState::Reconfiguring {
            let Some(mut tubes) = self.exchange.take() else {
                return;
            };
            std::mem::swap(&mut self.tubes, &mut tubes);
            // What stands where the sensor does not look is there still.
            tubes.save(&mut self.floor);
            self.tubes.resume(&self.floor);
            self.exchange.give_back(tubes);
        } else {
            // What was left by another process is left to the next one, too, should this one end at once.
            self.publish_floor(now_ns);
        }
        self.port.step(LifeCycleEvent::Configured);
    }

    fn compute(&mut self, now_ns: u64) {
        self.observe(now_ns);
        self.adapt(now_ns);
    }

    fn rest(&mut self, now_ns: u64) {
        if matches!(
            self.port.state(),
            LifeCycleState::Ready | LifeCycleState::Paused
        ) {
            self.observe(now_ns);
        }
        self.safe = SafeCommand::stop(self.safe.command.curvature_1_m);
    }

    fn communicate_out(&mut self, now_ns: u64) {
        self.symbols.safe.write(now_ns, &self.safe);
        self.state.tubes = self.tubes.set().len() as u64;
        self.symbols.state.write(now_ns, &self.state);
        self.port.publish(now_ns);
    }
}

impl RobotActivity for MotionTube {
    fn scans(&mut self) -> Option<&mut Option<Box<ScanIntake>>> {
        Some(&mut self.scans)
    }
}
