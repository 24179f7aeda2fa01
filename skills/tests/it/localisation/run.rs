//! One drive along a way, with the pose estimated on the side.

use crate::counting;
use crate::localisation::floor::{Floor, Vehicle};
use crate::localisation::maps::Place;
use description::geometry::{Point2, Pose2, Twist2, wrap_angle};
use description::robot::Navigation;
use nalgebra::{Matrix3, Vector3};
use skills::localisation::{PoseFilter, WallsOutcome};
use skills::perception::walls::WallMatcher;

pub const START_STD_M: f64 = 0.10;
pub const START_STD_RAD: f64 = 0.10;

/// How exact the pose should be where features are in view.
pub const TARGET_M: f64 = 0.05;
pub const TARGET_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// Seeds to drive: a few, or as many as `LOCALISATION_RUNS` says.
pub fn seeds(few: u64) -> std::ops::Range<u64> {
    let runs = std::env::var("LOCALISATION_RUNS").ok();
    0..runs.map_or(few, |runs| runs.parse().expect("a number of runs"))
}

/// What is known after a scan.
#[derive(Clone, Debug)]
pub struct Sample {
    pub truth: Pose2,
    pub estimate: Pose2,
    pub covariance: Matrix3<f64>,
    pub position_std_m: f64,
    pub heading_std_rad: f64,
    pub uncertain: bool,
    pub outcome: WallsOutcome,
}

impl Sample {
    pub fn error(&self) -> Vector3<f64> {
        Vector3::new(
            self.estimate.x_m - self.truth.x_m,
            self.estimate.y_m - self.truth.y_m,
            wrap_angle(self.estimate.theta_rad - self.truth.theta_rad),
        )
    }

    pub fn off_m(&self) -> f64 {
        self.error().xy().norm()
    }

    pub fn off_rad(&self) -> f64 {
        self.error().z.abs()
    }

    /// Normalised estimation error squared, of three degrees of freedom.
    pub fn nees(&self) -> f64 {
        let inverse = self.covariance.try_inverse().expect("a covariance");
        (self.error().transpose() * inverse * self.error()).x
    }

    /// Wrong by more than the target and by more than four standard deviations, and does not say so.
    pub fn confidently_wrong(&self) -> bool {
        let error = self.error();
        let place = self.covariance.fixed_view::<2, 2>(0, 0).into_owned();
        let inverse = place.try_inverse().expect("a covariance");
        let astray = (error.xy().transpose() * inverse * error.xy()).x > 16.0;
        let askew = error.z.powi(2) > 16.0 * self.covariance[(2, 2)];
        !self.uncertain
            && ((astray && self.off_m() > TARGET_M) || (askew && self.off_rad() > TARGET_RAD))
    }
}

pub struct Drive {
    pub vehicle: Vehicle,
    pub filter: PoseFilter,
    pub matcher: WallMatcher,
    way: Vec<Point2>,
    reached: usize,
    pub speed_m_s: f64,
}

impl Drive {
    /// Believes to stand at the start of the way, and stands `off` from there.
    pub fn new(seed: u64, place: &Place, floor: Floor, off: Pose2) -> Self {
        let start = place.start();
        let vehicle = Vehicle::new(seed, floor, start.compose(off));
        let beams = vehicle.lidar.beams;
        Self {
            filter: PoseFilter::new(Navigation::default(), start, START_STD_M, START_STD_RAD),
            matcher: WallMatcher::new(&place.map, beams, Navigation::default()),
            vehicle,
            way: place.way.clone(),
            reached: 0,
            speed_m_s: 0.4,
        }
    }

    /// The start off by as much as it is said to be uncertain.
    pub fn honest(seed: u64, place: &Place, floor: Floor) -> Self {
        let mut drive = Self::new(seed, place, floor, Pose2::IDENTITY);
        let random = &mut drive.vehicle.random;
        let off = [
            random.normal(START_STD_M),
            random.normal(START_STD_M),
            random.normal(START_STD_RAD),
        ];
        let truth = &mut drive.vehicle.truth;
        *truth = Pose2::new(
            truth.x_m + off[0],
            truth.y_m + off[1],
            truth.theta_rad + off[2],
        );
        drive
    }

    /// Drives until the next scan was used; none when the way has ended.
    pub fn next(&mut self) -> Option<Sample> {
        loop {
            let twist = self.steer()?;
            if let Some(sample) = self.step(twist) {
                return Some(sample);
            }
        }
    }

    /// Moves for ten milliseconds.
    pub fn step(&mut self, twist: Twist2) -> Option<Sample> {
        let ready = self.vehicle.step(twist);
        self.filter.predict(&self.vehicle.odometry);
        ready.then(|| self.look())
    }

    pub fn look(&mut self) -> Sample {
        let since = self.vehicle.since();
        let before = counting::so_far();
        let outcome = self
            .filter
            .see_walls(&mut self.matcher, &self.vehicle.scan, since);
        assert_eq!(counting::so_far(), before, "a step allocated");
        Sample {
            truth: self.vehicle.truth,
            estimate: self.filter.pose(),
            covariance: *self.filter.covariance(),
            position_std_m: self.filter.position_std_m(),
            heading_std_rad: self.filter.heading_std_rad(),
            uncertain: self.filter.is_uncertain(),
            outcome,
        }
    }

    /// A driver who sees the truth: towards a point half a metre ahead on the way.
    fn steer(&mut self) -> Option<Twist2> {
        let truth = self.vehicle.truth;
        while self.reached + 1 < self.way.len() {
            let (from, to) = (self.way[self.reached], self.way[self.reached + 1]);
            let unit = (to - from) * (1.0 / from.distance_m(to));
            let left_m = from.distance_m(to) - unit.dot(truth.position() - from);
            if left_m > 0.5 {
                let along_m = unit.dot(truth.position() - from) + 0.5;
                let aim = truth.inverse_transform(from + unit * along_m);
                let curvature_1_m = (2.0 * aim.y_m / aim.dot(aim)).clamp(-2.2, 2.2);
                // Behind: as tight as it can.
                let curvature_1_m = if aim.x_m < 0.0 {
                    2.2f64.copysign(aim.y_m)
                } else {
                    curvature_1_m
                };
                return Some(Twist2::new(self.speed_m_s, self.speed_m_s * curvature_1_m));
            }
            self.reached += 1;
        }
        None
    }
}
