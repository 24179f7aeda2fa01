//! The owner's side: declare, build, hand out, seal.

use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::blackboard::{Adder, Blackboard, WriterPort, failed};
use super::directory::{DIRECTORY_KEY, Directory, RowId};
use super::entry::{Reader, Writer};
use super::owner::Owner;
use super::sweep::Removed;
use super::{Datatype, Namespace, Stamped, SymbolError, SymbolInfo};

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
        let row = self.directory.add::<T>(owner, model)?;
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
        let shared = Arc::new(Shared {
            port,
            blackboard,
            owner,
        });
        let directory_writer = Writer::new(handle, shared.clone());
        let table = SymbolTable {
            state: Mutex::new(State {
                directory,
                directory_writer,
                generation: 0,
                sealed: false,
            }),
            shared,
            removed_at_start,
        };
        table.lock().publish();
        // Last, so that nobody opens a table whose directory is not yet there.
        table.shared.owner.publish()?;
        Ok(table)
    }
}

impl fmt::Debug for TableBuilder {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "TableBuilder({})", self.robot)
    }
}

/// What has to live as long as any handle; dropped in this order.
struct Shared {
    port: WriterPort,
    blackboard: Blackboard,
    owner: Owner,
}

struct State {
    directory: Box<Directory>,
    directory_writer: Writer<Directory>,
    generation: u64,
    sealed: bool,
}

impl State {
    fn publish(&mut self) {
        // Not a time: the directory only tells its versions apart.
        self.generation += 1;
        self.directory_writer
            .write(self.generation, &self.directory);
    }
}

/// The symbols of one running robot; there is one per robot and place.
///
/// The shared memory lives until the table and all its handles are dropped, and is then removed.
pub struct SymbolTable {
    state: Mutex<State>,
    shared: Arc<Shared>,
    removed_at_start: Removed,
}

impl SymbolTable {
    /// Hands `owner` the writer of its symbol (`T`, `model`), once.
    ///
    /// # Errors
    /// If the table is sealed, the symbol is unknown or of another type or owner, or its writer is
    /// taken.
    pub fn writer<T: Datatype>(&self, owner: &str, model: &str) -> Result<Writer<T>, SymbolError> {
        let mut state = self.lock();
        let row = state.look_up::<T>(owner, model)?;
        let found = state.directory.owner(row);
        if found != owner {
            return Err(SymbolError::NotOwner {
                asked_by: owner.into(),
                datatype: T::NAME.into(),
                model: model.into(),
                owner: found.into(),
            });
        }
        if state.directory.is_taken(row) {
            return Err(SymbolError::WriterTaken {
                owner: found.into(),
                datatype: T::NAME.into(),
                model: model.into(),
            });
        }
        let handle = self
            .shared
            .port
            .entry::<Stamped<T>>(&row.key())
            .map_err(failed(&self.shared.owner.run, "open a symbol for writing"))?;
        state.directory.set_taken(row);
        state.publish();
        Ok(Writer::new(handle, self.shared.clone()))
    }

    /// Looks up the symbol (`T`, `model`) for the activity `reader`, and notes it as a reader.
    ///
    /// # Errors
    /// If the table is sealed, the symbol is unknown or of another type, or the list of readers is full.
    pub fn reader<T: Datatype>(&self, reader: &str, model: &str) -> Result<Reader<T>, SymbolError> {
        let mut state = self.lock();
        let row = state.look_up::<T>(reader, model)?;
        let handle = self
            .shared
            .blackboard
            .reader
            .entry::<Stamped<T>>(&row.key())
            .map_err(failed(&self.shared.owner.run, "open a symbol for reading"))?;
        state.directory.add_reader(row, reader)?;
        state.publish();
        Ok(Reader::new(handle, self.shared.clone()))
    }

    /// Ends start-up: no more handles are given. Fails if a declared symbol has no writer.
    ///
    /// # Errors
    /// [`SymbolError::NotTaken`] with every such symbol.
    pub fn seal(&self) -> Result<(), SymbolError> {
        let mut state = self.lock();
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
    pub fn directory(&self) -> Vec<SymbolInfo> {
        self.lock().directory.list()
    }

    /// The robot that the table belongs to.
    pub fn robot(&self) -> &str {
        &self.shared.owner.run.robot
    }

    /// What a killed process had left of this robot, and building the table removed.
    pub fn removed_at_start(&self) -> &Removed {
        &self.removed_at_start
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // Every change of the state is complete before anything can panic.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl fmt::Debug for SymbolTable {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "SymbolTable({})", self.robot())
    }
}

impl State {
    fn look_up<T: Datatype>(&self, asked_by: &str, model: &str) -> Result<RowId, SymbolError> {
        if self.sealed {
            return Err(SymbolError::Sealed {
                asked_by: asked_by.into(),
                datatype: T::NAME.into(),
                model: model.into(),
            });
        }
        self.directory.look_up::<T>(asked_by, model)
    }
}
