//! The two roles on a side of the protocol: what each may do next.

use thiserror::Error;

use super::resource::{Phase, Resource};
use crate::protocol::{AbortError, Change, FlagId, Position, SetError, Side};

/// The side is the other party's, or one of another protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum WrongSide {
    /// It runs another protocol.
    #[error("the side runs another protocol than the resource")]
    Protocol,
    /// It is the other party's side.
    #[error("the side is the other party's")]
    Party,
}

/// The resource's protocol has no such flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the protocol of the resource has no flag that says `{0}`")]
pub struct NotDeclared(pub &'static str);

/// Why a role could not do what it was told. Nothing changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum RoleError {
    /// The protocol cannot say that.
    #[error(transparent)]
    NotDeclared(#[from] NotDeclared),
    /// It cannot be said now.
    #[error(transparent)]
    Set(#[from] SetError),
    /// The flag asks for the resource, releases it, or answers that.
    #[error("expected a flag of the use, found flag number {}, which has another meaning", .0.0)]
    NotOfUse(FlagId),
}

/// What both roles have.
struct Role<'a, S> {
    resource: &'a Resource,
    side: &'a mut S,
}

impl<'a, S: Side> Role<'a, S> {
    fn new(resource: &'a Resource, side: &'a mut S, is_user: bool) -> Result<Self, WrongSide> {
        let (own, others) = (&**resource.protocol(), side.protocol());
        if !core::ptr::eq(own, others) && own != others {
            return Err(WrongSide::Protocol);
        }
        if (side.party() == resource.user()) != is_user {
            return Err(WrongSide::Party);
        }
        Ok(Self { resource, side })
    }

    fn phase(&self) -> Phase {
        self.resource.phase(self.side.read_to())
    }

    fn read(&mut self, mut each: impl FnMut(Change)) -> Phase {
        while let Some(change) = self.side.poll() {
            each(change);
        }
        self.phase()
    }

    /// Whether `flag` may be set now.
    fn may(&self, flag: Option<FlagId>) -> bool {
        let protocol = self.resource.protocol();
        let next = |flag| protocol.after(self.side.read_to(), flag);
        let is_own = |&flag: &FlagId| protocol.owner(flag) == Some(self.side.party());
        flag.filter(is_own).and_then(next).is_some() && self.side.peek().is_none()
    }

    fn step(&mut self, flag: FlagId) -> Result<(), RoleError> {
        if self.resource.flags.contains(flag) {
            return Err(RoleError::NotOfUse(flag));
        }
        Ok(self.side.set(flag)?)
    }

    fn set(&mut self, flag: Option<FlagId>, says: &'static str) -> Result<(), RoleError> {
        Ok(self.side.set(flag.ok_or(NotDeclared(says))?)?)
    }
}

/// Who wants the resource, on its side of the protocol.
pub struct User<'a, S>(Role<'a, S>);

impl<'a, S: Side> User<'a, S> {
    /// The user's role on `side`.
    ///
    /// # Errors
    /// If it is a side of another protocol, or the owner's.
    pub fn new(resource: &'a Resource, side: &'a mut S) -> Result<Self, WrongSide> {
        Role::new(resource, side, true).map(Self)
    }

    /// Where the resource is, as far as this side has read.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.0.phase()
    }

    /// Reads what the owner did, showing it to `each`, and returns where the resource is then.
    pub fn read(&mut self, each: impl FnMut(Change)) -> Phase {
        self.0.read(each)
    }

    /// Whether the resource can be asked for now.
    #[must_use]
    pub fn may_request(&self) -> bool {
        self.0.may(Some(self.0.resource.flags.request))
    }

    /// Asks for the resource.
    ///
    /// # Errors
    /// If it was asked for already, or the owner's flags are still to be read.
    pub fn request(&mut self) -> Result<(), RoleError> {
        self.0.set(Some(self.0.resource.flags.request), "request")
    }

    /// Whether a flag of the use may be set now.
    #[must_use]
    pub fn may_step(&self, flag: FlagId) -> bool {
        !self.0.resource.flags.contains(flag) && self.0.may(Some(flag))
    }

    /// Sets a flag of the use.
    ///
    /// # Errors
    /// If it is no flag of the use, the owner's, or not next.
    pub fn step(&mut self, flag: FlagId) -> Result<(), RoleError> {
        self.0.step(flag)
    }

    /// Whether the resource can be released now: its steps of use are done.
    #[must_use]
    pub fn may_release(&self) -> bool {
        self.0.may(Some(self.0.resource.flags.release))
    }

    /// Releases the resource.
    ///
    /// # Errors
    /// If the user does not have it, or steps of use come first.
    pub fn release(&mut self) -> Result<(), RoleError> {
        self.0.set(Some(self.0.resource.flags.release), "release")
    }

    /// Whether the resource can be given back unused now.
    #[must_use]
    pub fn may_give_back(&self) -> bool {
        self.0.may(self.0.resource.flags.returned)
    }

    /// Gives the resource back without having used it.
    ///
    /// # Errors
    /// If the protocol has no such flag, the user does not have it, or has begun to use it.
    pub fn give_back(&mut self) -> Result<(), RoleError> {
        self.0.set(self.0.resource.flags.returned, "give back")
    }
}

/// Whom the resource belongs to, on its side of the protocol.
pub struct Owner<'a, S>(Role<'a, S>);

impl<'a, S: Side> Owner<'a, S> {
    /// The owner's role on `side`.
    ///
    /// # Errors
    /// If it is a side of another protocol, or the user's.
    pub fn new(resource: &'a Resource, side: &'a mut S) -> Result<Self, WrongSide> {
        Role::new(resource, side, false).map(Self)
    }

    /// Where the resource is, as far as this side has read.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.0.phase()
    }

    /// Reads what the user did, showing it to `each`, and returns where the resource is then.
    pub fn read(&mut self, each: impl FnMut(Change)) -> Phase {
        self.0.read(each)
    }

    /// Whether a request can be granted now.
    #[must_use]
    pub fn may_grant(&self) -> bool {
        self.0.may(Some(self.0.resource.flags.granted))
    }

    /// Grants the resource.
    ///
    /// # Errors
    /// If nobody has asked, or the user's flags are still to be read.
    pub fn grant(&mut self) -> Result<(), RoleError> {
        self.0.set(Some(self.0.resource.flags.granted), "granted")
    }

    /// Whether a request can be refused now.
    #[must_use]
    pub fn may_refuse(&self) -> bool {
        self.0.may(self.0.resource.flags.refused)
    }

    /// Refuses the resource.
    ///
    /// # Errors
    /// If the protocol has no such flag, or nobody has asked.
    pub fn refuse(&mut self) -> Result<(), RoleError> {
        self.0.set(self.0.resource.flags.refused, "refused")
    }

    /// Sets a flag of the use.
    ///
    /// # Errors
    /// If it is no flag of the use, the user's, or not next.
    pub fn step(&mut self, flag: FlagId) -> Result<(), RoleError> {
        self.0.step(flag)
    }

    /// Whether a release can be confirmed now.
    #[must_use]
    pub fn may_confirm(&self) -> bool {
        self.0.may(self.0.resource.flags.released)
    }

    /// Confirms a release.
    ///
    /// # Errors
    /// If the protocol has no such flag, or the user has not released the resource.
    pub fn confirm(&mut self) -> Result<(), RoleError> {
        self.0.set(self.0.resource.flags.released, "released")
    }

    /// Takes the resource away by giving up the run; how far that had come.
    ///
    /// # Errors
    /// If the owner is not the protocol's keeper, or no run number is left.
    pub fn take_away(&mut self) -> Result<Position, AbortError> {
        self.0.side.abort()
    }
}
