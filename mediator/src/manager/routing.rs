//! The manager of one site: hands every report, tick and order to the parts that it concerns.

use std::sync::Arc;

use contract::timing::LEVEL_PERIOD_NS;
use contract::wire::{MediatorReport, RobotReport};

use super::alarm::Alarm;
use super::areas::Areas;
use super::coordinations::{Coordinations, Surroundings};
use super::effects::{Counters, Effects};
use super::error::{ClearError, RestoreError, UnknownRobot};
use super::names::Names;
use super::peers::Peers;
use super::sessions::Sessions;
use super::status::Status;
use super::view::View;
use crate::journal::{Entry, RobotRecord, Stored};
use crate::nets::Plan;
use crate::setup::Setup;

/// The manager of one site.
#[derive(Debug)]
pub struct Manager {
    names: Arc<Names>,
    peers: Peers,
    sessions: Sessions,
    areas: Areas,
    coordinations: Coordinations,
    effects: Effects,
}

impl Manager {
    /// Takes up where the journal ends; an empty one is a first start. Coordinates nobody.
    ///
    /// # Errors
    /// As [`Manager::with_plans`].
    pub fn new(setup: &Setup, stored: &Stored, now_ns: u64) -> Result<Self, RestoreError> {
        Self::with_plans(setup, Vec::new(), stored, now_ns)
    }

    /// Takes up where the journal ends; an empty one is a first start. `plans` are made for this setup.
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
        let names = Arc::new(Names::new(setup)?);
        // Never smaller than before, so that robots recognise what an earlier start has said.
        let epoch = stored.epoch + 1;
        let mut effects = Effects::new(names.robots().len());
        effects.entries.push(Entry::Epoch(epoch));
        let silent_after_ns = u64::try_from(setup.silent_after.as_nanos()).unwrap_or(u64::MAX);
        let areas = Areas::restore(setup, &names, stored, now_ns)?;
        let mut sessions = Sessions::new(&names, epoch, silent_after_ns);
        for (id, record) in &stored.robots {
            if let Some(robot) = names.robot(id) {
                sessions.robot_mut(robot).restore(record, now_ns);
            }
        }
        let known = (0..names.robots().len())
            .filter(|&robot| sessions.robot(robot).number > 0 && areas.robot(robot).is_somewhere());
        sessions.wait_for(known.collect());
        let coordinations =
            Coordinations::restore(plans, areas.len(), &names, stored, now_ns, &mut effects);
        // Every start of a journal's mediator has another number; `speaks_as` gives it one that no other journal's has.
        let peers = Peers::new(
            epoch,
            stored.journal,
            epoch,
            names.robots().len(),
            silent_after_ns,
        );
        Ok(Self {
            peers,
            names,
            sessions,
            areas,
            coordinations,
            effects,
        })
    }

    /// The number of this process, drawn at random at its start, by which robots tell it from others.
    #[must_use]
    pub fn speaks_as(mut self, instance: u64) -> Self {
        self.peers.instance = instance;
        self
    }

    /// Another mediator goes on; this one grants nothing.
    #[must_use]
    pub fn stands_by(&self) -> bool {
        self.peers.stands_by
    }

    /// How often the mediator has started, this time included.
    #[must_use]
    pub fn epoch(&self) -> u64 {
        self.sessions.epoch
    }

    /// Counts since the start.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.effects.counters
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

    fn view(&self, now_ns: u64) -> View<'_> {
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
        let Some(robot) = self.sessions.identify(report, effects) else {
            return;
        };
        self.peers.hear(robot, report, now_ns);
        self.judge_peers(now_ns);
        let (effects, ours) = (&mut self.effects, self.peers.is_ours(report));
        if self.peers.stands_by && report.mediator_instance != self.peers.instance {
            return self.sessions.stand_by(report);
        }
        let recognised = (self.sessions).recognise(robot, report, ours, now_ns, effects);
        if recognised.promoted {
            self.areas.forget_place(robot);
        }
        if recognised.changed {
            self.store_robot(robot);
        }
        if !recognised.counts {
            return;
        }
        let heard = self.sessions.hear(robot, now_ns, &mut self.effects);
        if heard.completes {
            self.areas.touch_all();
        }
        if heard.again {
            self.areas.touch_what_waits(robot);
        }
        let (effects, reservations) = (&mut self.effects, &mut self.coordinations);
        let areas = &mut self.areas;
        if areas.take_in(robot, report, heard.first, now_ns, reservations, effects) {
            self.sessions.drop_candidate(robot);
        }
        if areas.place(robot, report, effects) {
            self.store_robot(robot);
        }
        self.coordinate(now_ns, |coordinations, around| {
            coordinations.take_in(robot, report, heard.first, around);
        });
        self.go_on(now_ns);
    }

    /// Orders and grants what can be; nothing while another mediator goes on.
    fn go_on(&mut self, now_ns: u64) {
        if !self.peers.stands_by {
            self.coordinate(now_ns, Coordinations::go_on);
            self.serve();
        }
    }

    fn judge_peers(&mut self, now_ns: u64) {
        let stood_by = self.peers.stands_by;
        if self.peers.decide(now_ns) {
            self.effects.alarms.push(Alarm::SecondMediator {
                instance: self.peers.instance,
                stands_by: self.peers.stands_by,
            });
        }
        if stood_by && !self.peers.stands_by {
            self.areas.touch_all();
        }
    }

    fn store_robot(&mut self, robot: usize) {
        let occupant = self.areas.robot(robot);
        let areas = occupant.stands_in.iter();
        self.effects.entries.push(Entry::Robot {
            robot: self.names.robot_id(robot),
            record: RobotRecord {
                stands_in: areas.map(|&area| self.names.area_id(area)).collect(),
                fsm_state: occupant.fsm_state.clone(),
                ..self.sessions.robot(robot).record()
            },
        });
    }

    fn coordinate(
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

    // ---------------------------------------------------------------- time and operators

    /// Lets time pass: finds silent robots, and repeats levels. Call it some times a second.
    pub fn tick(&mut self, now_ns: u64) {
        self.judge_peers(now_ns);
        for robot in 0..self.names.robots().len() {
            if self.sessions.falls_silent(robot, now_ns) {
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
            self.sessions.keep_up(robot, now_ns, &mut self.effects);
        }
        if !self.peers.stands_by {
            self.coordinate(now_ns, Coordinations::watch);
        }
        self.go_on(now_ns);
    }

    /// An operator says that no silent robot is in the area. Returns whose hold was ended.
    ///
    /// # Errors
    /// [`ClearError`] when there is no such area, or a robot that is heard is in it.
    pub fn clear(&mut self, area_id: &str, now_ns: u64) -> Result<Vec<String>, ClearError> {
        let area = self
            .names
            .area(area_id)
            .ok_or_else(|| ClearError::UnknownArea {
                found: area_id.to_owned(),
                known: self.names.all_areas(),
            })?;
        let occupants: Vec<usize> = self.areas.occupants(area).collect();
        if let Some(&robot) = { occupants.iter() }.find(|&&robot| self.sessions.is_heard(robot)) {
            return Err(ClearError::Heard {
                area: area_id.to_owned(),
                robot: self.names.robot_id(robot),
            });
        }
        for &robot in &occupants {
            self.effects.counters.cleared += 1;
            self.areas.leave(robot, area);
            self.store_robot(robot);
            self.areas.end_hold(robot, area, &mut self.effects);
            self.coordinate(now_ns, |coordinations, around| {
                coordinations.cleared_of(robot, around);
            });
            self.effects.tell(robot);
            if !self.areas.robot(robot).is_somewhere() {
                self.sessions.give_up(robot);
                self.areas.touch_all();
            }
        }
        self.areas.touch(area);
        self.go_on(now_ns);
        let names = occupants.iter().map(|&robot| self.names.robot_id(robot));
        Ok(names.collect())
    }

    // ---------------------------------------------------------------- messages out

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
        Some(self.view(now_ns).message(robot, boot_epoch, session))
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
