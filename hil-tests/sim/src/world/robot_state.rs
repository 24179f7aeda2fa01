//! One robot in the world: its motion, the command its drive holds, and what it did so far.

use super::collision::{Cause, Collision, MOST_COLLISIONS};
use super::geometry::{Point, Pose, Rectangle, norm, sub};
use super::random::Random;
use super::robot::{Motion, RobotModel};
use super::truth::Truth;
use crate::plant::DriveCommand;

/// Steps whose poses are kept: a quarter of a second.
pub(super) const HISTORY_STEPS: usize = 256;
/// Contacts less than this apart are one collision.
const SAME_COLLISION_NS: u64 = 500_000_000;

/// A robot, its motion, and what it did so far.
#[derive(Debug, Clone)]
pub(super) struct RobotState {
    pub model: RobotModel,
    /// Of the footprint.
    pub reach_m: f64,
    pub motion: Motion,
    pub command: DriveCommand,
    pub commanded_ns: u64,
    pub min_clearance_m: f64,
    pub in_contact: bool,
    pub first_collisions: Vec<Collision>,
    /// Poses of the last steps; that of step n is at n modulo the length.
    history: Vec<Pose>,
    distance_m: f64,
    collisions: u64,
    run_into: u64,
    last_contact_ns: Option<u64>,
}

impl RobotState {
    pub(super) fn new(model: RobotModel, random: &mut Random) -> RobotState {
        RobotState {
            motion: Motion::new(&model, random),
            command: DriveCommand::OFF,
            commanded_ns: 0,
            history: vec![model.start; HISTORY_STEPS],
            min_clearance_m: f64::INFINITY,
            distance_m: 0.0,
            collisions: 0,
            run_into: 0,
            first_collisions: Vec::new(),
            last_contact_ns: None,
            in_contact: false,
            reach_m: model.footprint.reach_m(),
            model,
        }
    }

    /// It stands somewhere else, without power, and has been there.
    pub(super) fn set_down(&mut self, pose: Pose) {
        self.motion.set_down(pose);
        self.command = DriveCommand::OFF;
        self.history.fill(pose);
        self.in_contact = false;
    }

    /// The floor that the robot covers.
    pub(super) fn floor(&self) -> Rectangle {
        self.model.footprint.at(&self.motion.pose)
    }

    /// Where its `base_link` is.
    pub(super) fn middle_m(&self) -> Point {
        [self.motion.pose.x_m, self.motion.pose.y_m]
    }

    /// Fastest speed of the outline in a motion of this robot.
    pub(super) fn outline_m_s(&self, motion: &Motion) -> f64 {
        motion.twist.v_m_s.abs() + motion.twist.omega_rad_s.abs() * self.reach_m
    }

    /// The pose `ago` steps before step `step`; of those too old, the oldest kept.
    pub(super) fn past(&self, step: u64, ago: u64) -> Pose {
        let oldest = HISTORY_STEPS as u64 - 1;
        let index = step.wrapping_sub(ago.min(oldest)) % HISTORY_STEPS as u64;
        self.history[index as usize]
    }

    /// Keeps the pose as that of step `step`.
    pub(super) fn remember(&mut self, step: u64) {
        self.history[(step % HISTORY_STEPS as u64) as usize] = self.motion.pose;
    }

    /// Adds the way from `before` to now.
    pub(super) fn add_way(&mut self, before: &Pose) {
        let to = self.motion.pose;
        self.distance_m += norm(sub([to.x_m, to.y_m], [before.x_m, before.y_m]));
    }

    /// Takes note of a contact at `at_ns`; true when it begins a collision.
    pub(super) fn touches(&mut self, at_ns: u64) -> bool {
        let last_ns = self.last_contact_ns.replace(at_ns);
        last_ns.is_none_or(|last_ns| at_ns - last_ns > SAME_COLLISION_NS)
    }

    /// Counts a collision, and keeps it if it is among the first.
    pub(super) fn add_collision(&mut self, collision: Collision) {
        self.collisions += 1;
        self.run_into += u64::from(collision.cause == Cause::RunInto);
        if self.first_collisions.len() < MOST_COLLISIONS {
            self.first_collisions.push(collision);
        }
    }

    pub(super) fn truth(&self, time_ns: u64, clearance_m: f64) -> Truth {
        Truth {
            time_ns,
            pose: self.motion.pose,
            twist: self.motion.twist,
            pivot_rad: self.motion.pivot_rad,
            clearance_m,
            min_clearance_m: self.min_clearance_m,
            distance_m: self.distance_m,
            collisions: self.collisions,
            run_into: self.run_into,
            in_contact: self.in_contact,
        }
    }
}
