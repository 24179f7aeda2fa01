//! The activity: its event loop around the navigator, and the instructions that it passes on.

use coordination::activity::{Activity, LifeCycle, LifeCycleEvent, LifeCycleState};
use coordination::symbols::Stamped;
use description::areas::AreaIndex;
use skills::navigator::{Instructed, Instruction, NavigationInput, NavigationOutput};
use skills::odometry::Odometry;

use super::hands::Hands;
use super::membership::Membership;
use super::part::Part;
use crate::activities::exchange::Exchange;
use crate::activities::fleet_link::{NavigationEnd, NavigationEvent};
use crate::activities::port::{Command, Placed, Port, Report};
use crate::activities::robot_activity::RobotActivity;
use crate::activities::scans::ScanIntake;
use crate::fleet::Directive;
use crate::symbols::faults::Fault;
use crate::symbols::values::{Name, NavigationState, PoseEstimate, WantedMotion, Whereabouts};
use crate::symbols::wiring::{NavigationFleetSymbols, NavigationSymbols};

/// Who gave the instruction that the next step takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    ByOperator,
    ByFleet,
}

/// The activity.
pub struct Navigation {
    port: Port,
    symbols: NavigationSymbols,
    scans: Option<Box<ScanIntake>>,
    exchange: Exchange<Part>,
    part: Box<Part>,
    membership: Membership,
    /// Who waits to hear what the next step makes of the instruction given.
    asked: Option<Asked>,
    /// Who drives by hand.
    hands: Hands,
    odometry: Stamped<Odometry>,
    output: Option<NavigationOutput>,
    /// When its pose was the robot's.
    pose_ns: u64,
    speed_share: f64,
    schedule_changes: u64,
    laps: u64,
}

impl Navigation {
    /// An activity in state *created*.
    #[must_use]
    pub fn new(
        port: Port,
        symbols: NavigationSymbols,
        part: Box<Part>,
        exchange: Exchange<Part>,
    ) -> Self {
        Self {
            port,
            symbols,
            scans: None,
            exchange,
            part,
            membership: Membership::default(),
            asked: None,
            hands: Hands::default(),
            odometry: Stamped::default(),
            output: None,
            pose_ns: 0,
            speed_share: 1.0,
            schedule_changes: 0,
            laps: 0,
        }
    }

    /// On a managed site: the robot may only be where the mediator lets it, and does what it orders.
    #[must_use]
    pub fn managed(mut self, symbols: NavigationFleetSymbols, link: NavigationEnd) -> Self {
        self.membership = Membership::managed(symbols, link);
        self
    }

    /// One step of navigation; tracks in every state and moves only when `motion_allowed`.
    fn step(&mut self, now_ns: u64, motion_allowed: bool) {
        if self.odometry.stamp_ns == 0 {
            return; // no odometry yet
        }
        // What cannot be used is reported by the motion tube, which looks at the same scans.
        let scan = self.scans.as_ref().and_then(|scans| scans.fresh());
        let before = self.part.navigator.machine().state();
        let input = NavigationInput {
            now_ns,
            scan,
            odometry: &self.odometry.value,
            lost: self.hands.robot_is_lost(),
            motion_allowed,
            by_hand: self.hands.wish(&self.part.teleop, now_ns),
            allowed: self.membership.allowed(),
        };
        let output = self.part.navigator.step(&input);
        if output.state != before {
            self.port.report(Report::Moved {
                from: before,
                to: output.state,
            });
        }
        if let Some(asked) = self.asked.take() {
            let taken = Instructed::Taken {
                from: before,
                to: output.state,
                hold: output.hold,
            };
            self.answer(asked, taken);
        }
        for &event in output.outputs.as_slice() {
            self.membership
                .tell(NavigationEvent::Output(event), &mut self.port);
        }
        self.schedule_changes += u64::from(output.schedule_changed);
        self.laps += output
            .outputs
            .as_slice()
            .iter()
            .filter(|&&event| Some(event) == self.part.names.lap)
            .count() as u64;
        self.port.set(
            Fault::PoseUncertain,
            output.pose_uncertain,
            output.position_std_m,
        );
        self.port.set(
            Fault::LidarBlind,
            output.blind,
            output.counters.scans_blind as f64,
        );
        self.port.set(
            Fault::OffLane,
            output.deviation_exceeded,
            output.lateral_error_m,
        );
        self.output = Some(output);
        self.pose_ns = self.odometry.stamp_ns;
    }

    /// Takes an operator's word for where the robot stands.
    fn place(&mut self, placed: Placed) {
        let Part {
            navigator, start, ..
        } = &mut *self.part;
        let (pose, state) = match placed {
            Placed::AtStart => (start.pose, start.state),
            Placed::At { pose, state } => {
                (pose, state.unwrap_or_else(|| navigator.machine().state()))
            }
        };
        // People put it anywhere as well as at its start.
        if navigator.relocate(pose, start.std_m, start.std_rad) && navigator.restart_in(state) {
            self.membership.relocated();
        }
    }

    /// Gives the machine an event from outside. The answer follows with the step that takes it, or at once.
    fn instruct(&mut self, asked: Asked, instruction: Instruction) {
        let steps = matches!(
            self.port.state(),
            LifeCycleState::Running | LifeCycleState::Ready | LifeCycleState::Paused
        );
        let machine = self.part.navigator.machine();
        let refusal = if !steps || self.odometry.stamp_ns == 0 {
            Some(Instructed::NotReady)
        } else if !machine.accepts(instruction.event) {
            let state = machine.state();
            Some(Instructed::Ignored { state })
        } else {
            let taken = self.part.navigator.instruct(instruction);
            taken.err().map(Instructed::Refused)
        };
        match refusal {
            None => self.asked = Some(asked),
            Some(refusal) => self.answer(asked, refusal),
        }
    }

    fn answer(&mut self, asked: Asked, answer: Instructed) {
        match asked {
            Asked::ByOperator => self.port.report(Report::Instructed(answer)),
            Asked::ByFleet => {
                let answer = NavigationEvent::Instructed(answer);
                self.membership.tell(answer, &mut self.port);
            }
        }
    }

    /// Carries out what the mediator has ordered.
    fn obey(&mut self) {
        while let Some(order) = self.membership.next_order() {
            match order {
                Directive::Instruct(_) if self.asked.is_some() => {
                    // The next step answers an earlier instruction.
                    self.answer(Asked::ByFleet, Instructed::NotReady);
                }
                Directive::Instruct(instruction) => self.instruct(Asked::ByFleet, instruction),
                Directive::LimitSpeed(limit_m_s) => {
                    self.membership.limit_speed(limit_m_s);
                }
                Directive::Resume(state) => {
                    if self.part.navigator.restart_in(state) {
                        self.membership.relocated();
                    }
                }
            }
        }
    }

    fn publish_output(&mut self, now_ns: u64) {
        let Some(output) = &self.output else { return };
        let std_m = |variance: f64| variance.max(0.0).sqrt();
        let pose = PoseEstimate {
            pose: output.pose,
            std_x_m: std_m(output.covariance[0][0]),
            std_y_m: std_m(output.covariance[1][1]),
            std_theta_rad: std_m(output.covariance[2][2]),
            uncertain: u64::from(output.pose_uncertain),
            ..PoseEstimate::default()
        }
        .checked(output.check);
        let name = |names: &[Name], index: Option<usize>| {
            index
                .and_then(|index| names.get(index).copied())
                .unwrap_or_default()
        };
        let names = &self.part.names;
        let state = NavigationState {
            state: name(&names.states, Some(output.state.index())),
            area: name(&names.areas, output.area.map(AreaIndex::place)),
            skill: name(&names.skills, Some(output.skill)),
            lateral_error_m: output.lateral_error_m,
            heading_error_rad: output.heading_error_rad,
            lane_end_m: output.lane_end.map_or(f64::NAN, |end| end.distance_m),
            hold: output
                .hold
                .map(|hold| Name::new(hold.reason()))
                .unwrap_or_default(),
            waiting_for: name(&names.areas, output.waiting_for.map(AreaIndex::place)),
            border_distance_m: output.border_distance_m.unwrap_or(f64::NAN),
            schedule_changes: self.schedule_changes,
            laps: self.laps,
            ignored_events: self.part.navigator.machine().ignored(),
            blind_scans: output.counters.scans_blind,
        };
        let mut command = self.membership.limited(output.command);
        command.speed_m_s *= self.speed_share;
        // Of the time of the odometry that it is made of: by now a robot that turns has turned on.
        self.symbols.pose.write(self.pose_ns, &pose);
        self.symbols.state.write(now_ns, &state);
        self.symbols.command.write(
            now_ns,
            &WantedMotion {
                command,
                room: output.room,
                blind: u64::from(output.blind),
                by_hand: u64::from(self.hands.are_on()),
            },
        );
    }
}

impl Activity for Navigation {
    fn name(&self) -> &'static str {
        "navigation"
    }

    fn life_cycle(&self) -> &LifeCycle {
        self.port.life_cycle()
    }

    fn communicate_in(&mut self, now_ns: u64) {
        self.membership.read(now_ns);
        self.odometry = self.symbols.odometry.read();
        let (mode, wish) = (self.symbols.mode.read(), self.symbols.wish.read());
        self.hands.hear(&mode.value, &wish.value);
    }

    fn coordinate(&mut self, _now_ns: u64) {
        while let Some(command) = self.port.next_command() {
            match command {
                Command::LimitSpeed(thousandths) => {
                    self.speed_share = f64::from(thousandths.min(1000)) / 1000.0
                }
                Command::Reset => {
                    if let Some(event) = self.part.names.reset {
                        self.part.navigator.post(event);
                    }
                }
                Command::Instruct(instruction) => self.instruct(Asked::ByOperator, instruction),
                Command::Place(placed) => self.place(placed),
                Command::LifeCycle(_) | Command::FreeBehind(_) => {}
            }
        }
        self.obey();
    }

    fn configure(&mut self, _now_ns: u64) {
        if self.port.state() == LifeCycleState::Reconfiguring {
            let Some(mut part) = self.exchange.take() else {
                return;
            };
            std::mem::swap(&mut self.part, &mut part);
            // The robot is where it is, in the state it is in; the new machine has all states of the old one.
            self.part.navigator.take_over(&part.navigator);
            self.exchange.give_back(part);
        }
        self.port.step(LifeCycleEvent::Configured);
    }

    fn compute(&mut self, now_ns: u64) {
        self.step(now_ns, true);
    }

    fn rest(&mut self, now_ns: u64) {
        if matches!(
            self.port.state(),
            LifeCycleState::Ready | LifeCycleState::Paused
        ) {
            self.step(now_ns, false);
        } else if let Some(output) = &mut self.output {
            // No step, no wish to move: an old command must not look like a new one.
            output.command = output.command.with_speed(0.0);
        }
    }

    fn communicate_out(&mut self, now_ns: u64) {
        self.publish_output(now_ns);
        // Without a step, the whereabouts are old and must not look new.
        if let Some(output) = self.output.filter(|output| output.now_ns == now_ns) {
            let whereabouts = Whereabouts::of(&self.part.navigator, &output);
            self.symbols.whereabouts.write(now_ns, &whereabouts);
            self.membership.published(now_ns, &mut self.port);
        }
        self.port.publish(now_ns);
    }
}

impl RobotActivity for Navigation {
    fn scans(&mut self) -> Option<&mut Option<Box<ScanIntake>>> {
        Some(&mut self.scans)
    }
}
