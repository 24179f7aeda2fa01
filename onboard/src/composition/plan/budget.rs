//! How late a stop may begin, whoever hangs, and whether the motion tubes have planned for it.
//!
//! A motion tube is free for the way that the robot needs to stand: `tubes.reaction_s` at its speed, and the braking way at
//! `drive.stop_deceleration_m_s2`. How old the scan is, each evaluation counts for itself. What can be late after that must lie
//! inside: the next evaluation, the threads that pass the command on, the timeouts that replace one that hangs, and what the
//! wheels do when their drive hears nothing more.

use std::fmt;
use std::time::Duration;

use description::keys::{KeyError, KeyErrors};
use description::robot::URG_04LX_HZ;
use description::threads::{ActivityKind, ThreadConfig, Trigger};

use super::contents::Plan;

/// A tube that is exactly long enough is.
const ROUNDING_M: f64 = 1e-9;
/// What is kept from everything is for what scans and steps leave out; of this part of it wheels may make use that do not obey.
const WHEELS_SHARE: f64 = 0.5;
/// Without so many scans a robot that sees nothing drives on, at most.
const MOST_SCANS: u32 = 5;

/// Something that may hang, and what passes until the wheels brake.
#[derive(Clone, Debug, PartialEq)]
pub struct Lateness {
    /// Who.
    pub who: &'static str,
    /// What passes one after the other, by key.
    pub parts: Vec<(String, Duration)>,
    /// Deceleration from then on, m/s², and its key.
    pub braking: (&'static str, f64),
}

impl Lateness {
    /// The sum of its parts.
    #[must_use]
    pub fn delay(&self) -> Duration {
        self.parts.iter().map(|(_, time)| *time).sum()
    }

    /// The way to a stand.
    #[must_use]
    pub fn way_m(&self, speed_m_s: f64) -> f64 {
        way_m(speed_m_s, self.delay().as_secs_f64(), self.braking.1)
    }
}

impl fmt::Display for Lateness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, (key, time)) in self.parts.iter().enumerate() {
            let plus = if number == 0 { "" } else { " + " };
            write!(f, "{plus}{key} {}", ms(*time))?;
        }
        let (key, deceleration_m_s2) = self.braking;
        write!(f, ", then {key} {deceleration_m_s2}")
    }
}

/// What the tubes plan with, and what can happen.
#[derive(Clone, Debug, PartialEq)]
pub struct Budget {
    /// The fastest that a tube allows.
    pub speed_m_s: f64,
    /// What the tubes plan with.
    pub planned: Lateness,
    /// What can happen.
    pub cases: Vec<Lateness>,
    /// How far wheels may move beyond what they were told, `drive.following_error_m`, and farther where they are left without power
    /// then (`drive.emergency_bits`); and what of the room that is kept from everything is for that.
    pub wheels_m: [f64; 2],
    /// They are left without power then.
    pub coasts: bool,
    /// Without scans the robot stops after this time. Each evaluation counts how old its scan is.
    pub unseen: Duration,
}

impl Budget {
    /// That of a plan's files.
    #[must_use]
    pub fn of(plan: &Plan) -> Self {
        let (drive, tubes) = (&plan.robot.drive, &plan.robot.tubes);
        let stop = (
            "drive.stop_deceleration_m_s2",
            drive.limits.stop_deceleration_m_s2,
        );
        let unpowered = (
            "drive.unpowered_deceleration_m_s2",
            drive.unpowered_deceleration_m_s2,
        );
        let part = |key: &str, ms: u32| (key.to_owned(), Duration::from_millis(u64::from(ms)));
        let [adapts, controls, exchanges] = [
            ActivityKind::MotionTube,
            ActivityKind::Control,
            ActivityKind::Drive,
        ]
        .map(|kind| longest_pause(&plan.robot.threads, kind));
        // Frames that are lost hold up what is told to the wheels, and nobody is told of it so soon.
        let lost = part("drive.hold_ms", drive.hold_ms);
        let wheels = part("drive.lag_ms", drive.lag_ms);
        let case = |who, braking, parts: &[&(String, Duration)]| Lateness {
            who,
            parts: parts.iter().map(|&part| part.clone()).collect(),
            braking,
        };
        let command = part(
            "control.command_timeout_ms",
            plan.robot.control.command_timeout_ms,
        );
        let setpoint = part("drive.setpoint_timeout_ms", drive.setpoint_timeout_ms);
        let watchdog = part("ethercat.watchdog_ms", plan.robot.ethercat.watchdog_ms);
        let reaction_s = tubes.adapt.reaction_s;
        let speed_m_s = tubes.fastest_m_s().min(drive.limits.max_speed_m_s);
        // Wheels that do not obey are left to the drive, without power.
        let coasts_m = if drive.emergency_bits {
            (way_m(speed_m_s, 0.0, unpowered.1) - way_m(speed_m_s, 0.0, stop.1)).max(0.0)
        } else {
            0.0
        };
        Self {
            speed_m_s,
            planned: Lateness {
                who: "planned by the tubes",
                parts: vec![(
                    "tubes.reaction_s".to_owned(),
                    Duration::from_secs_f64(reaction_s),
                )],
                braking: stop,
            },
            cases: vec![
                case(
                    "nobody hangs",
                    stop,
                    &[&adapts, &controls, &exchanges, &lost, &wheels],
                ),
                case(
                    "motion tubes hang",
                    stop,
                    &[&command, &controls, &exchanges, &lost, &wheels],
                ),
                case(
                    "control hangs",
                    stop,
                    &[&adapts, &setpoint, &exchanges, &lost, &wheels],
                ),
                case(
                    "the drive or its bus hangs",
                    unpowered,
                    &[&adapts, &controls, &watchdog],
                ),
                // Where the drive brakes harder by itself than it is told to.
                case(
                    "the drive hangs for a moment",
                    stop,
                    &[&adapts, &controls, &exchanges, &watchdog, &wheels],
                ),
            ],
            wheels_m: [
                drive.following_error_m + coasts_m,
                WHEELS_SHARE * least_room(plan).1,
            ],
            coasts: drive.emergency_bits,
            unseen: Duration::from_millis(u64::from(plan.robot.lidar.scan_timeout_ms)),
        }
    }

    /// The longest time until the wheels brake, whatever hangs.
    pub(super) fn longest_delay(&self) -> Duration {
        let delays = self.cases.iter().map(Lateness::delay);
        delays.max().unwrap_or_default()
    }

    /// Whether all that can happen was planned.
    ///
    /// # Errors
    /// The keys that do not fit together.
    pub fn check(plan: &Plan) -> Result<Self, KeyErrors> {
        let budget = Self::of(plan);
        let mut errors = Vec::new();
        let planned_m = budget.planned.way_m(budget.speed_m_s);
        let speed_m_s = budget.speed_m_s;
        let worst = budget.cases.iter().max_by(|one, other| {
            let way_m = |case: &Lateness| case.way_m(speed_m_s);
            way_m(one).total_cmp(&way_m(other))
        });
        if let Some(case) = worst.filter(|case| case.way_m(speed_m_s) > planned_m + ROUNDING_M) {
            let way_m = case.way_m(speed_m_s);
            let braking_m = speed_m_s.powi(2) / (2.0 * budget.planned.braking.1);
            let needed_ms = ((way_m - braking_m) / speed_m_s * 1e3).ceil();
            errors.push(KeyError::new(
                "tubes.reaction_s",
                format!(
                    "{} s, with which the robot stands within {planned_m:.3} m from {speed_m_s} m/s",
                    plan.robot.tubes.adapt.reaction_s
                ),
                format!(
                    "at least {} s, since it takes {way_m:.3} m when {}: {case}",
                    needed_ms * 1e-3,
                    case.who
                ),
            ));
        }
        let [found_m, most_m] = budget.wheels_m;
        if found_m > most_m + ROUNDING_M {
            let following_m = plan.robot.drive.following_error_m;
            let coasts_m = found_m - following_m;
            let room = format!("at most {most_m:.3}, half of {}", least_room(plan).0);
            let expected = if budget.coasts {
                format!(
                    "{room}, also with the {coasts_m:.3} that wheels without power roll farther (drive.emergency_bits)"
                )
            } else {
                room
            };
            errors.push(KeyError::new(
                "drive.following_error_m",
                following_m.to_string(),
                expected,
            ));
        }
        errors.extend(too_short(plan));
        errors.extend(unseen_too_long(plan));
        KeyErrors::any(errors)?;
        Ok(budget)
    }
}

/// The least room that the tubes keep from everything, with its key.
fn least_room(plan: &Plan) -> (&'static str, f64) {
    let parameters = &plan.robot.tubes;
    let (own_m, by_hand_m) = (parameters.augment_m, parameters.by_hand_augment_m);
    if by_hand_m < own_m {
        ("tubes.by_hand_augment_m", by_hand_m)
    } else {
        ("tubes.augment_m", own_m)
    }
}

/// From one scan to the next.
fn scan_period(plan: &Plan) -> Duration {
    Duration::from_secs_f64(f64::from(1 + plan.robot.lidar.skip) / URG_04LX_HZ)
}

/// A robot that sees nothing must not drive on for long.
fn unseen_too_long(plan: &Plan) -> Option<KeyError> {
    let found_ms = plan.robot.lidar.scan_timeout_ms;
    let most = scan_period(plan) * MOST_SCANS;
    (Duration::from_millis(u64::from(found_ms)) > most).then(|| {
        let expected = format!("at most {MOST_SCANS} scans, {}", ms(most));
        KeyError::new("lidar.scan_timeout_ms", found_ms.to_string(), expected)
    })
}

/// Timeouts that a thread which keeps its time would run into.
fn too_short(plan: &Plan) -> Vec<KeyError> {
    let (robot, threads) = (&plan.robot, &plan.robot.threads);
    let pause = |kind| longest_pause(threads, kind);
    let ms = |ms: u32| Duration::from_millis(u64::from(ms));
    let scans = ("a scan".to_owned(), scan_period(plan));
    let pairs = [
        (
            "control.command_timeout_ms",
            robot.control.command_timeout_ms,
            2,
            pause(ActivityKind::MotionTube),
        ),
        (
            "drive.setpoint_timeout_ms",
            robot.drive.setpoint_timeout_ms,
            2,
            pause(ActivityKind::Control),
        ),
        (
            "lidar.scan_timeout_ms",
            robot.lidar.scan_timeout_ms,
            2,
            scans,
        ),
    ];
    let bad = pairs
        .into_iter()
        .filter(|(_, timeout, times, (_, each))| ms(*timeout) < *each * *times);
    bad.map(|(key, timeout, times, (what, each))| {
        let expected = format!("at least {times} times {what}, {}", self::ms(each * times));
        KeyError::new(key, format!("{timeout}"), expected)
    })
    .collect()
}

fn way_m(speed_m_s: f64, delay_s: f64, deceleration_m_s2: f64) -> f64 {
    speed_m_s * delay_s + speed_m_s.powi(2) / (2.0 * deceleration_m_s2)
}

/// The longest time from one evaluation of an activity to the next, with its key; none for one that no table has.
pub(super) fn longest_pause(threads: &[ThreadConfig], kind: ActivityKind) -> (String, Duration) {
    let thread = threads
        .iter()
        .find(|thread| thread.activities.contains(&kind));
    let Some(thread) = thread else {
        return (kind.name().to_owned(), Duration::ZERO);
    };
    let (key, pause) = match thread.trigger {
        Trigger::Period { period } => ("period_us", period),
        Trigger::Scan { at_least } => ("at_least_ms", at_least),
        Trigger::Lidar | Trigger::Async => ("trigger", Duration::ZERO),
    };
    (format!("threads.{}.{key}", thread.name), pause)
}

/// In milliseconds, as people write it.
pub(super) fn ms(time: Duration) -> String {
    format!("{} ms", time.as_secs_f64() * 1e3)
}

impl fmt::Display for Budget {
    /// Line by line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "to a stand from {} m/s, in m and ms", self.speed_m_s)?;
        for case in std::iter::once(&self.planned).chain(&self.cases) {
            let (way_m, delay_ms) = (case.way_m(self.speed_m_s), case.delay().as_secs_f64() * 1e3);
            write!(f, "\n{:<28} {way_m:.3} {delay_ms:>6}  {case}", case.who)?;
        }
        let unseen_ms = self.unseen.as_secs_f64() * 1e3;
        write!(
            f,
            "\n{:<28}       {unseen_ms:>6}  lidar.scan_timeout_ms; each evaluation counts how old its scan is",
            "no scan comes"
        )?;
        let [found_m, most_m] = self.wheels_m;
        write!(
            f,
            "\n{:<28} {found_m:.3}         {}, of {most_m:.3} that the tubes keep from everything for it",
            "wheels do not obey",
            if self.coasts {
                "drive.following_error_m, and farther without power (drive.emergency_bits)"
            } else {
                "drive.following_error_m"
            }
        )
    }
}
