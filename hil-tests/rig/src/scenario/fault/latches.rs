//! Which faults that wait for an operator a kind may be to blame for. Any other that a robot says it has is its own mistake.

use onboard::symbols::faults::Fault;

use super::ScriptedKind;

/// A bus that is gone for a while comes back to a robot that waits for its operator, who may have to say what is behind it.
const GONE: &[Fault] = &[
    Fault::DriveReturned,
    Fault::BringUpLimit,
    Fault::FloorUnknown,
];
/// A process that ends leaves what the next one cannot know.
const ENDED: &[Fault] = &[
    Fault::PlaceUnknown,
    Fault::DriveReturned,
    Fault::BringUpLimit,
    Fault::FloorUnknown,
];
const PANICKED: &[Fault] = &[
    Fault::Panic,
    Fault::PlaceUnknown,
    Fault::DriveReturned,
    Fault::BringUpLimit,
    Fault::FloorUnknown,
];
/// Threads that do not run are found to hang or to be late, and what they exchange with the drive stops.
const LATE: &[Fault] = &[
    Fault::ThreadHung,
    Fault::Overruns,
    Fault::DriveReturned,
    Fault::BringUpLimit,
    Fault::FloorUnknown,
];

impl ScriptedKind {
    /// Whether this kind may be to blame for that fault of a robot's. Any may for a robot that sees no walls for so long that it does not
    /// know where it is, and for the stop of the operator who helps it then.
    #[must_use]
    pub fn may_latch(self, fault: Fault) -> bool {
        let any = [Fault::PoseUncertain, Fault::OperatorStop];
        any.contains(&fault) || self.latches().contains(&fault)
    }

    fn latches(self) -> &'static [Fault] {
        match self {
            // Another process of the robot stands still or goes on elsewhere.
            Self::KillRobot
            | Self::EndRobot
            | Self::RebootRobot
            | Self::Sleep
            | Self::LoseNetwork
            | Self::FillDisk
            | Self::Absent => ENDED,
            Self::Panic => PANICKED,
            Self::Hang | Self::LateThreads | Self::Overload => LATE,
            Self::LoseFrames
            | Self::RefuseFrames
            | Self::LoseInterface
            | Self::LeaveOp
            | Self::CutPower => GONE,
            Self::CutMotors => &[Fault::MotorsOff, Fault::FloorUnknown],
            Self::LowVoltage => &[Fault::BusVoltage],
            Self::HotMotor => &[Fault::DriveFault],
            Self::FreezeSensors => &[Fault::DriveStalled, Fault::FloorUnknown],
            Self::StickEncoder => &[
                Fault::EncoderBroken,
                Fault::WheelSlip,
                Fault::WheelsDisobey,
                Fault::FloorUnknown,
            ],
            Self::Slip => &[Fault::WheelSlip, Fault::WheelsDisobey, Fault::FloorUnknown],
            Self::JamPivot | Self::Slope => &[Fault::WheelsDisobey, Fault::WheelSlip],
            Self::ReverseMotor => &[Fault::WheelsDisobey, Fault::WheelSlip, Fault::EncoderBroken],
            Self::WeakBrakes | Self::Load => &[Fault::WheelsDisobey],
            Self::FreezeScans | Self::FreezeLidar => &[Fault::LidarFrozen],
            // Who puts a robot elsewhere than it is has its wheels turn otherwise than its map says.
            Self::Place => &[Fault::WheelSlip],
            Self::Lose
            | Self::Repeat
            | Self::Delay
            | Self::Partition
            | Self::DeadLink
            | Self::CloneRobot
            | Self::KillMediator
            | Self::RebootMediator
            | Self::HangMediator
            | Self::RestoreJournal
            | Self::LoseJournal
            | Self::SecondMediator
            | Self::CopiedMediator
            | Self::ClearAreas
            | Self::CloseAreas
            | Self::EndCoordination
            | Self::SlowDisk
            | Self::FullDisk
            | Self::Drift
            | Self::BreakScans
            | Self::DelayScans
            | Self::AgeScans
            | Self::CoverLidar
            | Self::Unplug
            | Self::Person
            | Self::Box
            | Self::Pause
            | Self::Stop
            | Self::Reset
            | Self::Reload
            | Self::Teleop => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use onboard::symbols::faults::Resumes;

    use super::*;

    #[test]
    fn messages_and_mediators_break_no_drive() {
        for what in [ScriptedKind::KillMediator, ScriptedKind::Lose] {
            let latches = { Fault::ALL.into_iter() }.filter(|&fault| what.may_latch(fault));
            let any = [Fault::PoseUncertain, Fault::OperatorStop];
            assert_eq!(latches.collect::<Vec<_>>(), any);
        }
        assert!(ScriptedKind::CutPower.may_latch(Fault::DriveReturned));
    }

    /// One that a table would excuse and nobody waits for would be a mistake of the table.
    #[test]
    fn only_what_waits_for_an_operator_is_excused() {
        for what in ScriptedKind::all() {
            let mut latches = what.latches().iter();
            assert!(latches.all(|fault| fault.resumes() == Resumes::Operator));
        }
    }
}
