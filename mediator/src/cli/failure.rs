//! How a command ends when it did not do what it should.

/// Exit code for a mistake in files, arguments or names: nothing was started.
pub const EXIT_REFUSED: u8 = 2;
/// Exit code for a failure while running.
pub const EXIT_FAILED: u8 = 1;
/// Exit code for a question that was not decided within the bounds of time and memory.
pub const EXIT_UNDECIDED: u8 = 3;

/// Why a command did not do what it should.
#[derive(Debug)]
pub(super) enum Failure {
    /// A mistake in files, arguments or names.
    Refused(String),
    /// The command was right, and did not work.
    Failed(String),
    /// The command was right, and its question is too large to be decided.
    Undecided(String),
}
