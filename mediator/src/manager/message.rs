//! What the manager says to a robot.

use contract::timing::LEVEL_PERIOD_NS;
use contract::wire::{AccessGrant, Control, MediatorReport, TakeUp};
use contract::{VERSION, level};

use super::routing::Manager;
use super::view::View;

impl Manager {
    /// Repeats levels that are due, between two ticks: few at a time, so that no news waits behind many.
    pub fn repeat_levels(&mut self, now_ns: u64) {
        self.sessions.keep_up(now_ns, &mut self.effects);
    }

    /// The next message to send, to the robot that it names; nothing when all have heard the news.
    pub fn next_message(&mut self, now_ns: u64) -> Option<MediatorReport> {
        if let Some(refusal) = self.sessions.next_refusal() {
            let (instance, journal) = (self.peers.instance, self.peers.journal);
            return Some(MediatorReport {
                instance,
                journal,
                ..refusal
            });
        }
        let (robot, boot_epoch, session) =
            self.sessions.next_listener(now_ns, &mut self.effects)?;
        self.explain_waits(robot, now_ns);
        let message = self.view(now_ns).message(robot, boot_epoch, session);
        let own = self.sessions.robot_mut(robot);
        if own.is_of(boot_epoch) {
            if message.session == 0 || own.unaccounted {
                own.say_all();
            } else {
                self.areas.note_said(robot, message.sequence);
            }
        }
        Some(message)
    }

    /// Says why the robot waits. That is for people, and may be as old as a level.
    fn explain_waits(&mut self, robot: usize, now_ns: u64) {
        let old = |why_ns: u64| why_ns == 0 || now_ns >= why_ns.saturating_add(LEVEL_PERIOD_NS);
        let claims = self.areas.robot(robot).claims.iter();
        let due: Vec<usize> = { claims }
            .filter(|(_, claim)| claim.waits() && old(claim.why.0))
            .map(|(area, _)| area)
            .collect();
        for area in due {
            let why = self.view(now_ns).explain(robot, area);
            self.areas.note_why(robot, area, now_ns, why);
        }
    }
}

impl View<'_> {
    /// The whole of what the process of a boot must know, as of now.
    pub(crate) fn message(&self, robot: usize, boot_epoch: u64, session: u64) -> MediatorReport {
        let own = self.sessions.robot(robot);
        let refusal = own.refusal(boot_epoch);
        let refused = !refusal.is_empty();
        // Another mediator may have granted and taken back since: its robot knows better, and says so first.
        let withheld = refused || own.unaccounted;
        let known = own.known().filter(|_| session == own.number);
        MediatorReport {
            version: Some(VERSION.into()),
            mediator_epoch: self.sessions.epoch,
            sequence: own.sent,
            robot_id: self.names.robot_id(robot),
            boot_epoch,
            session: if refused { 0 } else { session },
            refusal: refusal.to_owned(),
            role: self.names.robots()[robot].role.clone(),
            access: if withheld {
                Vec::new()
            } else {
                self.access(robot, known)
            },
            revocations: if withheld {
                Vec::new()
            } else {
                self.areas.revocations_of(robot, known)
            },
            control: self.control(robot).filter(|_| !refused),
            take_up: self.take_up(robot, session),
            floor_hash: self.names.floor.hash(),
            floor: if own.knows_floor {
                Vec::new()
            } else {
                self.names.floor.say()
            },
            instance: self.peers.instance,
            journal: self.peers.journal,
            stands_by: self.peers.stands_by,
            robot_sequence: if own.is_of(boot_epoch) && self.may_have_lease(robot) {
                own.counted
            } else {
                0
            },
            identity_doubled: self.sessions.is_doubled(robot, self.now_ns),
            ..MediatorReport::default()
        }
    }

    /// Protocol 1 of all areas that the robot has used, but for those that rest as it knows.
    fn access(&self, robot: usize, known: Option<u64>) -> Vec<AccessGrant> {
        { self.areas.robot(robot).claims.iter() }
            .filter(|(_, claim)| claim.is_said(known))
            .map(|(area, claim)| AccessGrant {
                area: self.names.area_id(area),
                level: Some(level::encode(claim.level())),
                fence: claim.fence,
                waits_for: if claim.waits() {
                    claim.why.1.clone()
                } else {
                    String::new()
                },
                place: self.place(robot, area),
            })
            .collect()
    }

    /// Its place in the order of requests, from 1; 0 when it does not wait.
    fn place(&self, robot: usize, area: usize) -> u32 {
        let queue = &self.areas.area(area).queue;
        let place = { queue.iter() }.position(|&other| other == robot);
        place.map_or(0, |place| u32::try_from(place + 1).unwrap_or(u32::MAX))
    }

    /// Protocol 2, for a robot that a coordination has acquired or is about to.
    fn control(&self, robot: usize) -> Option<Control> {
        let (instance, role) = self.coordinations.control_of(robot)?;
        let script = instance.script(role);
        Some(Control {
            coordination: instance.number,
            level: Some(level::encode(instance.participants()[role].level())),
            net: instance.plan.net.clone(),
            flags: script.flags.clone(),
            paths: script.paths.clone(),
        })
    }

    /// For a robot that has not yet said where it is, and that left something behind when it restarted.
    fn take_up(&self, robot: usize, session: u64) -> Option<TakeUp> {
        let occupant = self.areas.robot(robot);
        let was_there = !occupant.fsm_state.is_empty();
        let is_new = session != self.sessions.robot(robot).number || !occupant.placed;
        (was_there && is_new).then(|| TakeUp {
            // Known only if this mediator has heard it: from a journal the pose would be too old.
            pose: occupant.pose,
            fsm_state: occupant.fsm_state.clone(),
            release: self.coordinations.release_from(robot, &occupant.fsm_state),
        })
    }
}
