//! Breadth first through all states, so that what is found is found on a shortest way.

use std::collections::HashSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::action::Action;
use super::world::World;

/// Both cores of CI.
const THREADS: usize = 2;
/// States that a thread takes at once.
const SHARE: usize = 64;

/// What a search has seen.
pub struct Outcome {
    pub states: usize,
    /// Steps that were tried.
    pub steps: usize,
    /// Grants that an operator has ended before the robot was in the area.
    pub cleared: usize,
    /// The most actions on a shortest way to a state.
    pub depth: usize,
    /// The shortest way to a violation, and what it is.
    pub found: Option<(Vec<Action>, String)>,
}

/// A state that is new, where it came from, and how.
struct Next {
    key: u64,
    from: u32,
    action: Action,
    world: World,
}

/// Looks at all states; `every`: one in this many is also handed to `look`, which may find something wrong with it.
pub fn search(
    start: World,
    every: u64,
    look: &(impl Fn(&World) -> Option<String> + Sync),
) -> Outcome {
    let mut seen: HashSet<u64> = HashSet::from([start.key()]);
    // By state: the one before, and the action from there.
    let mut ways: Vec<(u32, Action)> = vec![(0, Action::Tick)];
    let mut frontier: Vec<(u32, World)> = vec![(0, start)];
    let (steps, cleared) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let mut depth = 0;
    loop {
        let next: Mutex<Vec<Next>> = Mutex::new(Vec::new());
        let wrong: Mutex<Option<(u32, Option<Action>, String)>> = Mutex::new(None);
        let taken = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..THREADS {
                scope.spawn(|| {
                    let mut own = Vec::new();
                    loop {
                        let from = taken.fetch_add(SHARE, Ordering::Relaxed);
                        if from >= frontier.len() {
                            break;
                        }
                        for (index, world) in &frontier[from..frontier.len().min(from + SHARE)] {
                            if world.key().is_multiple_of(every)
                                && let Some(what) = look(world)
                            {
                                *wrong.lock().expect("no panic") = Some((*index, None, what));
                            }
                            let mut actions = Vec::new();
                            world.actions(&mut actions);
                            for action in actions {
                                let Some(after) = world.after(action) else {
                                    continue;
                                };
                                steps.fetch_add(1, Ordering::Relaxed);
                                if matches!(action, Action::Clear(area) if world.is_granted(area)) {
                                    cleared.fetch_add(1, Ordering::Relaxed);
                                }
                                if let Some(what) = after.violation() {
                                    let found = Some((*index, Some(action), what));
                                    *wrong.lock().expect("no panic") = found;
                                }
                                let key = after.key();
                                if !seen.contains(&key) {
                                    own.push(Next {
                                        key,
                                        from: *index,
                                        action,
                                        world: after,
                                    });
                                }
                            }
                        }
                    }
                    next.lock().expect("no panic").append(&mut own);
                });
            }
        });
        let found = wrong
            .into_inner()
            .expect("no panic")
            .map(|(at, last, what)| {
                let mut way = way_to(&ways, at);
                way.extend(last);
                (way, what)
            });
        frontier.clear();
        for Next {
            key,
            from,
            action,
            world,
        } in next.into_inner().expect("no panic")
        {
            if seen.insert(key) {
                let index = u32::try_from(ways.len()).expect("fewer states than that");
                ways.push((from, action));
                frontier.push((index, world));
            }
        }
        if found.is_some() || frontier.is_empty() {
            return Outcome {
                states: ways.len(),
                steps: steps.into_inner(),
                cleared: cleared.into_inner(),
                depth,
                found,
            };
        }
        depth += 1;
    }
}

fn way_to(ways: &[(u32, Action)], mut at: u32) -> Vec<Action> {
    let mut way = Vec::new();
    while at != 0 {
        let (before, action) = ways[at as usize];
        way.push(action);
        at = before;
    }
    way.reverse();
    way
}
