//! Which keys a kind of fault has, and how large their values are drawn.

use super::ScriptedKind;

/// Which keys a kind has beside when and how long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keys {
    /// `robot`: needed, or possible.
    pub robot: Option<bool>,
    /// `share`.
    pub share: bool,
    /// `by_s`.
    pub by_s: bool,
    /// `thread`, possible.
    pub thread: bool,
    /// `pose`, possible.
    pub pose: bool,
    /// `motion`, needed.
    pub motion: bool,
    /// `way` and `mediator`, possible.
    pub way: bool,
}

impl ScriptedKind {
    /// Which keys it has.
    #[must_use]
    pub fn keys(self) -> Keys {
        let keys = |robot, share, by_s| Keys {
            robot,
            share,
            by_s,
            thread: matches!(self, Self::Hang | Self::LateThreads | Self::Panic),
            pose: self == Self::CloneRobot,
            motion: self == Self::Teleop,
            way: matches!(
                self,
                Self::Lose | Self::Repeat | Self::Delay | Self::Partition
            ),
        };
        match self {
            Self::Lose | Self::Repeat | Self::Drift => keys(Some(false), true, false),
            Self::Delay => keys(Some(false), false, true),
            Self::Partition
            | Self::DeadLink
            | Self::LoseNetwork
            | Self::FillDisk
            | Self::KillRobot
            | Self::RebootRobot
            | Self::Sleep
            | Self::EndRobot
            | Self::Panic
            | Self::CloneRobot
            | Self::Absent
            | Self::Hang
            | Self::Overload
            | Self::LoseInterface
            | Self::LeaveOp
            | Self::CutPower
            | Self::CutMotors
            | Self::LowVoltage
            | Self::HotMotor
            | Self::FreezeSensors
            | Self::StickEncoder
            | Self::JamPivot
            | Self::ReverseMotor
            | Self::FreezeScans
            | Self::FreezeLidar
            | Self::CoverLidar
            | Self::Unplug
            | Self::Person
            | Self::Box
            | Self::Pause
            | Self::Stop
            | Self::Reset
            | Self::Place
            | Self::Teleop => keys(Some(true), false, false),
            Self::LoseFrames
            | Self::RefuseFrames
            | Self::BreakScans
            | Self::AgeScans
            | Self::Slip
            | Self::WeakBrakes
            | Self::Slope
            | Self::Load
            | Self::Reload => keys(Some(true), true, false),
            Self::LateThreads => keys(Some(true), true, true),
            Self::DelayScans => keys(Some(true), false, true),
            Self::KillMediator
            | Self::RebootMediator
            | Self::HangMediator
            | Self::RestoreJournal
            | Self::LoseJournal
            | Self::SecondMediator
            | Self::CopiedMediator
            | Self::ClearAreas
            | Self::CloseAreas
            | Self::EndCoordination
            | Self::FullDisk => keys(None, false, false),
            Self::SlowDisk => keys(None, false, true),
        }
    }

    /// The least share that it may have.
    #[must_use]
    pub fn least_share(self) -> f64 {
        match self {
            Self::Drift | Self::Slope => -1.0,
            _ => 0.0,
        }
    }

    /// The largest share that is drawn at random.
    #[must_use]
    pub fn most_share(self) -> f64 {
        match self {
            // Clocks of computers are off by less.
            Self::Drift => 0.0005,
            Self::Slip => 0.3,
            Self::WeakBrakes => 0.6,
            // Steeper than ramps for wheelchairs are.
            Self::Slope => 0.08,
            Self::Reload => 0.5,
            // Before the end of a long one scans are later than they may be.
            Self::AgeScans => 0.06,
            _ => 1.0,
        }
    }

    /// The longest `by_s` that is drawn at random.
    #[must_use]
    pub fn most_by_s(self) -> f64 {
        match self {
            Self::LateThreads => 0.1,
            // Twice the time for which robots may go by what they have heard.
            Self::Delay => 10.0,
            _ => 1.0,
        }
    }
}
