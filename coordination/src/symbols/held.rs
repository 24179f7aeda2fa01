//! What handles hold: the memory, and their place in the directory, which they give back when they are dropped.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use iceoryx2::port::writer::EntryHandleMut;

use super::access::{self, Grants, Held};
use super::blackboard::{Blackboard, Key, WriterPort};
use super::directory::{DECLARED, Directory, RowId};
use super::entry::{Presence, Writer};
use super::owner::Owner;
use super::page::Page;
use super::service::Service;
use super::{Datatype, Stamped, SymbolError};
use crate::protocol::End;

/// What has to live as long as any handle; dropped in this order.
pub(super) struct Memory {
    pub(super) port: WriterPort,
    pub(super) blackboard: Blackboard,
    pub(super) owner: Owner,
}

/// A table, for its handles; dropped in this order.
pub(super) struct Shared {
    pub(super) state: Mutex<State>,
    pub(super) memory: Arc<Memory>,
}

impl Shared {
    pub(super) fn lock(&self) -> MutexGuard<'_, State> {
        // Every change of the state is complete before anything can panic.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

pub(super) struct State {
    pub(super) directory: Box<Directory>,
    pub(super) directory_writer: Writer<Directory>,
    pub(super) generation: u64,
    pub(super) sealed: bool,
    /// Pages are numbered from 1, and no number comes again.
    pub(super) last_page: u64,
    pub(super) pages: HashMap<u64, Added>,
    pub(super) grants: Grants,
}

/// A symbol that was added; dropped in this order.
pub(super) struct Added {
    pub(super) presence: EntryHandleMut<Service, Key, Stamped<Presence>>,
    pub(super) page: Arc<Page>,
}

impl Added {
    /// Tells readers that the symbol is removed.
    pub(super) fn withdraw(self) {
        self.presence.update_with_copy(Stamped {
            stamp_ns: 0,
            value: Presence { removed: 1 },
        });
    }
}

impl State {
    pub(super) fn publish(&mut self) {
        // Not a time: the directory only tells its versions apart.
        self.generation += 1;
        self.directory_writer
            .write(self.generation, &self.directory);
    }

    pub(super) fn look_up<T: Datatype>(
        &self,
        asked_by: &str,
        model: &str,
    ) -> Result<RowId, SymbolError> {
        let row = self.directory.look_up::<T>(asked_by, model)?;
        if self.sealed && self.directory.page(row) == DECLARED {
            return Err(SymbolError::Sealed {
                asked_by: asked_by.into(),
                datatype: T::NAME.into(),
                model: model.into(),
            });
        }
        Ok(row)
    }

    pub(super) fn check_owner<T: Datatype>(
        &self,
        row: RowId,
        asked_by: &str,
        model: &str,
    ) -> Result<(), SymbolError> {
        let owner = self.directory.owner(row);
        if owner == asked_by {
            return Ok(());
        }
        Err(SymbolError::NotOwner {
            asked_by: asked_by.into(),
            datatype: T::NAME.into(),
            model: model.into(),
            owner: owner.into(),
        })
    }

    /// Takes back what an activity has, and lets the directory show that.
    pub(super) fn release(&mut self, activity: &mut End) {
        if !access::release(activity) {
            return;
        }
        for (row, held) in self.grants.take_back() {
            match held {
                Held::Writer => self.directory.set_taken(row, false),
                Held::Reader(_) if self.grants.has(row, held) => {}
                Held::Reader(activity) => self.directory.remove_reader(row, activity),
            }
        }
        self.publish();
    }

    /// The page of an added symbol; none of a declared one.
    pub(super) fn page_of(&self, row: RowId) -> Option<Arc<Page>> {
        let added = self.pages.get(&self.directory.page(row));
        added.map(|added| Arc::clone(&added.page))
    }
}

/// Releases a symbol when it is dropped; its fields are dropped in this order.
pub(super) struct Hold {
    /// The activity's end of the run by which it was acquired.
    pub(super) activity: End,
    pub(super) _page: Option<Arc<Page>>,
    pub(super) shared: Arc<Shared>,
}

impl Drop for Hold {
    fn drop(&mut self) {
        self.shared.lock().release(&mut self.activity);
    }
}
