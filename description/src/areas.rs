//! Areas of a site by number.

/// Areas that a site of robots can have.
pub const MAX_AREAS: usize = 1 + u8::MAX as usize;

/// Number of an area: its place in the order of the site file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AreaIndex(pub u8);

impl AreaIndex {
    /// The area at this place of the site file; `None` at [`MAX_AREAS`] or more.
    #[must_use]
    pub fn new(place: usize) -> Option<Self> {
        u8::try_from(place).ok().map(Self)
    }

    /// The first `count` areas.
    pub fn first(count: usize) -> impl Iterator<Item = Self> + Clone {
        (0..=u8::MAX).take(count).map(Self)
    }

    /// Its place in the site file.
    #[must_use]
    pub const fn place(self) -> usize {
        self.0 as usize
    }
}
