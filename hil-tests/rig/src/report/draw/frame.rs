//! From metres to pixels: what the map covers, and its axes.

use config::SiteConfig;

use super::canvas::{Canvas, Px2};
use super::labels::Field;
use super::scale;
use super::sheet::{PLOT_LEFT_PX, PLOT_RIGHT_PX};

/// A tall site is drawn smaller rather than longer.
const MOST_HEIGHT_PX: f64 = 860.0;
/// Free floor around the site.
const BORDER_M: f64 = 0.2;
/// A path that leaves the site is followed this far.
const OUTSIDE_M: f64 = 2.0;

/// Turns metres of `map` into places on the page.
#[derive(Clone, Copy, Debug)]
pub(in crate::report) struct Frame {
    /// Scale of the drawing.
    pub(in crate::report) px_per_m: f64,
    /// What the map covers on the page.
    pub(in crate::report) field: Field,
    extent: Extent,
}

impl Frame {
    /// Room for a site, and for the points of a path unless it leads far away.
    pub(in crate::report) fn new(
        site: &SiteConfig,
        path: impl Iterator<Item = [f64; 2]>,
        top_px: f64,
    ) -> Self {
        let room = Field {
            min: [PLOT_LEFT_PX, top_px],
            max: [PLOT_RIGHT_PX, top_px + MOST_HEIGHT_PX],
        };
        Self::within(site, path, room)
    }

    /// The same in a part of the page: as large as fits, at its upper border.
    pub(in crate::report) fn within(
        site: &SiteConfig,
        path: impl Iterator<Item = [f64; 2]>,
        room: Field,
    ) -> Self {
        let extent = Extent::of(site, path);
        let [width_m, height_m] = extent.size_m();
        let [left_px, top_px, room_px, most_px] = room.rectangle();
        let px_per_m = (room_px / width_m).min(most_px / height_m);
        let size = [width_m * px_per_m, height_m * px_per_m];
        let left_px = left_px + (room_px - size[0]) / 2.0;
        let field = Field {
            min: [left_px, top_px],
            max: [left_px + size[0], top_px + size[1]],
        };
        Self {
            px_per_m,
            field,
            extent,
        }
    }

    /// Where a point of the floor is on the page.
    pub(in crate::report) fn at(&self, at_m: [f64; 2]) -> Px2 {
        [
            self.field.min[0] + (at_m[0] - self.extent.min_m[0]) * self.px_per_m,
            self.field.max[1] - (at_m[1] - self.extent.min_m[1]) * self.px_per_m,
        ]
    }

    /// Where a region is on the page.
    pub(in crate::report) fn region(&self, region: &description::geometry::Rect) -> Field {
        let [left, bottom] = self.at(region.min.xy_m());
        let [right, top] = self.at(region.max.xy_m());
        Field {
            min: [left, top],
            max: [right, bottom],
        }
    }

    /// Draws the frame with axes in metres.
    pub(in crate::report) fn draw_axes(&self, canvas: &mut Canvas) {
        let [left, top, width, height] = self.field.rectangle();
        let (right, bottom) = (left + width, top + height);
        canvas.rect("class=\"frame\"", [left, top, width, height]);
        let [width_m, height_m] = self.extent.size_m();
        let longest_m = width_m.max(height_m);
        let step_m = scale::step(longest_m, 16.0);
        for x_m in scale::ticks(self.extent.min_m[0], self.extent.max_m[0], step_m) {
            let [x, _] = self.at([x_m, 0.0]);
            canvas.line("mark", [x, bottom], [x, bottom + 6.0]);
            canvas.text("tick m", [x, bottom + 20.0], &scale::label(x_m, step_m));
        }
        for y_m in scale::ticks(self.extent.min_m[1], self.extent.max_m[1], step_m) {
            let [_, y] = self.at([0.0, y_m]);
            canvas.line("mark", [left - 6.0, y], [left, y]);
            canvas.text("tick e", [left - 10.0, y + 4.0], &scale::label(y_m, step_m));
        }
        canvas.text(
            "axis m",
            [(left + right) / 2.0, bottom + 40.0],
            "x (east), m",
        );
        let middle = (top + bottom) / 2.0;
        let x = left - 46.0;
        canvas.open(
            "g",
            format_args!("transform=\"translate({x:.1} {middle:.1}) rotate(-90)\""),
        );
        canvas.text("axis m", [0.0, 0.0], "y (north), m");
        canvas.close("g");
    }
}

/// A part of the floor; at first none.
#[derive(Clone, Copy, Debug)]
struct Extent {
    min_m: [f64; 2],
    max_m: [f64; 2],
}

impl Extent {
    const NONE: Self = Self {
        min_m: [f64::INFINITY; 2],
        max_m: [f64::NEG_INFINITY; 2],
    };

    /// The floor that must be seen: the site, and the path unless it leads far away.
    fn of(site: &SiteConfig, path: impl Iterator<Item = [f64; 2]>) -> Self {
        let mut extent = Self::NONE;
        for wall in &site.walls {
            extent.include([wall.line.a.xy_m(), wall.line.b.xy_m()]);
        }
        for lane in &site.lanes {
            extent.include([lane.line.a.xy_m(), lane.line.b.xy_m()]);
        }
        let areas = site.areas.iter().map(|area| &area.region);
        for region in areas.chain(site.perception.iter().map(|zone| &zone.region)) {
            extent.include([region.min.xy_m(), region.max.xy_m()]);
        }
        let near = extent.grown(OUTSIDE_M);
        for at_m in path {
            extent.include([near.nearest(at_m)]);
        }
        if extent.is_none() {
            extent.include([[0.0; 2], [1.0; 2]]);
        }
        extent.grown(BORDER_M)
    }

    fn is_none(&self) -> bool {
        self.min_m[0] > self.max_m[0]
    }

    fn include<const N: usize>(&mut self, points_m: [[f64; 2]; N]) {
        for (point_m, axis) in points_m
            .iter()
            .flat_map(|point_m| [(point_m, 0), (point_m, 1)])
        {
            self.min_m[axis] = self.min_m[axis].min(point_m[axis]);
            self.max_m[axis] = self.max_m[axis].max(point_m[axis]);
        }
    }

    fn grown(self, by_m: f64) -> Self {
        Self {
            min_m: self.min_m.map(|low| low - by_m),
            max_m: self.max_m.map(|high| high + by_m),
        }
    }

    /// The point of it nearest to another; nothing has no bounds.
    fn nearest(&self, at_m: [f64; 2]) -> [f64; 2] {
        if self.is_none() {
            return at_m;
        }
        [0, 1].map(|axis| at_m[axis].clamp(self.min_m[axis], self.max_m[axis]))
    }

    fn size_m(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.max_m[axis] - self.min_m[axis])
    }
}
