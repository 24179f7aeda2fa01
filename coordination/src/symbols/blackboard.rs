//! The one file that knows how iceoryx2 is set up.
//!
//! Each run has an iceoryx2 root folder and prefix of its own, so it shares no node, service or
//! management segment with anything else on the machine, and no system-wide configuration file
//! affects it. All of its shared memory is its owner's alone: [`Service`] leaves out the one part
//! that iceoryx2 makes writable by everybody.

use std::fmt::Debug;

use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port;
use iceoryx2::prelude::{
    FileName, LogLevel, Path, SemanticString, ServiceName, SignalHandlingMode,
    set_log_level_from_env_or,
};
use iceoryx2::service::builder::blackboard::Creator;
use iceoryx2::service::port_factory::blackboard::PortFactory;

use super::service::Service;
use super::table_run::TableRun;
use super::{Namespace, SymbolError};

/// The number of a symbol in the directory, from 1; the directory itself is 0.
pub(super) type Key = u64;
pub(super) type Adder = Creator<Key, Service>;
pub(super) type ReaderPort = port::reader::Reader<Service, Key>;
pub(super) type WriterPort = port::writer::Writer<Service, Key>;

/// How many processes, the owner and inspectors, can have the table open at a time.
const MAX_PROCESSES: usize = 64;
const SERVICE_NAME: &str = "symbols";

/// An open blackboard: its node, its service and the reader port that handles come from.
#[derive(Debug)]
pub(super) struct Blackboard {
    pub(super) reader: ReaderPort,
    factory: PortFactory<Service, Key>,
    node: Node<Service>,
}

/// Another blackboard of the same run, for what is added while it is used.
#[derive(Debug)]
pub(super) struct PageBoard {
    pub(super) reader: ReaderPort,
    factory: PortFactory<Service, Key>,
}

impl PageBoard {
    /// The one writing port.
    pub(super) fn writer(&self, run: &TableRun) -> Result<WriterPort, SymbolError> {
        self.factory
            .writer_builder()
            .create()
            .map_err(failed(run, "open the shared memory for writing"))
    }

    fn new(run: &TableRun, factory: PortFactory<Service, Key>) -> Result<Self, SymbolError> {
        let reader = factory
            .reader_builder()
            .create()
            .map_err(failed(run, "open the shared memory for reading"))?;
        Ok(Self { reader, factory })
    }
}

impl Blackboard {
    /// Creates the blackboard with the entries that `fill` adds.
    pub(super) fn create(
        run: &TableRun,
        place: &Namespace,
        fill: impl FnOnce(Adder) -> Adder,
    ) -> Result<Self, SymbolError> {
        let node = node(run, place)?;
        let creator = node
            .service_builder(&service_name(run, SERVICE_NAME)?)
            .blackboard_creator::<Key>()
            .max_nodes(MAX_PROCESSES)
            .max_readers(MAX_PROCESSES);
        let factory = fill(creator)
            .create()
            .map_err(failed(run, "create the shared memory"))?;
        Self::with_reader(run, node, factory)
    }

    /// Opens the blackboard that another process, or this one, created.
    pub(super) fn open(run: &TableRun, place: &Namespace) -> Result<Self, SymbolError> {
        let node = node(run, place)?;
        let factory = node
            .service_builder(&service_name(run, SERVICE_NAME)?)
            .blackboard_opener::<Key>()
            .open()
            .map_err(failed(run, "open the shared memory"))?;
        Self::with_reader(run, node, factory)
    }

    /// Creates the blackboard of page `page` with the entries that `fill` adds.
    pub(super) fn create_page(
        &self,
        run: &TableRun,
        page: u64,
        fill: impl FnOnce(Adder) -> Adder,
    ) -> Result<PageBoard, SymbolError> {
        let creator = { self.node.service_builder(&page_name(run, page)?) }
            .blackboard_creator::<Key>()
            .max_nodes(MAX_PROCESSES)
            .max_readers(MAX_PROCESSES);
        let factory = fill(creator)
            .create()
            .map_err(failed(run, "create the shared memory of an added symbol"))?;
        PageBoard::new(run, factory)
    }

    /// Opens the blackboard of page `page`, which another process has created.
    pub(super) fn open_page(&self, run: &TableRun, page: u64) -> Result<PageBoard, SymbolError> {
        let factory = { self.node.service_builder(&page_name(run, page)?) }
            .blackboard_opener::<Key>()
            .open()
            .map_err(failed(run, "open the shared memory of an added symbol"))?;
        PageBoard::new(run, factory)
    }

    /// The one writing port, from which the owners' handles come.
    pub(super) fn writer(&self, run: &TableRun) -> Result<WriterPort, SymbolError> {
        self.factory
            .writer_builder()
            .create()
            .map_err(failed(run, "open the shared memory for writing"))
    }

    fn with_reader(
        run: &TableRun,
        node: Node<Service>,
        factory: PortFactory<Service, Key>,
    ) -> Result<Self, SymbolError> {
        let reader = factory
            .reader_builder()
            .create()
            .map_err(failed(run, "open the shared memory for reading"))?;
        Ok(Self {
            reader,
            factory,
            node,
        })
    }
}

fn node(run: &TableRun, place: &Namespace) -> Result<Node<Service>, SymbolError> {
    // What it has to say comes back as an error; its log would mix into the robot's.
    set_log_level_from_env_or(LogLevel::Fatal);
    let mut config = Config::default();
    let folder = run.folder();
    let root = Path::new(folder.as_os_str().as_encoded_bytes());
    config
        .global
        .set_root_path(&root.map_err(failed(run, "name the folder of the shared memory"))?);
    let prefix = format!("{}{}_", place.prefix, run.word);
    config.global.prefix =
        FileName::new(prefix.as_bytes()).map_err(failed(run, "name the shared memory"))?;
    NodeBuilder::new()
        .config(&config)
        // The robot handles its signals itself.
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<Service>()
        .map_err(failed(run, "register with the shared memory"))
}

fn service_name(run: &TableRun, name: &str) -> Result<ServiceName, SymbolError> {
    ServiceName::new(name).map_err(failed(run, "name the service"))
}

fn page_name(run: &TableRun, page: u64) -> Result<ServiceName, SymbolError> {
    service_name(run, &format!("{SERVICE_NAME}-{page}"))
}

pub(super) fn failed<E: Debug>(
    run: &TableRun,
    doing: &'static str,
) -> impl FnOnce(E) -> SymbolError {
    let robot = run.robot.as_str().into();
    move |reason| SymbolError::SharedMemory {
        robot,
        doing,
        reason: format!("{reason:?}").into(),
    }
}
