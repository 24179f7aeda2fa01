//! The view of a run in the terminal: robots, areas, who waits for whom, and what nets have marked.

use std::fmt::Write as _;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

use super::execution::Execution;
use super::watch::Run;
use crate::network::mediator_status::Told;
use crate::network::observations::Observations;

/// Lines are cut here, so that none is wrapped and the view stays in place.
const DEFAULT_COLUMNS: usize = 120;

/// Shows the progress of a run: in a terminal as a view that stays in place, elsewhere as a few lines now and then.
#[derive(Debug)]
pub struct Live {
    silent: bool,
    terminal: bool,
    shown: Option<Instant>,
    lines: usize,
}

impl Live {
    /// A view; shows nothing when `silent`.
    #[must_use]
    pub fn new(silent: bool) -> Self {
        Self {
            silent,
            terminal: std::io::stdout().is_terminal(),
            shown: None,
            lines: 0,
        }
    }

    /// Shows the present state, if it is time to.
    pub fn show<E: Execution>(&mut self, run: &Run<E>) {
        let period = if self.terminal {
            Duration::from_millis(250)
        } else {
            Duration::from_secs(5)
        };
        if self.silent || self.shown.is_some_and(|shown| shown.elapsed() < period) {
            return;
        }
        self.shown = Some(Instant::now());
        let view = view(run);
        let mut out = std::io::stdout().lock();
        let mut text = String::new();
        if self.terminal {
            let columns = rustix::termios::tcgetwinsize(&out)
                .map_or(DEFAULT_COLUMNS, |size| usize::from(size.ws_col).max(20));
            if self.lines > 0 {
                let _ = write!(text, "\x1b[{}A", self.lines);
            }
            for line in view.lines() {
                let cut: String = line.chars().take(columns - 1).collect();
                let _ = writeln!(text, "\x1b[K{cut}");
            }
            text.push_str("\x1b[J");
            self.lines = view.lines().count();
        } else {
            text.clone_from(&view);
        }
        // A closed terminal is no reason to stop robots.
        let _ = out.write_all(text.as_bytes());
        let _ = out.flush();
    }

    /// Leaves the view where it is: what is printed from now on comes below.
    pub fn end(&mut self) {
        self.lines = 0;
    }
}

/// The present state, in lines.
fn view<E: Execution>(run: &Run<E>) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{:.0} s of {:.0} s, {} violations",
        run.stage.seconds(run.stage.now_ns()),
        run.scenario.longest_s(),
        run.judge.violations().len()
    );
    run.stage.heard(|observations| {
        for robot in 0..run.tracks.len() {
            add_robot(&mut text, run, robot, observations);
        }
        add_areas(&mut text, run, observations);
    });
    if run.stage.mediator().is_some() {
        let now_ns = run.stage.now_ns();
        run.stage.told(|told| add_nets(&mut text, told, now_ns));
    }
    text
}

fn add_robot<E: Execution>(
    text: &mut String,
    run: &Run<E>,
    robot: usize,
    observations: &Observations,
) {
    let (player, track) = (&run.scenario.robots[robot], &run.tracks[robot]);
    let said = observations.said(&player.id).map(|said| &said.state);
    let faults: Vec<&str> = { said.iter() }
        .flat_map(|state| &state.faults)
        .filter(|fault| fault.active)
        .map(|fault| fault.name.as_str())
        .collect();
    let truth = track.truth.unwrap_or_default();
    let or_dash = |text: Option<&str>| match text {
        None | Some("") => "-".to_owned(),
        Some(text) => text.to_owned(),
    };
    let inside = run.judge.inside(robot).join("+");
    let _ = writeln!(
        text,
        "  {:<8} {:<16} {:<12} in {:<14} {:5.2} m/s  clearance {:5.2} m  x {:6.2} y {:6.2}  round {}/{}  {}",
        player.id,
        or_dash(said.map(|state| state.fsm_state.as_str())),
        or_dash(said.map(|state| state.skill.as_str())),
        or_dash(Some(&inside)),
        truth.twist.v_m_s,
        truth.clearance_m,
        truth.pose.x_m,
        truth.pose.y_m,
        track.progress.rounds(),
        track.progress.wanted(),
        faults.join(" ")
    );
}

/// Who has which area, and who waits for one.
fn add_areas<E: Execution>(text: &mut String, run: &Run<E>, observations: &Observations) {
    if !run.scenario.site.areas_managed {
        return;
    }
    text.push_str("  areas");
    for area in &run.scenario.site.areas {
        let owners: Vec<String> = { observations.ownings().iter() }
            .filter(|own| own.area == area.id && own.released_ns.is_none())
            .map(|own| format!("{}#{}", own.robot, own.fence))
            .collect();
        if !owners.is_empty() {
            let _ = write!(text, "  {}: {}", area.id, owners.join(" "));
        }
    }
    text.push('\n');
    let now_ns = run.stage.now_ns();
    for waiting in { observations.waitings().iter() }.filter(|own| own.to_ns.is_none()) {
        let since_s = now_ns.saturating_sub(waiting.from_ns) as f64 / 1e9;
        if since_s > 0.5 {
            let _ = writeln!(
                text,
                "  {} waits for {} {}",
                waiting.robot, waiting.area, waiting.why
            );
        }
    }
}

/// What nets have marked.
fn add_nets(text: &mut String, told: Option<&Told>, now_ns: u64) {
    let Some(status) = told.and_then(|told| told.status(now_ns)) else {
        text.push_str("  the mediator does not answer\n");
        return;
    };
    for own in status.coordinations.iter().filter(|own| !own.over) {
        let _ = writeln!(
            text,
            "  net {} {} after {} firings: {}",
            own.net,
            own.number,
            own.fired,
            own.marking.join(", ")
        );
    }
}
