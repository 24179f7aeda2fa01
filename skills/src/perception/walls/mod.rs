//! Every wall of the map that is in view, matched with a scan.
//!
//! From the believed pose the matcher works out which wall each beam should hit: walls hide each other, end where they
//! end and leave openings. A beam whose end lies near enough to the wall that it, or a beam close by, should hit is
//! given to that wall; how near is near enough follows from the covariance of the pose and the noise of the range. Each
//! wall's points then go to the robust fit of [`line`](super::line): boxes, people and robots standing before a wall are
//! left out there, and a fit that covers too little is no wall.
//!
//! Nothing is seen through a wall. A line beyond which much is seen, where the wall should still be, is the side of
//! something that stands before it, and no wall. And where beams pass through a wall itself, the pose or the map is
//! wrong; beams that end before it only say that something stands there.
//!
//! Real time: [`WallMatcher::observe`] neither allocates nor locks nor panics. Its time grows with walls times the
//! directions they span, plus beams times [`PAIRS`](super::line); it is bounded for a map and a sensor.

mod beyond;
mod blind;
mod matcher;
mod view;

pub use matcher::{BeamCounts, MAX_SEEN_WALLS, SeenWall, WallMatcher, WallScan};

#[cfg(test)]
mod tests;
