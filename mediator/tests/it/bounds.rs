//! One lie with a number just below its bound leaves room for the honest ones that follow, also after a restart.

use contract::client::{Client, Situation};
use contract::timing::{ENTERS_NO_MORE_NS, SILENT_AFTER_NS};
use contract::wire::{Access, Level, RobotReport};
use mediator::journal::Stored;
use mediator::manager::Manager;

use crate::takeover::{AREA, NOW_NS, gives_back_what_is_closed, robot, start, talk, talks_on};

type Robots = Vec<(Client, Situation)>;

fn robots() -> Robots {
    ["amr-1", "amr-2", "amr-3"].map(|id| robot(id, &[])).into()
}

/// All robots and the mediator talk for some rounds, and the first one lies in each report.
fn lie(
    manager: &mut Manager,
    robots: &mut [(Client, Situation)],
    now_ns: u64,
    lie: impl Fn(&mut RobotReport),
) {
    for _ in 0..4 {
        for (number, (client, situation)) in robots.iter_mut().enumerate() {
            client.step(situation.clone(), now_ns, SILENT_AFTER_NS);
            let mut report = client.report();
            if number == 0 {
                lie(&mut report);
            }
            manager.report(&report, now_ns);
        }
        manager.tick(now_ns);
        while let Some(message) = manager.next_message(now_ns) {
            for (client, _) in robots.iter_mut() {
                client.receive(&message, now_ns);
            }
        }
    }
}

fn says(run: u32, (path, progress): (u32, u32), fence: u64) -> impl Fn(&mut RobotReport) {
    move |report| {
        let level = Level {
            run,
            path,
            progress,
            ..Level::default()
        };
        report.access = vec![Access {
            area: AREA.to_owned(),
            level: Some(level),
            fence,
        }];
    }
}

const GRANTED: (u32, u32) = (0, 2);
const ENTERED: (u32, u32) = (0, 3);
const RETURNED: (u32, u32) = (1, 3);
/// Of a revocation.
const KEPT: (u32, u32) = (1, 2);

/// The robot drives into the gate, and out of it again.
fn drives_through(manager: &mut Manager, robots: &mut Robots, own: usize, now_ns: u64, what: &str) {
    robots[own].1.wanted = vec![AREA.to_owned()];
    let status = talk(manager, robots, now_ns);
    assert!(robots[own].0.holds(AREA), "{what}: {status:?}");
    robots[own].1.stands_in = vec![AREA.to_owned()];
    talk(manager, robots, now_ns);
    (robots[own].1.stands_in, robots[own].1.wanted) = (Vec::new(), Vec::new());
    let status = talk(manager, robots, now_ns);
    let area = &status.areas[0];
    assert!(area.holders.is_empty(), "{what}: {area:?}");
}

fn restart(manager: &mut Manager, stored: &mut Stored) {
    manager.entries().for_each(|entry| stored.apply(entry));
    *manager = start(stored, manager.instance() + 1, 0);
}

#[test]
fn a_made_up_fence_leaves_room_for_grants() {
    for fence in [(1 << 61) - 1, (1 << 62) - 2, (1 << 62) - 1] {
        let what = format!("fence {fence}");
        let mut stored = Stored::new(1);
        let mut manager = start(&stored, 50, 0);
        let mut robots = robots();
        lie(&mut manager, &mut robots, NOW_NS, says(0, GRANTED, fence));
        lie(&mut manager, &mut robots, NOW_NS, says(0, RETURNED, fence));
        for _ in 0..3 {
            drives_through(&mut manager, &mut robots, 1, NOW_NS, &what);
            restart(&mut manager, &mut stored);
        }
    }
}

/// The liar says that it has it from another mediator, which is gone.
#[test]
fn a_made_up_fence_of_another_mediator_leaves_room_for_grants() {
    for fence in [(1 << 61) - 1, (1 << 62) - 1] {
        let what = format!("fence {fence}");
        let mut robots = robots();
        talk(&mut start(&Stored::new(2), 40, 0), &mut robots, NOW_NS);
        let mut stored = Stored::new(1);
        let mut manager = start(&stored, 50, NOW_NS);
        for seconds in [2, 7] {
            let now_ns = NOW_NS + seconds * SILENT_AFTER_NS;
            lie(&mut manager, &mut robots, now_ns, says(0, GRANTED, fence));
        }
        let now_ns = NOW_NS + 3 * ENTERS_NO_MORE_NS;
        lie(&mut manager, &mut robots, now_ns, says(0, GRANTED, fence));
        lie(&mut manager, &mut robots, now_ns, says(0, RETURNED, fence));
        for _ in 0..3 {
            drives_through(&mut manager, &mut robots, 1, now_ns, &what);
            restart(&mut manager, &mut stored);
        }
    }
}

/// Of the area of its own identity: the next process is honest.
#[test]
fn a_made_up_run_leaves_room_for_those_of_the_next_process() {
    for run in [(1 << 30) - 1, (1 << 31) - 2, (1 << 31) - 1] {
        for (first, reached) in [(true, GRANTED), (true, ENTERED), (false, ENTERED)] {
            let what = format!("run {run}, {reached:?}, {first}");
            let mut stored = Stored::new(1);
            let mut manager = start(&stored, 50, 0);
            let mut robots = robots();
            if !first {
                talk(&mut manager, &mut robots, NOW_NS);
            }
            lie(&mut manager, &mut robots, NOW_NS, says(run, reached, 1));
            robots[0].0 = Client::new("amr-1", "hall", 8);
            let mut now_ns = NOW_NS;
            for _ in 0..30 {
                now_ns += SILENT_AFTER_NS / 2;
                talk(&mut manager, &mut robots, now_ns);
            }
            for _ in 0..3 {
                drives_through(&mut manager, &mut robots, 0, now_ns, &what);
                restart(&mut manager, &mut stored);
            }
        }
    }
}

/// Of the array by which grants are asked back.
#[test]
fn a_made_up_run_of_a_revocation_leaves_room_for_others() {
    for run in [(1 << 30) - 1, (1 << 31) - 1] {
        let mut manager = start(&Stored::new(1), 50, 0);
        let mut robots = robots();
        lie(&mut manager, &mut robots, NOW_NS, |report| {
            says(run, KEPT, 9)(report);
            std::mem::swap(&mut report.access, &mut report.revocations);
        });
        robots[0].0 = Client::new("amr-1", "hall", 8);
        let mut now_ns = NOW_NS;
        for _ in 0..30 {
            now_ns += SILENT_AFTER_NS / 2;
            talk(&mut manager, &mut robots, now_ns);
        }
        for _ in 0..3 {
            let what = format!("run {run}");
            gives_back_what_is_closed(&mut manager, &mut robots, 0, now_ns, &what);
        }
    }
}

/// Of the newest message that it has heard.
#[test]
fn a_made_up_number_of_a_message_leaves_room_for_others() {
    for sequence in [(1 << 61) - 3, 1 << 61, (1 << 61) + 1] {
        let mut manager = start(&Stored::new(1), 50, 0);
        let mut robots = robots();
        talk(&mut manager, &mut robots, NOW_NS);
        lie(&mut manager, &mut robots, NOW_NS, |report| {
            report.mediator_sequence = sequence;
        });
        let mut now_ns = NOW_NS;
        talks_on(&mut manager, &mut robots, &mut now_ns);
        let epoch = manager.epoch();
        talks_on(&mut manager, &mut robots, &mut now_ns);
        let what = format!("message {sequence}");
        assert_eq!(manager.epoch(), epoch, "{what}");
        drives_through(&mut manager, &mut robots, 0, now_ns, &what);
    }
}

/// Of a report that counts: the robot goes on from there, and what is started next knows nothing of it.
#[test]
fn a_made_up_number_of_a_report_leaves_room_after_a_restart_and_with_another_mediator() {
    for sequence in [(1 << 61) - 3, 1 << 61] {
        let what = format!("report {sequence}");
        let mut stored = Stored::new(1);
        let mut manager = start(&stored, 50, 0);
        let mut robots = robots();
        talk(&mut manager, &mut robots, NOW_NS);
        lie(&mut manager, &mut robots, NOW_NS, |report| {
            report.sequence = sequence;
        });
        let mut now_ns = NOW_NS;
        talks_on(&mut manager, &mut robots, &mut now_ns);
        for _ in 0..2 {
            restart(&mut manager, &mut stored);
            talks_on(&mut manager, &mut robots, &mut now_ns);
            drives_through(&mut manager, &mut robots, 0, now_ns, &what);
        }
        let mut manager = start(&Stored::new(2), 60, now_ns);
        talks_on(&mut manager, &mut robots, &mut now_ns);
        drives_through(&mut manager, &mut robots, 0, now_ns, &what);
    }
}
