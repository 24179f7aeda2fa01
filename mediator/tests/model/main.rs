//! Random robots, random faults, a simulated clock: never two owners, and always progress once the faults stop.
//!
//! Robots drive by the contract's own client: round a ring of areas with different priorities; through the shipped corridor,
//! where the shipped net lets the emergency robot overtake; in and out of the shipped docking bay, by its net. Messages are lost, repeated, delayed by up to two
//! seconds and so reordered, and replayed much later; reports come with old levels and fences; robots and mediator crash at any
//! moment, the mediator also between journal and network; a power loss takes the last writes of the journal; some orders
//! are never carried out. What is judged is where the robots truly are.
//!
//! `MEDIATOR_MODEL_RUNS` and `MEDIATOR_MODEL_SEED` ask for more, or for one again.

mod fleet;
mod floor;
mod journal;
mod random;
mod robot;
#[path = "../sites/mod.rs"]
mod sites;

use fleet::{Faults, Fleet, Tally};
use floor::Floor;
use random::Random;
use robot::Robot;

fn number(name: &str) -> Option<u64> {
    let text = std::env::var(name).ok()?;
    Some(
        text.parse()
            .unwrap_or_else(|_| panic!("{name} must be a number, found `{text}`")),
    )
}

fn seeds(runs: u64) -> Vec<u64> {
    match number("MEDIATOR_MODEL_SEED") {
        Some(seed) => vec![seed],
        None => (0..number("MEDIATOR_MODEL_RUNS").unwrap_or(runs)).collect(),
    }
}

/// All faults, then none: everyone gets on.
fn survive(
    runs: u64,
    floor: impl Fn(&mut Random) -> (Floor, Vec<Robot>),
    faults: Faults,
    settle_ms: u64,
) -> (usize, Tally) {
    let mut tally = Tally::default();
    let seeds = seeds(runs);
    for &seed in &seeds {
        let mut random = Random::new(seed);
        let mut fleet = Fleet::new(floor(&mut random), seed);
        fleet.run(20_000, faults, &mut random);
        fleet.recover();
        // Everything in flight arrives, everyone registers again, what is stuck is got out of the way.
        fleet.run(settle_ms, Faults::NONE, &mut random);
        let before = fleet.moves();
        let running: Vec<u64> = { fleet.coordinations().into_iter() }
            .filter(|own| !own.over)
            .map(|own| own.number)
            .collect();
        fleet.run(10_000, Faults::NONE, &mut random);
        let before_all = &before;
        for (robot, (before, after)) in before.iter().zip(fleet.moves()).enumerate() {
            // Priority may let one wait for ever, but only while those that go first get on.
            let others = before_all.iter().zip(fleet.moves()).enumerate();
            let passed = others
                .filter(|(other, _)| fleet.priority(*other) > fleet.priority(robot))
                .map(|(_, (before, after))| after - before);
            assert!(
                after > *before || passed.sum::<u64>() > 5,
                "seed {seed}: robot {robot} has not moved in 10 s without faults: {}",
                fleet.explain()
            );
        }
        let mut after = fleet.coordinations();
        after.retain(|own| !own.over && own.net != "docking" && running.contains(&own.number));
        assert!(after.is_empty(), "seed {seed}: {after:#?} have not ended");
        fleet.assert_no_violation_was_claimed();
        tally += fleet.tally();
    }
    eprintln!("{} runs: {tally:?}", seeds.len());
    (seeds.len(), tally)
}

#[test]
fn never_two_owners_and_always_progress_once_faults_stop() {
    let (runs, tally) = survive(400, Floor::ring, Faults::ALL, 4_000);
    let many = runs as u64 / 10;
    assert!(tally.crashes >= many && tally.power_losses >= many && tally.replayed >= many);
}

#[test]
fn coordinations_end_whatever_happens() {
    let (runs, tally) = survive(300, Floor::corridor, Faults::ALL, 20_000);
    let some = runs as u64 / 20;
    // Faults that do not happen prove nothing.
    assert!(
        tally.passed >= some && tally.preempted >= some && tally.yielded + tally.kept >= some,
        "{tally:?}"
    );
}

#[test]
fn a_net_lets_robots_in_one_after_the_other() {
    let (runs, tally) = survive(300, Floor::docking, Faults::ALL, 6_000);
    assert!(tally.moves > 10 * runs as u64, "{tally:?}");
}

#[test]
fn without_faults_robots_drive_on_without_waiting_for_long() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let mut fleet = Fleet::new(Floor::ring(&mut random), seed);
        fleet.run(20_000, Faults::NONE, &mut random);
        for (robot, moves) in fleet.moves().into_iter().enumerate() {
            assert!(
                moves >= 5,
                "seed {seed}: robot {robot} moved {moves} times in 20 s"
            );
        }
        fleet.assert_no_violation_was_claimed();
    }
}

#[test]
fn the_emergency_robot_overtakes() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let mut fleet = Fleet::new(Floor::corridor(&mut random), seed);
        fleet.run(60_000, Faults::NONE, &mut random);
        let tally = fleet.tally();
        assert!(
            tally.passed > 0,
            "seed {seed}: {tally:?} {}",
            fleet.explain()
        );
        assert_eq!(tally.preempted, 0, "seed {seed}: {}", fleet.explain());
        fleet.assert_no_violation_was_claimed();
        let over = fleet.coordinations();
        let whole = over
            .iter()
            .find(|own| own.over && own.situation == "normal-ahead");
        let whole = whole.unwrap_or_else(|| panic!("seed {seed}: none has ended"));
        let order = |name: &str| {
            let at = whole.firings.iter().position(|(fired, _)| fired == name);
            at.unwrap_or_else(|| panic!("seed {seed}: {name} did not fire: {whole:?}"))
        };
        assert!(order("aside") < order("pass") && order("pass") < order("passed"));
        assert!(order("passed") < order("back") && order("back") < order("let-normal-go"));
    }
}
