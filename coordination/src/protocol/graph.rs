//! The arrays of a model in numbers: which can follow which, and the tree of all runs.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;

use super::error::Problem;
use super::tree::{Flag, FlagId, Node, Protocol};

#[derive(Clone, Debug)]
pub(super) struct Array {
    pub(super) name: String,
    pub(super) flags: Vec<FlagId>,
    /// The arrays that can follow.
    pub(super) next: Vec<usize>,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Graph {
    pub(super) flags: Vec<Flag>,
    pub(super) arrays: Vec<Array>,
    /// The arrays that a run can begin with.
    pub(super) starts: Vec<usize>,
}

impl Graph {
    /// Checks the order of the arrays, none of which may be empty.
    pub(super) fn check(&self, parties: &[String; 2], problems: &mut Vec<Problem>) {
        self.check_alternatives("a run", &self.starts, parties, problems);
        for array in &self.arrays {
            let place = format!("array `{}`", array.name);
            self.check_alternatives(&place, &array.next, parties, problems);
        }
        let mut reached = vec![false; self.arrays.len()];
        let mut waiting = self.starts.clone();
        while let Some(array) = waiting.pop() {
            if !core::mem::replace(&mut reached[array], true) {
                waiting.extend(&self.arrays[array].next);
            }
        }
        for (array, _) in self
            .arrays
            .iter()
            .zip(&reached)
            .filter(|(_, reached)| !**reached)
        {
            problems.push(Problem::Unreachable {
                array: array.name.clone(),
            });
        }
        self.check_cycles(problems);
    }

    /// At a branch one party chooses, and the flag that it sets tells which way.
    fn check_alternatives(
        &self,
        place: &str,
        alternatives: &[usize],
        parties: &[String; 2],
        problems: &mut Vec<Problem>,
    ) {
        for (index, &second) in alternatives.iter().enumerate() {
            let (second, begun) = (&self.arrays[second], self.arrays[second].flags[0]);
            for &first in &alternatives[..index] {
                let (first, begins) = (&self.arrays[first], self.arrays[first].flags[0]);
                let owner = |flag: FlagId| self.flags[flag.index()].owner;
                if begins == begun {
                    problems.push(Problem::SameFlag {
                        place: place.to_owned(),
                        first: first.name.clone(),
                        second: second.name.clone(),
                        flag: self.flags[begun.index()].name.to_string(),
                    });
                } else if owner(begins) != owner(begun) {
                    problems.push(Problem::TwoChoose {
                        place: place.to_owned(),
                        first: first.name.clone(),
                        first_owner: parties[owner(begins).index()].clone(),
                        second: second.name.clone(),
                        second_owner: parties[owner(begun).index()].clone(),
                    });
                }
            }
        }
    }

    /// Takes away arrays that nothing leads to, again and again; a cycle stays.
    fn check_cycles(&self, problems: &mut Vec<Problem>) {
        let mut before = vec![0_usize; self.arrays.len()];
        for &next in self.arrays.iter().flat_map(|array| &array.next) {
            before[next] += 1;
        }
        let free = |(index, &count): (usize, &usize)| (count == 0).then_some(index);
        let mut waiting: Vec<usize> = before.iter().enumerate().filter_map(free).collect();
        while let Some(array) = waiting.pop() {
            for &next in &self.arrays[array].next {
                before[next] -= 1;
                if before[next] == 0 {
                    waiting.push(next);
                }
            }
        }
        // What stays leads, walked backwards among what stays, around a cycle.
        let stays = |array: usize| before[array] > 0;
        let Some(mut array) = (0..self.arrays.len()).find(|&array| stays(array)) else {
            return;
        };
        for _ in 0..self.arrays.len() {
            let mut all = 0..self.arrays.len();
            array = all
                .find(|&other| stays(other) && self.arrays[other].next.contains(&array))
                .unwrap_or(array);
        }
        problems.push(Problem::Cycle {
            array: self.arrays[array].name.clone(),
        });
    }

    /// All positions of all runs, as [`Protocol::new`] takes them. The graph has been checked.
    pub(super) fn expand(&self) -> Result<Vec<Node>, Problem> {
        let mut nodes = vec![Node {
            flag: 0,
            parent: 0,
            depth: 0,
            last: 0,
            path: 0,
        }];
        // The last one in comes first, so that everything below a node directly follows it.
        let mut waiting: Vec<(usize, u16)> = self.starts.iter().rev().map(|&s| (s, 0)).collect();
        while let Some((array, mut parent)) = waiting.pop() {
            let array = &self.arrays[array];
            for &flag in &array.flags {
                if is_set(&nodes, parent, flag) {
                    return Err(Problem::SetTwice {
                        flag: self.flags[flag.index()].name.to_string(),
                        array: array.name.clone(),
                    });
                }
                if nodes.len() >= Protocol::LIMIT {
                    return Err(Problem::TooLarge {
                        limit: Protocol::LIMIT,
                    });
                }
                let number = nodes.len() as u16;
                nodes.push(Node {
                    flag: flag.0,
                    parent,
                    depth: nodes[usize::from(parent)].depth + 1,
                    last: number,
                    path: 0,
                });
                parent = number;
            }
            waiting.extend(array.next.iter().rev().map(|&next| (next, parent)));
        }
        Ok(nodes)
    }
}

fn is_set(nodes: &[Node], mut at: u16, flag: FlagId) -> bool {
    while at != 0 {
        let node = nodes[usize::from(at)];
        if node.flag == flag.0 {
            return true;
        }
        at = node.parent;
    }
    false
}
