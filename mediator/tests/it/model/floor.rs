//! Floors for robots: a ring of areas, the corridor with its lay-by, and the docking bay.

use std::sync::Arc;
use std::time::Duration;

use super::robot::Robot;
use crate::random::Random;
use crate::sites;
use mediator::nets::Plan;
use mediator::setup::{AreaSetup, RobotSetup, Setup};

pub const SILENT_NS: u64 = 1_000_000_000;

/// Areas, and places in them.
pub struct Floor {
    pub setup: Setup,
    pub plans: Vec<Arc<Plan>>,
    /// How many robots may truly be in each area.
    pub limits: Vec<u32>,
    /// The areas that a robot takes in each spot; the last one is outside all of them.
    pub spots: Vec<Vec<usize>>,
    /// Spots where robots are overtaken: beside the first, the first, the one behind it.
    pub lay_by: Option<usize>,
    pub first: Option<usize>,
    pub second: Option<usize>,
}

impl Floor {
    /// The spot beside all areas.
    pub fn outside(&self) -> usize {
        self.spots.len() - 1
    }

    pub fn name(&self, area: usize) -> &str {
        &self.setup.areas[area].id
    }

    /// Some areas in a ring, and some robots of different priority there.
    pub fn ring(random: &mut Random) -> (Self, Vec<Robot>) {
        let areas = 3 + random.below(6) as usize;
        let capacities: Vec<u32> = (0..areas).map(|_| 1 + random.below(2) as u32).collect();
        // On a ring somebody can always move unless all of it is full.
        let most = capacities.iter().sum::<u32>() as usize - 1;
        let count = 1 + random.below(most.min(6) as u64) as usize;
        let route: Vec<usize> = (0..areas).collect();
        let mut free = capacities.clone();
        let mut robots = Vec::new();
        for number in 0..count {
            let area = loop {
                let area = random.below(areas as u64) as usize;
                if free[area] > 0 {
                    free[area] -= 1;
                    break area;
                }
            };
            robots.push(Robot::new(
                &format!("r{number}"),
                "normal",
                &route,
                area,
                250,
                random,
            ));
        }
        let ids: Vec<String> = (0..areas).map(|area| format!("a{area}")).collect();
        let setup = Setup {
            site: "ring".into(),
            areas: { ids.iter().zip(&capacities) }
                .map(|(id, &capacity)| AreaSetup {
                    id: id.clone(),
                    capacity,
                })
                .collect(),
            robots: { robots.iter() }
                .map(|robot| RobotSetup {
                    id: robot.id.clone(),
                    role: "normal".into(),
                    priority: random.below(3) as u32,
                    ages_after: 0,
                    starts_in: vec![ids[robot.spot].clone()],
                })
                .collect(),
            floor: contract::floor::Floor::default(),
            silent_after: Duration::from_nanos(SILENT_NS),
        };
        let floor = Self {
            setup,
            plans: Vec::new(),
            limits: capacities,
            spots: { (0..areas).map(|area| vec![area]) }
                .chain([Vec::new()])
                .collect(),
            lay_by: None,
            first: None,
            second: None,
        };
        (floor, robots)
    }

    /// The shipped corridor and the shipped net, with an emergency robot and one or two normal ones.
    pub fn corridor(random: &mut Random) -> (Self, Vec<Robot>) {
        let (mut setup, plans) = CORRIDOR.with(Clone::clone);
        let area = |id: &str| {
            let found = setup.areas.iter().position(|area| area.id == id);
            found.expect("the corridor has it")
        };
        let route = ["1", "2", "3", "4", "6", "7"].map(area);
        let lay_by = area("5");
        let offset = random.below(6) as usize;
        let mut robots = vec![
            Robot::new("fast", "emergency", &route, offset, 100, random),
            Robot::new("slow", "normal", &route, (offset + 2) % 6, 600, random),
        ];
        if random.chance(40) {
            let third = (offset + 4) % 6;
            robots.push(Robot::new("third", "normal", &route, third, 400, random));
            robots[2].dreams = true;
        }
        let areas = 0..setup.areas.len();
        let spots: Vec<Vec<usize>> = { areas.map(|area| vec![area]) }
            .chain([Vec::new()])
            .collect();
        place(&mut setup, &robots, &spots);
        let floor = Self {
            limits: setup.areas.iter().map(|area| area.capacity).collect(),
            setup,
            plans,
            spots,
            lay_by: Some(lay_by),
            first: Some(route[0]),
            second: Some(route[1]),
        };
        (floor, robots)
    }

    /// The shipped docking bay and its net. The lanes of the access hold any number, so that only the net keeps robots apart.
    pub fn docking(random: &mut Random) -> (Self, Vec<Robot>) {
        let (mut setup, plans) = DOCKING.with(Clone::clone);
        let spots: Vec<Vec<usize>> = [
            &["apron"][..],
            &["access-in"],
            &["dock"],
            &["access-out"],
            &["access-in", "access-out"],
            &[],
        ]
        .iter()
        .map(|ids| {
            let area = |id: &&str| setup.areas.iter().position(|area| area.id == *id);
            ids.iter()
                .map(|id| area(id).expect("the site has it"))
                .collect()
        })
        .collect();
        // The big one has left a lane now and then to which it comes back.
        let (small, big) = (&[0, 1, 2, 3][..], &[0, 4, 1, 4, 2, 4][..]);
        let mut robots = vec![
            Robot::new("amr-1", "small", small, 0, 200, random),
            Robot::new("amr-2", "small", small, 2, 200, random),
            Robot::new("amr-big", "big", big, 0, 300, random),
        ];
        robots[2].through = Some((1, 4));
        setup.areas.iter_mut().for_each(|area| area.capacity = 3);
        place(&mut setup, &robots, &spots);
        let mut limits = vec![3; setup.areas.len()];
        spots[4].iter().for_each(|&area| limits[area] = 1);
        let floor = Self {
            setup,
            plans,
            limits,
            spots,
            lay_by: None,
            first: None,
            second: None,
        };
        (floor, robots)
    }
}

/// Everybody starts where the bodies are.
fn place(setup: &mut Setup, robots: &[Robot], spots: &[Vec<usize>]) {
    for own in &mut setup.robots {
        let body = robots.iter().find(|robot| robot.id == own.id);
        let areas = body.map_or(&[][..], |body| &spots[body.spot]);
        own.starts_in = { areas.iter() }
            .map(|&area| setup.areas[area].id.clone())
            .collect();
    }
}

thread_local! {
    static CORRIDOR: (Setup, Vec<Arc<Plan>>) = sites::corridor();
    static DOCKING: (Setup, Vec<Arc<Plan>>) = sites::docking();
}
