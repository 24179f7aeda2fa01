//! Questions about the whole graph of states, once all of it is known.

/// Steps between states, each as (from, to).
pub(super) type Edges = [(u32, u32)];

/// For each state, whether one of the `targets` can be reached from it.
pub(super) fn can_reach(
    states: usize,
    edges: &Edges,
    targets: impl Iterator<Item = u32>,
) -> Vec<bool> {
    Backwards::new(states, edges).can_reach(targets)
}

/// The steps sorted by where they lead, for several questions to one graph.
pub(super) struct Backwards {
    begins: Vec<u32>,
    sources: Vec<u32>,
}

impl Backwards {
    pub(super) fn new(states: usize, edges: &Edges) -> Self {
        let (begins, sources) = by_target(states, edges);
        Self { begins, sources }
    }

    /// From where one step leads to `state`.
    fn before(&self, state: u32) -> &[u32] {
        let state = state as usize;
        &self.sources[self.begins[state] as usize..self.begins[state + 1] as usize]
    }

    /// For each state, whether one of the `targets` can be reached from it.
    pub(super) fn can_reach(&self, targets: impl Iterator<Item = u32>) -> Vec<bool> {
        let mut can = vec![false; self.begins.len() - 1];
        let mut waiting = Vec::new();
        for target in targets {
            if !std::mem::replace(&mut can[target as usize], true) {
                waiting.push(target);
            }
        }
        while let Some(state) = waiting.pop() {
            for &before in self.before(state) {
                if !std::mem::replace(&mut can[before as usize], true) {
                    waiting.push(before);
                }
            }
        }
        can
    }
}

/// The first state from which one can go on for ever along these steps.
pub(super) fn first_endless(states: usize, edges: &Edges) -> Option<u32> {
    let endless = endless(states, edges);
    (0..states as u32).find(|&state| endless[state as usize])
}

/// The states that remain when those without steps out of them are taken away, again and again.
fn endless(states: usize, edges: &Edges) -> Vec<bool> {
    let mut out = vec![0_u32; states];
    for &(from, _) in edges {
        out[from as usize] += 1;
    }
    let backwards = Backwards::new(states, edges);
    let mut waiting: Vec<u32> = (0..states as u32)
        .filter(|&s| out[s as usize] == 0)
        .collect();
    while let Some(state) = waiting.pop() {
        for &before in backwards.before(state) {
            out[before as usize] -= 1;
            if out[before as usize] == 0 {
                waiting.push(before);
            }
        }
    }
    out.into_iter().map(|count| count > 0).collect()
}

/// The edges sorted by target: where each target's edges begin, and the sources.
fn by_target(states: usize, edges: &Edges) -> (Vec<u32>, Vec<u32>) {
    let mut begins = vec![0_u32; states + 1];
    for &(_, to) in edges {
        begins[to as usize + 1] += 1;
    }
    for state in 0..states {
        begins[state + 1] += begins[state];
    }
    let mut next = begins.clone();
    let mut sources = vec![0_u32; edges.len()];
    for &(from, to) in edges {
        sources[next[to as usize] as usize] = from;
        next[to as usize] += 1;
    }
    (begins, sources)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_can_reach_a_target_is_found_backwards() {
        let edges = [(0, 1), (1, 2), (2, 1), (0, 3), (3, 3), (1, 4)];
        let can = can_reach(5, &edges, [4].into_iter());
        assert_eq!(can, [true, true, true, false, true]);
        assert_eq!(can_reach(5, &edges, std::iter::empty()), [false; 5]);
    }

    #[test]
    fn what_leads_onto_a_circle_is_endless() {
        assert_eq!(
            first_endless(5, &[(1, 2), (2, 3), (3, 2), (3, 4), (0, 4)]),
            Some(1)
        );
        assert_eq!(first_endless(4, &[(0, 1), (0, 2), (1, 3), (2, 3)]), None);
        assert_eq!(first_endless(2, &[(1, 1)]), Some(1));
        assert_eq!(first_endless(0, &[]), None);
    }
}
