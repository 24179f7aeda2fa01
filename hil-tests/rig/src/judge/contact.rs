//! Collisions and clearance.

use sim::world::Cause;

use super::look::{Look, Robot, place};
use super::violations::Violations;
use crate::figures::Figures;
use crate::scenario::{Limits, Player, Scenario, ScriptedFault, ScriptedKind};
use crate::violation::ViolationKind;

/// The lidar sees up to this angle to either side.
const IN_VIEW_RAD: f64 = 2.09;

/// Watches what one robot touches.
#[derive(Debug)]
pub(super) struct Contact {
    /// Collisions so far.
    collisions: usize,
    start_ns: u64,
    hands: Hands,
}

/// Somebody drives a robot by hand, with the margin of `tubes.by_hand_augment_m`: nearer to things, and nearer to other robots.
#[derive(Debug, Default)]
struct Hands {
    /// From when until when anybody does, in seconds of the run.
    windows_s: Vec<(f64, f64)>,
    /// By so much the margin is smaller than where a robot drives by itself.
    nearer_m: f64,
    /// It came nearer then, and has not been away since.
    still_near: bool,
}

impl Hands {
    fn of(scenario: &Scenario) -> Self {
        let by_hand = |fault: &&ScriptedFault| fault.what == ScriptedKind::Teleop;
        let nearer_m = |player: &Player| {
            let tubes = &player.config.tubes;
            (tubes.augment_m - tubes.by_hand_augment_m).max(0.0)
        };
        Self {
            windows_s: { scenario.faults.iter() }
                .filter(by_hand)
                .map(|fault| (fault.at_s, fault.until_s()))
                .collect(),
            nearer_m: { scenario.robots.iter() }.map(nearer_m).fold(0.0, f64::max),
            still_near: false,
        }
    }

    /// The least clearance now, where robots that drive by themselves keep `alone_m`.
    fn least_m(&mut self, at_s: f64, clearance_m: f64, alone_m: f64) -> f64 {
        let driven =
            { self.windows_s.iter() }.any(|&(from_s, until_s)| from_s <= at_s && at_s <= until_s);
        self.still_near = clearance_m < alone_m && (driven || self.still_near);
        if self.still_near {
            (alone_m - self.nearer_m).max(0.0)
        } else {
            alone_m
        }
    }
}

impl Contact {
    pub(super) fn new(scenario: &Scenario, start_ns: u64) -> Self {
        Self {
            collisions: 0,
            start_ns,
            hands: Hands::of(scenario),
        }
    }

    pub(super) fn judge(
        &mut self,
        robot: &Robot,
        limits: &Limits,
        look: &Look<'_>,
        figures: &mut Figures,
        violations: &mut Violations,
    ) {
        let (truth, before) = (look.truth, self.collisions);
        let at = place(&truth.pose);
        let known = look.world.collisions(look.robot);
        for collision in known.iter().skip(before) {
            let seen = collision.bearing_rad.abs() <= IN_VIEW_RAD;
            let (count, kind) = match collision.cause {
                Cause::DroveInto => (&mut figures.drove_into, ViolationKind::Collision),
                Cause::Met if seen => (&mut figures.met, ViolationKind::CollisionMet),
                Cause::Met => (&mut figures.met, ViolationKind::CollisionMetUnseen),
                Cause::RunInto => (&mut figures.run_into, ViolationKind::CollisionRunInto),
            };
            *count += 1;
            if collision.cause != Cause::RunInto || !limits.may_be_run_into {
                let detail = format!(
                    "{at}; the robot moved at {:.2} m/s, the other at {:.2} m/s, {:.0}° to the left",
                    collision.robot_m_s,
                    collision.object_m_s,
                    collision.bearing_rad.to_degrees()
                );
                violations.report(kind, &robot.name, collision.time_ns, detail);
            }
        }
        self.collisions = before.max(known.len());
        // The world keeps the causes of so many collisions and no more, but counts all of them.
        let counted = usize::try_from(truth.collisions).unwrap_or(usize::MAX);
        if counted > self.collisions {
            self.collisions = counted;
            violations.report(
                ViolationKind::Collision,
                &robot.name,
                truth.time_ns,
                at.clone(),
            );
        }
        let at_s = truth.time_ns.saturating_sub(self.start_ns) as f64 / 1e9;
        let least_m = self
            .hands
            .least_m(at_s, truth.clearance_m, limits.clearance_m);
        if self.collisions == before && truth.clearance_m < least_m {
            let detail = format!(
                "{:.3} m {at}, expected at least {least_m} m",
                truth.clearance_m
            );
            violations.report(ViolationKind::Clearance, &robot.name, truth.time_ns, detail);
        }
    }
}
