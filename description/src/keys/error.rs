//! What is wrong with a value, by its key.

use std::fmt;

/// A value that does not fit: which key, what was found, what was expected.
///
/// Code that gives a value its meaning judges it and answers with the key's full path; who has the file adds name and
/// line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyError {
    /// The full key, such as `tubes.omega_steps`.
    pub key: String,
    /// What was found.
    pub found: String,
    /// What was expected.
    pub expected: String,
}

impl KeyError {
    /// An error at one key.
    #[must_use]
    pub fn new(
        key: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self {
            key: key.into(),
            found: found.into(),
            expected: expected.into(),
        }
    }

    /// A name that nothing has, at the key that says it.
    #[must_use]
    pub fn unknown(key: impl Into<String>, what: &str, name: &str) -> Self {
        let found = format!("{what} `{name}`, which does not exist");
        Self::new(key, found, format!("the name of {}", article(what)))
    }

    /// The same below a section: `omega_steps` below `tubes` is `tubes.omega_steps`.
    #[must_use]
    pub fn below(mut self, section: &str) -> Self {
        self.key = format!("{section}.{}", self.key);
        self
    }
}

/// What is wrong with several keys, each told once; never empty.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyErrors(Vec<KeyError>);

impl KeyErrors {
    /// `Ok` when there is none.
    ///
    /// # Errors
    /// All of them.
    pub fn any(errors: impl IntoIterator<Item = KeyError>) -> Result<(), Self> {
        let mut own = Vec::new();
        for error in errors {
            if !own.contains(&error) {
                own.push(error);
            }
        }
        if own.is_empty() {
            Ok(())
        } else {
            Err(Self(own))
        }
    }
}

impl From<KeyError> for KeyErrors {
    fn from(error: KeyError) -> Self {
        Self(vec![error])
    }
}

impl IntoIterator for KeyErrors {
    type Item = KeyError;
    type IntoIter = std::vec::IntoIter<KeyError>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl fmt::Display for KeyErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, error) in self.0.iter().enumerate() {
            write!(f, "{}{error}", if index == 0 { "" } else { "; " })?;
        }
        Ok(())
    }
}

impl std::error::Error for KeyErrors {}

/// The noun with its article.
#[must_use]
pub fn article(noun: &str) -> String {
    let an = noun.starts_with(['a', 'e', 'i', 'o']);
    format!("{} {noun}", if an { "an" } else { "a" })
}

impl fmt::Display for KeyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            key,
            found,
            expected,
        } = self;
        write!(f, "{key}: found {found}, expected {expected}")
    }
}

impl std::error::Error for KeyError {}
