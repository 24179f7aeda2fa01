//! Borders of areas that the rig withholds leave for.

use sim::world::STANDING_M_S;

use super::look::{Look, Robot};
use super::overlap::Overlap;
use super::violations::Violations;
use crate::figures::Figures;
use crate::violation::ViolationKind;

/// A robot may reach this far into an area without leave: touching the border is no violation.
const BORDER_M: f64 = 0.001;
/// A robot that stands at most this far from an area waits before it.
const BEFORE_M: f64 = 0.5;

pub(super) fn judge(
    robot: &Robot,
    look: &Look<'_>,
    figures: &mut Figures,
    violations: &mut Violations,
) {
    if look.leave.iter().all(|given| *given) {
        return;
    }
    let floor = robot.footprint.at(&look.truth.pose);
    let stands = look.truth.twist.v_m_s.abs() < STANDING_M_S;
    let withheld = { robot.site.areas.iter() }
        .zip(look.leave)
        .filter(|(_, given)| !**given);
    for (area, _) in withheld {
        let Overlap {
            depth_m,
            distance_m,
        } = Overlap::of(&floor, &area.region);
        if stands && distance_m < BEFORE_M {
            figures.min_border_m = figures.min_border_m.min(distance_m);
        }
        if depth_m > BORDER_M {
            let detail = format!("{depth_m:.3} m inside area {} without leave", area.id);
            violations.report(
                ViolationKind::Border,
                &robot.name,
                look.truth.time_ns,
                detail,
            );
        }
    }
}
