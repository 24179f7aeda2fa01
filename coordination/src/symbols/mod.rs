//! The symbol table (the paper's Section 3.3): what the activities of a robot share, in shared
//! memory.
//!
//! A symbol is one plain value with a time stamp. Its [`SemanticId`] is datatype and model, for example `encoders` / `drive`, which
//! are unique together, and the metamodel that the datatype conforms to, a URI; exactly one activity owns it and writes it, any
//! number reads it. Start-up has two phases: owners [declare](TableBuilder::declare), the table is
//! [built](TableBuilder::build), then owners take their [`Writer`] and others look up a [`Reader`].
//! [`SymbolTable::seal`] ends it.
//!
//! **Acquire and release.** Every handle is a run of that [pattern](crate::acquire_release), whose owner is the table: it grants the one writer
//! of a symbol to its owner, or refuses it while it is held, and grants readers to all who ask. Dropping a handle releases it; removing
//! a symbol takes it from all who have it. The directory shows who reads now.
//!
//! **While the robot runs**, a thread that is not a real-time one can [add](SymbolTable::add) symbols and
//! [remove](SymbolTable::remove) them, also after the table was sealed: seal fixes who uses the declared symbols, which is all that
//! real-time threads use. An added symbol has a page of shared memory of its own, which the directory names, so that handles of other
//! symbols are not touched. A reader of a removed symbol is [told](Reader::is_removed), and the page is freed with the last handle.
//! What an inspector that was killed had open stays until the robot ends.
//!
//! Any other process of the same user can look into a running robot with an [`Inspector`]; other
//! users can neither read nor write any of it. One robot id runs once per [`Namespace`]. The shared
//! memory disappears with the table; what a killed process left behind is removed by the next start,
//! or by [`remove_stale`].
//!
//! **Real time:** [`Writer::write`] and [`Reader::read`] do not allocate, lock, wait or make a
//! system call. A writer never waits for readers. A reader that meets a write reads again, which
//! [`Reader::retries`] counts. Everything else in this module is for start-up and shutdown.
//!
//! **Not for** queues (a reader sees the newest value only), nor for values with pointers.
//!
//! ```
//! use coordination::symbols::{Datatype, Inspector, Namespace, TableBuilder};
//!
//! #[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
//! #[repr(C)]
//! struct Encoders {
//!     left_rad: f64,
//!     right_rad: f64,
//! }
//! impl Datatype for Encoders {
//!     const NAME: &'static str = "encoders";
//! }
//!
//! # let folder = tempfile::tempdir().expect("a temporary folder");
//! # let run_folder = folder.path();
//! let place = Namespace::new(run_folder, "robots_");
//! let mut builder = TableBuilder::new("amr1", &place);
//! builder.declare::<Encoders>("drive", "drive")?;
//! let table = builder.build()?;
//! let mut writer = table.writer::<Encoders>("drive", "drive")?;
//! let mut reader = table.reader::<Encoders>("proprioception", "drive")?;
//! table.seal()?;
//!
//! assert_eq!(reader.read().stamp_ns, 0, "never written");
//! writer.write(17, &Encoders { left_rad: 1.0, right_rad: 2.0 });
//! assert_eq!(reader.read().value.right_rad, 2.0);
//!
//! let inspector = Inspector::open("amr1", &place)?; // in any process
//! assert_eq!(inspector.directory()[0].readers, ["proprioception"]);
//! # Ok::<(), coordination::symbols::SymbolError>(())
//! ```

mod access;
mod blackboard;
mod datatype;
mod directory;
mod entry;
mod error;
mod held;
mod inspector;
mod lock;
mod namespace;
mod owner;
mod page;
mod service;
mod sweep;
mod table;
mod table_run;

pub use datatype::{Datatype, METAMODEL, SemanticId, Stamped};
pub use directory::SymbolInfo;
pub use entry::{Reader, Writer};
pub use error::SymbolError;
pub use inspector::Inspector;
pub use namespace::Namespace;
pub use sweep::{Removed, remove_all_stale, remove_stale};
pub use table::{SymbolTable, TableBuilder};
