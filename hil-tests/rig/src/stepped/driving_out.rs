//! An operator takes a robot that finds no way on by hand, as `onboard teleop` does: a little back or around, to where it has
//! room ahead, and lets it go on. One that somebody has driven by hand before, to where it finds no way at all, he carries back.

use description::geometry::{Pose2, Twist2};
use onboard::process::ctl::{Request, Teleop};
use onboard::symbols::faults::{Fault, FaultTable, Resumes};
use sim::world::{Pose, STANDING_M_S, Truth, World};

use super::robot::SteppedRobot;
use crate::stand_ins::caretaker::brought_back;

/// An operator comes when a robot has found no way for this long,
const AFTER_NS: u64 = 10_000_000_000;
/// drives it for this long,
const LASTS_NS: u64 = 4_000_000_000;
/// at one of these speeds, on one of these curves,
const SPEEDS_M_S: [f64; 2] = [-0.1, 0.1];
const TURNS_RAD_S: [f64; 3] = [0.0, 0.05, -0.05];
/// so far from everything,
const APART_M: f64 = 0.11;
/// to where it has most room this far ahead. So far people look.
const AHEAD_M: f64 = 0.4;
const LOOK_M: f64 = 1.0;
/// How often, at most.
const TIMES: u32 = 3;

/// Drives one robot out.
#[derive(Clone, Debug, Default)]
pub(super) struct DrivingOut {
    /// Where it was when somebody took it to drive it by hand, and the state of its machine.
    taken_from: Option<(Pose, String)>,
    /// It is in hands until then.
    until_ns: Option<u64>,
    /// How often it was.
    pub(super) times: u32,
}

impl DrivingOut {
    /// Somebody drives it by hand from now on.
    pub(super) fn is_taken_from(&mut self, pose: Pose, state: String) {
        self.taken_from.get_or_insert((pose, state));
    }

    /// Whether the robot is in hands.
    pub(super) fn lasts(&self) -> bool {
        self.until_ns.is_some()
    }

    /// Looks after a robot with these faults, the number `number` of the world. Returns whether it is let go, to go on.
    pub(super) fn look(
        &mut self,
        robot: &mut SteppedRobot,
        faults: &FaultTable,
        world: &mut World,
        number: usize,
        now_ns: u64,
    ) -> bool {
        if let Some(until_ns) = self.until_ns {
            let over = now_ns >= until_ns;
            if over {
                self.until_ns = None;
                robot.let_go();
            }
            return over;
        }
        let waits = |fault| {
            let own = faults.state(fault);
            own.active != 0 && now_ns.saturating_sub(own.since_ns) >= AFTER_NS
        };
        let waited = waits(Fault::NoFreeTube);
        // It has strayed, and its machine has stopped it.
        let strayed = waits(Fault::OffLane);
        let mut active = faults.active();
        let latched = active.any(|fault| fault.resumes() == Resumes::Operator);
        if latched || !(waited || strayed) {
            return false;
        }
        if strayed || self.times == TIMES {
            self.carry_back(robot, world, number);
            return false;
        }
        let truth = world.truth(number);
        let Some(truth) = truth.filter(|truth| truth.twist.v_m_s.abs() < STANDING_M_S) else {
            return false;
        };
        let from = Pose2::new(truth.pose.x_m, truth.pose.y_m, truth.pose.theta_rad);
        let Some(motion) = best(world, number, from) else {
            return false;
        };
        self.times += 1;
        self.until_ns = Some(now_ns + LASTS_NS);
        robot.desk().ask(Teleop::default());
        robot.ask(Request::Teleop(Teleop::default()));
        robot.desk().want(motion.v_m_s, motion.omega_rad_s);
        false
    }

    /// To where it was taken from, once nothing is there.
    fn carry_back(&mut self, robot: &mut SteppedRobot, world: &mut World, number: usize) {
        let stands = |own: &Truth| own.twist.v_m_s.abs() < STANDING_M_S;
        if !world.truth(number).as_ref().is_some_and(stands) {
            return;
        }
        let from = self.taken_from.take();
        let Some((pose, state)) = from else { return };
        let is_free = world.clearance_at_m(number, pose, LOOK_M) >= APART_M;
        if !is_free || world.carry(number, pose).is_err() {
            self.taken_from = Some((pose, state));
            return;
        }
        let words = brought_back(world, number, Some(&state));
        words.into_iter().for_each(|word| robot.ask(word));
    }
}

/// The motion after which it has most room ahead, of those on which it comes close to nothing.
fn best(world: &World, number: usize, from: Pose2) -> Option<Twist2> {
    let lasts_s = LASTS_NS as f64 * 1e-9;
    let room_m = |pose: Pose2| {
        let pose = Pose::new(pose.x_m, pose.y_m, pose.theta_rad);
        world.clearance_at_m(number, pose, LOOK_M)
    };
    let motions = SPEEDS_M_S
        .into_iter()
        .flat_map(|v_m_s| TURNS_RAD_S.map(|omega_rad_s| Twist2::new(v_m_s, omega_rad_s)));
    let room_ahead_m = |motion: Twist2| {
        let way = |share: f64| from.advance(motion, share * lasts_s);
        let ahead = way(1.0).advance(Twist2::new(AHEAD_M, 0.0), 1.0);
        let apart = [0.25, 0.5, 0.75, 1.0]
            .into_iter()
            .all(|share| room_m(way(share)) >= APART_M);
        apart.then(|| (room_m(ahead), motion))
    };
    { motions.filter_map(room_ahead_m) }
        .max_by(|(a, _), (b, _)| a.total_cmp(b))
        .map(|(_, motion)| motion)
}
