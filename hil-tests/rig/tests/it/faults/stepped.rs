//! Faults on the simulated clock: the fleet bears each kind, goes on by itself, and the same seed gives the same run.

use rig::scenario::{Direction, Player, Scenario, ScriptedFault, ScriptedKind};
use rig::stepped::Plans;
use rig::stepped::faults::drawn;
use rig::summary::Summary;
use rig::violation::ViolationKind;

use crate::stepped::{json, plans, without_faults};

fn overtaking() -> Scenario {
    crate::stepped::scenario("overtaking")
}

fn ended(scenario: &Scenario, seed: u64) -> Summary {
    ended_with(scenario, &plans(scenario), seed)
}

fn ended_with(scenario: &Scenario, plans: &Plans, seed: u64) -> Summary {
    crate::stepped::ended(scenario, plans, seed).1
}

fn raised(summary: &Summary, fault: &str) -> bool {
    let mut all = summary.robots.iter().flat_map(|robot| &robot.faults);
    all.any(|(name, _)| name == fault)
}

/// Robots go for less than this by what they have heard.
const LEASE_S: f64 = 5.0;

/// A fault of this kind while the slow robot is on its way into the lay-by.
fn fault(what: ScriptedKind) -> ScriptedFault {
    let keys = what.keys();
    ScriptedFault {
        at_s: 24.0,
        for_s: match what {
            // Longer than robots may go by what they have heard, or until a lidar has frozen three times.
            ScriptedKind::HangMediator | ScriptedKind::FreezeLidar => 8.0,
            // Until a queue is full.
            ScriptedKind::Overload => 20.0,
            _ => 4.0,
        },
        what,
        robot: keys.robot.map(|_| "amr-1".to_owned()),
        share: keys.share.then_some(0.7 * what.most_share()),
        by_s: keys.by_s.then_some(0.5 * what.most_by_s()),
        thread: None,
        pose: None,
        motion: None,
        way: None,
        mediator: None,
    }
}

/// One that hears and is not heard, and one that is heard and does not hear: for longer than leases last, both say so, and nobody is let in
/// where it may go.
#[test]
#[ignore = "CI makes these runs"]
fn a_link_that_carries_one_way_is_no_link() {
    for way in [Direction::ToMediator, Direction::ToRobots] {
        for (robot, at_s) in [("amr-1", 24.0), ("amr-2", 24.0), ("amr-2", 40.0)] {
            let mut scenario = overtaking();
            scenario.faults = vec![ScriptedFault {
                at_s,
                for_s: 20.0,
                robot: Some(robot.to_owned()),
                way: Some(way),
                ..fault(ScriptedKind::Partition)
            }];
            let summary = ended(&scenario, 3);
            assert!(summary.passed(), "{way:?} {robot}: {summary:?}");
            let own = summary.robots.iter().find(|own| own.id == robot);
            let mut faults = own.iter().flat_map(|own| &own.faults);
            let says = faults.any(|(name, _)| name == "mediator-silent");
            assert!(says, "{way:?} {robot}: {own:?}");
        }
    }
}

#[test]
#[ignore = "CI makes these runs"]
fn the_fleet_bears_what_goes_wrong_with_messages_and_processes() {
    goes_on(&overtaking(), |kind| {
        kind.needs_mediator() || PROCESSES.contains(&kind)
    });
}

/// What goes wrong with devices, wheels and people: whole fleets meet it in campaigns.
#[test]
#[ignore = "CI makes these runs"]
fn a_robot_bears_everything_else() {
    goes_on(&crate::stepped::scenario("lap").with_at_most(1), |kind| {
        !kind.needs_mediator() && !PROCESSES.contains(&kind)
    });
}

const PROCESSES: [ScriptedKind; 9] = [
    ScriptedKind::FillDisk,
    ScriptedKind::Overload,
    ScriptedKind::KillRobot,
    ScriptedKind::EndRobot,
    ScriptedKind::Panic,
    ScriptedKind::Reload,
    ScriptedKind::Hang,
    ScriptedKind::LateThreads,
    ScriptedKind::Drift,
];

/// These change nothing of this run: nothing is there to be reset, who says where the robot is
/// says the truth, and motors with power hold it on any slope and with any load.
const UNNOTICED: [ScriptedKind; 4] = [
    ScriptedKind::Reset,
    ScriptedKind::Place,
    ScriptedKind::Slope,
    ScriptedKind::Load,
];

/// Each of these kinds alone, while the first robot is on its way, in a fleet into the lay-by: all come through, and not as without it.
fn goes_on(scenario: &Scenario, concerns: impl Fn(ScriptedKind) -> bool) {
    let without = without_faults(scenario, 3);
    let starts_without = without.mediator.as_ref().map(|own| own.starts);
    let without = json(&without);
    let kinds = ScriptedKind::DRAWN.into_iter().chain(ScriptedKind::BORNE);
    let plans = plans(scenario);
    for what in kinds.filter(|kind| concerns(*kind)) {
        let mut scenario = scenario.clone();
        scenario.faults = vec![fault(what)];
        let summary = ended_with(&scenario, &plans, 3);
        assert!(summary.passed(), "{what:?}: {summary:?}");
        let noticed = json(&summary) != without;
        assert_ne!(noticed, UNNOTICED.contains(&what), "{what:?}");
        let expected = match what {
            ScriptedKind::Partition
            | ScriptedKind::DeadLink
            | ScriptedKind::KillMediator
            | ScriptedKind::RebootMediator
            | ScriptedKind::HangMediator
            | ScriptedKind::FullDisk => Some("mediator-silent"),
            ScriptedKind::LoseNetwork => Some("fleet-network"),
            ScriptedKind::FillDisk => Some("note-unwritten"),
            ScriptedKind::FreezeLidar => Some("lidar-frozen"),
            ScriptedKind::Overload => Some("queue-full"),
            ScriptedKind::Stop => Some("operator-stop"),
            ScriptedKind::Hang => Some("setpoint-stale"),
            ScriptedKind::Panic => Some("panic"),
            ScriptedKind::RebootRobot | ScriptedKind::Sleep => Some("place-unknown"),
            ScriptedKind::LeaveOp | ScriptedKind::CutPower | ScriptedKind::LoseInterface => {
                Some("bus-lost")
            }
            ScriptedKind::CutMotors => Some("motors-off"),
            ScriptedKind::LowVoltage => Some("bus-voltage"),
            ScriptedKind::HotMotor => Some("drive-fault"),
            ScriptedKind::FreezeSensors => Some("drive-stalled"),
            ScriptedKind::StickEncoder => Some("encoder-broken"),
            ScriptedKind::ReverseMotor => Some("wheels-disobey"),
            ScriptedKind::BreakScans => Some("scan-broken"),
            ScriptedKind::CoverLidar => Some("lidar-blind"),
            ScriptedKind::Unplug | ScriptedKind::FreezeScans => Some("lidar-lost"),
            _ => None,
        };
        if let Some(expected) = expected {
            assert!(raised(&summary, expected), "{what:?}: {summary:?}");
        }
        let lost_frames = summary.robots[0].ethercat.lost_frames;
        let loses = [ScriptedKind::LoseFrames, ScriptedKind::RefuseFrames].contains(&what);
        assert_eq!(lost_frames > 100, loses, "{what:?}: {lost_frames}");
        let kills = [ScriptedKind::KillMediator, ScriptedKind::RebootMediator];
        let killed = u32::from(kills.contains(&what));
        let starts = summary.mediator.map(|own| own.starts);
        let expected = starts_without.map(|starts| starts + killed);
        assert_eq!(starts, expected, "{what:?}");
    }
}

#[test]
fn drawn_faults_are_the_same_for_the_same_seed_and_fit_the_scenario() {
    let scenario = overtaking();
    let known: Vec<_> = scenario.robots.iter().map(Player::threads).collect();
    let mut seen = Vec::new();
    let (mut long, mut slow, mut of_mediator, mut stale) = (0, 0, 0, 0);
    let mut split = 0;
    let mut threads = Vec::new();
    for seed in 0..400 {
        let faults = drawn(&scenario, seed);
        assert_eq!(faults, drawn(&scenario, seed));
        // A split belongs to a second mediator.
        let (splits, others): (Vec<_>, Vec<_>) =
            { faults.iter() }.partition(|fault| fault.mediator.is_some());
        assert!(!others.is_empty() && others.len() <= 6);
        split += usize::from(!splits.is_empty());
        for fault in faults {
            assert_eq!(fault.complaints(&known), Vec::<String>::new(), "{fault}");
            assert!((0.0..=90.0).contains(&fault.at_s) && fault.for_s <= 120.0);
            long += u32::from(fault.for_s > 30.0);
            slow += u32::from(fault.share.is_some_and(|share| share < 0.0));
            let delays = fault.what == ScriptedKind::Delay;
            stale += u32::from(delays && fault.by_s > Some(LEASE_S));
            let clock = fault.what == ScriptedKind::Drift;
            of_mediator += u32::from(clock && fault.robot.is_none());
            threads.extend(fault.thread.clone().map(|thread| (fault.what, thread)));
            if !seen.contains(&fault.what) {
                seen.push(fault.what);
            }
        }
    }
    // Without a robot that is carried away for good no fleet comes to its goals.
    assert!(!seen.contains(&ScriptedKind::Absent));
    let expected = ScriptedKind::all().count() - 1;
    assert_eq!(seen.len(), expected, "{seen:?}");
    for what in [
        ScriptedKind::Hang,
        ScriptedKind::Panic,
        ScriptedKind::LateThreads,
    ] {
        let own = threads.iter().filter(|(kind, _)| *kind == what);
        let mut names: Vec<_> = own.map(|(_, thread)| thread).collect();
        names.sort_unstable();
        names.dedup();
        assert!(names.len() > 2, "{what:?}: {names:?}");
    }
    // Of about 1,400.
    assert!((40..160).contains(&long), "{long} longer than 30 s");
    assert!(slow > 3 && of_mediator > 3, "{slow}, {of_mediator}");
    assert!(stale > 1, "{stale} delays outlast leases");
    assert!(
        split > 3,
        "{split} networks are split between two mediators"
    );
}

#[test]
fn faults_are_drawn_for_as_long_as_the_scenario_says() {
    let docking = crate::stepped::scenario("docking");
    let begins_s = (0..50)
        .flat_map(|seed| drawn(&docking, seed))
        .map(|own| own.at_s);
    let last_s = begins_s.fold(0.0, f64::max);
    assert_eq!(docking.clone().with_at_most(1).faults_until_s, 100.0);
    assert!(
        last_s > 200.0 && last_s <= docking.faults_until_s,
        "{last_s}"
    );
}

/// A robot's one way and the mediator's the other, which is harder on leases than one alone.
#[test]
#[ignore = "CI makes these runs"]
fn clocks_that_run_slow_or_fast_hinder_nobody() {
    for share in [-0.01, 0.01] {
        let drifts = |robot: Option<&str>, share| ScriptedFault {
            at_s: 5.0,
            for_s: 60.0,
            robot: robot.map(str::to_owned),
            share: Some(share),
            ..fault(ScriptedKind::Drift)
        };
        let mut scenario = overtaking();
        scenario.faults = vec![drifts(Some("amr-1"), share), drifts(None, -share)];
        let summary = ended(&scenario, 3);
        assert!(summary.passed(), "{share}: {summary:?}");
    }
}

#[test]
#[ignore = "CI makes these runs"]
fn late_communication_delays_what_a_robot_says() {
    let mut scenario = overtaking();
    let asked_s = |summary: Summary| -> Vec<f64> {
        assert!(summary.passed(), "{summary:?}");
        let own = summary.areas.iter().flat_map(|area| &area.owners);
        let own = own.filter(|own| own.robot == "amr-1");
        own.filter_map(|own| own.released_s).collect()
    };
    scenario.faults = vec![ScriptedFault {
        at_s: 5.0,
        for_s: 40.0,
        share: Some(1.0),
        by_s: Some(0.5),
        thread: Some("communication".to_owned()),
        ..fault(ScriptedKind::LateThreads)
    }];
    let late = asked_s(ended(&scenario, 3));
    assert_ne!(late, asked_s(without_faults(&overtaking(), 3)));
}

#[test]
#[ignore = "CI makes these runs"]
fn a_robot_whose_communication_hangs_stops_for_it_until_a_reset() {
    let mut scenario = overtaking();
    let without = without_faults(&scenario, 3);
    for robot in &without.robots {
        let cycles = robot.threads["communication"]["cycles"].as_u64();
        assert!(cycles > Some(1000), "{}: {cycles:?} cycles", robot.id);
    }
    assert!(!raised(&without, "thread-hung"), "{without:?}");
    scenario.faults = vec![ScriptedFault {
        thread: Some("communication".to_owned()),
        ..fault(ScriptedKind::Hang)
    }];
    let with = ended(&scenario, 3);
    assert!(with.passed() && raised(&with, "thread-hung"), "{with:?}");
    assert_eq!(with.robots[0].resets, 1, "{with:?}");
}

#[test]
#[ignore = "CI makes these runs"]
fn a_run_with_faults_is_the_same_for_the_same_seed() {
    for seed in [4, 17, 61, 135] {
        let mut scenario = overtaking();
        scenario.faults = drawn(&scenario, seed);
        let one = ended(&scenario, seed);
        assert_eq!(json(&one), json(&ended(&scenario, seed)), "seed {seed}");
        scenario.faults.clear();
        assert_ne!(json(&one), json(&ended(&scenario, seed)), "seed {seed}");
    }
}

#[test]
fn a_robot_that_stays_cut_off_keeps_its_areas_and_the_run_fails() {
    let mut scenario = overtaking();
    scenario.standstill_s = 20.0;
    scenario.faults = vec![ScriptedFault {
        at_s: 30.0,
        for_s: 3000.0,
        ..fault(ScriptedKind::Partition)
    }];
    let summary = ended(&scenario, 3);
    assert!(
        !summary.is_done() && summary.violations.is_empty(),
        "{summary:?}"
    );
}

#[test]
fn a_fleet_that_stays_stuck_after_the_last_fault_is_found() {
    let mut scenario = overtaking();
    scenario.standstill_s = 10.0;
    scenario.faults = vec![ScriptedFault {
        at_s: 2.0,
        for_s: 4.0,
        ..fault(ScriptedKind::Pause)
    }];
    // Nobody grants areas: all stand before their first border.
    let plans = plans(&scenario).without_mediator();
    let stuck = |scenario: &Scenario| {
        let summary = ended_with(scenario, &plans, 3);
        let kinds: Vec<_> = summary.violations.iter().map(|own| own.kind).collect();
        (kinds, summary.duration_s)
    };
    let both = vec![ViolationKind::StuckAfterFaults; 2];
    let (kinds, duration_s) = stuck(&scenario);
    assert_eq!(kinds, both);
    // The fault, the operator's time, and then nobody moves.
    assert!((26.0..26.2).contains(&duration_s), "{duration_s} s");
    // A fault that is never drawn sets no bounds.
    scenario.faults[0].what = ScriptedKind::LoseJournal;
    assert_eq!(stuck(&scenario).0, []);
    scenario.faults.clear();
    assert_eq!(stuck(&scenario).0, []);
}

#[test]
#[ignore = "CI makes these runs"]
fn a_robot_that_drives_and_never_arrives_after_the_last_fault_is_found() {
    let mut scenario = overtaking();
    scenario.patience_s = 100.0;
    scenario.faults = vec![ScriptedFault {
        at_s: 2.0,
        for_s: 4.0,
        ..fault(ScriptedKind::Pause)
    }];
    // Nobody is told to use the lay-by: both drive on, and the first one does not come to its goals.
    let plans = plans(&scenario).without_nets();
    let summary = ended_with(&scenario, &plans, 3);
    let found: Vec<_> = { summary.violations.iter() }
        .map(|own| (own.kind, own.robot.as_str()))
        .collect();
    let expected = [(ViolationKind::StuckAfterFaults, "amr-1")];
    assert_eq!(found, expected, "{summary:?}");
    assert!((116.0..116.2).contains(&summary.duration_s), "{summary:?}");
}
