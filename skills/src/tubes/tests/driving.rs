//! Driving among things: whatever is wanted, nothing is touched.

use super::stand::{parameters, with_detours};
use super::world::{Drive, Random, Robot, SMALL, Thing, corridor, urg};
use crate::tubes::{MotionTubes, StopRules, TubeSet, Verdict};
use description::geometry::{MotionCommand, Point2, Pose2};

fn world(random: &mut Random, start: Pose2) -> Vec<Thing> {
    let mut things = corridor();
    while things.len() < 4 + 6 {
        let middle = Point2::new(random.between(0.5, 9.5), random.between(-1.5, 1.5));
        let thing = random.thing(middle, 0.06);
        // Room to start: what stands in its blind flanks was never seen.
        let room = SMALL.grown(0.5);
        if !thing.overlaps(&room, start) {
            things.push(thing);
        }
    }
    things
}

#[test]
fn a_robot_that_wants_anything_touches_nothing() {
    let (set, _) = TubeSet::generate(&parameters(), &SMALL, &urg()).unwrap();
    let (mut stopped, mut shifted, mut slowed, mut distance_m) = (0, 0, 0, 0.0);
    for seed in 0..30 {
        let random = &mut Random(seed);
        let start = Pose2::new(
            random.between(1.0, 9.0),
            random.between(-1.0, 1.0),
            random.between(-3.1, 3.1),
        );
        let things = world(random, start);
        if things.iter().any(|thing| thing.overlaps(&SMALL, start)) {
            continue;
        }
        let tubes = MotionTubes::new(set.clone(), with_detours(), StopRules::default()).unwrap();
        let mut drive = Drive::new(Robot::new(start, urg()), tubes);
        drive.noise_m = 0.005;
        let mut wanted = MotionCommand::new(0.4, 0.0);
        for tick in 0..300 {
            if tick % 15 == 0 {
                wanted = MotionCommand::new(random.between(0.1, 0.5), random.between(-2.5, 2.5));
            }
            let adapted = drive.tick(&things, wanted);
            stopped += usize::from(adapted.verdict == Verdict::Stopped);
            shifted += usize::from(adapted.verdict == Verdict::Shifted);
            slowed += usize::from(adapted.verdict == Verdict::Slowed);
            distance_m += 0.1 * drive.twist.v_m_s;
            if let Some(thing) = things
                .iter()
                .find(|thing| thing.overlaps(&SMALL, drive.robot.pose))
            {
                panic!(
                    "seed {seed}, tick {tick}: {thing:?} is touched at {:?} with {:?}, {adapted:?}",
                    drive.robot.pose, drive.twist
                );
            }
        }
    }
    assert!(distance_m > 20.0, "it drove {distance_m} m only");
    assert!(
        stopped > 100 && shifted > 10 && slowed > 100,
        "{stopped} {shifted} {slowed}"
    );
}
