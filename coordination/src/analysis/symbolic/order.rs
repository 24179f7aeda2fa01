//! An order of variables in which those that steps touch together stand near each other, so that
//! diagrams stay small.

use std::cmp::Reverse;
use std::collections::BTreeSet;

use super::super::closed::rule::Rules;

/// A variable that this many times as many rules touch as the mean comes last: else what it joins would
/// be pulled apart. Each is tried.
const HUB_TIMES: [usize; 3] = [4, 16, 64];

/// A rule that touches more variables brings none of them near to another.
const LARGEST_GROUP: usize = 512;

/// `order[new]` is the old number: as declared or greedily, with or without some last, whichever
/// keeps rules shortest and lowest.
pub(super) fn order(rules: &Rules) -> Vec<u32> {
    let variables = rules.meanings.len();
    let mut groups: Vec<Vec<u32>> = Vec::with_capacity(rules.rules.len());
    for rule in &rules.rules {
        let mut group: Vec<u32> = rule.literals().map(|literal| literal.variable).collect();
        group.sort_unstable();
        group.dedup();
        groups.push(group);
    }
    let mut touching = vec![0_usize; variables];
    for &variable in groups.iter().flatten() {
        touching[variable as usize] += 1;
    }
    let all: usize = touching.iter().sum();
    let mean = all.div_ceil(variables.max(1));
    let declared: Vec<u32> = (0..variables as u32).collect();
    let mut orders = vec![declared.clone()];
    for times in HUB_TIMES {
        let is_hub = |variable: u32| touching[variable as usize] > times * mean;
        let (last, mut first): (Vec<u32>, Vec<u32>) = declared.iter().partition(|&&v| is_hub(v));
        first.extend(last);
        orders.push(first);
        orders.push(greedy(variables, &groups, is_hub));
    }
    let best = orders.into_iter().min_by_key(|order| cost(order, &groups));
    best.unwrap_or(declared)
}

/// How far the variables of rules are apart, and how far up they begin, over all rules.
fn cost(order: &[u32], groups: &[Vec<u32>]) -> u64 {
    let mut place = vec![0_u32; order.len()];
    for (&variable, number) in order.iter().zip(0..) {
        place[variable as usize] = number;
    }
    let cost = |group: &Vec<u32>| {
        let places = group.iter().map(|&variable| place[variable as usize]);
        let least = places.clone().min().unwrap_or(0);
        let span = places.max().unwrap_or(0) - least;
        u64::from(span) + order.len() as u64 - u64::from(least)
    };
    groups.iter().map(cost).sum()
}

/// Next comes the variable whose rules have most of their variables in the order already; of
/// several the one that was touched last, then the one that fewest rules touch.
fn greedy(variables: usize, groups: &[Vec<u32>], is_hub: impl Fn(u32) -> bool) -> Vec<u32> {
    let mut member = vec![Vec::new(); variables];
    for (number, group) in groups.iter().enumerate() {
        for &variable in group {
            member[variable as usize].push(number as u32);
        }
    }
    let place = |variable: u32, (sum, touched): (f64, usize)| {
        let among = member[variable as usize].len();
        let nearness = sum / among.max(1) as f64;
        Place {
            is_first: !is_hub(variable),
            nearness_bits: nearness.to_bits(),
            touched,
            among: Reverse(among),
            variable: Reverse(variable),
        }
    };
    let mut near = vec![(0.0_f64, 0_usize); variables];
    let all = 0..variables as u32;
    let mut left: BTreeSet<Place> = all.map(|own| place(own, (0.0, 0))).collect();
    let mut order = Vec::with_capacity(variables);
    while let Some(Place { variable, .. }) = left.pop_last() {
        let Reverse(chosen) = variable;
        order.push(chosen);
        let groups = { member[chosen as usize].iter() }.map(|&number| &groups[number as usize]);
        for group in groups.filter(|group| group.len() <= LARGEST_GROUP) {
            for &other in group {
                let own = &mut near[other as usize];
                let is_left = left.remove(&place(other, *own));
                own.0 += 1.0 / group.len() as f64;
                own.1 = order.len();
                if is_left {
                    left.insert(place(other, *own));
                }
            }
        }
    }
    order
}

/// Where a variable stands among those that are left: the last of them comes next.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    is_first: bool,
    /// Of a number that is not negative: they grow with it.
    nearness_bits: u64,
    touched: usize,
    among: Reverse<usize>,
    /// Of several alike the one that was declared first.
    variable: Reverse<u32>,
}
