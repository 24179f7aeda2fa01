//! Whole steps of the shipped nets, as the mediator runs them: with their ports, protocols and bindings,
//! and robots that answer at random. Only the mediator's steps are timed.

use std::time::Instant;

use coordination::analysis::{self, Limits};
use coordination::binding::NetBinding;
use coordination::event::EventTable;
use coordination::petri::{Budget, TransitionId};
use coordination::protocol::{Party, Position, Replica, Side};

use crate::measure::{Effort, quantile};
use crate::random::Random;
use crate::shipped::Shipped;

/// Nets that take their steps one after another, so that a step is long enough to be timed.
const COPIES: usize = 64;

/// Steps of each from its beginning, unless it ends before.
const STEPS: usize = 200;

/// What the mediator allows a step.
const BUDGET: Budget = Budget {
    firings: 32,
    rounds: 4,
};

/// Medians over all steps in which something fires somewhere.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    pub ns_per_step: f64,
    pub tail_ns_per_step: f64,
    pub firings_per_step: f64,
    pub ns_per_firing: f64,
    /// A step that has nothing to do.
    pub ns_per_idle_step: f64,
}

/// A running net, and its robots.
struct Copy {
    net: NetBinding<Replica>,
    robots: Vec<Replica>,
}

pub fn measure(shipped: &Shipped, effort: Effort) -> Steps {
    let mut random = Random::new();
    let (mut all, mut idle) = (Vec::new(), Vec::new());
    let mut batches = 0;
    let begin = Instant::now();
    while effort.wants_more(batches, begin) {
        // Another order in each batch.
        let model = shipped.shuffled(|limit| random.below(limit));
        let proof = analysis::check(&model, &shipped.uses, &Limits::default());
        let proof = proof.unwrap_or_else(|refusal| panic!("{}: {refusal}", shipped.name));
        let net = model
            .compile(&mut EventTable::new())
            .expect("the net is sound");
        let mut copies: Vec<_> = (0..COPIES)
            .map(|_| {
                let sides = shipped.uses.iter().map(|used| {
                    let side = Replica::new(&used.protocol, 0, Party::Second, 0);
                    (used.name.as_str(), side)
                });
                let robots = shipped.uses.iter();
                Copy {
                    net: NetBinding::new(&proof, &net, sides).expect("the proof is of this net"),
                    robots: { robots.map(|used| Replica::new(&used.protocol, 0, Party::First, 0)) }
                        .collect(),
                }
            })
            .collect();
        for _ in 0..STEPS {
            for copy in &mut copies {
                copy.robots_answer(&mut random);
            }
            let (ns, fired) = step_all(&mut copies);
            if fired == 0 {
                break;
            }
            let copies_count = COPIES as f64;
            all.push((ns / copies_count, f64::from(fired) / copies_count));
            // What the first step has left is done in this one.
            step_all(&mut copies);
            let (ns, fired) = step_all(&mut copies);
            if fired == 0 {
                idle.push(ns / copies_count);
            }
        }
        batches += 1;
    }
    let of = |of: fn(&(f64, f64)) -> f64| all.iter().map(of).collect();
    let steps: Vec<f64> = of(|&(ns, _)| ns);
    Steps {
        ns_per_step: quantile(steps.clone(), 0.5),
        tail_ns_per_step: quantile(steps, 0.99),
        firings_per_step: quantile(of(|&(_, fired)| fired), 0.5),
        ns_per_firing: quantile(of(|&(ns, fired)| ns / fired), 0.5),
        ns_per_idle_step: quantile(idle, 0.5),
    }
}

/// A step of each; nanoseconds, and how many transitions fired.
fn step_all(copies: &mut [Copy]) -> (f64, u32) {
    let mut fired = 0;
    let start = Instant::now();
    for copy in copies {
        let mut trace = [TransitionId(0); BUDGET.firings as usize];
        let progress = copy.net.step_traced(BUDGET, &mut trace, |_| false);
        fired += progress.evaluation.fired;
    }
    (start.elapsed().as_nanos() as f64, fired)
}

impl Copy {
    /// Levels go both ways, and half of the robots that may set a flag do so.
    fn robots_answer(&mut self, random: &mut Random) {
        for (robot, side) in self.robots.iter_mut().zip(self.net.sides_mut()) {
            robot.merge(side.level()).expect("it is of this protocol");
            while robot.poll().is_some() {}
            let protocol = robot.protocol();
            let at = protocol.next(robot.read_to()).next();
            let at = at.map_or(Position::START, |_| robot.read_to());
            let next = protocol.next(at).map(|(flag, _)| flag);
            let own: Vec<_> =
                { next.filter(|&flag| protocol.owner(flag) == Some(Party::First)) }.collect();
            if !own.is_empty() && random.below(2) == 0 {
                // It may have to wait until the last flag of the run before has been read.
                let _ = robot.set(own[random.below(own.len())]);
            }
            side.merge(robot.level()).expect("it is of this protocol");
        }
    }
}
