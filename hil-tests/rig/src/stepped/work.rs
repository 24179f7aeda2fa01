//! What a robot's cycles take to compute, while its threads run on the simulated clock: by the clock of the machine that steps them. On an
//! emulated machine with one instruction in each nanosecond of its own time, these are numbers of instructions.
//!
//! What a thread waits for, and what its simulated devices do meanwhile, is left out.

use std::cell::{Cell, RefCell};

use coordination::activity::{Activity, LifeCycle, LifeCycleState};
use description::threads::ActivityKind;
use onboard::activities::robot_activity::RobotActivity;
use onboard::activities::scans::ScanIntake;
use onboard::realtime::wake::Wake;
use sim::rt::monotonic_ns;

/// A piece of work that repeats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// A cycle of the fieldbus: its frame made, taken apart, and the drive judged.
    Bus,
    /// A cycle of motion: odometry, and wheel setpoints.
    Motion,
    /// The bytes of a scan parsed.
    Parse,
    /// A scan aligned and navigated by: walls, pose, wanted motion.
    Scan,
    /// Motion tubes against a scan.
    Tubes,
}

impl Work {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Bus,
        Self::Motion,
        Self::Parse,
        Self::Scan,
        Self::Tubes,
    ];

    fn of(kind: ActivityKind) -> Option<Self> {
        match kind {
            ActivityKind::Drive => Some(Self::Bus),
            ActivityKind::Proprioception | ActivityKind::Control => Some(Self::Motion),
            ActivityKind::Lidar => Some(Self::Parse),
            ActivityKind::Navigation => Some(Self::Scan),
            ActivityKind::MotionTube => Some(Self::Tubes),
            ActivityKind::Communication => None,
        }
    }
}

/// A piece of work that was done.
#[derive(Clone, Copy, Debug)]
pub struct Done {
    /// What.
    pub work: Work,
    /// When it began and ended, on the monotonic clock,
    pub span_ns: (u64, u64),
    /// and what it took of that.
    pub took_ns: u64,
}

thread_local! {
    /// What was done since it was taken last; none while nobody measures.
    static DONE: RefCell<Option<Vec<Done>>> = const { RefCell::new(None) };
    /// Whether somebody measures.
    static ON: Cell<bool> = const { Cell::new(false) };
    /// Time that the coroutine that runs now was away: it waited, or its devices did their part.
    static AWAY_NS: Cell<u64> = const { Cell::new(0) };
    /// When it went on last, and how long it had been away by then.
    static WENT_ON_NS: Cell<(u64, u64)> = const { Cell::new((0, 0)) };
    /// The same of when each piece of work began.
    static BEGAN_NS: Cell<[(u64, u64); Work::ALL.len()]> = const { Cell::new([(0, 0); Work::ALL.len()]) };
}

/// Measures the one robot that is built and stepped by this thread, until it is dropped.
#[derive(Debug)]
pub struct WorkMeter(());

impl WorkMeter {
    /// Begins to measure.
    #[must_use]
    pub fn begin() -> Self {
        ON.set(true);
        DONE.set(Some(Vec::new()));
        Self(())
    }

    /// What was done since it was asked last.
    #[must_use]
    pub fn take(&mut self) -> Vec<Done> {
        DONE.with_borrow_mut(|done| done.as_mut().map(std::mem::take).unwrap_or_default())
    }
}

impl Drop for WorkMeter {
    fn drop(&mut self) {
        ON.set(false);
        DONE.set(None);
    }
}

/// Runs what a device does for the coroutine that runs now.
pub(super) fn of_a_device<R>(part: impl FnOnce() -> R) -> R {
    if !ON.get() {
        return part();
    }
    let began_ns = monotonic_ns();
    let result = part();
    AWAY_NS.set(AWAY_NS.get() + (monotonic_ns() - began_ns));
    result
}

/// Suspends the coroutine that runs now, by `wait`; others run meanwhile.
pub(super) fn while_it_waits(wait: impl FnOnce()) {
    if !ON.get() {
        return wait();
    }
    let (away_ns, began_ns) = (AWAY_NS.get(), monotonic_ns());
    wait();
    let now_ns = monotonic_ns();
    let away_ns = away_ns + (now_ns - began_ns);
    AWAY_NS.set(away_ns);
    WENT_ON_NS.set((now_ns, away_ns));
}

/// The activities of a robot, measured if somebody does. `scans` wakes those that wait for one.
pub(super) fn measured(
    activities: Vec<(ActivityKind, Box<dyn RobotActivity>)>,
    scans: &Wake,
) -> Vec<(ActivityKind, Box<dyn RobotActivity>)> {
    if !ON.get() {
        return activities;
    }
    let measured = |(kind, activity): (ActivityKind, Box<dyn RobotActivity>)| {
        let Some(work) = Work::of(kind) else {
            return (kind, activity);
        };
        let own = Measured {
            activity,
            work,
            begins: kind != ActivityKind::Control,
            ends: kind != ActivityKind::Proprioception,
            scans: scans.clone(),
            seen: 0,
            before_ns: 0,
        };
        (kind, Box::new(own) as Box<dyn RobotActivity>)
    };
    activities.into_iter().map(measured).collect()
}

/// An activity that does a piece of work, or a part of one.
struct Measured {
    activity: Box<dyn RobotActivity>,
    work: Work,
    /// The piece begins with it,
    begins: bool,
    /// and ends with it.
    ends: bool,
    scans: Wake,
    /// Scans, as it knows.
    seen: u32,
    /// What earlier turns have taken of the same piece.
    before_ns: u64,
}

impl Measured {
    fn begin(&self) {
        let mut began_ns = BEGAN_NS.get();
        began_ns[self.work as usize] = match self.work {
            // What its thread does before is a scan's, too: it is aligned there.
            Work::Scan => WENT_ON_NS.get(),
            _ => (monotonic_ns(), AWAY_NS.get()),
        };
        BEGAN_NS.set(began_ns);
    }

    fn end(&mut self) {
        if self.life_cycle().state() != LifeCycleState::Running {
            return;
        }
        let (began_ns, away_ns) = BEGAN_NS.get()[self.work as usize];
        let now_ns = monotonic_ns();
        let took_ns = (now_ns - began_ns).saturating_sub(AWAY_NS.get() - away_ns);
        let scans = self.scans.count();
        let new_scan = std::mem::replace(&mut self.seen, scans) != scans;
        let took_ns = match (self.work, new_scan) {
            (Work::Bus | Work::Motion, _) => took_ns,
            // Its bytes come in pieces.
            (Work::Parse, false) => {
                self.before_ns += took_ns;
                return;
            }
            (Work::Parse, true) => std::mem::take(&mut self.before_ns) + took_ns,
            (Work::Scan | Work::Tubes, true) => took_ns,
            // Woken for want of a scan.
            (Work::Scan | Work::Tubes, false) => return,
        };
        let done = Done {
            work: self.work,
            span_ns: (began_ns, now_ns),
            took_ns,
        };
        DONE.with_borrow_mut(|all| all.iter_mut().for_each(|all| all.push(done)));
    }
}

impl Activity for Measured {
    fn name(&self) -> &'static str {
        self.activity.name()
    }

    fn life_cycle(&self) -> &LifeCycle {
        self.activity.life_cycle()
    }

    fn communicate_in(&mut self, now_ns: u64) {
        if self.begins {
            self.begin();
        }
        self.activity.communicate_in(now_ns);
    }

    fn coordinate(&mut self, now_ns: u64) {
        self.activity.coordinate(now_ns);
    }

    fn configure(&mut self, now_ns: u64) {
        self.activity.configure(now_ns);
    }

    fn compute(&mut self, now_ns: u64) {
        self.activity.compute(now_ns);
    }

    fn rest(&mut self, now_ns: u64) {
        self.activity.rest(now_ns);
    }

    fn communicate_out(&mut self, now_ns: u64) {
        self.activity.communicate_out(now_ns);
        if self.ends {
            self.end();
        }
    }
}

impl RobotActivity for Measured {
    fn scans(&mut self) -> Option<&mut Option<Box<ScanIntake>>> {
        self.activity.scans()
    }

    fn waited_ns(&self) -> u64 {
        self.activity.waited_ns()
    }

    fn after_panic(&mut self, now_ns: u64) -> bool {
        self.activity.after_panic(now_ns)
    }
}
