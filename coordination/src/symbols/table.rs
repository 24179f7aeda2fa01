//! The owner's side: declare, build, hand out, seal; add and remove.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex};

use super::access::{Grants, Held};
use super::blackboard::{Adder, Blackboard, failed};
use super::directory::{DECLARED, DIRECTORY_KEY, Directory, RowId};
use super::entry::{Reader, Writer};
use super::held::{Added, Hold, Memory, Shared, State};
use super::owner::Owner;
use super::page::Page;
use super::sweep::Removed;
use super::{Datatype, Namespace, Stamped, SymbolError, SymbolInfo};
use crate::protocol::End;

/// Collects the declarations of the owners; the first phase of start-up.
pub struct TableBuilder {
    robot: String,
    place: Namespace,
    directory: Box<Directory>,
    adders: Vec<Box<dyn FnOnce(Adder) -> Adder>>,
}

impl TableBuilder {
    /// A table without symbols for the robot called `robot`. Nothing is created yet.
    #[must_use]
    pub fn new(robot: &str, place: &Namespace) -> Self {
        Self {
            robot: robot.to_owned(),
            place: place.clone(),
            directory: Directory::new(),
            adders: Vec::new(),
        }
    }

    /// Declares that the activity `owner` owns the symbol (`T`, `model`).
    ///
    /// # Errors
    /// If a name cannot be used, the symbol is declared already, or the directory is full.
    pub fn declare<T: Datatype>(
        &mut self,
        owner: &str,
        model: &str,
    ) -> Result<&mut Self, SymbolError> {
        let row = self.directory.add::<T>(owner, model, DECLARED)?;
        self.adders.push(Box::new(move |adder: Adder| {
            let never_written = Stamped {
                stamp_ns: 0,
                value: T::zeroed(),
            };
            adder.add::<Stamped<T>>(row.key(), never_written)
        }));
        Ok(self)
    }

    /// Creates the shared memory, after removing what a killed process left of this robot. Refuses
    /// while the robot runs already. Not for real-time threads.
    ///
    /// # Errors
    /// If nothing is declared, the robot runs already, or a file or the shared memory cannot be made.
    pub fn build(self) -> Result<SymbolTable, SymbolError> {
        if self.adders.is_empty() {
            return Err(SymbolError::NothingDeclared {
                robot: self.robot.into(),
            });
        }
        let (owner, removed_at_start) = Owner::acquire(&self.robot, &self.place)?;
        let run = owner.run.clone();
        let directory = self.directory;
        let first = Stamped {
            stamp_ns: 0,
            value: *directory,
        };
        let adders = self.adders;
        let blackboard = Blackboard::create(&run, &self.place, |adder| {
            let adder = adder.add::<Stamped<Directory>>(DIRECTORY_KEY, first);
            adders.into_iter().fold(adder, |adder, add| add(adder))
        })?;
        let port = blackboard.writer(&run)?;
        let handle = port
            .entry::<Stamped<Directory>>(&DIRECTORY_KEY)
            .map_err(failed(&run, "open the directory"))?;
        let memory = Arc::new(Memory {
            port,
            blackboard,
            owner,
        });
        let state = State {
            directory,
            directory_writer: Writer::new(handle, Box::new(Arc::clone(&memory))),
            generation: 0,
            sealed: false,
            last_page: DECLARED,
            pages: HashMap::new(),
            grants: Grants::default(),
        };
        let table = SymbolTable {
            shared: Arc::new(Shared {
                state: Mutex::new(state),
                memory,
            }),
            removed_at_start,
        };
        table.shared.lock().publish();
        // Last, so that nobody opens a table whose directory is not yet there.
        table.shared.memory.owner.publish()?;
        Ok(table)
    }
}

impl fmt::Debug for TableBuilder {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "TableBuilder({})", self.robot)
    }
}

/// The symbols of one running robot; there is one per robot and place.
///
/// The shared memory lives until the table and all its handles are dropped, and is then removed.
pub struct SymbolTable {
    shared: Arc<Shared>,
    removed_at_start: Removed,
}

impl SymbolTable {
    /// Hands `owner` the writer of its symbol (`T`, `model`), of which there is one at a time.
    ///
    /// # Errors
    /// If the symbol is declared and the table is sealed, the symbol is unknown or of another type or owner, or its writer is taken.
    pub fn writer<T: Datatype>(&self, owner: &str, model: &str) -> Result<Writer<T>, SymbolError> {
        let mut state = self.shared.lock();
        let row = state.look_up::<T>(owner, model)?;
        state.check_owner::<T>(row, owner, model)?;
        self.take_writer(&mut state, row, owner, model)
    }

    fn take_writer<T: Datatype>(
        &self,
        state: &mut State,
        row: RowId,
        owner: &str,
        model: &str,
    ) -> Result<Writer<T>, SymbolError> {
        let granted = state.grants.acquire(row, Held::Writer);
        let mut activity = granted.ok_or_else(|| SymbolError::WriterTaken {
            owner: owner.into(),
            datatype: T::NAME.into(),
            model: model.into(),
        })?;
        let memory = &self.shared.memory;
        let page = state.page_of(row);
        let handle = match &page {
            Some(page) => page.value_mut::<T>(&memory.owner.run),
            None => { memory.port.entry::<Stamped<T>>(&row.key()) }
                .map_err(failed(&memory.owner.run, "open a symbol for writing")),
        };
        match handle {
            Ok(handle) => {
                state.directory.set_taken(row, true);
                state.publish();
                Ok(Writer::new(handle, self.hold(activity, page)))
            }
            Err(error) => {
                state.release(&mut activity);
                Err(error)
            }
        }
    }

    /// Looks up the symbol (`T`, `model`) for the activity `reader`, and notes it as a reader for as long as it has the handle.
    ///
    /// # Errors
    /// If the symbol is declared and the table is sealed, the symbol is unknown or of another type, or the list of readers is full.
    pub fn reader<T: Datatype>(&self, reader: &str, model: &str) -> Result<Reader<T>, SymbolError> {
        let mut state = self.shared.lock();
        let row = state.look_up::<T>(reader, model)?;
        let memory = &self.shared.memory;
        let run = &memory.owner.run;
        let page = state.page_of(row);
        let (handle, presence) = match &page {
            Some(page) => (page.value::<T>(run)?, Some(page.presence(run)?)),
            None => {
                let handle = memory.blackboard.reader.entry::<Stamped<T>>(&row.key());
                let handle = handle.map_err(failed(run, "open a symbol for reading"))?;
                (handle, None)
            }
        };
        let number = state.directory.add_reader(row, reader)?;
        let granted = state.grants.acquire(row, Held::Reader(number));
        let activity = granted.expect("any number read");
        state.publish();
        Ok(Reader::new(handle, presence, self.hold(activity, page)))
    }

    fn hold(&self, activity: End, page: Option<Arc<Page>>) -> Box<Hold> {
        Box::new(Hold {
            activity,
            _page: page,
            shared: Arc::clone(&self.shared),
        })
    }

    /// Adds the symbol (`T`, `model`) of `owner` to the running table and hands out its writer: at any time, also after
    /// [`seal`](Self::seal), by a thread that is not a real-time one. The symbol has shared memory of its own, a page, so that nothing
    /// of other symbols is touched; [`writer`](Self::writer) and [`reader`](Self::reader) give handles of it until it is
    /// [removed](Self::remove).
    ///
    /// # Errors
    /// If a name cannot be used, there is such a symbol, the directory is full, or the shared memory cannot be made.
    pub fn add<T: Datatype>(&self, owner: &str, model: &str) -> Result<Writer<T>, SymbolError> {
        let mut state = self.shared.lock();
        let memory = &self.shared.memory;
        let run = &memory.owner.run;
        let number = state.last_page + 1;
        let row = state.directory.add::<T>(owner, model, number)?;
        state.last_page = number;
        let page = Page::create::<T>(&memory.blackboard, run, number);
        let added = page.and_then(|page| {
            Ok(Added {
                presence: page.presence_mut(run)?,
                page: Arc::new(page),
            })
        });
        let taken = added.and_then(|added| {
            state.pages.insert(number, added);
            self.take_writer(&mut state, row, owner, model)
        });
        if taken.is_err() {
            state.directory.remove(row);
            state.pages.remove(&number);
            state.publish();
        }
        taken
    }

    /// Removes the symbol (`T`, `model`), which `owner` has added: it leaves the directory at once, and its readers are
    /// [told](Reader::is_removed). Handles of it go on working, on values that nobody else finds; its memory is freed with the last of
    /// them. Not for real-time threads.
    ///
    /// # Errors
    /// If the symbol is unknown or of another type or owner, or was declared before the table was built.
    pub fn remove<T: Datatype>(&self, owner: &str, model: &str) -> Result<(), SymbolError> {
        let mut state = self.shared.lock();
        let row = state.directory.look_up::<T>(owner, model)?;
        state.check_owner::<T>(row, owner, model)?;
        let number = state.directory.page(row);
        let Some(added) = state.pages.remove(&number) else {
            return Err(SymbolError::NotAdded {
                datatype: T::NAME.into(),
                model: model.into(),
            });
        };
        state.directory.remove(row);
        state.grants.revoke(row);
        state.publish();
        drop(state);
        added.withdraw();
        Ok(())
    }

    /// Ends start-up: no more handles are given of declared symbols, so that whatever runs in real time has what it will ever have.
    /// Fails if a declared symbol has no writer. Symbols can still be [added](Self::add), and handles of those are given.
    ///
    /// # Errors
    /// [`SymbolError::NotTaken`] with every such symbol.
    pub fn seal(&self) -> Result<(), SymbolError> {
        let mut state = self.shared.lock();
        let not_taken = state.directory.not_taken();
        if !not_taken.is_empty() {
            return Err(SymbolError::NotTaken {
                symbols: not_taken.join(", ").into(),
            });
        }
        state.sealed = true;
        state.directory.sealed = 1;
        state.publish();
        Ok(())
    }

    /// All symbols, in the order of their declaration.
    #[must_use]
    pub fn directory(&self) -> Vec<SymbolInfo> {
        self.shared.lock().directory.list()
    }

    /// The robot that the table belongs to.
    #[must_use]
    pub fn robot(&self) -> &str {
        &self.shared.memory.owner.run.robot
    }

    /// What a killed process had left of this robot, and building the table removed.
    #[must_use]
    pub fn removed_at_start(&self) -> &Removed {
        &self.removed_at_start
    }
}

impl fmt::Debug for SymbolTable {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "SymbolTable({})", self.robot())
    }
}
