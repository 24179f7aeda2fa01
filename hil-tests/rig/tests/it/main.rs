//! Tests of whole robots, subject by subject: `stepped` on the simulated clock, where figures are judged because no load of the machine
//! spoils them, and `programs` through the real programs, whose devices speak their protocols: what only they show, and that they are safe.
//! Both judge by the world's truth.
//!
//! They are one binary, since real programs wait most of the time, and stepped ones compute: they do so one beside the other. What takes
//! longest begins first.

/// What tests of real programs have in common: the stage of one robot, or of a fleet; a turn among those who want the machine; who waits
/// for what is true, asks how threads do, keeps one from its work, and knows when the machine was to blame.
mod programs {
    pub mod bench;
    pub mod figures;
    pub mod fleet;
    pub mod held;
    pub mod late;
    pub mod turn;
    pub mod watch;
}
mod stepped;

/// Fleets and their mediator.
mod a_fleet {
    /// The rig itself does what it says, and leaves nothing when it is killed; mediator and robots are killed; a robot of another
    /// vendor is among them; links have certificates.
    mod programs {
        mod deaths;
        mod mixed;
        mod program;
        mod secured;
    }
    mod stepped;
}

/// What real-time threads promise, for a minute.
mod a_minute {
    mod programs;
}

/// The bus loses frames, or the drive.
mod bus {
    mod programs;
    mod stepped;
}

/// Somebody drives it by hand.
mod by_hand {
    mod programs;
    mod stepped;
}

/// What the judge must find.
mod controls {
    mod stepped;
}

/// The robot is killed, or told to end.
mod death {
    mod programs;
    mod stepped;
}

/// It starts again in the dock.
mod docked {
    mod stepped;
}

/// Other users of the computer ask.
mod doors {
    mod programs;
}

/// The drive fails.
mod drive {
    mod programs;
    mod stepped;
}

/// The faults of a scenario.
mod faults {
    mod stepped;
}

/// Its files are wrong.
mod files {
    mod programs;
}

/// What campaigns have found.
mod found {
    mod stepped;
}

/// Threads hang.
mod hung {
    mod stepped;
}

/// The rig is interrupted, or killed.
mod laps {
    mod programs;
}

/// The lidar fails.
mod lidar {
    mod programs;
    mod stepped;
}

/// `rig bench`.
mod measured {
    mod programs;
}

/// The names that it needs are taken.
mod names {
    mod programs;
}

/// Something is in the way.
mod obstacle {
    mod stepped;
}

/// Requests while it drives.
mod operator {
    mod programs;
}

/// Orders while it drives.
mod orders {
    mod programs;
}

/// The computer has no time for it.
mod overload {
    mod programs;
}

/// Threads panic.
mod panics {
    mod stepped;
}

/// An operator says where it stands.
mod placing {
    mod stepped;
}

/// What is answered to a reset.
mod resets {
    mod stepped;
}

/// Faults that are never drawn by chance.
mod scripted {
    mod stepped;
}

/// Its computer sleeps.
mod sleep {
    mod stepped;
}

/// Another MainDevice than ours.
mod stranger {
    mod programs;
}

/// It strays from its lane.
mod straying {
    mod stepped;
}

/// Whole scenarios of one robot.
mod trials {
    mod stepped;
}

/// Wheels do not obey.
mod wheels {
    mod stepped;
}
