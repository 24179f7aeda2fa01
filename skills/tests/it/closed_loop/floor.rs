//! Floors to drive on, and machines of a few states to drive them with.

use crate::closed_loop::robot::Robot;
use crate::plant::Plant;
use coordination::event::EventTable;
use coordination::fsm::MachineModel;
use description::geometry::{Footprint, Point2, Pose2, Rect, Segment};
use skills::map::{AreaData, LaneData, MapData, WallData};
use skills::monitors::MonitorKind;
use skills::navigator::{NavigationGains, NavigatorSetup};
use skills::perception::{Feature, FeatureSet};
use skills::scan::ScanGeometry;
use skills::schedule::{ControllerSetup, MonitorSetup, SkillSetup, StateSetup};

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

/// A map and a machine, made step by step.
#[derive(Clone, Debug, Default)]
pub struct Floor {
    pub map: MapData,
    skills: Vec<SkillSetup>,
    states: Vec<StateSetup>,
    monitors: Vec<(String, MonitorKind)>,
    transitions: Vec<[String; 3]>,
}

impl Floor {
    pub fn wall(mut self, id: &str, from: [f64; 2], to: [f64; 2]) -> Self {
        self.map.walls.push(WallData {
            id: id.into(),
            line: line(from, to),
        });
        self
    }

    pub fn lane(mut self, id: &str, from: [f64; 2], to: [f64; 2], end: Option<&str>) -> Self {
        self.map.lanes.push(LaneData {
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
        self.map.areas.push(AreaData {
            id: id.into(),
            region: rect(min, max),
            lane: lane.map(Into::into),
            speed_limit_m_s,
            deviation_limit_m: 0.4,
        });
        self
    }

    pub fn monitor(mut self, id: &str, kind: MonitorKind) -> Self {
        self.monitors.push((id.into(), kind));
        self
    }

    pub fn reached(self, id: &str, min: [f64; 2], max: [f64; 2]) -> Self {
        let region = rect(min, max);
        self.monitor(id, MonitorKind::RegionReached { region })
    }

    /// A state with a skill of its own; the pose is corrected by all walls in view.
    pub fn state(
        mut self,
        name: &str,
        area: &str,
        controller: ControllerSetup,
        monitors: &[&str],
    ) -> Self {
        self.skills.push(SkillSetup {
            id: format!("{name}-skill"),
            controller,
            speed_m_s: None,
            tracks: [Feature::Walls].into_iter().collect(),
            searches: [Feature::Corridor].into_iter().collect(),
            monitors: monitors.iter().map(|&name| name.into()).collect(),
        });
        self.states.push(StateSetup {
            name: name.into(),
            area: Some(area.into()),
            lane: None,
            skill: format!("{name}-skill"),
        });
        self
    }

    /// The last state looks for the lane's end too.
    pub fn searching_the_end(mut self) -> Self {
        let skill = self.skills.last_mut().expect("a state");
        skill.searches = [Feature::Corridor, Feature::LaneEnd].into_iter().collect();
        self
    }

    /// The last state sees the corridor alone.
    pub fn tracking_only(mut self, tracks: FeatureSet) -> Self {
        let skill = self.skills.last_mut().expect("a state");
        skill.tracks = tracks;
        skill.searches = FeatureSet::default();
        self
    }

    /// The last state drives no faster than this.
    pub fn at_speed(mut self, speed_m_s: f64) -> Self {
        self.skills.last_mut().expect("a state").speed_m_s = Some(speed_m_s);
        self
    }

    pub fn go(mut self, from: &str, on: &str, to: &str) -> Self {
        self.transitions.push([from.into(), on.into(), to.into()]);
        self
    }

    /// The first state is the initial one.
    pub fn setup(&self, start: Pose2) -> (NavigatorSetup, EventTable) {
        let mut model = MachineModel::new("test");
        for state in &self.states {
            model.state(&state.name);
        }
        model.initial(&self.states[0].name);
        for [from, on, to] in &self.transitions {
            model.transition(from, on, to, &[]);
        }
        let mut events = EventTable::new();
        let machine = model.compile(&mut events).expect("a sound machine");
        let monitors = self.monitors.iter().map(|(id, kind)| MonitorSetup {
            id: id.clone(),
            event: events.intern(id).expect("room for a few events"),
            kind: *kind,
        });
        let setup = NavigatorSetup {
            map: self.map.clone(),
            monitors: monitors.collect(),
            machine,
            states: self.states.clone(),
            skills: self.skills.clone(),
            gains: NavigationGains::default(),
            max_speed_m_s: 0.4,
            footprint: FOOTPRINT,
            beams: lidar().beams,
            start,
            start_state: None,
        };
        (setup, events)
    }

    /// A robot near `start`.
    pub fn robot(&self, seed: u64, start: Pose2) -> Robot {
        let walls = self.map.walls.iter().map(|wall| wall.line).collect();
        let plant = Plant::new(seed, walls, FOOTPRINT, start);
        let (setup, events) = self.setup(start);
        Robot::around(plant, setup, events)
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
