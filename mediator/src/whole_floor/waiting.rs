//! Who waits by the order of areas alone, whatever else happens on the floor.

use super::floor::Floor;
use super::state::{Areas, State};

/// Who has which areas for as long as it waits, and who goes nowhere without which others.
pub(super) struct Occupied<'a> {
    capacities: &'a [usize],
    /// By robot.
    has: Vec<Areas>,
    /// By robot: what it lacks for where it goes, if that is decided and no order can change it.
    lacks: Vec<Areas>,
    /// By area.
    lacked_by: Vec<Vec<usize>>,
}

impl Floor {
    pub(super) fn occupied(&self, state: &State) -> Occupied<'_> {
        let robots = 0..self.routes.len();
        let has: Vec<Areas> = { robots.clone() }
            .map(|robot| {
                if self.is_cast(robot) {
                    // What it is not in yet it may be told to give back.
                    self.stands_in(state, robot).clone()
                } else {
                    self.has(state, robot)
                }
            })
            .collect();
        let lacks: Vec<Areas> = robots
            .map(|robot| {
                let areas = self.heads_for(state, robot).into_iter().flatten();
                let lacks = areas.filter(|area| !self.has_area(state, robot, **area));
                lacks.copied().collect()
            })
            .collect();
        let mut lacked_by = vec![Vec::new(); self.capacities.len()];
        for (robot, areas) in lacks.iter().enumerate() {
            for &area in areas {
                lacked_by[usize::from(area)].push(robot);
            }
        }
        Occupied {
            capacities: &self.capacities,
            has,
            lacks,
            lacked_by,
        }
    }
}

impl Occupied<'_> {
    /// Robots that wait for each other for ever: each lacks an area that others of them fill.
    pub(super) fn who_waits_for_each_other(&self) -> Vec<usize> {
        let mut waits: Vec<usize> = (0..self.has.len()).collect();
        loop {
            let mut inside = vec![0; self.capacities.len()];
            for &area in waits.iter().flat_map(|&robot| &self.has[robot]) {
                inside[usize::from(area)] += 1;
            }
            let is_full =
                |area: &u16| inside[usize::from(*area)] >= self.capacities[usize::from(*area)];
            let before = waits.len();
            waits.retain(|&robot| self.lacks[robot].iter().any(is_full));
            if waits.len() == before {
                return waits;
            }
        }
    }

    /// Robots that wait for one that stays where it is with all that it has, and for those that wait for it.
    pub(super) fn who_waits_for(&self, robot: usize) -> Vec<usize> {
        let mut stay = vec![robot];
        let mut inside = vec![0; self.capacities.len()];
        let mut next = 0;
        while let Some(&robot) = stay.get(next) {
            next += 1;
            for area in self.has[robot].iter().map(|&area| usize::from(area)) {
                inside[area] += 1;
                if inside[area] >= self.capacities[area] {
                    let lacked_by = { self.lacked_by[area].iter() }
                        .filter(|own| !stay.contains(own))
                        .copied();
                    let lacked_by: Vec<usize> = lacked_by.collect();
                    stay.extend(lacked_by);
                }
            }
        }
        stay.remove(0);
        stay
    }
}
