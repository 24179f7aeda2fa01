//! All runs of a small model: two robots, two areas, a mediator, an operator, and what goes wrong between them.
//!
//! The random model (`tests/it/model`) tries some runs of a large fleet; this one tries every run of a small one, breadth first, so
//! that what it finds comes with a shortest way to it. It is made of the product's own parts, as they are:
//! [`mediator::manager::Manager`] with what its journal holds, and a `contract::client::Client` for each process of a robot.
//!
//! **What is modelled.** Two areas for one robot each, and robots that drive from outside through `a` into `b` and out. Bodies: a
//! robot passes its point of no return before an area only when its client says that it may be in it; from then on its body
//! reaches in at any moment of the next 3.9 s, or stands, also when its process has ended. Clocks: ticks of 0.98 s, a first robot whose
//! clock is 2 % slower than the mediator's, a second one whose clock is 2 % faster, none with the time of another one. In each tick a
//! robot that is within reach reports once, before or after anybody else does anything. Faults: a report or an answer is lost, late
//! or comes twice, also past later ones; a robot is cut off for any time; its process ends, and starts again at any time or
//! never; the mediator starts again with its journal, with one that has lost the last write, or with an empty one; a second
//! robot is given the identity of the first; a robot gives up where it was going; a report gives back a grant by the fence of the one
//! before. An operator clears an area that he sees empty, or takes another one for it in which a robot stands that has said so,
//! switches a robot off that is in no area and says that it is absent, or takes one that cannot drive out of its areas; that he does
//! at any moment.
//!
//! **What is judged.** Never two bodies in one area. Fences by which robots enter grow, as long as no journal has lost any. And
//! from one in 256 states, both robots get through both areas within half a minute once nothing goes wrong any more, and people clear
//! what a process before is not known to have left.
//!
//! **Rules taken away.** Each of [`Rule`] is taken away at the border of the product: what it is told, at which time, and what is done
//! with what it answers. Then the search must find the collision, and prints the way to it.
//!
//! **What is not modelled.** Two mediators that live at once; nets and their orders; a second process whose body is in an area (here it
//! begins outside, and enters what it may), intruders and closed areas, and so revocations, which only those bring; a second process
//! together with another fault, but for the longer test and beside a robot that is cut off; priorities; robots that do not know where they are; more than one report of a
//! robot in a tick; messages that overtake more than one other. The random model and the conformance kit have these.
//!
//! **Why no library.** The parties of a state are shared between states, copied when a step touches them, and looked at
//! once; a state's key is what `Debug` prints of them, so that no field can be left out. `stateright` wants to hash whole states, and
//! brings a server of web pages.
//!
//! **How far.** One fault of each kind, one order where an operator matters, 2 to 6 ticks: `assert_safe`'s lines in the tests below. Every
//! rule's collision is found at 3 to 18 steps. An operator ends a grant that was not used after 6 ticks at the earliest: in CI with a robot
//! that is cut off for good, and with one that is when the search begins, where another fault of any kind comes beside the order. An ignored
//! test goes farther: there robots come within reach again, two faults of messages meet, and so do faults of messages and orders, and two
//! faults and an order, or a fault and two, beside a robot that is cut off. CI runs it, in release, where it is told to take its time
//! (`CI_LONG=1 bash .ci/run`).
//!
//! `MEDIATOR_EXHAUSTIVE_TICKS`, `_FAULTS`, `_KINDS` (bits, as in `world.rs`), `_ORDERS` and `_GONE` go elsewhere: `cargo test -p mediator --test exhaustive -- --nocapture`.

mod action;
mod kept;
mod network;
mod office;
mod progress;
mod robot;
mod rules;
mod search;
mod steps;
mod world;

use std::fmt::Write;
use std::time::Instant;

use action::Action;
use rules::Rule;
use search::{Outcome, search};
use world::{
    ALL, AWAY, CUTS, FENCES, Limits, MEDIATOR, MESSAGES, MINDS, PROCESSES, SECOND, TICK_NS, World,
};

/// A grant is given in the first tick at the earliest. When its robot is heard no more, an operator is given the area 5.0 s later: in
/// no search of fewer ticks.
const CLEARED_AFTER: u8 = 6;
/// From one in so many states it is looked whether robots get on.
const LOOKED_AT: u64 = 256;

fn number(name: &str) -> Option<u8> {
    let text = std::env::var(name).ok()?;
    Some(
        text.parse()
            .unwrap_or_else(|_| panic!("{name} must be a number, found `{text}`")),
    )
}

fn tell(limits: Limits, outcome: &Outcome, since: Instant) -> String {
    let Outcome {
        states,
        steps,
        cleared,
        depth,
        found,
    } = outcome;
    let mut text = format!(
        "{limits:?}: {states} states, {steps} steps, {cleared} grants cleared, at most {depth} one after the other, {:.1} s",
        since.elapsed().as_secs_f64()
    );
    if let Some((way, what)) = found {
        write!(text, ": {what}").expect("a string takes everything");
        let mut at_s = 0.0;
        for action in way {
            if *action == Action::Tick {
                at_s += TICK_NS as f64 * 1e-9;
            }
            write!(text, "\n  {at_s:5.2} s  {action}").expect("a string takes everything");
        }
    }
    text
}

fn run(limits: Limits) -> (Outcome, String) {
    let since = Instant::now();
    let every = if limits.without.is_none() {
        LOOKED_AT
    } else {
        u64::MAX
    };
    let outcome = search(World::new(limits), every, &World::stays_stuck);
    let text = tell(limits, &outcome, since);
    eprintln!("{text}");
    (outcome, text)
}

fn assert_safe(all: &[Limits]) {
    for line in all {
        let limits = Limits {
            ticks: number("MEDIATOR_EXHAUSTIVE_TICKS").unwrap_or(line.ticks),
            faults: number("MEDIATOR_EXHAUSTIVE_FAULTS").unwrap_or(line.faults),
            kinds: number("MEDIATOR_EXHAUSTIVE_KINDS").unwrap_or(line.kinds),
            orders: number("MEDIATOR_EXHAUSTIVE_ORDERS").unwrap_or(line.orders),
            gone: number("MEDIATOR_EXHAUSTIVE_GONE").map_or(line.gone, |gone| gone > 0),
            ..*line
        };
        let (outcome, text) = run(limits);
        assert!(outcome.found.is_none(), "{text}");
        let gone = limits.gone || limits.kinds & (AWAY | CUTS) != 0;
        assert!(
            !gone || limits.orders == 0 || limits.ticks < CLEARED_AFTER || outcome.cleared > 0,
            "nothing was cleared: {text}"
        );
        if ["TICKS", "FAULTS", "KINDS", "ORDERS", "GONE"]
            .iter()
            .any(|name| number(&format!("MEDIATOR_EXHAUSTIVE_{name}")).is_some())
        {
            // All lines would be nearly the same.
            return;
        }
    }
}

#[test]
#[ignore = "CI makes these runs"]
fn no_run_leads_two_robots_into_one_area() {
    let of = Limits::new;
    assert_safe(&[
        of(1, AWAY, 1, CLEARED_AFTER),
        of(1, CUTS, 1, 3),
        of(1, PROCESSES, 0, 4),
        of(1, MEDIATOR, 1, 3),
        of(1, MESSAGES | MINDS | FENCES, 0, 3),
        of(1, SECOND, 0, 3),
        of(2, PROCESSES | MEDIATOR, 0, 2),
        of(1, ALL, 1, CLEARED_AFTER).gone(),
    ]);
}

#[test]
#[ignore = "minutes"]
fn nor_does_a_longer_one() {
    let of = Limits::new;
    assert_safe(&[
        of(1, AWAY, 1, 7),
        of(1, CUTS, 1, CLEARED_AFTER),
        of(1, PROCESSES, 0, 7),
        // Long enough for what the product does once a grant of before the start is over.
        of(1, MEDIATOR, 1, 7),
        of(1, ALL, 1, 4),
        of(2, MESSAGES | CUTS, 0, 3),
        of(2, MESSAGES | MEDIATOR, 0, 3),
        of(2, PROCESSES | MEDIATOR, 0, 4),
        of(2, SECOND | CUTS, 0, 4),
        of(2, SECOND | MEDIATOR, 0, 4),
        of(2, ALL, 1, CLEARED_AFTER).gone(),
        // A copy that is switched on once its robot has not been heard for 5 s is its next process, if that was in no area either: `SECURITY.md`
        // assumes that nobody does.
        of(1, ALL & !SECOND, 2, 8).gone(),
    ]);
}

/// Whether the same steps are possible, and end as badly, with all rules.
fn is_held(limits: Limits, way: &[Action]) -> bool {
    let mut world = World::new(Limits {
        without: None,
        ..limits
    });
    for &action in way {
        let mut possible = Vec::new();
        world.actions(&mut possible);
        match world.after(action).filter(|_| possible.contains(&action)) {
            Some(after) => world = after,
            None => return true,
        }
    }
    world.violation().is_none()
}

#[test]
fn without_any_rule_two_robots_meet() {
    for rule in Rule::ALL {
        for limits in rule.searches() {
            let (outcome, text) = run(limits);
            let (way, what) = outcome.found.unwrap_or_else(|| panic!("{rule:?}: {text}"));
            assert!(what.contains("2 robots"), "{text}");
            assert!(is_held(limits, &way), "not by that rule: {text}");
        }
    }
}
