//! Floors to drive on, and machines of a few states to drive them with.

use crate::closed_loop::robot::Robot;
use crate::plant::Plant;
use description::geometry::{Footprint, Point2, Pose2, Rect, Segment};
use description::robot::Navigation;
use description::site::{
    Area, ControlLayer, ControllerConfig, Feature, FsmConfig, FsmState, FsmTransition, Lane,
    Manoeuvre, Monitor, MonitorKind, PerceptionKind, RegionRef, Site, SiteRobot, SkillConfig, Wall,
};
use skills::navigator::NavigatorSetup;
use skills::scan::ScanGeometry;

pub const FOOTPRINT: Footprint = Footprint {
    front_m: 0.32,
    rear_m: 0.08,
    left_m: 0.15,
    right_m: 0.15,
};

pub fn lidar() -> ScanGeometry {
    ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0)
}

pub fn rect(min: [f64; 2], max: [f64; 2]) -> Rect {
    Rect::new(min.into(), max.into())
}

pub fn line(from: [f64; 2], to: [f64; 2]) -> Segment {
    Segment::new(Point2::from(from), Point2::from(to))
}

/// The name of the state machine.
pub const ROLE: &str = "test";
/// The name of the robot.
pub const ROBOT: &str = "robot";

pub fn area(
    id: &str,
    region: Rect,
    lane: Option<&str>,
    speed_limit_m_s: f64,
    deviation_limit_m: f64,
) -> Area {
    Area {
        id: id.into(),
        region,
        lane: lane.map(Into::into),
        capacity: 1,
        control: ControlLayer {
            manoeuvre: Manoeuvre::Any,
            speed_limit_m_s,
            deviation_limit_m,
        },
    }
}

pub fn region(min: [f64; 2], max: [f64; 2]) -> MonitorKind {
    MonitorKind::RegionReached {
        of: RegionRef::Own,
        region: rect(min, max),
    }
}

pub fn state(name: &str, area: &str, skill: &str) -> FsmState {
    FsmState {
        name: name.into(),
        area: area.into(),
        also: Vec::new(),
        lane: None,
        skill: skill.into(),
    }
}

pub fn transition(from: &str, on: &str, to: &str, outputs: &[&str]) -> FsmTransition {
    FsmTransition {
        from: from.into(),
        on: on.into(),
        to: to.into(),
        outputs: outputs.iter().map(|&name| name.into()).collect(),
    }
}

/// The robot of 0.4 m × 0.3 m on a site.
pub fn setup_of(mut site: Site, fsm: FsmConfig, start: Pose2) -> NavigatorSetup {
    let robot = SiteRobot {
        role: ROLE.into(),
        start,
        start_state: None,
    };
    site.fsm.insert(ROLE.into(), fsm);
    site.robots.insert(ROBOT.into(), robot);
    NavigatorSetup {
        site,
        robot: ROBOT.into(),
        gains: Navigation::default(),
        acceleration_m_s2: 0.5,
        max_speed_m_s: 0.4,
        footprint: FOOTPRINT,
        beams: lidar().beams,
    }
}

/// A site and a machine, made step by step.
#[derive(Clone, Debug, Default)]
pub struct Floor {
    pub site: Site,
    fsm: FsmConfig,
}

impl Floor {
    pub fn wall(mut self, id: &str, from: [f64; 2], to: [f64; 2]) -> Self {
        self.site.walls.push(Wall {
            id: id.into(),
            line: line(from, to),
        });
        self
    }

    pub fn lane(mut self, id: &str, from: [f64; 2], to: [f64; 2], end: Option<&str>) -> Self {
        self.site.lanes.push(Lane {
            id: id.into(),
            line: line(from, to),
            end_wall: end.map(Into::into),
        });
        self
    }

    pub fn area(
        mut self,
        id: &str,
        min: [f64; 2],
        max: [f64; 2],
        lane: Option<&str>,
        speed_limit_m_s: f64,
    ) -> Self {
        let area = area(id, rect(min, max), lane, speed_limit_m_s, 0.4);
        self.site.areas.push(area);
        self
    }

    pub fn monitor(mut self, event: &str, kind: MonitorKind) -> Self {
        let event = event.into();
        self.site.monitors.push(Monitor { event, kind });
        self
    }

    pub fn reached(self, id: &str, min: [f64; 2], max: [f64; 2]) -> Self {
        self.monitor(id, region(min, max))
    }

    /// A state with a skill of its own; the pose is corrected by all walls in view.
    pub fn state(
        mut self,
        name: &str,
        area: &str,
        controller: ControllerConfig,
        monitors: &[&str],
    ) -> Self {
        let skill = format!("{name}-skill");
        self.fsm.states.push(state(name, area, &skill));
        self.site.skills.push(SkillConfig {
            id: skill,
            controller,
            speed_m_s: None,
            perception: name.into(),
            monitors: monitors.iter().map(|&name| name.into()).collect(),
        });
        self.perceiving(&[Feature::Walls], &[Feature::Corridor])
    }

    fn perceiving(mut self, tracks: &[Feature], searches: &[Feature]) -> Self {
        let state = self.fsm.states.last().expect("a state");
        let kind = PerceptionKind {
            tracks: tracks.into(),
            searches: searches.into(),
        };
        self.site.perception_kinds.insert(state.name.clone(), kind);
        self
    }

    /// The last state looks for the lane's end too.
    pub fn searching_the_end(self) -> Self {
        self.perceiving(&[Feature::Walls], &[Feature::Corridor, Feature::LaneEnd])
    }

    /// The last state sees these alone.
    pub fn tracking_only(self, tracks: &[Feature]) -> Self {
        self.perceiving(tracks, &[])
    }

    /// The last state drives no faster than this.
    pub fn at_speed(mut self, speed_m_s: f64) -> Self {
        let skill = self.site.skills.last_mut().expect("a state");
        skill.speed_m_s = Some(speed_m_s);
        self
    }

    pub fn go(mut self, from: &str, on: &str, to: &str) -> Self {
        self.fsm.transitions.push(transition(from, on, to, &[]));
        self
    }

    /// The first state is the initial one.
    pub fn setup(&self, start: Pose2) -> NavigatorSetup {
        let mut fsm = self.fsm.clone();
        fsm.initial.clone_from(&fsm.states[0].name);
        setup_of(self.site.clone(), fsm, start)
    }

    /// A robot near `start`.
    pub fn robot(&self, seed: u64, start: Pose2) -> Robot {
        let walls = self.site.walls.iter().map(|wall| wall.line).collect();
        let plant = Plant::new(seed, walls, FOOTPRINT, start);
        Robot::around(plant, self.setup(start))
    }
}

/// The corridor of 10 m with two lanes and a shoulder; the areas hold no states yet.
pub fn corridor() -> Floor {
    Floor::default()
        .wall("south", [0.0, -1.6], [10.0, -1.6])
        .wall("north", [0.0, 1.6], [10.0, 1.6])
        .wall("east", [10.0, -1.6], [10.0, 1.6])
        .wall("west", [0.0, -1.6], [0.0, 1.6])
        .lane("east", [1.2, -0.5], [8.8, -0.5], Some("east"))
        .lane("west", [8.8, 0.5], [1.2, 0.5], Some("west"))
        .lane("shoulder", [3.0, -1.2], [5.0, -1.2], None)
        .area("1", [1.5, -0.9], [5.5, 0.0], Some("east"), 0.4)
        .area("2", [5.5, -0.9], [8.5, 0.0], Some("east"), 0.4)
        .area("3", [8.5, -1.6], [10.0, 1.6], None, 0.3)
        .area("4", [4.5, 0.0], [8.5, 1.6], Some("west"), 0.4)
        .area("5", [3.0, -1.6], [5.0, -0.9], Some("shoulder"), 0.2)
        .area("6", [1.5, 0.0], [4.5, 1.6], Some("west"), 0.4)
        .area("7", [0.0, -1.6], [1.5, 1.6], None, 0.3)
}

/// Three arms, 2.4 m wide and 5 m long, round a crossing at the origin: west, east and south. Keep right.
pub fn junction() -> Floor {
    Floor::default()
        .wall("north", [-6.2, 1.2], [6.2, 1.2])
        .wall("west", [-6.2, -1.2], [-6.2, 1.2])
        .wall("east", [6.2, -1.2], [6.2, 1.2])
        .wall("south", [-1.2, -6.2], [1.2, -6.2])
        .wall("south-west", [-6.2, -1.2], [-1.2, -1.2])
        .wall("south-east", [1.2, -1.2], [6.2, -1.2])
        .wall("arm-west", [-1.2, -6.2], [-1.2, -1.2])
        .wall("arm-east", [1.2, -6.2], [1.2, -1.2])
        .lane("west-in", [-5.0, -0.5], [-1.2, -0.5], None)
        .lane("west-out", [-1.2, 0.5], [-5.0, 0.5], Some("west"))
        .lane("east-in", [5.0, 0.5], [1.2, 0.5], None)
        .lane("east-out", [1.2, -0.5], [5.0, -0.5], Some("east"))
        .lane("south-in", [0.5, -5.0], [0.5, -1.2], None)
        .lane("south-out", [-0.5, -1.2], [-0.5, -5.0], Some("south"))
        .area("west-in", [-6.2, -1.2], [-1.2, 0.0], Some("west-in"), 0.4)
        .area("west-out", [-6.2, 0.0], [-1.2, 1.2], Some("west-out"), 0.4)
        .area("east-in", [1.2, 0.0], [6.2, 1.2], Some("east-in"), 0.4)
        .area("east-out", [1.2, -1.2], [6.2, 0.0], Some("east-out"), 0.4)
        .area("south-in", [0.0, -6.2], [1.2, -1.2], Some("south-in"), 0.4)
        .area(
            "south-out",
            [-1.2, -6.2],
            [0.0, -1.2],
            Some("south-out"),
            0.4,
        )
        .area("crossing", [-1.2, -1.2], [1.2, 1.2], None, 0.3)
}
