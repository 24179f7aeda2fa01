//! Scenarios with a fleet, through the real programs: every robot and the mediator is a process, their devices speak
//! their protocols, and what happened is judged by the world's truth and an independent listener.
//!
//! - [`bench`] sets the stage, in turn with all other tests that run whole robots;
//! - [`program`]: the rig itself does what it says, and leaves nothing when it is killed;
//! - [`deaths`]: mediator and robots are killed;
//! - [`mixed`]: a robot of another vendor among them;
//! - [`secured`]: links with certificates.

mod bench;
mod deaths;
mod mixed;
mod program;
mod secured;
