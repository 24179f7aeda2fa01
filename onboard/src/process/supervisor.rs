//! The supervisor: life cycles, faults, signals, requests and the log, ten times a second on the main thread.
//!
//! It runs no activity. It tells activities what to do by events and learns of them by reports; what they do meanwhile
//! does not wait for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use coordination::activity::{LifeCycleEvent, LifeCycleState};
use coordination::event::{Receiver, Sender};
use description::threads::ActivityKind;

use crate::activities::machine_names::MachineNames;
use crate::activities::port::{Command, Instructed, Report};
use crate::process::ctl::{Event, Pending, Request, Server};
use crate::process::overruns::{Load, OverrunWatch};
use crate::process::reload::{RECONFIGURED, Reload, Step, View};
use crate::realtime::clock::{MILLISECOND_NS, SECOND_NS, now_ns, sleep_until};
use crate::realtime::log::LogDrain;
use crate::realtime::panic::has_panicked;
use crate::symbols::faults::{Fault, FaultTable, Resumes};
use crate::symbols::values::{Mode, RobotMode};
use crate::symbols::wiring::SupervisorSymbols;

/// Period of the supervisor.
pub const PERIOD_NS: u64 = 100 * MILLISECOND_NS;
/// How long a robot may take to stand before the program ends all the same.
const STANDSTILL_NS: u64 = 3 * SECOND_NS;
/// How long activities may take to stop once the robot stands.
const STOPPING_NS: u64 = SECOND_NS;
/// Wheel speed below which the robot stands.
const STANDING_RAD_S: f64 = 0.2;
/// How long navigation may take to say what became of an event.
const ANSWER_NS: u64 = SECOND_NS;
/// An encoder reading older than this says nothing.
const ENCODER_AGE_NS: u64 = 200 * MILLISECOND_NS;

/// The supervisor's side of one activity.
#[derive(Debug)]
pub struct Handle {
    /// Which.
    pub kind: ActivityKind,
    /// Commands to it.
    pub commands: Sender<Command>,
    /// Reports from it.
    pub reports: Receiver<Report>,
    /// Its state, as last reported.
    pub state: LifeCycleState,
}

/// The supervisor.
pub struct Supervisor {
    handles: Vec<Handle>,
    symbols: SupervisorSymbols,
    table: FaultTable,
    mode_value: RobotMode,
    operator_paused: bool,
    ending_since_ns: u64,
    watch: OverrunWatch,
    names: MachineNames,
    log: LogDrain,
    reload: Reload,
    sent: Option<Sent>,
}

/// An event that was sent to the robot's machine and waits for its answer.
struct Sent {
    event: String,
    pending: Pending,
    since_ns: u64,
}

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// By a signal.
    Asked,
    /// A thread panicked.
    Panicked,
}

impl Supervisor {
    /// A supervisor of `handles`; `names` are those of the robot's machine.
    #[must_use]
    pub fn new(
        handles: Vec<Handle>,
        symbols: SupervisorSymbols,
        mode_value: RobotMode,
        watch: OverrunWatch,
        names: MachineNames,
        log: LogDrain,
        reload: Reload,
    ) -> Self {
        Self {
            handles,
            symbols,
            table: FaultTable::default(),
            mode_value,
            operator_paused: false,
            ending_since_ns: 0,
            watch,
            names,
            log,
            reload,
            sent: None,
        }
    }

    /// Supervises until the robot has been asked to end and stands.
    pub fn run(&mut self, asked_to_end: &AtomicBool, server: &Server) -> Ending {
        self.tell_all(Command::LifeCycle(LifeCycleEvent::Configure));
        let mut next_ns = now_ns();
        loop {
            next_ns = (next_ns + PERIOD_NS).max(now_ns());
            sleep_until(next_ns);
            let now_ns = now_ns();
            self.hear(now_ns);
            if asked_to_end.load(Ordering::Relaxed) || has_panicked() {
                if self.end(now_ns) {
                    break;
                }
            } else {
                self.keep_running();
                self.judge_load(now_ns);
                while let Some(pending) = server.next() {
                    self.serve(pending, now_ns);
                }
                self.go_on_reloading(now_ns);
                self.expire_sent(now_ns);
            }
            self.publish(now_ns);
        }
        self.stop_activities();
        self.publish(now_ns());
        if has_panicked() {
            Ending::Panicked
        } else {
            Ending::Asked
        }
    }

    /// Takes in all reports.
    fn hear(&mut self, now_ns: u64) {
        for index in 0..self.handles.len() {
            while let Some(report) = self.handles[index].reports.receive() {
                self.take(index, report, now_ns);
            }
        }
        self.log.drain();
    }

    fn take(&mut self, index: usize, report: Report, now_ns: u64) {
        let name = self.handles[index].kind.name();
        match report {
            Report::LifeCycle(state) => {
                self.handles[index].state = state;
                tracing::debug!("{name} is {state}");
            }
            Report::Raised(fault, figure) => self.raise(name, fault, figure, now_ns),
            Report::Cleared(fault) => self.clear(name, fault, now_ns),
            Report::Moved { from, to } => {
                tracing::info!(
                    "state {} -> {}",
                    self.names.state(from),
                    self.names.state(to)
                );
            }
            Report::Instructed(what) => self.answer_sent(what),
        }
    }

    fn raise(&mut self, who: &str, fault: Fault, figure: f64, now_ns: u64) {
        if self.table.raise(fault, now_ns) {
            tracing::warn!(
                "{} ({who}, {figure:.3}): {}",
                fault.name(),
                fault.sentence()
            );
        }
    }

    fn clear(&mut self, who: &str, fault: Fault, now_ns: u64) {
        let since_ns = self.table.state(fault).since_ns;
        if self.table.clear(fault) {
            let lasted_ms = now_ns.saturating_sub(since_ns) / MILLISECOND_NS;
            tracing::info!("{} is gone ({who}, after {lasted_ms} ms)", fault.name());
        }
    }

    /// Tells activities what holds now. A level, told again each time: a command that was lost is repaired by the next.
    fn keep_running(&mut self) {
        // A fleet network that cannot be reached keeps no robot from starting.
        let all_configured = self.mode_value.mode != Mode::Configuring as u64
            || self.handles.iter().all(|handle| {
                handle.state == LifeCycleState::Ready || handle.kind == ActivityKind::Communication
            });
        for handle in &mut self.handles {
            let held =
                (self.operator_paused && is_mover(handle.kind)) || self.reload.holds(handle.kind);
            let wakes =
                handle.state == LifeCycleState::Ready || handle.state == LifeCycleState::Paused;
            if held && handle.state == LifeCycleState::Running {
                tell(handle, Command::LifeCycle(LifeCycleEvent::Pause));
            } else if all_configured && wakes && !held {
                tell(handle, Command::LifeCycle(LifeCycleEvent::Run));
            }
        }
        if [Fault::OperatorStop, Fault::Overruns]
            .iter()
            .any(|&fault| self.table.state(fault).active != 0)
        {
            self.tell(ActivityKind::MotionTube, Command::StopNow);
        }
        if all_configured {
            self.mode_value.mode = self.mode() as u64;
        }
    }

    fn mode(&self) -> Mode {
        if self
            .table
            .active()
            .any(|fault| fault.resumes() == Resumes::Operator)
        {
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
                tracing::info!("thread {thread} keeps its time again");
                self.tell(ActivityKind::Navigation, Command::LimitSpeed(1000));
            }
            Some((thread, Load::Degraded)) => {
                tracing::warn!("thread {thread} overruns: driving at half speed");
                self.tell(ActivityKind::Navigation, Command::LimitSpeed(500));
            }
            Some((thread, Load::Overloaded)) => {
                tracing::error!("thread {thread} overruns repeatedly: stopping");
                self.raise("supervisor", Fault::Overruns, 0.0, now_ns);
                self.tell(ActivityKind::MotionTube, Command::StopNow);
            }
        }
    }

    fn serve(&mut self, pending: Pending, now_ns: u64) {
        let result = match &pending.request {
            Request::Pause => {
                self.operator_paused = true;
                self.tell(
                    ActivityKind::Navigation,
                    Command::LifeCycle(LifeCycleEvent::Pause),
                );
                Ok("paused".into())
            }
            Request::Resume if self.mode() == Mode::Stopped => Err(
                "it is stopped by a fault; see `onboard inspect`, then `onboard ctl reset`".into(),
            ),
            Request::Resume => {
                self.operator_paused = false;
                Ok("running".into())
            }
            Request::Stop => {
                self.raise("operator", Fault::OperatorStop, 0.0, now_ns);
                self.tell(ActivityKind::MotionTube, Command::StopNow);
                Ok("stopped; `onboard ctl reset` goes on".into())
            }
            Request::Reset => {
                for fault in [Fault::OperatorStop, Fault::Overruns] {
                    self.clear("operator", fault, now_ns);
                }
                self.watch.forget();
                self.tell_all(Command::Reset);
                self.tell(ActivityKind::Navigation, Command::LimitSpeed(1000));
                Ok("reset".into())
            }
            Request::Reload => {
                self.reload.begin(pending, now_ns);
                return;
            }
            Request::Send(event) => match self.send(event.clone()) {
                Ok(event) => {
                    self.sent = Some(Sent {
                        event,
                        pending,
                        since_ns: now_ns,
                    });
                    return;
                }
                Err(why) => Err(why),
            },
        };
        tracing::info!("operator: {}: {result:?}", pending.request.name());
        pending.answer(&result);
    }

    /// Gives an external event to navigation; the answer comes as a report.
    fn send(&mut self, event: Event) -> Result<String, String> {
        if self.sent.is_some() {
            return Err("another event is on its way".into());
        }
        if self.reload.in_progress() {
            return Err("a reload is under way".into());
        }
        let instruction = {
            let (fsm, role) = (&self.reload.plan().fsm, &self.reload.plan().role);
            let known = fsm.external.contains(&event.name);
            let id = self.names.input(&event.name).filter(|_| known);
            let Some(id) = id else {
                return Err(format!(
                    "role `{role}` has no external event `{}`; it has {}",
                    event.name,
                    quoted(fsm.external.iter())
                ));
            };
            event.instruction(id)
        };
        let mut refused = true;
        for handle in self
            .handles
            .iter_mut()
            .filter(|handle| handle.kind == ActivityKind::Navigation)
        {
            refused = handle
                .commands
                .send(Command::Instruct(instruction))
                .is_err();
        }
        if refused {
            return Err("navigation does not take its commands".into());
        }
        Ok(event.name)
    }

    fn answer_sent(&mut self, what: Instructed) {
        let Some(sent) = self.sent.take() else {
            return; // it took too long and was answered
        };
        let event = &sent.event;
        let state = |number: u16| self.names.state(number);
        let result = match what {
            Instructed::Taken { from, to, hold } => {
                let stands = hold.map_or(String::new(), |hold| {
                    format!("; the robot stands: {}", hold.reason())
                });
                Ok(format!(
                    "`{event}`: state {} -> {}{stands}",
                    state(from),
                    state(to)
                ))
            }
            Instructed::Ignored { state: number } => {
                let fsm = &self.reload.plan().fsm;
                let accepted = fsm
                    .transitions
                    .iter()
                    .filter(|t| t.from == state(number) && fsm.external.contains(&t.on))
                    .map(|t| &t.on);
                Err(format!(
                    "state `{}` has no use for `{event}`; it takes {}",
                    state(number),
                    quoted(accepted)
                ))
            }
            Instructed::Refused(error) => Err(error.to_string()),
            Instructed::NotReady => Err("navigation does not run yet".to_owned()),
        };
        tracing::info!("operator: send {event}: {result:?}");
        sent.pending.answer(&result);
    }

    fn expire_sent(&mut self, now_ns: u64) {
        if let Some(sent) = self.sent.take_if(|sent| now_ns > sent.since_ns + ANSWER_NS) {
            let why = "navigation does not answer; see `onboard inspect` for what it does";
            sent.pending.answer(&Err(why.into()));
        }
    }

    /// Steps a reload: see [`crate::process::reload`].
    fn go_on_reloading(&mut self, now_ns: u64) {
        if !self.reload.in_progress() {
            return;
        }
        let all = |wanted: &[LifeCycleState]| {
            self.handles
                .iter()
                .filter(|handle| RECONFIGURED.contains(&handle.kind))
                .all(|handle| wanted.contains(&handle.state))
        };
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
            Step::Done(names) => {
                tracing::info!("operator: reload: done");
                self.names = names;
            }
        }
    }

    fn tell_reconfigured(&mut self, event: LifeCycleEvent) {
        for kind in RECONFIGURED {
            self.tell(kind, Command::LifeCycle(event));
        }
    }

    /// Stops the robot; true when it stands, or when it has had its time.
    fn end(&mut self, now_ns: u64) -> bool {
        if self.ending_since_ns == 0 {
            self.ending_since_ns = now_ns;
            self.mode_value.mode = Mode::Ending as u64;
            tracing::info!("stopping the robot, then the program");
            if has_panicked() {
                self.raise("supervisor", Fault::Panic, 0.0, now_ns);
            }
        }
        self.tell(ActivityKind::MotionTube, Command::StopNow);
        self.standing(now_ns) || now_ns > self.ending_since_ns + STANDSTILL_NS
    }

    fn standing(&mut self, now_ns: u64) -> bool {
        let encoders = self.symbols.encoders.read();
        let fresh = now_ns.saturating_sub(encoders.stamp_ns) < ENCODER_AGE_NS;
        let slow = encoders.value.left_rad_s.abs() < STANDING_RAD_S
            && encoders.value.right_rad_s.abs() < STANDING_RAD_S;
        let drive = self.symbols.drive.read();
        let bus =
            drive.value.operational != 0 && now_ns.saturating_sub(drive.stamp_ns) < ENCODER_AGE_NS;
        (fresh && slow) || !bus
    }

    fn stop_activities(&mut self) {
        self.tell_all(Command::LifeCycle(LifeCycleEvent::Stop));
        let deadline_ns = now_ns() + STOPPING_NS;
        while now_ns() < deadline_ns
            && self
                .handles
                .iter()
                .any(|handle| handle.state != LifeCycleState::Stopped)
        {
            sleep_until(now_ns() + 5 * MILLISECOND_NS);
            self.hear(now_ns());
        }
        for handle in self
            .handles
            .iter()
            .filter(|handle| handle.state != LifeCycleState::Stopped)
        {
            tracing::warn!("{} did not stop in time", handle.kind);
        }
    }

    fn publish(&mut self, now_ns: u64) {
        self.symbols.faults.write(now_ns, &self.table);
        self.symbols.mode.write(now_ns, &self.mode_value);
    }

    fn tell(&mut self, kind: ActivityKind, command: Command) {
        for handle in self.handles.iter_mut().filter(|handle| handle.kind == kind) {
            tell(handle, command);
        }
    }

    fn tell_all(&mut self, command: Command) {
        self.handles
            .iter_mut()
            .for_each(|handle| tell(handle, command));
    }
}

/// Activities that an operator's pause holds.
fn is_mover(kind: ActivityKind) -> bool {
    kind == ActivityKind::Navigation
}

/// Names for people: "`a`, `b`", or "none".
fn quoted<'a>(names: impl Iterator<Item = &'a String>) -> String {
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

fn tell(handle: &mut Handle, command: Command) {
    if handle.commands.send(command).is_err() {
        tracing::error!(
            "{} does not take its commands: {command:?} is lost",
            handle.kind
        );
    }
}

/// A flag that SIGINT, SIGTERM, SIGQUIT and the closing of the terminal raise.
///
/// # Errors
/// The operating system's.
pub fn termination_flag() -> std::io::Result<Arc<AtomicBool>> {
    let flag = Arc::<AtomicBool>::default();
    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM};
    for signal in [SIGINT, SIGTERM, SIGHUP, SIGQUIT] {
        signal_hook::flag::register(signal, Arc::clone(&flag))?;
    }
    Ok(flag)
}
