//! The invariants of a net by the numbers of its internal places, and what they prove.

use std::collections::HashMap;

use super::semiflows::semiflows;
use super::work::Work;
use crate::petri::{NetModel, PlaceKind};

pub(super) struct Numbered<'a> {
    /// Of internal places.
    pub(super) names: Vec<&'a str>,
    pub(super) numbers: HashMap<&'a str, u32>,
    /// By invariant: its places with their weights, and its tokens.
    pub(super) found: Vec<(Vec<(u32, u32)>, u64)>,
    pub(super) is_complete: bool,
}

impl<'a> Numbered<'a> {
    pub(super) fn of(model: &'a NetModel, work: &mut Work) -> Self {
        let (mut names, mut marked) = (Vec::new(), Vec::new());
        for place in model
            .places()
            .filter(|place| place.kind == PlaceKind::Internal)
        {
            names.push(place.name);
            marked.push(place.marked);
        }
        let numbers: HashMap<&str, u32> = names.iter().copied().zip(0..).collect();
        let changes = model.transitions().map(|transition| {
            let mut changes: HashMap<u32, i64> = HashMap::new();
            let number = |place: &&str| numbers.get(place).copied();
            for place in transition.inputs.iter().filter_map(number) {
                *changes.entry(place).or_default() -= 1;
            }
            for place in transition.outputs.iter().filter_map(number) {
                *changes.entry(place).or_default() += 1;
            }
            changes.into_iter().collect()
        });
        let (semiflows, is_complete) = semiflows(names.len(), changes.collect(), work);
        let found = semiflows.into_iter().map(|weights| {
            let tokens = { weights.iter() }
                .filter(|&&(place, _)| marked[place as usize])
                .map(|&(_, weight)| u64::from(weight))
                .sum();
            (weights, tokens)
        });
        Self {
            found: found.collect(),
            names,
            numbers,
            is_complete,
        }
    }

    /// By place, the most tokens that it can hold; the largest number if no invariant tells.
    pub(super) fn bounds(&self) -> Vec<u64> {
        let mut bounds = vec![u64::MAX; self.names.len()];
        for (weights, tokens) in &self.found {
            for &(place, weight) in weights {
                let bound = &mut bounds[place as usize];
                *bound = (*bound).min(tokens / u64::from(weight));
            }
        }
        bounds
    }

    /// Of some sets of places, given by names, those of which surely never two places are marked; as far as there is
    /// work left to look.
    pub(super) fn excluded<'s>(
        &self,
        sets: impl Iterator<Item = (&'s str, Vec<&'s str>)>,
        bounds: &[u64],
        work: &mut Work,
    ) -> Vec<String> {
        // By place: its invariants, and its weights there.
        let mut with: Vec<Vec<(u32, u32)>> = vec![Vec::new(); self.names.len()];
        for (number, (weights, _)) in (0..).zip(&self.found) {
            for &(place, weight) in weights {
                with[place as usize].push((number, weight));
            }
        }
        // By place: the last one with which it is surely never marked, of those looked at.
        let mut apart = vec![u32::MAX; self.names.len()];
        let never = |&place: &Option<u32>| place.is_some_and(|place| bounds[place as usize] == 0);
        let mut holds = |places: &[&str]| {
            let places = places.iter().map(|place| self.numbers.get(place).copied());
            let places: Vec<Option<u32>> = places.filter(|place| !never(place)).collect();
            places.iter().enumerate().all(|(index, &one)| {
                let Some(one) = one else {
                    return places.len() == 1;
                };
                for &(number, weight) in &with[one as usize] {
                    let (weights, tokens) = &self.found[number as usize];
                    if !work.take(weights.len()) {
                        return false;
                    }
                    for &(other, other_weight) in weights {
                        if u64::from(weight) + u64::from(other_weight) > *tokens {
                            apart[other as usize] = one;
                        }
                    }
                }
                let mut others = places[index + 1..].iter();
                work.take(others.len())
                    && others.all(|other| other.is_some_and(|other| apart[other as usize] == one))
            })
        };
        let held = sets.filter(|(_, places)| holds(places));
        held.map(|(name, _)| name.to_owned()).collect()
    }
}
