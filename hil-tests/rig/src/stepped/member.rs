//! A robot of a stepped fleet: its devices, its process while it runs, and the people who look after it.

use onboard::symbols::faults::FaultTable;
use serde_json::Value as Json;

use super::checkpoints::Checkpoints;
use super::devices::Devices;
use super::driving_out::DrivingOut;
use super::motors_off::MotorsOff;
use super::reloading::Reloading;
use super::restarting::Restarting;
use super::robot::SteppedRobot;
use super::sending_on::SendingOn;
use crate::scenario::ScriptedKind;
use crate::stand_ins::caretaker::Caretaker;

/// One of the robots.
pub(super) struct Member {
    pub(super) id: String,
    pub(super) devices: Devices,
    pub(super) starts_ns: u64,
    /// None before it starts, and while it is killed.
    pub(super) robot: Option<SteppedRobot>,
    /// It is killed in the next step, by this.
    pub(super) killed: Option<ScriptedKind>,
    /// It was carried away for good.
    pub(super) gone: bool,
    /// How far its computer's clock was ahead when its process was killed.
    pub(super) ahead_ns: f64,
    /// What its processes leave for the next.
    pub(super) checkpoints: Checkpoints,
    /// State of its machine when its process was killed, as people remember it.
    pub(super) was_in: Option<String>,
    /// Its process has driven, and so knew where it was and in which state: that holds though it may have lost its place since, asleep.
    pub(super) has_driven: bool,
    /// The operator who resets it.
    pub(super) caretaker: Caretaker,
    /// The operator who drives it by hand.
    pub(super) driving_out: DrivingOut,
    /// The operator who sends it on.
    pub(super) sending_on: SendingOn,
    /// The operator who changes its file, and has it read again.
    pub(super) reloading: Reloading,
    /// The operator who restarts it.
    pub(super) restarting: Restarting,
    pub(super) faults: FaultTable,
    /// Whether it must wait for its operator, whatever it says.
    pub(super) motors_off: MotorsOff,
    /// How often its processes that have ended raised each fault, in the order of [`Fault::ALL`].
    pub(super) raised_before: Vec<u64>,
    /// What its symbols said when it was stopped.
    pub(super) symbols: Json,
    /// The areas that the rig has given it leave for.
    pub(super) allowed: Vec<bool>,
}
