//! What can go wrong while a symbol table is built, opened or removed.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// An error of the symbol table. None comes from reading or writing a value.
#[derive(Debug, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum SymbolError {
    /// A name cannot be used.
    #[error("{what} `{name}` must have 1 to {limit} characters out of {allowed}")]
    BadName {
        what: &'static str,
        name: Box<str>,
        limit: usize,
        allowed: &'static str,
    },
    /// A metamodel is no URI, or a long one.
    #[error("the metamodel `{found}` must be a URI of up to {limit} visible ASCII characters")]
    BadMetamodel { found: Box<str>, limit: usize },
    /// A symbol that was declared at the start was to be removed.
    #[error(
        "{datatype}/{model} was declared before the table was built and stays; only added symbols can be removed"
    )]
    NotAdded { datatype: Box<str>, model: Box<str> },
    /// A semantic id was declared twice.
    #[error(
        "symbol {datatype}/{model} is declared by `{first}` and again by `{second}`; it can have one owner"
    )]
    Duplicate {
        datatype: Box<str>,
        model: Box<str>,
        first: Box<str>,
        second: Box<str>,
    },
    /// More than fits into the directory.
    #[error("there are more than {limit} {what}")]
    TooMany { what: &'static str, limit: usize },
    /// A table without symbols was to be built.
    #[error("robot `{robot}` declares no symbol")]
    NothingDeclared { robot: Box<str> },
    /// The robot's table exists already, in this process or another one.
    #[error("robot `{robot}` already runs ({})", pid_text(*pid))]
    AlreadyRuns {
        robot: Box<str>,
        /// The process that owns it, once that has written it down.
        pid: Option<u32>,
    },
    /// The robot does not run in this place.
    #[error("robot `{robot}` does not run in {}{}", root.display(), left_behind(*dead_pid))]
    NotRunning {
        robot: Box<str>,
        root: PathBuf,
        /// The process that ended without cleaning up, if one did.
        dead_pid: Option<u32>,
    },
    /// The robot has been started and its table is not yet built.
    #[error("robot `{robot}` is still starting ({})", pid_text(*pid))]
    StillStarting {
        robot: Box<str>,
        /// The process that starts it, once that has written it down.
        pid: Option<u32>,
    },
    /// No symbol has this semantic id, nor one with the same model.
    #[error("`{asked_by}` asks for {datatype}/{model}, which nobody owns; there are: {known}")]
    Unknown {
        asked_by: Box<str>,
        datatype: Box<str>,
        model: Box<str>,
        known: Box<str>,
    },
    /// The model exists with another datatype.
    #[error(
        "`{asked_by}` asks for {datatype}/{model}, but `{owner}` owns {found}/{model}; there are: {known}"
    )]
    Mistyped {
        asked_by: Box<str>,
        datatype: Box<str>,
        model: Box<str>,
        found: Box<str>,
        owner: Box<str>,
        known: Box<str>,
    },
    /// The datatype is understood by another metamodel than the one who asks conforms to.
    #[error(
        "`{asked_by}` reads {datatype}/{model} by the metamodel `{expected}`, but `{owner}` writes it by `{found}`"
    )]
    OtherMetamodel {
        asked_by: Box<str>,
        datatype: Box<str>,
        model: Box<str>,
        owner: Box<str>,
        expected: Box<str>,
        found: Box<str>,
    },
    /// Two types of different sizes claim the same datatype name.
    #[error(
        "`{asked_by}` reads {datatype}/{model} as {expected_bytes} bytes, but `{owner}` writes {found_bytes} bytes"
    )]
    OtherLayout {
        asked_by: Box<str>,
        datatype: Box<str>,
        model: Box<str>,
        owner: Box<str>,
        expected_bytes: usize,
        found_bytes: usize,
    },
    /// Somebody else than the owner wants to write.
    #[error("`{asked_by}` wants to write {datatype}/{model}, which `{owner}` owns")]
    NotOwner {
        asked_by: Box<str>,
        datatype: Box<str>,
        model: Box<str>,
        owner: Box<str>,
    },
    /// The one writer of a symbol was handed out, and not dropped since.
    #[error("`{owner}` took the writer of {datatype}/{model} twice")]
    WriterTaken {
        owner: Box<str>,
        datatype: Box<str>,
        model: Box<str>,
    },
    /// Owners declared symbols and never took their writers.
    #[error("declared but not owned, because their writers were never taken: {symbols}")]
    NotTaken { symbols: Box<str> },
    /// The table is sealed: start-up is over.
    #[error("`{asked_by}` asks for {datatype}/{model} after the table was sealed")]
    Sealed {
        asked_by: Box<str>,
        datatype: Box<str>,
        model: Box<str>,
    },
    /// The directory in shared memory is of another version of this program.
    #[error(
        "robot `{robot}` keeps its symbols in format {found}, this program reads format {expected}"
    )]
    OtherFormat {
        robot: Box<str>,
        found: u32,
        expected: u32,
    },
    /// The robot's program was built for a processor of another width.
    #[error(
        "robot `{robot}` (pid {pid}) is a program of {found} bits, and this one has {expected}: they cannot share memory; use the \
         program of the robot's own package"
    )]
    OtherWidth {
        robot: Box<str>,
        pid: u32,
        found: u32,
        expected: u32,
    },
    /// The root folder's path leaves no room for the names below it.
    #[error("the path {} is longer than {limit} bytes or not plain text", root.display())]
    BadRoot { root: PathBuf, limit: usize },
    /// A file or folder could not be used.
    #[error("cannot {doing} {}: {source}", path.display())]
    File {
        doing: &'static str,
        path: PathBuf,
        source: io::Error,
    },
    /// The shared memory could not be used.
    #[error("robot `{robot}`: cannot {doing}: {reason}")]
    SharedMemory {
        robot: Box<str>,
        doing: &'static str,
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
