//! Collisions and clearance.

use sim::world::Cause;

use super::look::{Look, Robot, place};
use super::violations::Violations;
use crate::figures::Figures;
use crate::scenario::Limits;
use crate::violation::ViolationKind;

/// The lidar sees up to this angle to either side.
const IN_VIEW_RAD: f64 = 2.09;

/// Watches what one robot touches.
#[derive(Debug, Default)]
pub(super) struct Contact {
    /// Collisions so far.
    collisions: usize,
}

impl Contact {
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
        if self.collisions == before && truth.clearance_m < limits.clearance_m {
            let detail = format!(
                "{:.3} m {at}, expected at least {} m",
                truth.clearance_m, limits.clearance_m
            );
            violations.report(ViolationKind::Clearance, &robot.name, truth.time_ns, detail);
        }
    }
}
