//! The operator who looks after a robot that has latched, with a fault that only an operator ends.
//!
//! One rule, through the real programs and on the simulated clock:
//!
//! - a latch that something else is to blame for is reset after 3 s, and again after 3 s if it is still there; one that comes back
//!   within 5 s of a reset, after twice the time of the one before, since something has to be seen to first;
//! - any other is the robot's own, and ends the run at once; but an uncertain pose has 30 s, since walls may come into view again;
//! - whatever was to blame, a latch that lasts for 30 s ends the run; as long as a fault of the scenario lasts, its robot has that time
//!   still before it;
//! - whoever resets a robot stands beside it, sees where it is and what is behind it, and says so where the fault asks for it;
//! - a robot that somebody has stopped on purpose is left to whoever did that: a reset would end the stop.
//!
//! What differs is what may be to [`Blame`].

use description::geometry::Pose2;
use onboard::process::ctl::{FreeBehind, Place, Request, Spot};
use onboard::symbols::faults::{Fault, FaultTable, Resumes};
use sim::world::World;

use crate::stalls::{LATCHES, LATCHES_WITHIN_NS};

/// A latch is judged after this time: by then the watch has noted the stall that it came with.
const JUDGED_AFTER_NS: u64 = 100_000_000;
/// A robot is reset after this time, and not sooner again.
const RESET_AFTER_NS: u64 = 3_000_000_000;
/// What comes back within this time of a reset was reset in vain,
const IN_VAIN_NS: u64 = 5_000_000_000;
/// which doubles the time before the next one, so often at most.
const DOUBLED: u32 = 3;
/// A reset is answered within this time.
const ANSWERED_NS: u64 = 1_000_000_000;
/// How far behind a robot people look.
const LOOK_BEHIND_M: f64 = 2.5;
/// Faults after which a robot may know nothing of the floor behind it.
const ASK_BEHIND: [Fault; 4] = [
    Fault::DriveReturned,
    Fault::BringUpLimit,
    Fault::WheelSlip,
    Fault::FloorUnknown,
];
/// To which part of a metre and of a radian they say where it stands.
const PARTS: f64 = 100.0;
/// A latch that may be reset, or end by itself, strands the robot after this time.
const STRANDED_NS: u64 = 30_000_000_000;

/// What a latch may be blamed on, if not on the robot.
#[derive(Clone, Copy)]
pub enum Blame<'a> {
    /// Through the real programs: a stall of the machine, within 2 s before a latch that lateness can cause. Tells whether it stalled
    /// between two times.
    Stalls(&'a dyn Fn(u64, u64) -> bool),
    /// On the simulated clock, where nothing stalls: faults of the scenario.
    Faults {
        /// Tells whether one that concerns this robot may be to blame for this latch, of this time.
        blamed: &'a dyn Fn(Fault, u64) -> bool,
        /// One lasts that concerns this robot.
        lasts: bool,
    },
}

impl Blame<'_> {
    fn is_to_blame(&self, fault: Fault, since_ns: u64) -> bool {
        match self {
            Self::Stalls(stalled) => {
                let from_ns = since_ns.saturating_sub(LATCHES_WITHIN_NS);
                LATCHES.contains(&fault) && stalled(from_ns, since_ns)
            }
            Self::Faults { blamed, .. } => blamed(fault, since_ns),
        }
    }
}

/// What to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Care {
    /// Nothing, yet.
    None,
    /// Reset the robot.
    Reset,
    /// End the run: nobody is to clear this fault.
    GiveUp(Fault),
}

/// What an operator says to a robot with these faults when resetting it, standing beside it. `was_in` is the state of its
/// machine, as it was heard last before the robot lost its memory.
#[must_use]
pub fn words(
    faults: &FaultTable,
    world: &World,
    robot: usize,
    was_in: Option<&str>,
) -> Vec<Request> {
    let is_any = |kinds: &[Fault]| kinds.iter().any(|&kind| faults.state(kind).active != 0);
    let lost = is_any(&[Fault::PoseUncertain, Fault::PlaceUnknown]);
    let silent = is_any(&[Fault::BusLost, Fault::OdometrySilent]);
    if is_any(&[Fault::DriveStalled]) || lost && silent {
        // Its drive says nothing, or still how fast it was: nobody can say where it stands, or on what, before it says that it does.
        return vec![Request::Reset];
    }
    if lost && !is_any(&[Fault::OperatorStop, Fault::PlaceUnknown]) {
        // One that finds its place again drives on: whoever has more to say stops it first, and waits until it stands.
        return vec![Request::Stop];
    }
    let place = lost.then(|| place(world, robot, was_in)).flatten();
    let behind = (lost || is_any(&ASK_BEHIND)).then(|| free_behind(world, robot));
    let words = [place, behind.flatten(), Some(Request::Reset)];
    words.into_iter().flatten().collect()
}

/// What who stands beside a robot sees of where it is and of what is behind it.
#[must_use]
pub fn where_it_is(world: &World, robot: usize) -> Vec<Request> {
    let words = [place(world, robot, None), free_behind(world, robot)];
    words.into_iter().flatten().collect()
}

/// What who has carried a robot somewhere says then, where its machine is to be in this state; it goes on afterwards.
#[must_use]
pub fn brought_back(world: &World, robot: usize, state: Option<&str>) -> Vec<Request> {
    let words = [
        Some(Request::Stop),
        place(world, robot, state),
        free_behind(world, robot),
        Some(Request::Reset),
    ];
    words.into_iter().flatten().collect()
}

fn place(world: &World, robot: usize, state: Option<&str>) -> Option<Request> {
    let pose = world.truth(robot)?.pose;
    let [x_m, y_m, theta_rad] =
        [pose.x_m, pose.y_m, pose.theta_rad].map(|exact| (exact * PARTS).round() / PARTS);
    Some(Request::Place(Place {
        at: Spot::Pose(Pose2::new(x_m, y_m, theta_rad)),
        state: state.map(str::to_owned),
    }))
}

/// None: there is no way.
fn free_behind(world: &World, robot: usize) -> Option<Request> {
    let way_m = world.free_behind_m(robot, LOOK_BEHIND_M);
    (way_m > 0.0).then_some(Request::FreeBehind(FreeBehind { way_m }))
}

/// Looks after one robot.
#[derive(Clone, Copy, Debug, Default)]
pub struct Caretaker {
    reset_ns: u64,
    /// Resets in vain, one after the other, up to the last one.
    in_vain: u32,
    /// When a fault of the scenario lasted last.
    hindered_ns: u64,
    /// How often it was reset.
    pub resets: u32,
}

impl Caretaker {
    /// What to do now about what the robot says of its faults. An operator's stop is `on_purpose` while whoever stopped it is
    /// still there to let it go on.
    pub fn look(
        &mut self,
        faults: &FaultTable,
        now_ns: u64,
        on_purpose: bool,
        blame: Blame<'_>,
    ) -> Care {
        // One that was refused before leaves the robot stopped.
        let stop = faults.state(Fault::OperatorStop);
        let refused_ns = self.reset_ns..=self.reset_ns + ANSWERED_NS;
        let is_own = self.resets > 0 && refused_ns.contains(&stop.since_ns);
        let stopped = on_purpose && stop.active != 0 && !is_own;
        let latched = { faults.active() }
            .filter(|fault| fault.resumes() == Resumes::Operator)
            .filter(|fault| !stopped || *fault != Fault::OperatorStop)
            .map(|fault| (fault, faults.state(fault).since_ns));
        if let Blame::Faults { lasts: true, .. } = blame {
            self.hindered_ns = now_ns;
        }
        let mut care = Care::None;
        let mut in_vain = 0;
        for (fault, since_ns) in latched {
            let lasts_ns = now_ns.saturating_sub(since_ns);
            if lasts_ns < JUDGED_AFTER_NS {
                continue;
            }
            let excused =
                is_own && fault == Fault::OperatorStop || blame.is_to_blame(fault, since_ns);
            let may_end = excused || fault == Fault::PoseUncertain;
            let waited_ns = lasts_ns.min(now_ns - self.hindered_ns);
            if !may_end || waited_ns > STRANDED_NS {
                return Care::GiveUp(fault);
            }
            if self.is_back(since_ns) {
                in_vain = self.in_vain + 1;
            }
            let after_ns = RESET_AFTER_NS << in_vain.min(DOUBLED);
            let in_time = lasts_ns > after_ns && now_ns > self.reset_ns + RESET_AFTER_NS;
            if excused && in_time && !stopped {
                care = Care::Reset;
            }
        }
        if care == Care::Reset {
            (self.reset_ns, self.in_vain) = (now_ns, in_vain);
            self.resets += 1;
        }
        care
    }

    /// Whether a latch of this time came soon after the last reset.
    fn is_back(&self, since_ns: u64) -> bool {
        let soon_ns = self.reset_ns..self.reset_ns.saturating_add(IN_VAIN_NS);
        self.resets > 0 && soon_ns.contains(&since_ns)
    }

    /// It does not ask for the reset of its last look: there is no answer to the one before, which was counted by then.
    pub fn asks_nothing(&mut self, before: Self) {
        (self.reset_ns, self.in_vain, self.resets) =
            (before.reset_ns, before.in_vain, before.resets);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND_NS: u64 = 1_000_000_000;
    const FAULTS: Blame<'_> = Blame::Faults {
        blamed: &|_, _| true,
        lasts: false,
    };
    const NOBODY: Blame<'_> = Blame::Faults {
        blamed: &|_, _| false,
        lasts: false,
    };

    /// By a fault that is to blame for anything.
    fn hindered(lasts: bool) -> Blame<'static> {
        Blame::Faults {
            blamed: &|_, _| true,
            lasts,
        }
    }

    fn latched(fault: Fault) -> FaultTable {
        let mut faults = FaultTable::default();
        faults.raise(fault, 10 * SECOND_NS);
        faults
    }

    #[test]
    fn a_latch_that_something_else_is_to_blame_for_is_reset_and_counted() {
        let faults = latched(Fault::Overruns);
        let stall_ns = 9 * SECOND_NS;
        let stalled = |from_ns, to_ns| (from_ns..=to_ns).contains(&stall_ns);
        for blame in [Blame::Stalls(&stalled), FAULTS] {
            let mut caretaker = Caretaker::default();
            let mut look = |at_s| {
                let care = caretaker.look(&faults, at_s * SECOND_NS, true, blame);
                (care, caretaker.resets)
            };
            assert_eq!(look(10), (Care::None, 0));
            assert_eq!(look(12), (Care::None, 0), "as a person does");
            assert_eq!(look(14), (Care::Reset, 1));
            assert_eq!(look(15), (Care::None, 1), "it takes a while");
            assert_eq!(look(18), (Care::Reset, 2));
            assert_eq!(look(41), (Care::GiveUp(Fault::Overruns), 2), "in vain");
            let gone = caretaker.look(&FaultTable::default(), 50 * SECOND_NS, true, blame);
            assert_eq!((gone, caretaker.resets), (Care::None, 2));
        }
    }

    /// As of a pivot that is jammed.
    #[test]
    fn what_comes_back_after_each_reset_is_waited_for_longer_and_longer() {
        let mut caretaker = Caretaker::default();
        let mut faults = FaultTable::default();
        let mut resets_s = Vec::new();
        for at_s in 10..90 {
            faults.raise(Fault::WheelsDisobey, at_s * SECOND_NS);
            if caretaker.look(&faults, at_s * SECOND_NS, false, hindered(true)) == Care::Reset {
                faults.clear(Fault::WheelsDisobey);
                resets_s.push(at_s);
            }
        }
        assert_eq!(resets_s, [14, 22, 36, 62, 88]);
        // What comes much later is another one.
        faults.clear(Fault::WheelsDisobey);
        faults.raise(Fault::WheelsDisobey, 100 * SECOND_NS);
        let mut look = |at_s| caretaker.look(&faults, at_s * SECOND_NS, false, hindered(true));
        assert_eq!([look(103), look(104)], [Care::None, Care::Reset]);
    }

    #[test]
    fn any_other_latch_ends_the_run_at_once() {
        // A stall long before it does not count.
        let stalled = |from_ns, _| from_ns <= 7 * SECOND_NS;
        for blame in [Blame::Stalls(&stalled), NOBODY] {
            let look = |fault, at_s: f64| {
                let at_ns = (at_s * 1e9) as u64;
                Caretaker::default().look(&latched(fault), at_ns, true, blame)
            };
            assert_eq!(look(Fault::Overruns, 10.05), Care::None);
            assert_eq!(look(Fault::Overruns, 10.2), Care::GiveUp(Fault::Overruns));
            assert_eq!(look(Fault::MotorsOff, 10.2), Care::GiveUp(Fault::MotorsOff));
            assert_eq!(look(Fault::BusLost, 100.0), Care::None, "ends by itself");
            let uncertain = Fault::PoseUncertain;
            assert_eq!(look(uncertain, 20.0), Care::None, "it may end by itself");
            assert_eq!(look(uncertain, 41.0), Care::GiveUp(uncertain));
        }
    }

    #[test]
    fn a_stall_excuses_no_latch_that_lateness_cannot_cause() {
        for fault in Fault::ALL {
            let blame = Blame::Stalls(&|_, _| true);
            let care = Caretaker::default().look(&latched(fault), 14 * SECOND_NS, false, blame);
            let expected = match fault.resumes() {
                Resumes::ByItself => Care::None,
                Resumes::Operator if LATCHES.contains(&fault) => Care::Reset,
                Resumes::Operator => Care::GiveUp(fault),
            };
            assert_eq!(care, expected, "{fault:?}");
        }
        assert!(LATCHES.contains(&Fault::Overruns) && !LATCHES.contains(&Fault::MotorsOff));
    }

    #[test]
    fn who_is_stopped_on_purpose_is_left_alone() {
        let look = |faults: &FaultTable, on_purpose| {
            Caretaker::default().look(faults, 20 * SECOND_NS, on_purpose, FAULTS)
        };
        let mut faults = latched(Fault::OperatorStop);
        assert_eq!(look(&faults, true), Care::None);
        assert_eq!(
            look(&faults, false),
            Care::Reset,
            "nobody is there any more"
        );
        faults.raise(Fault::MotorsOff, 11 * SECOND_NS);
        assert_eq!(
            look(&faults, true),
            Care::None,
            "a reset would end the stop"
        );
        let much_later = Caretaker::default().look(&faults, 50 * SECOND_NS, true, FAULTS);
        assert_eq!(much_later, Care::GiveUp(Fault::MotorsOff));
    }

    #[test]
    fn whom_a_fault_hinders_for_long_is_given_up_some_time_after_it() {
        let faults = latched(Fault::BringUpLimit);
        let mut caretaker = Caretaker::default();
        let mut look = |at_s: u64, lasts| {
            let blame = hindered(lasts);
            caretaker.look(&faults, at_s * SECOND_NS, false, blame)
        };
        assert_eq!(look(60, true), Care::Reset);
        assert_eq!(look(70, true), Care::Reset);
        assert_eq!(look(99, false), Care::Reset);
        assert_eq!(look(101, false), Care::GiveUp(Fault::BringUpLimit));
    }

    /// As while a supervisor hangs.
    #[test]
    fn whom_a_fault_hinders_without_an_answer_is_given_up_some_time_after_it_too() {
        let faults = latched(Fault::BringUpLimit);
        let mut caretaker = Caretaker::default();
        let mut look = |at_s: u64, lasts| {
            let blame = hindered(lasts);
            let before = caretaker;
            let care = caretaker.look(&faults, at_s * SECOND_NS, false, blame);
            if care == Care::Reset {
                caretaker.asks_nothing(before);
            }
            (care, caretaker.resets)
        };
        assert_eq!(look(60, true), (Care::Reset, 0));
        assert_eq!(look(61, false), (Care::Reset, 0));
        assert_eq!(look(91, false), (Care::GiveUp(Fault::BringUpLimit), 0));
    }

    #[test]
    fn what_is_the_robots_own_counts_more_than_a_stall() {
        let mut faults = latched(Fault::Overruns);
        faults.raise(Fault::DriveFault, 20 * SECOND_NS);
        let stalled = |_, to_ns| to_ns < 15 * SECOND_NS;
        let blame = Blame::Stalls(&stalled);
        let care = Caretaker::default().look(&faults, 21 * SECOND_NS, true, blame);
        assert_eq!(care, Care::GiveUp(Fault::DriveFault));
    }

    #[test]
    fn a_reset_that_was_refused_is_tried_again_where_others_stop_on_purpose() {
        let mut caretaker = Caretaker::default();
        let mut faults = latched(Fault::DriveReturned);
        let at = |s: u64| s * SECOND_NS;
        assert_eq!(caretaker.look(&faults, at(14), true, FAULTS), Care::Reset);
        faults.raise(Fault::OperatorStop, at(14) + SECOND_NS / 3);
        assert_eq!(caretaker.look(&faults, at(16), true, FAULTS), Care::None);
        assert_eq!(caretaker.look(&faults, at(18), true, FAULTS), Care::Reset);
        // Of somebody else: long after the reset.
        faults.clear(Fault::OperatorStop);
        faults.raise(Fault::OperatorStop, at(21));
        assert_eq!(caretaker.look(&faults, at(25), true, FAULTS), Care::None);
    }
}
