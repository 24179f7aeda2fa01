//! Whether a robot that waits for its operator stands until he has reset it, in whatever process.
//!
//! What it waits for it says itself, which is a promise; whether it keeps it is judged by truth. A robot whose motors were off must wait by
//! truth, whatever it says. One that still brakes has the time that it takes (`braking` has its bounds); once it stands, it stands.

use sim::world::{STANDING_M_S, Truth};

/// It stands, or moves, when it has done so for this long: supervisors say what is over up to so much later.
const STEADY_NS: u64 = 300_000_000;
/// What it has said for this long it has also written down for the process that comes after it.
const KEPT_NS: u64 = 500_000_000;

/// What can be known of a robot that may wait for its operator, while its process runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Waiting {
    /// For what it waits, as it says, or as it must.
    pub fault: Option<&'static str>,
    /// How often operators have asked its process for something.
    pub asked: usize,
    /// One of them has no answer yet.
    pub owes: bool,
}

/// Watches one robot.
#[derive(Clone, Debug, Default)]
pub(super) struct Latched {
    /// For what it waits, and since when.
    fault: Option<(&'static str, u64)>,
    /// Of the process that ran last.
    asked: usize,
    /// The process that has said so last is gone.
    orphaned: bool,
    stands_since_ns: Option<u64>,
    moves_since_ns: Option<u64>,
    /// It has stood.
    has_stood: bool,
}

impl Latched {
    /// Takes in what is true of a robot, and what it waits for; none: no process of it runs. Returns what is wrong.
    pub(super) fn look(&mut self, truth: &Truth, waiting: Option<Waiting>) -> Option<String> {
        let now_ns = truth.time_ns;
        let Some(waiting) = waiting else {
            let kept = |(_, since_ns): &(_, u64)| self.orphaned || now_ns - since_ns >= KEPT_NS;
            *self = Self {
                fault: self.fault.filter(kept),
                orphaned: true,
                has_stood: self.has_stood,
                ..Self::default()
            };
            return None;
        };
        if waiting.owes || waiting.asked != self.asked {
            *self = Self {
                asked: waiting.asked,
                ..Self::default()
            };
            return None;
        }
        // What the next process says is its own.
        self.orphaned &= waiting.fault.is_none();
        let forgotten = self.orphaned;
        let fault = self.fault.map(|(fault, _)| fault);
        if waiting.fault != fault && !forgotten {
            *self = Self {
                fault: waiting.fault.map(|fault| (fault, now_ns)),
                asked: waiting.asked,
                has_stood: self.has_stood && fault.is_some(),
                ..Self::default()
            };
        }
        let (fault, _) = self.fault?;
        let moves = truth.twist.v_m_s.abs() > STANDING_M_S;
        let (since, other) = if moves {
            (&mut self.moves_since_ns, &mut self.stands_since_ns)
        } else {
            (&mut self.stands_since_ns, &mut self.moves_since_ns)
        };
        *other = None;
        let steady = now_ns - *since.get_or_insert(now_ns) >= STEADY_NS;
        self.has_stood |= steady && !moves;
        (steady && moves && (self.has_stood || forgotten)).then(|| {
            let speed_m_s = truth.twist.v_m_s;
            let it = if forgotten {
                "the process before waited"
            } else {
                "it waits"
            };
            format!("{speed_m_s:.3} m/s, expected to stand until it is reset: {it} for its operator with `{fault}`")
        })
    }
}

#[cfg(test)]
mod tests {
    use sim::world::Twist;

    use super::*;

    const STOPPED: Option<Waiting> = waits("operator-stop");
    const NOTHING: Option<Waiting> = Some(Waiting {
        fault: None,
        asked: 0,
        owes: false,
    });
    /// An operator has asked for something, which its process has not answered yet, and has answered.
    const ASKED: [Option<Waiting>; 2] = [asked(true), asked(false)];
    const NO_PROCESS: Option<Waiting> = None;

    const fn waits(fault: &'static str) -> Option<Waiting> {
        Some(Waiting {
            fault: Some(fault),
            asked: 0,
            owes: false,
        })
    }

    const fn asked(owes: bool) -> Option<Waiting> {
        Some(Waiting {
            fault: None,
            asked: 1,
            owes,
        })
    }

    /// Whether something is wrong at the end of these times, each so many tenths of a second with this speed and fault.
    fn is_found(times: &[(u64, f64, Option<Waiting>)]) -> bool {
        let (mut own, mut at_ns, mut found) = (Latched::default(), 0, false);
        for &(tenths, v_m_s, waiting) in times {
            for _ in 0..tenths * 5 {
                at_ns += 20_000_000;
                let truth = Truth {
                    time_ns: at_ns,
                    twist: Twist {
                        v_m_s,
                        ..Twist::default()
                    },
                    ..Truth::default()
                };
                found |= own.look(&truth, waiting).is_some();
            }
        }
        found
    }

    #[test]
    fn a_robot_that_moves_without_the_reset_that_it_waits_for_is_found() {
        let stands = (10, 0.0, STOPPED);
        assert!(is_found(&[(20, 0.3, STOPPED), stands, (5, 0.1, STOPPED)]));
        assert!(is_found(&[stands, (5, -0.1, STOPPED)]), "backwards too");
        let other = waits("drive-returned");
        assert!(is_found(&[stands, (5, 0.1, other)]), "for something else");
        for (times, why) in [
            (
                [stands, (50, 0.0, STOPPED), (50, 0.3, NOTHING)],
                "it was over by itself",
            ),
            ([(9, 0.3, NOTHING), (20, 0.3, STOPPED), stands], "it brakes"),
            (
                [stands, (2, 0.1, STOPPED), (50, 0.3, NOTHING)],
                "it says so late",
            ),
            ([stands, (1, 0.3, STOPPED), stands], "for a moment"),
            (
                [(50, 0.0, NOTHING), (50, 0.3, NOTHING), stands],
                "nothing is latched",
            ),
            ([stands, (1, 0.0, ASKED[0]), (50, 0.3, ASKED[1])], "reset"),
            ([stands, (0, 0.0, None), (50, 0.3, ASKED[1])], "in between"),
        ] {
            assert!(!is_found(&times), "{why}");
        }
    }

    #[test]
    fn so_is_one_whose_next_process_has_forgotten_it() {
        let (stands, dies) = ((10, 0.0, STOPPED), (20, 0.0, NO_PROCESS));
        let goes = (5, 0.3, NOTHING);
        assert!(is_found(&[stands, dies, goes]));
        assert!(is_found(&[(10, 0.3, STOPPED), dies, goes]), "it braked");
        assert!(is_found(&[stands, dies, (30, 0.0, NOTHING), goes]), "later");
        assert!(is_found(&[stands, dies, (1, 0.0, NOTHING), dies, goes]));
        let late = [stands, dies, (5, 0.0, NOTHING), (5, 0.0, STOPPED), goes];
        assert!(!is_found(&late), "it was over by itself");
        for (times, why) in [
            (
                [stands, dies, (1, 0.0, ASKED[0]), (5, 0.3, ASKED[1])],
                "reset",
            ),
            (
                [(10, 0.3, NOTHING), (3, 0.3, STOPPED), dies, goes],
                "it had no time to write it down",
            ),
            ([(10, 0.3, NOTHING), dies, goes, goes], "nothing is latched"),
        ] {
            assert!(!is_found(&times), "{why}");
        }
    }
}
