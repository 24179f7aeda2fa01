//! Whether robots brake as they must after a fault.
//!
//! From when a robot's commands are invalid, at speed v0, it must be slower than v0 − a·(t − 50 ms), with a tenth of tolerance,
//! until the fault is over; a is what its file promises: the deceleration of stops, or that without power where nothing can
//! brake. Faults at the same time get into each other's way: then the latest of their stops counts, and the weakest brake; and while one
//! that begins holds the wheels to what they were told last, as a lost bus does until the drive's watchdog trips, t stands still. One that is
//! paused may be driven by hand, and stops again when it is let go.

use crate::scenario::{Player, ScriptedFault, ScriptedKind, Stopping};

/// From when commands are invalid until the robot brakes.
const REACTION_S: f64 = 0.05;
/// Share of tolerance.
const TOLERANCE: f64 = 0.1;
/// Slower than this it stands.
const STANDING_M_S: f64 = 0.02;

/// Watches how one robot brakes.
#[derive(Clone, Debug)]
pub(super) struct Braking {
    stops: Vec<Stop>,
    /// At the last look.
    speed_m_s: f64,
}

/// A time in which the robot must brake and then stand.
#[derive(Clone, Debug)]
struct Stop {
    fault: String,
    from_s: f64,
    until_s: f64,
    deceleration_m_s2: f64,
    /// Begin and length of times in which other faults hold the wheels to what they were told last.
    held_s: Vec<(f64, f64)>,
    /// How fast it was at its begin.
    speed_m_s: Option<f64>,
    /// The fault shows only while the robot drives, and is noticed after it has driven for so long.
    driven_s: Option<f64>,
    /// Nothing is asked of a robot that does not drive at this time.
    lost_driving_s: Option<f64>,
}

impl Stop {
    /// It is asked of nobody who has not driven when the fault began.
    fn is_lost_driving(&mut self, at_s: f64, speed_m_s: f64) {
        if self.lost_driving_s.is_some_and(|lost_s| at_s >= lost_s) {
            self.lost_driving_s = None;
            if speed_m_s < STANDING_M_S {
                self.until_s = self.from_s;
            }
        }
    }

    /// Nobody can notice yet what shows only while it drives.
    fn waits_for_driving(&mut self, at_s: f64, speed_m_s: f64) {
        if let Some(driven_s) = self.driven_s
            && speed_m_s < STANDING_M_S
            && at_s < self.from_s
        {
            self.from_s = self.from_s.max(at_s + driven_s);
        }
    }

    fn limit_m_s(&self, at_s: f64, from_m_s: f64) -> f64 {
        let held_s =
            { self.held_s.iter() }.map(|(from_s, for_s)| (at_s - from_s).clamp(0.0, *for_s));
        let braked_s = (at_s - self.from_s - held_s.sum::<f64>() - REACTION_S).max(0.0);
        let deceleration_m_s2 = self.deceleration_m_s2 * (1.0 - TOLERANCE);
        let limit_m_s = from_m_s * (1.0 + TOLERANCE) - deceleration_m_s2 * braked_s;
        limit_m_s.max(STANDING_M_S)
    }
}

impl Braking {
    /// Of a robot, with the faults of its scenario.
    pub(super) fn new(faults: &[ScriptedFault], player: &Player) -> Self {
        let own: Vec<(&ScriptedFault, Stopping)> = { faults.iter() }
            .filter(|fault| fault.robot.as_ref() == Some(&player.id))
            .map(|fault| (fault, fault.stopping(&player.config)))
            .collect();
        let by_hand = |fault: &&ScriptedFault| fault.what == ScriptedKind::Teleop;
        let stops = |(fault, stopping): &(&ScriptedFault, Stopping)| {
            let mut from_s = fault.at_s + stopping.after_s?;
            let mut until_s = fault.until_s();
            let (mut deceleration_m_s2, mut pull_m_s2) =
                (stopping.deceleration_m_s2, stopping.pull_m_s2);
            let mut held_s = Vec::new();
            for (other, theirs) in &own {
                let meets = other.at_s <= fault.until_s() && theirs.until_s >= fault.at_s;
                if std::ptr::eq(*other, *fault) || !meets {
                    continue;
                }
                // Nobody is asked to brake who is carried away.
                let carried = other.what == ScriptedKind::Absent;
                if carried || stopping.lost_driving && other.ends_process() {
                    until_s = until_s.min(other.at_s);
                }
                deceleration_m_s2 = deceleration_m_s2.min(theirs.deceleration_m_s2);
                pull_m_s2 += theirs.pull_m_s2;
                if other.at_s <= from_s {
                    if theirs.disables {
                        from_s = from_s.max(theirs.until_s + stopping.after_s?);
                    }
                    from_s += theirs.delays_s;
                } else {
                    held_s.push((other.at_s, theirs.holds_s));
                }
            }
            // Motors with power brake as told on any floor.
            if deceleration_m_s2 <= player.config.drive.unpowered_deceleration_m_s2 {
                deceleration_m_s2 = (deceleration_m_s2 - pull_m_s2).max(0.0);
            }
            let stop = |from_s, until_s| Stop {
                fault: fault.what.name(),
                from_s,
                until_s: f64::min(until_s, from_s + stopping.stops_for_s),
                deceleration_m_s2,
                held_s: held_s.clone(),
                speed_m_s: None,
                driven_s: stopping.after_s.filter(|_| stopping.shows_driving),
                lost_driving_s: stopping.lost_driving.then_some(fault.at_s),
            };
            let mut stops = Vec::new();
            if fault.what == ScriptedKind::Pause {
                for hands in own.iter().map(|(other, _)| *other).filter(by_hand) {
                    stops.push(stop(from_s, hands.at_s.min(until_s)));
                    from_s = from_s.max(hands.until_s() + stopping.after_s?);
                }
            }
            stops.push(stop(from_s, until_s));
            stops.retain(|stop| stop.from_s < stop.until_s);
            Some(stops)
        };
        Self {
            stops: own.iter().filter_map(stops).flatten().collect(),
            speed_m_s: 0.0,
        }
    }

    /// Takes in how fast the robot truly is. Returns what is wrong.
    pub(super) fn look(&mut self, at_s: f64, speed_m_s: f64) -> Option<String> {
        let before_m_s = std::mem::replace(&mut self.speed_m_s, speed_m_s);
        for stop in &mut self.stops {
            stop.waits_for_driving(at_s, speed_m_s);
            stop.is_lost_driving(at_s, before_m_s);
        }
        let lasting = { self.stops.iter_mut() }
            .filter(|stop| (stop.from_s..stop.until_s).contains(&at_s))
            .map(|stop| {
                let from_m_s = *stop.speed_m_s.get_or_insert(before_m_s.max(speed_m_s));
                (stop.limit_m_s(at_s, from_m_s), &*stop)
            });
        let (limit_m_s, stop) = lasting.max_by(|one, other| one.0.total_cmp(&other.0))?;
        (speed_m_s > limit_m_s).then(|| {
            format!(
                "{speed_m_s:.3} m/s, expected at most {limit_m_s:.3}: {:.3} s after it must brake for `{}`",
                at_s - stop.from_s,
                stop.fault
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    /// Limits of amr-1: it brakes with 2 m/s², and without power with 1.5.
    fn braking(faults: &[&str]) -> Braking {
        let faults: Vec<ScriptedFault> = { faults.iter() }
            .map(|fault| toml::from_str(&fault.replace(", ", "\n")).expect("a fault"))
            .collect();
        Braking::new(&faults, &testing::scenario("lap").robots[0])
    }

    fn windows(braking: &Braking) -> Vec<(f64, f64, f64)> {
        let ms = |time_s: f64| (time_s * 1e3).round() / 1e3;
        { braking.stops.iter() }
            .map(|own| (ms(own.from_s), ms(own.until_s), own.deceleration_m_s2))
            .collect()
    }

    const UNPLUG: &str = "at_s = 10.0, for_s = 5.0, what = \"unplug\", robot = \"amr-1\"";

    #[test]
    fn a_robot_brakes_from_when_its_commands_are_invalid_until_the_fault_is_over() {
        let mut own = braking(&[UNPLUG]);
        assert_eq!(windows(&own), [(10.3, 15.0, 2.0)]);
        // At first it may go on; then its speed falls by 1.8 m/s each second.
        for (at_s, least_bad_m_s) in [
            (10.0, None),
            (10.29, None),
            (10.31, Some(0.441)),
            (10.45, Some(0.261)),
            (10.55, Some(0.081)),
            (10.65, Some(0.021)),
            (14.99, Some(0.021)),
            (15.0, None),
        ] {
            let good_m_s = least_bad_m_s.map_or(0.4, |bad_m_s: f64| (bad_m_s - 0.002).min(0.4));
            assert_eq!(own.clone().look(at_s, good_m_s), None, "at {at_s} s");
            if let Some(bad_m_s) = least_bad_m_s {
                own.speed_m_s = 0.4;
                let mut bad = own.clone();
                // As fast as before at the begin of the stop.
                bad.look(10.305, 0.4);
                assert!(bad.look(at_s, bad_m_s).is_some(), "at {at_s} s");
            }
        }
    }

    #[test]
    fn frozen_sensors_are_noticed_once_the_robot_drives() {
        const FREEZE: &str =
            "at_s = 10.0, for_s = 5.0, what = \"freeze-sensors\", robot = \"amr-1\"";
        let mut own = braking(&[FREEZE]);
        assert_eq!(windows(&own), [(10.2, 15.0, 2.0)]);
        for tenths in 90..=120 {
            assert_eq!(own.look(f64::from(tenths) / 10.0, 0.0), None, "it stands");
        }
        assert_eq!(own.look(12.1, 0.3), None);
        assert_eq!(windows(&own), [(12.2, 15.0, 2.0)]);
        assert_eq!(own.look(12.2, 0.3), None, "it has as long as at the begin");
        assert!(own.look(12.5, 0.3).is_some(), "it should brake by now");
    }

    #[test]
    fn faults_get_into_each_others_way() {
        let hang = "at_s = 10.2, for_s = 0.5, what = \"hang\", robot = \"amr-1\"";
        let late = "at_s = 9.0, for_s = 3.0, what = \"late-threads\", robot = \"amr-1\", share = 0.5, by_s = 0.02";
        let motors = "at_s = 12.0, for_s = 1.0, what = \"cut-motors\", robot = \"amr-1\"";
        let absent = "at_s = 10.2, for_s = 1.0, what = \"absent\", robot = \"amr-1\"";
        let slope = "at_s = 9.0, for_s = 9.0, what = \"slope\", robot = \"amr-1\", share = -0.1";
        let reversed = "at_s = 9.0, for_s = 9.0, what = \"reverse-motor\", robot = \"amr-1\"";
        let all = [
            // Who hangs looks for scans afterwards.
            ([UNPLUG, hang], vec![(11.0, 15.0, 1.5), (10.3, 10.7, 1.5)]),
            ([UNPLUG, absent], vec![]),
            ([UNPLUG, late], vec![(10.36, 15.0, 1.5)]),
            // It stands by then, and goes on to.
            ([UNPLUG, motors], vec![(10.3, 15.0, 1.5), (12.0, 13.0, 1.5)]),
            ([UNPLUG, reversed], vec![(10.3, 15.0, 0.0)]),
            // Downhill only motors with power brake as on level ground.
            ([UNPLUG, slope], vec![(10.3, 15.0, 2.0)]),
            ([slope, motors], vec![(12.0, 13.0, 1.5 - 0.1 * 9.81)]),
        ];
        for (faults, expected) in all {
            assert_eq!(windows(&braking(&faults)), expected, "{faults:?}");
        }
        let pause = "at_s = 10.0, for_s = 5.0, what = \"pause\", robot = \"amr-1\"";
        let hands =
            "at_s = 11.0, for_s = 1.0, what = \"teleop\", robot = \"amr-1\", motion = [0.1,0.0]";
        assert_eq!(
            windows(&braking(&[pause, hands])),
            [(10.15, 11.0, 0.8), (12.15, 15.0, 0.8)],
            "one that is paused may be driven by hand"
        );
        let later =
            "at_s = 40.0, for_s = 1.0, what = \"teleop\", robot = \"amr-1\", motion = [0.1,0.0]";
        assert_eq!(
            windows(&braking(&[pause, later])),
            windows(&braking(&[pause])),
            "long after it went on"
        );
        let other = UNPLUG.replace("amr-1", "amr-2");
        assert_eq!(windows(&braking(&[&other])), []);
    }

    #[test]
    fn nobody_brakes_while_a_fault_holds_the_wheels_to_what_they_were_told() {
        let fieldbus =
            "at_s = 10.341, for_s = 0.5, what = \"hang\", robot = \"amr-1\", thread = \"fieldbus\"";
        let bad = |faults: &[&str], looks: &[(f64, f64)]| {
            let mut own = braking(faults);
            let bad = looks
                .iter()
                .map(|&(at_s, m_s)| own.look(at_s, m_s).is_some());
            bad.collect::<Vec<_>>()
        };
        let late = [(10.301, 0.2), (10.4, 0.2), (10.44, 0.2), (10.48, 0.2)];
        assert_eq!(bad(&[UNPLUG, fieldbus], &late), [false; 4]);
        assert_eq!(bad(&[UNPLUG], &late), [false, true, true, true]);
        let too_late = [(10.301, 0.2), (10.442, 0.2), (10.6, 0.2)];
        assert_eq!(bad(&[UNPLUG, fieldbus], &too_late), [false, false, true]);
        // It stood by then.
        let drives = [(10.301, 0.2), (10.34, 0.01), (10.42, 0.25)];
        assert_eq!(bad(&[UNPLUG, fieldbus], &drives), [false, false, true]);
    }

    #[test]
    fn each_thread_has_the_time_of_whoever_notices() {
        for (thread, expected) in [
            ("fieldbus", vec![(10.1, 15.0, 1.5)]),
            ("motion", vec![(10.05, 15.0, 2.0)]),
            ("navigation", vec![(10.15, 15.0, 2.0)]),
            ("lidar", vec![(10.3, 15.0, 2.0)]),
            ("supervisor", vec![(11.05, 15.0, 2.0)]),
            ("communication", vec![(12.15, 15.0, 2.0)]),
        ] {
            let fault = format!(
                "at_s = 10.0, for_s = 5.0, what = \"hang\", robot = \"amr-1\", thread = \"{thread}\""
            );
            assert_eq!(windows(&braking(&[&fault])), expected, "{thread}");
        }
    }

    #[test]
    fn whoever_is_started_again_may_drive_where_nothing_else_keeps_it() {
        for (what, expected) in [
            ("lose-network", vec![(10.1, 12.0, 1.5)]),
            ("fill-disk", vec![(10.1, 15.0, 1.5)]),
            ("freeze-lidar", vec![(10.9, 15.0, 2.0)]),
            ("overload", vec![(11.15, 15.0, 1.5)]),
        ] {
            let fault = format!("at_s = 10.0, for_s = 5.0, what = \"{what}\", robot = \"amr-1\"");
            assert_eq!(windows(&braking(&[&fault])), expected, "{what}");
        }
    }

    #[test]
    fn who_starts_without_its_network_or_stands_then_need_not_stop_for_it() {
        const HANG: &str = "at_s = 10.0, for_s = 5.0, what = \"hang\", robot = \"amr-1\", thread = \"communication\"";
        let killed = |at_s: f64| {
            let kill =
                format!("at_s = {at_s:?}, for_s = 3.0, what = \"kill-robot\", robot = \"amr-1\"");
            windows(&braking(&[HANG, &kill]))
        };
        // What is left is what the kill asks for.
        assert_eq!(killed(8.0), [(8.1, 11.0, 1.5)]);
        assert_eq!(killed(13.0), [(12.15, 13.0, 1.5), (13.1, 16.0, 1.5)]);
        for (speed_m_s, stops) in [(0.0, false), (0.3, true)] {
            let mut own = braking(&[HANG]);
            own.look(9.99, speed_m_s);
            own.look(10.01, speed_m_s);
            own.look(12.2, 0.3);
            assert_eq!(own.look(13.0, 0.3).is_some(), stops, "{speed_m_s} m/s");
        }
    }
}
