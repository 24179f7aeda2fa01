//! A net with fewer roles than there are robots that come.

use contract::client::{Client, Situation};
use contract::timing::SILENT_AFTER_NS;
use mediator::journal::Stored;
use mediator::manager::Manager;

use crate::sites;

const ROBOTS: usize = 6;
const STEP_NS: u64 = 100_000_000;
/// Steps that a robot stays on the crossing, and away from it.
const STAYS: u64 = 3;

struct Robot {
    client: Client,
    inside: bool,
    next: u64,
    crossings: u32,
}

#[test]
fn a_net_serves_whichever_robots_come() {
    let (setup, plans) = sites::crossing(ROBOTS);
    let mut manager = Manager::with_plans(&setup, plans, &Stored::default(), 0).expect("valid");
    let mut robots: Vec<Robot> = { setup.robots.iter() }
        .map(|robot| Robot {
            client: Client::new(&robot.id, &setup.site, 5).on(setup.floor.clone()),
            inside: false,
            next: 0,
            crossings: 0,
        })
        .collect();
    for step in 0..600 {
        let now_ns = step * STEP_NS;
        for (number, robot) in robots.iter_mut().enumerate() {
            if robot.inside && step >= robot.next {
                (robot.inside, robot.next) = (false, step + STAYS);
                robot.crossings += 1;
            } else if !robot.inside && robot.client.holds("Cr") {
                (robot.inside, robot.next) = (true, step + STAYS);
            }
            let room = format!("room-{number}");
            let wants = robot.inside || step >= robot.next;
            let crossing = |is: bool| is.then(|| "Cr".to_owned());
            let situation = Situation {
                located: true,
                stands_in: [Some(room.clone()), crossing(robot.inside)]
                    .into_iter()
                    .flatten()
                    .collect(),
                wanted: [Some(room), crossing(wants)]
                    .into_iter()
                    .flatten()
                    .collect(),
                ..Situation::default()
            };
            robot.client.step(situation, now_ns, SILENT_AFTER_NS);
            manager.report(&robot.client.report(), now_ns);
        }
        manager.tick(now_ns);
        while let Some(message) = manager.next_message(now_ns) {
            for robot in &mut robots {
                robot.client.receive(&message, now_ns);
            }
        }
        let inside = robots.iter().filter(|robot| robot.inside).count();
        assert!(inside <= 1, "{inside} at step {step}");
    }
    let crossings: Vec<u32> = robots.iter().map(|robot| robot.crossings).collect();
    // All come again and again, and the net lets one in at a time.
    let fewest = crossings.iter().min().copied().unwrap_or(0);
    assert!(fewest >= 5, "{crossings:?}");
    let status = manager.status(600 * STEP_NS);
    assert_eq!(
        status.coordinations.iter().filter(|own| !own.over).count(),
        1
    );
}
