//! `rig map`: a site as its file describes it, for people to check.

use config::SiteConfig;
use sim::world::Pose;

use super::draw::canvas::{Canvas, Curve, Px2, shortened};
use super::draw::floor;
use super::draw::frame::Frame;
use super::draw::labels::{Field, LABEL_PX, Labels, text_width_px};
use super::draw::marks;
use super::draw::scale_bar::draw_scale_bar;
use super::draw::sheet::{MARGIN_PX, PLOT_LEFT_PX, PLOT_RIGHT_PX};

const LINE_PX: f64 = 21.0;
/// Length of the arrow that stands for a robot whose size the site does not know.
const ROBOT_M: f64 = 0.4;

/// Draws a site: walls, lanes with their direction, areas with capacity and limits, perception zones, robots' starts.
#[must_use]
pub fn site_svg(site: &SiteConfig) -> String {
    let mut canvas = Canvas::default();
    let title = format!("site {}", site.name);
    canvas.text("h", [MARGIN_PX, 56.0], &shortened(&title, 56));
    canvas.text("sub", [MARGIN_PX, 82.0], &contents(site));
    let starts = site
        .robots
        .values()
        .map(|robot| [robot.start.x_m, robot.start.y_m]);
    let frame = Frame::new(site, starts, 112.0);
    let mut labels = Labels::new(frame.field);
    floor::draw_areas(&mut canvas, site, &frame, &mut labels);
    floor::draw_zones(&mut canvas, site, &frame, &mut labels);
    floor::draw_lanes(&mut canvas, site, &frame);
    floor::draw_walls(&mut canvas, site, &frame, &mut labels);
    draw_robots(&mut canvas, site, &frame, &mut labels);
    name_lanes(&mut canvas, site, &frame, &mut labels);
    name_walls(&mut canvas, site, &frame, &mut labels);
    frame.draw_axes(&mut canvas);
    let below_px = frame.field.max[1] + 74.0;
    draw_signs(&mut canvas, [PLOT_LEFT_PX, below_px]);
    draw_scale_bar(&mut canvas, &frame, below_px);
    let height_px = draw_layers(&mut canvas, site, below_px + 46.0);
    canvas.finish(height_px, &title)
}

fn contents(site: &SiteConfig) -> String {
    let managed = if site.areas_managed {
        "granted by a mediator"
    } else {
        "all granted"
    };
    format!(
        "walls: {}, lanes: {}, areas: {} ({managed}), perception zones: {}, robots: {}",
        site.walls.len(),
        site.lanes.len(),
        site.areas.len(),
        site.perception.len(),
        site.robots.len()
    )
}

/// Each robot as an arrow with its tail at `base_link`.
fn draw_robots(canvas: &mut Canvas, site: &SiteConfig, frame: &Frame, labels: &mut Labels) {
    for (id, robot) in &site.robots {
        let start = Pose::new(robot.start.x_m, robot.start.y_m, robot.start.theta_rad);
        let at = |point_m: [f64; 2]| frame.at(start.transform(point_m));
        let half_m = 0.25 * ROBOT_M;
        let mut arrow = Curve::default();
        let corners = [
            [0.0, half_m],
            [0.6 * ROBOT_M, half_m],
            [ROBOT_M, 0.0],
            [0.6 * ROBOT_M, -half_m],
            [0.0, -half_m],
        ];
        arrow.along(corners.map(at));
        arrow.close();
        canvas.curve("class=\"end\"", &arrow);
        let covered = Field::over(&[
            at([0.0, half_m]),
            at([ROBOT_M, 0.0]),
            at([0.0, -half_m]),
            at([0.5 * ROBOT_M, 0.0]),
        ]);
        labels.take(covered);
        let text = format!("{id} ({})", robot.role);
        draw_pill(canvas, labels, &covered, &shortened(&text, 32));
    }
}

fn name_lanes(canvas: &mut Canvas, site: &SiteConfig, frame: &Frame, labels: &mut Labels) {
    for lane in &site.lanes {
        let (from, to) = (frame.at(lane.line.a.xy_m()), frame.at(lane.line.b.xy_m()));
        let middle = [0, 1].map(|axis| (from[axis] + to[axis]) / 2.0);
        let text = match &lane.end_wall {
            Some(wall) => format!("lane {} (ends at wall {wall})", lane.id),
            None => format!("lane {}", lane.id),
        };
        let short = format!("lane {}", lane.id);
        let named = Field::around(middle, [0.0; 2]);
        if !draw_pill(canvas, labels, &named, &shortened(&text, 40)) {
            draw_pill(canvas, labels, &named, &shortened(&short, 24));
        }
    }
}

fn name_walls(canvas: &mut Canvas, site: &SiteConfig, frame: &Frame, labels: &mut Labels) {
    for wall in &site.walls {
        let (from, to) = (frame.at(wall.line.a.xy_m()), frame.at(wall.line.b.xy_m()));
        let middle = [0, 1].map(|axis| (from[axis] + to[axis]) / 2.0);
        let text = format!("wall {}", shortened(&wall.id, 24));
        draw_pill(canvas, labels, &Field::around(middle, [0.0; 2]), &text);
    }
}

fn draw_signs(canvas: &mut Canvas, at: Px2) {
    const SIGN_PX: f64 = 34.0;
    let [mut x, y] = at;
    for (sign, name) in [
        ("wall", "wall"),
        ("lane", "lane, driven as its arrows point"),
        ("zone", "perception zone"),
        ("end", "start of a robot"),
    ] {
        if sign == "end" {
            canvas.rect("class=\"end\"", [x + 4.0, y - 6.0, 22.0, 11.0]);
        } else {
            canvas.line(sign, [x, y], [x + SIGN_PX - 4.0, y]);
        }
        canvas.text("", [x + SIGN_PX + 4.0, y + 4.5], name);
        x += SIGN_PX + text_width_px(name, LABEL_PX) + 24.0;
    }
}

/// The control layer and the perception layer in words; returns where the page ends.
fn draw_layers(canvas: &mut Canvas, site: &SiteConfig, top_px: f64) -> f64 {
    let areas: Vec<String> = site
        .areas
        .iter()
        .map(|area| {
            let lane = area
                .lane
                .as_ref()
                .map_or_else(String::new, |lane| format!(", lane {lane}"));
            format!(
                "{}: {}{lane}, holds {}, {} m/s, at most {} m off",
                area.id,
                area.control.manoeuvre.name(),
                area.capacity,
                area.control.speed_limit_m_s,
                area.control.deviation_limit_m
            )
        })
        .collect();
    let kinds: Vec<String> = site
        .perception_kinds
        .iter()
        .map(|(kind, what)| {
            let names = |features: &[description::site::Feature]| {
                let names: Vec<&str> = features.iter().map(|feature| feature.name()).collect();
                names.join(", ")
            };
            let mut text = format!("{kind}: tracks {}", names(&what.tracks));
            if !what.searches.is_empty() {
                text.push_str(&format!("; searches {}", names(&what.searches)));
            }
            text
        })
        .collect();
    let y_px = draw_list(canvas, "Control layer: areas", &areas, top_px);
    draw_list(canvas, "Perception layer: kinds", &kinds, y_px + 14.0)
}

fn draw_list(canvas: &mut Canvas, title: &str, lines: &[String], top_px: f64) -> f64 {
    const COLUMNS: usize = 3;
    canvas.text("cap", [PLOT_LEFT_PX, top_px], title);
    let rows = lines.len().div_ceil(COLUMNS);
    let width_px = (PLOT_RIGHT_PX - PLOT_LEFT_PX) / COLUMNS as f64;
    for (index, line) in lines.iter().enumerate() {
        let at = [
            PLOT_LEFT_PX + width_px * (index / rows) as f64,
            top_px + LINE_PX * (index % rows + 1) as f64 + 2.0,
        ];
        canvas.text("", at, &shortened(line, 72));
    }
    top_px + LINE_PX * (rows + 1) as f64
}

/// A label beside what it names; false if there is no room.
fn draw_pill(canvas: &mut Canvas, labels: &mut Labels, named: &Field, text: &str) -> bool {
    let width_px = text_width_px(text, LABEL_PX) + 16.0;
    let place = marks::draw_pill(canvas, labels, named, width_px);
    if let Some(at) = place {
        canvas.text("m", at, text);
    }
    place.is_some()
}
