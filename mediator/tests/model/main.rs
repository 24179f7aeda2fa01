//! Random robots, random faults, a simulated clock: never two owners, and always progress once the faults stop.
//!
//! Robots drive round a ring of areas by the contract's own client. Messages are lost, repeated, delayed by up to two
//! seconds and so reordered; robots and mediator crash at any moment, the mediator also between journal and network. What
//! is judged is where the robots truly are.
//!
//! `MEDIATOR_MODEL_RUNS` and `MEDIATOR_MODEL_SEED` ask for more, or for one again.

mod fleet;
mod random;

use fleet::{Faults, Fleet};
use random::Random;

fn runs() -> u64 {
    number("MEDIATOR_MODEL_RUNS").unwrap_or(300)
}

fn number(name: &str) -> Option<u64> {
    let text = std::env::var(name).ok()?;
    Some(
        text.parse()
            .unwrap_or_else(|_| panic!("{name} must be a number, found `{text}`")),
    )
}

fn seeds() -> Vec<u64> {
    match number("MEDIATOR_MODEL_SEED") {
        Some(seed) => vec![seed],
        None => (0..runs()).collect(),
    }
}

#[test]
fn never_two_owners_and_always_progress_once_faults_stop() {
    let mut moves = 0;
    let mut crashes = 0;
    for seed in seeds() {
        let mut random = Random::new(seed);
        let mut fleet = Fleet::new(&mut random);
        fleet.run(20_000, Faults::All, &mut random, seed);
        crashes += fleet.crashes();
        fleet.recover();
        // Everything in flight arrives, everyone registers again.
        fleet.run(4_000, Faults::None, &mut random, seed);
        let before = fleet.moves();
        fleet.run(10_000, Faults::None, &mut random, seed);
        for (robot, (before, after)) in before.iter().zip(fleet.moves()).enumerate() {
            assert!(
                after > *before,
                "seed {seed}: robot {robot} has not moved in 10 s without faults: {}",
                fleet.explain()
            );
            moves += after;
        }
        fleet.assert_no_violation_was_claimed(seed);
    }
    eprintln!("{} runs, {moves} moves, {crashes} crashes", seeds().len());
}

#[test]
fn without_faults_robots_drive_on_without_waiting_for_long() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let mut fleet = Fleet::new(&mut random);
        fleet.run(20_000, Faults::None, &mut random, seed);
        for (robot, moves) in fleet.moves().into_iter().enumerate() {
            assert!(
                moves >= 5,
                "seed {seed}: robot {robot} moved {moves} times in 20 s"
            );
        }
        fleet.assert_no_violation_was_claimed(seed);
    }
}
