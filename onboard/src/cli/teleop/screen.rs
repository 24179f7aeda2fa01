//! What the terminal shows: speed asked and allowed, what limits it, pose, and what to press.

use super::keyboard::Setting;
use crate::process::teleop::Status;

/// What is shown.
pub(super) struct View<'a> {
    pub(super) robot: &'a str,
    /// The dead-man is held.
    pub(super) held: bool,
    pub(super) tells_releases: bool,
    pub(super) gamepad: bool,
    pub(super) setting: Setting,
    pub(super) status: &'a Status,
    /// What became of the last reset.
    pub(super) note: &'a str,
}

impl View<'_> {
    /// Its lines.
    pub(super) fn lines(&self) -> Vec<String> {
        let Status {
            asked,
            allowed_m_s,
            limit,
            moves,
            pose,
            std_m,
            uncertain,
            state,
            faults,
            ..
        } = self.status;
        let place = if *uncertain { "  UNCERTAIN" } else { "" };
        let limit = match (limit.as_str(), self.held) {
            ("", true) => "nothing",
            ("", false) => "-",
            (limit, _) => limit,
        };
        let held = if self.held { "HELD" } else { "released" };
        let mut lines = vec![
            format!("onboard teleop {}   dead-man {held}", self.robot),
            String::new(),
            format!(
                "asked    {:+.2} m/s  {:+.2} rad/s",
                asked.v_m_s, asked.omega_rad_s
            ),
            format!("allowed  {allowed_m_s:+.2} m/s"),
            format!(
                "moves    {:+.2} m/s  {:+.2} rad/s",
                moves.v_m_s, moves.omega_rad_s
            ),
            format!("limit    {limit}"),
            format!(
                "pose     x {:.2} m  y {:.2} m  {:.0} deg  +- {std_m:.2} m{place}   state {state}",
                pose.x_m,
                pose.y_m,
                pose.theta_rad.to_degrees()
            ),
            format!(
                "faults   {}",
                if faults.is_empty() {
                    "none".to_owned()
                } else {
                    faults.join(", ")
                }
            ),
            String::new(),
        ];
        if self.gamepad {
            lines.push("hold a shoulder button, and drive with the left stick; this robot turns only while it rolls".to_owned());
        } else {
            lines.extend(self.keys());
        }
        lines.push("r  reset faults      x, Esc or Ctrl-C  leave: the robot stays paused until `onboard ctl resume`".to_owned());
        if !self.note.is_empty() {
            lines.extend([String::new(), self.note.to_owned()]);
        }
        lines
    }

    fn keys(&self) -> [String; 3] {
        let Setting {
            speed_m_s,
            curve_1_m,
        } = self.setting;
        let held = if self.tells_releases {
            "the robot drives while a key is held"
        } else {
            "the robot drives while a key repeats: hold it a moment"
        };
        [
            format!("q w e  forward left, straight, right      {held}"),
            "a s d  backward left, straight, right     any other key stops".to_owned(),
            format!(
                "+ -    speed {speed_m_s:.2} m/s                     1 2 3  curve {curve_1_m:.2} 1/m"
            ),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_shows_what_limits_and_what_to_press() {
        let status = Status {
            limit: "tube: something is in the way".to_owned(),
            faults: vec!["no-free-tube".to_owned()],
            uncertain: true,
            ..Status::default()
        };
        let view = View {
            robot: "amr-1",
            held: true,
            tells_releases: false,
            gamepad: false,
            setting: Setting {
                speed_m_s: 0.1,
                curve_1_m: 0.5,
            },
            status: &status,
            note: "reset",
        };
        let text = view.lines().join("\n");
        for part in [
            "amr-1",
            "HELD",
            "something is in the way",
            "no-free-tube",
            "UNCERTAIN",
            "repeats",
            "q w e",
            "onboard ctl resume",
            "reset",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
        let pad = View {
            gamepad: true,
            note: "",
            ..view
        };
        let text = pad.lines().join("\n");
        assert!(text.contains("shoulder") && !text.contains("q w e"));
    }
}
