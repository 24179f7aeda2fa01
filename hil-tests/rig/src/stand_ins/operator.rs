//! The operator of a trial: gives the events that nothing on the robot raises, with stop poses and speed limits.

use config::SiteConfig;
use description::geometry::Pose2;
use description::instruction::Instruction;
use description::site::{ControllerConfig, FsmConfig, StopPlace};
use sim::world::{Random, STANDING_M_S, Truth};

use crate::lanes::lane_of;

/// The operator reacts to a state after this time, as a person does.
const LOOKS_S: f64 = 0.6;
/// How far ahead of the robot a stop may be asked for: least and most.
const AHEAD_M: [f64; 2] = [0.8, 1.6];
/// A stop may come with a speed limit: least and most.
const SPEED_LIMIT_M_S: [f64; 2] = [0.15, 0.35];
const OPERATOR_STREAM: u64 = 0x4F50_4552;

/// Plays the operator, at random by the seed.
#[derive(Clone, Debug)]
pub struct Operator {
    random: Random,
    state: String,
    since_ns: u64,
    acted: bool,
    stopped: bool,
}

impl Operator {
    /// An operator who has done nothing yet.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self {
            random: Random::new(seed, OPERATOR_STREAM),
            state: String::new(),
            since_ns: 0,
            acted: false,
            stopped: false,
        }
    }

    /// Looks at the robot in a state of its machine; at most one instruction for each visit of a state.
    pub fn look(
        &mut self,
        site: &SiteConfig,
        fsm: &FsmConfig,
        state: &str,
        truth: &Truth,
    ) -> Option<Instruction<String>> {
        if self.state != state {
            state.clone_into(&mut self.state);
            self.since_ns = truth.time_ns;
            self.acted = false;
        }
        let waited_s = truth.time_ns.saturating_sub(self.since_ns) as f64 / 1e9;
        if self.acted || waited_s < LOOKS_S {
            return None;
        }
        let transitions = fsm.transitions.iter().filter(|one| one.from == state);
        let mut external = transitions
            .clone()
            .filter(|one| one.on != "reset" && fsm.external.contains(&one.on));
        let stands = truth.twist.v_m_s.abs() < STANDING_M_S;
        let stop = external
            .clone()
            .find(|one| one.to != state && takes_pose(site, fsm, &one.to));
        if let Some(stop) = stop.filter(|_| !self.stopped && !stands) {
            self.acted = true;
            self.stopped = true;
            let pose = self.place_ahead(site, fsm, &stop.to, truth)?;
            let limit = self.between(SPEED_LIMIT_M_S);
            return Some(Instruction {
                event: stop.on.clone(),
                stop_at: Some(pose),
                speed_limit_m_s: (self.random.unit() < 0.5).then_some(limit),
            });
        }
        // When the robot stands, let it go on; if it would go on by itself, do so half the time.
        let go = external.find(|one| one.to != state && !takes_pose(site, fsm, &one.to))?;
        if !stands {
            return None;
        }
        self.acted = true;
        let by_itself = transitions
            .into_iter()
            .any(|one| !fsm.external.contains(&one.on));
        if by_itself && !takes_pose(site, fsm, state) && self.random.unit() < 0.5 {
            return None;
        }
        Some(Instruction::plain(go.on.clone()))
    }

    fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + self.random.unit() * (high - low)
    }

    /// A pose ahead of the robot on the lane of a state.
    fn place_ahead(
        &mut self,
        site: &SiteConfig,
        fsm: &FsmConfig,
        state: &str,
        truth: &Truth,
    ) -> Option<Pose2> {
        let line = lane_of(site, fsm.state(state)?)?.line;
        let along_m = line.along_m([truth.pose.x_m, truth.pose.y_m].into());
        let at = line.a + line.unit() * (along_m + self.between(AHEAD_M));
        Some(Pose2::new(at.x_m, at.y_m, line.direction_rad()))
    }
}

/// The state stops at a pose that comes with its event.
fn takes_pose(site: &SiteConfig, fsm: &FsmConfig, state: &str) -> bool {
    let skill = fsm.state(state).and_then(|state| site.skill(&state.skill));
    skill.is_some_and(|skill| {
        skill.controller
            == ControllerConfig::StopAt {
                place: StopPlace::Instructed,
            }
    })
}
