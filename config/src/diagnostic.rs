//! One shape for everything that can be wrong with a file: file, line, key,
//! what was found, what was expected.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};

use crate::spot::{Source, line_of};

/// What sort of problem it is; shown as the diagnostic's code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProblemKind {
    /// The file cannot be read.
    File,
    /// The text is not TOML.
    Syntax,
    /// A key that means nothing.
    UnknownKey,
    /// A key that must be there.
    MissingKey,
    /// A value of another type.
    WrongType,
    /// A value outside what is possible.
    OutOfRange,
    /// The same thing named twice.
    Duplicate,
    /// A name that refers to nothing.
    UnknownReference,
    /// Values that do not fit together.
    Inconsistent,
    /// An override that is not `key=value`, or whose key belongs to no file.
    Override,
}

impl ProblemKind {
    const fn code(self) -> &'static str {
        match self {
            ProblemKind::File => "config::file",
            ProblemKind::Syntax => "config::syntax",
            ProblemKind::UnknownKey => "config::unknown_key",
            ProblemKind::MissingKey => "config::missing_key",
            ProblemKind::WrongType => "config::wrong_type",
            ProblemKind::OutOfRange => "config::out_of_range",
            ProblemKind::Duplicate => "config::duplicate",
            ProblemKind::UnknownReference => "config::unknown_reference",
            ProblemKind::Inconsistent => "config::inconsistent",
            ProblemKind::Override => "config::override",
        }
    }
}

/// Texts with longer lines are not quoted in errors.
const LONGEST_SHOWN_LINE: usize = 1000;

/// One thing wrong with a file or an override.
#[derive(Clone, Debug)]
pub struct Problem {
    /// What sort of problem.
    pub kind: ProblemKind,
    /// The file, or the override as it was typed.
    pub file: String,
    /// The line in the file; none for an override or an unreadable file.
    pub line: Option<usize>,
    /// The full key, such as `drive.wheelbase_m`.
    pub key: String,
    /// What was there.
    pub found: String,
    /// What should have been there.
    pub expected: String,
    /// What to do about it, where that can be guessed.
    pub hint: Option<String>,
    source: Option<Arc<NamedSource<String>>>,
    labels: Vec<LabeledSpan>,
}

impl Problem {
    pub(crate) fn new(
        kind: ProblemKind,
        key: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self {
            kind,
            file: String::new(),
            line: None,
            key: key.into(),
            found: found.into(),
            expected: expected.into(),
            hint: None,
            source: None,
            labels: Vec::new(),
        }
    }

    pub(crate) fn in_file(mut self, file: impl Into<String>) -> Self {
        self.file = file.into();
        self
    }

    pub(crate) fn place(&mut self, source: &Source, span: Range<usize>) {
        let text = source.text.inner();
        let (start, end) = (span.start.min(text.len()), span.end.min(text.len()));
        self.file = source.text.name().to_owned();
        self.line = source.is_file.then(|| line_of(text, start));
        // The printer cannot indent that far, and nobody would read it.
        if text.lines().any(|line| line.len() > LONGEST_SHOWN_LINE) {
            return;
        }
        self.labels = vec![LabeledSpan::new_primary_with_span(
            Some("here".to_owned()),
            start..end.max(start),
        )];
        self.source = Some(Arc::clone(&source.text));
    }

    pub(crate) fn with_also(mut self, source: &Source, span: Range<usize>, label: &str) -> Self {
        if self
            .source
            .as_ref()
            .is_some_and(|own| Arc::ptr_eq(own, &source.text))
        {
            self.labels
                .push(LabeledSpan::new_with_span(Some(label.to_owned()), span));
        }
        self
    }

    /// The same problem with advice.
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if !self.key.is_empty() {
            write!(f, ": {}", self.key)?;
        }
        write!(f, ": found {}, expected {}", self.found, self.expected)
    }
}

impl std::error::Error for Problem {}

impl Diagnostic for Problem {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(self.kind.code()))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.hint
            .as_ref()
            .map(|hint| Box::new(hint) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|source| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        (!self.labels.is_empty())
            .then(|| Box::new(self.labels.iter().cloned()) as Box<dyn Iterator<Item = LabeledSpan>>)
    }
}

/// Everything that is wrong, in the order of the file.
///
/// As a [`Diagnostic`] it prints all of it; a single problem prints as itself.
#[derive(Clone, Debug)]
pub struct ConfigError {
    problems: Vec<Problem>,
    omitted: usize,
}

impl ConfigError {
    pub(crate) fn new(mut problems: Vec<Problem>, omitted: usize) -> Self {
        problems.sort_by(|a, b| (&a.file, a.line).cmp(&(&b.file, b.line)));
        Self { problems, omitted }
    }

    /// What is wrong; never empty.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// Two errors as one, so that a robot's and a site's problems print together.
    #[must_use]
    pub fn and(mut self, other: ConfigError) -> ConfigError {
        self.problems.extend(other.problems);
        self.omitted += other.omitted;
        self
    }

    fn single(&self) -> Option<&Problem> {
        match self.problems.as_slice() {
            [only] if self.omitted == 0 => Some(only),
            _ => None,
        }
    }
}

impl From<Problem> for ConfigError {
    fn from(problem: Problem) -> Self {
        Self {
            problems: vec![problem],
            omitted: 0,
        }
    }
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(problem) = self.single() {
            return problem.fmt(f);
        }
        let count = self.problems.len() + self.omitted;
        write!(f, "{count} problems in the configuration")?;
        if self.omitted > 0 {
            write!(f, ", the first {} are shown", self.problems.len())?;
        }
        Ok(())
    }
}

impl std::error::Error for ConfigError {}

impl Diagnostic for ConfigError {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.single()?.code()
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.single()?.help()
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.single()?.source_code()
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.single()?.labels()
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        match self.single() {
            Some(_) => None,
            None => Some(Box::new(
                self.problems
                    .iter()
                    .map(|problem| problem as &dyn Diagnostic),
            )),
        }
    }
}
