//! A robot that follows a lane through its motion tubes, in a plant with the timing of the real one: control every 5 ms,
//! ten scans a second that turn for 66 ms and arrive late, tubes on each scan and at least every 50 ms.

use crate::clutter::world::{self, Disc, World};
use crate::plant::{Plant, STEP_NS};
use crate::random::Random;
use description::geometry::{Footprint, MotionCommand, Pose2, wrap_angle};
use description::robot::TricycleGeometry;
use description::robot::{AdaptPolicy, Horizon, Tubes};
use description::robot::{Control, DriveLimits};
use description::wheels::WheelSpeeds;
use skills::drive::{StopKind, WheelController};
use skills::history::OdometryHistory;
use skills::odometry::DeadReckoning;
use skills::scan::{AlignedScan, ScanGeometry};
use skills::tubes::{Adapted, MotionTubes, Reason, StopRules, TubeSet, Verdict};

pub const FOOTPRINT: Footprint = Footprint {
    front_m: 0.32,
    rear_m: 0.08,
    left_m: 0.15,
    right_m: 0.15,
};

const CONTROL_NS: u64 = 5_000_000;
const SCAN_NS: u64 = 100_000_000;
/// From the last beam until the scan has come over the serial line.
const SCAN_DELAY_NS: u64 = 25_000_000;
const ADAPT_NS: u64 = 50_000_000;

pub fn lidar() -> ScanGeometry {
    ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0)
}

pub struct Robot {
    pub plant: Plant,
    pub world: World,
    pub tubes: MotionTubes,
    pub adapted: Adapted,
    pub lane_y_m: f64,
    pub wanted: Option<MotionCommand>,
    dead_reckoning: DeadReckoning,
    controller: WheelController,
    history: OdometryHistory,
    aligned: AlignedScan,
    raw: Vec<u16>,
    raw_stamp_ns: u64,
    next_beam: usize,
    scan_due_ns: Option<u64>,
    next_scan_ns: u64,
    last_adapt_ns: u64,
    setpoints: WheelSpeeds,
    random: Random,
    /// Pose error of navigation.
    off: Pose2,
}

impl Robot {
    pub fn new(seed: u64, world: World, start: Pose2) -> Self {
        let parameters = Tubes {
            backward_horizons: vec![Horizon {
                horizon_s: 1.5,
                speed_m_s: 0.10,
            }],
            ..Tubes::default()
        };
        let mut policy = AdaptPolicy::default();
        policy.detour.curvature_1_m = 2.5;
        let (set, _) = TubeSet::generate(&parameters, &FOOTPRINT, &lidar()).expect("sound tubes");
        let mut plant = Plant::new(seed, world.walls(), FOOTPRINT, start);
        plant.obstacles.clone_from(&world.boxes);
        let mut random = Random::new(seed ^ 0x77);
        let off = Pose2::new(
            0.0,
            random.between(-0.02, 0.02),
            random.between(-0.015, 0.015),
        );
        let geometry = TricycleGeometry::default();
        let next_scan_ns = plant.now_ns + 50 * STEP_NS;
        Self {
            plant,
            world,
            tubes: MotionTubes::new(set, policy, StopRules::default()).expect("a sound policy"),
            adapted: Adapted::default(),
            lane_y_m: start.y_m,
            wanted: None,
            dead_reckoning: DeadReckoning::new(geometry, 35.0).expect("sound geometry"),
            controller: WheelController::new(geometry, DriveLimits::default(), Control::default())
                .expect("sound limits"),
            history: OdometryHistory::default(),
            aligned: AlignedScan::new(lidar()).expect("a sound lidar"),
            raw: vec![0; lidar().beams],
            raw_stamp_ns: 0,
            next_beam: 0,
            scan_due_ns: None,
            next_scan_ns,
            last_adapt_ns: 0,
            setpoints: WheelSpeeds::default(),
            random,
            off,
        }
    }

    /// One millisecond; says whether the tubes were asked.
    pub fn step(&mut self) -> bool {
        self.plant.step(self.setpoints);
        self.world.step(1e-3);
        self.sweep();
        let now_ns = self.plant.now_ns;
        if now_ns.is_multiple_of(CONTROL_NS) {
            self.control();
        }
        let arrived = self.scan_due_ns.is_some_and(|due_ns| now_ns >= due_ns);
        if !arrived && now_ns - self.last_adapt_ns < ADAPT_NS {
            return false;
        }
        if arrived {
            self.scan_due_ns = None;
            let aligned = self
                .aligned
                .align(&self.raw, self.raw_stamp_ns, &self.history);
            if aligned.is_ok() {
                self.tubes
                    .observe(&self.aligned, now_ns)
                    .expect("a good scan");
            }
        }
        self.last_adapt_ns = now_ns;
        let wanted = self.wanted.unwrap_or_else(|| self.follow_lane());
        let current = self.dead_reckoning.odometry().twist;
        self.adapted = self.tubes.adapt(wanted, current, now_ns);
        true
    }

    /// As the corridor controller does: approaches its lane at a bounded angle, slower when far off it.
    fn follow_lane(&self) -> MotionCommand {
        let pose = self.plant.pose;
        let lateral_m = pose.y_m - self.lane_y_m + self.off.y_m;
        let heading_rad = wrap_angle(pose.theta_rad + self.off.theta_rad);
        let approach_rad = (lateral_m.abs() / 0.6).atan().min(0.7);
        let off_rad = heading_rad + lateral_m.clamp(-approach_rad, approach_rad);
        let share = heading_rad.cos().max(0.0) / (1.0 + (2.0 * lateral_m).powi(2));
        MotionCommand::new(0.4 * share.max(0.3), (-4.0 * off_rad).clamp(-2.5, 2.5))
    }

    fn control(&mut self) {
        let _ = self.dead_reckoning.update(&self.plant.encoders);
        let odometry = *self.dead_reckoning.odometry();
        let _ = self
            .history
            .push(odometry.stamp_ns, odometry.pose, odometry.twist);
        let must_stop =
            self.adapted.verdict == Verdict::Stopped && self.adapted.reason != Reason::None;
        let stop = if must_stop {
            StopKind::Hard
        } else {
            StopKind::None
        };
        self.setpoints = self.controller.step(
            self.adapted.command,
            stop,
            odometry.steering_rad,
            self.plant.speeds,
            CONTROL_NS as f64 * 1e-9,
        );
    }

    /// Measures the beams whose time has come.
    fn sweep(&mut self) {
        let now_ns = self.plant.now_ns;
        if now_ns < self.next_scan_ns {
            return;
        }
        let lidar = lidar();
        if self.next_beam == 0 {
            self.raw_stamp_ns = now_ns;
        }
        let passed = (now_ns - self.next_scan_ns) as f64 / lidar.duration_ns() as f64;
        let upto = ((passed * lidar.beams as f64) as usize + 1).min(lidar.beams);
        while self.next_beam < upto {
            let still_mm = self.plant.beam_mm(&lidar, self.next_beam);
            let sensor = self.plant.pose.compose(lidar.mount);
            let direction_rad = sensor.theta_rad + lidar.beam_angle_rad(self.next_beam);
            let disc_m = self.world.disc_range_m(sensor.position(), direction_rad);
            self.raw[self.next_beam] = match (still_mm, disc_m) {
                (code, _) if (1..20).contains(&code) => code,
                (_, Some(range_m)) if range_m < 4.0 => {
                    let noise_m = self.random.normal(0.01 * range_m.max(1.0));
                    let disc_mm = ((range_m + noise_m) * 1e3).max(20.0) as u16;
                    if still_mm == 0 {
                        disc_mm
                    } else {
                        still_mm.min(disc_mm)
                    }
                }
                _ => still_mm,
            };
            self.next_beam += 1;
        }
        if self.next_beam == lidar.beams {
            self.next_beam = 0;
            self.scan_due_ns = Some(now_ns + SCAN_DELAY_NS);
            self.next_scan_ns += SCAN_NS;
        }
    }

    /// Distance of the body from walls and boxes; negative when it overlaps one.
    pub fn still_clearance_m(&self) -> f64 {
        let walls_m = self.plant.clearance_m();
        let boxes_m = self
            .world
            .boxes
            .iter()
            .map(|one| world::separation_m(&FOOTPRINT, self.plant.pose, one));
        boxes_m.fold(walls_m, f64::min)
    }

    /// The disc that overlaps the body, if one does.
    pub fn touched(&self) -> Option<Disc> {
        let pose = self.plant.pose;
        self.world
            .discs
            .iter()
            .find(|disc| FOOTPRINT.distance_m(pose.inverse_transform(disc.centre)) < disc.radius_m)
            .copied()
    }
}
