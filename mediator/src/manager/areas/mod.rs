//! Who may be in which area: requests, grants with fences, occupancy, revocation.
//!
//! * **Occupancy.** An area is occupied by every robot that was granted it, that stands in it by its own report, or that did so
//!   when it was last heard. A silent robot goes on occupying what it occupied.
//! * **Queue.** Requests wait in the order of priority, then of asking.
//! * **Grant.** Given when the area's other occupants leave room; whoever stands in the area already comes first. An intruder
//!   closes it to everyone who does not stand there, and more bodies than the area holds, those of second processes included, to
//!   everyone, until it is right again; grants that are not used yet are asked back.
//! * **Closing.** An operator closes an area: grants that are not used yet are asked back, and nobody is let in who does not stand
//!   there already.
//! * **Fence.** Every grant of an area has a larger number than all before it, so a message about an older grant is recognised
//!   and ignored.
//! * **Restart.** A new process of a robot is its next one where the one before can have brought it; elsewhere it is another body, and what the
//!   one before was in or had stays blocked.
//! * **Revocation.** Asking a grant back is a request: until the robot has answered, it has the area.
//!
//! What coordinations decide about areas comes in through [`Reservations`].

mod before;
mod claim;
mod closing;
mod grants;
mod occupant;
mod reports;
mod reservations;
mod restore;
mod revocation;
mod revoking;
mod seconds;
mod table;
mod takeover;

pub(crate) use reservations::{Reservations, Reserved};
pub(crate) use seconds::{Known, Speaker};
pub(crate) use table::Areas;
pub(crate) use takeover::SecondHeard;

#[cfg(test)]
mod tests;
