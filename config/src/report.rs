//! Collects every problem of a file while it is read and checked.

use std::cell::{Cell, RefCell};

use crate::diagnostic::{ConfigError, Problem, ProblemKind};
use crate::origin::Origin;

/// More problems than this help nobody.
pub(crate) const MOST_PROBLEMS: usize = 100;

/// Collects problems.
pub(crate) struct Report {
    pub(crate) origin: Origin,
    problems: RefCell<Vec<Problem>>,
    omitted: Cell<usize>,
}

impl Report {
    pub(crate) fn new(origin: Origin) -> Self {
        Self {
            origin,
            problems: RefCell::default(),
            omitted: Cell::new(0),
        }
    }

    pub(crate) fn push(&self, problem: Problem) {
        let mut problems = self.problems.borrow_mut();
        if problems.len() < MOST_PROBLEMS {
            problems.push(problem);
        } else {
            self.omitted.set(self.omitted.get() + 1);
        }
    }

    /// Whether further problems are only counted.
    pub(crate) fn is_full(&self) -> bool {
        self.problems.borrow().len() >= MOST_PROBLEMS
    }

    /// Whether any of these keys, or a key above or below one of them, already has a problem.
    pub(crate) fn touched(&self, keys: &[&str]) -> bool {
        let below = |key: &str, outer: &str| {
            key.strip_prefix(outer)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        self.problems.borrow().iter().any(|problem| {
            keys.iter()
                .any(|key| below(&problem.key, key) || below(key, &problem.key))
        })
    }

    /// Pushes a problem that needs no more than this.
    pub(crate) fn wrong(
        &self,
        kind: ProblemKind,
        key: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) {
        self.push(self.problem(kind, key, found, expected));
    }

    /// A problem ready to be refined and pushed.
    pub(crate) fn problem(
        &self,
        kind: ProblemKind,
        key: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Problem {
        if self.is_full() {
            // Finding its line takes time, and it will only be counted.
            return Problem::new(kind, key, found, expected);
        }
        self.origin.problem(kind, key, found, expected)
    }

    /// The value, if nothing was wrong.
    pub(crate) fn finish<T>(self, value: T) -> Result<T, ConfigError> {
        let problems = self.problems.into_inner();
        if problems.is_empty() {
            Ok(value)
        } else {
            Err(ConfigError::new(problems, self.omitted.get()))
        }
    }
}
