//! The progress line.

use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use contract::wire::RobotState;
use sim::world::Truth;

/// Shows how a robot gets on, on one line of a terminal or now and then on lines of their own.
#[derive(Debug)]
pub struct Progress {
    silent: bool,
    terminal: bool,
    shown: Option<Instant>,
}

impl Progress {
    /// A progress line; shows nothing when `silent`.
    #[must_use]
    pub fn new(silent: bool) -> Self {
        Self {
            silent,
            terminal: std::io::stdout().is_terminal(),
            shown: None,
        }
    }

    /// Shows the state: what the robot says of itself, and what is true.
    pub fn show(&mut self, what: &str, heard: Option<&RobotState>, truth: &Truth) {
        let period = if self.terminal {
            Duration::from_millis(200)
        } else {
            Duration::from_secs(5)
        };
        if self.silent || self.shown.is_some_and(|shown| shown.elapsed() < period) {
            return;
        }
        self.shown = Some(Instant::now());
        let unknown = RobotState::default();
        let state = heard.unwrap_or(&unknown);
        let faults: Vec<&str> = state
            .faults
            .iter()
            .filter(|fault| fault.active)
            .map(|fault| fault.name.as_str())
            .collect();
        let line = format!(
            "{what}  area {:<3} skill {:<12} speed {:5.2} m/s  clearance {:5.2} m  x {:5.2} y {:5.2}  {}",
            or_dash(&state.area),
            or_dash(&state.skill),
            truth.twist.v_m_s,
            truth.clearance_m,
            truth.pose.x_m,
            truth.pose.y_m,
            faults.join(" ")
        );
        let mut out = std::io::stdout().lock();
        // A closed terminal is no reason to stop a robot.
        let _ = if self.terminal {
            write!(out, "\r\x1b[K{line}")
        } else {
            writeln!(out, "{line}")
        };
        let _ = out.flush();
    }

    /// Ends the line.
    pub fn end(&self) {
        if !self.silent && self.terminal && self.shown.is_some() {
            println!();
        }
    }
}

fn or_dash(text: &str) -> &str {
    if text.is_empty() { "-" } else { text }
}
