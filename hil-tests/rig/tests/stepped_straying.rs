//! On the simulated clock: detours keep to the deviation limit, and a robot that strayed comes back when it is reset.

use onboard::cli::Files;
use onboard::composition::plan::Plan;
use onboard::process::ctl::Request;
use rig::belief::Belief;
use rig::folder::Folder;
use rig::stepped::{Devices, Fleet, Start, SteppedRobot};
use rig::testbed::world;
use sim::world::{Obstacle, Pose, Shape, SharedWorld, World};

const MILLISECOND_NS: u64 = 1_000_000;
const LANE_Y_M: f64 = -0.5;
const LIMIT_M: f64 = 0.30;

/// One robot in the corridor, on the simulated clock.
struct Stage {
    robot: SteppedRobot,
    devices: Devices,
    world: SharedWorld,
    now_ns: u64,
    _folder: Folder,
}

impl Stage {
    /// It stands at `start` in `map`, and believes to stand `believed_off_m` farther to the right of its lane.
    fn new(start: Pose, believed_off_m: f64, things: &[Shape], set: &[&str]) -> Self {
        let shipped = |file: &str| {
            let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config");
            format!("{config}/{file}").into()
        };
        let Pose {
            x_m,
            y_m,
            theta_rad,
        } = start;
        let y_m = y_m - believed_off_m;
        let place = format!(
            "robots.amr-1.start={{ x_m = {x_m:?}, y_m = {y_m:?}, theta_rad = {theta_rad:?} }}"
        );
        let files = Files {
            robot: shipped("robots/amr-1.toml"),
            site: shipped("sites/corridor.toml"),
            set: [place.as_str()]
                .iter()
                .chain(set)
                .map(|&one| one.to_owned())
                .collect(),
        };
        let plan = Plan::load(&files).unwrap_or_else(|failure| panic!("{failure:?}"));
        let world = world(&plan.site, &[(&plan.robot, start)], 1).expect("a world");
        for &thing in things {
            world
                .lock()
                .add_obstacle(Obstacle::fixed(thing))
                .expect("added");
        }
        let now_ns = 1000 * MILLISECOND_NS;
        world.lock().advance_to(now_ns);
        let devices = Devices::new(&world, &plan, now_ns).expect("devices");
        let folder = Folder::new().expect("a folder");
        let start = Start {
            fleet: Fleet::Alone,
            boot_epoch: 1,
            at_ns: now_ns,
        };
        let robot = SteppedRobot::new(&plan, &files, folder.path(), &devices, start);
        Self {
            robot: robot.unwrap_or_else(|failure| panic!("{failure:?}")),
            devices,
            world,
            now_ns,
            _folder: folder,
        }
    }

    /// Looks ten times a second until `done` or for `seconds`; returns whether it was done.
    fn run(&mut self, seconds: u64, mut done: impl FnMut(&Belief, &World) -> bool) -> bool {
        for step in 0..1000 * seconds {
            self.world.lock().advance_to(self.now_ns);
            let (robot, now_ns) = (&mut self.robot, self.now_ns);
            self.devices.step(now_ns, || robot.step(now_ns));
            self.now_ns += MILLISECOND_NS;
            if step % 100 == 0 && done(&self.robot.belief(), &self.world.lock()) {
                return true;
            }
        }
        false
    }

    fn reset(&mut self) {
        self.robot.ask(Request::Reset);
    }
}

fn at(world: &World) -> Pose {
    world.truth(0).expect("a robot").pose
}

fn off_m(world: &World) -> f64 {
    (at(world).y_m - LANE_Y_M).abs()
}

const DETOURS: &str = "tubes.detour_curvature_1_m=4";

#[test]
fn before_a_closed_way_it_stays_within_the_deviation_limit() {
    let wall = Shape::Box {
        pose: Pose::new(5.0, 0.0, 0.0),
        length_m: 0.1,
        width_m: 3.2,
    };
    let mut stage = Stage::new(Pose::new(2.0, LANE_Y_M, 0.0), 0.0, &[wall], &[DETOURS]);
    let mut most_off_m: f64 = 0.0;
    let strayed = stage.run(120, |belief, world| {
        most_off_m = most_off_m.max(off_m(world));
        belief.state.starts_with("halt")
    });
    assert!(!strayed && most_off_m < LIMIT_M, "{most_off_m} m off");
    // It has tried, and stands in the end.
    let truth = stage.world.lock().truth(0).expect("a robot");
    assert!(truth.pose.x_m > 3.5 && truth.collisions == 0, "{truth:?}");
    let before = at(&stage.world.lock());
    assert!(!stage.run(20, |_, world| (at(world).x_m - before.x_m).abs() > 0.01));
}

#[test]
fn a_way_around_that_fits_into_the_limit_is_taken() {
    let thing = Shape::Box {
        pose: Pose::new(4.5, -0.72, 0.0),
        length_m: 0.15,
        width_m: 0.15,
    };
    let mut stage = Stage::new(Pose::new(2.0, LANE_Y_M, 0.0), 0.0, &[thing], &[DETOURS]);
    let mut most_off_m: f64 = 0.0;
    let passed = stage.run(60, |belief, world| {
        most_off_m = most_off_m.max(off_m(world));
        assert!(!belief.state.starts_with("halt"), "strayed");
        at(world).x_m > 5.5
    });
    assert!(
        passed && most_off_m < LIMIT_M,
        "{:?}, {most_off_m} m off",
        at(&stage.world.lock())
    );
}

#[test]
fn a_robot_that_strayed_comes_back_when_it_is_reset() {
    // 0.45 m off its lane, more than it was told, and turned away from it.
    let start = Pose::new(2.5, -0.05, 0.7);
    let mut stage = Stage::new(start, 0.16, &[], &[]);
    assert!(
        stage.run(5, |belief, _| belief.state == "halt-1"),
        "strayed"
    );
    assert!(!stage.run(10, |belief, _| belief.state != "halt-1"));
    stage.reset();
    let mut halted = false;
    let back = stage.run(20, |belief, world| {
        halted |= at(world) != start && belief.state.starts_with("halt");
        off_m(world) < 0.05
    });
    assert!(back && !halted, "{:?}", at(&stage.world.lock()));
    assert!(
        stage.run(20, |belief, _| belief.state == "search-2"),
        "it drives on"
    );
}

#[test]
fn a_strayed_robot_that_cannot_come_back_halts_again() {
    let start = Pose::new(2.5, -0.05, 0.0);
    let across = Shape::Box {
        pose: Pose::new(3.1, -0.05, 0.0),
        length_m: 0.1,
        width_m: 1.0,
    };
    let mut stage = Stage::new(start, 0.16, &[across], &[]);
    assert!(
        stage.run(5, |belief, _| belief.state == "halt-1"),
        "strayed"
    );
    stage.reset();
    assert!(stage.run(2, |belief, _| belief.state == "drive-1"), "reset");
    assert!(
        !stage.run(10, |belief, _| belief.state != "drive-1"),
        "it waits"
    );
    assert!(
        stage.run(25, |belief, _| belief.state == "halt-1"),
        "not for ever"
    );
}
