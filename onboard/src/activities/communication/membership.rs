//! Communication on a managed site: between the mediator's messages, navigation, and [`Member`].

use contract::wire::{MediatorReport, Pose};
use contract::{Message, decode};
use coordination::event::EventId;
use coordination::fsm::Machine;
use nalgebra::Matrix3;
use skills::borders::AreaSet;

use super::network::{Mailbox, Session};
use crate::activities::fleet_link::{CommunicationEnd, NavigationEvent};
use crate::fleet::{Directive, Member, Sense, Setup, Troubles, UncertainPose};
use crate::realtime::clock::SECOND_NS;
use crate::realtime::log::{Complaints, LogSender};
use crate::symbols::values::{FleetState, Whereabouts};
use crate::symbols::wiring::CommunicationFleetSymbols;

/// An older pose does not say where the robot is.
const POSE_AGE_NS: u64 = SECOND_NS;

/// What a robot says of a mediator that acknowledges none of its reports.
const UNHEARD: &str = "the mediator is heard, and does not acknowledge what this robot reports: it awaits other robots or stands by \
    (`mediator why` says so), or the link carries one way only; no further area is entered until it does";

/// What communication needs on a managed site.
pub struct MembershipSetup {
    /// The robot's side of the mediator.
    pub setup: Setup,
    /// The queues to navigation and back.
    pub link: CommunicationEnd,
    /// The robot's machine, for the names of its outputs; navigation steps it.
    pub machine: Machine,
}

/// The robot as a member of its fleet.
pub(super) struct Membership {
    symbols: CommunicationFleetSymbols,
    /// `None` where nobody manages the areas.
    inner: Option<Inner>,
}

struct Inner {
    member: Member,
    link: CommunicationEnd,
    machine: Machine,
    mailbox: Mailbox,
    /// Refused by navigation's full queue, to be sent again.
    unsent: Option<Directive>,
    sense: Sense,
    refusals: Complaints,
    unheard: Complaints,
    sent: u64,
    received: u64,
    unreadable: u64,
}

impl Membership {
    pub(super) fn new(
        symbols: CommunicationFleetSymbols,
        setup: Option<MembershipSetup>,
        now_ns: u64,
    ) -> Self {
        let inner = setup.map(|own| Inner {
            member: Member::new(own.setup, now_ns),
            link: own.link,
            machine: own.machine,
            mailbox: Mailbox::default(),
            unsent: None,
            sense: Sense::default(),
            refusals: Complaints::default(),
            unheard: Complaints::default(),
            sent: 0,
            received: 0,
            unreadable: 0,
        });
        Self { symbols, inner }
    }

    /// Where messages of the mediator go; none where there is no mediator.
    pub(super) fn mailbox(&self) -> Option<Mailbox> {
        self.inner.as_ref().map(|inner| inner.mailbox.clone())
    }

    /// Messages of the mediator so far; `None` where there is none.
    pub(super) fn received(&self) -> Option<u64> {
        self.inner.as_ref().map(|inner| inner.received)
    }

    /// Takes in what the mediator, navigation and the robot's pose say.
    pub(super) fn listen(&mut self, speed_m_s: f64, now_ns: u64) {
        let Some(inner) = &mut self.inner else { return };
        while let Some(letter) = inner.mailbox.take() {
            match decode::<MediatorReport>(&letter) {
                Ok(message) => {
                    inner.received += 1;
                    inner.member.receive(&message, now_ns);
                }
                Err(_) => inner.unreadable += 1,
            }
        }
        while let Some(event) = inner.link.events.receive() {
            match event {
                NavigationEvent::Output(output) => inner.output(output),
                NavigationEvent::Instructed(answer) => inner.member.answered(answer),
                NavigationEvent::Relocated => inner.member.relocated(),
            }
        }
        // Read last, so that it includes what navigation has just reported.
        let whereabouts = self.symbols.whereabouts.read();
        let fresh = { whereabouts.age_ns(now_ns) }.is_some_and(|age_ns| age_ns <= POSE_AGE_NS);
        inner.sense = sense(&whereabouts.value, fresh, speed_m_s);
    }

    /// Nobody knows where the robot is any more.
    pub(super) fn lose_place(&mut self) {
        if let Some(inner) = &mut self.inner {
            inner.member.lose_place();
        }
    }

    /// One step of the protocols.
    pub(super) fn step(&mut self, now_ns: u64) {
        if let Some(inner) = &mut self.inner {
            inner.member.step(&inner.sense, now_ns);
        }
    }

    /// Tells navigation where the robot may be and what to do, then the mediator. In this order: an area given back may be
    /// granted to another robot as soon as the mediator knows.
    pub(super) fn speak(
        &mut self,
        session: Option<&dyn Session>,
        log: &LogSender,
        now_ns: u64,
    ) -> Result<(), String> {
        let Some(inner) = &mut self.inner else {
            return Ok(());
        };
        self.symbols.allowed.write(now_ns, &inner.member.allowed());
        inner.give_orders();
        while let Some(complaint) = inner.member.next_complaint() {
            log.warn(format!("mediator: {complaint}"));
        }
        let state = inner.state(now_ns);
        self.symbols.state.write(now_ns, &state);
        match session {
            Some(session) if inner.member.is_report_due(now_ns) => {
                inner.sent += 1;
                session.send_report(inner.member.report(now_ns).encode_to_vec())
            }
            _ => Ok(()),
        }
    }

    /// The activity has ended: nothing is allowed any more.
    pub(super) fn leave(&mut self, now_ns: u64) {
        if self.inner.is_some() {
            self.symbols.allowed.write(now_ns, &AreaSet::EMPTY);
        }
    }

    /// What is wrong with the mediator at present.
    pub(super) fn troubles(&mut self, log: &LogSender, now_ns: u64) -> Troubles {
        let Some(inner) = &mut self.inner else {
            return Troubles::default();
        };
        let troubles = inner.member.troubles(now_ns);
        if troubles.refused {
            let why = inner.member.refusal().to_owned();
            inner
                .refusals
                .say(log, "the mediator refuses this robot", why);
        } else {
            inner.refusals.forget();
        }
        if troubles.unheard {
            inner.unheard.say(log, "no lease", UNHEARD.to_owned());
        } else {
            inner.unheard.forget();
        }
        troubles
    }
}

impl Inner {
    fn output(&mut self, output: EventId) {
        self.member.output(self.machine.output_name(output));
    }

    fn give_orders(&mut self) {
        while let Some(directive) = self.unsent.take().or_else(|| self.member.next_directive()) {
            if self.link.orders.send(directive).is_err() {
                // Navigation is slow; this order is sent first next time.
                self.unsent = Some(directive);
                return;
            }
        }
    }

    fn state(&self, now_ns: u64) -> FleetState {
        FleetState {
            sent: self.sent,
            received: self.received,
            dropped: self.mailbox.dropped() + self.unreadable,
            ..self.member.state(now_ns)
        }
    }
}

/// What navigation says of the robot, for the protocols.
fn sense(whereabouts: &Whereabouts, fresh: bool, speed_m_s: f64) -> Sense {
    if !fresh {
        return Sense::default();
    }
    let at = &whereabouts.at;
    let (pose, covariance) = (at.pose, Matrix3::from(at.covariance).transpose());
    let known = at.uncertain == 0 && pose.is_finite();
    let std = |axis: usize| at.covariance[axis][axis].max(0.0).sqrt();
    Sense {
        place: known.then_some(UncertainPose { pose, covariance }),
        pose: Some(Pose {
            std_x_m: std(0),
            std_y_m: std(1),
            std_theta_rad: std(2),
            ..pose.into()
        }),
        speed_m_s,
        state: usize::try_from(at.state).ok(),
        waiting_for: whereabouts.waiting_for(),
    }
}

#[cfg(test)]
mod tests {
    use description::areas::AreaIndex;
    use description::geometry::Pose2;

    use super::*;

    #[test]
    fn what_is_stale_or_uncertain_is_no_place() {
        let mut here = Whereabouts {
            waiting_for: u64::MAX,
            ..Whereabouts::default()
        };
        here.at.pose = Pose2::new(1.0, 0.0, 0.0);
        here.at.covariance = [[0.04, 0.01, 0.0], [0.01, 0.0, 0.0], [0.0; 3]];
        here.at.state = 3;
        let known = sense(&here, true, 0.2);
        let place = known.place.expect("a place");
        assert_eq!(
            (place.covariance[(0, 1)], place.covariance[(1, 0)]),
            (0.01, 0.01)
        );
        assert_eq!((known.state, known.waiting_for), (Some(3), None));
        assert_eq!(known.pose.map(|pose| pose.std_x_m), Some(0.2));
        assert!(sense(&here, false, 0.2).place.is_none());
        here.at.uncertain = 1;
        let unsure = Whereabouts {
            waiting_for: 2,
            ..here
        };
        let unsure = sense(&unsure, true, 0.2);
        assert!(unsure.place.is_none() && unsure.state == Some(3));
        assert_eq!(unsure.waiting_for, AreaIndex::new(2));
    }
}
