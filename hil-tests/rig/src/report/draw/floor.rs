//! The floor of a site: areas, perception zones, lanes and walls, to scale.

use config::SiteConfig;
use sim::world::{Rectangle, Shape};

use super::canvas::{Canvas, Curve, shortened};
use super::frame::Frame;
use super::labels::{Field, Labels, text_width_px};
use super::scale;

/// Areas with their names and what is done in them.
pub(in crate::report) fn draw_areas(
    canvas: &mut Canvas,
    site: &SiteConfig,
    frame: &Frame,
    labels: &mut Labels,
) {
    for (index, area) in site.areas.iter().enumerate() {
        let field = frame.region(&area.region);
        let [x, y, width, _] = field.rectangle();
        let colour = scale::area_colour(index);
        let control = &area.control;
        let about = format!(
            "{}, {} m/s",
            control.manoeuvre.name(),
            control.speed_limit_m_s
        );
        canvas.rect_with_hint(
            &format!("class=\"area\" fill=\"{colour}\""),
            field.rectangle(),
            &format!("area {}: {about}", area.id),
        );
        canvas.text("id", [x + 8.0, y + 23.0], &area.id);
        let id_px = text_width_px(&area.id, 20.0) + 18.0;
        let about_px = text_width_px(&about, 12.0);
        let beside = id_px + about_px + 6.0 < width;
        let mut covered = Field {
            min: [x, y],
            max: [x + id_px, y + 28.0],
        };
        if beside {
            canvas.text("note", [x + id_px, y + 22.0], &about);
            covered.max[0] += about_px;
        }
        labels.take(covered);
    }
}

/// Zones of the perception layer.
pub(in crate::report) fn draw_zones(
    canvas: &mut Canvas,
    site: &SiteConfig,
    frame: &Frame,
    labels: &mut Labels,
) {
    // A little inside, since zones often share their borders with areas.
    const INSET_PX: f64 = 4.0;
    for zone in &site.perception {
        let field = frame.region(&zone.region);
        let [x, y, width, height] = field.rectangle();
        canvas.rect_with_hint(
            "class=\"zone\"",
            [
                x + INSET_PX,
                y + INSET_PX,
                (width - 2.0 * INSET_PX).max(0.0),
                (height - 2.0 * INSET_PX).max(0.0),
            ],
            &format!("perception zone {}, kind {}", zone.id, zone.kind),
        );
        let name = shortened(&format!("zone {}", zone.kind), 24);
        let name_px = text_width_px(&name, 12.0);
        let end = [field.max[0] - INSET_PX - 6.0, field.max[1] - INSET_PX - 7.0];
        if name_px + 4.0 * INSET_PX < width {
            canvas.text("note e", end, &name);
            labels.take(Field {
                min: [end[0] - name_px, end[1] - 13.0],
                max: [end[0] + 4.0, end[1] + 5.0],
            });
        }
    }
}

/// Lanes with their direction.
pub(in crate::report) fn draw_lanes(canvas: &mut Canvas, site: &SiteConfig, frame: &Frame) {
    const ARROW_PX: f64 = 7.0;
    const ARROWS_EVERY_M: f64 = 1.0;
    let mut arrows = Curve::default();
    for lane in &site.lanes {
        let (from, to) = (frame.at(lane.line.a.xy_m()), frame.at(lane.line.b.xy_m()));
        canvas.line("lane", from, to);
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let length_px = dx.hypot(dy);
        if length_px < 1.0 {
            continue;
        }
        let (along, across) = (
            [dx / length_px, dy / length_px],
            [-dy / length_px, dx / length_px],
        );
        let count = (length_px / frame.px_per_m / ARROWS_EVERY_M)
            .floor()
            .clamp(1.0, 200.0) as u32;
        for index in 0..count {
            let share = (f64::from(index) + 0.5) / f64::from(count);
            let tip = [from[0] + dx * share, from[1] + dy * share];
            let wing = |side: f64| {
                [0, 1]
                    .map(|axis| tip[axis] - ARROW_PX * along[axis] + side * ARROW_PX * across[axis])
            };
            arrows.along([wing(1.0), tip, wing(-1.0)]);
        }
    }
    canvas.curve("class=\"arrow\"", &arrows);
}

/// Walls.
pub(in crate::report) fn draw_walls(
    canvas: &mut Canvas,
    site: &SiteConfig,
    frame: &Frame,
    labels: &mut Labels,
) {
    for wall in &site.walls {
        let (from, to) = (frame.at(wall.line.a.xy_m()), frame.at(wall.line.b.xy_m()));
        canvas.line("wall", from, to);
        labels.avoid_line(from, to);
    }
}

/// What the site does not know: boxes, people, other vehicles.
pub(in crate::report) fn draw_obstacles(canvas: &mut Canvas, obstacles: &[Shape], frame: &Frame) {
    for shape in obstacles {
        match shape {
            Shape::Wall(wall) => canvas.line("wall", frame.at(wall.from_m), frame.at(wall.to_m)),
            Shape::Disc { centre_m, radius_m } => {
                canvas.circle("thing", frame.at(*centre_m), radius_m * frame.px_per_m);
            }
            Shape::Box {
                pose,
                length_m,
                width_m,
            } => {
                let corners = Rectangle::centred(pose, *length_m, *width_m).corners_m;
                let mut outline = Curve::default();
                outline.along(corners.map(|corner| frame.at(corner)));
                outline.close();
                canvas.curve("class=\"thing\"", &outline);
            }
        }
    }
}
