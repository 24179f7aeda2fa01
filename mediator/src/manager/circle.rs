//! Robots that wait for each other: each has an area that another one of them needs.
//!
//! `mediator check` proves of most sites that this cannot come; elsewhere, and after an operator's hand, it can. A robot goes on
//! when it waits for nothing, or when some area that it waits for has room, or will have: one of those that fill it goes on. Where
//! a net decides, or a silent robot or a second process of one blocks, something else is to be done, and is said elsewhere. Robots that do not go on by that
//! rule wait for each other in circles. Where one has not been in its area yet, that is asked back for who waits for it, if it goes first;
//! else people are told.

use std::collections::BTreeMap;

use super::alarm::Alarm;
use super::areas::Areas;
use super::coordinations::Coordinations;
use super::names::Names;
use super::sessions::Sessions;

/// It is looked for this often: what was there the last time, too, is asked back,
const PERIOD_NS: u64 = 1_000_000_000;
/// and people are told when it has lasted for so long.
const LASTS_NS: u64 = 5_000_000_000;

/// A robot of a circle, the area that it waits for, and the next robot, which has that.
type Wait = (usize, usize, usize);

/// Each robot of a circle, from the one with the smallest number on.
type Circle = Vec<Wait>;

/// What is to be done about circles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Looked {
    /// Robots, each with an area that another one of its circle needs first.
    pub(crate) ask_back: Vec<(usize, usize)>,
    pub(crate) alarms: Vec<Alarm>,
}

/// Circles that were found.
#[derive(Clone, Debug, Default)]
pub(crate) struct CircleWatch {
    next_ns: u64,
    found: BTreeMap<Circle, Found>,
}

#[derive(Clone, Copy, Debug)]
struct Found {
    since_ns: u64,
    told: bool,
}

impl CircleWatch {
    /// Looks for circles, now and then.
    pub(crate) fn look(
        &mut self,
        names: &Names,
        areas: &Areas,
        sessions: &Sessions,
        coordinations: &Coordinations,
        now_ns: u64,
    ) -> Looked {
        let mut looked = Looked::default();
        if now_ns < self.next_ns {
            return looked;
        }
        self.next_ns = now_ns.saturating_add(PERIOD_NS);
        let stuck =
            |robot: usize| sessions.is_heard(robot) && coordinations.control_of(robot).is_none();
        let new = Found {
            since_ns: now_ns,
            told: false,
        };
        let circles = find(areas, names.robots().len(), stuck).into_iter();
        let found = circles.map(|circle| {
            let known = self.found.get(&circle).copied();
            (circle, known.unwrap_or(new))
        });
        self.found = found.collect();
        for (circle, own) in &mut self.found {
            let lasts_ns = now_ns.saturating_sub(own.since_ns);
            if lasts_ns > 0 {
                // Who asked first goes first, but for more important ones: they would be let in again at once.
                let priority = |robot: usize| names.robots()[robot].priority;
                let first = { circle.iter() }.filter(|wait| priority(wait.0) >= priority(wait.2));
                looked
                    .ask_back
                    .extend(first.map(|&(_, area, has)| (has, area)));
            }
            if !own.told && lasts_ns >= LASTS_NS {
                own.told = true;
                looked.alarms.push(alarm(circle, names, areas));
            }
        }
        looked
    }
}

fn alarm(circle: &Circle, names: &Names, areas: &Areas) -> Alarm {
    let waits = { circle.iter() }.map(|&(robot, area, has)| {
        let [robot, has] = [robot, has].map(|robot| names.robot_id(robot));
        format!("{robot} for area {}, which {has} has", names.area_id(area))
    });
    // The least important one; of equals the one that has asked last.
    let asked_ns = |&(robot, area, _): &Wait| {
        areas
            .robot(robot)
            .claim(area)
            .map_or(0, |claim| claim.asked_ns)
    };
    let backs_out = { circle.iter() }.min_by_key(|wait| {
        (
            names.robots()[wait.0].priority,
            std::cmp::Reverse(asked_ns(wait)),
        )
    });
    let backs_out = backs_out.map_or(0, |&(robot, ..)| robot);
    let wanted = { circle.iter() }.find(|&&(.., has)| has == backs_out);
    Alarm::Circle {
        waits: waits.collect::<Vec<_>>().join("; "),
        robot: names.robot_id(backs_out),
        area: wanted.map_or_else(String::new, |&(_, area, _)| names.area_id(area)),
    }
}

/// All circles, of which no two have a robot in common; none where all go on. Only robots that `may_wait` can wait for each other.
fn find(areas: &Areas, robots: usize, may_wait: impl Fn(usize) -> bool) -> Vec<Circle> {
    // By robot: what it waits for, and who fills that. Whoever has no entry goes on.
    let mut waits: Vec<Vec<(usize, Vec<usize>)>> = vec![Vec::new(); robots];
    for robot in (0..robots).filter(|&robot| may_wait(robot)) {
        let full = areas.robot(robot).waits().map(|area| {
            let others: Vec<usize> = areas
                .occupants(area)
                .filter(|&other| other != robot && areas.robot(other).has(area))
                .collect();
            (area, others)
        });
        let full: Vec<(usize, Vec<usize>)> = full.collect();
        let capacity = |area: usize| areas.area(area).capacity as usize;
        if full
            .iter()
            .all(|(area, others)| others.len() >= capacity(*area))
        {
            waits[robot] = full;
        }
    }
    loop {
        let goes_on: Vec<bool> = waits.iter().map(Vec::is_empty).collect();
        let freed = (0..robots).find(|&robot| {
            waits[robot]
                .iter()
                .any(|(_, others)| others.iter().any(|&other| goes_on[other]))
        });
        match freed {
            Some(robot) => waits[robot].clear(),
            None => break,
        }
    }
    let mut circles = Vec::new();
    let mut seen = vec![false; robots];
    for first in 0..robots {
        let mut way: Circle = Vec::new();
        let mut at = first;
        // Nobody that is left waits only for those who go on. What leads to a way of before leads to nothing new.
        while let Some((area, others)) = waits[at].first()
            && let Some(&other) = others.first()
            && !std::mem::replace(&mut seen[at], true)
        {
            way.push((at, *area, other));
            at = other;
        }
        if let Some(start) = way.iter().position(|&(robot, ..)| robot == at) {
            let mut circle = way.split_off(start);
            let least = { circle.iter().enumerate() }.min_by_key(|(_, wait)| wait.0);
            let least = least.map_or(0, |(place, _)| place);
            circle.rotate_left(least);
            circles.push(circle);
        }
    }
    circles
}
