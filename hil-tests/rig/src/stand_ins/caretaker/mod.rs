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
        *self = Self {
            hindered_ns: self.hindered_ns,
            ..before
        };
    }
}

#[cfg(test)]
mod tests;
