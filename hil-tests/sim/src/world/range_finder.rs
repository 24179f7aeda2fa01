//! What a URG-04LX mounted on a robot measures.
//!
//! A turn has 1024 steps and takes about 100 ms; step 384 looks along the mount's x axis and steps count
//! counter-clockwise. Each beam leaves from where the robot is at the beam's own time and meets obstacles and other
//! robots where they are then; it never meets its own robot. Readings are millimetres; under 20 they are the
//! device's error codes: 0 nothing within reach, 1 too little light, 6 too near, 19 a step it does not measure.

use std::sync::LazyLock;

use super::geometry::{Footprint, Point, Pose, SeenSegment, add, norm, ray_hit_disc_m, sub};
use super::random::Random;
use super::scene::{Outline, Target};
use super::simulation::World;
use crate::range_source::{RANGE_STEPS, STEPS_PER_TURN};

const FIRST_STEP: usize = 44;
const LAST_STEP: usize = 725;
const FRONT_STEP: usize = 384;

const NOTHING_WITHIN_REACH: u16 = 0;
const TOO_LITTLE_LIGHT: u16 = 1;
const TOO_NEAR: u16 = 6;
const NOT_MEASURABLE: u16 = 19;

/// Poses are looked up once for this many beams: 0.8 ms, or 0.3 mm at full speed.
const STEPS_PER_SLICE: usize = 8;
const SLICES: usize = RANGE_STEPS.div_ceil(STEPS_PER_SLICE);
/// Half a step beside the outermost beams of a slice: far beyond what rounding decides.
const ASIDE: f64 = 0.003;
/// Most distance that a robot travels during one turn.
const TRAVEL_M: f64 = 0.5;
/// Random streams of range noise begin here, apart from those of wheel errors.
const NOISE_STREAM: u64 = 1 << 32;

/// Range and accuracy of the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeModel {
    /// Shortest distance measured; anything closer gives an error code.
    pub min_m: f64,
    /// Beyond this, a growing share of readings is lost.
    pub reliable_m: f64,
    /// Beyond this, all readings are lost.
    pub max_m: f64,
    /// Standard deviation at short distances.
    pub sigma_m: f64,
    /// Standard deviation as a share of the distance, where that is larger; doubled beyond the reliable range.
    pub sigma_share: f64,
    /// Share of readings lost anywhere.
    pub dropout_share: f64,
}

impl Default for RangeModel {
    /// The URG-04LX: 20 mm to 4 m, up to 5.6 m, standard deviation 10 mm or 1 %.
    fn default() -> RangeModel {
        RangeModel {
            min_m: 0.02,
            reliable_m: 4.0,
            max_m: 5.6,
            sigma_m: 0.01,
            sigma_share: 0.01,
            dropout_share: 0.0,
        }
    }
}

impl RangeModel {
    fn reading_mm(&self, distance_m: f64, random: &mut Random) -> u16 {
        if distance_m > self.max_m {
            return NOTHING_WITHIN_REACH;
        }
        let beyond_m = (distance_m - self.reliable_m).max(0.0);
        let lost_share = (beyond_m / (self.max_m - self.reliable_m)).max(self.dropout_share);
        if random.unit() < lost_share {
            let weak = random.unit() < 0.1;
            return if weak {
                TOO_LITTLE_LIGHT
            } else {
                NOTHING_WITHIN_REACH
            };
        }
        let mut sigma_m = self.sigma_m.max(self.sigma_share * distance_m);
        if beyond_m > 0.0 {
            sigma_m *= 2.0;
        }
        let reading_m = distance_m + sigma_m * random.normal();
        if distance_m < self.min_m || reading_m < self.min_m {
            return TOO_NEAR;
        }
        (reading_m.min(self.max_m) * 1000.0).round() as u16
    }
}

/// The optics of one robot's lidar.
///
/// Capturing copies what is needed out of the world in a few microseconds; casting works on the copy, so that a
/// shared world is not held for longer.
#[derive(Debug, Clone)]
pub struct RangeFinder {
    robot: usize,
    model: RangeModel,
    random: Random,
    mount: Pose,
    slice_s: f64,
    origins: Vec<Pose>,
    targets: Vec<Target>,
    others: Vec<(Footprint, Vec<Pose>)>,
    /// What beams of the present slice may meet.
    visible: Visible,
}

impl RangeFinder {
    /// The lidar of a robot, by its index in the world.
    #[must_use]
    pub fn new(world: &World, robot: usize, model: RangeModel) -> RangeFinder {
        let mount = world
            .models()
            .nth(robot)
            .map_or(Pose::default(), |m| m.lidar);
        RangeFinder {
            robot,
            model,
            random: Random::new(world.seed(), NOISE_STREAM + robot as u64),
            mount,
            slice_s: 0.0,
            origins: Vec::with_capacity(SLICES),
            targets: Vec::new(),
            others: Vec::new(),
            visible: Visible::default(),
        }
    }

    /// Copies what the turn that began at `turn_start_ns` can see. The world must have been advanced to the end of
    /// the measuring range, three quarters of a turn later, and not by much more than another turn.
    pub fn capture(&mut self, world: &World, turn_start_ns: u64, turn_ns: u64) {
        let slice_ns = turn_ns as f64 * STEPS_PER_SLICE as f64 / STEPS_PER_TURN as f64;
        self.slice_s = slice_ns * 1e-9;
        let middle = |slice: usize| turn_start_ns + ((slice as f64 + 0.5) * slice_ns) as u64;
        let path = |robot: usize, poses: &mut Vec<Pose>| {
            poses.clear();
            let pose = |slice| world.pose_at(robot, middle(slice)).unwrap_or_default();
            poses.extend((0..SLICES).map(pose));
        };
        path(self.robot, &mut self.origins);
        for origin in &mut self.origins {
            *origin = origin.compose(&self.mount);
        }
        self.targets.clear();
        let reach_m = self.model.max_m + TRAVEL_M;
        world.targets(&self.origins[0], reach_m, turn_start_ns, &mut self.targets);
        self.others.resize_with(world.models().count(), || {
            (
                Footprint {
                    front_m: 0.0,
                    rear_m: 0.0,
                    left_m: 0.0,
                    right_m: 0.0,
                },
                Vec::new(),
            )
        });
        for (index, (model, other)) in world.models().zip(&mut self.others).enumerate() {
            other.0 = model.footprint;
            let apart_m = world.pose_at(index, turn_start_ns).map_or(0.0, |pose| {
                norm(sub(
                    [pose.x_m, pose.y_m],
                    [self.origins[0].x_m, self.origins[0].y_m],
                ))
            });
            // Both drive on during the turn.
            if index == self.robot || apart_m > reach_m + TRAVEL_M + model.footprint.reach_m() {
                other.1.clear();
            } else {
                path(index, &mut other.1);
            }
        }
    }

    /// Measures every step of the captured turn.
    pub fn cast(&mut self, readings_mm: &mut [u16; RANGE_STEPS]) {
        readings_mm.fill(NOT_MEASURABLE);
        for slice in FIRST_STEP / STEPS_PER_SLICE..=LAST_STEP / STEPS_PER_SLICE {
            let Some(origin) = self.origins.get(slice).copied() else {
                return;
            };
            let beams = Beams::of(&origin, slice);
            self.collect_visible(slice, &beams);
            let steps = slice * STEPS_PER_SLICE..(slice + 1) * STEPS_PER_SLICE;
            for (step, direction) in steps.zip(beams.directions) {
                if (FIRST_STEP..=LAST_STEP).contains(&step) {
                    let distance_m = self.visible.nearest_m(beams.from, direction);
                    readings_mm[step] = self.model.reading_mm(distance_m, &mut self.random);
                }
            }
        }
    }

    /// Distance of each step without noise or limits of range; infinite where there is nothing.
    pub fn cast_exact(&mut self, distances_m: &mut [f64; RANGE_STEPS]) {
        distances_m.fill(f64::INFINITY);
        for (slice, distances_m) in distances_m.chunks_mut(STEPS_PER_SLICE).enumerate() {
            let Some(origin) = self.origins.get(slice).copied() else {
                return;
            };
            let beams = Beams::of(&origin, slice);
            self.collect_visible(slice, &beams);
            for (distance_m, direction) in distances_m.iter_mut().zip(beams.directions) {
                *distance_m = self.visible.nearest_m(beams.from, direction);
            }
        }
    }

    /// Places everything that the beams of a slice may meet as it is in its middle.
    fn collect_visible(&mut self, slice: usize, beams: &Beams) {
        let age_s = (slice as f64 + 0.5) * self.slice_s;
        self.visible.clear();
        for target in &self.targets {
            let by_m = target.course.way_m(age_s);
            match target.outline {
                Outline::Segment(segment) => {
                    let seen = segment.moved(by_m).seen_from(beams.from);
                    self.visible.add(beams, seen);
                }
                Outline::Disc { centre_m, radius_m } => {
                    self.visible.discs.push((add(centre_m, by_m), radius_m));
                }
            }
        }
        for (footprint, poses) in &self.others {
            if let Some(pose) = poses.get(slice) {
                for edge in footprint.at(pose).edges() {
                    self.visible.add(beams, edge.seen_from(beams.from));
                }
            }
        }
    }
}

/// The beams of a slice.
struct Beams {
    from: Point,
    directions: [Point; STEPS_PER_SLICE],
    /// All of them lie between the rays in these two directions.
    right: Point,
    left: Point,
}

/// The directions of all steps, seen from the sensor: a sine for each beam of each scan would be a good part of a stepped run.
static DIRECTIONS: LazyLock<[Point; SLICES * STEPS_PER_SLICE]> = LazyLock::new(|| {
    std::array::from_fn(|step| {
        let angle_rad =
            (step as f64 - FRONT_STEP as f64) * std::f64::consts::TAU / STEPS_PER_TURN as f64;
        [angle_rad.cos(), angle_rad.sin()]
    })
});

impl Beams {
    fn of(origin: &Pose, slice: usize) -> Beams {
        let (sin, cos) = origin.theta_rad.sin_cos();
        let own = &DIRECTIONS[slice * STEPS_PER_SLICE..];
        let directions: [Point; STEPS_PER_SLICE] = std::array::from_fn(|index| {
            let [ahead, aside] = own[index];
            [cos * ahead - sin * aside, sin * ahead + cos * aside]
        });
        let (first, last) = (directions[0], directions[STEPS_PER_SLICE - 1]);
        Beams {
            from: [origin.x_m, origin.y_m],
            directions,
            right: [first[0] + ASIDE * first[1], first[1] - ASIDE * first[0]],
            left: [last[0] - ASIDE * last[1], last[1] + ASIDE * last[0]],
        }
    }
}

/// What may be met by the beams of a slice.
#[derive(Debug, Clone, Default)]
struct Visible {
    segments: Vec<SeenSegment>,
    discs: Vec<(Point, f64)>,
}

impl Visible {
    fn clear(&mut self) {
        self.segments.clear();
        self.discs.clear();
    }

    /// Adds a segment unless it is beside all beams.
    fn add(&mut self, beams: &Beams, segment: SeenSegment) {
        if !segment.is_beside(beams.right, -1.0) && !segment.is_beside(beams.left, 1.0) {
            self.segments.push(segment);
        }
    }

    fn nearest_m(&self, from: Point, direction: Point) -> f64 {
        let mut nearest_m = f64::INFINITY;
        for segment in &self.segments {
            if let Some(hit_m) = segment.ray_hit_m(direction) {
                nearest_m = nearest_m.min(hit_m);
            }
        }
        for (centre_m, radius_m) in &self.discs {
            if let Some(hit_m) = ray_hit_disc_m(*centre_m, *radius_m, from, direction) {
                nearest_m = nearest_m.min(hit_m);
            }
        }
        nearest_m
    }
}
