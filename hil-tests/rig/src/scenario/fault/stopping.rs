//! What faults mean for how a robot stops, by the robot's own files.

use config::RobotConfig;
use description::threads::{ActivityKind, ThreadConfig, Trigger};

use super::{SUPERVISOR, ScriptedFault, ScriptedKind};

/// A supervisor that is silent for this long stops the robot.
const SUPERVISOR_SILENT_S: f64 = 1.0;
/// A supervisor that judges its threads once a second finds one that hangs after two of these at the latest.
const HANG_FOUND_S: f64 = 2.0;
/// Requests of operators wait for up to this, and what a supervisor finds out.
const SERVED_WITHIN_S: f64 = 0.1;
/// What the drive says of itself is believed after this time,
const BELIEVED_S: f64 = 0.05;
/// and that its sensors stand still after this.
const STALLED_S: f64 = 0.2;
/// Five scans that are the same are none; one more may just have begun to be taken in.
const FROZEN_S: f64 = 0.6;
/// A lidar that is connected anew needs so long at least, good scans included.
const CONNECTED_ANEW_S: f64 = 1.0;
/// A thread that panics does so within this time: the lidar's waits for a turn of it.
const PANICS_WITHIN_S: f64 = 0.12;
/// A process that ends is started again so much later: `RestartSec=` of the robot's service.
pub(crate) const STARTED_AGAIN_S: f64 = 2.0;
/// On a computer that is overloaded each wake-up of the thread that controls the wheels is late by up to this.
pub(crate) const OVERLOADED_BY_S: f64 = 0.1;
/// The Earth's pull, m/s².
pub const GRAVITY_M_S2: f64 = 9.81;
/// At least this share of frames or scans is all of them.
const ALL: f64 = 1.0;
/// A command goes through so many threads that may each be late.
const THREADS: f64 = 3.0;

/// What a fault means for how its robot stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stopping {
    /// So long after it began the robot's commands are invalid, and it must brake; none: it need not stop.
    pub after_s: Option<f64>,
    /// That time runs only while the robot drives: nothing shows while it stands.
    pub shows_driving: bool,
    /// Only a process that drove the robot when it began must stop it: one that starts meanwhile never had what hangs.
    pub lost_driving: bool,
    /// It goes on by itself after so long, though the fault lasts.
    pub stops_for_s: f64,
    /// A stop for something else begins later by up to this.
    pub delays_s: f64,
    /// When it begins, the wheels go on for so long as they were told last.
    pub holds_s: f64,
    /// The hardest that the robot can brake meanwhile, m/s².
    pub deceleration_m_s2: f64,
    /// How hard the floor pulls at the robot meanwhile, against what brakes it without power, m/s².
    pub pull_m_s2: f64,
    /// Whoever would stop the robot for something else is not there, and notices it afterwards.
    pub disables: bool,
    /// When what it does to the robot is over.
    pub until_s: f64,
}

impl ScriptedFault {
    /// What it means for this robot.
    #[must_use]
    pub fn stopping(&self, robot: &RobotConfig) -> Stopping {
        let seconds = |ms: u32| f64::from(ms) / 1e3;
        let limits = &robot.drive.limits;
        let goes_on = Stopping {
            after_s: None,
            shows_driving: false,
            lost_driving: false,
            stops_for_s: f64::INFINITY,
            delays_s: 0.0,
            holds_s: 0.0,
            deceleration_m_s2: limits.stop_deceleration_m_s2,
            pull_m_s2: 0.0,
            disables: false,
            until_s: self.until_s(),
        };
        let brakes = |after_s| Stopping {
            after_s: Some(after_s),
            ..goes_on
        };
        let unpowered_m_s2 = robot.drive.unpowered_deceleration_m_s2;
        let coasting = Stopping {
            deceleration_m_s2: unpowered_m_s2.min(limits.stop_deceleration_m_s2),
            ..goes_on
        };
        let coasts = |after_s| Stopping {
            after_s: Some(after_s),
            ..coasting
        };
        let by_tubes = |after_s| brakes(after_s + tubes_period_s(robot));
        let watchdog_s = seconds(robot.ethercat.watchdog_ms);
        let unseen_s = seconds(robot.lidar.scan_timeout_ms);
        let share = self.share.unwrap_or(0.0);
        let by_s = self.by_s.unwrap_or(0.0);
        let alone = Stopping {
            disables: true,
            holds_s: watchdog_s,
            ..coasts(watchdog_s)
        };
        match self.what {
            ScriptedKind::KillRobot | ScriptedKind::RebootRobot | ScriptedKind::Sleep => alone,
            // Without its network it may drive once its next process runs, but not without its note.
            ScriptedKind::LoseNetwork => Stopping {
                stops_for_s: STARTED_AGAIN_S - watchdog_s,
                until_s: self.at_s + STARTED_AGAIN_S,
                ..alone
            },
            ScriptedKind::FillDisk => Stopping {
                until_s: self.until_s().max(self.at_s + STARTED_AGAIN_S),
                ..alone
            },
            ScriptedKind::Hang => match self.hung(robot) {
                Hung::All | Hung::Activity(ActivityKind::Drive) => alone,
                Hung::Activity(ActivityKind::Control) => Stopping {
                    disables: true,
                    holds_s: seconds(robot.drive.setpoint_timeout_ms),
                    ..brakes(seconds(robot.drive.setpoint_timeout_ms))
                },
                Hung::Activity(ActivityKind::MotionTube) => Stopping {
                    disables: true,
                    holds_s: seconds(robot.control.command_timeout_ms),
                    ..brakes(seconds(robot.control.command_timeout_ms))
                },
                Hung::Activity(ActivityKind::Lidar) => by_tubes(unseen_s),
                // A fleet network that cannot be reached keeps no robot from starting.
                Hung::Activity(_) => Stopping {
                    lost_driving: true,
                    ..by_tubes(HANG_FOUND_S + SERVED_WITHIN_S)
                },
                Hung::Supervisor => Stopping {
                    disables: true,
                    ..by_tubes(SUPERVISOR_SILENT_S)
                },
            },
            ScriptedKind::LateThreads => {
                let threads = if self.thread.is_some() { 1.0 } else { THREADS };
                Stopping {
                    delays_s: threads * by_s,
                    holds_s: threads * by_s,
                    ..coasting
                }
            }
            ScriptedKind::Overload => Stopping {
                delays_s: OVERLOADED_BY_S,
                holds_s: OVERLOADED_BY_S,
                disables: true,
                deceleration_m_s2: coasting.deceleration_m_s2,
                ..by_tubes(SUPERVISOR_SILENT_S + OVERLOADED_BY_S)
            },
            ScriptedKind::CutPower | ScriptedKind::CutMotors => coasts(0.0),
            ScriptedKind::HotMotor => coasts(BELIEVED_S),
            ScriptedKind::LowVoltage => brakes(BELIEVED_S),
            ScriptedKind::FreezeSensors => Stopping {
                shows_driving: true,
                ..brakes(STALLED_S)
            },
            // Its process ends when it stands, and its drive holds it until its watchdog lets it stand without power.
            ScriptedKind::Panic => brakes(PANICS_WITHIN_S),
            ScriptedKind::EndRobot => by_tubes(SERVED_WITHIN_S),
            ScriptedKind::LoseInterface => alone,
            ScriptedKind::LoseFrames | ScriptedKind::RefuseFrames if share >= ALL => alone,
            ScriptedKind::LoseFrames | ScriptedKind::RefuseFrames => Stopping {
                delays_s: watchdog_s,
                holds_s: watchdog_s,
                ..coasting
            },
            // Its wheels coast until the bus is up again.
            ScriptedKind::LeaveOp => Stopping {
                until_s: self.at_s + robot.ethercat.bring_up_s,
                ..coasting
            },
            ScriptedKind::BreakScans if share >= ALL => by_tubes(unseen_s),
            ScriptedKind::DelayScans if by_s > unseen_s => by_tubes(unseen_s),
            // The last good scan comes later.
            ScriptedKind::DelayScans => Stopping {
                delays_s: by_s,
                ..goes_on
            },
            ScriptedKind::CoverLidar | ScriptedKind::Unplug => by_tubes(unseen_s),
            // A source that repeats itself is found, and connected anew, after which it may go on.
            ScriptedKind::FreezeScans => Stopping {
                stops_for_s: CONNECTED_ANEW_S,
                ..by_tubes(FROZEN_S + unseen_s)
            },
            // It never sees for long enough to drive on.
            ScriptedKind::FreezeLidar => by_tubes(FROZEN_S + unseen_s),
            ScriptedKind::Stop => by_tubes(SERVED_WITHIN_S),
            ScriptedKind::Pause => Stopping {
                deceleration_m_s2: limits.deceleration_m_s2,
                ..by_tubes(SERVED_WITHIN_S)
            },
            ScriptedKind::Slip | ScriptedKind::WeakBrakes => Stopping {
                deceleration_m_s2: limits.stop_deceleration_m_s2 * (1.0 - share),
                ..goes_on
            },
            ScriptedKind::Slope => Stopping {
                pull_m_s2: share.abs() * GRAVITY_M_S2,
                ..goes_on
            },
            // It pulls where it should brake.
            ScriptedKind::ReverseMotor => Stopping {
                deceleration_m_s2: 0.0,
                ..goes_on
            },
            _ => goes_on,
        }
    }

    /// Whether a process of its robot ends with it, and another one starts.
    #[must_use]
    pub fn ends_process(&self) -> bool {
        matches!(
            self.what,
            ScriptedKind::KillRobot
                | ScriptedKind::RebootRobot
                | ScriptedKind::EndRobot
                | ScriptedKind::Panic
                | ScriptedKind::LoseNetwork
                | ScriptedKind::FillDisk
        )
    }

    /// What hangs of this robot.
    fn hung(&self, robot: &RobotConfig) -> Hung {
        let Some(name) = &self.thread else {
            return Hung::All;
        };
        if name == SUPERVISOR {
            return Hung::Supervisor;
        }
        let threads = robot.threads.iter().filter(|thread| thread.name == *name);
        let activities = threads.flat_map(|thread| &thread.activities);
        // What is nearest to the wheels counts.
        let chain = [
            ActivityKind::Drive,
            ActivityKind::Control,
            ActivityKind::MotionTube,
            ActivityKind::Lidar,
        ];
        let activities: Vec<ActivityKind> = activities.copied().collect();
        let first = { chain.into_iter() }.find(|kind| activities.contains(kind));
        Hung::Activity(first.unwrap_or(ActivityKind::Communication))
    }
}

/// How long it may take until the motion tubes look again.
fn tubes_period_s(robot: &RobotConfig) -> f64 {
    let has_tubes = |thread: &&ThreadConfig| thread.activities.contains(&ActivityKind::MotionTube);
    let thread = robot.threads.iter().find(has_tubes);
    thread.map_or(0.0, |thread| match thread.trigger {
        Trigger::Period { period } => period.as_secs_f64(),
        Trigger::Scan { at_least } => at_least.as_secs_f64(),
        Trigger::Lidar | Trigger::Async => 0.0,
    })
}

/// What hangs.
enum Hung {
    All,
    /// A thread with this activity.
    Activity(ActivityKind),
    Supervisor,
}
