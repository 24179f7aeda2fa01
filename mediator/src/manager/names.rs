//! Ids of the site's areas and robots. Everywhere else they are indices in the order of the site file.

use std::fmt;

use contract::floor::Floor;

use crate::setup::{Index, Setup, SetupError, index};

/// People read so many names in a sentence; of more they are told how many.
const MOST_NAMED: usize = 10;

/// A robot as the site file lists it.
#[derive(Clone, Debug)]
pub(crate) struct RobotName {
    pub(crate) id: String,
    pub(crate) role: String,
    /// Who goes first: the larger one.
    pub(crate) priority: u32,
    ages_after: u32,
}

impl RobotName {
    /// Whether it goes before others of its priority when enough of them have gone before it.
    pub(crate) fn ages(&self) -> bool {
        self.ages_after > 0
    }

    /// Who goes first, when so many later requests have gone before its own.
    pub(crate) fn priority_after(&self, passed: u32) -> u32 {
        let aged = passed.checked_div(self.ages_after).unwrap_or(0);
        self.priority.saturating_add(aged)
    }
}

/// What people are told of whose body a second process is.
pub(crate) fn second_of(robot_id: &str) -> String {
    format!("a second process of {robot_id}")
}

/// Areas and robots by index and by id. Never changes.
#[derive(Clone)]
pub(crate) struct Names {
    pub(crate) site: String,
    pub(crate) floor: Floor,
    areas: Vec<String>,
    robots: Vec<RobotName>,
    area_index: Index,
    robot_index: Index,
}

/// All parts of the manager have a copy, so it says its site only.
impl fmt::Debug for Names {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Names").field(&self.site).finish()
    }
}

impl Names {
    /// # Errors
    /// [`SetupError`] when an id is used twice, or cannot be part of a journal's key.
    pub(crate) fn new(setup: &Setup) -> Result<Self, SetupError> {
        Ok(Self {
            site: setup.site.clone(),
            floor: setup.floor.clone(),
            area_index: index("area", setup.areas.iter().map(|area| &area.id))?,
            robot_index: index("robot", setup.robots.iter().map(|robot| &robot.id))?,
            areas: setup.areas.iter().map(|area| area.id.clone()).collect(),
            robots: { setup.robots.iter() }
                .map(|robot| RobotName {
                    id: robot.id.clone(),
                    role: robot.role.clone(),
                    priority: robot.priority,
                    ages_after: robot.ages_after,
                })
                .collect(),
        })
    }

    pub(crate) fn area(&self, id: &str) -> Option<usize> {
        self.area_index.get(id).copied()
    }

    pub(crate) fn robot(&self, id: &str) -> Option<usize> {
        self.robot_index.get(id).copied()
    }

    pub(crate) fn area_id(&self, area: usize) -> String {
        self.areas[area].clone()
    }

    pub(crate) fn robot_id(&self, robot: usize) -> String {
        self.robots[robot].id.clone()
    }

    pub(crate) fn robots(&self) -> &[RobotName] {
        &self.robots
    }

    /// Ids of areas, for people.
    pub(crate) fn area_list(&self, areas: impl IntoIterator<Item = usize>) -> String {
        listed(areas.into_iter().map(|area| &self.areas[area]))
    }

    /// Ids of robots, for people.
    pub(crate) fn robot_list(&self, robots: impl IntoIterator<Item = usize>) -> String {
        listed(robots.into_iter().map(|robot| &self.robots[robot].id))
    }

    /// Ids of all areas in alphabetical order, for people.
    pub(crate) fn all_areas(&self) -> String {
        let mut ids: Vec<&str> = self.areas.iter().map(String::as_str).collect();
        ids.sort_unstable();
        listed(ids)
    }

    /// Ids of all robots, for people.
    pub(crate) fn all_robots(&self) -> String {
        self.robot_list(0..self.robots.len())
    }
}

/// Some things, for people: the first of them, and how many more there are, so that no sentence grows with the fleet.
pub(crate) fn listed<T: fmt::Display>(all: impl IntoIterator<Item = T>) -> String {
    let mut all = all.into_iter();
    let first: Vec<String> = { all.by_ref().take(MOST_NAMED) }
        .map(|own| own.to_string())
        .collect();
    let text = first.join(", ");
    match all.count() {
        0 => text,
        more => format!("{text}, and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_the_first_are_named_and_the_others_counted() {
        assert_eq!(listed(["a", "b"]), "a, b");
        assert_eq!(listed(0..MOST_NAMED), "0, 1, 2, 3, 4, 5, 6, 7, 8, 9");
        assert_eq!(
            listed(0..1000),
            "0, 1, 2, 3, 4, 5, 6, 7, 8, 9, and 990 more"
        );
    }
}
