//! A run under way: looks at everything some tens of times a second, and knows when it ends.

use sim::world::{Pose, STANDING_M_S, Truth, TruthRecord};

use super::ending::Ending;
use super::execution::Execution;
use super::path::Path;
use crate::belief::Belief;
use crate::goals::Progress;
use crate::judge::{Judge, Look};
use crate::network::mediator_status::Told;
use crate::record::{Incident, PathPoint, StateChange};
use crate::scenario::{HELPED_AFTER_S, Player, Scenario};
use crate::shapes;
use crate::stand_ins::leave::LeaveKeeper;
use crate::stand_ins::operator::Operator;
use crate::testbed::drawn_starts;
use crate::violation::ViolationKind;
use onboard::cli::Failure;

/// What is known of one robot while it runs.
#[derive(Clone, Debug)]
pub struct Track {
    /// How far it is with its goal.
    pub progress: Progress,
    /// Where it truly was.
    pub path: Path,
    /// What is true of it; none before it was looked at.
    pub truth: Option<Truth>,
    /// Fastest true speed.
    pub fastest_m_s: f64,
    /// States that it believed to be in, where that is looked at.
    pub states: Vec<StateChange>,
    operator: Option<Operator>,
    leave: Option<LeaveKeeper>,
    leave_now: Vec<bool>,
}

/// A run under way.
pub struct Run<E> {
    /// The scenario.
    pub scenario: Scenario,
    /// Robots, world and mediator.
    pub stage: E,
    /// The judge.
    pub judge: Judge,
    /// Seed of everything that is drawn at random.
    pub seed: u64,
    pub(super) tracks: Vec<Track>,
    pub(super) incidents: Vec<Incident>,
    looks_inside: bool,
    moved_ns: u64,
}

impl<E: Execution> Run<E> {
    /// Begins to judge what `stage` runs.
    pub fn new(scenario: Scenario, mut stage: E, seed: u64) -> Self {
        let starts = drawn_starts(&scenario, seed);
        let tracks = { scenario.robots.iter().enumerate().zip(&starts) }
            .map(|((robot, player), (_, start))| {
                let seed = seed.wrapping_add(robot as u64);
                let footprint = shapes::footprint(&player.config);
                let keeper = LeaveKeeper::random(&scenario.site, &footprint, start, seed);
                let leave_now: Vec<bool> = keeper.granted().collect();
                let withheld = scenario.withholds_areas && stage.give_leave(robot, &leave_now);
                Track::new(&scenario, player, withheld.then_some(keeper), seed)
            })
            .collect();
        Self {
            judge: Judge::new(&scenario, stage.start_ns(), stage.hears_grants()),
            moved_ns: stage.start_ns(),
            looks_inside: scenario.looks_inside(),
            tracks,
            incidents: { scenario.faults.iter() }
                .map(|fault| Incident {
                    at_s: fault.at_s,
                    what: fault.to_string(),
                })
                .collect(),
            scenario,
            stage,
            seed,
        }
    }

    /// Waits for the next look, and looks; returns how the run ended, if it did.
    ///
    /// # Errors
    /// [`Failure::Failed`] when a robot cannot be started.
    pub fn step(&mut self) -> Result<Option<Ending>, Failure> {
        self.stage.pass_time()?;
        self.observe();
        let (start_ns, now_ns) = (self.stage.start_ns(), self.stage.now_ns());
        let longest_ns = (self.scenario.longest_s() * 1e9) as u64;
        let now_s = self.stage.seconds(now_ns);
        // The end of a fault, and the operator's time, give the fleet as much time as if it had just moved.
        let moved_s = self.stage.seconds(self.moved_ns);
        let over_s = self.scenario.may_stand_until_s(now_s);
        let moved_s = over_s.map_or(moved_s, |over_s| moved_s.max(over_s + HELPED_AFTER_S));
        let ending = if self.is_done() {
            Some(Ending::Done)
        } else if let Some(ending) = self.stage.ended() {
            Some(ending)
        } else if now_ns >= start_ns + longest_ns {
            Some(Ending::TooSlow)
        } else if now_s - moved_s > self.scenario.standstill_s {
            Some(Ending::Standstill)
        } else {
            None
        };
        if let Some(Ending::Standstill) = ending {
            self.judge_standstill(now_ns);
        }
        Ok(ending)
    }

    /// No robot moves: finds those that should have gone on after faults.
    fn judge_standstill(&mut self, now_ns: u64) {
        let now_s = self.stage.seconds(now_ns);
        if !self.scenario.must_have_gone_on(now_s) {
            return;
        }
        let calm_s = now_s - self.scenario.last_fault_over_s(now_s).unwrap_or_default();
        for (robot, player) in self.scenario.robots.iter().enumerate() {
            let figures = self.judge.figures(robot);
            if let Some(missing) = self.tracks[robot].progress.missing(&player.id, figures) {
                let detail = format!("{missing}, {calm_s:.1} s after the last fault was over");
                let kind = ViolationKind::StuckAfterFaults;
                self.judge.report_of(robot, kind, now_ns, detail);
            }
        }
    }

    /// Where a robot truly is; none before it was looked at.
    #[must_use]
    pub fn truth(&self, robot: usize) -> Option<Truth> {
        self.tracks.get(robot)?.truth
    }

    /// What is known of the robots, in the order of the scenario.
    #[must_use]
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// Whether all goals are reached: words are only made when no robot is on its way any more.
    fn is_done(&self) -> bool {
        let robots_are = { self.tracks.iter() }.all(|track| track.progress.done_ns().is_some());
        robots_are && self.missing().is_empty()
    }

    /// What has not been reached yet, in words; empty: all goals are reached.
    #[must_use]
    pub fn missing(&self) -> Vec<String> {
        let mut missing = Vec::new();
        for (robot, (player, track)) in self.scenario.robots.iter().zip(&self.tracks).enumerate() {
            missing.extend(
                track
                    .progress
                    .missing(&player.id, self.judge.figures(robot)),
            );
        }
        for (id, wanted) in &self.scenario.coordinations {
            let ended = self.stage.told(|told| self.ended(told, id));
            if ended < *wanted {
                missing.push(format!(
                    "coordination {id} has run to its end {ended} of {wanted} times"
                ));
            }
        }
        if missing.is_empty() {
            let never = self.judge.rules().into_iter();
            missing.extend(
                never
                    .filter(|rule| rule.checked_s <= 0.0)
                    .map(|rule| format!("never checked: {}", rule.rule)),
            );
        }
        missing
    }

    /// How many runs of a coordination have come to a declared end of their net.
    fn ended(&self, told: Option<&Told>, id: &str) -> u32 {
        let is_end = |net: &str, marking: &[String]| {
            let net = self.scenario.nets.iter().find(|own| own.name == net);
            net.is_some_and(|net| {
                { net.ends.iter() }
                    .any(|end| end.places.iter().all(|place| marking.contains(place)))
            })
        };
        let all = told
            .into_iter()
            .flat_map(|told| told.coordinations.values());
        let ended = all.filter(|seen| {
            let status = &seen.status;
            status.over && status.id == id && is_end(&status.net, &status.marking)
        });
        u32::try_from(ended.count()).unwrap_or(u32::MAX)
    }

    /// Takes in what has been true since the last look.
    pub(super) fn observe(&mut self) {
        for record in self.stage.truths() {
            if record.robot < self.tracks.len() {
                self.look(&record);
            } else {
                self.look_at_clone(&record);
            }
        }
    }

    fn look(&mut self, record: &TruthRecord) {
        let (robot, truth) = (record.robot, &record.truth);
        let (judge, track) = (&mut self.judge, &mut self.tracks[robot]);
        let belief = if self.looks_inside {
            self.stage.belief(robot)
        } else {
            None
        };
        self.stage.show(|world, observations| {
            judge.observe(&Look {
                robot,
                truth,
                world,
                belief: belief.as_ref(),
                leave: &track.leave_now,
                observations,
            });
        });
        judge.observe_latch(robot, truth, self.stage.latch(robot));
        track.progress.observe(truth, judge.figures(robot));
        let (progress, id) = (&track.progress, &self.scenario.robots[robot].id);
        judge.observe_progress(robot, truth, |figures| progress.missing(id, figures));
        track.truth = Some(*truth);
        let speed_m_s = truth.twist.v_m_s.abs();
        track.fastest_m_s = track.fastest_m_s.max(speed_m_s);
        if speed_m_s > STANDING_M_S {
            self.moved_ns = self.moved_ns.max(truth.time_ns);
        }
        let at_s = self.stage.seconds(truth.time_ns);
        track.path.push(PathPoint {
            at_s,
            pose: truth.pose,
            speed_m_s: truth.twist.v_m_s,
            clearance_m: truth.clearance_m,
            in_contact: truth.in_contact,
        });
        if let Some(belief) = &belief {
            track.note_state(at_s, belief);
            self.operate(robot, belief, truth);
        }
        self.keep_leave(robot, truth);
    }

    /// A second robot with the identity of one: of it only its conduct is judged.
    fn look_at_clone(&mut self, record: &TruthRecord) {
        let judge = &mut self.judge;
        self.stage.show(|world, observations| {
            judge.observe(&Look {
                robot: record.robot,
                truth: &record.truth,
                world,
                belief: None,
                leave: &[],
                observations,
            });
        });
    }

    /// Has the operator look at a robot.
    fn operate(&mut self, robot: usize, belief: &Belief, truth: &Truth) {
        let fsm = &self.scenario.robots[robot].fsm;
        let Some(operator) = &mut self.tracks[robot].operator else {
            return;
        };
        let instruction = operator.look(&self.scenario.site, fsm, &belief.state, truth);
        if let Some(instruction) = instruction {
            if let Some(pose) = instruction.stop_at {
                let pose = Pose::new(pose.x_m, pose.y_m, pose.theta_rad);
                self.judge.instructed(robot, pose);
            }
            if let Err(why) = self.stage.instruct(robot, &instruction) {
                self.judge
                    .report_of(robot, ViolationKind::Instruction, truth.time_ns, why);
            }
        }
    }

    /// Gives and withholds leave for areas, where the rig does so.
    fn keep_leave(&mut self, robot: usize, truth: &Truth) {
        let footprint = shapes::footprint(&self.scenario.robots[robot].config);
        let now_ns = self.stage.now_ns();
        let track = &mut self.tracks[robot];
        let (site, speed_m_s) = (&self.scenario.site, truth.twist.v_m_s);
        if let Some(keeper) = &mut track.leave
            && keeper.look(site, &footprint, &truth.pose, speed_m_s, now_ns)
        {
            track.leave_now = keeper.granted().collect();
            self.stage.give_leave(robot, &track.leave_now);
        }
    }

    pub(super) fn note(&mut self, what: String) {
        let at_s = self.stage.seconds(self.stage.now_ns());
        self.incidents.push(Incident { at_s, what });
    }
}

impl Track {
    fn new(scenario: &Scenario, player: &Player, leave: Option<LeaveKeeper>, seed: u64) -> Self {
        Self {
            progress: Progress::new(&scenario.site, player),
            path: Path::default(),
            truth: None,
            fastest_m_s: 0.0,
            states: Vec::new(),
            operator: player.operator.then(|| Operator::new(seed)),
            leave_now: { leave.iter() }.flat_map(LeaveKeeper::granted).collect(),
            leave,
        }
    }

    /// How often leave for an area was withheld until the robot had waited.
    #[must_use]
    pub fn withheld(&self) -> u64 {
        self.leave.as_ref().map_or(0, LeaveKeeper::withheld)
    }

    fn note_state(&mut self, at_s: f64, belief: &Belief) {
        let changed = { self.states.last() }
            .is_none_or(|last| last.state != belief.state || last.skill != belief.skill);
        if changed && !belief.skill.is_empty() {
            self.states.push(StateChange {
                at_s,
                state: belief.state.clone(),
                area: belief.area.clone(),
                skill: belief.skill.clone(),
                believed_m: [belief.pose.x_m, belief.pose.y_m],
            });
        }
    }
}
