//! The robot's state as a message to everybody.

use contract::wire::{Battery, Fault as FaultMessage, Load as LoadMessage, Pose, RobotState};

use coordination::symbols::Stamped;
use skills::odometry::Odometry;

use crate::realtime::clock::MILLISECOND_NS;
use crate::symbols::faults::{Fault, FaultTable};
use crate::symbols::values::{DriveStatus, Load, Mode, NavigationState, PoseEstimate};

/// What was read in one event loop.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Snapshot {
    pub(super) pose: Stamped<PoseEstimate>,
    pub(super) odometry: Odometry,
    pub(super) navigation: NavigationState,
    pub(super) faults: FaultTable,
    pub(super) mode: u64,
    pub(super) drive: DriveStatus,
    pub(super) load: Load,
}

/// The message; its sequence and the ages of faults are filled in when it is sent.
pub(super) fn message(
    snapshot: &Snapshot,
    robot_id: &str,
    role: &str,
    boot_epoch: u64,
) -> RobotState {
    let Snapshot {
        pose,
        odometry,
        navigation,
        faults,
        mode,
        drive,
        load,
    } = snapshot;
    RobotState {
        robot_id: robot_id.to_owned(),
        boot_epoch,
        sequence: 0,
        stamp_ns: pose.stamp_ns,
        pose: (pose.stamp_ns != 0).then_some(Pose {
            std_x_m: pose.value.std_x_m,
            std_y_m: pose.value.std_y_m,
            std_theta_rad: pose.value.std_theta_rad,
            ..pose.value.pose.into()
        }),
        speed_m_s: odometry.twist.v_m_s,
        yaw_rate_rad_s: odometry.twist.omega_rad_s,
        fsm_state: navigation.state.as_str().to_owned(),
        area: navigation.area.as_str().to_owned(),
        skill: navigation.skill.as_str().to_owned(),
        role: role.to_owned(),
        mode: Mode::name_of(*mode).to_owned(),
        faults: fault_messages(faults),
        laps: u32::try_from(navigation.laps).unwrap_or(u32::MAX),
        // The drive hangs on the battery itself. While it does not answer, its last word is old.
        battery: (drive.operational != 0).then_some(Battery {
            voltage_v: drive.bus_voltage_v,
            ..Battery::default()
        }),
        load: (!load.name.as_str().is_empty()).then(|| LoadMessage {
            name: load.name.as_str().to_owned(),
            mass_kg: load.mass_kg,
        }),
    }
}

/// Faults that were ever raised.
fn fault_messages(table: &FaultTable) -> Vec<FaultMessage> {
    Fault::ALL
        .into_iter()
        .map(|fault| (fault, table.state(fault)))
        .filter(|(_, state)| state.count > 0)
        .map(|(fault, state)| FaultMessage {
            name: fault.name().to_owned(),
            active: state.active != 0,
            count: state.count,
            age_ms: 0,
        })
        .collect()
}

pub(super) fn age_ms(table: &FaultTable, name: &str, now_ns: u64) -> u64 {
    let since_ns = Fault::ALL
        .into_iter()
        .find(|fault| fault.name() == name)
        .map(|fault| table.state(fault).since_ns);
    now_ns.saturating_sub(since_ns.unwrap_or(now_ns)) / MILLISECOND_NS
}

/// Whether a discrete part of the state has changed; changes of pose and speed wait for the 5 Hz repetition.
pub(super) fn is_news(sent: &RobotState, state: &RobotState) -> bool {
    let ages_aside = |faults: &[FaultMessage]| {
        faults
            .iter()
            .map(|fault| (fault.name.clone(), fault.active, fault.count))
            .collect::<Vec<_>>()
    };
    sent.fsm_state != state.fsm_state
        || sent.area != state.area
        || sent.skill != state.skill
        || sent.mode != state.mode
        || sent.laps != state.laps
        || sent.load != state.load
        || ages_aside(&sent.faults) != ages_aside(&state.faults)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_battery_is_told_of_while_the_drive_answers() {
        let snapshot = |operational| Snapshot {
            drive: DriveStatus {
                operational,
                bus_voltage_v: 25.5,
                ..DriveStatus::default()
            },
            ..Snapshot::default()
        };
        let battery = |operational| message(&snapshot(operational), "amr-1", "normal", 7).battery;
        let known = Battery {
            voltage_v: 25.5,
            charge: 0.0,
        };
        assert_eq!((battery(1), battery(0)), (Some(known), None));
    }

    #[test]
    fn only_discrete_changes_are_news() {
        let state = RobotState {
            area: "1".into(),
            speed_m_s: 0.1,
            ..RobotState::default()
        };
        assert!(!is_news(
            &state,
            &RobotState {
                speed_m_s: 0.4,
                ..state.clone()
            }
        ));
        assert!(is_news(
            &state,
            &RobotState {
                area: "2".into(),
                ..state.clone()
            }
        ));
    }
}
