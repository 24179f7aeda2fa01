//! The arcs of a net's drawing.

use crate::report::draw::canvas::{Canvas, Curve, Px2};

use super::layers::Layout;

pub(super) const PLACE_PX: f64 = 8.5;
/// Half a bar's length, and half its thickness.
pub(super) const BAR_PX: Px2 = [18.0, 3.0];
pub(super) const TIP_PX: Px2 = [3.6, 7.5];

/// An arc between an internal place and a transition.
pub(super) struct Arc<'a> {
    pub(super) from: usize,
    pub(super) to: usize,
    /// The transition takes the token and puts it back.
    pub(super) both: bool,
    pub(super) transition: &'a str,
}

/// Draws arcs between nodes of which the first `places` are places; arcs of transitions that `never` fired are pale.
pub(super) fn draw_arcs(
    canvas: &mut Canvas,
    arcs: &[Arc<'_>],
    layout: &Layout,
    places: usize,
    never: impl Fn(&str) -> bool,
) {
    let ends = ends(arcs, layout, places);
    for ((arc, route), [from, to]) in arcs.iter().zip(&layout.routes).zip(&ends) {
        let class = if never(arc.transition) {
            "never"
        } else {
            "ever"
        };
        canvas.open("g", format_args!("class=\"{class}\""));
        let down = to[1] > from[1];
        let mut tips = Curve::default();
        let (mut begin, mut end) = (*from, *to);
        end[1] = tip(&mut tips, *to, down);
        if arc.both {
            begin[1] = tip(&mut tips, *from, !down);
        }
        let mut curve = Curve::default();
        curve.move_to(begin);
        let last = route.len() - 1;
        let mut points: Vec<Px2> = route[1..last].to_vec();
        if let Some(first) = points.first_mut() {
            first[0] = from[0];
        }
        if let Some(end) = points.last_mut() {
            end[0] = to[0];
        }
        for (index, point) in points.iter().enumerate() {
            match index.checked_sub(1).filter(|_| index % 2 == 1) {
                Some(before) => curve.bend_to(points[before], *point),
                None => curve.line_to(*point),
            }
        }
        curve.line_to(end);
        canvas.curve("class=\"arc\"", &curve);
        canvas.curve("class=\"tip\"", &tips);
        canvas.close("g");
    }
}

/// Where each arc leaves its first node and reaches its second: side by side, in the order in which they come.
fn ends(arcs: &[Arc<'_>], layout: &Layout, places: usize) -> Vec<[Px2; 2]> {
    let mut ends: Vec<[Px2; 2]> = arcs
        .iter()
        .map(|arc| [layout.nodes[arc.from], layout.nodes[arc.to]])
        .collect();
    for node in 0..layout.nodes.len() {
        for below in [false, true] {
            let mut here: Vec<(f64, usize, usize)> = Vec::new();
            for (index, (arc, route)) in arcs.iter().zip(&layout.routes).enumerate() {
                // The layer beyond the gap tells where it comes from.
                let beyond = [
                    route.get(2),
                    route.len().checked_sub(3).map(|at| &route[at]),
                ];
                for (end, own) in [arc.from, arc.to].into_iter().enumerate() {
                    let Some(beyond) = beyond[end].filter(|_| own == node) else {
                        continue;
                    };
                    if (beyond[1] > layout.nodes[node][1]) == below {
                        here.push((beyond[0], index, end));
                    }
                }
            }
            here.sort_by(|a, b| a.0.total_cmp(&b.0));
            let bar = node >= places;
            // At a place with many arcs, those that come and those that go each share an end.
            let kind = |index: usize, end: usize| match (arcs[index].both, end) {
                (true, _) => 2,
                (false, end) => end,
            };
            let mut kinds: Vec<usize> = Vec::new();
            for (_, index, end) in &here {
                if !kinds.contains(&kind(*index, *end)) {
                    kinds.push(kind(*index, *end));
                }
            }
            let shared = !bar && here.len() > 2;
            let count = if shared { kinds.len() } else { here.len() };
            for (order, (_, index, end)) in here.iter().enumerate() {
                let own = kinds.iter().position(|own| *own == kind(*index, *end));
                let place = own.filter(|_| shared).unwrap_or(order);
                let room_px = if bar { BAR_PX[0] - 3.0 } else { PLACE_PX - 2.0 };
                let step_px = (2.0 * room_px / count as f64).min(9.0);
                let aside_px = step_px * (place as f64 - (count - 1) as f64 / 2.0);
                let away_px = if bar {
                    BAR_PX[1]
                } else {
                    (PLACE_PX * PLACE_PX - aside_px * aside_px).max(0.0).sqrt() + 0.8
                };
                let [x, y] = layout.nodes[node];
                let y = if below { y + away_px } else { y - away_px };
                ends[*index][*end] = [x + aside_px, y];
            }
        }
    }
    ends
}

/// Adds the tip of an arrow; returns where the line ends.
fn tip(curve: &mut Curve, at: Px2, down: bool) -> f64 {
    let base_px = if down {
        at[1] - TIP_PX[1]
    } else {
        at[1] + TIP_PX[1]
    };
    curve.along([
        at,
        [at[0] - TIP_PX[0], base_px],
        [at[0] + TIP_PX[0], base_px],
    ]);
    curve.close();
    base_px
}
