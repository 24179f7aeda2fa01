//! Faults of a run: drawn from the seed, or from the scenario's file, and what they do to the run at a time.

use description::threads::ActivityKind;
use onboard::symbols::faults::Fault;
use sim::world::{Mechanics, Random};

use super::clock::START_NS;
pub use super::late::Lateness;
use super::message::{MessageKind, Weather};
use super::split::splits;
use crate::scenario::{
    Direction, GRAVITY_M_S2, OVERLOADED_BY_S, SUPERVISOR, Scenario, ScriptedFault, ScriptedKind,
};

/// Faults come from the seed, apart from everything else.
const FAULT_STREAM: u64 = 0x4641_554C;
/// At most this many are drawn.
const MOST: f64 = 6.0;
/// They begin while robots start, or later, until a time that the scenario says.
const BEGIN_S: f64 = 0.0;
/// They last between these times, short ones as often as long ones,
const LASTS_S: [f64; 2] = [0.05, 12.0];
/// but for this share of them, which last longer: deadlines of robots and mediator are 30 s and 60 s.
const LONG: f64 = 0.1;
const LONG_S: [f64; 2] = [12.0, 120.0];
/// This share is of kinds after which a fleet may not go on by itself.
const LASTING: f64 = 0.05;
/// Delays are at least as long.
const LEAST_BY_S: f64 = 0.005;
/// What a fault leaves shows so long after its end,
const SHOWS_LATE_NS: u64 = 60_000_000_000;
/// and a robot says when by its own clock, which may be this far off.
const CLOCKS_DIFFER_NS: u64 = 100_000_000;
/// Who drives by hand wants at most this: forward, metres per second, and turning, radians per second.
pub(crate) const FASTEST: [f64; 2] = [0.4, 1.0];

/// Faults for a scenario, drawn from the seed; in the order of their times.
#[must_use]
pub fn drawn(scenario: &Scenario, seed: u64) -> Vec<ScriptedFault> {
    let mut random = Random::new(seed, FAULT_STREAM);
    let count = 1 + (random.unit() * MOST) as usize;
    let managed = scenario.site.areas_managed && !scenario.withholds_areas;
    let mut faults: Vec<ScriptedFault> = (0..count)
        .map(|_| draw(scenario, managed, &mut random))
        .collect();
    faults.extend(splits(scenario, seed, &faults));
    faults.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    faults
}

/// A scenario with the faults of a seed beside its own.
#[must_use]
pub fn faulted(scenario: &Scenario, seed: u64) -> Scenario {
    let mut scenario = scenario.clone();
    scenario.faults.extend(drawn(&scenario, seed));
    scenario
}

fn draw(scenario: &Scenario, managed: bool, random: &mut Random) -> ScriptedFault {
    let lasting = random.unit() < LASTING && managed;
    let kinds: &[&[ScriptedKind]] = if lasting {
        &[&ScriptedKind::LASTING]
    } else {
        &[&ScriptedKind::DRAWN, &ScriptedKind::BORNE]
    };
    // A fleet does not come to its goals without a robot that is carried away for good.
    let kinds: Vec<ScriptedKind> = { kinds.iter().copied().flatten().copied() }
        .filter(|kind| managed || !kind.needs_mediator())
        .filter(|kind| *kind != ScriptedKind::Absent)
        .collect();
    let what = kinds[below(random, kinds.len())];
    let keys = what.keys();
    let player = &scenario.robots[below(random, scenario.robots.len())];
    let robot = &player.id;
    // Drawn in any case, so that a fault does not depend on the kinds of those before it.
    let [at, lasts, long, own, share, by, alone] = std::array::from_fn(|_| random.unit());
    let (_, mut threads) = player.threads();
    threads.push(SUPERVISOR);
    let thread = threads[below(random, threads.len())];
    // As often one thread as all, or as the one that drives.
    let thread = (keys.thread && alone < 0.5).then(|| thread.to_owned());
    let lasts_s = if long < LONG { LONG_S } else { LASTS_S };
    // A clock that is off is slow as often as fast, and a slope as often rises as falls.
    let slow = what.least_share() < 0.0 && by < 0.5;
    let sign = if slow { -1.0 } else { 1.0 };
    ScriptedFault {
        at_s: rounded(BEGIN_S + at * (scenario.faults_until_s - BEGIN_S)),
        for_s: rounded(between(lasts_s, lasts)),
        what,
        robot: { keys.robot }.and_then(|must| (must || own < 0.5).then(|| robot.clone())),
        share: keys
            .share
            .then(|| sign * rounded(share * what.most_share() * 10.0) / 10.0),
        by_s: keys
            .by_s
            .then(|| rounded(between([LEAST_BY_S, what.most_by_s()], by))),
        thread,
        // As often in the middle of an area as in nobody's way.
        pose: (keys.pose && alone < 0.5).then(|| {
            let areas = &scenario.site.areas;
            let region = areas[place(share, areas.len())].region;
            let [x_m, y_m] = [
                region.min.x_m + region.max.x_m,
                region.min.y_m + region.max.y_m,
            ]
            .map(|twice| (twice * 500.0).round() / 1e3);
            [x_m, y_m, (by * 360.0).round()]
        }),
        motion: keys.motion.then(|| {
            let [forward, turning] = [share, by].map(|unit| 2.0 * unit - 1.0);
            [forward * FASTEST[0], turning * FASTEST[1]].map(|wanted| (wanted * 1e3).round() / 1e3)
        }),
        way: { keys.way }.then(|| Direction::drawn(alone)).flatten(),
        mediator: None,
    }
}

pub(crate) fn below(random: &mut Random, count: usize) -> usize {
    place(random.unit(), count)
}

/// One of so many, from a number between 0 and 1.
fn place(unit: f64, count: usize) -> usize {
    ((unit * count as f64) as usize).min(count - 1)
}

/// As likely between 0.1 and 1 as between 1 and 10.
pub(crate) fn between([least, most]: [f64; 2], unit: f64) -> f64 {
    least * (most / least).powf(unit)
}

/// To thousandths (milliseconds are the clock's steps), without becoming nothing.
pub(crate) fn rounded(value: f64) -> f64 {
    (value * 1e3).round().max(1.0) / 1e3
}

/// What a fault does at its begin or its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Change {
    /// Number of the fault in the scenario.
    pub(super) fault: usize,
    pub(super) what: ScriptedKind,
    pub(super) begins: bool,
    /// Number in the scenario.
    pub(super) robot: Option<usize>,
}

/// A run's faults, with times of the simulated clock.
pub(super) struct Schedule {
    faults: Vec<Planned>,
}

struct Planned {
    from_ns: u64,
    to_ns: u64,
    robot: Option<usize>,
    fault: ScriptedFault,
    begun: bool,
    over: bool,
    /// Where its robot headed when it began, in the world.
    heading_rad: f64,
}

impl Planned {
    /// It is this robot's, or all robots'.
    fn concerns(&self, robot: usize) -> bool {
        self.robot.is_none_or(|own| own == robot)
    }
}

impl Schedule {
    /// What who drives by hand wants, by a fault's number: forward, metres per second, and turning, radians per second.
    pub(super) fn motion(&self, fault: usize) -> [f64; 2] {
        let motion = { self.faults.get(fault) }.and_then(|planned| planned.fault.motion);
        motion.unwrap_or_default()
    }

    pub(super) fn new(scenario: &Scenario) -> Self {
        let ns = |seconds: f64| START_NS + (seconds * 1e9) as u64;
        let planned = |fault: &ScriptedFault| {
            let robot = fault.robot.as_deref().and_then(|id| scenario.player(id));
            let mut fault = fault.clone();
            if let (ScriptedKind::Overload, Some(robot)) = (fault.what, robot) {
                fault.thread = scenario.robots[robot].thread_of(ActivityKind::Control);
            }
            Planned {
                from_ns: ns(fault.at_s),
                to_ns: ns(fault.until_s()),
                robot,
                fault,
                begun: false,
                over: false,
                heading_rad: 0.0,
            }
        };
        Self {
            faults: scenario.faults.iter().map(planned).collect(),
        }
    }

    /// Which thread a fault concerns, if it is that alone.
    pub(super) fn thread(&self, fault: usize) -> Option<&str> {
        { self.faults.get(fault) }.and_then(|planned| planned.fault.thread.as_deref())
    }

    /// A robot headed there when a fault began that concerns it.
    pub(super) fn heads(&mut self, fault: usize, heading_rad: f64) {
        if let Some(own) = self.faults.get_mut(fault) {
            own.heading_rad = heading_rad;
        }
    }

    /// Whether one that concerns this robot, or all, may be to blame for this fault, which its robot raised at this time.
    pub(super) fn are_blamed(&self, robot: usize, raised: Fault, raised_ns: u64) -> bool {
        { self.faults.iter() }
            .filter(|own| own.begun && own.concerns(robot))
            .filter(|own| own.fault.what.may_latch(raised))
            .any(|own| {
                raised_ns + CLOCKS_DIFFER_NS >= own.from_ns && raised_ns < own.to_ns + SHOWS_LATE_NS
            })
    }

    /// Whether there were any, and all are over.
    pub(super) fn are_over(&self) -> bool {
        !self.faults.is_empty() && self.faults.iter().all(|own| own.over)
    }

    /// What begins or ends now.
    pub(super) fn changes(&mut self, now_ns: u64) -> Vec<Change> {
        let mut changes = Vec::new();
        for (fault, own) in self.faults.iter_mut().enumerate() {
            let mut change = |begins| {
                let (what, robot) = (own.fault.what, own.robot);
                changes.push(Change {
                    fault,
                    what,
                    begins,
                    robot,
                });
            };
            if !own.begun && now_ns >= own.from_ns {
                own.begun = true;
                change(true);
            }
            if own.begun && !own.over && now_ns >= own.to_ns {
                own.over = true;
                change(false);
            }
        }
        changes
    }

    fn lasting(&self) -> impl Iterator<Item = &Planned> {
        { self.faults.iter() }.filter(|own| own.begun && !own.over)
    }

    /// Whether a fault of this kind lasts, for this robot.
    pub(super) fn lasts(&self, what: ScriptedKind, robot: Option<usize>) -> bool {
        self.lasting()
            .any(|own| own.fault.what == what && own.robot == robot)
    }

    /// Whether a fault lasts that concerns this robot, or all.
    pub(super) fn hinders(&self, robot: usize) -> bool {
        self.lasting().any(|own| own.concerns(robot))
    }

    /// How often or how much, where faults of this kind last for this robot; else 0.
    pub(super) fn share(&self, what: ScriptedKind, robot: usize) -> f64 {
        self.most(what, Some(robot), |fault| fault.share)
    }

    /// By how much, where faults of this kind last for this robot; else 0.
    pub(super) fn by_ns(&self, what: ScriptedKind, robot: Option<usize>) -> u64 {
        (self.most(what, robot, |fault| fault.by_s) * 1e9) as u64
    }

    fn most(
        &self,
        what: ScriptedKind,
        robot: Option<usize>,
        of: impl Fn(&ScriptedFault) -> Option<f64>,
    ) -> f64 {
        { self.lasting() }
            .filter(|own| own.fault.what == what && own.robot == robot)
            .filter_map(|own| of(&own.fault))
            .fold(0.0, f64::max)
    }

    /// How fast the clock of a robot gets ahead of the world's, or the mediator's does; negative: how far behind.
    pub(super) fn drift(&self, robot: Option<usize>) -> f64 {
        { self.lasting() }
            .filter(|own| own.fault.what == ScriptedKind::Drift && own.robot == robot)
            .filter_map(|own| own.fault.share)
            .max_by(|a, b| a.abs().total_cmp(&b.abs()))
            .unwrap_or(0.0)
    }

    /// How late threads of a robot are.
    pub(super) fn lateness(&self, robot: usize) -> Vec<Lateness> {
        { self.lasting() }
            .filter(|own| own.robot == Some(robot))
            .filter_map(|own| {
                let (share, by_s) = match own.fault.what {
                    ScriptedKind::LateThreads => (own.fault.share?, own.fault.by_s?),
                    ScriptedKind::Overload => (1.0, OVERLOADED_BY_S),
                    _ => return None,
                };
                Some(Lateness {
                    share,
                    by_ns: (by_s * 1e9) as u64,
                    thread: own.fault.thread.clone(),
                })
            })
            .collect()
    }

    /// Whether all threads of a robot hang,
    pub(super) fn hangs(&self, robot: usize) -> bool {
        self.hung(robot).any(|thread| thread.is_none())
    }

    /// or which of them.
    pub(super) fn hung_threads(&self, robot: usize) -> Vec<&str> {
        self.hung(robot).flatten().collect()
    }

    fn hung(&self, robot: usize) -> impl Iterator<Item = Option<&str>> {
        { self.lasting() }
            .filter(move |own| own.robot == Some(robot))
            .filter_map(|own| match own.fault.what {
                ScriptedKind::Hang => Some(own.fault.thread.as_deref()),
                ScriptedKind::Overload => Some(Some(SUPERVISOR)),
                _ => None,
            })
    }

    /// What is wrong with a robot's wheels, whose motors brake with `braking_m_s2` where nothing is.
    pub(super) fn mechanics(&self, robot: usize, braking_m_s2: f64) -> Mechanics {
        let lasts = |what| self.lasts(what, Some(robot));
        let slip = self.share(ScriptedKind::Slip, robot);
        let weaker = self.share(ScriptedKind::WeakBrakes, robot);
        let weak = lasts(ScriptedKind::WeakBrakes);
        let slopes = { self.lasting() }
            .filter(|own| own.fault.what == ScriptedKind::Slope && own.robot == Some(robot));
        let slope_m_s2 = slopes.fold([0.0; 2], |[along_x, along_y], own| {
            let pull_m_s2 = own.fault.share.unwrap_or(0.0) * GRAVITY_M_S2;
            let (sin, cos) = own.heading_rad.sin_cos();
            [along_x + pull_m_s2 * cos, along_y + pull_m_s2 * sin]
        });
        Mechanics {
            slip: [slip, slip / 2.0],
            slope_m_s2,
            load: 1.0 + self.share(ScriptedKind::Load, robot),
            braking_m_s2: if weak {
                braking_m_s2 * (1.0 - weaker)
            } else {
                f64::INFINITY
            },
            reversed: [lasts(ScriptedKind::ReverseMotor), false],
            pivot_jammed: lasts(ScriptedKind::JamPivot),
        }
    }

    /// What happens to messages of a robot, of this kind.
    pub(super) fn weather(&self, robot: usize, kind: MessageKind) -> Weather {
        let (way, mediator) = kind.way();
        let mut weather = Weather::default();
        let own = self.lasting().filter(|own| own.concerns(robot));
        for own in own.filter(|own| own.fault.meets(way, mediator)) {
            let share = own.fault.share.unwrap_or(0.0);
            match own.fault.what {
                ScriptedKind::Lose => weather.lost = weather.lost.max(share),
                ScriptedKind::Partition => weather.lost = 1.0,
                ScriptedKind::Repeat => weather.repeated = weather.repeated.max(share),
                ScriptedKind::Delay => {
                    let by_ns = own.fault.by_s.unwrap_or(0.0) * 1e9;
                    weather.delay_ns = weather.delay_ns.max(by_ns);
                }
                _ => {}
            }
        }
        weather
    }

    /// How long the disk takes for each write.
    pub(super) fn disk_ns(&self) -> u64 {
        self.by_ns(ScriptedKind::SlowDisk, None)
    }
}
