//! Who has which handle: runs of the [pattern](crate::acquire_release) by which resources are acquired and released. The table owns the symbols,
//! and activities use them.
//!
//! The activity asks and the table answers within one call, under the table's lock. Of each run one end is in the handle, the other one
//! here. The table is the keeper: removing a symbol takes it from whoever has it, and what such a handle releases later is void.

use std::sync::LazyLock;

use super::directory::RowId;
use crate::acquire_release::{AcquireRelease, By, Resource};
use crate::protocol::{End, FlagId, Side, channel};

/// The pattern, in the names of a symbol table.
struct Access {
    resource: Resource,
    ask: FlagId,
    granted: FlagId,
    refused: FlagId,
    release: FlagId,
}

static ACCESS: LazyLock<Access> = LazyLock::new(|| {
    let mut access = AcquireRelease::new("access to a symbol", "activity", "table");
    access
        .acquire("ask", "granted")
        .refuse("refused")
        .release("release")
        .keeper(By::Owner);
    let resource = access.compile().expect("it acquires and releases");
    let flag = |name| resource.protocol().flag(name).expect("it is declared");
    Access {
        ask: flag("ask"),
        granted: flag("granted"),
        refused: flag("refused"),
        release: flag("release"),
        resource,
    }
});

/// What a handle is acquired for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Held {
    Writer,
    /// The activity's number.
    Reader(u32),
}

/// A symbol that is held.
#[derive(Debug)]
struct Grant {
    row: RowId,
    held: Held,
    table: End,
}

/// The table's ends.
#[derive(Debug, Default)]
pub(super) struct Grants {
    all: Vec<Grant>,
}

impl Grants {
    /// Asks for a symbol and answers: the activity's end, or nothing if it is refused, because somebody has the one writer.
    pub(super) fn acquire(&mut self, row: RowId, held: Held) -> Option<End> {
        let access = &*ACCESS;
        let (mut activity, mut table) = channel(access.resource.protocol());
        let is_free = held != Held::Writer || !self.has(row, held);
        activity.set(access.ask).ok()?;
        table.poll();
        let answer = if is_free {
            access.granted
        } else {
            access.refused
        };
        table.set(answer).ok()?;
        activity.poll();
        if !access.resource.is_held(activity.read_to()) {
            return None;
        }
        self.all.push(Grant { row, held, table });
        Some(activity)
    }

    /// Whether somebody has it.
    pub(super) fn has(&self, row: RowId, held: Held) -> bool {
        let mut all = self.all.iter();
        all.any(|grant| grant.row == row && grant.held == held)
    }

    /// Takes back what has been released since.
    pub(super) fn take_back(&mut self) -> Vec<(RowId, Held)> {
        let is_released = |grant: &mut Grant| {
            grant.table.poll();
            !ACCESS.resource.is_held(grant.table.read_to())
        };
        let released = self.all.extract_if(.., is_released);
        released.map(|grant| (grant.row, grant.held)).collect()
    }

    /// Takes a removed symbol from all who have it.
    pub(super) fn revoke(&mut self, row: RowId) {
        for mut grant in self.all.extract_if(.., |grant| grant.row == row) {
            // The runs of one handle never come to the last number.
            let _ = grant.table.abort();
        }
    }
}

/// Releases what an activity has; `false` if it was taken from it before.
pub(super) fn release(activity: &mut End) -> bool {
    activity.set(ACCESS.release).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::symbols::Datatype;
    use crate::symbols::directory::{DECLARED, Directory};

    #[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
    #[repr(C)]
    struct Angle {
        rad: f64,
    }

    impl Datatype for Angle {
        const NAME: &'static str = "angle";
    }

    fn rows() -> [RowId; 2] {
        let mut directory = Directory::new();
        ["left", "right"].map(|model| directory.add::<Angle>("drive", model, DECLARED).unwrap())
    }

    #[test]
    fn one_writes_a_symbol_and_the_next_one_after_it() {
        let [left, right] = rows();
        let mut grants = Grants::default();
        let mut first = grants.acquire(left, Held::Writer).unwrap();
        assert!(grants.acquire(left, Held::Writer).is_none());
        assert!(grants.acquire(right, Held::Writer).is_some());
        assert!(grants.take_back().is_empty());

        assert!(release(&mut first));
        assert_eq!(grants.take_back(), [(left, Held::Writer)]);
        assert!(grants.acquire(left, Held::Writer).is_some());
    }

    #[test]
    fn any_number_read() {
        let [left, _] = rows();
        let mut grants = Grants::default();
        let mut readers = [1, 1, 2].map(|activity| grants.acquire(left, Held::Reader(activity)));
        assert!(readers.iter().all(Option::is_some));
        assert!(release(readers[0].as_mut().unwrap()));
        assert_eq!(grants.take_back(), [(left, Held::Reader(1))]);
        assert!(grants.has(left, Held::Reader(1)), "its other handle");
    }

    #[test]
    fn what_was_taken_away_is_not_released_again() {
        let [left, _] = rows();
        let mut grants = Grants::default();
        let mut before = grants.acquire(left, Held::Writer).unwrap();
        grants.revoke(left);
        assert_eq!(before.peek(), Some(crate::protocol::Change::Aborted));
        // Another symbol has come into its row.
        let _writer = grants.acquire(left, Held::Writer).unwrap();
        assert!(!release(&mut before));
        assert!(grants.take_back().is_empty());
        assert!(grants.has(left, Held::Writer));
    }
}
