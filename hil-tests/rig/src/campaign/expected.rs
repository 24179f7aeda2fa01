//! What robots must raise for each kind of fault: without it a kind that does nothing would pass every campaign.

use onboard::symbols::faults::Fault;

use super::cases::Case;
use crate::scenario::{SUPERVISOR, ScriptedFault, ScriptedKind};

/// A run that ends sooner after a fault need not have heard of it.
const SAID_WITHIN_S: f64 = 1.0;

/// What is expected of the runs of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Expected {
    /// One of these, in one at least of the runs in which it can show.
    Raised(&'static [Fault], Shows),
    /// Nothing that robots say.
    Nothing(Why),
}

/// From when a fault can show, whatever the robot does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shows {
    /// It lasts for at least this long,
    for_s: f64,
    /// and has at least this share, where it has one.
    share: f64,
}

/// Why robots may say nothing of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Why {
    /// Robots wait or are told again, as every day: levels are repeated, and doors are closed.
    Everyday,
    /// They go on as if nothing were: within what they are made for.
    Borne,
    /// Whether it shows hangs on the moment.
    Chance,
}

const fn after(for_s: f64) -> Shows {
    Shows { for_s, share: 0.0 }
}

/// What is expected of a case.
pub(super) fn expected(case: &Case) -> Expected {
    use Expected::{Nothing, Raised};
    let all = Shows {
        for_s: 1.0,
        share: 1.0,
    };
    match case.what {
        ScriptedKind::Lose => Raised(&[Fault::MediatorSilent], Shows { for_s: 2.0, ..all }),
        ScriptedKind::Partition
        | ScriptedKind::KillMediator
        | ScriptedKind::RebootMediator
        | ScriptedKind::HangMediator
        | ScriptedKind::LoseJournal
        | ScriptedKind::FullDisk => Raised(&[Fault::MediatorSilent], after(2.5)),
        // It lasts until the robot opens another session.
        ScriptedKind::DeadLink => Raised(&[Fault::MediatorSilent], after(0.0)),
        ScriptedKind::SecondMediator | ScriptedKind::CopiedMediator => {
            Raised(&[Fault::SecondMediator], after(1.0))
        }
        ScriptedKind::CloneRobot => Raised(&[Fault::IdentityDoubled], after(6.0)),
        ScriptedKind::KillRobot | ScriptedKind::EndRobot => {
            Raised(&[Fault::ScanSilent], after(0.0))
        }
        ScriptedKind::Panic => Raised(&[Fault::Panic, Fault::ScanSilent], after(0.0)),
        ScriptedKind::RebootRobot => Raised(&[Fault::PlaceUnknown], after(0.0)),
        ScriptedKind::Hang => hangs(case.thread.as_deref()),
        ScriptedKind::LoseFrames | ScriptedKind::RefuseFrames => Raised(&[Fault::BusLost], all),
        ScriptedKind::LoseInterface | ScriptedKind::CutPower => {
            Raised(&[Fault::BusLost], after(1.0))
        }
        ScriptedKind::LeaveOp => Raised(&[Fault::BusLost], after(0.0)),
        ScriptedKind::CutMotors => Raised(&[Fault::MotorsOff], after(0.3)),
        ScriptedKind::LowVoltage => Raised(&[Fault::BusVoltage], after(0.3)),
        ScriptedKind::HotMotor => Raised(&[Fault::DriveFault], after(0.3)),
        ScriptedKind::FreezeSensors => Raised(&[Fault::DriveStalled], after(0.5)),
        ScriptedKind::StickEncoder => Raised(&[Fault::EncoderBroken], after(1.0)),
        ScriptedKind::JamPivot | ScriptedKind::ReverseMotor => {
            Raised(&[Fault::WheelsDisobey], after(1.0))
        }
        ScriptedKind::BreakScans => Raised(&[Fault::ScanBroken], all),
        ScriptedKind::Slip => {
            let far = Shows {
                for_s: 6.0,
                share: 0.25,
            };
            Raised(&[Fault::WheelSlip, Fault::WheelsDisobey], far)
        }
        ScriptedKind::AgeScans => {
            // By more than half a second.
            let late = Shows {
                for_s: 9.0,
                share: 0.06,
            };
            Raised(&[Fault::LidarLost, Fault::ScanSilent], late)
        }
        ScriptedKind::FreezeScans => Raised(&[Fault::LidarLost], after(2.0)),
        ScriptedKind::CoverLidar => Raised(&[Fault::LidarBlind], after(1.0)),
        ScriptedKind::Unplug => Raised(&[Fault::LidarLost, Fault::ScanSilent], after(0.5)),
        ScriptedKind::Stop => Raised(&[Fault::OperatorStop], after(0.3)),
        ScriptedKind::Repeat
        | ScriptedKind::CloseAreas
        | ScriptedKind::ClearAreas
        | ScriptedKind::EndCoordination
        | ScriptedKind::RestoreJournal
        | ScriptedKind::Pause
        | ScriptedKind::Teleop
        | ScriptedKind::Reset
        | ScriptedKind::Place
        | ScriptedKind::Reload
        | ScriptedKind::Absent => Nothing(Why::Everyday),
        ScriptedKind::Drift | ScriptedKind::Load | ScriptedKind::Slope => Nothing(Why::Borne),
        ScriptedKind::Delay
        | ScriptedKind::SlowDisk
        | ScriptedKind::LateThreads
        | ScriptedKind::WeakBrakes
        | ScriptedKind::Person
        | ScriptedKind::Box
        | ScriptedKind::DelayScans => Nothing(Why::Chance),
    }
}

/// What is said of one thread that hangs, or of all.
fn hangs(thread: Option<&str>) -> Expected {
    match thread {
        // Whoever would say so hangs as well, and finds afterwards what has come of it.
        None => Expected::Raised(&[Fault::SetpointStale, Fault::BusLost], after(1.0)),
        Some(SUPERVISOR) => Expected::Raised(&[Fault::SupervisorSilent], after(1.5)),
        Some(_) => Expected::Raised(&[Fault::ThreadHung], after(2.5)),
    }
}

impl Expected {
    /// Which of these a row has not raised, of runs that took so many seconds, each with its fault; none: it has raised one, or need not.
    pub(super) fn missing<'a>(
        self,
        mut runs: impl Iterator<Item = (f64, &'a ScriptedFault)>,
        raised: &[(String, usize)],
    ) -> Option<&'static [Fault]> {
        let Self::Raised(any_of, shows) = self else {
            return None;
        };
        let must = runs.any(|(duration_s, fault)| {
            let share = fault.share.map_or(1.0, f64::abs);
            let in_time = duration_s >= fault.until_s() + SAID_WITHIN_S;
            fault.for_s >= shows.for_s && share >= shows.share && in_time
        });
        let was = |fault: &Fault| raised.iter().any(|(name, _)| name == fault.name());
        (must && !any_of.iter().any(was)).then_some(any_of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(what: ScriptedKind) -> Case {
        Case { what, thread: None }
    }

    #[test]
    fn a_fault_that_can_show_and_is_never_raised_is_missing() {
        let unplug = |for_s: f64| {
            let text =
                format!("at_s = 1.0\nfor_s = {for_s:?}\nwhat = \"unplug\"\nrobot = \"amr-1\"");
            toml::from_str::<ScriptedFault>(&text).expect("a fault")
        };
        let raised = [("lidar-lost".to_owned(), 1)];
        let missing = |for_s: &[f64], raised: &[(String, usize)]| {
            let faults: Vec<ScriptedFault> = for_s.iter().map(|for_s| unplug(*for_s)).collect();
            let runs = faults.iter().map(|fault| (10.0, fault));
            expected(&case(ScriptedKind::Unplug)).missing(runs, raised)
        };
        assert_eq!(missing(&[0.3, 4.0], &raised), None);
        assert_eq!(missing(&[0.3], &[]), None, "too short to show");
        let both = [Fault::LidarLost, Fault::ScanSilent];
        assert_eq!(missing(&[0.3, 4.0], &[]), Some(&both[..]));
        let other = [("bus-lost".to_owned(), 3)];
        assert_eq!(missing(&[4.0], &other), Some(&both[..]));
        assert_eq!(missing(&[8.5], &[]), None, "the run was over");
        let reload = expected(&case(ScriptedKind::Reload));
        assert_eq!(
            reload.missing([(10.0, &unplug(4.0))].into_iter(), &[]),
            None
        );
    }

    #[test]
    fn most_kinds_must_show() {
        let silent = ScriptedKind::all()
            .filter(|what| matches!(expected(&case(*what)), Expected::Nothing(_)));
        assert_eq!(silent.count(), 21);
    }
}
