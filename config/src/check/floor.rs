//! The floor: lanes without gaps, areas on one piece of floor, areas that can be reached.

use std::collections::BTreeSet;

use crate::diagnostic::ProblemKind;
use crate::loaded::SiteConfig;
use crate::report::Report;
use description::geometry::{Point2, Rect, Segment};
use description::keys::rounded;
use description::site::{Area, Lane, Wall};

/// Narrower holes and strips are rounding, metres.
const SLIVER_M: f64 = 0.02;
/// Resolution of the floor, metres, as long as an area has no more cells to a side.
const CELL_M: f64 = 0.05;
const MOST_CELLS: usize = 300;
/// Where in its cell a point stands: not on round numbers, where walls are.
const MIDDLE: f64 = 0.4873;
/// Less floor behind a wall than this share of the area is rounding.
const CUT_SHARE: f64 = 0.01;
/// Open border that two areas need for a robot to pass from one to the other, metres.
const OPENING_M: f64 = 0.20;

pub(super) fn check(site: &SiteConfig, report: &Report) {
    for lane in &site.lanes {
        no_gap(site, lane, report);
    }
    for area in &site.areas {
        on_one_floor(site, area, report);
    }
    // An area that a wall cuts in two was reported above; paths through it would mean nothing.
    if !report.touched(&["areas"]) {
        reachable(site, report);
    }
}

/// Everywhere along a lane there must be an area.
fn no_gap(site: &SiteConfig, lane: &Lane, report: &Report) {
    let key = format!("lanes.{}", lane.id);
    let length_m = lane.line.length_m();
    if report.touched(&[&key]) || length_m < SLIVER_M {
        return;
    }
    let mut covered: Vec<(f64, f64, &str)> = site
        .areas
        .iter()
        .filter_map(|area| {
            let (enter, leave) = area.region.clip(&lane.line)?;
            Some((enter * length_m, leave * length_m, area.id.as_str()))
        })
        .collect();
    covered.sort_by(|one, other| one.0.total_cmp(&other.0));
    let (mut reached_m, mut last) = (0.0, "");
    for (enter_m, leave_m, area) in covered {
        if enter_m > reached_m + SLIVER_M {
            let at = |along_m: f64| {
                let at = lane.line.a + lane.line.unit() * along_m;
                format!("({}, {})", rounded(at.x_m), rounded(at.y_m))
            };
            report.wrong(
                ProblemKind::Inconsistent,
                &key,
                format!(
                    "a gap of {:.3} m between areas `{last}` and `{area}`, from {} to {}",
                    enter_m - reached_m,
                    at(reached_m),
                    at(enter_m)
                ),
                "areas all along the lane, each beginning where the one before ends",
            );
            return;
        }
        if leave_m > reached_m {
            (reached_m, last) = (leave_m, area);
        }
    }
}

/// No wall may cut off a part of an area: its border would lie outside the floor.
fn on_one_floor(site: &SiteConfig, area: &Area, report: &Report) {
    let key = format!("areas.{}.region", area.id);
    if report.touched(&[&key]) {
        return;
    }
    let near = |wall: &&Wall| area.region.clip(&wall.line).is_some();
    let walls: Vec<&Wall> = site.walls.iter().filter(near).collect();
    let cells = Cells::new(&area.region);
    let blocked = |one: Point2, other: Point2| {
        let step = Segment::new(one, other);
        let wall = walls.iter().find(|wall| step.meets(&wall.line));
        wall.map(|wall| wall.id.as_str())
    };
    let (reached, by) = cells.flood(cells.near(seed(site, area)), blocked);
    let missing = cells.len() - reached;
    let Some(wall) = by.filter(|_| missing as f64 > CUT_SHARE * cells.len() as f64) else {
        return;
    };
    let problem = report.problem(
        ProblemKind::Inconsistent,
        &key,
        format!(
            "a region of which wall `{wall}` cuts off {:.2} m²",
            missing as f64 * cells.size_m2()
        ),
        "a region on one piece of floor, with its border inside the walls",
    );
    report.push(
        report
            .origin
            .also(problem, &format!("walls.{wall}"), "the wall"),
    );
}

/// A place in the area that is floor: where a lane passes, else its middle.
fn seed(site: &SiteConfig, area: &Area) -> Point2 {
    let own = area.lane.as_deref().and_then(|lane| site.lane(lane));
    let on_lane = own.into_iter().chain(&site.lanes).find_map(|lane| {
        let (enter, leave) = area.region.clip(&lane.line)?;
        Some(lane.line.a + (lane.line.b - lane.line.a) * ((enter + leave) / 2.0))
    });
    on_lane.unwrap_or(area.region.centre())
}

/// A rectangle in cells.
struct Cells {
    region: Rect,
    count: [usize; 2],
}

impl Cells {
    fn new(region: &Rect) -> Self {
        let cells = |side_m: f64| ((side_m / CELL_M).ceil() as usize).clamp(1, MOST_CELLS);
        let count = (region.max - region.min).xy_m().map(cells);
        Self {
            region: *region,
            count,
        }
    }

    fn len(&self) -> usize {
        self.count[0] * self.count[1]
    }

    fn side_m(&self, axis: usize) -> f64 {
        (self.region.max - self.region.min).xy_m()[axis] / self.count[axis] as f64
    }

    fn size_m2(&self) -> f64 {
        self.side_m(0) * self.side_m(1)
    }

    /// The cell that is nearest to a point.
    fn near(&self, point: Point2) -> [usize; 2] {
        let from_m = (point - self.region.min).xy_m();
        [0, 1].map(|axis| {
            let cell = from_m[axis] / self.side_m(axis);
            // The cast turns negative values and NaN into 0.
            (cell as usize).min(self.count[axis] - 1)
        })
    }

    fn centre(&self, cell: [usize; 2]) -> Point2 {
        let along_m = |axis: usize| (cell[axis] as f64 + MIDDLE) * self.side_m(axis);
        self.region.min + Point2::new(along_m(0), along_m(1))
    }

    /// How many cells are reached from one, and a wall that was in the way.
    fn flood<'w>(
        &self,
        from: [usize; 2],
        blocked: impl Fn(Point2, Point2) -> Option<&'w str>,
    ) -> (usize, Option<&'w str>) {
        let index = |cell: [usize; 2]| cell[1] * self.count[0] + cell[0];
        let mut seen = vec![false; self.len()];
        seen[index(from)] = true;
        let (mut reached, mut wall, mut waiting) = (1, None, vec![from]);
        while let Some(cell) = waiting.pop() {
            let [x, y] = cell;
            let neighbours = [
                (x > 0).then(|| [x - 1, y]),
                (y > 0).then(|| [x, y - 1]),
                (x + 1 < self.count[0]).then_some([x + 1, y]),
                (y + 1 < self.count[1]).then_some([x, y + 1]),
            ];
            for next in neighbours.into_iter().flatten() {
                if seen[index(next)] {
                    continue;
                }
                match blocked(self.centre(cell), self.centre(next)) {
                    Some(id) => wall = Some(id),
                    None => {
                        seen[index(next)] = true;
                        reached += 1;
                        waiting.push(next);
                    }
                }
            }
        }
        (reached, wall)
    }
}

/// Every area must be connected, over open borders, with the areas where robots start.
fn reachable(site: &SiteConfig, report: &Report) {
    let starts: BTreeSet<usize> = (0..site.areas.len())
        .filter(|&index| {
            let area = &site.areas[index];
            site.robots
                .values()
                .any(|robot| area.region.contains(robot.start.position()))
        })
        .collect();
    // Without a robot, what is connected with the first area counts.
    let mut reached = if starts.is_empty() {
        BTreeSet::from([0])
    } else {
        starts
    };
    let mut waiting: Vec<usize> = reached.iter().copied().collect();
    while let Some(at) = waiting.pop() {
        for next in 0..site.areas.len() {
            if !reached.contains(&next) && neighbours(site, &site.areas[at], &site.areas[next]) {
                reached.insert(next);
                waiting.push(next);
            }
        }
    }
    for (index, area) in site.areas.iter().enumerate() {
        if !reached.contains(&index) {
            report.wrong(
                ProblemKind::Inconsistent,
                &format!("areas.{}.region", area.id),
                format!(
                    "area `{}`, which no robot can reach: no open border joins it to the areas where they start",
                    area.id
                ),
                format!(
                    "areas that are joined, with at least {OPENING_M} m of border and no wall between"
                ),
            );
        }
    }
}

/// Whether a robot can go from one area to the other across a border that they share.
fn neighbours(site: &SiteConfig, one: &Area, other: &Area) -> bool {
    (0..2).any(|across| {
        let along = 1 - across;
        let corners = |region: &Rect| (region.min.xy_m(), region.max.xy_m());
        let ((a_min, a_max), (b_min, b_max)) = (corners(&one.region), corners(&other.region));
        let border_m = if (a_max[across] - b_min[across]).abs() < SLIVER_M {
            a_max[across]
        } else if (b_max[across] - a_min[across]).abs() < SLIVER_M {
            a_min[across]
        } else {
            return false;
        };
        let from_m = a_min[along].max(b_min[along]);
        let to_m = a_max[along].min(b_max[along]);
        let places = ((to_m - from_m) / CELL_M).floor().max(0.0) as usize;
        let places = places.min(MOST_CELLS);
        let step_m = (to_m - from_m) / places.max(1) as f64;
        let open = |place: usize| {
            let at_m = from_m + (place as f64 + 0.5) * step_m;
            let point = |across_m: f64| {
                let mut point_m = [0.0; 2];
                (point_m[across], point_m[along]) = (across_m, at_m);
                Point2::from(point_m)
            };
            let step = Segment::new(point(border_m - CELL_M), point(border_m + CELL_M));
            !site.walls.iter().any(|wall| step.meets(&wall.line))
        };
        let mut run = 0;
        (0..places).any(|place| {
            run = if open(place) { run + 1 } else { 0 };
            run as f64 * step_m >= OPENING_M
        })
    })
}
