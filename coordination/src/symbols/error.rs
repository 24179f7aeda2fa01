//! What can go wrong while a symbol table is built, opened or removed.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// An error of the symbol table. None comes from reading or writing a value.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SymbolError {
    /// A name cannot be used.
    #[error("{what} `{name}` must have 1 to {limit} characters out of {allowed}")]
    BadName {
        /// What the name is for.
        what: &'static str,
        /// The name.
        name: Box<str>,
        /// How long it may be.
        limit: usize,
        /// What it may consist of.
        allowed: &'static str,
    },
    /// A semantic id was declared twice.
    #[error(
        "symbol {datatype}/{model} is declared by `{first}` and again by `{second}`; it can have one owner"
    )]
    Duplicate {
        /// The datatype of both.
        datatype: Box<str>,
        /// The model of both.
        model: Box<str>,
        /// Who declared it first.
        first: Box<str>,
        /// Who declared it again.
        second: Box<str>,
    },
    /// More than fits into the directory.
    #[error("there are more than {limit} {what}")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many fit.
        limit: usize,
    },
    /// A table without symbols was to be built.
    #[error("robot `{robot}` declares no symbol")]
    NothingDeclared {
        /// The robot.
        robot: Box<str>,
    },
    /// The robot's table exists already, in this process or another one.
    #[error("robot `{robot}` already runs ({})", pid_text(*pid))]
    AlreadyRuns {
        /// The robot.
        robot: Box<str>,
        /// The process that owns it, once that has written it down.
        pid: Option<u32>,
    },
    /// The robot does not run in this place.
    #[error("robot `{robot}` does not run in {}{}", root.display(), left_behind(*dead_pid))]
    NotRunning {
        /// The robot.
        robot: Box<str>,
        /// The root folder of the place.
        root: PathBuf,
        /// The process that ended without cleaning up, if one did.
        dead_pid: Option<u32>,
    },
    /// The robot has been started and its table is not yet built.
    #[error("robot `{robot}` is still starting ({})", pid_text(*pid))]
    StillStarting {
        /// The robot.
        robot: Box<str>,
        /// The process that starts it, once that has written it down.
        pid: Option<u32>,
    },
    /// No symbol has this semantic id, nor one with the same model.
    #[error("`{asked_by}` asks for {datatype}/{model}, which nobody owns; there are: {known}")]
    Unknown {
        /// Who asked.
        asked_by: Box<str>,
        /// The datatype asked for.
        datatype: Box<str>,
        /// The model asked for.
        model: Box<str>,
        /// What exists, for the message.
        known: Box<str>,
    },
    /// The model exists with another datatype.
    #[error(
        "`{asked_by}` asks for {datatype}/{model}, but `{owner}` owns {found}/{model}; there are: {known}"
    )]
    Mistyped {
        /// Who asked.
        asked_by: Box<str>,
        /// The datatype asked for.
        datatype: Box<str>,
        /// The model asked for.
        model: Box<str>,
        /// The datatype of the symbol that exists.
        found: Box<str>,
        /// Who owns that.
        owner: Box<str>,
        /// What exists, for the message.
        known: Box<str>,
    },
    /// Two types of different sizes claim the same datatype name.
    #[error(
        "`{asked_by}` reads {datatype}/{model} as {expected_bytes} bytes, but `{owner}` writes {found_bytes} bytes"
    )]
    OtherLayout {
        /// Who asked.
        asked_by: Box<str>,
        /// The datatype of both.
        datatype: Box<str>,
        /// The model of both.
        model: Box<str>,
        /// Who owns the symbol.
        owner: Box<str>,
        /// The size of the type asked for.
        expected_bytes: usize,
        /// The size of the type declared.
        found_bytes: usize,
    },
    /// Somebody else than the owner wants to write.
    #[error("`{asked_by}` wants to write {datatype}/{model}, which `{owner}` owns")]
    NotOwner {
        /// Who asked.
        asked_by: Box<str>,
        /// The symbol's datatype.
        datatype: Box<str>,
        /// The symbol's model.
        model: Box<str>,
        /// The owner.
        owner: Box<str>,
    },
    /// The one writer of a symbol was already handed out.
    #[error("`{owner}` took the writer of {datatype}/{model} twice")]
    WriterTaken {
        /// The owner.
        owner: Box<str>,
        /// The symbol's datatype.
        datatype: Box<str>,
        /// The symbol's model.
        model: Box<str>,
    },
    /// Owners declared symbols and never took their writers.
    #[error("declared but not owned, because their writers were never taken: {symbols}")]
    NotTaken {
        /// The symbols, for the message.
        symbols: Box<str>,
    },
    /// The table is sealed: start-up is over.
    #[error("`{asked_by}` asks for {datatype}/{model} after the table was sealed")]
    Sealed {
        /// Who asked.
        asked_by: Box<str>,
        /// The datatype asked for.
        datatype: Box<str>,
        /// The model asked for.
        model: Box<str>,
    },
    /// The directory in shared memory is of another version of this program.
    #[error(
        "robot `{robot}` keeps its symbols in format {found}, this program reads format {expected}"
    )]
    OtherFormat {
        /// The robot.
        robot: Box<str>,
        /// The format found.
        found: u32,
        /// The format expected.
        expected: u32,
    },
    /// The root folder's path leaves no room for the names below it.
    #[error("the path {} is longer than {limit} bytes or not plain text", root.display())]
    BadRoot {
        /// The root folder.
        root: PathBuf,
        /// How many bytes it may have.
        limit: usize,
    },
    /// A file or folder could not be used.
    #[error("cannot {doing} {}: {source}", path.display())]
    File {
        /// What was tried.
        doing: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The shared memory could not be used.
    #[error("robot `{robot}`: cannot {doing}: {reason}")]
    SharedMemory {
        /// The robot.
        robot: Box<str>,
        /// What was tried.
        doing: &'static str,
        /// What iceoryx2 said.
        reason: Box<str>,
    },
}

fn pid_text(pid: Option<u32>) -> String {
    pid.map_or_else(|| "pid unknown".to_owned(), |pid| format!("pid {pid}"))
}

fn left_behind(dead_pid: Option<u32>) -> String {
    dead_pid.map_or_else(String::new, |pid| {
        format!(" (pid {pid} ended without cleaning up)")
    })
}
