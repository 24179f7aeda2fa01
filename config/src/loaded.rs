//! The content of a file, and where each value was written.

use std::ops::{Deref, DerefMut};

use description::robot::Robot;
use description::site::Site;

use crate::origin::Origin;

/// A valid file, and where each of its values was written.
#[derive(Clone, Debug)]
pub struct Loaded<T> {
    /// What it says.
    pub value: T,
    /// Where each value was written.
    pub origin: Origin,
}

/// A robot file.
pub type RobotConfig = Loaded<Robot>;
/// A site file.
pub type SiteConfig = Loaded<Site>;

impl<T> Deref for Loaded<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> DerefMut for Loaded<T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.value
    }
}
