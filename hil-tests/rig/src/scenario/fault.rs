//! What goes wrong in a run on the simulated clock: what, when, for how long and for whom.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Something that goes wrong. Times are seconds since the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScriptedFault {
    /// When it begins.
    pub at_s: f64,
    /// How long it lasts.
    pub for_s: f64,
    /// What it is.
    pub what: ScriptedKind,
    /// For this robot; left out where it concerns all, or the mediator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// How often, or how much, from 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// By how much, seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_s: Option<f64>,
    /// Of the robot's threads only this one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thread: Option<String>,
    /// Where in `map`: x and y in metres, heading in degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<[f64; 3]>,
}

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ScriptedKind {
    /// Messages from and to a robot, or all, get lost with a probability.
    Lose,
    /// They arrive twice with a probability.
    Repeat,
    /// They take longer, by up to `by_s`, so that later ones overtake them.
    Delay,
    /// No message from or to the robot arrives.
    Partition,
    /// The robot's process is killed, and started again at the end.
    KillRobot,
    /// A second robot with the same identity, plan and configuration is switched on at a pose, or where it is in nobody's way;
    /// at the end it is switched off and carried away.
    CloneRobot,
    /// The mediator is killed, and started again with its journal at the end.
    KillMediator,
    /// The mediator's journal is copied; at the end the mediator is killed, and started again with that copy.
    RestoreJournal,
    /// The mediator is killed, and started again at the end without its journal.
    LoseJournal,
    /// Another mediator of the same site runs, with a journal of its own.
    SecondMediator,
    /// The disk below the mediator's journal takes `by_s` for each write.
    SlowDisk,
    /// All threads of the robot stand still.
    Hang,
    /// Each wake-up of the robot's threads is late with a probability, by up to `by_s`.
    LateThreads,
    /// The robot's clock runs faster than the others', by this share.
    Drift,
    /// Frames on the robot's bus get lost with a probability.
    LoseFrames,
    /// The robot's drive falls out of OP, once.
    LeaveOp,
    /// The robot's drive loses its power, and has it again at the end.
    CutPower,
    /// An emergency stop cuts the power of the robot's motors, and is released at the end.
    CutMotors,
    /// The robot's wheels turn further than it moves: the left one by this share, the right one by half of it.
    Slip,
    /// Scans of the robot's lidar arrive broken with a probability.
    BreakScans,
    /// What the robot's lidar sends arrives late, by `by_s`.
    DelayScans,
    /// What the robot's lidar sends arrives later and later, by this share of the time that passes.
    AgeScans,
    /// Somebody covers the window of the robot's lidar, so that no beam has an echo, and uncovers it at the end.
    CoverLidar,
    /// The robot's lidar is unplugged, and plugged in again at the end.
    Unplug,
    /// Somebody steps into the robot's way, and leaves it at the end.
    Person,
    /// A box is put into the robot's way, and taken away at the end.
    Box,
    /// An operator pauses the robot, and lets it go on at the end.
    Pause,
    /// An operator stops the robot, and resets it at the end.
    Stop,
}

/// Which keys a kind has beside when and how long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keys {
    /// `robot`: needed, or possible.
    pub robot: Option<bool>,
    /// `share`.
    pub share: bool,
    /// `by_s`.
    pub by_s: bool,
    /// `pose`, possible.
    pub pose: bool,
}

impl ScriptedKind {
    /// Those that are drawn at random: what a fleet is expected to come through.
    pub const DRAWN: [Self; 24] = [
        Self::Lose,
        Self::Repeat,
        Self::Delay,
        Self::Partition,
        Self::KillRobot,
        Self::KillMediator,
        Self::SlowDisk,
        Self::Hang,
        Self::LateThreads,
        Self::Drift,
        Self::LoseFrames,
        Self::LeaveOp,
        Self::CutPower,
        Self::CutMotors,
        Self::Slip,
        Self::BreakScans,
        Self::DelayScans,
        Self::AgeScans,
        Self::CoverLidar,
        Self::Unplug,
        Self::Person,
        Self::Box,
        Self::Pause,
        Self::Stop,
    ];

    /// Which keys it has.
    #[must_use]
    pub fn keys(self) -> Keys {
        let keys = |robot, share, by_s| Keys {
            robot,
            share,
            by_s,
            pose: self == Self::CloneRobot,
        };
        match self {
            Self::Lose | Self::Repeat => keys(Some(false), true, false),
            Self::Delay => keys(Some(false), false, true),
            Self::Partition
            | Self::KillRobot
            | Self::CloneRobot
            | Self::Hang
            | Self::LeaveOp
            | Self::CutPower
            | Self::CutMotors
            | Self::CoverLidar
            | Self::Unplug
            | Self::Person
            | Self::Box
            | Self::Pause
            | Self::Stop => keys(Some(true), false, false),
            Self::LoseFrames | Self::BreakScans | Self::AgeScans | Self::Slip | Self::Drift => {
                keys(Some(true), true, false)
            }
            Self::LateThreads => keys(Some(true), true, true),
            Self::DelayScans => keys(Some(true), false, true),
            Self::KillMediator
            | Self::RestoreJournal
            | Self::LoseJournal
            | Self::SecondMediator => keys(None, false, false),
            Self::SlowDisk => keys(None, false, true),
        }
    }

    /// Whether it concerns a mediator or what is said with it.
    #[must_use]
    pub fn needs_mediator(self) -> bool {
        matches!(
            self,
            Self::Lose
                | Self::Repeat
                | Self::Delay
                | Self::Partition
                | Self::KillMediator
                | Self::RestoreJournal
                | Self::LoseJournal
                | Self::SecondMediator
                | Self::SlowDisk
        )
    }

    /// The largest share that is drawn at random.
    #[must_use]
    pub fn most_share(self) -> f64 {
        match self {
            // Clocks of computers are off by less.
            Self::Drift => 0.0005,
            Self::Slip => 0.3,
            // By the end of the longest one scans are as late as they may be.
            Self::AgeScans => 0.02,
            _ => 1.0,
        }
    }

    /// The longest `by_s` that is drawn at random.
    #[must_use]
    pub fn most_by_s(self) -> f64 {
        match self {
            Self::LateThreads | Self::DelayScans => 0.1,
            _ => 1.0,
        }
    }
}

impl ScriptedFault {
    /// When it is over.
    #[must_use]
    pub fn until_s(&self) -> f64 {
        self.at_s + self.for_s
    }

    /// What is wrong with it, for a scenario with these robots.
    #[must_use]
    pub fn complaints(&self, robots: &[&str]) -> Vec<String> {
        const LONGEST_S: f64 = 3600.0;
        let mut complaints = Vec::new();
        let keys = self.what.keys();
        for (key, value, most) in [
            ("at_s", Some(self.at_s), LONGEST_S),
            ("for_s", Some(self.for_s), LONGEST_S),
            ("share", self.share, 1.0),
            ("by_s", self.by_s, 60.0),
        ] {
            if let Some(value) = value.filter(|value| !(0.0..=most).contains(value)) {
                complaints.push(format!("found {key} = {value}, expected 0 to {most}"));
            }
        }
        let mut key = |name: &str, is: bool, may: bool, must: bool| {
            if is && !may {
                complaints.push(format!("found `{name}`, expected none for this fault"));
            } else if must && !is {
                complaints.push(format!("found no `{name}`, expected one for this fault"));
            }
        };
        key(
            "robot",
            self.robot.is_some(),
            keys.robot.is_some(),
            keys.robot == Some(true),
        );
        key("share", self.share.is_some(), keys.share, keys.share);
        key("by_s", self.by_s.is_some(), keys.by_s, keys.by_s);
        let may = self.what == ScriptedKind::LateThreads;
        key("thread", self.thread.is_some(), may, false);
        key("pose", self.pose.is_some(), keys.pose, false);
        const FARTHEST: f64 = 1000.0;
        let near = |value: &f64| value.abs() <= FARTHEST;
        if let Some(pose) = self.pose.filter(|pose| !pose.iter().all(near)) {
            complaints.push(format!(
                "found pose = {pose:?}, expected metres, metres and degrees, each from -{FARTHEST} to {FARTHEST}"
            ));
        }
        if let Some(robot) = &self.robot
            && !robots.contains(&robot.as_str())
        {
            let known = robots.join("`, `");
            complaints.push(format!("found robot `{robot}`, expected one of `{known}`"));
        }
        complaints
    }
}

impl fmt::Display for ScriptedFault {
    /// As it stands in a scenario file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Every kind is a word.
        let what = serde_json::to_string(&self.what).unwrap_or_default();
        write!(
            f,
            "{{ at_s = {:?}, for_s = {:?}, what = {what}",
            self.at_s, self.for_s
        )?;
        if let Some(robot) = &self.robot {
            write!(f, ", robot = {robot:?}")?;
        }
        if let Some(share) = self.share {
            write!(f, ", share = {share:?}")?;
        }
        if let Some(by_s) = self.by_s {
            write!(f, ", by_s = {by_s:?}")?;
        }
        if let Some(thread) = &self.thread {
            write!(f, ", thread = {thread:?}")?;
        }
        if let Some(pose) = self.pose {
            write!(f, ", pose = {pose:?}")?;
        }
        f.write_str(" }")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Deserialize)]
    struct File {
        faults: Vec<ScriptedFault>,
    }

    #[test]
    fn a_fault_reads_as_it_is_written() {
        let lines = [
            "{ at_s = 12.5, for_s = 3.0, what = \"partition\", robot = \"amr-1\" }",
            "{ at_s = 0.25, for_s = 0.5, what = \"lose\", share = 0.3 }",
            "{ at_s = 1.0, for_s = 2.0, what = \"delay\", robot = \"amr-1\", by_s = 0.125 }",
            "{ at_s = 1.0, for_s = 2.0, what = \"late-threads\", robot = \"amr-1\", share = 0.5, by_s = 0.125, thread = \"motion\" }",
            "{ at_s = 1.0, for_s = 2.0, what = \"clone-robot\", robot = \"amr-1\", pose = [2.0, -0.5, 90.0] }",
        ];
        let text = format!("faults = [{}]", lines.join(", "));
        let File { faults } = toml::from_str(&text).expect("good");
        let shown: Vec<String> = faults.iter().map(ToString::to_string).collect();
        assert_eq!(shown, lines);
        for fault in &faults {
            assert_eq!(fault.complaints(&["amr-1"]), Vec::<String>::new());
        }
        assert_eq!(
            faults[0].complaints(&["amr-2"]),
            ["found robot `amr-1`, expected one of `amr-2`"]
        );
    }

    #[test]
    fn keys_that_do_not_belong_are_named() {
        let fault = ScriptedFault {
            at_s: -1.0,
            for_s: 1.0,
            what: ScriptedKind::KillMediator,
            robot: Some("amr-1".into()),
            share: None,
            by_s: Some(f64::NAN),
            thread: Some("motion".into()),
            pose: Some([0.0, f64::NAN, 0.0]),
        };
        assert_eq!(
            fault.complaints(&["amr-1"]),
            [
                "found at_s = -1, expected 0 to 3600",
                "found by_s = NaN, expected 0 to 60",
                "found `robot`, expected none for this fault",
                "found `by_s`, expected none for this fault",
                "found `thread`, expected none for this fault",
                "found `pose`, expected none for this fault",
                "found pose = [0.0, NaN, 0.0], expected metres, metres and degrees, each from -1000 to 1000",
            ]
        );
        let nobody = ScriptedFault {
            at_s: 1.0,
            what: ScriptedKind::Hang,
            robot: None,
            by_s: None,
            thread: None,
            pose: None,
            ..fault
        };
        assert_eq!(
            nobody.complaints(&["amr-1"]),
            ["found no `robot`, expected one for this fault"]
        );
    }
}
