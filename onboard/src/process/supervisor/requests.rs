//! What operators ask, and what is done about it.

use coordination::activity::LifeCycleEvent;
use description::instruction::Instruction;
use description::threads::ActivityKind;
use skills::localisation::ScanVerdict;
use skills::navigator::Instructed;

use super::holders::Who;
use super::sent::{Sent, answer};
use super::supervision::{STOPS, Supervisor};
use super::waiting::{PLACED_NS, RESET_NS};
use crate::activities::port::{Command, Placed};
use crate::process::ctl::{
    Done, Event, FreeBehind, Pending, Place, Placement, Refusal, Request, Spot, quoted,
};
use crate::symbols::faults::Fault;
use crate::symbols::values::{Load, Mode, Name};

impl Supervisor {
    pub(super) fn serve(&mut self, pending: Pending, now_ns: u64) {
        let reply = match &pending.request {
            Request::Pause => {
                self.take_back("an operator pauses the robot");
                self.operator_paused = true;
                self.handles.tell(
                    ActivityKind::Navigation,
                    Command::LifeCycle(LifeCycleEvent::Pause),
                );
                Ok(Done::Paused)
            }
            Request::Resume | Request::Reload if self.lease.is_some() => Err(Refusal::ByHand),
            Request::Resume if self.mode() == Mode::Stopped => Err(Refusal::StoppedByFault),
            Request::Resume => {
                self.operator_paused = false;
                Ok(Done::Running)
            }
            Request::Stop => {
                self.take_back("an operator stops the robot");
                self.raise(Who::Operator, Fault::OperatorStop, 0.0, now_ns);
                Ok(Done::Stopped)
            }
            Request::Reset => {
                self.watch.forget();
                let hangs = self.watch.hangs();
                // A thread that still hangs cannot be reset: it is to be found by the answer, not a second later.
                for fault in { STOPS.into_iter() }.filter(|&own| own != Fault::ThreadHung || !hangs)
                {
                    self.clear(Who::Operator, fault, now_ns);
                }
                self.handles.tell_all(Command::Reset);
                self.limit_speed(1000);
                self.resets.wait(pending, now_ns + RESET_NS);
                return;
            }
            Request::Place(_) if self.is_unmeasured(now_ns) => Err(Refusal::Unmeasured),
            Request::Place(_) | Request::FreeBehind(_)
                if self.mode() == Mode::Running || !self.standing(now_ns) =>
            {
                Err(Refusal::MayMove)
            }
            // Its state is one of the machine that goes.
            Request::Place(_) if self.is_reloading() => Err(Refusal::AnotherReload),
            Request::Place(place) => match self.place(place, now_ns) {
                Ok(()) => {
                    self.placings.wait(pending, now_ns + PLACED_NS);
                    return;
                }
                Err(why) => Err(why),
            },
            Request::FreeBehind(FreeBehind { way_m }) => {
                self.handles
                    .tell(ActivityKind::MotionTube, Command::FreeBehind(*way_m));
                Ok(Done::FreeBehind(*way_m))
            }
            Request::Load(load) => {
                let value = Load {
                    name: Name::new(&load.name),
                    mass_kg: load.mass_kg,
                };
                self.symbols.load.write(now_ns, &value);
                Ok(Done::Carries(Some(load.name.clone())))
            }
            Request::Unload => {
                self.symbols.load.write(now_ns, &Load::default());
                Ok(Done::Carries(None))
            }
            Request::Teleop(_) => self.lend(now_ns),
            Request::Reload => {
                self.reload.begin(pending, now_ns);
                return;
            }
            Request::Send(Event(instruction)) => match self.send(instruction) {
                Ok(()) => {
                    self.sent = Some(Sent {
                        event: instruction.event.clone(),
                        pending,
                        since_ns: now_ns,
                    });
                    return;
                }
                Err(why) => Err(why),
            },
        };
        answer(pending, &reply);
    }

    /// Takes an operator's word for where the robot stands.
    fn place(&mut self, place: &Place, now_ns: u64) -> Result<(), Refusal> {
        let state = match &place.state {
            None => None,
            Some(name) => Some(self.machine.state_id(name).ok_or_else(|| {
                let plan = self.reload.plan();
                Refusal::UnknownState {
                    role: plan.role.clone(),
                    state: name.clone(),
                    known: quoted(plan.fsm.states.iter().map(|state| &state.name)),
                }
            })?),
        };
        let placed = match (place.at, state) {
            (Spot::Start, None) => Placed::AtStart,
            (Spot::Start, state) => Placed::At {
                pose: self.reload.plan().start.start,
                state,
            },
            (Spot::Pose(pose), state) => Placed::At { pose, state },
        };
        // The tubes forget the floor before navigation wants to drive over it.
        for kind in [ActivityKind::MotionTube, ActivityKind::Navigation] {
            self.handles.tell(kind, Command::Place(placed));
        }
        // Its place is one word, that it may drive another; also where the fleet is what did not know it.
        if self.table.state(Fault::PlaceUnknown).active != 0 {
            self.raise(Who::Operator, Fault::OperatorStop, 0.0, now_ns);
        }
        self.placed = Some(match placed {
            Placed::AtStart => self.reload.plan().start.start,
            Placed::At { pose, .. } => pose,
        });
        self.lost = false;
        self.clear(Who::Operator, Fault::PlaceUnknown, now_ns);
        Ok(())
    }

    /// Tells those who have said where the robot stands what its walls say.
    pub(super) fn answer_placings(&mut self, now_ns: u64) {
        for pending in self.placings.due(now_ns) {
            let read = self.symbols.pose.read();
            let is_new = now_ns.saturating_sub(read.stamp_ns) < PLACED_NS;
            let looked = is_new && !read.value.scan.as_str().is_empty();
            let placement = Placement {
                pose: read.value.pose,
                agree: read.value.walls_agree,
                contradict: read.value.walls_contradict,
                looked,
                unseen: looked && read.value.scan.as_str() == ScanVerdict::Blind.name(),
            };
            answer(pending, &Ok(Done::Placed(placement)));
        }
    }

    /// Gives an external event to navigation; the answer comes as a report.
    fn send(&mut self, instruction: &Instruction<String>) -> Result<(), Refusal> {
        if self.sent.is_some() {
            return Err(Refusal::AnotherEvent);
        }
        if self.reload.in_progress() {
            return Err(Refusal::AnotherReload);
        }
        let (plan, event) = (self.reload.plan(), &instruction.event);
        let known = plan.fsm.external.contains(event);
        let Some(id) = self.machine.input(event).filter(|_| known) else {
            return Err(Refusal::UnknownEvent {
                role: plan.role.clone(),
                event: event.clone(),
                known: quoted(plan.fsm.external.iter()),
            });
        };
        let command = Command::Instruct(instruction.with_event(id));
        let mut handles = self.handles.0.iter_mut();
        let navigation = handles.find(|handle| handle.kind == ActivityKind::Navigation);
        if navigation.is_none_or(|handle| handle.commands.send(command).is_err()) {
            return Err(Refusal::QueueFull);
        }
        Ok(())
    }

    pub(super) fn answer_sent(&mut self, what: Instructed) {
        // One that took too long has been answered already.
        if let Some(sent) = self.sent.take() {
            sent.answer(what, &self.machine, &self.reload.plan().fsm);
        }
    }

    pub(super) fn expire_sent(&mut self, now_ns: u64) {
        if let Some(sent) = self.sent.take_if(|sent| sent.is_late(now_ns)) {
            answer(sent.pending, &Err(Refusal::NoAnswer));
        }
    }

    /// Tells those who have reset the robot what still stops it, and what else is the matter.
    pub(super) fn answer_resets(&mut self, now_ns: u64) {
        let due = self.resets.due(now_ns);
        if due.is_empty() {
            return;
        }
        // Of a drive that does not answer no fault was reset, and when it is back it may have more.
        let gone = self.drive_gone().into_iter();
        let remaining: Vec<_> = gone.chain(self.stopped_by()).collect();
        // What remains may end by itself, or an activity that was busy may carry the reset out later: none that was refused may have
        // let the robot go on then. One that does not know where it is can be driven by hand, and is paused when that ends; whoever says
        // where it is stops it, too.
        let holds = |&fault: &Fault| match fault {
            Fault::PlaceUnknown => false,
            Fault::PoseUncertain => self.lease.is_none(),
            _ => true,
        };
        if self.resets.is_empty() && remaining.iter().any(holds) {
            self.raise(Who::Operator, Fault::OperatorStop, 0.0, now_ns);
        }
        for pending in due {
            let reply = match remaining.is_empty() {
                true => Ok(Done::Reset(self.table.active().collect())),
                false => Err(Refusal::Remaining(remaining.clone())),
            };
            answer(pending, &reply);
        }
    }
}
