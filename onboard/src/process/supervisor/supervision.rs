//! What the supervisor does ten times a second.

use coordination::activity::{LifeCycleEvent, LifeCycleState};
use coordination::fsm::Machine;
use description::geometry::Pose2;
use description::threads::ActivityKind;

use super::handles::{Handle, Handles};
use super::holders::{Holders, Who};
use super::keeper::Keeper;
use super::lease::Lease;
use super::sent::Sent;
use super::waiting::Waiting;
use crate::activities::port::{Command, Report};
use crate::composition::files::Files;
use crate::process::ctl::Pending;
use crate::process::overruns::{Load, OverrunWatch};
use crate::process::reload::{RECONFIGURED, Reload, Step, View};
use crate::realtime::clock::MILLISECOND_NS;
use crate::realtime::log::LogDrain;
use crate::realtime::panic::Panicked;
use crate::symbols::faults::{Fault, FaultTable, Resumes};
use crate::symbols::values::{Mode, RobotMode};
use crate::symbols::wiring::SupervisorSymbols;

/// Period of the supervisor.
pub const PERIOD_NS: u64 = 100 * MILLISECOND_NS;

/// Faults that the supervisor finds itself, and by which it stops the robot until a reset.
pub(super) const STOPS: [Fault; 3] = [Fault::OperatorStop, Fault::Overruns, Fault::ThreadHung];

/// The supervisor.
pub struct Supervisor {
    pub(super) handles: Handles,
    pub(super) symbols: SupervisorSymbols,
    pub(super) table: FaultTable,
    holders: Holders,
    pub(super) mode_value: RobotMode,
    pub(super) operator_paused: bool,
    /// Somebody drives by hand.
    pub(super) lease: Option<Lease>,
    /// How often somebody has.
    pub(super) sessions: u64,
    pub(super) ending_since_ns: u64,
    pub(super) panicked: Panicked,
    pub(super) watch: OverrunWatch,
    /// For its names; navigation steps it.
    pub(super) machine: Machine,
    log: LogDrain,
    pub(super) reload: Reload,
    pub(super) keeper: Keeper,
    /// Commands that activities had not taken when it was looked at last.
    refused: u64,
    pub(super) sent: Option<Sent>,
    pub(super) resets: Waiting,
    pub(super) placings: Waiting,
    /// For how long its computer had slept when it was looked at last, once it was.
    pub(super) slept_ns: Option<u64>,
    /// What dead reckoning had not measured when it was looked at last.
    pub(super) unmeasured_m: f64,
    /// It goes on from what another process has left, and has not looked yet.
    pub(super) goes_on: bool,
    /// Nobody knows where the robot stands until an operator says so.
    pub(super) lost: bool,
    /// Where an operator has said that it stands, until navigation says so too.
    pub(super) placed: Option<Pose2>,
}

impl Supervisor {
    /// A supervisor of `handles`; `machine` is the robot's, as it is now.
    #[must_use]
    pub fn new(
        handles: Vec<Handle>,
        symbols: SupervisorSymbols,
        mode_value: RobotMode,
        watch: OverrunWatch,
        machine: Machine,
        log: LogDrain,
        (reload, keeper): (Reload, Keeper),
    ) -> Self {
        Self {
            handles: Handles(handles),
            symbols,
            table: FaultTable::default(),
            holders: Holders::default(),
            mode_value,
            operator_paused: false,
            lease: None,
            sessions: 0,
            ending_since_ns: 0,
            panicked: Panicked::default(),
            watch,
            machine,
            log,
            reload,
            keeper,
            refused: 0,
            sent: None,
            resets: Waiting::default(),
            placings: Waiting::default(),
            slept_ns: None,
            unmeasured_m: 0.0,
            goes_on: false,
            lost: false,
            placed: None,
        }
    }

    /// Ends the robot when a part of its program has panicked, which this flag tells.
    #[must_use]
    pub fn heeding(self, panicked: Panicked) -> Self {
        Self { panicked, ..self }
    }

    /// From now on a reload reads these files.
    pub fn reload_from(&mut self, files: Files) {
        self.reload.read_from(files);
    }

    /// Has all activities acquire what they need: the first step of all.
    pub fn begin(&mut self) {
        self.handles
            .tell_all(Command::LifeCycle(LifeCycleEvent::Configure));
    }

    /// What is due every [`PERIOD_NS`] while nobody has asked the robot to end. `next_request` gives the requests that wait.
    pub fn cycle(&mut self, now_ns: u64, mut next_request: impl FnMut() -> Option<Pending>) {
        self.hear(now_ns);
        self.heed_moved(now_ns);
        self.watch_lease(now_ns);
        self.keep_running();
        self.judge_load(now_ns);
        while let Some(pending) = next_request() {
            self.serve(pending, now_ns);
        }
        self.go_on_reloading(now_ns);
        self.expire_sent(now_ns);
        self.answer_resets(now_ns);
        self.answer_placings(now_ns);
        self.tell_mode();
        self.judge_queues(now_ns);
        self.publish(now_ns);
        self.keep(self.mode_to_keep(), now_ns);
        self.judge_keeping(now_ns);
    }

    /// A command that an activity did not take is lost; what holds is said again.
    fn judge_queues(&mut self, now_ns: u64) {
        let refused = self.handles.refused();
        if refused > std::mem::replace(&mut self.refused, refused) {
            self.raise(Who::Supervisor, Fault::QueueFull, refused as f64, now_ns);
            self.clear(Who::Supervisor, Fault::QueueFull, now_ns);
        }
    }

    /// Takes in all reports.
    pub(super) fn hear(&mut self, now_ns: u64) {
        while let Some((kind, report)) = self.handles.next_report() {
            self.take(kind, report, now_ns);
        }
        self.log.drain();
    }

    fn take(&mut self, kind: ActivityKind, report: Report, now_ns: u64) {
        let who = Who::Activity(kind);
        match report {
            Report::LifeCycle(state) => tracing::debug!("{kind} is {state}"),
            Report::Raised(fault, figure) => self.raise(who, fault, figure, now_ns),
            Report::Cleared(fault) => self.clear(who, fault, now_ns),
            Report::Moved { from, to } => {
                tracing::info!(
                    "state {} -> {}",
                    self.machine.state_name(from),
                    self.machine.state_name(to)
                );
            }
            Report::Instructed(what) => self.answer_sent(what),
            Report::Disobeyed(what) => tracing::error!("{what}"),
            Report::Contradicted(what) => tracing::error!("{what}"),
            Report::Slipped(what) => tracing::error!("{what}"),
        }
    }

    pub(super) fn raise(&mut self, who: Who, fault: Fault, figure: f64, now_ns: u64) {
        // A port that has lost a report says all again.
        if self.holders.raise(fault, who) && self.table.raise(fault, now_ns) {
            tracing::warn!(
                "{} ({}, {figure:.3}): {}",
                fault.name(),
                who.name(),
                fault.sentence()
            );
        }
    }

    pub(super) fn clear(&mut self, who: Who, fault: Fault, now_ns: u64) {
        let since_ns = self.table.state(fault).since_ns;
        if self.holders.clear(fault, who) && self.table.clear(fault) {
            let who = who.name();
            let lasted_ms = now_ns.saturating_sub(since_ns) / MILLISECOND_NS;
            tracing::info!("{} is gone ({who}, after {lasted_ms} ms)", fault.name());
        }
    }

    /// Tells activities what holds now. A level, told again each time: a command that was lost is repaired by the next.
    fn keep_running(&mut self) {
        // A fleet network that cannot be reached keeps no robot from starting.
        let all_configured = self.mode_value.mode != Mode::Configuring as u64
            || self.handles.0.iter().all(|handle| {
                handle.state == LifeCycleState::Ready || handle.kind == ActivityKind::Communication
            });
        for handle in &mut self.handles.0 {
            let stands = self.operator_paused && self.lease.is_none();
            let paused = stands && handle.kind == ActivityKind::Navigation;
            let held = paused || self.reload.holds(handle.kind);
            let wakes =
                handle.state == LifeCycleState::Ready || handle.state == LifeCycleState::Paused;
            if held && handle.state == LifeCycleState::Running {
                handle.repeat(Command::LifeCycle(LifeCycleEvent::Pause));
            } else if all_configured && wakes && !held {
                handle.repeat(Command::LifeCycle(LifeCycleEvent::Run));
            }
        }
        if all_configured {
            self.mode_value.mode = self.mode() as u64;
        }
    }

    /// Faults that keep the robot stopped until an operator ends them.
    pub(super) fn stopped_by(&self) -> impl Iterator<Item = Fault> + '_ {
        { self.table.active() }.filter(|fault| fault.resumes() == Resumes::Operator)
    }

    pub(super) fn mode(&self) -> Mode {
        if self.lease.is_some() {
            Mode::Teleop
        } else {
            self.mode_of_itself()
        }
    }

    pub(super) fn mode_of_itself(&self) -> Mode {
        if self.stopped_by().next().is_some() {
            Mode::Stopped
        } else if self.operator_paused {
            Mode::Paused
        } else {
            Mode::Running
        }
    }

    /// Slows down, then stops a robot whose real-time threads overrun repeatedly.
    fn judge_load(&mut self, now_ns: u64) {
        match self.watch.judge(now_ns) {
            None => {}
            Some((thread, Load::Fine)) => {
                tracing::info!("thread {thread} keeps its deadlines again");
                self.limit_speed(1000);
            }
            Some((thread, Load::Degraded)) => {
                let stands = self.stopped_by().next().is_some();
                let drives = if stands {
                    "the robot stands"
                } else {
                    "driving at half speed"
                };
                tracing::warn!("thread {thread} overruns: {drives}");
                self.limit_speed(500);
            }
            Some((thread, load @ (Load::Overloaded | Load::Hung))) => {
                let (does, fault) = if load == Load::Hung {
                    ("does not run any more", Fault::ThreadHung)
                } else {
                    ("overruns repeatedly", Fault::Overruns)
                };
                tracing::error!("thread {thread} {does}: stopping");
                self.raise(Who::Supervisor, fault, 0.0, now_ns);
            }
        }
    }

    /// Nobody knows where the robot stands: by what the process before has left, or by what the fleet says to that.
    pub(super) fn is_lost(&self) -> bool {
        self.lost || self.table.state(Fault::PlaceUnknown).active != 0
    }

    /// Whether the robot is to stand, whatever navigation wants: a level, which nobody can miss who runs again.
    fn is_halted(&self) -> bool {
        let mut stops = STOPS.iter().chain([&Fault::WheelSlip, &Fault::LidarFrozen]);
        let lost = self.is_lost() && self.lease.is_none();
        self.ending_since_ns != 0
            || lost
            || !self.keeper.is_noted()
            || stops.any(|&fault| self.table.state(fault).active != 0)
    }

    pub(super) fn limit_speed(&mut self, thousandths: u16) {
        self.handles
            .tell(ActivityKind::Navigation, Command::LimitSpeed(thousandths));
    }

    pub(super) fn is_reloading(&self) -> bool {
        self.reload.in_progress()
    }

    /// Steps a reload: see [`crate::process::reload`].
    fn go_on_reloading(&mut self, now_ns: u64) {
        if !self.is_reloading() {
            return;
        }
        let all = |states: &[LifeCycleState]| self.handles.are(&RECONFIGURED, states);
        let (paused, reconfiguring) = (
            all(&[LifeCycleState::Paused, LifeCycleState::Ready]),
            all(&[LifeCycleState::Reconfiguring]),
        );
        let view = View {
            standing: self.standing(now_ns),
            paused,
            reconfiguring,
        };
        match self.reload.step(view, now_ns) {
            Step::Wait => {}
            Step::Reconfigure => self.tell_reconfigured(LifeCycleEvent::Reconfigure),
            Step::GiveUp => self.tell_reconfigured(LifeCycleEvent::Configured),
            Step::Done(machine) => {
                tracing::info!("operator: reload: done");
                self.machine = machine;
                // A later process that reads the new files finds its place; one that reads the old ones does not.
                self.keeper.is_of(self.reload.plan());
            }
        }
    }

    fn tell_reconfigured(&mut self, event: LifeCycleEvent) {
        for kind in RECONFIGURED {
            self.handles.tell(kind, Command::LifeCycle(event));
        }
    }

    pub(super) fn publish(&mut self, now_ns: u64) {
        self.mode_value.halt = u64::from(self.is_halted());
        self.mode_value.lost = u64::from(self.is_lost());
        self.symbols.faults.write(now_ns, &self.table);
        self.symbols.mode.write(now_ns, &self.mode_value);
    }
}
