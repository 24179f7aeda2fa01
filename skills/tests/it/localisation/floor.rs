//! What really stands on the floor, and a lidar and odometry with errors among it.

use crate::random::Random;
use description::geometry::{Point2, Pose2, Segment, Twist2};
use skills::history::OdometryHistory;
use skills::odometry::Odometry;
use skills::scan::{AlignedScan, ScanGeometry};

/// A disc on the floor that may move: a leg, a person, a pillar.
#[derive(Clone, Copy)]
pub struct Disc {
    pub at: Point2,
    pub radius_m: f64,
    pub moves_m_s: Point2,
}

/// Everything that reflects.
#[derive(Clone, Default)]
pub struct Floor {
    pub walls: Vec<Segment>,
    pub discs: Vec<Disc>,
}

impl Floor {
    pub fn of(walls: impl IntoIterator<Item = Segment>) -> Self {
        Self {
            walls: walls.into_iter().collect(),
            discs: Vec::new(),
        }
    }

    /// A box of this size, turned: another robot, a crate.
    pub fn put_box(&mut self, pose: Pose2, length_m: f64, width_m: f64) {
        let corner =
            |x: f64, y: f64| pose.transform(Point2::new(x * length_m / 2.0, y * width_m / 2.0));
        let corners = [
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
        ];
        for side in 0..4 {
            self.walls
                .push(Segment::new(corners[side], corners[(side + 1) % 4]));
        }
    }

    fn range_m(&self, origin: Point2, direction_rad: f64) -> f64 {
        let ray = Point2::new(direction_rad.cos(), direction_rad.sin());
        let walls = self.walls.iter().filter_map(|wall| {
            let (edge, offset) = (wall.b - wall.a, wall.a - origin);
            let scale = 1.0 / ray.cross(edge);
            let share = offset.cross(ray) * scale;
            let range_m = offset.cross(edge) * scale;
            (range_m >= 0.0 && (0.0..=1.0).contains(&share)).then_some(range_m)
        });
        let discs = self.discs.iter().filter_map(|disc| {
            let to = disc.at - origin;
            let along_m = to.dot(ray);
            let off_m2 = to.dot(to) - along_m * along_m;
            let half_m2 = disc.radius_m * disc.radius_m - off_m2;
            (along_m > 0.0 && half_m2 > 0.0).then(|| along_m - half_m2.sqrt())
        });
        walls.chain(discs).fold(f64::INFINITY, f64::min)
    }
}

pub const STEP_NS: u64 = 10_000_000;
const SCAN_STEPS: u64 = 10;

/// A robot that drives exactly as told, and measures with errors.
pub struct Vehicle {
    pub floor: Floor,
    pub truth: Pose2,
    before: Pose2,
    pub odometry: Odometry,
    pub random: Random,
    /// Of distance, of turning, and turning per metre.
    pub errors: [f64; 3],
    pub history: OdometryHistory,
    pub scan: AlignedScan,
    pub lidar: ScanGeometry,
    raw: Vec<u16>,
    steps: u64,
    begun_ns: u64,
    next_beam: usize,
}

impl Vehicle {
    pub fn new(seed: u64, floor: Floor, truth: Pose2) -> Self {
        let lidar = ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0);
        let mut random = Random::new(seed);
        let errors = [
            random.between(-0.01, 0.01),
            random.between(-0.01, 0.01),
            random.between(-0.005, 0.005),
        ];
        Self {
            floor,
            truth,
            before: truth,
            odometry: Odometry {
                stamp_ns: 1_000_000_000,
                pose: Pose2::new(3.0, -2.0, 1.0),
                ..Odometry::default()
            },
            random,
            errors,
            history: OdometryHistory::default(),
            scan: AlignedScan::new(lidar).expect("sound lidar"),
            lidar,
            raw: vec![0; lidar.beams],
            steps: 0,
            begun_ns: 0,
            next_beam: 0,
        }
    }

    /// Ten milliseconds; `true` when a new scan is ready.
    pub fn step(&mut self, twist: Twist2) -> bool {
        self.drive(twist);
        self.sweep()
    }

    /// Moves for ten milliseconds, without looking.
    pub fn drive(&mut self, twist: Twist2) {
        let dt_s = STEP_NS as f64 * 1e-9;
        self.before = self.truth;
        self.truth = self.truth.advance(twist, dt_s);
        for disc in &mut self.floor.discs {
            disc.at = disc.at + disc.moves_m_s * dt_s;
        }
        let [scale, turn_scale, bend] = self.errors;
        let slip = 1.0 + self.random.normal(0.02);
        let v_m_s = twist.v_m_s * (1.0 + scale) * slip;
        let noise = self.random.normal(0.002) * (twist.v_m_s.abs() / 0.4).sqrt();
        let omega_rad_s = twist.omega_rad_s * (1.0 + turn_scale) + bend * twist.v_m_s + noise;
        let measured = Twist2::new(v_m_s, omega_rad_s);
        self.odometry.pose = self.odometry.pose.advance(measured, dt_s);
        self.odometry.twist = measured;
        self.odometry.stamp_ns += STEP_NS;
        self.odometry.distance_m += measured.v_m_s.abs() * dt_s;
        self.odometry.turned_rad += measured.omega_rad_s.abs() * dt_s;
        let stamp_ns = self.odometry.stamp_ns;
        let _ = self
            .history
            .push(stamp_ns, self.odometry.pose, self.odometry.twist);
    }

    /// Measures the beams of this step; the sensor turns on all the time.
    fn sweep(&mut self) -> bool {
        let phase = self.steps % SCAN_STEPS;
        self.steps += 1;
        if phase == 0 {
            self.begun_ns = self.odometry.stamp_ns;
            self.next_beam = 0;
        }
        let beam_steps =
            self.lidar.duration_ns() as f64 / (STEP_NS as f64 * (self.lidar.beams - 1) as f64);
        while self.next_beam < self.lidar.beams {
            let late = phase as f64 - self.next_beam as f64 * beam_steps;
            if late < 0.0 {
                break;
            }
            // Each beam from where the robot was at its time.
            let base = self.truth.interpolate(self.before, late);
            let sensor = base.compose(self.lidar.mount);
            let direction_rad = sensor.theta_rad + self.lidar.beam_angle_rad(self.next_beam);
            let range_m = self.floor.range_m(sensor.position(), direction_rad);
            // Ten millimetres, or one per cent from a metre on.
            let measured_m = range_m + self.random.normal(0.01 * range_m.clamp(1.0, 10.0));
            self.raw[self.next_beam] = if self.random.uniform() < 0.002 {
                7
            } else if measured_m < self.lidar.range_max_m {
                (measured_m * 1e3).max(20.0) as u16
            } else {
                0
            };
            self.next_beam += 1;
        }
        phase == SCAN_STEPS - 1
            && self
                .scan
                .align(&self.raw, self.begun_ns, &self.history)
                .is_ok()
    }

    /// Where the last scan has `base_link`, seen from `base_link` now.
    pub fn since(&self) -> Pose2 {
        self.odometry.pose.between(self.scan.odom_pose())
    }
}
