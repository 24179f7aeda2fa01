//! Strongly connected components of the graph of states (Tarjan 1972).

use super::graph::Edges;

const NONE: u32 = u32::MAX;

/// Sets of states that lead to each other.
pub(super) struct Components {
    /// By state: its component. Every step stays in its component or leads to one with a smaller number.
    pub(super) of: Vec<u32>,
    /// All states, component by component.
    pub(super) order: Vec<u32>,
    pub(super) count: usize,
    /// By component, whether no step leaves it.
    last: Vec<bool>,
    /// By state: where its steps begin.
    begins: Vec<u32>,
}

impl Components {
    /// The steps are in the order of the states from which they lead.
    pub(super) fn new(states: usize, edges: &Edges) -> Self {
        debug_assert!(edges.is_sorted_by_key(|&(from, _)| from));
        let mut begins = vec![0_u32; states + 1];
        for &(from, _) in edges {
            begins[from as usize + 1] += 1;
        }
        for state in 0..states {
            begins[state + 1] += begins[state];
        }
        let mut components = Self {
            of: vec![NONE; states],
            order: Vec::with_capacity(states),
            count: 0,
            last: Vec::new(),
            begins,
        };
        components.search(edges);
        components.last = vec![true; components.count];
        for &(from, to) in edges {
            let (from, to) = (components.of[from as usize], components.of[to as usize]);
            components.last[from as usize] &= from == to;
        }
        components
    }

    fn search(&mut self, edges: &Edges) {
        let states = self.of.len();
        // By state: its number in the order of visits, then the smallest that it leads back to.
        let mut low = vec![NONE; states];
        let mut visits = 0_u32;
        // States whose component is not known yet, and the way to where the search is: each with its number, and
        // the step to be taken next.
        let (mut open, mut way): (Vec<u32>, Vec<(u32, u32, u32)>) = (Vec::new(), Vec::new());
        for root in 0..states as u32 {
            let mut next = (low[root as usize] == NONE).then_some(root);
            loop {
                if let Some(state) = next.take() {
                    low[state as usize] = visits;
                    way.push((state, visits, self.begins[state as usize]));
                    open.push(state);
                    visits += 1;
                }
                let Some((state, number, step)) = way.last_mut() else {
                    break;
                };
                let (own, number) = (*state as usize, *number);
                if *step < self.begins[own + 1] {
                    let (_, to) = edges[*step as usize];
                    *step += 1;
                    if low[to as usize] == NONE {
                        next = Some(to);
                    } else if self.of[to as usize] == NONE {
                        low[own] = low[own].min(low[to as usize]);
                    }
                    continue;
                }
                way.pop();
                if low[own] == number {
                    self.close(own as u32, &mut open);
                } else if let Some(&(before, ..)) = way.last() {
                    low[before as usize] = low[before as usize].min(low[own]);
                }
            }
        }
    }

    /// What is open since `first` was visited is a component.
    fn close(&mut self, first: u32, open: &mut Vec<u32>) {
        while let Some(state) = open.pop() {
            self.of[state as usize] = self.count as u32;
            self.order.push(state);
            if state == first {
                break;
            }
        }
        self.count += 1;
    }

    /// By component, whether no step leaves it.
    pub(super) fn last(&self) -> &[bool] {
        &self.last
    }

    /// The steps from `state`, of the steps that the components are made of.
    pub(super) fn steps_from<'e>(&self, state: u32, edges: &'e Edges) -> &'e Edges {
        let state = state as usize;
        &edges[self.begins[state] as usize..self.begins[state + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::super::graph::can_reach;
    use super::*;

    #[test]
    fn a_circle_is_one_and_comes_before_what_leads_to_it() {
        let edges = [(0, 1), (1, 2), (2, 1), (2, 3), (3, 3), (4, 3)];
        let found = Components::new(5, &edges);
        assert_eq!(found.count, 4);
        assert_eq!(found.of, [2, 1, 1, 0, 3]);
        assert_eq!(found.last(), [true, false, false, false]);
        assert_eq!(found.steps_from(2, &edges), [(2, 1), (2, 3)]);
        assert_eq!(Components::new(0, &[]).count, 0);
    }

    #[test]
    fn a_way_of_any_length_is_no_deep_recursion() {
        let long = 1_000_000;
        let mut edges: Vec<(u32, u32)> = (0..long - 1).map(|state| (state, state + 1)).collect();
        assert_eq!(Components::new(long as usize, &edges).count, long as usize);
        edges.push((long - 1, 0));
        assert_eq!(Components::new(long as usize, &edges).count, 1);
    }

    #[test]
    fn states_are_together_that_lead_to_each_other() {
        let mut random = 0x9E37_79B9_7F4A_7C15_u64;
        let mut below = |limit: u32| {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            (random % u64::from(limit)) as u32
        };
        for _ in 0..500 {
            let states = 1 + below(12);
            let count = below(24);
            let mut edges: Vec<_> = { 0..count }
                .map(|_| (below(states), below(states)))
                .collect();
            edges.sort_unstable();
            let found = Components::new(states as usize, &edges);
            let reach: Vec<Vec<bool>> = { 0..states }
                .map(|to| can_reach(states as usize, &edges, [to].into_iter()))
                .collect();
            for (a, b) in
                (0..states as usize).flat_map(|a| (0..states as usize).map(move |b| (a, b)))
            {
                let together = reach[a][b] && reach[b][a];
                assert_eq!(found.of[a] == found.of[b], together, "{edges:?}");
            }
            assert!(
                edges
                    .iter()
                    .all(|&(from, to)| found.of[from as usize] >= found.of[to as usize])
            );
            let runs = found
                .order
                .chunk_by(|&a, &b| found.of[a as usize] == found.of[b as usize]);
            assert_eq!(runs.count(), found.count, "{edges:?}");
        }
    }
}
