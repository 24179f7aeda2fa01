//! What robots must raise for each kind of fault: without it a kind that does nothing would pass every campaign.

use std::collections::BTreeSet;

use onboard::symbols::faults::Fault;

use super::cases::{Case, Does};
use crate::scenario::{SUPERVISOR, ScriptedFault, ScriptedKind};

/// A run that ends sooner after a fault need not have heard of it.
const SAID_WITHIN_S: f64 = 1.0;

/// What is expected of the runs of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Expected {
    /// One of these, in the runs in which it can show.
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
    in_runs: In,
}

/// In how many of the runs in which it can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum In {
    /// In each.
    Each,
    /// In one at least: in others the robot stands meanwhile, or is about to.
    One,
}

/// A run with one fault, and what robots said.
#[derive(Clone, Debug)]
pub(super) struct Said<'a> {
    pub(super) seed: u64,
    pub(super) duration_s: f64,
    pub(super) fault: &'a ScriptedFault,
    pub(super) raised: BTreeSet<&'a str>,
}

/// What was not raised.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Missing {
    /// One of these,
    pub(super) any_of: &'static [Fault],
    /// in the runs of these seeds.
    pub(super) silent: Vec<u64>,
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
    Shows {
        for_s,
        share: 0.0,
        in_runs: In::Each,
    }
}

const fn sometimes(shows: Shows) -> Shows {
    Shows {
        in_runs: In::One,
        ..shows
    }
}

/// What is expected of a case.
pub(super) fn expected(case: &Case) -> Expected {
    use Expected::{Nothing, Raised};
    let all = Shows {
        share: 1.0,
        ..after(1.0)
    };
    match case.what {
        // Its next one begins where it ended, and is to back out.
        _ if case.does == Does::Dock => Raised(&[Fault::FloorUnknown], after(0.0)),
        ScriptedKind::Lose => Raised(&[Fault::MediatorSilent], Shows { for_s: 2.0, ..all }),
        ScriptedKind::Partition
        | ScriptedKind::KillMediator
        | ScriptedKind::RebootMediator
        | ScriptedKind::HangMediator
        | ScriptedKind::LoseJournal => Raised(&[Fault::MediatorSilent], after(2.5)),
        // Unless there is nothing to write meanwhile.
        ScriptedKind::FullDisk => Raised(&[Fault::MediatorSilent], sometimes(after(2.5))),
        // It lasts until the robot opens another session.
        ScriptedKind::DeadLink => Raised(&[Fault::MediatorSilent], after(0.0)),
        // Its process is killed, and the next one begins by then.
        ScriptedKind::LoseNetwork => Raised(&[Fault::FleetNetwork], after(4.0)),
        ScriptedKind::FillDisk => Raised(&[Fault::NoteUnwritten], after(4.0)),
        ScriptedKind::SecondMediator | ScriptedKind::CopiedMediator => {
            // People are told of one that is heard for 3 s.
            Raised(&[Fault::SecondMediator], after(4.5))
        }
        ScriptedKind::CloneRobot => Raised(&[Fault::IdentityDoubled], after(6.0)),
        ScriptedKind::KillRobot | ScriptedKind::EndRobot => {
            Raised(&[Fault::ScanSilent], after(0.0))
        }
        ScriptedKind::Panic => Raised(&[Fault::Panic, Fault::ScanSilent], after(0.0)),
        ScriptedKind::RebootRobot => Raised(&[Fault::PlaceUnknown], after(0.0)),
        ScriptedKind::Sleep => Raised(&[Fault::PlaceUnknown], after(0.25)),
        ScriptedKind::Hang => hangs(case.thread.as_deref()),
        // As many reports as a queue holds.
        ScriptedKind::Overload => Raised(&[Fault::QueueFull], after(20.0)),
        ScriptedKind::LoseFrames | ScriptedKind::RefuseFrames => Raised(&[Fault::BusLost], all),
        ScriptedKind::LoseInterface | ScriptedKind::CutPower => {
            Raised(&[Fault::BusLost], after(1.0))
        }
        ScriptedKind::LeaveOp => Raised(&[Fault::BusLost], after(0.0)),
        ScriptedKind::CutMotors => Raised(&[Fault::MotorsOff], after(0.3)),
        ScriptedKind::LowVoltage => Raised(&[Fault::BusVoltage], after(0.3)),
        ScriptedKind::HotMotor => Raised(&[Fault::DriveFault], after(0.3)),
        ScriptedKind::FreezeSensors => Raised(&[Fault::DriveStalled], after(0.5)),
        // Whichever shows first stops it.
        ScriptedKind::StickEncoder => Raised(&[Fault::EncoderBroken, Fault::WheelSlip], after(1.0)),
        ScriptedKind::ReverseMotor => Raised(&[Fault::WheelsDisobey], after(1.0)),
        // Straight ahead it is where it should be.
        ScriptedKind::JamPivot => Raised(&[Fault::WheelsDisobey], sometimes(after(1.0))),
        ScriptedKind::BreakScans => Raised(&[Fault::ScanBroken], all),
        ScriptedKind::Slip => {
            let far = Shows {
                share: 0.25,
                ..sometimes(after(6.0))
            };
            Raised(&[Fault::WheelSlip, Fault::WheelsDisobey], far)
        }
        ScriptedKind::AgeScans => {
            // By more than half a second.
            let late = Shows {
                share: 0.06,
                ..sometimes(after(9.0))
            };
            Raised(&[Fault::LidarLost, Fault::ScanSilent], late)
        }
        ScriptedKind::FreezeScans => Raised(&[Fault::LidarLost], after(2.0)),
        // Found three times, of which each takes it a second and a half.
        ScriptedKind::FreezeLidar => Raised(&[Fault::LidarFrozen], after(6.0)),
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

impl Shows {
    /// Whether it can show in a run.
    fn must(self, run: &Said<'_>) -> bool {
        let fault = run.fault;
        let share = fault.share.map_or(1.0, f64::abs);
        let in_time = run.duration_s >= fault.until_s() + SAID_WITHIN_S;
        fault.for_s >= self.for_s && share >= self.share && in_time
    }
}

impl Expected {
    /// In how many of a case's runs it can show, if anything must.
    pub(super) fn shows_in(self, runs: &[Said<'_>]) -> Option<usize> {
        let Self::Raised(_, shows) = self else {
            return None;
        };
        Some(runs.iter().filter(|run| shows.must(run)).count())
    }

    /// In which of a case's runs nothing was raised that had to be, and what; none: all is as it must be.
    pub(super) fn missing(self, runs: &[Said<'_>]) -> Option<Missing> {
        let Self::Raised(any_of, shows) = self else {
            return None;
        };
        let is_silent = |run: &&Said<'_>| !any_of.iter().any(|own| run.raised.contains(own.name()));
        let all = runs.iter().filter(|run| shows.must(run));
        let silent: Vec<u64> = all.clone().filter(is_silent).map(|run| run.seed).collect();
        let enough = match shows.in_runs {
            In::Each => silent.is_empty(),
            In::One => silent.is_empty() || silent.len() < all.count(),
        };
        (!enough).then_some(Missing { any_of, silent })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(what: ScriptedKind) -> Case {
        Case::of(what)
    }

    #[test]
    fn a_fault_that_can_show_and_is_never_raised_is_missing() {
        let unplug = |for_s: f64| {
            let text =
                format!("at_s = 1.0\nfor_s = {for_s:?}\nwhat = \"unplug\"\nrobot = \"amr-1\"");
            toml::from_str::<ScriptedFault>(&text).expect("a fault")
        };
        let silent = |what, in_runs, runs: &[(f64, &'static str)]| {
            let faults: Vec<ScriptedFault> = runs.iter().map(|(for_s, _)| unplug(*for_s)).collect();
            let said: Vec<Said<'_>> = { faults.iter().zip(runs).zip(1..) }
                .map(|((fault, (_, raised)), seed)| Said {
                    seed,
                    duration_s: 10.0,
                    fault,
                    raised: BTreeSet::from([*raised]),
                })
                .collect();
            let expected = match expected(&case(what)) {
                Expected::Raised(any_of, shows) => {
                    Expected::Raised(any_of, Shows { in_runs, ..shows })
                }
                nothing => nothing,
            };
            let missing = expected.missing(&said);
            missing.map_or(Vec::new(), |missing| missing.silent)
        };
        let unplugged =
            |in_runs, runs: &[(f64, &'static str)]| silent(ScriptedKind::Unplug, in_runs, runs);
        let none: Vec<u64> = Vec::new();
        for in_runs in [In::Each, In::One] {
            assert_eq!(
                unplugged(in_runs, &[(0.3, ""), (4.0, "lidar-lost")]),
                none,
                "too short to show"
            );
            assert_eq!(unplugged(in_runs, &[(0.3, ""), (4.0, "")]), [2]);
            assert_eq!(
                unplugged(in_runs, &[(4.0, "bus-lost")]),
                [1],
                "another fault"
            );
            assert_eq!(unplugged(in_runs, &[(8.5, "")]), none, "the run was over");
        }
        let some = [(4.0, "scan-silent"), (4.0, "")];
        assert_eq!(unplugged(In::Each, &some), [2]);
        assert_eq!(unplugged(In::One, &some), none);
        assert_eq!(silent(ScriptedKind::Reload, In::Each, &some), none);
        let short = unplug(0.3);
        let said = |duration_s| Said {
            seed: 1,
            duration_s,
            fault: &short,
            raised: BTreeSet::new(),
        };
        let unplug = expected(&case(ScriptedKind::Unplug));
        assert_eq!(unplug.shows_in(&[said(10.0)]), Some(0));
        let reload = expected(&case(ScriptedKind::Reload));
        assert_eq!(reload.shows_in(&[said(10.0)]), None);
    }

    #[test]
    fn most_kinds_must_show() {
        let silent = ScriptedKind::all()
            .filter(|what| matches!(expected(&case(*what)), Expected::Nothing(_)));
        assert_eq!(silent.count(), 21);
    }
}
