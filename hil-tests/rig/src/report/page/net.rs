//! A coordination's net as a drawing: places are circles, transitions bars, from above to below.
//!
//! Sources and sinks stand beside the transitions that read and write them, in the colour of the robot that plays the
//! role; one that several transitions use is drawn at each.

use std::collections::BTreeMap;

use config::{NetConfig, NetPlace, NetTransition};
use coordination::petri::{Binding, PlaceKind};

use crate::summary::CoordinationSummary;

use super::arcs::{Arc, BAR_PX, PLACE_PX, TIP_PX, draw_arcs};
use super::html::quantity;
use super::layers::{Extent, lay_out};
use super::style::WIDTH_PX;
use super::view::View;
use crate::report::draw::canvas::{Canvas, Curve, Px, Px2, shortened};
use crate::report::draw::labels::{self, Field};

/// Nets with more places and transitions are not drawn.
const MOST_NODES: usize = 200;
const TOKEN_PX: f64 = 3.8;
/// Sources and sinks: how far from the bar's middle, their size, and from one to the next.
const BESIDE_PX: f64 = 42.0;
const PORT_PX: f64 = 5.2;
const PORT_STEP_PX: f64 = 17.0;
const TEXT_PX: f64 = 12.0;
const SMALL_PX: f64 = 11.0;
const MARGIN_PX: f64 = 6.0;
const LONGEST: usize = 34;

/// When a transition fired: its places in the order of all firings from 1, and the times.
type Firings<'a> = BTreeMap<&'a str, Vec<(usize, f64)>>;

/// Draws a net: of a run, with what fired; `situation` gives the initial marking. `None` if it is too large.
pub(super) fn draw(
    view: &View<'_>,
    net: &NetConfig,
    situation: &str,
    run: Option<&CoordinationSummary>,
) -> Option<String> {
    let places: Vec<&NetPlace> = net
        .places
        .iter()
        .filter(|place| place.kind == PlaceKind::Internal)
        .collect();
    if places.len() + net.transitions.len() > MOST_NODES {
        return None;
    }
    let marked: Vec<&str> = net
        .situation(situation)
        .into_iter()
        .flat_map(|situation| situation.marked.iter().map(String::as_str))
        .collect();
    let mut fired = Firings::new();
    for (index, firing) in run.iter().flat_map(|run| &run.firings).enumerate() {
        let times = fired.entry(firing.transition.as_str()).or_default();
        times.push((index + 1, firing.at_s));
    }
    let mut drawing = Drawing {
        view,
        net,
        run,
        places,
        marked,
        fired,
        short: false,
    };
    let (drawn, width_px) = drawing.draw();
    if width_px <= WIDTH_PX {
        return Some(drawn);
    }
    drawing.short = true;
    Some(drawing.draw().0)
}

struct Drawing<'a> {
    view: &'a View<'a>,
    net: &'a NetConfig,
    run: Option<&'a CoordinationSummary>,
    /// The internal ones; nodes of the graph in this order, then the transitions.
    places: Vec<&'a NetPlace>,
    marked: Vec<&'a str>,
    fired: Firings<'a>,
    /// The drawing would be too wide: flags without their roles, which their colours tell, and only first firings.
    short: bool,
}

impl Drawing<'_> {
    /// The drawing and its width.
    fn draw(&self) -> (String, f64) {
        let arcs = self.arcs();
        let mut extents: Vec<Extent> = self
            .places
            .iter()
            .map(|place| place_extent(place))
            .collect();
        let of_transitions = self.net.transitions.iter();
        extents.extend(of_transitions.map(|transition| self.transition_extent(transition)));
        let edges: Vec<(usize, usize)> = arcs.iter().map(|arc| (arc.from, arc.to)).collect();
        let is_marked = |index: &usize| self.marked.contains(&self.places[*index].id.as_str());
        let top: Vec<usize> = (0..self.places.len()).filter(is_marked).collect();
        let mut layout = lay_out(&extents, &edges, &top);
        for point in layout
            .nodes
            .iter_mut()
            .chain(layout.routes.iter_mut().flatten())
        {
            *point = point.map(|value| value + MARGIN_PX);
        }
        let mut canvas = Canvas::default();
        let never = |transition: &str| self.run.is_some() && !self.fired.contains_key(transition);
        draw_arcs(&mut canvas, &arcs, &layout, self.places.len(), never);
        for (index, place) in self.places.iter().enumerate() {
            self.draw_place(&mut canvas, place, layout.nodes[index]);
        }
        for (index, transition) in self.net.transitions.iter().enumerate() {
            let at = layout.nodes[self.places.len() + index];
            self.draw_transition(&mut canvas, transition, at);
        }
        let size = layout.size.map(|length| length + 2.0 * MARGIN_PX);
        let label = format!("Petri net {}", self.net.name);
        (canvas.finish_inline("petri", size, &label), size[0])
    }

    fn arcs(&self) -> Vec<Arc<'_>> {
        let place_index = |id: &String| self.places.iter().position(|place| &place.id == id);
        let mut arcs = Vec::new();
        for (index, transition) in self.net.transitions.iter().enumerate() {
            let bar = self.places.len() + index;
            let id = transition.id.as_str();
            for place in &transition.from {
                arcs.extend(place_index(place).map(|from| Arc {
                    from,
                    to: bar,
                    both: transition.to.contains(place),
                    transition: id,
                }));
            }
            for place in transition
                .to
                .iter()
                .filter(|place| !transition.from.contains(place))
            {
                arcs.extend(place_index(place).map(|to| Arc {
                    from: bar,
                    to,
                    both: false,
                    transition: id,
                }));
            }
        }
        arcs
    }

    /// Sources, then sinks, of a transition: whether it is a sink, role and name of the event.
    fn ports(&self, transition: &NetTransition) -> Vec<(bool, Option<&str>, String)> {
        let of = |ids: &[String], kind: PlaceKind| -> Vec<(bool, Option<&str>, String)> {
            ids.iter()
                .filter_map(|id| self.net.place(id))
                .filter(|place| place.kind == kind)
                .map(|place| {
                    let (role, name) = match &place.binding {
                        Some(Binding::Flag { protocol, flag }) if self.short => {
                            (Some(protocol.as_str()), flag.clone())
                        }
                        Some(binding @ Binding::Flag { protocol, .. }) => {
                            (Some(protocol.as_str()), binding.event_name())
                        }
                        Some(binding) => (None, binding.event_name()),
                        None => (None, place.id.clone()),
                    };
                    (kind == PlaceKind::Sink, role, shortened(&name, LONGEST))
                })
                .collect()
        };
        let mut ports = of(&transition.from, PlaceKind::Source);
        ports.extend(of(&transition.to, PlaceKind::Sink));
        ports
    }

    fn transition_extent(&self, transition: &NetTransition) -> Extent {
        let ports = self.ports(transition);
        let widest_px = ports
            .iter()
            .map(|port| text_width_px(&port.2, SMALL_PX))
            .fold(0.0, f64::max);
        let [numbers, times] = self.firing_texts(&transition.id);
        let name_px = text_width_px(&shortened(&transition.id, LONGEST), TEXT_PX)
            + badge_px(&numbers).map_or(0.0, |width_px| width_px + 5.0);
        let half_px = PORT_STEP_PX * ports.len() as f64 / 2.0;
        Extent {
            left_px: if ports.is_empty() {
                BAR_PX[0]
            } else {
                BESIDE_PX + PORT_PX + 5.0 + widest_px
            },
            right_px: BAR_PX[0] + 6.0 + name_px.max(text_width_px(&times, SMALL_PX)),
            above_px: half_px.max(9.0),
            below_px: half_px.max(if times.is_empty() { 9.0 } else { 19.0 }),
        }
    }

    /// Which firings a transition was, and when.
    fn firing_texts(&self, transition: &str) -> [String; 2] {
        let shown = if self.short { 1 } else { 3 };
        let Some(fired) = self.fired.get(transition) else {
            return [String::new(), String::new()];
        };
        let listed = |text: &dyn Fn(&(usize, f64)) -> String| {
            let texts: Vec<String> = fired.iter().take(shown).map(text).collect();
            texts.join(", ")
        };
        let more = match fired.len().checked_sub(shown) {
            None | Some(0) => String::new(),
            Some(_) => format!(" … {}×", fired.len()),
        };
        [
            listed(&|firing| firing.0.to_string()) + &more,
            listed(&|firing| quantity(firing.1, 1, "s")),
        ]
    }

    fn draw_place(&self, canvas: &mut Canvas, place: &NetPlace, at: Px2) {
        let [x, y] = at.map(Px);
        let marked = self.marked.contains(&place.id.as_str());
        let hint = format!("{}: {}", place.id, place.about);
        canvas.element_with_hint(
            "circle",
            format_args!("class=\"place\" cx=\"{x}\" cy=\"{y}\" r=\"{PLACE_PX}\""),
            &hint,
        );
        if marked {
            canvas.circle("token", at, TOKEN_PX);
        }
        let text_at = [at[0] + PLACE_PX + 5.0, at[1] + 4.0];
        canvas.text("note halo", text_at, &shortened(&place.id, LONGEST));
    }

    fn draw_transition(&self, canvas: &mut Canvas, transition: &NetTransition, at: Px2) {
        let never = self.run.is_some() && !self.fired.contains_key(transition.id.as_str());
        canvas.open(
            "g",
            format_args!("class=\"{}\"", if never { "never" } else { "ever" }),
        );
        let ports = self.ports(transition);
        for (index, (sink, role, name)) in ports.iter().enumerate() {
            let step = index as f64 - (ports.len() - 1) as f64 / 2.0;
            self.draw_port(canvas, at, step, *sink, *role, name);
        }
        let bar = Field::around(at, BAR_PX.map(|half| 2.0 * half));
        canvas.rect("class=\"trans\"", bar.rectangle());
        let [numbers, times] = self.firing_texts(&transition.id);
        let mut x = at[0] + BAR_PX[0] + 6.0;
        if let Some(width_px) = badge_px(&numbers) {
            let place = [x, at[1] - 8.0, width_px, 15.0];
            canvas.rect("class=\"nr\" rx=\"7.5\"", place);
            canvas.text("nrtext", [x + width_px / 2.0, at[1] + 3.5], &numbers);
            x += width_px + 5.0;
        }
        canvas.text(
            "trname halo",
            [x, at[1] + 4.0],
            &shortened(&transition.id, LONGEST),
        );
        if !times.is_empty() {
            canvas.text(
                "about halo",
                [at[0] + BAR_PX[0] + 8.0, at[1] + 18.0],
                &times,
            );
        }
        canvas.close("g");
    }

    fn draw_port(
        &self,
        canvas: &mut Canvas,
        bar: Px2,
        step: f64,
        sink: bool,
        role: Option<&str>,
        name: &str,
    ) {
        let robot = role.and_then(|role| {
            let parts = self.run.into_iter().flat_map(|run| &run.robots);
            { parts }.find(|part| part.role == role)
        });
        let class = robot.map_or_else(|| "neutral".to_owned(), |part| self.view.class(&part.robot));
        canvas.open("g", format_args!("class=\"{class}\""));
        let at = [bar[0] - BESIDE_PX, bar[1] + step * PORT_STEP_PX];
        let joint = [bar[0] - BAR_PX[0], bar[1] + step.clamp(-1.0, 1.0) * 1.5];
        let beside = [at[0] + PORT_PX + 0.8, at[1]];
        // From the source to the bar, or from the bar to the sink.
        let (from, to) = if sink {
            (joint, beside)
        } else {
            (beside, joint)
        };
        let direction = (to[0] - from[0]).signum();
        let end = [to[0] - direction * TIP_PX[1], to[1]];
        let mut curve = Curve::default();
        curve.move_to(from);
        curve.lean_to(from, end);
        canvas.curve("class=\"io\"", &curve);
        let mut head = Curve::default();
        let wing = |side: f64| [end[0], to[1] + side * TIP_PX[0]];
        head.along([to, wing(-1.0), wing(1.0)]);
        head.close();
        canvas.curve("class=\"iotip\"", &head);
        canvas.circle(if sink { "sink" } else { "source" }, at, PORT_PX);
        if sink {
            canvas.circle("ring", at, PORT_PX - 2.4);
        }
        canvas.text("about e halo", [at[0] - PORT_PX - 5.0, at[1] + 3.8], name);
        canvas.close("g");
    }
}

/// About the width of a text; names here are of small letters, which are narrower than others.
fn text_width_px(text: &str, size_px: f64) -> f64 {
    0.93 * labels::text_width_px(text, size_px)
}

fn place_extent(place: &NetPlace) -> Extent {
    Extent {
        left_px: PLACE_PX + 2.0,
        right_px: PLACE_PX + 5.0 + text_width_px(&shortened(&place.id, LONGEST), TEXT_PX),
        above_px: PLACE_PX + 2.0,
        below_px: PLACE_PX + 2.0,
    }
}

/// Width of the badge with the numbers of firings; none without any.
fn badge_px(numbers: &str) -> Option<f64> {
    (!numbers.is_empty()).then(|| (labels::text_width_px(numbers, SMALL_PX) + 10.0).max(17.0))
}
