//! The declaration of such a protocol.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

use thiserror::Error;

use super::resource::Resource;
use crate::protocol::{ModelError, Protocol, ProtocolModel};

/// What is wrong with an [`AcquireRelease`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PatternError {
    /// Nothing says how the resource is acquired.
    #[error("protocol `{0}` acquires nothing: it needs the flags of a request and of its grant")]
    NoAcquire(String),
    /// Nothing says how the resource is released.
    #[error("protocol `{0}` releases nothing: it needs the flag of a release")]
    NoRelease(String),
    /// Flags or parties make no protocol.
    #[error(transparent)]
    Model(#[from] ModelError),
}

/// Who sets a flag while the resource is in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// Who has it.
    User,
    /// Whom it belongs to.
    Owner,
}

/// A protocol by which `user` acquires a resource of `owner`, in names. Adding to it never fails; [`compile`](Self::compile) says
/// what is wrong with the whole.
#[derive(Clone, Debug)]
pub struct AcquireRelease {
    name: String,
    user: String,
    owner: String,
    owner_is_first: bool,
    keeper: Option<By>,
    acquire: Option<(String, String)>,
    refused: Option<String>,
    using: Vec<(String, By)>,
    release: Option<String>,
    released: Option<String>,
    returned: Option<String>,
}

impl AcquireRelease {
    /// A protocol without flags between two parties, of which the user is the first.
    pub fn new(name: impl Into<String>, user: impl Into<String>, owner: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            user: user.into(),
            owner: owner.into(),
            owner_is_first: false,
            keeper: None,
            acquire: None,
            refused: None,
            using: Vec::new(),
            release: None,
            released: None,
            returned: None,
        }
    }

    /// Makes the owner the protocol's first party.
    pub fn owner_first(&mut self) -> &mut Self {
        self.owner_is_first = true;
        self
    }

    /// Lets one of the two give up a run at any time; without this nobody may.
    pub fn keeper(&mut self, keeper: By) -> &mut Self {
        self.keeper = Some(keeper);
        self
    }

    /// The user's flag that asks, and the owner's that grants.
    pub fn acquire(&mut self, request: impl Into<String>, granted: impl Into<String>) -> &mut Self {
        self.acquire = Some((request.into(), granted.into()));
        self
    }

    /// The owner's flag that refuses, which ends the run.
    pub fn refuse(&mut self, refused: impl Into<String>) -> &mut Self {
        self.refused = Some(refused.into());
        self
    }

    /// One more flag, behind those declared before, that is set while the user has the resource.
    pub fn using(&mut self, flag: impl Into<String>, by: By) -> &mut Self {
        self.using.push((flag.into(), by));
        self
    }

    /// The user's flag that releases the resource.
    pub fn release(&mut self, release: impl Into<String>) -> &mut Self {
        self.release = Some(release.into());
        self
    }

    /// The owner's flag that confirms a release; without it, the release ends the run.
    pub fn confirm(&mut self, released: impl Into<String>) -> &mut Self {
        self.released = Some(released.into());
        self
    }

    /// The user's flag that gives the resource back, in the place of the first [step of use](Self::using) and all that follows.
    pub fn give_back(&mut self, returned: impl Into<String>) -> &mut Self {
        self.returned = Some(returned.into());
        self
    }

    /// Checks the declaration and makes the protocol. Not for real-time threads.
    ///
    /// # Errors
    /// [`PatternError`]
    pub fn compile(&self) -> Result<Resource, PatternError> {
        let no_acquire = || PatternError::NoAcquire(self.name.clone());
        let (request, granted) = self.acquire.as_ref().ok_or_else(no_acquire)?;
        let no_release = || PatternError::NoRelease(self.name.clone());
        let release = self.release.as_ref().ok_or_else(no_release)?;
        let protocol = self.model(request, granted, release).compile()?;
        let find = |name: &String| {
            let flag = protocol.flag(name);
            flag.expect("every flag is in an array")
        };
        let (granted, release) = (find(granted), find(release));
        let user = protocol.party(&self.user).expect("it is a party");
        Ok(Resource::new(Arc::new(protocol), user, granted, release))
    }

    /// As [`compile`](Self::compile), without what the positions mean.
    ///
    /// # Errors
    /// [`PatternError`]
    pub fn protocol(&self) -> Result<Protocol, PatternError> {
        let resource = self.compile()?;
        Ok(Protocol::clone(resource.protocol()))
    }

    fn model(&self, request: &str, granted: &str, release: &str) -> ProtocolModel {
        let (user, owner) = (self.user.as_str(), self.owner.as_str());
        let party = |by| match by {
            By::User => user,
            By::Owner => owner,
        };
        let [first, second] = match self.owner_is_first {
            false => [user, owner],
            true => [owner, user],
        };
        let mut model = ProtocolModel::new(&self.name, first, second);
        if let Some(keeper) = self.keeper {
            model.keeper(party(keeper));
        }
        model.array("request", &[(request, user)]);
        model
            .array("grant", &[(granted, owner)])
            .follow("request", "grant");
        if let Some(refused) = &self.refused {
            model
                .array("refuse", &[(refused, owner)])
                .follow("request", "refuse");
        }
        let mut uses: Vec<(&str, &str)> = Vec::new();
        uses.extend(
            self.using
                .iter()
                .map(|(flag, by)| (flag.as_str(), party(*by))),
        );
        uses.push((release, user));
        uses.extend(
            self.released
                .as_ref()
                .map(|released| (released.as_str(), owner)),
        );
        model.array("use", &uses).follow("grant", "use");
        if let Some(returned) = &self.returned {
            model
                .array("give back", &[(returned, user)])
                .follow("grant", "give back");
        }
        model
    }
}
