//! What can go wrong.

use serde::{Deserialize, Serialize};

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ScriptedKind {
    /// Messages from and to a robot, or all, get lost with a probability.
    Lose,
    /// They arrive twice with a probability, the second time up to 10 s later.
    Repeat,
    /// They take longer, by up to `by_s`, so that later ones overtake them.
    Delay,
    /// No message from or to the robot arrives.
    Partition,
    /// The link of the robot's session lives and carries nothing from now on, until the robot opens another session.
    DeadLink,
    /// The robot's process is killed, and started again at the end.
    KillRobot,
    /// The robot's program is told to end, as by a service manager, and started again at the end.
    EndRobot,
    /// A part of the robot's program panics, which ends it once the robot stands: what runs its drive, or `thread`. It is started again at
    /// the end.
    Panic,
    /// The robot's computer is switched off, and on again at the end: its process ends, and nothing is left of what it knew.
    RebootRobot,
    /// A second robot with the same identity, plan and configuration is switched on at a pose, or, as when a robot is near there,
    /// where it is in nobody's way; at the end it is switched off and carried away.
    CloneRobot,
    /// The network interface over which the robot talks with its fleet is gone, and there again at the end. Its process is killed with
    /// it, and the next one can open no session.
    LoseNetwork,
    /// The disk of the robot's computer is full, and has room again at the end. Its process is killed for it, and the next one cannot
    /// note that the robot is under way.
    FillDisk,
    /// The mediator is killed while it writes its journal, or after a second in which it has nothing to write, and started again with the
    /// journal at the end.
    KillMediator,
    /// The same by a loss of power: of what was not synced each sector is on the disk or not, by chance.
    RebootMediator,
    /// The mediator's thread that manages areas hangs, and goes on at the end; what arrives meanwhile waits for it.
    HangMediator,
    /// The mediator's journal is copied; at the end the mediator is killed, and started again with that copy.
    RestoreJournal,
    /// The mediator is killed, and started again at the end without its journal.
    LoseJournal,
    /// Another mediator of the same site runs, with a journal of its own.
    SecondMediator,
    /// The same with a copy of the journal, as when its computer was copied while it ran.
    CopiedMediator,
    /// An operator at the mediator clears every area that he sees empty, again and again. He knows nothing of grants.
    ClearAreas,
    /// An operator at the mediator closes every area, and opens them at the end.
    CloseAreas,
    /// An operator at the mediator ends every coordination that runs.
    EndCoordination,
    /// The robot is switched off and carried away for good, and an operator at the mediator says that it is absent.
    Absent,
    /// The disk below the mediator's journal takes `by_s` for each write.
    SlowDisk,
    /// The disk below the mediator's journal is full.
    FullDisk,
    /// All threads of the robot stand still, or only `thread`, or its supervisor.
    Hang,
    /// The robot's computer sleeps, as one whose lid was closed: nothing of it runs, until it wakes at the end.
    Sleep,
    /// Each wake-up of the robot's threads and of its supervisor is late with a probability, by up to `by_s`.
    LateThreads,
    /// The robot's computer is overloaded: its supervisor does not run, and the thread that controls its wheels wakes up late each
    /// time, by up to 0.1 s. Nobody restarts it.
    Overload,
    /// The robot's clock runs faster than the world's, by this share, or slower where that is negative; without a robot the
    /// mediator's.
    Drift,
    /// Frames on the robot's bus get lost with a probability, on their way there or back.
    LoseFrames,
    /// The network interface of the robot's bus has no room for frames with a probability, and refuses them.
    RefuseFrames,
    /// The network interface of the robot's bus is gone, and there again at the end.
    LoseInterface,
    /// The robot's drive falls out of OP, once.
    LeaveOp,
    /// The robot's drive loses its power, and has it again at the end.
    CutPower,
    /// An emergency stop cuts the power of the robot's motors, and is released at the end.
    CutMotors,
    /// The robot's battery is nearly empty.
    LowVoltage,
    /// The robot's left motor is too hot, says the drive, and takes its power.
    HotMotor,
    /// The firmware of the robot's drive hangs: it answers with what its sensors said last.
    FreezeSensors,
    /// The encoder of the robot's left wheel stands still.
    StickEncoder,
    /// The robot's wheels turn further than it moves: the left one by this share, the right one by half of it.
    Slip,
    /// The robot's drive unit does not turn under its platform.
    JamPivot,
    /// The robot's left motor turns the wrong way.
    ReverseMotor,
    /// The robot's motors brake less hard than its file says, by this share.
    WeakBrakes,
    /// The floor falls away ahead of the robot, by this share of the way, or rises where that is negative.
    Slope,
    /// The robot is heavier than its motors are made for, by this share.
    Load,
    /// Scans of the robot's lidar arrive broken with a probability.
    BreakScans,
    /// What the robot's lidar sends arrives late, by `by_s`.
    DelayScans,
    /// What the robot's lidar sends arrives later and later, by this share of the time that passes.
    AgeScans,
    /// The robot's lidar repeats its last scan, until its laser is switched off and on.
    FreezeScans,
    /// The robot's lidar repeats its last scan, and does so again a second after each time that its laser is switched on.
    FreezeLidar,
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
    /// An operator resets the robot, and again at the end, though nobody asked him to; not one that was stopped on purpose.
    Reset,
    /// An operator says where the robot is and how far the floor behind it is free, and again at the end, though nobody asked him to.
    Place,
    /// An operator lowers the robot's top speed by this share in its file and has that read again, and puts it back at the end.
    Reload,
    /// Somebody drives the robot by hand, and sends it on at the end.
    Teleop,
}

/// As a `thread` that hangs or is late: the robot's supervisor.
pub const SUPERVISOR: &str = "supervisor";

impl ScriptedKind {
    /// A fleet is expected to come through any of them. They are drawn at random, as the next ones are.
    pub const DRAWN: [Self; 40] = [
        Self::Lose,
        Self::Repeat,
        Self::Delay,
        Self::Partition,
        Self::DeadLink,
        Self::KillRobot,
        Self::KillMediator,
        Self::RebootMediator,
        Self::CloseAreas,
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
        Self::Reset,
        Self::Panic,
        Self::RefuseFrames,
        Self::LoseInterface,
        Self::Slope,
        Self::Load,
        Self::FreezeScans,
        Self::Reload,
        Self::Place,
        Self::EndRobot,
        Self::HangMediator,
        Self::LoseNetwork,
        Self::FillDisk,
    ];

    /// Those that a fleet comes through besides, but slowly: on each of them but a full disk the robot stops and needs its operator.
    pub const BORNE: [Self; 12] = [
        Self::FullDisk,
        Self::RebootRobot,
        Self::LowVoltage,
        Self::HotMotor,
        Self::FreezeSensors,
        Self::StickEncoder,
        Self::JamPivot,
        Self::ReverseMotor,
        Self::WeakBrakes,
        Self::FreezeLidar,
        Self::Overload,
        Self::Sleep,
    ];

    /// Those after which robots are safe, but may need more than resets to go on. They are drawn now and then, but
    /// for `absent`: without that robot a fleet does not come to its goals.
    pub const LASTING: [Self; 9] = [
        Self::Teleop,
        Self::ClearAreas,
        Self::EndCoordination,
        Self::CloneRobot,
        Self::RestoreJournal,
        Self::LoseJournal,
        Self::SecondMediator,
        Self::CopiedMediator,
        Self::Absent,
    ];

    /// Every kind.
    pub fn all() -> impl Iterator<Item = Self> {
        { Self::DRAWN.into_iter() }
            .chain(Self::BORNE)
            .chain(Self::LASTING)
    }

    /// Its name in a file.
    #[must_use]
    pub fn name(self) -> String {
        // Every kind is a word.
        let quoted = serde_json::to_string(&self).unwrap_or_default();
        quoted.trim_matches('"').to_owned()
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
                | Self::DeadLink
                | Self::LoseNetwork
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
                | Self::Absent
                | Self::SlowDisk
                | Self::FullDisk
        )
    }

    /// Whether a robot may take its pose, by no fault of its own, for another than it is: what tells it how its wheels turn, or where
    /// walls are, is wrong or late, or somebody tells it. Late threads are none: what is measured has the time of its measurement.
    pub(super) fn misleads(self) -> bool {
        matches!(
            self,
            Self::Slip
                | Self::StickEncoder
                | Self::FreezeSensors
                | Self::FreezeScans
                | Self::FreezeLidar
                | Self::AgeScans
                | Self::DelayScans
                | Self::Place
        )
    }
}
