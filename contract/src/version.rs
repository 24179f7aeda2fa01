//! The contract's version and the rule by which peers agree.

use crate::wire;
use core::fmt;

/// A version of the contract. Peers with the same major number understand each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Version {
    /// Changes when an older peer could misunderstand.
    pub major: u32,
    /// Changes when something was added.
    pub minor: u32,
}

/// The version this crate speaks.
pub const VERSION: Version = Version { major: 2, minor: 3 };

/// A peer speaks another major version.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "contract version {found} of the peer does not go with ours, {ours}: update the older of the two"
)]
pub struct VersionMismatch {
    /// What the peer said.
    pub found: Version,
    /// What we speak.
    pub ours: Version,
}

impl Version {
    /// Checks that a peer with version `found` can be understood.
    ///
    /// # Errors
    /// [`VersionMismatch`] when the major numbers differ.
    pub fn accept(self, found: Version) -> Result<(), VersionMismatch> {
        if found.major == self.major {
            Ok(())
        } else {
            Err(VersionMismatch { found, ours: self })
        }
    }
}

impl From<Version> for wire::Version {
    fn from(version: Version) -> Self {
        let Version { major, minor } = version;
        Self { major, minor }
    }
}

/// A message without a version says 0.0, which nobody accepts.
impl From<Option<wire::Version>> for Version {
    fn from(version: Option<wire::Version>) -> Self {
        let wire::Version { major, minor } = version.unwrap_or_default();
        Self { major, minor }
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minor_differences_are_fine_and_major_ones_are_refused() {
        assert!(
            VERSION
                .accept(Version {
                    minor: VERSION.minor + 1,
                    ..VERSION
                })
                .is_ok()
        );
        let other = Version {
            major: VERSION.major + 1,
            minor: 0,
        };
        assert_eq!(
            VERSION.accept(other),
            Err(VersionMismatch {
                found: other,
                ours: VERSION
            })
        );
    }

    #[test]
    fn a_message_without_a_version_is_refused() {
        assert!(VERSION.accept(None.into()).is_err());
        let said = wire::Version::from(VERSION);
        assert!(VERSION.accept(Some(said).into()).is_ok());
    }
}
