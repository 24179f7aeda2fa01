//! One robot in the corridor, on its devices.

use onboard::cli::Files;
use onboard::composition::checkpoint::Checkpoint;
use onboard::composition::plan::Plan;
use onboard::process::checkpoints::Inheritance;
use onboard::process::ctl::{Reply, Request, Teleop};
use onboard::symbols::faults::{Fault, FaultTable};
use onboard::symbols::values::LidarStatus;
use rig::belief::Belief;
use rig::folder::Folder;
use rig::stepped::faults::Lateness;
use rig::stepped::{Checkpoints, Devices, Fleet, Start, SteppedDesk, SteppedRobot};
use rig::testbed::{start_pose, world};
use sim::world::{Obstacle, ObstacleId, Pose, Shape, SharedWorld, Truth, World};

use crate::stepped::cores::Core;
use crate::stepped::{shipped, yield_to_programs};

const MILLISECOND_NS: u64 = 1_000_000;
const ROBOT: &str = "amr-1";
/// Faster than this it drives.
const DRIVING_M_S: f64 = 0.12;
/// Slower than this it stands.
const STANDING_M_S: f64 = 0.01;
/// How long it must do either to be believed.
const STEADY_S: f64 = 0.3;
/// The last link of the chain is at rest after this time, whatever happened: the drive's watchdog, then friction.
const SURELY_STANDS_S: f64 = 1.5;
/// A robot that goes on brings its bus up, connects its lidar and sees 2 s of good scans first.
const PATIENCE_S: f64 = 10.0;

/// One robot, its devices and its world.
pub struct Bench {
    robot: SteppedRobot,
    /// Its devices.
    pub devices: Devices,
    /// The world.
    pub world: SharedWorld,
    /// What its files say.
    pub plan: Plan,
    /// What time it is.
    pub now_ns: u64,
    files: Files,
    checkpoints: Checkpoints,
    starts: u64,
    _folder: Folder,
    _core: Core,
}

impl Bench {
    /// It stands at `start` in `map`, and believes to stand `believed_off_m` farther to the right of its lane.
    pub fn new(start: Pose, believed_off_m: f64, things: &[Shape], set: &[&str]) -> Self {
        let Pose {
            x_m,
            y_m,
            theta_rad,
        } = start;
        let y_m = y_m - believed_off_m;
        let place = format!(
            "robots.amr-1.start={{ x_m = {x_m:?}, y_m = {y_m:?}, theta_rad = {theta_rad:?} }}"
        );
        let set = std::iter::once(place.as_str()).chain(set.iter().copied());
        let files = files(set.map(str::to_owned).collect());
        Self::with(&files, Fleet::Alone, |_| start, things)
    }

    /// It stands at `start` in `map`, and may be only in the first of the areas, so many of them.
    pub fn allowed(start: Pose, areas: usize) -> Self {
        let Pose {
            x_m,
            y_m,
            theta_rad,
        } = start;
        let place = format!(
            "robots.amr-1.start={{ x_m = {x_m:?}, y_m = {y_m:?}, theta_rad = {theta_rad:?} }}"
        );
        let mut bench = Self::with(&files(vec![place]), Fleet::Rig, |_| start, &[]);
        bench.allow(areas);
        bench
    }

    /// From now on it may be in the first areas, so many of them.
    pub fn allow(&mut self, areas: usize) {
        let granted: Vec<bool> = (0..self.plan.site.areas.len())
            .map(|area| area < areas)
            .collect();
        self.robot.allow(&granted);
    }

    /// It stands where the site has it start, and was just switched on.
    pub fn standing() -> Self {
        Self::standing_with(&[])
    }

    /// The same with these keys of its files.
    pub fn standing_with(set: &[&str]) -> Self {
        let start = |plan: &Plan| start_pose(&plan.site, ROBOT).expect("the site knows it");
        let set = set.iter().map(|&one| one.to_owned()).collect();
        Self::with(&files(set), Fleet::Alone, start, &[])
    }

    /// It drives, from where the site has it start.
    pub fn driving() -> Self {
        Self::driving_with(&[])
    }

    /// The same with these keys of its files.
    pub fn driving_with(set: &[&str]) -> Self {
        let mut bench = Self::standing_with(set);
        bench.until_driving();
        bench
    }

    fn with(
        files: &Files,
        fleet: Fleet,
        start: impl FnOnce(&Plan) -> Pose,
        things: &[Shape],
    ) -> Self {
        yield_to_programs();
        let core = Core::wait();
        let plan = Plan::load(files).unwrap_or_else(|failure| panic!("{failure:?}"));
        let world = world(&plan.site, &[(&plan.robot, start(&plan))], 1).expect("a world");
        for &thing in things {
            add(&mut world.lock(), thing);
        }
        let now_ns = 1000 * MILLISECOND_NS;
        world.lock().advance_to(now_ns);
        let devices = Devices::new(&world, &plan, now_ns).expect("devices");
        let folder = Folder::in_memory().expect("a folder");
        let checkpoints = Checkpoints::default();
        let start = Start {
            fleet,
            boot_epoch: 1,
            at_ns: now_ns,
            ahead_ns: 0.0,
            checkpoints: checkpoints.clone(),
        };
        let robot = SteppedRobot::new(&plan, files, folder.path(), &devices, start);
        Self {
            robot: robot.unwrap_or_else(|failure| panic!("{failure:?}")),
            devices,
            world,
            plan,
            now_ns,
            files: files.clone(),
            checkpoints,
            starts: 1,
            _folder: folder,
            _core: core,
        }
    }

    /// Tells its process to end, and waits until it has.
    pub fn end(&mut self) {
        self.robot.tell_to_end();
        self.until("it has ended", PATIENCE_S, Self::has_ended);
    }

    /// Starts another process of the robot, which talks with nobody.
    pub fn begin_again(&mut self) {
        self.devices.hang_up();
        self.starts += 1;
        let start = Start {
            fleet: Fleet::Alone,
            boot_epoch: self.starts,
            at_ns: self.now_ns,
            ahead_ns: 0.0,
            checkpoints: self.checkpoints.clone(),
        };
        let folder = Folder::in_memory().expect("a folder");
        let robot = SteppedRobot::new(&self.plan, &self.files, folder.path(), &self.devices, start);
        self.robot = robot.unwrap_or_else(|failure| panic!("{failure:?}"));
        self._folder = folder;
    }

    /// Its computer was switched off while it drove: it does not know where it is, and somebody drives it who sees to that.
    pub fn be_lost_in_hands(&mut self) {
        self.lose_memory();
        self.begin_again();
        self.watch(6.0);
        assert!(self.has(Fault::PlaceUnknown));
        self.ask(Request::Teleop(Teleop {
            without_borders: true,
        }));
        self.until("it is in hands", 1.0, |bench| bench.desk().is_taken());
    }

    /// What its next process would go on from now.
    pub fn kept(&self) -> Option<Box<Checkpoint>> {
        let bytes = self.checkpoints.clone().take().ok()??;
        Checkpoint::from_bytes(&bytes).ok()
    }

    /// Its computer is switched off, while it runs: its next process finds only what is on disk.
    pub fn lose_memory(&self) {
        self.checkpoints.lose_memory();
    }

    /// Its computer's disk is full, or has room again.
    pub fn fill_disk(&self, is_full: bool) {
        self.checkpoints.fill(is_full);
    }

    /// From now on its files have these keys, and an operator has it read them.
    pub fn reload_with(&mut self, set: &[&str]) {
        self.files = files(set.iter().map(|&one| one.to_owned()).collect());
        self.plan = Plan::load(&self.files).unwrap_or_else(|failure| panic!("{failure:?}"));
        self.robot.reload_from(self.files.clone());
        let (reply, _) = self.answer_to(Request::Reload);
        assert!(reply.is_ok(), "{reply:?}");
    }

    /// Somebody carries it to where the site has it start.
    pub fn put_at_its_start(&self) {
        let start = start_pose(&self.plan.site, ROBOT).expect("the site knows it");
        self.world.lock().carry(0, start).expect("nothing is there");
    }

    fn step(&mut self) {
        self.world.lock().advance_to(self.now_ns);
        let (robot, now_ns) = (&mut self.robot, self.now_ns);
        self.devices.step(now_ns, || {
            if !robot.has_ended() {
                robot.step(now_ns);
            }
        });
        self.now_ns += MILLISECOND_NS;
    }

    /// Looks ten times a second until `done` or for `seconds`; returns whether it was done.
    pub fn run(&mut self, seconds: u64, mut done: impl FnMut(&Belief, &World) -> bool) -> bool {
        for step in 0..1000 * seconds {
            self.step();
            if step % 100 == 0 && done(&self.robot.insight().look(), &self.world.lock()) {
                return true;
            }
        }
        false
    }

    /// What an operator asks of it.
    pub fn ask(&mut self, request: Request) {
        self.robot.ask(request);
    }

    /// Who drives it by hand.
    pub fn desk(&mut self) -> &mut SteppedDesk {
        self.robot.desk()
    }

    /// From now on these of its threads do not run.
    pub fn hang(&mut self, threads: &[&str]) {
        self.robot.hang(threads);
    }

    /// Its computer sleeps for so long, and is awake again.
    pub fn sleep(&mut self, seconds: f64) {
        self.robot.sleep(true);
        self.watch(seconds);
        self.robot.sleep(false);
    }

    /// This of its threads panics.
    pub fn panic(&mut self, thread: &str) {
        self.robot.panic(thread);
    }

    /// Whether its process has ended: after a panic, or because it was told to.
    pub fn has_ended(&mut self) -> bool {
        self.robot.has_ended()
    }

    /// From now on this share of a thread's wake-ups is late, by this time at most.
    pub fn be_late(&mut self, thread: &str, share: f64, by_ms: u64) {
        self.robot.be_late(vec![Lateness {
            share,
            by_ns: by_ms * MILLISECOND_NS,
            thread: Some(thread.to_owned()),
        }]);
    }

    /// What operators were refused.
    pub fn refused(&self) -> Vec<String> {
        self.robot.refused()
    }

    /// What operators were answered, with the name of the request.
    pub fn replies(&self) -> Vec<(&'static str, Reply)> {
        self.robot.replies()
    }

    /// An operator waits for an answer.
    pub fn owes_an_answer(&self) -> bool {
        self.robot.owes_an_answer()
    }

    /// Asks, and waits for the answer; returns it, and after how many seconds it came.
    pub fn answer_to(&mut self, request: Request) -> (Reply, f64) {
        let (name, before) = (request.name(), self.replies().len());
        let asked_ns = self.now_ns;
        self.ask(request);
        self.until("an answer", PATIENCE_S, |bench| {
            bench.replies().len() > before
        });
        let (answered, reply) = self.replies().swap_remove(before);
        assert_eq!(answered, name);
        (reply, (self.now_ns - asked_ns) as f64 / 1e9)
    }

    /// What the robot believes.
    pub fn belief(&mut self) -> Belief {
        self.robot.insight().look()
    }

    /// What the robot says of its faults.
    pub fn faults(&mut self) -> FaultTable {
        self.robot.insight().faults()
    }

    /// When the robot says that its newest scan's first beam was measured.
    pub fn scan_stamp_ns(&mut self) -> u64 {
        self.robot.insight().scan_stamp_ns()
    }

    /// What the robot says of its lidar.
    pub fn lidar(&mut self) -> LidarStatus {
        self.robot.insight().lidar()
    }

    /// Whether this fault is present.
    pub fn has(&mut self, fault: Fault) -> bool {
        self.faults().state(fault).active != 0
    }

    /// How often this fault was raised.
    pub fn raised(&mut self, fault: Fault) -> u64 {
        self.faults().state(fault).count
    }

    /// What is true now.
    pub fn truth(&self) -> Truth {
        self.world.lock().truth(0).expect("a robot")
    }

    /// A place ahead of where `base_link` is truly.
    pub fn ahead(&self, forward_m: f64) -> Pose {
        let pose = self.truth().pose;
        let (sin, cos) = pose.theta_rad.sin_cos();
        Pose::new(
            pose.x_m + cos * forward_m,
            pose.y_m + sin * forward_m,
            pose.theta_rad,
        )
    }

    /// Puts something into the world.
    pub fn add(&self, shape: Shape) -> ObstacleId {
        add(&mut self.world.lock(), shape)
    }

    /// Lets time pass; returns what was true in each millisecond.
    pub fn watch(&mut self, seconds: f64) -> Vec<Truth> {
        let steps = (seconds * 1e3) as usize;
        let mut seen = Vec::with_capacity(steps);
        for _ in 0..steps {
            self.step();
            seen.push(self.truth());
        }
        seen
    }

    /// Lets time pass until something holds.
    pub fn until(&mut self, what: &str, patience_s: f64, mut holds: impl FnMut(&mut Self) -> bool) {
        let began_ns = self.now_ns;
        while !holds(self) {
            let waited_s = (self.now_ns - began_ns) as f64 / 1e9;
            assert!(
                waited_s < patience_s,
                "not within {patience_s} s: {what}; {:?}, {:?}",
                self.faults().active().collect::<Vec<Fault>>(),
                self.truth()
            );
            self.step();
        }
    }

    /// Waits until this fault is present.
    pub fn until_raised(&mut self, fault: Fault, patience_s: f64) {
        self.until(fault.name(), patience_s, |bench| bench.has(fault));
    }

    /// Waits until it drives steadily.
    pub fn until_driving(&mut self) {
        self.until_steadily("it drives", PATIENCE_S, |v_m_s| v_m_s > DRIVING_M_S);
    }

    /// Waits until it stands, which must be the case within a time from now on.
    pub fn until_standing(&mut self, within_s: f64) {
        self.until_steadily("it stands", within_s + STEADY_S, |v_m_s| {
            v_m_s.abs() < STANDING_M_S
        });
    }

    fn until_steadily(&mut self, what: &str, patience_s: f64, holds: impl Fn(f64) -> bool) {
        let mut since_ns = self.now_ns;
        self.until(what, patience_s, |bench| {
            if !holds(bench.truth().twist.v_m_s) {
                since_ns = bench.now_ns;
            }
            (bench.now_ns - since_ns) as f64 / 1e9 > STEADY_S
        });
    }

    /// Lets time pass in which it must stand.
    pub fn stands_for(&mut self, seconds: f64) {
        let before = self.truth();
        self.watch(seconds);
        let way_m = self.truth().distance_m - before.distance_m;
        assert!(way_m < 0.001, "moved {way_m:.4} m in {seconds} s");
    }

    /// Lets time pass in which it must drive all the time.
    pub fn drives_for(&mut self, seconds: f64) {
        for truth in self.watch(seconds) {
            assert!(truth.twist.v_m_s > DRIVING_M_S, "slowed down: {truth:?}");
        }
    }

    /// It stops by what `happens`, and in time: `delay_s` later the command was invalid and that was noticed, and from then
    /// on the true speed has been under `v0 - a_stop * t`, with a tenth of tolerance.
    pub fn is_stopped(&mut self, delay_s: f64, happens: impl FnOnce(&Self)) {
        const SLACK_S: f64 = 0.05;
        const FLOOR_M_S: f64 = 0.02;
        let start_ns = self.now_ns;
        happens(self);
        let deceleration_m_s2 = 0.9 * self.plan.robot.drive.limits.stop_deceleration_m_s2;
        let mut start_m_s: f64 = 0.0;
        for truth in self.watch(SURELY_STANDS_S) {
            let after_s = truth.time_ns.saturating_sub(start_ns) as f64 / 1e9;
            let speed_m_s = truth.twist.v_m_s.abs();
            if after_s <= delay_s {
                // It may have been accelerating until then.
                start_m_s = start_m_s.max(speed_m_s);
                continue;
            }
            let limit_m_s =
                start_m_s * 1.1 - deceleration_m_s2 * (after_s - delay_s - SLACK_S).max(0.0);
            assert!(
                speed_m_s < limit_m_s.max(FLOOR_M_S),
                "unsafe: {speed_m_s:.3} m/s, expected at most {limit_m_s:.3}, {after_s:.3} s after the fault"
            );
        }
        self.stands_for(STEADY_S);
    }

    /// The end of a good day: it never hit anything.
    pub fn finish(self) {
        let truth = self.truth();
        assert_eq!(truth.collisions, 0, "{truth:?}");
    }
}

fn files(set: Vec<String>) -> Files {
    Files {
        robot: shipped("robots/amr-1.toml"),
        site: shipped("sites/corridor.toml"),
        set,
    }
}

fn add(world: &mut World, shape: Shape) -> ObstacleId {
    world.add_obstacle(Obstacle::fixed(shape)).expect("added")
}
