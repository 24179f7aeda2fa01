//! Which wall is to be seen in which direction from a place in the map.

use crate::direction::{direction_rad, floor};
use description::geometry::{Point2, Pose2, Segment, wrap_angle};
use std::f64::consts::TAU;

/// Directions that are told apart: half a degree.
const BINS: usize = 720;
const BIN_RAD: f64 = TAU / BINS as f64;
const BINS_PER_RAD: f64 = BINS as f64 / TAU;
/// Directions to either side of a beam that are asked, at most: 15°.
const MAX_SPREAD_BINS: usize = 30;

/// The nearest wall in a direction.
#[derive(Clone, Copy, Debug)]
struct Bin {
    wall: u32,
    /// One over how far off it is: that takes no division for each direction.
    per_range_1_m: f32,
}

const NOTHING: Bin = Bin {
    wall: u32::MAX,
    per_range_1_m: 0.0,
};

/// What a beam should hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected {
    candidates: [Bin; 5],
    /// The wall in just that direction, and how far off.
    pub(super) nearest: Option<(usize, f64)>,
}

impl Expected {
    /// The walls that the beam may have hit, each once.
    pub(super) fn walls(&self) -> impl Iterator<Item = usize> + '_ {
        let walls = self.candidates.map(|bin| bin.wall);
        { walls.into_iter().enumerate() }
            .filter(move |(index, wall)| *wall != u32::MAX && !walls[..*index].contains(wall))
            .map(|(_, wall)| wall as usize)
    }
}

/// The nearest wall in every direction.
#[derive(Clone, Debug)]
pub(super) struct View {
    bins: Box<[Bin]>,
    rays: Box<[Point2]>,
}

impl View {
    /// A view of nothing. Allocates, once.
    pub(super) fn new() -> Self {
        let ray = |bin: usize| {
            let (sin, cos) = ((bin as f64 + 0.5) * BIN_RAD).sin_cos();
            Point2::new(cos, sin)
        };
        Self {
            bins: vec![NOTHING; BINS].into_boxed_slice(),
            rays: (0..BINS).map(ray).collect(),
        }
    }

    /// Looks around from `eye` (in `map`) as far as `reach_m`.
    pub(super) fn look(&mut self, walls: &[Segment], eye: Pose2, reach_m: f64) {
        self.bins.fill(NOTHING);
        for (index, wall) in walls.iter().enumerate() {
            if wall.distance_m(eye.position()) < reach_m {
                self.draw(index as u32, wall, eye.position(), 1.0 / reach_m as f32);
            }
        }
    }

    fn draw(&mut self, index: u32, wall: &Segment, eye: Point2, per_reach_1_m: f32) {
        let (mut a, mut b) = (wall.a - eye, wall.b - eye);
        if a.cross(b) < 0.0 {
            (a, b) = (b, a);
        }
        let start = a.direction_rad().rem_euclid(TAU) / BIN_RAD;
        let span = wrap_angle(b.direction_rad() - a.direction_rad()).max(0.0) / BIN_RAD;
        // Bins whose middle lies within the wall.
        let first = (start - 0.5).ceil();
        let count = (start + span - 0.5 - first).floor() + 1.0;
        if !(1.0..=BINS as f64).contains(&count) {
            return;
        }
        let edge = b - a;
        let per_area_1_m2 = 1.0 / a.cross(edge);
        // From a place on its line it is seen from its end alone, which is no width.
        if !per_area_1_m2.is_finite() {
            return;
        }
        let mut bin = first as usize % BINS;
        for _ in 0..count as usize {
            let per_range_1_m = (self.rays[bin].cross(edge) * per_area_1_m2) as f32;
            if per_range_1_m > self.bins[bin].per_range_1_m.max(per_reach_1_m) {
                self.bins[bin] = Bin {
                    wall: index,
                    per_range_1_m,
                };
            }
            bin = if bin + 1 == BINS { 0 } else { bin + 1 };
        }
    }

    /// What a beam along `ray` (of length one) should hit when its direction is known to `spread_rad`.
    pub(super) fn expected(&self, ray: Point2, spread_rad: f64) -> Expected {
        let direction_rad = f64::from(direction_rad(ray.y_m as f32, ray.x_m as f32));
        let turned = (direction_rad + TAU) * BINS_PER_RAD;
        let middle = turned as usize % BINS;
        let spread = floor(-spread_rad * BINS_PER_RAD).saturating_neg();
        let spread = spread.clamp(1, MAX_SPREAD_BINS as i64) as usize;
        let at = |offset: usize| {
            let bin = middle + offset;
            self.bins[if bin < BINS { bin } else { bin - BINS }]
        };
        let half = spread.div_ceil(2);
        let candidates = [
            at(0),
            at(half),
            at(BINS - half),
            at(spread),
            at(BINS - spread),
        ];
        Expected {
            candidates,
            nearest: (candidates[0].wall != u32::MAX).then(|| {
                (
                    candidates[0].wall as usize,
                    1.0 / f64::from(candidates[0].per_range_1_m),
                )
            }),
        }
    }
}
