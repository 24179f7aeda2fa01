//! What must not happen in a run, by name.
//!
//! [`judge`](crate::judge) says for each kind what it is judged from.

use std::fmt;

use serde::{Deserialize, Serialize};

macro_rules! kinds {
    ($($kind:ident = $name:literal, $sentence:literal;)*) => {
        /// A kind of violation.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum ViolationKind {
            $(#[doc = $sentence] $kind,)*
        }

        impl ViolationKind {
            /// Every kind.
            pub const ALL: &[Self] = &[$(Self::$kind),*];

            /// Stable kebab-case name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$kind => $name),* }
            }
        }
    };
}

kinds! {
    Collision = "collision", "The robot drove into something that stood.";
    CollisionMet = "collision-met", "Robot and something in its view ran into each other.";
    CollisionMetUnseen = "collision-met-unseen", "Robot and something outside its view ran into each other.";
    CollisionRunInto = "collision-run-into", "Something ran into a robot that stood.";
    Clearance = "clearance", "The robot came too near to something.";
    EntryWithoutGrant = "entry-without-grant", "The robot was in an area without a grant.";
    Lease = "lease", "The robot entered an area long after it had heard the mediator last.";
    OverCapacity = "over-capacity", "More robots were in an area than it holds.";
    TwoOwners = "two-owners", "More robots had an area at once than it holds.";
    FenceNotGrown = "fence-not-grown", "A grant of an area had no larger fence than an earlier one.";
    TwoNets = "two-nets", "A coordination went on after another one had taken over the robot.";
    UncommandedEntry = "uncommanded-entry", "The robot entered an area that the net in control of it had not named.";
    Border = "border", "The robot was in an area that the rig withheld leave for.";
    During = "during", "A rule that holds during something was broken.";
    UnsafeSpeed = "unsafe-speed", "The robot did not brake as it must after a fault.";
    LateralError = "lateral-error", "The robot was too far off its lane.";
    Speed = "speed", "The robot was too fast for its area.";
    Docking = "docking", "The robot stopped too far from where it docks.";
    StopPose = "stop-pose", "The robot stopped too far from a pose.";
    StopBorder = "stop-border", "The robot stopped too far from an area, or too near to it.";
    Pose = "pose", "The robot believed to be somewhere else.";
    Heading = "heading", "The robot believed to look elsewhere.";
    Setpoint = "setpoint", "The drive received a wheel setpoint beyond its limit.";
    Current = "current", "The drive received a current limit beyond its own.";
    Instruction = "instruction", "The robot refused an instruction of its operator.";
    RobotEnd = "robot-end", "A robot's process ended by itself, or badly.";
    MediatorEnd = "mediator-end", "The mediator's process ended by itself, or badly.";
    BrokenOff = "broken-off", "A run on the simulated clock panicked, or could not go on.";
    Malformed = "malformed", "A message on the network could not be decoded.";
    StuckAfterFaults = "stuck-after-faults", "The robot did not reach its goals after faults that a fleet must come through.";
}

impl ViolationKind {
    /// Whether a stall of the machine can be to blame for it: what robots promise of their accuracy, and what braking late costs.
    /// For all else nothing is an excuse.
    #[must_use]
    pub const fn may_come_of_a_stall(self) -> bool {
        matches!(
            self,
            Self::Clearance
                | Self::UnsafeSpeed
                | Self::LateralError
                | Self::Speed
                | Self::Docking
                | Self::StopPose
                | Self::StopBorder
                | Self::Pose
                | Self::Heading
        )
    }
}

impl fmt::Display for ViolationKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_has_one_name_everywhere() {
        for kind in ViolationKind::ALL {
            let json = serde_json::to_value(kind).expect("JSON");
            assert_eq!(json, kind.name());
            assert_eq!(kind.to_string(), kind.name());
        }
    }
}
