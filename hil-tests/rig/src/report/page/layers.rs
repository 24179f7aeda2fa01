//! A directed graph in layers from above to below, laid out by dagre (Sugiyama's method with network simplex layers and
//! Brandes and Köpf's coordinates).

use dagre::graph::{Graph, GraphOptions};
use dagre::{EdgeLabel, LayoutOptions, NodeLabel, layout};

use crate::report::draw::canvas::Px2;

/// Free room between neighbours in a layer, between edges that pass one, and between layers.
const GAP_PX: f64 = 14.0;
const EDGE_GAP_PX: f64 = 10.0;
const LAYER_GAP_PX: f64 = 30.0;
/// Node above all nodes that must stand at the top, and how short its edges must be compared with others.
const ROOT: &str = "root";
const ROOT_WEIGHT: i32 = 100;

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
    /// One polyline for each edge, source to target: the two nodes' places, and in between where it leaves and enters each
    /// layer. Within a layer it is upright; it goes aside between layers only.
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
    let mut graph = Graph::with_options(GraphOptions {
        directed: true,
        multigraph: true,
        compound: false,
    });
    for (node, extent) in extents.iter().enumerate() {
        // dagre knows centres only: a box is as large on both sides as on its larger one.
        let label = NodeLabel {
            width: 2.0 * extent.left_px.max(extent.right_px),
            height: 2.0 * half_height_px(extent),
            ..NodeLabel::default()
        };
        graph.set_node(node.to_string(), Some(label));
    }
    graph.set_node(ROOT, Some(NodeLabel::default()));
    for node in top {
        let label = EdgeLabel {
            weight: ROOT_WEIGHT,
            ..EdgeLabel::default()
        };
        graph.set_edge(ROOT, node.to_string(), Some(label), None);
    }
    let leads_back = |&(from, to): &(usize, usize)| top.contains(&to) && !top.contains(&from);
    let downward = edges.iter().map(|edge| match *edge {
        (from, to) if leads_back(edge) => [to, from].map(|node| node.to_string()),
        (from, to) => [from, to].map(|node| node.to_string()),
    });
    let downward: Vec<[String; 2]> = downward.collect();
    for (number, [from, to]) in downward.iter().enumerate() {
        let name = number.to_string();
        graph.set_edge(from, to, Some(EdgeLabel::default()), Some(&name));
    }
    let options = LayoutOptions {
        nodesep: GAP_PX,
        edgesep: EDGE_GAP_PX,
        ranksep: LAYER_GAP_PX,
        ..LayoutOptions::default()
    };
    layout(&mut graph, Some(options));
    let place = |node: usize| -> Px2 {
        let label = graph.node(&node.to_string());
        label.map_or([0.0; 2], |label| {
            [label.x.unwrap_or(0.0), label.y.unwrap_or(0.0)]
        })
    };
    let nodes: Vec<Px2> = (0..extents.len()).map(place).collect();
    let routes = downward.iter().zip(edges).enumerate();
    let routes = routes.map(|(number, ([from, to], edge))| {
        let label = graph.edge(from, to, Some(&number.to_string()));
        let points = label.map_or(&[][..], |label| &label.points);
        let passed: Vec<Px2> = points.iter().map(|point| [point.x, point.y]).collect();
        // The first and the last point are on the two nodes' borders.
        let between = passed.get(1..passed.len().max(2) - 1).unwrap_or_default();
        let mut between = between.to_vec();
        if leads_back(edge) {
            between.reverse();
        }
        route(extents, &nodes, *edge, &between)
    });
    let routes = routes.collect();
    shifted(extents, nodes, routes)
}

fn half_height_px(extent: &Extent) -> f64 {
    extent.above_px.max(extent.below_px)
}

/// From node to node past the layers between; layers are known by the places of their nodes.
fn route(
    extents: &[Extent],
    nodes: &[Px2],
    (from, to): (usize, usize),
    between: &[Px2],
) -> Vec<Px2> {
    const SAME_PX: f64 = 0.5;
    let half_px = |y_px: f64| {
        let layer = nodes
            .iter()
            .zip(extents)
            .filter(|(at, _)| (at[1] - y_px).abs() < SAME_PX);
        layer
            .map(|(_, extent)| half_height_px(extent))
            .reduce(f64::max)
    };
    let (first, last) = (nodes[from], nodes[to]);
    let direction = if first[1] < last[1] { 1.0 } else { -1.0 };
    let mut route = Vec::new();
    for [x, y] in std::iter::once(first)
        .chain(between.iter().copied())
        .chain([last])
    {
        // Half-way between two layers there are no nodes.
        if let Some(half_px) = half_px(y) {
            route.extend([[x, y - direction * half_px], [x, y + direction * half_px]]);
        }
    }
    let end = route.len() - 1;
    (route[0], route[end]) = (first, last);
    route
}

/// With the upper left corner of all nodes and edges at the origin.
fn shifted(extents: &[Extent], mut nodes: Vec<Px2>, mut routes: Vec<Vec<Px2>>) -> Layout {
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let mut include = |low: Px2, high: Px2| {
        for axis in 0..2 {
            min[axis] = min[axis].min(low[axis]);
            max[axis] = max[axis].max(high[axis]);
        }
    };
    for (at, extent) in nodes.iter().zip(extents) {
        include(
            [at[0] - extent.left_px, at[1] - extent.above_px],
            [at[0] + extent.right_px, at[1] + extent.below_px],
        );
    }
    for at in routes.iter().flatten() {
        include(*at, *at);
    }
    for at in nodes.iter_mut().chain(routes.iter_mut().flatten()) {
        *at = [0, 1].map(|axis| at[axis] - min[axis]);
    }
    Layout {
        nodes,
        routes,
        size: [0, 1].map(|axis| max[axis] - min[axis]),
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
        let end = back.len() - 1;
        assert_eq!((back[0], back[end]), (layout.nodes[3], layout.nodes[0]));
        assert!(end >= 7, "it passes two layers: {back:?}");
        for between in &back[2..end - 1] {
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
