//! What a robot says to who drives it by hand.

use description::geometry::{Pose2, Twist2};
use serde::{Deserialize, Serialize};
use skills::navigator::Hold;
use skills::tubes::Reason;

use crate::symbols::faults::{Fault, FaultTable, Resumes};
use crate::symbols::values::{NavigationState, SafeCommand, TubeState};

/// Speeds that differ by less count as the same.
const SAME_M_S: f64 = 0.005;

/// What a robot makes of a wish, and why not more.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// What the desk has heard last.
    pub asked: Twist2,
    /// The speed that the robot allows for it,
    pub allowed_m_s: f64,
    /// and what limits it; empty for nothing.
    pub limit: String,
    /// How it moves.
    pub moves: Twist2,
    /// `base_link` in `map`.
    pub pose: Pose2,
    /// Standard deviation of the position in its worse direction, of both axes.
    pub std_m: f64,
    /// It does not know where it is.
    pub uncertain: bool,
    /// State of its machine.
    pub state: String,
    /// Faults that are present, by name.
    pub faults: Vec<String>,
    /// A wish to stand must come before it drives.
    pub release_first: bool,
}

/// The fault that keeps a robot from being driven by hand until somebody resets it. One that does not know its place may be
/// driven.
pub(super) fn stopping(faults: &FaultTable) -> Option<Fault> {
    let placeless = [Fault::PoseUncertain, Fault::PlaceUnknown];
    let mut active = faults.active();
    active.find(|fault| fault.resumes() == Resumes::Operator && !placeless.contains(fault))
}

/// What limits a wish, the nearest to the wheels last.
pub(super) struct Chain<'a> {
    pub(super) faults: &'a FaultTable,
    pub(super) asked_m_s: f64,
    pub(super) release_first: bool,
    pub(super) navigation: &'a NavigationState,
    /// What navigation lets through.
    pub(super) wanted_m_s: f64,
    pub(super) tube: &'a TubeState,
    pub(super) safe: &'a SafeCommand,
}

impl Chain<'_> {
    /// What the tubes let through.
    pub(super) fn allowed_m_s(&self) -> f64 {
        if self.safe.stop != 0 {
            0.0
        } else {
            self.safe.command.speed_m_s
        }
    }

    /// What limits the speed, in words; empty for nothing.
    pub(super) fn limit(&self) -> String {
        if let Some(fault) = stopping(self.faults) {
            return format!("fault {}: {}", fault.name(), fault.sentence());
        }
        if self.asked_m_s == 0.0 {
            return String::new();
        }
        if self.release_first {
            return "let go of the dead-man first".to_owned();
        }
        let less = |this_m_s: f64, than_m_s: f64| this_m_s.abs() < than_m_s.abs() - SAME_M_S;
        let (hold, area) = (
            self.navigation.hold.as_str(),
            self.navigation.waiting_for.as_str(),
        );
        if hold == Hold::PoseUncertain.reason() {
            return "place: the robot does not know where it is, so borders are no help; say where it stands with \
                    `onboard ctl place`, or drive with --without-borders and see to the areas yourself"
                .to_owned();
        }
        if less(self.wanted_m_s, self.asked_m_s) {
            return match (hold, area) {
                (hold, "") if !hold.is_empty() && hold != Hold::ByHand.reason() => hold.to_owned(),
                (_, "") => "speed: teleop.speed_m_s, the area's limit, or the ramp".to_owned(),
                (_, area) => {
                    format!("border: there is no leave for area `{area}`, which is asked for")
                }
            };
        }
        if less(self.allowed_m_s(), self.wanted_m_s) {
            let number = usize::try_from(self.tube.reason).ok();
            let reason = number.and_then(|number| Reason::ALL.get(number).copied());
            return match reason {
                None | Some(Reason::None)
                    if self.faults.state(Fault::NoteUnwritten).active != 0 =>
                {
                    format!("fault: {}", Fault::NoteUnwritten.sentence())
                }
                None | Some(Reason::None) => {
                    "tube: the motion thread or the supervisor is late".to_owned()
                }
                Some(Reason::UnknownFloor) => format!(
                    "tube: {}; look, then say how far it is with `onboard ctl free-behind`",
                    Reason::UnknownFloor.words()
                ),
                Some(reason) => format!("tube: {}", reason.words()),
            };
        }
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::symbols::values::Name;
    use description::geometry::MotionCommand;

    fn limit(
        change: impl FnOnce(&mut FaultTable, &mut NavigationState, &mut TubeState),
        speeds: [f64; 3],
    ) -> String {
        let mut faults = FaultTable::default();
        let (mut navigation, mut tube) = (NavigationState::default(), TubeState::default());
        change(&mut faults, &mut navigation, &mut tube);
        let [asked_m_s, wanted_m_s, safe_m_s] = speeds;
        Chain {
            faults: &faults,
            asked_m_s,
            release_first: false,
            navigation: &navigation,
            wanted_m_s,
            tube: &tube,
            safe: &SafeCommand::drive(MotionCommand::new(safe_m_s, 0.0)),
        }
        .limit()
    }

    #[test]
    fn the_first_that_limits_is_named() {
        let nothing = |_: &mut FaultTable, _: &mut NavigationState, _: &mut TubeState| {};
        assert_eq!(limit(nothing, [0.2, 0.2, 0.2]), "");
        assert_eq!(limit(nothing, [0.0, 0.0, 0.0]), "");
        assert!(limit(nothing, [0.4, 0.2, 0.2]).starts_with("speed: "));
        let border = |_: &mut FaultTable, navigation: &mut NavigationState, _: &mut TubeState| {
            navigation.waiting_for = Name::new("gate");
        };
        assert!(limit(border, [0.2, 0.1, 0.1]).contains("`gate`"));
        let behind = |_: &mut FaultTable, _: &mut NavigationState, tube: &mut TubeState| {
            tube.reason = Reason::UnknownFloor as u64;
        };
        assert!(limit(behind, [-0.1, -0.1, 0.0]).contains("free-behind"));
        let lost =
            |faults: &mut FaultTable, navigation: &mut NavigationState, _: &mut TubeState| {
                faults.raise(Fault::PoseUncertain, 1);
                navigation.hold = Name::new(Hold::PoseUncertain.reason());
            };
        assert!(limit(lost, [0.2, 0.0, 0.0]).starts_with("place: "));
        let stopped = |faults: &mut FaultTable, _: &mut NavigationState, _: &mut TubeState| {
            faults.raise(Fault::NoFreeTube, 1);
            faults.raise(Fault::WheelsDisobey, 1);
        };
        assert!(limit(stopped, [0.0, 0.0, 0.0]).starts_with("fault wheels-disobey: "));
    }
}
