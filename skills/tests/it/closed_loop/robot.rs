//! The robot's software around the plant, with the timing of the real one: control every 5 ms, ten scans a second that
//! arrive late, navigation on each scan and at least every 50 ms.

use crate::closed_loop::floor::{FOOTPRINT, ROBOT, lidar};
use crate::closed_loop::site;
use crate::counting;
use crate::plant::{Plant, STEP_NS};
use coordination::event::EventTable;
use description::geometry::{MotionCommand, Pose2};
use description::robot::TricycleGeometry;
use description::robot::{Control, DriveLimits};
use description::wheels::WheelSpeeds;
use skills::borders::AreaSet;
use skills::drive::{StopKind, WheelController};
use skills::history::OdometryHistory;
use skills::navigator::{ByHand, NavigationInput, NavigationOutput, Navigator, NavigatorSetup};
use skills::odometry::{DeadReckoning, EncoderSample};
use skills::scan::AlignedScan;

const CONTROL_NS: u64 = 5_000_000;
const SCAN_NS: u64 = 100_000_000;
/// From the last beam until the scan has come over the serial line.
const SCAN_DELAY_NS: u64 = 25_000_000;
const NAVIGATION_NS: u64 = 50_000_000;

/// What the world does to the sensors.
#[derive(Clone, Copy, Default)]
pub struct Trouble {
    pub no_scans: bool,
    pub frozen_scans: bool,
    /// Codes from this to that instead of ranges.
    pub codes: Option<(u16, u16)>,
    /// Ranges are longer than they are, by this.
    pub too_long_mm: u16,
    pub left_encoder_jumps: bool,
    pub pivot_encoder_jumps: bool,
}

pub struct Robot {
    pub plant: Plant,
    pub navigator: Navigator,
    pub events: EventTable,
    pub trouble: Trouble,
    pub motion_allowed: bool,
    pub by_hand: Option<ByHand>,
    pub allowed: AreaSet,
    pub dead_reckoning: DeadReckoning,
    pub output: Option<NavigationOutput>,
    /// Heap allocations counted inside the steps that must not allocate.
    pub allocations: u64,
    setup: NavigatorSetup,
    controller: WheelController,
    history: OdometryHistory,
    aligned: AlignedScan,
    raw: Vec<u16>,
    raw_stamp_ns: u64,
    next_beam: usize,
    scan_due_ns: Option<u64>,
    next_scan_ns: u64,
    last_navigation_ns: u64,
    command: MotionCommand,
    setpoints: WheelSpeeds,
    encoder_offset_rad: f64,
}

impl Robot {
    /// In the reference corridor, on its laps.
    pub fn new(seed: u64, believed: Pose2) -> Self {
        let plant = Plant::new(seed, site::walls(), FOOTPRINT, believed);
        Self::around(plant, site::setup(believed))
    }

    /// Starts near the setup's start pose, off by a typical error of a person who puts it down.
    pub fn around(mut plant: Plant, setup: NavigatorSetup) -> Self {
        let believed = setup.site.robots[ROBOT].start;
        let random = &mut plant.random;
        plant.pose = believed.compose(Pose2::new(
            random.between(-0.05, 0.05),
            random.between(-0.03, 0.03),
            random.between(-0.03, 0.03),
        ));
        let geometry = TricycleGeometry::default();
        let lidar = lidar();
        let next_scan_ns = plant.now_ns + 50 * STEP_NS;
        let navigator = Navigator::new(setup.clone()).expect("a sound setup");
        Self {
            plant,
            events: navigator.events().clone(),
            navigator,
            trouble: Trouble::default(),
            motion_allowed: true,
            by_hand: None,
            allowed: AreaSet::ALL,
            dead_reckoning: DeadReckoning::new(geometry, 35.0).expect("sound geometry"),
            output: None,
            allocations: 0,
            setup,
            controller: WheelController::new(geometry, DriveLimits::default(), Control::default())
                .expect("sound limits"),
            history: OdometryHistory::default(),
            aligned: AlignedScan::new(lidar).expect("sound lidar"),
            raw: vec![0; lidar.beams],
            raw_stamp_ns: 0,
            next_beam: 0,
            scan_due_ns: None,
            next_scan_ns,
            last_navigation_ns: 0,
            command: MotionCommand::STOP,
            setpoints: WheelSpeeds::default(),
            encoder_offset_rad: 0.0,
        }
    }

    /// Its process ends without being asked to, and begins again after a while. Meanwhile the drive stops the wheels.
    pub fn crash(&mut self, seconds: f64) {
        let left = self.navigator.checkpoint();
        let odometry = *self.dead_reckoning.odometry();
        for _ in 0..(seconds * 1e3) as u64 {
            self.plant.step(WheelSpeeds::STANDING);
        }
        self.navigator = Navigator::new(self.setup.clone()).expect("a sound setup");
        assert!(self.navigator.resume(&left), "{left:?}");
        self.dead_reckoning =
            DeadReckoning::new(TricycleGeometry::default(), 35.0).expect("sound geometry");
        self.dead_reckoning.resume(&odometry);
        self.history = OdometryHistory::default();
        (self.next_beam, self.scan_due_ns, self.output) = (0, None, None);
        self.next_scan_ns = self.plant.now_ns + SCAN_NS;
        self.last_navigation_ns = self.plant.now_ns;
        (self.command, self.setpoints) = (MotionCommand::STOP, WheelSpeeds::STANDING);
    }

    /// One millisecond; says what navigation said when it ran.
    pub fn step(&mut self) -> Option<NavigationOutput> {
        self.plant.step(self.setpoints);
        self.sweep();
        let now_ns = self.plant.now_ns;
        if now_ns.is_multiple_of(CONTROL_NS) {
            self.control();
        }
        let arrived = self.scan_due_ns.is_some_and(|due_ns| now_ns >= due_ns);
        if !arrived && now_ns - self.last_navigation_ns < NAVIGATION_NS {
            return None;
        }
        if arrived {
            self.scan_due_ns = None;
            if !self.trouble.no_scans {
                // A frozen scan is refused here; the one before stays and is not used again.
                let _ = self
                    .aligned
                    .align(&self.raw, self.raw_stamp_ns, &self.history);
            }
        }
        self.last_navigation_ns = now_ns;
        let before = counting::so_far();
        let output = self.navigator.step(&NavigationInput {
            now_ns,
            scan: Some(&self.aligned),
            odometry: self.dead_reckoning.odometry(),
            lost: false,
            motion_allowed: self.motion_allowed,
            by_hand: self.by_hand,
            allowed: self.allowed,
        });
        self.allocations += counting::so_far() - before;
        self.judge(&output);
        self.command = output.command;
        self.output = Some(output);
        self.output
    }

    /// What holds in every step of every run.
    fn judge(&self, output: &NavigationOutput) {
        let (before, after) = (self.command, output.command);
        let dt_s = match &self.output {
            Some(last) => (output.now_ns - last.now_ns) as f64 * 1e-9,
            None => 0.0,
        };
        let faster_m_s = after.speed_m_s.abs() - before.speed_m_s.abs();
        assert!(faster_m_s <= 0.5 * dt_s + 1e-9, "{faster_m_s} in {dt_s}");
        assert!(
            before.speed_m_s * after.speed_m_s >= 0.0,
            "{before:?} {after:?}"
        );
        assert!(after.curvature_1_m.abs() <= 2.5 && after.speed_m_s.abs() <= 0.4);
        let ahead = self.navigator.planned_path();
        let near = ahead
            .first()
            .is_none_or(|first| first.position().distance_m(output.pose.position()) < 0.06);
        assert!(near, "{ahead:?} from {:?}", output.pose);
    }

    /// The name of the machine's state.
    pub fn state(&self) -> &str {
        let machine = self.navigator.machine();
        machine.state_name(machine.state())
    }

    /// From the estimated to the true pose.
    pub fn pose_error_m(&self) -> f64 {
        self.output.map_or(0.0, |output| {
            let truth = self.plant.pose.position();
            truth.distance_m(output.pose.position())
        })
    }

    /// Drives until the machine has been in `state` for a time.
    pub fn run_until(&mut self, state: &str, limit_s: f64) {
        for _ in 0..(limit_s * 1e3) as u64 {
            self.step();
            assert!(
                self.plant.clearance_within_m(0.0).is_none(),
                "touches a wall: {:?}",
                self.output
            );
            if self.state() == state {
                return;
            }
        }
        panic!(
            "never in {state}: {:?} at {:?}",
            self.output, self.plant.pose
        );
    }

    /// Drives for a time.
    pub fn run_for(&mut self, seconds: f64) {
        for _ in 0..(seconds * 1e3) as u64 {
            self.step();
            assert!(
                self.plant.clearance_within_m(0.0).is_none(),
                "touches a wall: {:?}",
                self.output
            );
        }
    }

    fn control(&mut self) {
        let mut sample: EncoderSample = self.plant.encoders;
        if self.trouble.left_encoder_jumps && sample.stamp_ns.is_multiple_of(1_000_000_000) {
            self.encoder_offset_rad += 2.5;
        }
        if self.trouble.pivot_encoder_jumps && sample.stamp_ns.is_multiple_of(700_000_000) {
            sample.angles.pivot_rad += 0.7;
        }
        sample.angles.left_rad += self.encoder_offset_rad;
        let before = counting::so_far();
        let _ = self.dead_reckoning.update(&sample);
        let odometry = *self.dead_reckoning.odometry();
        let _ = self
            .history
            .push(odometry.stamp_ns, odometry.pose, odometry.twist);
        self.setpoints = self.controller.step(
            self.command,
            StopKind::None,
            odometry.steering_rad,
            self.plant.speeds,
            CONTROL_NS as f64 * 1e-9,
        );
        self.allocations += counting::so_far() - before;
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
            let measured = self.plant.beam_mm(&lidar, self.next_beam);
            if !self.trouble.frozen_scans {
                self.raw[self.next_beam] = match self.trouble.codes {
                    Some((low, high)) => {
                        let code = self
                            .plant
                            .random
                            .between(f64::from(low), f64::from(high) + 1.0);
                        code as u16
                    }
                    None => measured + self.trouble.too_long_mm,
                };
            }
            self.next_beam += 1;
        }
        if self.next_beam == lidar.beams {
            self.next_beam = 0;
            self.scan_due_ns = Some(now_ns + SCAN_DELAY_NS);
            self.next_scan_ns += SCAN_NS;
        }
    }
}
