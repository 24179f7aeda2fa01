//! The manager of one site: hands every report, tick and order to the parts that it concerns.

use std::sync::Arc;

use contract::wire::RobotReport;

use super::alarm::Alarm;
use super::areas::Areas;
use super::circle::CircleWatch;
use super::coordinations::{Coordinations, Surroundings};
use super::effects::{Counters, Effects};
use super::error::{RestoreError, UnknownRobot};
use super::names::Names;
use super::peers::Peers;
use super::sessions::{Heard, Sessions};
use super::status::Status;
use super::view::View;
use crate::journal::{Entry, RobotRecord, SecondRecord, Stored};
use crate::nets::Plan;
use crate::setup::Setup;

/// The manager of one site.
#[derive(Clone, Debug)]
pub struct Manager {
    pub(super) names: Arc<Names>,
    pub(super) peers: Peers,
    pub(super) sessions: Sessions,
    pub(super) areas: Areas,
    pub(super) coordinations: Coordinations,
    circle: CircleWatch,
    pub(super) effects: Effects,
}

impl Manager {
    /// Takes up where the journal ends. Coordinates nobody.
    ///
    /// # Errors
    /// As [`Manager::with_plans`].
    pub fn new(setup: &Setup, stored: &Stored, now_ns: u64) -> Result<Self, RestoreError> {
        Self::with_plans(setup, Vec::new(), stored, now_ns)
    }

    /// Takes up where the journal ends. Nothing is granted until every robot has said where it stands, or an operator that it is
    /// [absent](Self::absent). `plans` are made for this setup.
    ///
    /// # Errors
    /// [`RestoreError`] when the setup makes no sense, or the journal is of another one.
    pub fn with_plans(
        setup: &Setup,
        plans: Vec<Arc<Plan>>,
        stored: &Stored,
        now_ns: u64,
    ) -> Result<Self, RestoreError> {
        setup.check()?;
        if stored.journal == 0 {
            return Err(RestoreError::Nameless);
        }
        let names = Arc::new(Names::new(setup)?);
        // Never smaller than before, so that robots recognise what an earlier start has said.
        let epoch = stored.epoch + 1;
        let mut effects = Effects::new(names.robots().len());
        effects.entries.push(Entry::Epoch(epoch));
        let silent_after_ns = u64::try_from(setup.silent_after.as_nanos()).unwrap_or(u64::MAX);
        let areas = Areas::restore(setup, &names, stored, now_ns)?;
        let mut sessions = Sessions::new(&names, epoch, silent_after_ns, now_ns);
        for (id, record) in &stored.robots {
            if let Some(robot) = names.robot(id) {
                sessions.robot_mut(robot).restore(record, now_ns);
            }
        }
        // The journal may have lost its last entries, or be older: any robot may be anywhere, also one that was absent once.
        sessions.wait_for((0..names.robots().len()).collect());
        let coordinations =
            Coordinations::restore(plans, areas.len(), &names, stored, now_ns, &mut effects);
        // Every start of a journal's mediator has another number; `speaks_as` gives it one that no other journal's has.
        let robots = names.robots().len();
        let peers = Peers::new(epoch, stored.journal, epoch, robots, silent_after_ns);
        Ok(Self {
            peers,
            names,
            sessions,
            areas,
            coordinations,
            circle: CircleWatch::default(),
            effects,
        })
    }

    /// The number of this process, drawn at random at its start, by which robots tell it from others.
    #[must_use]
    pub fn speaks_as(mut self, instance: u64) -> Self {
        self.peers.instance = instance;
        self
    }

    /// The number of this process.
    #[must_use]
    pub fn instance(&self) -> u64 {
        self.peers.instance
    }

    /// Another mediator goes on; this one grants nothing.
    #[must_use]
    pub fn stands_by(&self) -> bool {
        self.peers.stands_by
    }

    /// Number of this start of the mediator, larger than that of all before; it may grow.
    #[must_use]
    pub fn epoch(&self) -> u64 {
        self.sessions.epoch
    }

    /// The robots that the site lists.
    #[must_use]
    pub fn robot_ids(&self) -> Vec<String> {
        let robots = 0..self.names.robots().len();
        robots.map(|robot| self.names.robot_id(robot)).collect()
    }

    /// Counts since the start.
    #[must_use]
    pub fn counters(&self) -> Counters {
        Counters {
            looks: self.peers.looks + self.coordinations.looks(),
            ..self.effects.counters
        }
    }

    /// What must be in the journal before any message leaves.
    pub fn entries(&mut self) -> std::vec::Drain<'_, Entry> {
        self.effects.entries.drain(..)
    }

    /// What people should hear of.
    pub fn alarms(&mut self) -> std::vec::Drain<'_, Alarm> {
        self.effects.alarms.drain(..)
    }

    /// How everything stands.
    #[must_use]
    pub fn status(&self, now_ns: u64) -> Status {
        self.view(now_ns).status()
    }

    /// Why a robot waits, a sentence for each area that it has asked for.
    ///
    /// # Errors
    /// [`UnknownRobot`] when the site has no such robot.
    pub fn why(&self, robot_id: &str, now_ns: u64) -> Result<String, UnknownRobot> {
        self.view(now_ns).why(robot_id)
    }

    pub(super) fn view(&self, now_ns: u64) -> View<'_> {
        View {
            names: &self.names,
            peers: &self.peers,
            sessions: &self.sessions,
            areas: &self.areas,
            coordinations: &self.coordinations,
            now_ns,
        }
    }

    // ---------------------------------------------------------------- reports in

    /// Takes in a report, however late, repeated or out of order it is.
    pub fn report(&mut self, report: &RobotReport, now_ns: u64) {
        let effects = &mut self.effects;
        effects.counters.reports += 1;
        let Some(robot) = self.sessions.identify(report, now_ns, effects) else {
            return;
        };
        self.coordinations.look_again_at(robot);
        let news = self.hear_whom_it_follows(robot, report, now_ns);
        if self.peers.asks(robot) && !self.sessions.robot(robot).is_retired(report.boot_epoch) {
            return;
        }
        let ours = self.peers.is_ours(report);
        if self.peers.stands_by && report.mediator_instance != self.peers.instance {
            return self.stand_by(robot, report, now_ns);
        }
        if !self.sessions.robot(robot).is_of(report.boot_epoch) && self.areas.may_enter(robot) {
            // Who speaks for it now may still enter what was granted to it.
            let until_ns = self.enters_no_more_ns(robot);
            self.sessions.robot_mut(robot).may_live(until_ns);
        }
        let before = self.speaker(robot);
        let effects = &mut self.effects;
        let recognised = (self.sessions).recognise(robot, report, ours, now_ns, effects);
        if recognised.promoted {
            self.areas.note_before(robot, before);
        }
        let speaks = recognised.promoted || recognised.counts;
        let frees = speaks && {
            self.areas
                .promote_second(robot, report, recognised.promoted)
        };
        if recognised.promoted || self.sessions.is_awaited(robot) {
            // Nothing was granted since: wherever it is, it was before.
            self.areas.forget_place(robot);
        }
        if recognised.changed || frees {
            self.store_robot(robot);
        }
        if !recognised.counts {
            let alone = news && !self.sessions.is_heard(robot);
            let refused = alone && self.sessions.robot(robot).refuses(report.boot_epoch);
            if refused || self.sessions.may_be_second(robot, report) {
                self.hold_for_second(robot, report, refused, now_ns);
            }
            if alone && !refused && self.may_stand_there(robot, report) {
                self.store_robot(robot);
            }
            return;
        }
        let heard = self
            .sessions
            .hear(robot, report.located, now_ns, &mut self.effects);
        if heard.completes {
            self.nobody_is_awaited();
        }
        if heard.again {
            self.areas.touch_what_waits(robot);
        }
        if heard.again {
            self.coordinations.may_answer(robot);
        } else if let Some(control) = &report.control {
            self.coordinations.take_answer(robot, control);
        }
        if self.take_in_areas(robot, report, heard, now_ns) {
            self.sessions.drop_candidate(robot);
        }
        let moved = self.areas.place(robot, report, &mut self.effects);
        if self.judge_before(robot) || moved || heard.accounted || heard.returns {
            self.store_robot(robot);
        }
        self.coordinate(now_ns, |coordinations, around| {
            coordinations.take_in(robot, report, heard.first, around);
        });
        self.go_on(now_ns);
    }

    /// Takes in what a report says of areas. Returns whether a level has changed.
    fn take_in_areas(
        &mut self,
        robot: usize,
        report: &RobotReport,
        heard: Heard,
        now_ns: u64,
    ) -> bool {
        let (areas, effects) = (&mut self.areas, &mut self.effects);
        if heard.accounted {
            if areas.take_over(robot, report, now_ns, effects) {
                self.coordinate(now_ns, |coordinations, around| {
                    coordinations.surprised_by(robot, around);
                });
            }
            return true;
        }
        if self.sessions.robot(robot).unaccounted {
            // It does not know where it is: what it has is taken over when it does.
            return false;
        }
        let reservations = &mut self.coordinations;
        areas.take_in(robot, report, heard, now_ns, reservations, effects)
    }

    /// The report is of a process that does not speak for the robot yet, while none that does is heard. Where one that speaks for it
    /// is, the journal knows. Returns whether the journal must know this, too.
    fn may_stand_there(&mut self, robot: usize, report: &RobotReport) -> bool {
        let (session, speaker) = (self.sessions.robot(robot), self.speaker(robot));
        !session.is_of(report.boot_epoch) && self.areas.suspect(robot, report, speaker)
    }

    /// Orders and grants what can be; nothing while another mediator goes on.
    pub(super) fn go_on(&mut self, now_ns: u64) {
        if self.sessions.awaited().is_empty() {
            self.areas.all_grants_are_known(&mut self.effects);
        }
        if !self.peers.stands_by {
            self.coordinate(now_ns, Coordinations::go_on);
            self.serve();
        }
    }

    pub(super) fn store_robot(&mut self, robot: usize) {
        let occupant = self.areas.robot(robot);
        let ids = |areas: &[usize]| -> Vec<String> {
            areas.iter().map(|&area| self.names.area_id(area)).collect()
        };
        self.effects.entries.push(Entry::Robot {
            robot: self.names.robot_id(robot),
            record: RobotRecord {
                stands_in: ids(&occupant.stands_in),
                seconds: { occupant.seconds.found() }
                    .map(|found| SecondRecord {
                        boot_epoch: found.process,
                        sequence: found.sequence,
                        alone: found.alone,
                        stands_in: ids(&found.areas),
                        with_robot: ids(&found.with_robot),
                        before: found.before,
                    })
                    .collect(),
                fsm_state: occupant.fsm_state.clone(),
                ..self.sessions.robot(robot).record()
            },
        });
    }

    pub(super) fn coordinate(
        &mut self,
        now_ns: u64,
        act: impl FnOnce(&mut Coordinations, &mut Surroundings<'_>),
    ) {
        let mut around = Surroundings {
            sessions: &mut self.sessions,
            areas: &mut self.areas,
            effects: &mut self.effects,
            now_ns,
        };
        act(&mut self.coordinations, &mut around);
    }

    fn serve(&mut self) {
        self.areas
            .serve(&self.sessions, &mut self.coordinations, &mut self.effects);
    }

    // ---------------------------------------------------------------- time

    /// Lets time pass: finds silent robots, and repeats levels. Call it some times a second.
    pub fn tick(&mut self, now_ns: u64) {
        self.judge_peers(now_ns);
        self.give_up_absent(now_ns);
        for robot in 0..self.names.robots().len() {
            self.look_after_seconds(robot, now_ns);
            if self.sessions.falls_silent(robot, now_ns) {
                self.coordinations.look_again_at(robot);
                let areas = self.names.area_list(self.areas.occupied_by(robot));
                self.effects.alarms.push(Alarm::Silent {
                    robot: self.names.robot_id(robot),
                    areas: if areas.is_empty() {
                        "nothing".to_owned()
                    } else {
                        areas
                    },
                });
                // It cannot be granted anything while it is silent, so others may go first.
                self.areas.touch_what_waits(robot);
            }
        }
        self.sessions.keep_up(now_ns, &mut self.effects);
        self.areas.ask_again(now_ns);
        if !self.peers.stands_by {
            self.coordinate(now_ns, Coordinations::watch);
            let (names, areas) = (&self.names, &self.areas);
            let (sessions, coordinations) = (&self.sessions, &self.coordinations);
            let circles = (self.circle).look(names, areas, sessions, coordinations, now_ns);
            for (robot, area) in circles.ask_back {
                self.areas
                    .revoke_if_not_used(robot, area, &mut self.effects);
            }
            self.effects.alarms.extend(circles.alarms);
        }
        self.go_on(now_ns);
    }
}
