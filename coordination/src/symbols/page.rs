//! A page: the blackboard of one symbol that was added while the robot ran.

use iceoryx2::port::reader::EntryHandle;
use iceoryx2::port::writer::EntryHandleMut;

use super::blackboard::{Adder, Blackboard, Key, PageBoard, WriterPort, failed};
use super::entry::Presence;
use super::service::Service;
use super::table_run::TableRun;
use super::{Datatype, Stamped, SymbolError};

const VALUE: Key = 0;
const PRESENCE: Key = 1;

/// One symbol's value, and whether the symbol was removed.
#[derive(Debug)]
pub(super) struct Page {
    /// Only its maker writes.
    port: Option<WriterPort>,
    board: PageBoard,
}

type Mut<T> = EntryHandleMut<Service, Key, Stamped<T>>;
type Ref<T> = EntryHandle<Service, Key, Stamped<T>>;

impl Page {
    pub(super) fn create<T: Datatype>(
        blackboard: &Blackboard,
        run: &TableRun,
        page: u64,
    ) -> Result<Self, SymbolError> {
        let board = blackboard.create_page(run, page, |adder: Adder| {
            adder
                .add::<Stamped<T>>(VALUE, zeroed())
                .add::<Stamped<Presence>>(PRESENCE, zeroed())
        })?;
        Ok(Self {
            port: Some(board.writer(run)?),
            board,
        })
    }

    pub(super) fn open(
        blackboard: &Blackboard,
        run: &TableRun,
        page: u64,
    ) -> Result<Self, SymbolError> {
        let board = blackboard.open_page(run, page)?;
        Ok(Self { port: None, board })
    }

    pub(super) fn value<T: Datatype>(&self, run: &TableRun) -> Result<Ref<T>, SymbolError> {
        let entry = self.board.reader.entry(&VALUE);
        entry.map_err(failed(run, "open an added symbol for reading"))
    }

    pub(super) fn presence(&self, run: &TableRun) -> Result<Ref<Presence>, SymbolError> {
        let entry = self.board.reader.entry(&PRESENCE);
        entry.map_err(failed(run, "open an added symbol for reading"))
    }

    pub(super) fn value_mut<T: Datatype>(&self, run: &TableRun) -> Result<Mut<T>, SymbolError> {
        let entry = self.port(run)?.entry(&VALUE);
        entry.map_err(failed(run, "open an added symbol for writing"))
    }

    pub(super) fn presence_mut(&self, run: &TableRun) -> Result<Mut<Presence>, SymbolError> {
        let entry = self.port(run)?.entry(&PRESENCE);
        entry.map_err(failed(run, "open an added symbol for writing"))
    }

    fn port(&self, run: &TableRun) -> Result<&WriterPort, SymbolError> {
        let port = self.port.as_ref().ok_or("only its maker writes");
        port.map_err(failed(run, "open an added symbol for writing"))
    }
}

fn zeroed<T: Datatype>() -> Stamped<T> {
    Stamped {
        stamp_ns: 0,
        value: T::zeroed(),
    }
}
