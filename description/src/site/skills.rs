//! Skills: what runs together, and controllers with their parameters.

use super::map::LENGTH;
use crate::geometry::Pose2;
use crate::keys::{
    Fault, Field, Flat, KeyError, Name, Need, OFFSET, Optional, POSITION, Page, Pose, Quantity,
    SPEED, Source, Text, Texts, Word,
};
use crate::{kinds, section, words};

const MARGIN: Quantity = Quantity::new("a length", "m").at_least(0.0).at_most(5.0);
const WAY: Quantity = Quantity::new("a way", "m").at_least(-10.0).at_most(10.0);

/// Distance to a border at which a robot stops when the file does not say.
const MARGIN_M: f64 = 0.10;

section! {
    /// What runs together: a controller, perception and monitors.
    pub struct SkillConfig {
        /// Unique among skills.
        pub id: String as Name,
        /// What moves the robot.
        pub controller: ControllerConfig as Flat,
        /// Fastest speed of this skill, always positive; the area's and the robot's limits hold as well. Required for
        /// `creep`; not for `stop`.
        pub speed_m_s: Option<f64> as Optional(SPEED),
        /// The perception kind that runs.
        pub perception: String as Text("a perception kind"),
        /// The monitors that run, by event.
        pub monitors: Vec<String> as Texts("a monitor's event"),
    }
}

kinds! {
    /// A controller with its parameters.
    pub enum ControllerConfig by "controller" else Stop {
        /// Keeps on the state's lane, or beside it, by the corridor's walls.
        Corridor "corridor" {
            /// Of the path from the lane's centre, positive to the left.
            offset_m: f64 as OFFSET => 0.0,
        },
        /// The same, up to a distance from the wall at the lane's end.
        EndOfLane "end-of-lane" {
            /// From `base_link` to the wall.
            distance_m: f64 as LENGTH,
        },
        /// Half a turn onto a lane that runs the other way.
        UTurn "u-turn" {
            /// To which side.
            direction: TurnDirection as Word,
            /// Of `base_link`'s path.
            radius_m: f64 as LENGTH,
        },
        /// Stands still.
        Stop "stop",
        /// From beside the state's lane onto it; done when the robot drives on it.
        Shift "shift" {
            /// Of the path on the lane from its centre, positive to the left.
            offset_m: f64 as OFFSET => 0.0,
            /// Length of lane that the change may take.
            within_m: f64 as LENGTH,
        },
        /// At a junction: from the lane of the state before onto the state's lane, left, right or straight on, as the
        /// lanes lie; done when the robot drives on it.
        Turn "turn" {
            /// Of `base_link`'s path where it turns.
            radius_m: f64 as LENGTH,
        },
        /// Along the state's lane to a place; done when the robot stands there.
        StopAt "stop-at" {
            /// Where.
            place: StopPlace as PlaceKeys,
        },
        /// Up to the end wall of the state's lane, as the lidar sees it; done when the robot stands.
        Dock "dock" {
            /// From the front of the footprint to the wall.
            distance_m: f64 as LENGTH,
        },
        /// A short way along the state's lane (without one: straight on), heading kept; done when it is driven.
        Creep "creep" {
            /// How far; negative: backward. Not zero.
            distance_m: f64 as Way,
        },
    }
}

impl ControllerConfig {
    /// Whether it comes to an end by itself, so that a monitor can see it done.
    #[must_use]
    pub const fn ends(&self) -> bool {
        !matches!(self, Self::Corridor { .. } | Self::Stop)
    }

    /// Whether it keeps along the state's lane.
    #[must_use]
    pub const fn follows_lane(&self) -> bool {
        !matches!(self, Self::UTurn { .. } | Self::Turn { .. } | Self::Stop)
    }
}

words! {
    /// To which side a robot turns.
    pub enum TurnDirection {
        /// Counter-clockwise.
        Left "left",
        /// Clockwise.
        Right "right",
    }
}

impl TurnDirection {
    /// +1 to the left, −1 to the right.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }
}

/// Where a robot stops on its lane.
#[derive(Clone, Debug, PartialEq)]
pub enum StopPlace {
    /// The whole footprint before the border of an area that lies ahead.
    BeforeArea {
        /// The area.
        area: String,
        /// From the front of the footprint to the border; the uncertainty of the pose is added to it.
        margin_m: f64,
    },
    /// `base_link` at a pose in `map`, on the lane or beside it and in its direction.
    Pose(Pose2),
    /// At the pose that comes with the event that starts the state.
    Instructed,
}

/// The rule of [`StopPlace`].
pub struct PlaceKeys;

impl Field<PlaceKeys> for StopPlace {
    fn check(&self, _: &str, _: &PlaceKeys) -> Result<(), KeyError> {
        match self {
            Self::BeforeArea { margin_m, .. } => margin_m.check("margin_m", &MARGIN),
            Self::Pose(pose) if !pose.is_finite() => {
                let found = format!("{pose:?}");
                Err(KeyError::new("pose", found, "a pose of finite numbers"))
            }
            Self::Pose(_) | Self::Instructed => Ok(()),
        }
    }

    fn read(s: &dyn Source, _: &'static str, _: &PlaceKeys, _: Option<Self>) -> Self {
        let area = s.text("before_area", "an area's id", Need::Optional);
        let margin_m = s.number("margin_m", &MARGIN, Need::Optional);
        let pose = <Option<Pose2> as Field<_>>::read(s, "pose", &Optional(Pose(POSITION)), None);
        let wrong = |key: &str, found: &str, expected: &str| {
            s.refuse(
                Fault::Inconsistent,
                key,
                found.to_owned(),
                expected.to_owned(),
            );
        };
        if area.is_none() && margin_m.is_some() {
            let expected = "it with `before_area`, whose border it is measured from";
            wrong("margin_m", "a margin", expected);
        }
        match (area, pose) {
            (Some(_), Some(_)) => {
                let expected =
                    "`before_area` or `pose`, or neither: the pose that comes with the event";
                wrong("pose", "`before_area` and `pose`", expected);
                Self::Instructed
            }
            (Some(area), None) => Self::BeforeArea {
                area,
                margin_m: margin_m.unwrap_or(MARGIN_M),
            },
            (None, Some(pose)) => Self::Pose(pose),
            (None, None) => Self::Instructed,
        }
    }

    fn excuse(s: &dyn Source, _: &'static str, _: &PlaceKeys) {
        let _ = (s.has("before_area"), s.has("margin_m"), s.has("pose"));
    }

    fn document(page: &mut Page, _: &'static str, _: &PlaceKeys, _: Option<Self>, _: &'static str) {
        let event = || Some("the pose that comes with the event".to_owned());
        let before =
            "Stop with the whole footprint before this area, which lies ahead on the lane.";
        page.key("before_area", "an area's id", event(), before);
        let margin = "With `before_area`: from the front of the footprint to the border.";
        page.key(
            "margin_m",
            MARGIN.describe(),
            Some(format!("{MARGIN_M:?}")),
            margin,
        );
        let value = "a pose { x_m = …, y_m = …, theta_rad = … }";
        page.key(
            "pose",
            value,
            event(),
            "Stop with `base_link` at this pose in `map`.",
        );
    }
}

/// The rule of a way that is not zero.
pub struct Way;

impl Way {
    const SHORTEST_M: f64 = 0.01;

    fn expected() -> String {
        format!(
            "a way of at least {} m; negative: backward",
            Self::SHORTEST_M
        )
    }
}

impl Field<Way> for f64 {
    fn read(s: &dyn Source, key: &'static str, _: &Way, _: Option<f64>) -> f64 {
        let way_m = s.number(key, &WAY, Need::Required).unwrap_or(f64::NAN);
        if way_m.abs() < Way::SHORTEST_M {
            let found = format!("{way_m:?}");
            s.refuse(Fault::OutOfRange, key, found, Way::expected());
        }
        way_m
    }

    fn check(&self, key: &str, _: &Way) -> Result<(), KeyError> {
        if self.abs() < Way::SHORTEST_M {
            return Err(KeyError::new(key, format!("{self:?}"), Way::expected()));
        }
        self.check(key, &WAY)
    }

    fn document(page: &mut Page, key: &'static str, _: &Way, _: Option<f64>, about: &'static str) {
        page.key(key, WAY.describe(), None, about);
    }
}
