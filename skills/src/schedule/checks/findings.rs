//! What was found so far.

use description::keys::KeyError;

/// Errors, each key once: the same mistake shows in many states.
#[derive(Default)]
pub(super) struct Findings(Vec<KeyError>);

impl Findings {
    pub(super) fn wrong(
        &mut self,
        key: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) {
        let error = KeyError::new(key, found, expected);
        if !self.0.iter().any(|told| told.key == error.key) {
            self.0.push(error);
        }
    }
}

impl IntoIterator for Findings {
    type Item = KeyError;
    type IntoIter = std::vec::IntoIter<KeyError>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}
