//! A tricycle with a caster between walls, and the lidar on it: ideal ray casting plus noise.

use crate::random::Random;
use description::geometry::{Footprint, Point2, Pose2, Rect, Segment, wrap_angle};
use description::robot::TricycleGeometry;
use description::wheels::{EncoderAngles, WheelSpeeds};
use skills::odometry::EncoderSample;
use skills::scan::ScanGeometry;

pub const STEP_NS: u64 = 1_000_000;
const WHEEL_LAG_S: f64 = 0.015;

pub struct Plant {
    pub walls: Vec<Segment>,
    pub obstacles: Vec<Rect>,
    pub geometry: TricycleGeometry,
    pub footprint: Footprint,
    pub now_ns: u64,
    pub pose: Pose2,
    pub encoders: EncoderSample,
    pub speeds: WheelSpeeds,
    pub random: Random,
    /// How much farther than their diameter says the wheels roll.
    pub scale: [f64; 2],
    pub driven_m: f64,
    /// Where the clearance was looked at last, and what it was.
    looked: (Pose2, f64),
}

impl Plant {
    pub fn new(seed: u64, walls: Vec<Segment>, footprint: Footprint, pose: Pose2) -> Self {
        let mut random = Random::new(seed);
        let scale = [random.between(0.99, 1.01), random.between(0.99, 1.01)];
        Self {
            walls,
            obstacles: Vec::new(),
            geometry: TricycleGeometry::default(),
            footprint,
            now_ns: 1_000_000_000,
            pose,
            encoders: EncoderSample {
                angles: EncoderAngles {
                    pivot_rad: random.between(-0.5, 0.5),
                    ..EncoderAngles::default()
                },
                ..EncoderSample::default()
            },
            speeds: WheelSpeeds::default(),
            random,
            scale,
            driven_m: 0.0,
            looked: (pose, f64::NEG_INFINITY),
        }
    }

    pub fn step(&mut self, wanted: WheelSpeeds) {
        let dt_s = STEP_NS as f64 * 1e-9;
        let share = 1.0 - (-dt_s / WHEEL_LAG_S).exp();
        self.speeds.left_rad_s += share * (wanted.left_rad_s - self.speeds.left_rad_s);
        self.speeds.right_rad_s += share * (wanted.right_rad_s - self.speeds.right_rad_s);
        let geometry = &self.geometry;
        let radius_m = geometry.wheel_radius_m();
        let left_m_s = self.speeds.left_rad_s * radius_m * self.scale[0];
        let right_m_s = self.speeds.right_rad_s * radius_m * self.scale[1];
        let unit_m_s = (left_m_s + right_m_s) / 2.0;
        let turn_rad_s = (right_m_s - left_m_s) / geometry.wheel_separation_m;
        let (sin, cos) = self.encoders.angles.pivot_rad.sin_cos();
        let caster_m = geometry.caster_offset_m;
        let omega_rad_s = (unit_m_s * sin + caster_m * turn_rad_s * cos) / geometry.wheelbase_m;
        let v_m_s = unit_m_s * cos - caster_m * turn_rad_s * sin;
        self.pose = self
            .pose
            .advance(description::geometry::Twist2::new(v_m_s, omega_rad_s), dt_s);
        self.driven_m += v_m_s.abs() * dt_s;
        self.encoders.angles.left_rad += self.speeds.left_rad_s * dt_s;
        self.encoders.angles.right_rad += self.speeds.right_rad_s * dt_s;
        self.encoders.angles.pivot_rad =
            wrap_angle(self.encoders.angles.pivot_rad + (turn_rad_s - omega_rad_s) * dt_s);
        self.now_ns += STEP_NS;
        self.encoders.stamp_ns = self.now_ns;
    }

    /// Distance of the body from the nearest wall; negative when it touches one.
    pub fn clearance_m(&self) -> f64 {
        let body = self.footprint.as_rect();
        let mut nearest_m = f64::INFINITY;
        for wall in &self.walls {
            let seen = wall.seen_from(self.pose);
            let length_m = seen.length_m();
            let (enter_m, exit_m) = exit_range_m(&body, seen.a, seen.direction_rad());
            if enter_m <= exit_m && exit_m >= 0.0 && enter_m <= length_m {
                return -1.0;
            }
            let corners = self.footprint.corners();
            nearest_m = corners
                .iter()
                .map(|&corner| seen.distance_m(corner))
                .chain([seen.a, seen.b].map(|end| body.distance_m(end)))
                .fold(nearest_m, f64::min);
        }
        nearest_m
    }

    /// The clearance where it is not more than a bound of at least 0. It is not looked at where the body cannot have come so near since
    /// it was: no part of it moves farther than its middle and its corner.
    pub fn clearance_within_m(&mut self, bound_m: f64) -> Option<f64> {
        let (from, clear_m) = self.looked;
        let turned_rad = wrap_angle(self.pose.theta_rad - from.theta_rad).abs();
        let moved_m = from.position().distance_m(self.pose.position())
            + turned_rad * self.footprint.radius_m();
        if clear_m - 1.001 * moved_m > bound_m {
            return None;
        }
        self.looked = (self.pose, self.clearance_m());
        Some(self.looked.1).filter(|&clear_m| clear_m <= bound_m)
    }

    /// The body's corners in `map`.
    pub fn corners(&self) -> [Point2; 4] {
        self.footprint
            .corners()
            .map(|corner| self.pose.transform(corner))
    }

    /// One beam, in millimetres or a code, as a URG reports it.
    pub fn beam_mm(&mut self, scan: &ScanGeometry, beam: usize) -> u16 {
        let sensor = self.pose.compose(scan.mount);
        let direction_rad = sensor.theta_rad + scan.beam_angle_rad(beam);
        let origin = sensor.position();
        let mut range_m = self
            .walls
            .iter()
            .filter_map(|wall| wall.ray_range_m(origin, direction_rad))
            .fold(f64::INFINITY, f64::min);
        for obstacle in &self.obstacles {
            let (enter_m, exit_m) = exit_range_m(obstacle, origin, direction_rad);
            if enter_m >= 0.0 && enter_m <= exit_m {
                range_m = range_m.min(enter_m);
            }
        }
        // Ten millimetres, or one per cent from a metre on.
        let std_m = 0.01 * range_m.max(1.0);
        if range_m.is_finite() {
            range_m += self.random.normal(std_m);
        }
        if self.random.uniform() < 0.002 {
            return 1 + (self.random.uniform() * 18.0) as u16;
        }
        if range_m > scan.range_max_m {
            0
        } else {
            (range_m * 1e3).max(20.0) as u16
        }
    }
}

/// Where a ray enters and leaves a rectangle; enters after it leaves when it misses.
fn exit_range_m(rect: &Rect, origin: Point2, direction_rad: f64) -> (f64, f64) {
    let (sin, cos) = direction_rad.sin_cos();
    let mut span = (f64::NEG_INFINITY, f64::INFINITY);
    for (low, high, at, slope) in [
        (rect.min.x_m, rect.max.x_m, origin.x_m, cos),
        (rect.min.y_m, rect.max.y_m, origin.y_m, sin),
    ] {
        let slope = if slope.abs() < 1e-12 { 1e-12 } else { slope };
        let (one, other) = ((low - at) / slope, (high - at) / slope);
        span = (span.0.max(one.min(other)), span.1.min(one.max(other)));
    }
    span
}
