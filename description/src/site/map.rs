//! Walls, lanes, areas and perception zones.

use crate::geometry::{Rect, Segment};
use crate::keys::{
    Corners, Count, Ends, Flat, Name, Need, Optional, POSITION, Quantity, SPEED, Text, Word,
    WordList,
};
use crate::{section, words};

/// A length on a floor.
pub(super) const LENGTH: Quantity = Quantity::new("a length", "m").above(0.0).at_most(100.0);

section! {
    /// A straight, solid wall, as the lidar sees it.
    pub struct Wall {
        /// Unique among walls.
        pub id: String as Name,
        /// From one end to the other.
        pub line: Segment as Ends(POSITION),
    }
}

section! {
    /// A directed centre line to drive on.
    pub struct Lane {
        /// Unique among lanes.
        pub id: String as Name,
        /// In the direction of driving.
        pub line: Segment as Ends(POSITION),
        /// The wall that closes the lane ahead: the feature "lane end". Without one the nearest wall across it.
        pub end_wall: Option<String> as Optional(Text("a wall's id")),
    }
}

section! {
    /// A piece of floor that is owned as a whole.
    pub struct Area {
        /// Unique among areas.
        pub id: String as Name,
        /// Where it is.
        pub region: Rect as Corners(POSITION),
        /// The lane that runs through it.
        pub lane: Option<String> as Optional(Text("a lane's id")),
        /// How many robots it holds.
        pub capacity: u32 as Count::new("a number of robots", 1, 1000) => 1,
        /// What a robot does in it, and within which limits.
        pub control: ControlLayer as Flat,
    }
}

section! {
    /// What an area expects of a robot's control.
    #[derive(Copy)]
    pub struct ControlLayer {
        /// The manoeuvre.
        pub manoeuvre: Manoeuvre as Word,
        /// Fastest speed.
        pub speed_limit_m_s: f64 as SPEED,
        /// Farthest from the lane's centre.
        pub deviation_limit_m: f64 as LENGTH,
    }
}

words! {
    /// What a robot does in an area.
    pub enum Manoeuvre {
        /// Drives along the lane, or to its end.
        Forward "forward",
        /// Turns round.
        UTurn "u-turn",
        /// Drives in, stops, drives out.
        Stop "stop",
        /// Crosses a junction: turns from one lane onto another, or goes straight on.
        Turn "turn",
        /// Drives up to a wall, and back from it.
        Dock "dock",
        /// What each state says: an area for several manoeuvres.
        Any "any",
    }
}

section! {
    /// A piece of floor in which the same features are perceived.
    pub struct PerceptionZone {
        /// Unique among zones.
        pub id: String as Name,
        /// Which of the perception kinds.
        pub kind: String as Text("a perception kind"),
        /// Where it is.
        pub region: Rect as Corners(POSITION),
    }
}

section! {
    /// What is perceived.
    #[derive(Default, Eq)]
    pub struct PerceptionKind {
        /// Features that are tracked and correct the pose.
        pub tracks: Vec<Feature> as WordList(Need::Optional),
        /// Features that are looked for, until an estimate is stable.
        pub searches: Vec<Feature> as WordList(Need::Optional),
    }
}

words! {
    /// What perception can find in a scan.
    pub enum Feature {
        /// The walls on both sides of the lane: orientation and lateral offset.
        Corridor "corridor",
        /// The wall that closes the lane: distance ahead.
        LaneEnd "lane-end",
        /// Every wall of the map that is in view: they correct the pose and nothing else.
        Walls "walls",
    }
}
