//! Traces of a run on the simulated clock, besides record and report.

use std::fmt::Write;

use onboard::symbols::faults::{Fault, FaultTable};
use sim::world::{Shape, Truth};

use super::clock::START_NS;
use crate::belief::Belief;

/// Traces of one robot.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// One line for each look: time, truth, belief, command, as comma-separated values.
    pub table: String,
    /// One line for each look and each disc or box: time, number, place.
    pub others: String,
    /// What the robot reported.
    pub notes: Vec<String>,
    /// Of the robot's machine.
    state: String,
}

impl Trace {
    /// What is new since the last look.
    pub(super) fn note(
        &mut self,
        now_ns: u64,
        belief: &Belief,
        before: &FaultTable,
        after: &FaultTable,
    ) {
        let at_s = (now_ns - START_NS) as f64 / 1e9;
        let mut note = |what: String| self.notes.push(format!("{at_s:8.2} s  {what}"));
        if belief.state != self.state {
            note(format!("state {} -> {}", self.state, belief.state));
        }
        for fault in Fault::ALL {
            let (before, after) = (before.state(fault), after.state(fault));
            if after.count > before.count {
                note(format!("{} is raised", fault.name()));
            }
            if after.active == 0 && (before.active != 0 || after.count > before.count) {
                note(format!("{} is gone", fault.name()));
            }
        }
        self.state.clone_from(&belief.state);
    }

    pub(super) fn add_others(&mut self, now_ns: u64, shapes: impl Iterator<Item = Shape>) {
        if self.others.is_empty() {
            self.others.push_str("t_s,number,x_m,y_m\n");
        }
        let at_s = (now_ns - START_NS) as f64 / 1e9;
        for (number, shape) in shapes.enumerate() {
            let [x_m, y_m] = match shape {
                Shape::Wall(_) => continue,
                Shape::Disc { centre_m, .. } => centre_m,
                Shape::Box { pose, .. } => [pose.x_m, pose.y_m],
            };
            // Writing to a string cannot fail.
            let _ = writeln!(self.others, "{at_s:.2},{number},{x_m:.3},{y_m:.3}");
        }
    }

    pub(super) fn add(&mut self, truth: &Truth, belief: &Belief) {
        if self.table.is_empty() {
            self.table.push_str(
                "t_s,x_m,y_m,theta_rad,v_m_s,omega_rad_s,clearance_m,\
                 believed_x_m,believed_y_m,believed_theta_rad,std_x_m,std_y_m,std_theta_rad,\
                 state,skill,verdict,reason\n",
            );
        }
        let (p, b) = (&truth.pose, &belief.pose);
        // Writing to a string cannot fail.
        let _ = writeln!(
            self.table,
            "{:.3},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{},{},{},{}",
            (truth.time_ns - START_NS) as f64 / 1e9,
            p.x_m,
            p.y_m,
            p.theta_rad,
            truth.twist.v_m_s,
            truth.twist.omega_rad_s,
            truth.clearance_m,
            b.x_m,
            b.y_m,
            b.theta_rad,
            belief.std[0],
            belief.std[1],
            belief.std[2],
            belief.state,
            belief.skill,
            belief.verdict,
            belief.reason
        );
    }
}
