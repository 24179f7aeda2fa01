//! A world of discs, boxes and walls: ideal ranges by ray casting, exact overlaps.

use crate::history::OdometryHistory;
use crate::scan::{AlignedScan, ScanGeometry};
use crate::tubes::{Adapted, MotionTubes, Verdict};
use description::geometry::{Footprint, MotionCommand, Point2, Pose2, Segment, Twist2};

pub const MS: u64 = 1_000_000;

/// The small robot and its sensor.
pub const SMALL: Footprint = Footprint {
    front_m: 0.32,
    rear_m: 0.08,
    left_m: 0.15,
    right_m: 0.15,
};

/// The big robot.
pub const BIG: Footprint = Footprint {
    front_m: 0.65,
    rear_m: 0.25,
    left_m: 0.35,
    right_m: 0.35,
};

pub fn urg() -> ScanGeometry {
    ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0)
}

#[derive(Clone, Copy, Debug)]
pub enum Thing {
    Disc { centre: Point2, radius_m: f64 },
    Box { middle: Pose2, half_m: [f64; 2] },
    Wall(Segment),
}

fn edges(middle: Pose2, [x, y]: [f64; 2]) -> [Segment; 4] {
    let corners = [(x, y), (-x, y), (-x, -y), (x, -y)];
    let corner = |i: usize| {
        let (x, y) = corners[i % 4];
        middle.transform(Point2::new(x, y))
    };
    std::array::from_fn(|i| Segment::new(corner(i), corner(i + 1)))
}

impl Thing {
    pub fn ray_range_m(&self, origin: Point2, direction_rad: f64) -> Option<f64> {
        match *self {
            Self::Wall(wall) => wall.ray_range_m(origin, direction_rad),
            Self::Box { middle, half_m } => edges(middle, half_m)
                .iter()
                .filter_map(|edge| edge.ray_range_m(origin, direction_rad))
                .min_by(f64::total_cmp),
            Self::Disc { centre, radius_m } => {
                let (sin, cos) = direction_rad.sin_cos();
                let ray = Point2::new(cos, sin);
                let along_m = (centre - origin).dot(ray);
                let off_m = (centre - origin).cross(ray);
                let inside = radius_m * radius_m - off_m * off_m;
                (inside >= 0.0 && along_m > 0.0).then(|| (along_m - inside.sqrt()).max(0.0))
            }
        }
    }

    /// Overlap with the robot at a pose; touching is none.
    pub fn overlaps(&self, footprint: &Footprint, robot: Pose2) -> bool {
        match *self {
            Self::Disc { centre, radius_m } => {
                footprint.distance_m(robot.inverse_transform(centre)) < radius_m - 1e-9
            }
            Self::Wall(wall) => {
                let wall = wall.seen_from(robot);
                separation_m(footprint, &[wall.a, wall.b]) < -1e-9
            }
            Self::Box { middle, half_m } => {
                let corners = edges(middle, half_m).map(|edge| robot.inverse_transform(edge.a));
                separation_m(footprint, &corners) < -1e-9
            }
        }
    }
}

/// Largest gap between the footprint and a convex shape over all separating directions; negative when they overlap.
fn separation_m(footprint: &Footprint, shape: &[Point2]) -> f64 {
    let body = footprint.corners();
    let normals = (0..shape.len()).map(|i| {
        let edge = shape[(i + 1) % shape.len()] - shape[i];
        Point2::new(edge.y_m, -edge.x_m) * (1.0 / edge.norm_m())
    });
    normals
        .chain([Point2::new(1.0, 0.0), Point2::new(0.0, 1.0)])
        .flat_map(|normal| [normal, normal * -1.0])
        .map(|normal| {
            let of = |points: &[Point2], pick: fn(f64, f64) -> f64, start: f64| {
                points
                    .iter()
                    .map(|point| point.dot(normal))
                    .fold(start, pick)
            };
            of(shape, f64::min, f64::INFINITY) - of(&body, f64::max, f64::NEG_INFINITY)
        })
        .fold(f64::NEG_INFINITY, f64::max)
}

/// What a beam measures, in millimetres; 0 when nothing is in range.
pub fn range_mm(things: &[Thing], sensor: Pose2, direction_rad: f64) -> u16 {
    things
        .iter()
        .filter_map(|thing| thing.ray_range_m(sensor.position(), sensor.theta_rad + direction_rad))
        .min_by(f64::total_cmp)
        .filter(|range_m| *range_m < 5.6)
        .map_or(0, |range_m| ((range_m * 1e3).round() as u16).max(20))
}

/// A robot with a history and a sensor, at a true pose that its odometry knows exactly.
pub struct Robot {
    pub pose: Pose2,
    pub now_ns: u64,
    pub history: OdometryHistory,
    pub scan: AlignedScan,
    /// Standard deviation of a range.
    pub noise_m: f64,
}

impl Robot {
    pub fn new(pose: Pose2, geometry: ScanGeometry) -> Self {
        let mut robot = Self {
            pose,
            now_ns: 1_000 * MS,
            history: OdometryHistory::default(),
            scan: AlignedScan::new(geometry).unwrap().without_frozen_check(),
            noise_m: 0.0,
        };
        robot.drive(Twist2::default(), 0.2);
        robot
    }

    /// Drives for a time in steps of 5 ms.
    pub fn drive(&mut self, twist: Twist2, duration_s: f64) {
        let steps = (duration_s / 0.005).round() as u64;
        for _ in 0..steps {
            self.pose = self.pose.advance(twist, 0.005);
            self.now_ns += 5 * MS;
            self.history.push(self.now_ns, self.pose, twist).unwrap();
        }
    }

    /// Measures a scan that ends now, from where the robot was meanwhile.
    pub fn measure(&mut self, things: &[Thing]) {
        self.measure_with(things, &mut Random(0));
    }

    pub fn measure_with(&mut self, things: &[Thing], random: &mut Random) {
        let geometry = *self.scan.geometry();
        let duration_ns = geometry.duration_ns();
        let stamp_ns = self.now_ns - duration_ns;
        let raw: Vec<u16> = (0..geometry.beams)
            .map(|beam| {
                let at_ns = stamp_ns + duration_ns * beam as u64 / (geometry.beams as u64 - 1);
                let sensor = self.history.at(at_ns).unwrap().compose(geometry.mount);
                match range_mm(things, sensor, geometry.beam_angle_rad(beam)) {
                    0 => 0,
                    exact => {
                        // The sum of twelve is nearly normal.
                        let normal = (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
                        let noisy = f64::from(exact) + 1e3 * self.noise_m * normal;
                        noisy.max(20.0) as u16
                    }
                }
            })
            .collect();
        self.scan.align(&raw, stamp_ns, &self.history).unwrap();
    }
}

/// Small, seeded, good enough: splitmix64.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// A disc or a box whose sides are all longer than `sample_step_m`.
    pub fn thing(&mut self, middle: Point2, sample_step_m: f64) -> Thing {
        let mut half_m = || {
            let largest = if self.unit() < 0.6 { 1.3 } else { 8.0 };
            sample_step_m * 0.5 * self.between(1.001, largest)
        };
        let (x, y) = (half_m(), half_m());
        if self.unit() < 0.5 {
            Thing::Disc {
                centre: middle,
                radius_m: x,
            }
        } else {
            let turn_rad = self.between(-3.2, 3.2);
            Thing::Box {
                middle: Pose2::new(middle.x_m, middle.y_m, turn_rad),
                half_m: [x, y],
            }
        }
    }
}

/// The reference corridor: 10 m × 3.2 m, closed.
pub fn corridor() -> Vec<Thing> {
    let corner = |x_m: f64, y_m: f64| Point2::new(x_m, y_m);
    let corners = [
        corner(0.0, -1.6),
        corner(10.0, -1.6),
        corner(10.0, 1.6),
        corner(0.0, 1.6),
    ];
    (0..4)
        .map(|i| Thing::Wall(Segment::new(corners[i], corners[(i + 1) % 4])))
        .collect()
}

/// A robot that drives what the tubes let it: a scan every 100 ms, which arrives 20 ms after its end, a command every
/// 50 ms, and a drive of limited acceleration and steering rate.
pub struct Drive {
    pub robot: Robot,
    pub tubes: MotionTubes,
    pub twist: Twist2,
    pub noise_m: f64,
    pub random: Random,
    /// No scans while set.
    pub blind: bool,
    curvature_1_m: f64,
}

impl Drive {
    pub fn new(robot: Robot, tubes: MotionTubes) -> Self {
        Self {
            robot,
            tubes,
            twist: Twist2::default(),
            noise_m: 0.0,
            random: Random(3),
            blind: false,
            curvature_1_m: 0.0,
        }
    }

    /// 100 ms of driving; gives the first adaptation.
    pub fn tick(&mut self, things: &[Thing], wanted: MotionCommand) -> Adapted {
        if !self.blind {
            self.robot.noise_m = self.noise_m;
            self.robot.measure_with(things, &mut self.random);
        }
        self.advance(self.twist, self.curvature_1_m, 4);
        if !self.blind {
            let seen = self.tubes.observe(&self.robot.scan, self.robot.now_ns);
            seen.unwrap();
        }
        let first = self.command(wanted, 10);
        self.command(wanted, 6);
        first
    }

    fn command(&mut self, wanted: MotionCommand, steps: usize) -> Adapted {
        let adapted = self.tubes.adapt(wanted, self.twist, self.robot.now_ns);
        let target_m_s = adapted.command.speed_m_s;
        let braking_m_s2 = if adapted.verdict == Verdict::Stopped {
            2.0
        } else {
            0.8
        };
        for _ in 0..steps {
            let speed_m_s = self.twist.v_m_s;
            let speed_m_s =
                target_m_s.clamp(speed_m_s - braking_m_s2 * 0.005, speed_m_s + 0.5 * 0.005);
            let turn_1_m = adapted.command.curvature_1_m - self.curvature_1_m;
            self.curvature_1_m += turn_1_m.clamp(-0.05, 0.05);
            let twist = MotionCommand::new(speed_m_s, self.curvature_1_m).twist();
            self.advance(twist, self.curvature_1_m, 1);
        }
        adapted
    }

    fn advance(&mut self, twist: Twist2, curvature_1_m: f64, steps: usize) {
        self.twist = twist;
        self.curvature_1_m = curvature_1_m;
        self.robot.drive(twist, 0.005 * steps as f64);
    }
}
