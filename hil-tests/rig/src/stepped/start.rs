//! A start of a robot's process, as the rest of the rig asks for it.

use onboard::activities::communication::OpenSession;

use super::checkpoints::Checkpoints;

/// Who says where the robot may be.
pub enum Fleet {
    /// The mediator, where there is one, over a session on the simulated network.
    Network(OpenSession),
    /// The rig, in communication's place; at first nowhere.
    Rig,
    /// Nobody: it may be anywhere, and talks with nobody.
    Alone,
}

/// A start of a robot's process.
pub struct Start {
    /// Who says where the robot may be.
    pub fleet: Fleet,
    /// Tells this start from others.
    pub boot_epoch: u64,
    /// When, by the world's clock.
    pub at_ns: u64,
    /// How far the clock of its computer is ahead of the world's by then.
    pub ahead_ns: f64,
    /// Where the process before has left its checkpoint, and this one leaves its own.
    pub checkpoints: Checkpoints,
}
