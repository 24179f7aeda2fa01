//! What is wrong with a scenario file.

use std::ops::Range;
use std::sync::Arc;

use miette::{Diagnostic, NamedSource, SourceSpan};

/// One thing wrong with a scenario file.
#[derive(Clone, Debug, thiserror::Error, Diagnostic)]
#[error("{place}: {what}")]
pub(super) struct Problem {
    place: String,
    what: String,
    #[source_code]
    text: Arc<NamedSource<String>>,
    #[label("here")]
    span: Option<SourceSpan>,
}

/// Everything wrong with it.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("{} problems in the scenario", .all.len())]
struct Several {
    #[related]
    all: Vec<Problem>,
}

/// The text of a file, and what was found to be wrong with it.
pub(super) struct Complaints {
    file: String,
    text: Arc<NamedSource<String>>,
    all: Vec<Problem>,
}

impl Complaints {
    pub(super) fn about(file: String, text: String) -> Self {
        Self {
            text: Arc::new(NamedSource::new(&file, text)),
            file,
            all: Vec::new(),
        }
    }

    /// `what` says what was found and what was expected; `span` is where, in bytes.
    pub(super) fn push(&mut self, span: Option<Range<usize>>, what: String) {
        let text = self.text.inner();
        let span = span.map(|span| span.start.min(text.len())..span.end.min(text.len()));
        let place = match &span {
            Some(span) => {
                let line = 1 + text.as_bytes()[..span.start]
                    .iter()
                    .filter(|&&byte| byte == b'\n')
                    .count();
                format!("{}:{line}", self.file)
            }
            None => self.file.clone(),
        };
        self.all.push(Problem {
            place,
            what,
            text: Arc::clone(&self.text),
            span: span.map(SourceSpan::from),
        });
    }

    pub(super) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// All of them; there must be one.
    pub(super) fn report(mut self) -> miette::Report {
        match self.all.len() {
            1 => miette::Report::new(self.all.remove(0)),
            _ => miette::Report::new(Several { all: self.all }),
        }
    }
}
