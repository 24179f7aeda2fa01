//! The view from outside: any process of the same user can list and read a robot's symbols.

use std::fmt;
use std::sync::Arc;
use std::sync::{Mutex, PoisonError};

use super::blackboard::{Blackboard, failed};
use super::directory::{DECLARED, DIRECTORY_KEY, Directory, FORMAT};
use super::entry::Reader;
use super::lock::{self, Seen};
use super::page::Page;
use super::sweep;
use super::table_run::TableRun;
use super::{Datatype, Namespace, SymbolError, SymbolInfo};

/// Who asks, in the error messages of an inspector.
const ASKED_BY: &str = "inspector";

/// A robot's symbols seen from another process, read-only by its interface.
///
/// It does not keep the robot from ending: then its readers keep the last values, and
/// [`is_alive`](Self::is_alive) turns false.
pub struct Inspector {
    directory: Mutex<Reader<Directory>>,
    pid: u32,
    shared: Arc<Shared>,
}

struct Shared {
    blackboard: Blackboard,
    visit: Visit,
}

/// Dropped last; removes what this process added to a run whose owner is gone.
struct Visit(TableRun);

impl Visit {
    /// Whether the owner of this run certainly lives, or certainly does not.
    fn is_alive(&self) -> Option<bool> {
        match lock::look(&self.0.root, &self.0.robot).ok()? {
            Seen::Alive(content) => Some(content.word? == self.0.word),
            Seen::Absent | Seen::Dead(_) => Some(false),
        }
    }
}

impl Drop for Visit {
    fn drop(&mut self) {
        if self.is_alive() == Some(false) {
            // Nobody else would remove it; an error has nobody to go to.
            let _ = sweep::remove_run(&self.0);
        }
    }
}

impl Inspector {
    /// Opens the symbols of `robot` while it runs. Not for real-time threads.
    ///
    /// # Errors
    /// If the robot does not run, is still starting, was built with another directory format or for another width of pointers, or its
    /// shared memory cannot be opened.
    pub fn open(robot: &str, place: &Namespace) -> Result<Self, SymbolError> {
        place.check(robot)?;
        let not_running = |dead_pid| SymbolError::NotRunning {
            robot: robot.into(),
            root: place.root.clone(),
            dead_pid,
        };
        let Some(root) = place.existing_root()? else {
            return Err(not_running(None));
        };
        let content = match lock::look(&root, robot)? {
            Seen::Absent => return Err(not_running(None)),
            Seen::Dead(content) => return Err(not_running(content.pid)),
            Seen::Alive(content) => content,
        };
        let (Some(pid), Some(word), true) = (content.pid, content.word, content.ready) else {
            return Err(SymbolError::StillStarting {
                robot: robot.into(),
                pid: content.pid,
            });
        };
        // Shared memory has counters and offsets as wide as a pointer: those of another width would be read as nonsense.
        let bits = content.bits.unwrap_or_default();
        if bits != usize::BITS {
            return Err(SymbolError::OtherWidth {
                robot: robot.into(),
                pid,
                found: bits,
                expected: usize::BITS,
            });
        }
        let run = TableRun::of(&root, robot, &word);
        let visit = Visit(run.clone());
        let blackboard = match Blackboard::open(&run, place) {
            Ok(blackboard) => blackboard,
            // It may just have ended.
            Err(_) if visit.is_alive() == Some(false) => return Err(not_running(None)),
            Err(error) => return Err(error),
        };
        let handle = blackboard
            .reader
            .entry(&DIRECTORY_KEY)
            .map_err(failed(&run, "open the directory"))?;
        let shared = Arc::new(Shared { blackboard, visit });
        let mut directory = Reader::<Directory>::new(handle, None, Box::new(Arc::clone(&shared)));
        let found = directory.read().value.format;
        if found != FORMAT {
            return Err(SymbolError::OtherFormat {
                robot: robot.into(),
                found,
                expected: FORMAT,
            });
        }
        Ok(Self {
            directory: Mutex::new(directory),
            pid,
            shared,
        })
    }

    /// All symbols, in the order of their declaration.
    pub fn directory(&self) -> Vec<SymbolInfo> {
        self.read_directory().list()
    }

    /// Whether the robot has finished its start-up, so that the directory is complete.
    pub fn is_sealed(&self) -> bool {
        self.read_directory().sealed != 0
    }

    /// A reader of the symbol (`T`, `model`). The directory does not list it.
    ///
    /// # Errors
    /// If nobody owns the symbol, also if it was removed just now, or its type differs.
    pub fn reader<T: Datatype>(&self, model: &str) -> Result<Reader<T>, SymbolError> {
        let run = &self.shared.visit.0;
        let mut missed = None;
        loop {
            let directory = self.read_directory();
            let row = directory.look_up::<T>(ASKED_BY, model)?;
            let number = directory.page(row);
            if number == DECLARED {
                let entry = self.shared.blackboard.reader.entry(&row.key());
                let handle = entry.map_err(failed(run, "open a symbol for reading"))?;
                let hold = Box::new(Arc::clone(&self.shared));
                return Ok(Reader::new(handle, None, hold));
            }
            match (self.added(number), missed) {
                (Ok(reader), _) => return Ok(reader),
                (Err(error), Some(before)) if before == number => return Err(error),
                // It may have been removed since. If it came again, its page is another.
                (Err(_), _) => missed = Some(number),
            }
        }
    }

    /// A reader of an added symbol.
    fn added<T: Datatype>(&self, number: u64) -> Result<Reader<T>, SymbolError> {
        let run = &self.shared.visit.0;
        let page = Page::open(&self.shared.blackboard, run, number)?;
        let (handle, presence) = (page.value::<T>(run)?, page.presence(run)?);
        let hold = Box::new((page, Arc::clone(&self.shared)));
        Ok(Reader::new(handle, Some(presence), hold))
    }

    /// The robot that is looked at.
    pub fn robot(&self) -> &str {
        &self.shared.visit.0.robot
    }

    /// The process that runs, or ran, the robot.
    pub fn pid(&self) -> u32 {
        self.pid
    }

    /// Whether the robot still runs. Opens a file.
    pub fn is_alive(&self) -> bool {
        self.shared.visit.is_alive() == Some(true)
    }

    fn read_directory(&self) -> Box<Directory> {
        let mut reader = self
            .directory
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        Box::new(reader.read().value)
    }
}

impl fmt::Debug for Inspector {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Inspector({}, pid {})", self.robot(), self.pid)
    }
}
