//! A directed graph in layers, from above to below, as Sugiyama, Tagawa and Toda (1981) do it: break cycles, assign
//! layers, order each layer so that few edges cross, then straighten.
//!
//! For the small graphs of coordination nets; the work grows with the square of the edges in a layer.

use crate::report::draw::canvas::Px2;

/// Sweeps over all layers when ordering, and when straightening.
const ORDERING_SWEEPS: usize = 24;
const STRAIGHTENING_SWEEPS: usize = 40;
/// Free room between neighbours in a layer, and between layers.
const GAP_PX: f64 = 14.0;
const LAYER_GAP_PX: f64 = 24.0;
/// Half the room that an edge takes when it passes a layer.
const EDGE_PX: f64 = 5.0;

/// What a node covers around the point where its edges end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Extent {
    pub(super) left_px: f64,
    pub(super) right_px: f64,
    pub(super) above_px: f64,
    pub(super) below_px: f64,
}

/// Where everything stands; the upper left corner is the origin.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Layout {
    /// By node.
    pub(super) nodes: Vec<Px2>,
    /// By edge, from its beginning to its end: the two nodes' places, and in between where it leaves and enters each
    /// layer. Within a layer it is upright; aside it goes only between layers.
    pub(super) routes: Vec<Vec<Px2>>,
    /// Width and height of all.
    pub(super) size: Px2,
}

/// Lays out a graph. The nodes in `top` stand at the top, whatever leads back to them; edges from a node to itself are
/// not allowed.
pub(super) fn lay_out(extents: &[Extent], edges: &[(usize, usize)], top: &[usize]) -> Layout {
    if extents.is_empty() {
        return Layout {
            routes: vec![Vec::new(); edges.len()],
            ..Layout::default()
        };
    }
    let (downward, visited) = without_cycles(extents.len(), edges, top);
    let layer_of = layers_of(extents.len(), &downward);
    let mut graph = Layered::new(extents, &downward, &layer_of, &visited);
    graph.order();
    graph.straighten();
    graph.finish(extents.len(), edges, &downward)
}

/// The edges, with those turned round that would lead back; and the nodes in the order of their first visit.
fn without_cycles(
    nodes: usize,
    edges: &[(usize, usize)],
    top: &[usize],
) -> (Vec<(usize, usize)>, Vec<usize>) {
    const NEW: u8 = 0;
    const OPEN: u8 = 1;
    const CLOSED: u8 = 2;
    let mut outgoing: Vec<Vec<usize>> = vec![Vec::new(); nodes];
    for (index, &(from, _)) in edges.iter().enumerate() {
        outgoing[from].push(index);
    }
    let mut downward = edges.to_vec();
    let (mut state, mut visited) = (vec![NEW; nodes], Vec::new());
    for root in top.iter().copied().chain(0..nodes) {
        if state[root] != NEW {
            continue;
        }
        state[root] = OPEN;
        visited.push(root);
        let mut stack = vec![(root, 0)];
        while let Some((node, next)) = stack.pop() {
            let Some(&edge) = outgoing[node].get(next) else {
                state[node] = CLOSED;
                continue;
            };
            stack.push((node, next + 1));
            let to = edges[edge].1;
            if top.contains(&to) && !top.contains(&node) {
                downward[edge] = (to, node);
                continue;
            }
            match state[to] {
                NEW => {
                    state[to] = OPEN;
                    visited.push(to);
                    stack.push((to, 0));
                }
                OPEN => downward[edge] = (to, node),
                _ => {}
            }
        }
    }
    (downward, visited)
}

/// Each node as high as its predecessors allow, then lower where that shortens more edges than it lengthens.
fn layers_of(nodes: usize, downward: &[(usize, usize)]) -> Vec<usize> {
    let mut layer = vec![0; nodes];
    // The longest way has fewer edges than there are nodes.
    for _ in 0..nodes {
        let mut changed = false;
        for &(from, to) in downward {
            if layer[to] <= layer[from] {
                layer[to] = layer[from] + 1;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    for _ in 0..nodes {
        let mut changed = false;
        for node in 0..nodes {
            let below = downward.iter().filter(|edge| edge.0 == node);
            let above = downward.iter().filter(|edge| edge.1 == node).count();
            let count = below.clone().count();
            let lowest = below.map(|edge| layer[edge.1]).min();
            // What begins at the top stays there.
            if let Some(lowest) = lowest
                && above > 0
                && count > above
                && lowest > layer[node] + 1
            {
                layer[node] = lowest - 1;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    layer
}

/// Nodes and, where an edge passes a layer, what stands for it.
struct Layered {
    extents: Vec<Extent>,
    /// Neighbours above and below, and how much each edge wants to be straight.
    above: Vec<Vec<(usize, f64)>>,
    below: Vec<Vec<(usize, f64)>>,
    layers: Vec<Vec<usize>>,
    /// By edge: the nodes on its way, from above to below.
    chains: Vec<Vec<usize>>,
    x_px: Vec<f64>,
}

impl Layered {
    fn new(
        extents: &[Extent],
        downward: &[(usize, usize)],
        layer_of: &[usize],
        visited: &[usize],
    ) -> Self {
        let depth = layer_of.iter().max().map_or(0, |deepest| deepest + 1);
        let mut graph = Self {
            extents: extents.to_vec(),
            above: vec![Vec::new(); extents.len()],
            below: vec![Vec::new(); extents.len()],
            layers: vec![Vec::new(); depth],
            chains: Vec::new(),
            x_px: Vec::new(),
        };
        for &node in visited {
            graph.layers[layer_of[node]].push(node);
        }
        for &(from, to) in downward {
            let mut chain = vec![from];
            for layer in layer_of[from] + 1..layer_of[to] {
                let passing = graph.extents.len();
                graph.extents.push(Extent {
                    left_px: EDGE_PX,
                    right_px: EDGE_PX,
                    ..Extent::default()
                });
                graph.above.push(Vec::new());
                graph.below.push(Vec::new());
                graph.layers[layer].push(passing);
                chain.push(passing);
            }
            chain.push(to);
            for pair in chain.windows(2) {
                let real = pair.iter().filter(|&&node| node < extents.len()).count();
                let weight = [8.0, 2.0, 1.0][real];
                graph.below[pair[0]].push((pair[1], weight));
                graph.above[pair[1]].push((pair[0], weight));
            }
            graph.chains.push(chain);
        }
        graph
    }

    /// Orders the layers; the best of all sweeps is kept.
    fn order(&mut self) {
        let mut best = (self.crossings(), self.layers.clone());
        for sweep in 0..ORDERING_SWEEPS {
            let depth = self.layers.len();
            for step in 0..depth {
                let (layer, neighbours) = if sweep % 2 == 0 {
                    (step, &self.above)
                } else {
                    (depth - 1 - step, &self.below)
                };
                let place = self.places();
                let middle = |node: usize| {
                    let near = &neighbours[node];
                    let sum: f64 = near.iter().map(|&(other, _)| place[other] as f64).sum();
                    if near.is_empty() {
                        place[node] as f64
                    } else {
                        sum / near.len() as f64
                    }
                };
                let mut nodes = self.layers[layer].clone();
                nodes.sort_by(|&a, &b| middle(a).total_cmp(&middle(b)));
                self.layers[layer] = nodes;
            }
            self.swap_neighbours();
            let crossings = self.crossings();
            if crossings < best.0 {
                best = (crossings, self.layers.clone());
            }
        }
        self.layers = best.1;
    }

    /// Swaps neighbours where that removes crossings.
    fn swap_neighbours(&mut self) {
        for layer in 0..self.layers.len() {
            for index in 1..self.layers[layer].len() {
                let place = self.places();
                let (left, right) = (self.layers[layer][index - 1], self.layers[layer][index]);
                let crossings = |first: usize, second: usize| -> usize {
                    [&self.above, &self.below]
                        .iter()
                        .map(|near| {
                            let of_second = &near[second];
                            let crossed = |a: usize| {
                                of_second
                                    .iter()
                                    .filter(|(b, _)| place[a] > place[*b])
                                    .count()
                            };
                            near[first].iter().map(|&(a, _)| crossed(a)).sum::<usize>()
                        })
                        .sum()
                };
                if crossings(right, left) < crossings(left, right) {
                    self.layers[layer].swap(index - 1, index);
                }
            }
        }
    }

    /// Each node's place in its layer.
    fn places(&self) -> Vec<usize> {
        let mut places = vec![0; self.extents.len()];
        for layer in &self.layers {
            for (place, &node) in layer.iter().enumerate() {
                places[node] = place;
            }
        }
        places
    }

    fn crossings(&self) -> usize {
        let place = self.places();
        let between = |layer: &Vec<usize>| {
            let edges: Vec<(usize, usize)> = layer
                .iter()
                .flat_map(|&node| self.below[node].iter().map(move |&(to, _)| (node, to)))
                .map(|(from, to)| (place[from], place[to]))
                .collect();
            let crossed = |index: usize| {
                edges[index + 1..]
                    .iter()
                    .filter(|later| {
                        (edges[index].0 < later.0 && edges[index].1 > later.1)
                            || (edges[index].0 > later.0 && edges[index].1 < later.1)
                    })
                    .count()
            };
            (0..edges.len()).map(crossed).sum::<usize>()
        };
        self.layers.iter().map(between).sum()
    }

    /// Moves nodes towards their neighbours as far as those beside them allow.
    fn straighten(&mut self) {
        self.x_px = vec![0.0; self.extents.len()];
        for layer in self.layers.clone() {
            let mut x_px = 0.0;
            for node in layer {
                x_px += self.extents[node].left_px;
                self.x_px[node] = x_px;
                x_px += self.extents[node].right_px + GAP_PX;
            }
        }
        let depth = self.layers.len();
        for sweep in 0..STRAIGHTENING_SWEEPS {
            // First one side at a time, so that all finds its place, then both.
            let both = sweep >= STRAIGHTENING_SWEEPS / 2;
            for step in 0..depth {
                let layer = if sweep % 2 == 0 {
                    step
                } else {
                    depth - 1 - step
                };
                let wanted: Vec<(f64, f64)> = self.layers[layer]
                    .iter()
                    .map(|&node| {
                        let near: Vec<(usize, f64)> = match (both, sweep % 2) {
                            (true, _) => [&self.above[node][..], &self.below[node]].concat(),
                            (false, 0) => self.above[node].clone(),
                            (false, _) => self.below[node].clone(),
                        };
                        self.wanted(node, &near)
                    })
                    .collect();
                self.place_layer(layer, &wanted);
            }
        }
    }

    /// Where a node wants to be, and how much: at the median of its neighbours.
    fn wanted(&self, node: usize, near: &[(usize, f64)]) -> (f64, f64) {
        let mut near: Vec<(f64, f64)> = near
            .iter()
            .map(|&(other, weight)| (self.x_px[other], weight))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = near.iter().map(|near| near.1).sum();
        if near.is_empty() {
            return (self.x_px[node], 0.1);
        }
        let mut sum = 0.0;
        for (index, &(x_px, weight)) in near.iter().enumerate() {
            sum += weight;
            if 2.0 * sum > total + 1e-9 {
                return (x_px, total);
            }
            if 2.0 * sum > total - 1e-9 {
                // Anywhere between the two is as good: where it is.
                let next_px = near.get(index + 1).map_or(x_px, |next| next.0);
                return (self.x_px[node].clamp(x_px, next_px), total);
            }
        }
        (near[near.len() - 1].0, total)
    }

    /// The places nearest to those wanted, in least squares, that keep order and distances: pool adjacent violators.
    fn place_layer(&mut self, layer: usize, wanted: &[(f64, f64)]) {
        struct Pool {
            mean_px: f64,
            weight: f64,
            count: usize,
        }
        let nodes = &self.layers[layer];
        let mut offsets_px = Vec::with_capacity(nodes.len());
        let mut offset_px = 0.0;
        for (index, &node) in nodes.iter().enumerate() {
            if index > 0 {
                let before = self.extents[nodes[index - 1]];
                offset_px += before.right_px + GAP_PX + self.extents[node].left_px;
            }
            offsets_px.push(offset_px);
        }
        let mut pools: Vec<Pool> = Vec::new();
        for (&(x_px, weight), offset_px) in wanted.iter().zip(&offsets_px) {
            let mut pool = Pool {
                mean_px: x_px - offset_px,
                weight,
                count: 1,
            };
            while let Some(last) = pools.pop_if(|last| last.mean_px > pool.mean_px) {
                let weight = last.weight + pool.weight;
                pool = Pool {
                    mean_px: (last.mean_px * last.weight + pool.mean_px * pool.weight) / weight,
                    weight,
                    count: last.count + pool.count,
                };
            }
            pools.push(pool);
        }
        let means = pools
            .iter()
            .flat_map(|pool| std::iter::repeat_n(pool.mean_px, pool.count));
        for ((&node, mean_px), offset_px) in nodes.iter().zip(means).zip(&offsets_px) {
            self.x_px[node] = mean_px + offset_px;
        }
    }

    /// Room under a layer: more where many edges lead far aside.
    fn gap_px(&self, layer: usize) -> f64 {
        const ASIDE_PX: f64 = 120.0;
        const EACH_PX: f64 = 2.5;
        const MOST_PX: f64 = 30.0;
        let nodes = self.layers[layer].iter();
        let aside = nodes
            .flat_map(|&node| self.below[node].iter().map(move |&(to, _)| (node, to)))
            .filter(|&(from, to)| (self.x_px[from] - self.x_px[to]).abs() > ASIDE_PX);
        LAYER_GAP_PX + (EACH_PX * aside.count() as f64).min(MOST_PX)
    }

    fn finish(self, nodes: usize, edges: &[(usize, usize)], downward: &[(usize, usize)]) -> Layout {
        let bound = |pick: fn(&Extent) -> f64, layer: &[usize]| {
            let picked = layer.iter().map(|&node| pick(&self.extents[node]));
            picked.fold(0.0, f64::max)
        };
        let all = || self.extents.iter().zip(&self.x_px);
        let left_px = all()
            .map(|(extent, x_px)| x_px - extent.left_px)
            .fold(f64::INFINITY, f64::min);
        let right_px = all()
            .map(|(extent, x_px)| x_px + extent.right_px)
            .fold(f64::NEG_INFINITY, f64::max);
        let mut at = vec![[0.0; 2]; self.extents.len()];
        // Where the layer of a node begins and ends.
        let mut within = vec![[0.0; 2]; self.extents.len()];
        let mut y_px = 0.0;
        for (index, layer) in self.layers.iter().enumerate() {
            if index > 0 {
                y_px += self.gap_px(index - 1);
            }
            let top_px = y_px;
            y_px += bound(|extent| extent.above_px, layer);
            for &node in layer {
                at[node] = [self.x_px[node] - left_px, y_px];
            }
            y_px += bound(|extent| extent.below_px, layer);
            for &node in layer {
                within[node] = [top_px, y_px];
            }
        }
        let routes = self.chains.iter().zip(edges).zip(downward);
        let routes = routes
            .map(|((chain, edge), downward)| {
                let borders = |&node: &usize| within[node].map(|y_px| [at[node][0], y_px]);
                let passed = chain.iter().flat_map(borders);
                let mut route: Vec<Px2> = passed.collect();
                // Not above the first node, nor below the last.
                if let (Some(first), Some(last)) = (chain.first(), chain.last()) {
                    let end = route.len() - 1;
                    (route[0], route[end]) = (at[*first], at[*last]);
                }
                if edge != downward {
                    route.reverse();
                }
                route
            })
            .collect();
        at.truncate(nodes);
        Layout {
            nodes: at,
            routes,
            size: [right_px - left_px, y_px],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOX: Extent = Extent {
        left_px: 20.0,
        right_px: 30.0,
        above_px: 8.0,
        below_px: 8.0,
    };

    fn apart(layout: &Layout) {
        for (index, a) in layout.nodes.iter().enumerate() {
            assert!(a[0] >= BOX.left_px - 1e-6 && a[0] + BOX.right_px <= layout.size[0] + 1e-6);
            assert!(a[1] >= BOX.above_px - 1e-6 && a[1] + BOX.below_px <= layout.size[1] + 1e-6);
            for b in &layout.nodes[..index] {
                let beside = (a[0] - b[0]).abs() >= BOX.left_px + BOX.right_px - 1e-6;
                let under = (a[1] - b[1]).abs() >= BOX.above_px + BOX.below_px - 1e-6;
                assert!(beside || under, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn a_chain_is_a_straight_line_downwards() {
        let layout = lay_out(&[BOX; 4], &[(0, 1), (1, 2), (2, 3)], &[0]);
        apart(&layout);
        for pair in layout.nodes.windows(2) {
            assert!((pair[0][0] - pair[1][0]).abs() < 1e-6 && pair[0][1] < pair[1][1]);
        }
    }

    #[test]
    fn a_way_back_leads_up_past_the_nodes_between() {
        let edges = [(0, 1), (1, 2), (2, 3), (3, 0)];
        let layout = lay_out(&[BOX; 4], &edges, &[0]);
        apart(&layout);
        let back = &layout.routes[3];
        assert_eq!((back[0], back[7]), (layout.nodes[3], layout.nodes[0]));
        for between in &back[2..6] {
            let beside = |node: &Px2| (node[0] - between[0]).abs() > BOX.left_px;
            assert!(layout.nodes[1..3].iter().all(beside), "{between:?}");
        }
    }

    #[test]
    fn crossings_that_need_not_be_are_removed() {
        // Two chains whose nodes are named the wrong way round.
        let edges = [(0, 3), (1, 2), (2, 5), (3, 4)];
        let layout = lay_out(&[BOX; 6], &edges, &[0, 1]);
        apart(&layout);
        let x = |node: usize| layout.nodes[node][0];
        assert_eq!(x(0) < x(1), x(3) < x(2));
        assert_eq!(x(3) < x(2), x(4) < x(5));
    }

    #[test]
    fn any_graph_is_laid_out_without_overlap() {
        let mut state = 7_u64;
        let mut below = |bound: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((state >> 33) % bound) as usize
        };
        for _ in 0..30 {
            let nodes = 2 + below(24);
            let edges: Vec<(usize, usize)> = (0..below(40))
                .map(|_| (below(nodes as u64), below(nodes as u64)))
                .filter(|(from, to)| from != to)
                .collect();
            let layout = lay_out(&vec![BOX; nodes], &edges, &[]);
            apart(&layout);
            for (route, &(from, to)) in layout.routes.iter().zip(&edges) {
                assert_eq!(route.first(), Some(&layout.nodes[from]));
                assert_eq!(route.last(), Some(&layout.nodes[to]));
            }
        }
        assert_eq!(lay_out(&[], &[], &[]), Layout::default());
    }
}
