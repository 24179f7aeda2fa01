//! Boxes that stand and discs that move in a hall.

use description::geometry::{Footprint, Point2, Pose2, Rect, Segment};

#[derive(Clone, Copy, Debug)]
pub struct Disc {
    pub centre: Point2,
    pub velocity: Point2,
    pub radius_m: f64,
}

#[derive(Clone, Debug)]
pub struct World {
    pub hall: Rect,
    pub boxes: Vec<Rect>,
    pub discs: Vec<Disc>,
}

impl World {
    pub fn new(boxes: Vec<Rect>) -> Self {
        Self {
            hall: rect([0.0, -1.6], [16.0, 1.6]),
            boxes,
            discs: Vec::new(),
        }
    }

    pub fn walls(&self) -> Vec<Segment> {
        let corners = corners(&self.hall);
        (0..4)
            .map(|i| Segment::new(corners[i], corners[(i + 1) % 4]))
            .collect()
    }

    /// Discs move on, and turn back at the walls.
    pub fn step(&mut self, dt_s: f64) {
        let hall = self.hall;
        for disc in &mut self.discs {
            disc.centre = disc.centre + disc.velocity * dt_s;
            let (centre, velocity, r) = (disc.centre, &mut disc.velocity, disc.radius_m);
            if centre.x_m < hall.min.x_m + r || centre.x_m > hall.max.x_m - r {
                let inward = if centre.x_m < 8.0 { 1.0 } else { -1.0 };
                velocity.x_m = inward * velocity.x_m.abs();
            }
            if centre.y_m < hall.min.y_m + r || centre.y_m > hall.max.y_m - r {
                velocity.y_m = -centre.y_m.signum() * velocity.y_m.abs();
            }
        }
    }

    pub fn disc_range_m(&self, origin: Point2, direction_rad: f64) -> Option<f64> {
        let (sin, cos) = direction_rad.sin_cos();
        let ray = Point2::new(cos, sin);
        let range_m = |disc: &Disc| {
            let along_m = (disc.centre - origin).dot(ray);
            let off_m = (disc.centre - origin).cross(ray);
            let inside = disc.radius_m * disc.radius_m - off_m * off_m;
            (inside >= 0.0 && along_m > 0.0).then(|| (along_m - inside.sqrt()).max(0.0))
        };
        self.discs.iter().filter_map(range_m).min_by(f64::total_cmp)
    }
}

pub fn rect(min: [f64; 2], max: [f64; 2]) -> Rect {
    Rect::new(min.into(), max.into())
}

fn corners(rect: &Rect) -> [Point2; 4] {
    [
        Point2::new(rect.min.x_m, rect.min.y_m),
        Point2::new(rect.max.x_m, rect.min.y_m),
        Point2::new(rect.max.x_m, rect.max.y_m),
        Point2::new(rect.min.x_m, rect.max.y_m),
    ]
}

/// Largest gap between the body and a rectangle over all separating directions; negative when they overlap.
pub fn separation_m(footprint: &Footprint, pose: Pose2, rect: &Rect) -> f64 {
    let body = footprint.corners().map(|corner| pose.transform(corner));
    let other = corners(rect);
    let ahead = pose.rotate(Point2::new(1.0, 0.0));
    let aside = pose.rotate(Point2::new(0.0, 1.0));
    [ahead, aside, Point2::new(1.0, 0.0), Point2::new(0.0, 1.0)]
        .into_iter()
        .flat_map(|normal| [normal, normal * -1.0])
        .map(|normal| {
            let least = other.iter().map(|point| point.dot(normal));
            let most = body.iter().map(|point| point.dot(normal));
            least.fold(f64::INFINITY, f64::min) - most.fold(f64::NEG_INFINITY, f64::max)
        })
        .fold(f64::NEG_INFINITY, f64::max)
}
