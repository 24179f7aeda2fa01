//! A thread on the bench: what it needs to run in a test, and what it reports.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use coordination::symbols::{Namespace, Reader, SymbolTable, TableBuilder, Writer};
use tempfile::TempDir;

use super::runner::{ThreadSetup, Trigger};
use crate::realtime::log;
use crate::realtime::panic::Panicked;
use crate::realtime::scheduling::{CoreClass, Wanted};
use crate::symbols::values::ThreadReport;

/// A thread's report alone in a symbol table of its own.
pub(super) struct Bench {
    pub(super) report: Reader<ThreadReport>,
    pub(super) stop: Arc<AtomicBool>,
    _table: SymbolTable,
    _folder: TempDir,
}

impl Bench {
    pub(super) fn new() -> (Self, Writer<ThreadReport>) {
        let folder = tempfile::tempdir().expect("temporary folder");
        let mut builder = TableBuilder::new("bench", &Namespace::new(folder.path(), "bench_"));
        builder
            .declare::<ThreadReport>("thread", "test")
            .expect("declared");
        let table = builder.build().expect("built");
        let writer = table.writer("thread", "test").expect("writer");
        let bench = Self {
            report: table.reader("bench", "test").expect("reader"),
            stop: Arc::default(),
            _table: table,
            _folder: folder,
        };
        (bench, writer)
    }

    /// A bench, and a thread without priority for it.
    pub(super) fn with_thread(trigger: Trigger) -> (Self, ThreadSetup) {
        let (bench, report) = Self::new();
        let setup = ThreadSetup {
            name: "test".to_owned(),
            trigger,
            wanted: Wanted {
                fifo_priority: None,
                cores: CoreClass::Any,
            },
            report,
            stop: Arc::clone(&bench.stop),
            log: log::queue().0,
            panicked: Panicked::default(),
        };
        (bench, setup)
    }
}

/// Waits until another thread has brought it about.
pub(super) fn wait_for(condition: impl Fn() -> bool) {
    let began = Instant::now();
    while !condition() {
        assert!(began.elapsed() < Duration::from_secs(20), "nothing happens");
        std::thread::sleep(Duration::from_millis(1));
    }
}
