//! What a site file says: the semantic map, the skills, the state machines, and which robots drive there.

mod coordination;
mod fsm;
mod map;
mod monitors;
mod skills;

pub use coordination::{
    CastConfig, CoordinationConfig, FlagMeaning, PreemptConfig, RoleConfig, SituationConfig,
    YieldConfig,
};
pub use fsm::{FsmConfig, FsmState, FsmTransition, SiteRobot};
pub use map::{Area, ControlLayer, Feature, Lane, Manoeuvre, PerceptionKind, PerceptionZone, Wall};
pub use monitors::{Monitor, MonitorKind, RegionRef};
pub use skills::{ControllerConfig, SkillConfig, StopPlace, TurnDirection};

use std::collections::BTreeMap;

use crate::geometry::Point2;
use crate::keys::{Each, Id, KeyError, Map, Need, Page, Section, Source, Table, Truth, Word};
use crate::{section, words};

/// A site. All lengths are metres in the `map` frame, x east, y north.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Site {
    /// The site's name.
    pub name: String,
    /// Whether a mediator grants areas; without one everything is granted.
    pub areas_managed: bool,
    /// Solid walls, as the lidar sees them.
    pub walls: Vec<Wall>,
    /// Directed centre lines to drive on.
    pub lanes: Vec<Lane>,
    /// The control layer: areas that a robot owns while it is in them.
    pub areas: Vec<Area>,
    /// The perception layer's zones.
    pub perception: Vec<PerceptionZone>,
    /// What is perceived in a zone of each kind.
    pub perception_kinds: BTreeMap<String, PerceptionKind>,
    /// What raises events.
    pub monitors: Vec<Monitor>,
    /// Schedules: perception, controller and monitors that run together.
    pub skills: Vec<SkillConfig>,
    /// A state machine for each role.
    pub fsm: BTreeMap<String, FsmConfig>,
    /// The robots, by identity.
    pub robots: BTreeMap<String, SiteRobot>,
    /// What the mediator knows of a role.
    pub roles: BTreeMap<String, RoleConfig>,
    /// When robots are coordinated.
    pub coordinations: BTreeMap<String, CoordinationConfig>,
}

words! {
    /// What a site file conforms to: the keys that `config/KEYS.md` lists, their units and what they mean. It changes when a file of
    /// before would mean something else.
    pub enum SiteMetamodel {
        /// The first.
        V1 "urn:kelo-onboard:site:1",
    }
}

section! {
    /// A site file says where robots drive and what they do there. All lengths are metres in the `map` frame, x east,
    /// y north.
    pub struct SiteFile {
        /// What the file conforms to; another one is refused.
        pub metamodel: SiteMetamodel as Word => SiteMetamodel::V1,
        /// The site's name.
        pub name: String as Id("the site's name"),
        /// Solid walls, as the lidar sees them.
        pub walls: Vec<Wall> as Map("sections [walls.<id>]", Need::Required),
        /// Directed centre lines to drive on.
        pub lanes: Vec<Lane> as Map("sections [lanes.<id>]", Need::Required),
        /// The control layer.
        pub areas: Areas as Table("[areas] and sections [areas.<id>]"),
        /// The perception layer.
        pub perception: Perception as Table("sections [perception.kinds.<kind>]"),
        /// What raises events.
        pub monitors: Vec<Monitor> as Map("sections [monitors.<event>]", Need::Required),
        /// What runs together.
        pub skills: Vec<SkillConfig> as Map("sections [skills.<id>]", Need::Required),
        /// A state machine for each role.
        pub fsm: BTreeMap<String, FsmConfig> as Map("sections [fsm.<role>]", Need::Required),
        /// The robots, by identity.
        pub robots: BTreeMap<String, SiteRobot> as Map("sections [robots.<id>]", Need::Required),
        /// What the mediator knows of a role.
        pub roles: BTreeMap<String, RoleConfig> as Map("sections [roles.<role>]", Need::Optional),
        /// When robots are coordinated.
        pub coordinations: BTreeMap<String, CoordinationConfig>
            as Map("sections [coordinations.<id>]", Need::Optional),
    }
}

section! {
    /// The control layer: areas that a robot owns while it is in them.
    pub struct Areas {
        /// Whether a mediator grants areas; without one everything is granted.
        pub managed: bool as Truth,
        /// The areas.
        pub areas: Vec<Area> as Each("<id>"),
    }
}

section! {
    /// The perception layer.
    pub struct Perception {
        /// What is perceived in a zone of each kind.
        pub kinds: BTreeMap<String, PerceptionKind>
            as Map("sections [perception.kinds.<kind>]", Need::Required),
        /// Where which kind is perceived.
        pub zones: Vec<PerceptionZone> as Map("a table", Need::Optional),
    }
}

impl Section for Site {
    const ABOUT: &'static str = SiteFile::ABOUT;
    const KEYS: &'static [&'static str] = SiteFile::KEYS;

    fn read(s: &dyn Source) -> Self {
        let file = SiteFile::read(s);
        let mut site = Self {
            name: file.name,
            areas_managed: file.areas.managed,
            walls: file.walls,
            lanes: file.lanes,
            areas: file.areas.areas,
            perception: file.perception.zones,
            perception_kinds: file.perception.kinds,
            monitors: file.monitors,
            skills: file.skills,
            fsm: file.fsm,
            robots: file.robots,
            roles: file.roles,
            coordinations: file.coordinations,
        };
        site.find_regions();
        site
    }

    fn check(&self) -> Result<(), KeyError> {
        Ok(())
    }

    fn excuse(s: &dyn Source) {
        SiteFile::excuse(s);
    }

    fn document(page: &mut Page) {
        SiteFile::document(page);
    }
}

impl Site {
    /// Finds the regions of areas and zones that monitors name. A name that nothing has is left for the check of
    /// references.
    fn find_regions(&mut self) {
        for monitor in &mut self.monitors {
            let MonitorKind::RegionReached { region, of } = &mut monitor.kind else {
                continue;
            };
            let found = match of {
                RegionRef::Area(id) => { self.areas.iter() }
                    .find(|area| area.id == *id)
                    .map(|area| area.region),
                RegionRef::Zone(id) => { self.perception.iter() }
                    .find(|zone| zone.id == *id)
                    .map(|zone| zone.region),
                RegionRef::Own => None,
            };
            *region = found.unwrap_or(*region);
        }
    }

    /// The wall with this id.
    #[must_use]
    pub fn wall(&self, id: &str) -> Option<&Wall> {
        self.walls.iter().find(|wall| wall.id == id)
    }

    /// The lane with this id.
    #[must_use]
    pub fn lane(&self, id: &str) -> Option<&Lane> {
        self.lanes.iter().find(|lane| lane.id == id)
    }

    /// The area with this id.
    #[must_use]
    pub fn area(&self, id: &str) -> Option<&Area> {
        self.areas.iter().find(|area| area.id == id)
    }

    /// The first area that contains the point.
    #[must_use]
    pub fn area_at(&self, point: Point2) -> Option<&Area> {
        self.areas.iter().find(|area| area.region.contains(point))
    }

    /// The monitor that raises this event.
    #[must_use]
    pub fn monitor(&self, event: &str) -> Option<&Monitor> {
        self.monitors.iter().find(|monitor| monitor.event == event)
    }

    /// The skill with this id.
    #[must_use]
    pub fn skill(&self, id: &str) -> Option<&SkillConfig> {
        self.skills.iter().find(|skill| skill.id == id)
    }
}
