//! Whether a robot that waits for its operator stands until he has reset it.
//!
//! What it waits for it says itself, which is a promise; whether it keeps it is judged by truth. One that still brakes has the time that
//! it takes (`braking` has its bounds); once it stands, it stands.

use sim::world::{STANDING_M_S, Truth};

/// It stands, or moves, when it has done so for this long: supervisors say what is over up to so much later.
const STEADY_NS: u64 = 300_000_000;

/// Watches one robot.
#[derive(Clone, Debug, Default)]
pub(super) struct Latched {
    /// For what it waits.
    fault: Option<&'static str>,
    stands_since_ns: Option<u64>,
    moves_since_ns: Option<u64>,
    /// It has stood.
    has_stood: bool,
}

impl Latched {
    /// Takes in what is true of a robot, and the fault for which it waits for its operator, if it does. Returns what is wrong.
    pub(super) fn look(&mut self, truth: &Truth, fault: Option<&'static str>) -> Option<String> {
        if self.fault != fault {
            *self = Self {
                fault,
                ..Self::default()
            };
        }
        let fault = fault?;
        let now_ns = truth.time_ns;
        let moves = truth.twist.v_m_s.abs() > STANDING_M_S;
        let (since, other) = if moves {
            (&mut self.moves_since_ns, &mut self.stands_since_ns)
        } else {
            (&mut self.stands_since_ns, &mut self.moves_since_ns)
        };
        *other = None;
        let steady = now_ns - *since.get_or_insert(now_ns) >= STEADY_NS;
        self.has_stood |= steady && !moves;
        (steady && moves && self.has_stood).then(|| {
            let speed_m_s = truth.twist.v_m_s;
            format!("{speed_m_s:.3} m/s, expected to stand until it is reset: it waits for its operator with `{fault}`")
        })
    }
}

#[cfg(test)]
mod tests {
    use sim::world::Twist;

    use super::*;

    const STOPPED: Option<&str> = Some("operator-stop");

    /// Whether something is wrong at the end of these times, each so many tenths of a second with this speed and fault.
    fn is_found(times: &[(u64, f64, Option<&'static str>)]) -> bool {
        let (mut own, mut at_ns, mut found) = (Latched::default(), 0, false);
        for &(tenths, v_m_s, fault) in times {
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
                found |= own.look(&truth, fault).is_some();
            }
        }
        found
    }

    #[test]
    fn a_robot_that_moves_without_the_reset_that_it_waits_for_is_found() {
        let stands = (10, 0.0, STOPPED);
        assert!(is_found(&[(20, 0.3, STOPPED), stands, (5, 0.1, STOPPED)]));
        assert!(is_found(&[stands, (5, -0.1, STOPPED)]), "backwards too");
        for (times, why) in [
            (
                [stands, (50, 0.0, STOPPED), (50, 0.3, None)],
                "it was reset",
            ),
            ([(9, 0.3, None), (20, 0.3, STOPPED), stands], "it brakes"),
            (
                [stands, (2, 0.1, STOPPED), (50, 0.3, None)],
                "it says so late",
            ),
            ([stands, (1, 0.3, STOPPED), stands], "for a moment"),
            (
                [(50, 0.0, None), (50, 0.3, None), stands],
                "nothing is latched",
            ),
        ] {
            assert!(!is_found(&times), "{why}");
        }
    }
}
