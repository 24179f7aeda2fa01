//! Faults one by one: each kind at a moment at which its robot drives, or stands in its dock, drawn from the seed.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use description::geometry::Point2;
use onboard::cli::Failure;
use sim::world::{Random, STANDING_M_S};

use crate::record::PathPoint;
use crate::run::{Ending, Run, record};
use crate::scenario::{Direction, Goal, SUPERVISOR, Scenario, ScriptedFault, ScriptedKind};
use crate::stepped::faults::{FASTEST, below, between, rounded};
use crate::stepped::{Plans, Stepped};
use crate::summary::Summary;

/// Moments come from the seed, apart from everything else.
const CASE_STREAM: u64 = 0x4341_5345;
/// Faster than this a robot drives.
const DRIVING_M_S: f64 = 0.15;
/// They last between these times: a robot that must stop has time to.
const LASTS_S: [f64; 2] = [0.3, 12.0];
/// Those that show only after seconds between these,
const LASTS_SECONDS_S: [f64; 2] = [2.0, 20.0];
/// and one that has to fill a queue.
const LASTS_LONG_S: [f64; 2] = [20.0, 60.0];
/// Delays are at least as long.
const LEAST_BY_S: f64 = 0.02;

/// A kind of fault, the thread that it hits, and where its robot is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Case {
    /// The kind.
    pub what: ScriptedKind,
    /// Of the robot's threads only this one.
    pub thread: Option<String>,
    /// What the robot does when it begins.
    pub does: Does,
}

/// What a robot does when a fault begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Does {
    /// It drives.
    Drive,
    /// It stands where its scenario has it stand, in a dock, and is to back out.
    Dock,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.what.name();
        match (&self.thread, self.does) {
            (_, Does::Dock) => f.pad(&format!("{name} docked")),
            (Some(thread), _) => f.pad(&format!("{name} {thread}")),
            (None, _) => f.pad(&name),
        }
    }
}

impl Case {
    /// Every kind that the scenario can have; of threads that hang or panic each one besides; and a program that ends in a dock, whose
    /// next one knows nothing of the floor behind it.
    #[must_use]
    pub fn all(scenario: &Scenario) -> Vec<Self> {
        let managed = scenario.site.areas_managed && !scenario.withholds_areas;
        let mut threads: Vec<&str> = { scenario.robots.iter() }
            .flat_map(|player| &player.config.threads)
            .map(|thread| thread.name.as_str())
            .chain([SUPERVISOR])
            .collect();
        threads.sort_unstable();
        threads.dedup();
        let of_threads = |what| {
            let own = move |thread: &&str| Self {
                thread: Some((*thread).to_owned()),
                ..Self::of(what)
            };
            threads.iter().map(own)
        };
        { ScriptedKind::all() }
            .filter(|what| managed || !what.needs_mediator())
            .map(Self::of)
            .chain(of_threads(ScriptedKind::Hang))
            .chain(of_threads(ScriptedKind::Panic))
            .chain([Self {
                does: Does::Dock,
                ..Self::of(ScriptedKind::EndRobot)
            }])
            .collect()
    }

    /// A kind, of a robot that drives.
    pub(super) fn of(what: ScriptedKind) -> Self {
        Self {
            what,
            thread: None,
            does: Does::Drive,
        }
    }

    /// The fault of a seed, at one of the moments at which a robot drives, or docks, which is none for a scenario in which nobody does.
    #[must_use]
    pub fn draw(&self, scenario: &Scenario, seed: u64, moments: &Moments) -> Option<ScriptedFault> {
        let mut random = Random::new(seed, CASE_STREAM ^ self.stream());
        let robot = below(&mut random, scenario.robots.len());
        let own = moments.of(robot, self.does)?;
        let at_s = own[below(&mut random, own.len())];
        let [lasts, whole, share, by] = std::array::from_fn(|_| random.unit());
        let keys = self.what.keys();
        let lasts_s = match self.what {
            ScriptedKind::LoseNetwork | ScriptedKind::FillDisk | ScriptedKind::FreezeLidar => {
                LASTS_SECONDS_S
            }
            ScriptedKind::Overload => LASTS_LONG_S,
            _ => LASTS_S,
        };
        // As often all of them as a part.
        let most = self.what.most_share();
        let share = if whole < 0.5 { 1.0 } else { share };
        // Drawn for none but these: the faults of all other kinds stay as they are.
        let falls = self.what != ScriptedKind::Slope || random.unit() < 0.5;
        let sign = if falls { 1.0 } else { -1.0 };
        Some(ScriptedFault {
            at_s: rounded(at_s),
            for_s: rounded(between(lasts_s, lasts)),
            what: self.what,
            robot: { keys.robot }.map(|_| scenario.robots[robot].id.clone()),
            share: keys
                .share
                .then(|| sign * rounded(share * most * 10.0) / 10.0),
            by_s: keys
                .by_s
                .then(|| rounded(between([LEAST_BY_S, self.what.most_by_s()], by))),
            thread: self.thread.clone(),
            pose: None,
            motion: keys.motion.then(|| {
                FASTEST.map(|most| {
                    rounded(most * random.unit()) * if random.unit() < 0.5 { -1.0 } else { 1.0 }
                })
            }),
            // By the one that it needs for nothing else.
            way: { keys.way }
                .then(|| Direction::drawn(if keys.by_s { whole } else { by }))
                .flatten(),
            mediator: None,
        })
    }

    /// Two cases of one seed: the second one begins while the first one lasts, for the same robot where it is a robot's.
    #[must_use]
    pub fn draw_pair(
        [first, second]: [&Self; 2],
        scenario: &Scenario,
        seed: u64,
        moments: &Moments,
    ) -> Option<[ScriptedFault; 2]> {
        let one = first.draw(scenario, seed, moments)?;
        let mut other = second.draw(scenario, seed, moments)?;
        let later = Random::new(seed, CASE_STREAM).unit();
        other.at_s = rounded(one.at_s + later * one.for_s);
        if one.robot.is_some() && other.robot.is_some() {
            other.robot.clone_from(&one.robot);
        }
        Some([one, other])
    }

    /// Tells cases apart.
    fn stream(&self) -> u64 {
        // FNV-1a: the same for ever.
        let text = self.to_string();
        let step =
            |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3);
        text.bytes().fold(0xCBF2_9CE4_8422_2325, step)
    }
}

/// What happens in a run without faults; until a fault begins, the run with it is the same.
#[derive(Clone, Debug)]
pub struct Moments {
    /// When each robot drives,
    driving_s: Vec<Vec<f64>>,
    /// and when it stands where it is to.
    docked_s: Vec<Vec<f64>>,
    /// What each robot raises all the same, as while it starts, and how often.
    raised: Vec<Vec<(String, u64)>>,
}

impl Moments {
    /// Of a run that is made for it.
    ///
    /// # Errors
    /// [`Failure::Refused`] when it cannot be built.
    pub fn find(scenario: &Scenario, plans: &Plans, seed: u64) -> Result<Self, Failure> {
        let stepped = Stepped::new(scenario, plans, seed, true, false)?;
        let mut run = Run::new(scenario.clone(), stepped, seed);
        let ending = run.run_to_end(true, &AtomicBool::new(false));
        if let Ending::BrokenOff(why) = &ending {
            let why = format_args!("seed {seed}: the run without faults broke off: {why}");
            return Err(Failure::failed(why));
        }
        run.stop();
        let times = |robot: usize, is: &dyn Fn(&PathPoint) -> bool| -> Vec<f64> {
            let points = run.tracks()[robot].path.points().iter();
            { points.filter(|point| is(point)) }
                .map(|point| point.at_s)
                .collect()
        };
        let robots = 0..run.tracks().len();
        let driving = |robot| times(robot, &|point| point.speed_m_s.abs() > DRIVING_M_S);
        let driving_s = robots.clone().map(driving).collect();
        let docked = |robot: usize| {
            let goal = &scenario.robots[robot].goal;
            times(robot, &|point| is_docked(goal, point))
        };
        let docked_s = robots.map(docked).collect();
        let robots = record(&run, &ending).summary.robots.into_iter();
        let raised = robots.map(|robot| robot.faults).collect();
        Ok(Self {
            driving_s,
            docked_s,
            raised,
        })
    }

    /// Which faults of the robots' table were raised in a run of the same seed, and not without what went wrong in it.
    #[must_use]
    pub fn raised_besides<'a>(&self, run: &'a Summary) -> BTreeSet<&'a str> {
        let before = |robot: usize, name: &str| {
            let own = self.raised.get(robot).into_iter().flatten();
            own.filter(|(own, _)| own == name)
                .map(|(_, count)| *count)
                .sum::<u64>()
        };
        { run.robots.iter().enumerate() }
            .flat_map(|(robot, own)| {
                own.faults
                    .iter()
                    .map(move |(name, count)| (robot, name, *count))
            })
            .filter(|(robot, name, count)| *count > before(*robot, name))
            .map(|(_, name, _)| name.as_str())
            .collect()
    }

    /// Those of a robot that does this; none: it never does.
    fn of(&self, robot: usize, does: Does) -> Option<&[f64]> {
        let all = match does {
            Does::Drive => &self.driving_s,
            Does::Dock => &self.docked_s,
        };
        let own = all.get(robot).map(Vec::as_slice);
        own.filter(|moments| !moments.is_empty())
    }
}

/// Whether a robot with this goal stands where it is to.
fn is_docked(goal: &Goal, point: &PathPoint) -> bool {
    let Goal::Places(places) = goal else {
        return false;
    };
    let at = Point2::new(point.pose.x_m, point.pose.y_m);
    let docks = { places.stops() }.filter(|stop| stop.stands_s > 0.0);
    point.speed_m_s.abs() < STANDING_M_S && docks.into_iter().any(|stop| stop.region.contains(at))
}

/// The moments of seeds, each found once.
#[derive(Debug, Default)]
pub struct MomentsOfSeeds(Mutex<BTreeMap<u64, Moments>>);

impl MomentsOfSeeds {
    /// Those of a seed.
    ///
    /// # Errors
    /// As [`Moments::find`].
    pub fn of(&self, scenario: &Scenario, plans: &Plans, seed: u64) -> Result<Moments, Failure> {
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known().get(&seed).cloned() {
            return Ok(found);
        }
        let found = Moments::find(scenario, plans, seed)?;
        known().insert(seed, found.clone());
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn every_case_is_drawn_while_its_robot_drives_and_fits_the_scenario() {
        let scenario = testing::scenario("overtaking");
        let moments = |driving_s: Vec<Vec<f64>>| Moments {
            docked_s: driving_s.clone(),
            driving_s,
            raised: Vec::new(),
        };
        let nobody = moments(vec![vec![], vec![]]);
        let moments = moments(vec![vec![10.0, 10.02], vec![20.0]]);
        let known: Vec<_> = { scenario.robots.iter() }
            .map(crate::scenario::Player::threads)
            .collect();
        let cases = Case::all(&scenario);
        assert_eq!(cases.len(), ScriptedKind::all().count() + 2 * 6 + 1);
        for case in &cases {
            for seed in 0..20 {
                let fault = case.draw(&scenario, seed, &moments).expect("they drive");
                assert_eq!(fault.complaints(&known), Vec::<String>::new(), "{fault}");
                let first = fault.robot.as_deref() == Some("amr-1");
                let second = fault.robot.as_deref() == Some("amr-2");
                assert!(fault.at_s < 10.03 && !second || fault.at_s == 20.0 && !first);
                assert_eq!(Some(fault), case.draw(&scenario, seed, &moments));
            }
        }
        let pair = Case::draw_pair([&cases[0], &cases[7]], &scenario, 3, &moments);
        let [one, other] = pair.expect("they drive");
        assert!((one.at_s..=one.until_s()).contains(&other.at_s));
        assert_eq!(cases[0].draw(&scenario, 3, &nobody), None);
    }
}
