//! What survives a restart of the mediator: an entry for every key whose value changed.
//!
//! Entries are put in order and whole: after a crash the store holds all entries up to some moment and none behind it.

mod entry;
mod error;
mod place;
mod record;
mod row;
mod store;

pub use entry::{
    AccessRecord, Before, ClosedRecord, Entry, OrderRecord, RevocationRecord, RobotRecord,
    SecondRecord, Stored,
};
pub use error::StoreError;
pub use record::{CoordinationRecord, LevelRecord, PartRecord};
pub use store::Store;

#[cfg(test)]
mod tests;
