//! Where a value lies that one thread writes and others read.

use std::sync::{Arc, Mutex, PoisonError, RwLock};

use arc_swap::ArcSwap;
use coordination::symbols::{Datatype, SymbolTable, TableBuilder};
use onboard::cli::Failure;
use onboard::process::runtime::Runtime;

use crate::folder::Folder;

/// Writes a value.
pub(super) type Write<T> = Box<dyn FnMut(&T) + Send>;
/// Reads a value.
pub(super) type Read<T> = Box<dyn FnMut() -> T + Send>;
/// The ends of who writes and of those who read, and what is kept as long as they are used.
pub(super) type Ends<T, S> = (Write<T>, Vec<Read<T>>, S);

/// Where a value lies that one writes and others read.
pub(super) trait Store<T>: Send + 'static {
    /// What it is called.
    const NAME: &'static str;

    /// Its ends, with this value in it.
    ///
    /// # Errors
    /// [`Failure`] when there is no such place.
    fn ends(value: T, readers: usize) -> Result<Ends<T, Self>, Failure>
    where
        Self: Sized;
}

/// The symbol table.
pub(super) struct Symbols {
    _table: SymbolTable,
    _folder: Folder,
}

impl<T: Datatype> Store<T> for Symbols {
    const NAME: &'static str = "symbol table";

    fn ends(value: T, readers: usize) -> Result<Ends<T, Self>, Failure> {
        let folder = Folder::new()?;
        let place = Runtime::new(Some(folder.path().to_owned()))?.place();
        let mut builder = TableBuilder::new("bench", &place);
        builder
            .declare::<T>("writer", "bench")
            .map_err(Failure::refused)?;
        let table = builder.build().map_err(Failure::refused)?;
        let mut writer = table
            .writer::<T>("writer", "bench")
            .map_err(Failure::refused)?;
        writer.write(1, &value);
        let reads = (0..readers).map(|number| {
            let name = format!("reader-{number}");
            let mut reader = table
                .reader::<T>(&name, "bench")
                .map_err(Failure::refused)?;
            Ok(Box::new(move || reader.read().value) as Read<T>)
        });
        let reads = reads.collect::<Result<_, Failure>>()?;
        let write = Box::new(move |value: &T| writer.write(2, value));
        let store = Self {
            _table: table,
            _folder: folder,
        };
        Ok((write, reads, store))
    }
}

/// `std::sync::Mutex`.
pub(super) struct Locked;

impl<T: Datatype> Store<T> for Locked {
    const NAME: &'static str = "Mutex";

    fn ends(value: T, readers: usize) -> Result<Ends<T, Self>, Failure> {
        let shared = Arc::new(Mutex::new(value));
        let read = |own: Arc<Mutex<T>>| {
            Box::new(move || *own.lock().unwrap_or_else(PoisonError::into_inner)) as Read<T>
        };
        let reads = (0..readers).map(|_| read(Arc::clone(&shared))).collect();
        let write = Box::new(move |value: &T| {
            *shared.lock().unwrap_or_else(PoisonError::into_inner) = *value;
        });
        Ok((write, reads, Self))
    }
}

/// `std::sync::RwLock`.
pub(super) struct ReadWriteLocked;

impl<T: Datatype> Store<T> for ReadWriteLocked {
    const NAME: &'static str = "RwLock";

    fn ends(value: T, readers: usize) -> Result<Ends<T, Self>, Failure> {
        let shared = Arc::new(RwLock::new(value));
        let read = |own: Arc<RwLock<T>>| {
            Box::new(move || *own.read().unwrap_or_else(PoisonError::into_inner)) as Read<T>
        };
        let reads = (0..readers).map(|_| read(Arc::clone(&shared))).collect();
        let write = Box::new(move |value: &T| {
            *shared.write().unwrap_or_else(PoisonError::into_inner) = *value;
        });
        Ok((write, reads, Self))
    }
}

/// `arc-swap`: a write allocates, which no real-time thread may.
pub(super) struct Swapped;

impl<T: Datatype> Store<T> for Swapped {
    const NAME: &'static str = "arc-swap";

    fn ends(value: T, readers: usize) -> Result<Ends<T, Self>, Failure> {
        let shared = Arc::new(ArcSwap::from_pointee(value));
        let read = |own: Arc<ArcSwap<T>>| Box::new(move || **own.load()) as Read<T>;
        let reads = (0..readers).map(|_| read(Arc::clone(&shared))).collect();
        let write = Box::new(move |value: &T| shared.store(Arc::new(*value)));
        Ok((write, reads, Self))
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;
    use crate::bench::symbols::Small;

    #[test]
    fn a_symbol_table_leaves_no_shared_memory() {
        let ends = Symbols::ends(Small::zeroed(), 1);
        let Ok((write, reads, store)) = ends else {
            panic!("no symbol table")
        };
        let folder = store._folder.path().to_owned();
        let runtime = Runtime::new(Some(folder.clone()));
        let prefix = runtime.expect("a folder").place().prefix;
        let is_there = || {
            let entries = std::fs::read_dir("/dev/shm").into_iter().flatten();
            let mut names = entries.flatten().map(|entry| entry.file_name());
            names.any(|name| name.to_string_lossy().starts_with(&prefix))
        };
        assert!(is_there());
        drop((write, reads, store));
        assert!(!is_there() && !folder.exists());
    }
}
