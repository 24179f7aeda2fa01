//! Traces of a run on the simulated clock, besides record and report.

use std::fmt::Write;

use onboard::symbols::faults::{Fault, FaultTable};
use sim::world::{Shape, Truth};

use super::clock::START_NS;
use crate::belief::Belief;

/// Lines of an hour: more, and the oldest are forgotten.
const MOST_LINES: usize = 180_000;

/// Lines under a head, of which only the last are kept: at least half of [`MOST_LINES`].
#[derive(Clone, Debug, Default)]
pub struct Lines {
    head: &'static str,
    older: String,
    newer: String,
    /// Lines of `newer`.
    count: usize,
}

impl Lines {
    fn of(head: &'static str) -> Self {
        Self {
            head,
            ..Self::default()
        }
    }

    /// Begins the next line.
    fn next(&mut self) -> &mut String {
        if self.count >= MOST_LINES / 2 {
            self.older = std::mem::take(&mut self.newer);
            self.count = 0;
        }
        self.count += 1;
        &mut self.newer
    }

    /// Head and lines.
    #[must_use]
    pub fn text(&self) -> String {
        [self.head, &self.older, &self.newer].concat()
    }
}

/// Traces of all robots and of what stands in their way; of a run that takes longer than an hour, its last part.
#[derive(Clone, Debug)]
pub struct Traces {
    /// Those of each robot.
    pub robots: Vec<Trace>,
    /// One line for each look and each disc or box: time, number, place.
    pub others: Lines,
}

impl Traces {
    pub(super) fn of(robots: usize) -> Self {
        Self {
            robots: vec![Trace::default(); robots],
            others: Lines::of("t_s,number,x_m,y_m\n"),
        }
    }

    pub(super) fn add_others(&mut self, now_ns: u64, shapes: impl Iterator<Item = Shape>) {
        let at_s = (now_ns - START_NS) as f64 / 1e9;
        for (number, shape) in shapes.enumerate() {
            let [x_m, y_m] = match shape {
                Shape::Wall(_) => continue,
                Shape::Disc { centre_m, .. } => centre_m,
                Shape::Box { pose, .. } => [pose.x_m, pose.y_m],
            };
            // Writing to a string cannot fail.
            let _ = writeln!(self.others.next(), "{at_s:.2},{number},{x_m:.3},{y_m:.3}");
        }
    }
}

/// Traces of one robot.
#[derive(Clone, Debug)]
pub struct Trace {
    /// One line for each look: time, truth, belief, command, as comma-separated values.
    pub table: Lines,
    /// What the robot reported.
    pub notes: Vec<String>,
    /// Of the robot's machine.
    state: String,
    hold: String,
}

impl Default for Trace {
    fn default() -> Self {
        Self {
            table: Lines::of(
                "t_s,x_m,y_m,theta_rad,v_m_s,omega_rad_s,clearance_m,\
                 believed_x_m,believed_y_m,believed_theta_rad,std_x_m,std_y_m,std_theta_rad,\
                 state,skill,verdict,reason\n",
            ),
            notes: Vec::new(),
            state: String::new(),
            hold: String::new(),
        }
    }
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
        if belief.hold != self.hold {
            match &*belief.hold {
                "" => note("goes on".to_owned()),
                hold => note(format!("stops: {hold}")),
            }
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
        self.hold.clone_from(&belief.hold);
    }

    pub(super) fn add(&mut self, truth: &Truth, belief: &Belief) {
        let (p, b) = (&truth.pose, &belief.pose);
        // Writing to a string cannot fail.
        let _ = writeln!(
            self.table.next(),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_lines_the_last_are_kept_under_their_head() {
        let mut lines = Lines::of("number\n");
        for number in 0..2 * MOST_LINES + 5 {
            let _ = writeln!(lines.next(), "{number}");
        }
        let text = lines.text();
        let mut kept = text.lines();
        assert_eq!(kept.next(), Some("number"));
        let kept: Vec<usize> = kept.map(|line| line.parse().expect("a number")).collect();
        assert!(kept.len() >= MOST_LINES / 2 && kept.len() <= MOST_LINES);
        assert_eq!(kept.last(), Some(&(2 * MOST_LINES + 4)));
        assert!(kept.windows(2).all(|pair| pair[1] == pair[0] + 1));
    }
}
