//! Whether the site's robots can deadlock: each waits for an area that another one has.
//!
//! Explores all placements of the robots that can be reached: each is in the areas of its machine's state, asks for those of the
//! states that follow, and keeps what it has until it is there. Only the order of areas counts: speeds, priorities, and how nets
//! decide, are left out, except that a net gives all areas of a passage at once. Events from outside are left out too, and so are
//! states that only an operator leads out of.

use std::collections::{HashSet, VecDeque};

use config::SiteConfig;
use description::site::FsmConfig;

/// The search ends without a verdict after this many placements of robots: a bound for its time and memory.
pub(crate) const MOST: usize = 200_000;

/// What was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// No deadlock.
    Never {
        /// How many placements of robots there are.
        looked: usize,
    },
    /// A deadlock can be reached.
    May(Vec<Waits>),
    /// There are more than [`MOST`] placements.
    Unknown,
}

/// One of the robots of a deadlock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Waits {
    pub(crate) robot: String,
    pub(crate) has: Vec<String>,
    pub(crate) needs: Vec<String>,
}

/// Sets of areas by their numbers.
type Areas = Vec<usize>;

/// A robot's machine as far as areas go: states of the same areas that follow on each other are one.
struct Route {
    robot: String,
    start: usize,
    areas: Vec<Areas>,
    next: Vec<Vec<usize>>,
}

/// Where a robot is: the node of its route, and what it was granted beyond that.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct RoutePosition {
    node: usize,
    ahead: Areas,
}

/// Explores a site; each of `together` is given to a robot as a whole.
pub(crate) fn look(site: &SiteConfig, together: &[Areas]) -> Verdict {
    let routes: Vec<Route> = { site.robots.iter() }
        .filter_map(|(id, robot)| {
            let fsm = site.fsm.get(&robot.role)?;
            let start = robot.start_state.as_ref().unwrap_or(&fsm.initial);
            Route::of(id, site, fsm, start)
        })
        .collect();
    let floor = Floor {
        capacities: { site.areas.iter() }
            .map(|area| area.capacity as usize)
            .collect(),
        together,
        routes: &routes,
    };
    let start: Vec<RoutePosition> = { routes.iter() }
        .map(|route| RoutePosition {
            node: route.start,
            ahead: Vec::new(),
        })
        .collect();
    let mut seen = HashSet::from([start.clone()]);
    let mut open = VecDeque::from([start]);
    while let Some(places) = open.pop_front() {
        let stuck = floor.stuck(&places);
        if !stuck.is_empty() {
            let name = |areas: Areas| -> Vec<String> {
                { areas.into_iter() }
                    .map(|area| site.areas[area].id.clone())
                    .collect()
            };
            let waits = stuck.into_iter().map(|robot| Waits {
                robot: routes[robot].robot.clone(),
                has: name(floor.has(robot, &places[robot])),
                needs: name(floor.needs(robot, &places[robot])),
            });
            return Verdict::May(waits.collect());
        }
        for robot in 0..places.len() {
            for place in floor.moves(robot, &places, |_| true) {
                let mut after = places.clone();
                after[robot] = place;
                if !seen.contains(&after) {
                    if seen.len() == MOST {
                        return Verdict::Unknown;
                    }
                    seen.insert(after.clone());
                    open.push_back(after);
                }
            }
        }
    }
    Verdict::Never { looked: seen.len() }
}

impl Route {
    fn of(robot: &str, site: &SiteConfig, fsm: &FsmConfig, start: &str) -> Option<Self> {
        let number = |name: &str| fsm.states.iter().position(|state| state.name == name);
        let areas: Vec<Areas> = { fsm.states.iter() }
            .map(|state| {
                let mut areas: Areas = { state.areas() }
                    .filter_map(|id| site.areas.iter().position(|area| area.id == id))
                    .collect();
                areas.sort_unstable();
                areas
            })
            .collect();
        let mut next: Vec<Vec<usize>> = vec![Vec::new(); areas.len()];
        for transition in &fsm.transitions {
            if !fsm.external.contains(&transition.on)
                && let (Some(from), Some(to)) = (number(&transition.from), number(&transition.to))
            {
                next[from].push(to);
            }
        }
        let leads_on: Vec<bool> = next.iter().map(|next| !next.is_empty()).collect();
        // States of the same areas that follow on each other: the first of them stands for all.
        let mut node: Vec<usize> = (0..areas.len()).collect();
        for _ in 0..areas.len() {
            for from in 0..areas.len() {
                for &to in next[from].iter().filter(|&&to| leads_on[to]) {
                    if areas[from] == areas[to] {
                        let least = node[from].min(node[to]);
                        (node[from], node[to]) = (least, least);
                    }
                }
            }
        }
        let mut joined: Vec<Vec<usize>> = vec![Vec::new(); areas.len()];
        for from in 0..areas.len() {
            for &to in next[from].iter().filter(|&&to| leads_on[to]) {
                let (from, to) = (node[from], node[to]);
                if from != to && !joined[from].contains(&to) {
                    joined[from].push(to);
                }
            }
        }
        Some(Self {
            robot: robot.to_owned(),
            start: node[number(start)?],
            areas,
            next: joined,
        })
    }
}

struct Floor<'a> {
    capacities: Vec<usize>,
    together: &'a [Areas],
    routes: &'a [Route],
}

impl Floor<'_> {
    fn has(&self, robot: usize, place: &RoutePosition) -> Areas {
        let mut has = self.routes[robot].areas[place.node].clone();
        has.extend(&place.ahead);
        has.sort_unstable();
        has.dedup();
        has
    }

    /// What it lacks for going on, by all the ways that it may go.
    fn needs(&self, robot: usize, place: &RoutePosition) -> Areas {
        let (route, has) = (&self.routes[robot], self.has(robot, place));
        let mut needs: Areas = { route.next[place.node].iter() }
            .flat_map(|&next| route.areas[next].iter().copied())
            .filter(|area| !has.contains(area))
            .collect();
        needs.sort_unstable();
        needs.dedup();
        needs
    }

    /// What a robot can do next while those for which `counts` holds stay where they are.
    fn moves(
        &self,
        robot: usize,
        places: &[RoutePosition],
        counts: impl Fn(usize) -> bool,
    ) -> Vec<RoutePosition> {
        let (route, place) = (&self.routes[robot], &places[robot]);
        let has = self.has(robot, place);
        let mut moves = Vec::new();
        for &next in &route.next[place.node] {
            if route.areas[next].iter().all(|area| has.contains(area)) {
                moves.push(RoutePosition {
                    node: next,
                    ahead: Vec::new(),
                });
            }
        }
        let has_room = |area: usize| {
            let others = (0..places.len()).filter(|&other| other != robot && counts(other));
            let inside = others.filter(|&other| self.has(other, &places[other]).contains(&area));
            inside.count() < self.capacities[area]
        };
        let needs = self.needs(robot, place);
        for &area in &needs {
            let whole = self.together.iter().find(|whole| whole.contains(&area));
            let asked: Areas = match whole {
                Some(whole) => { needs.iter().copied() }
                    .filter(|need| whole.contains(need))
                    .collect(),
                None => vec![area],
            };
            if asked.iter().all(|&area| has_room(area)) {
                let mut ahead = place.ahead.clone();
                ahead.extend(asked);
                ahead.sort_unstable();
                moves.push(RoutePosition {
                    node: place.node,
                    ahead,
                });
            }
        }
        moves
    }

    /// The largest set of robots none of which can do anything while the others of the set do nothing.
    fn stuck(&self, places: &[RoutePosition]) -> Vec<usize> {
        let goes_on = |robot: usize| !self.routes[robot].next[places[robot].node].is_empty();
        let mut stuck: Vec<usize> = (0..places.len()).filter(|&robot| goes_on(robot)).collect();
        loop {
            let still: Vec<usize> = { stuck.iter().copied() }
                .filter(|&robot| {
                    let moves = self.moves(robot, places, |other| stuck.contains(&other));
                    moves.is_empty()
                })
                .collect();
            if still.len() == stuck.len() {
                return stuck;
            }
            stuck = still;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::parse_site;

    fn shipped(name: &str, edit: impl Fn(String) -> String) -> SiteConfig {
        let path = format!("{}/../config/sites/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = edit(std::fs::read_to_string(path).expect("it ships"));
        parse_site("site.toml", &text, &[])
            .unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)))
    }

    fn numbers(site: &SiteConfig, ids: &[&str]) -> Areas {
        let number = |id: &&str| site.areas.iter().position(|area| area.id == *id);
        let mut numbers: Areas = ids.iter().filter_map(number).collect();
        numbers.sort_unstable();
        numbers
    }

    #[test]
    fn robots_of_the_shipped_sites_never_block_each_other() {
        for name in ["overtaking", "t-junction", "docking"] {
            let site = shipped(name, |text| text);
            let together = [numbers(&site, &["access-in", "access-out"])];
            let verdict = look(&site, &together);
            assert!(
                matches!(verdict, Verdict::Never { looked } if looked > 10),
                "{name}: {verdict:?}"
            );
        }
    }

    #[test]
    fn two_that_keep_what_the_other_needs_block_each_other() {
        // One has the crossing and waits for the road behind it, which another has that waits for the crossing.
        let site = shipped("t-junction", |text| {
            text.replace(
                "lane = \"1-out\", skill",
                "also = [\"R1o\"], lane = \"1-out\", skill",
            )
        });
        let Verdict::May(waits) = look(&site, &[]) else {
            panic!("it can happen");
        };
        assert_eq!(waits.len(), 2, "{waits:?}");
        for (own, other) in [(0, 1), (1, 0)] {
            let needs = &waits[own].needs;
            assert!(
                needs.iter().all(|area| waits[other].has.contains(area)),
                "{waits:?}"
            );
        }
    }

    #[test]
    fn a_place_kept_before_the_way_there_is_free_blocks_robots() {
        let site = shipped("docking", |text| {
            text.replace(
                "\naccess-in = { area = \"access-in\", skill",
                "\naccess-in = { area = \"access-in\", also = [\"bay-in\"], skill",
            )
            .replace(
                "also = [\"access-out\", \"gate\"]",
                "also = [\"access-out\", \"gate\", \"bay-in\"]",
            )
        });
        let together = [numbers(&site, &["access-in", "access-out"])];
        let verdict = look(&site, &together);
        assert!(matches!(verdict, Verdict::May(_)), "{verdict:?}");
    }
}
