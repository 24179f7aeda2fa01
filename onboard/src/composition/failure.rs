//! Why the program ends with an error, and its exit codes.

use std::io::Write;
use std::process::ExitCode;

/// Exit code for a mistake in files, arguments or names: nothing was started.
pub const EXIT_REFUSED: u8 = 2;
/// Exit code for a failure while running.
pub const EXIT_FAILED: u8 = 1;

/// Why the program ends with an error.
#[derive(Debug)]
pub enum Failure {
    /// Nothing was started: files, arguments or names are wrong.
    Refused(miette::Report),
    /// It failed while running.
    Failed(miette::Report),
}

impl Failure {
    /// A refusal with one sentence.
    pub fn refused(sentence: impl std::fmt::Display) -> Self {
        Self::Refused(miette::miette!("{sentence}"))
    }

    /// A failure with one sentence.
    pub fn failed(sentence: impl std::fmt::Display) -> Self {
        Self::Failed(miette::miette!("{sentence}"))
    }

    /// Prints it and gives the exit code that goes with it.
    #[must_use]
    pub fn print(self) -> ExitCode {
        let (code, report) = match self {
            Self::Refused(report) => (EXIT_REFUSED, report),
            Self::Failed(report) => (EXIT_FAILED, report),
        };
        let _ = writeln!(std::io::stderr(), "{report:?}");
        ExitCode::from(code)
    }
}
