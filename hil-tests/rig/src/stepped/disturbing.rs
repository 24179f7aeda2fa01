//! What faults do to a stepped robot's clock, threads, wheels and devices.

use sim::lidar::Disturbance;

use super::faults::Change;
use super::fleet::Stepped;
use super::member::Member;
use crate::scenario::ScriptedKind;

/// Of the least voltage that the robot accepts.
const LOW_VOLTAGE: f64 = 0.9;
/// In the drive's `status1`: the left motor is too hot.
const OVERTEMPERATURE_1: u16 = 0x0200;

impl Stepped<'_> {
    /// What a fault does to a robot's clock, threads, wheels and devices.
    pub(super) fn disturb_devices(&mut self, change: Change, number: usize, now_ns: u64) {
        let Change { what, begins, .. } = change;
        let lasts = self.faults.lasts(what, Some(number));
        let share = self.faults.share(what, number);
        let by_ns = self.faults.by_ns(what, Some(number));
        let (_, plan) = &self.plans.robots[number];
        let Member { devices, robot, .. } = &mut self.robots[number];
        match what {
            ScriptedKind::Hang | ScriptedKind::LateThreads | ScriptedKind::Overload => {
                let (hung, late) = (
                    self.faults.hung_threads(number),
                    self.faults.lateness(number),
                );
                if let Some(robot) = robot {
                    robot.hang(&hung);
                    robot.be_late(late);
                }
            }
            ScriptedKind::Sleep => robot.iter_mut().for_each(|own| own.sleep(lasts)),
            ScriptedKind::Drift => {
                let drift = self.faults.drift(Some(number));
                robot.iter_mut().for_each(|own| own.clock().drift(drift));
            }
            ScriptedKind::LoseFrames => devices.bus.lose(share),
            ScriptedKind::RefuseFrames => devices.bus.refuse(share),
            ScriptedKind::LoseInterface => devices.bus.lose_interface(lasts),
            ScriptedKind::LeaveOp if begins => devices.bus.faults.drop_to_safeop(0),
            ScriptedKind::CutPower if lasts => devices.bus.faults.power_off(0),
            ScriptedKind::CutPower => devices.bus.faults.power_on(0),
            ScriptedKind::CutMotors => devices.bus.drive.set_emergency_stop(lasts),
            ScriptedKind::LowVoltage => {
                // Still enough for the motors, which the stop needs.
                let volts = LOW_VOLTAGE * plan.robot.drive.min_bus_voltage_v;
                devices.bus.drive.set_bus_voltage(lasts.then_some(volts));
            }
            ScriptedKind::HotMotor => {
                let bits = if lasts { OVERTEMPERATURE_1 } else { 0 };
                devices.bus.drive.set_status1_bits(bits, 0);
            }
            ScriptedKind::FreezeSensors => devices.bus.drive.freeze_sensors(lasts),
            ScriptedKind::StickEncoder => devices.bus.drive.stick_left_encoder(lasts),
            ScriptedKind::Slip
            | ScriptedKind::JamPivot
            | ScriptedKind::ReverseMotor
            | ScriptedKind::WeakBrakes
            | ScriptedKind::Load
            | ScriptedKind::Slope => {
                let braking_m_s2 = plan.robot.drive.limits.stop_deceleration_m_s2;
                let mut world = self.world.lock();
                if let Some(truth) = world.truth(number).filter(|_| begins) {
                    self.faults.heads(change.fault, truth.pose.theta_rad);
                }
                world.wear(number, self.faults.mechanics(number, braking_m_s2));
            }
            ScriptedKind::BreakScans => devices.lidar.break_scans(share),
            ScriptedKind::DelayScans => devices.lidar.delay(by_ns),
            ScriptedKind::AgeScans => devices.lidar.delay_more_and_more(share, now_ns),
            ScriptedKind::CoverLidar => {
                let cover = Disturbance::Cover { covered: lasts };
                devices.lidar.disturb(cover, now_ns);
            }
            ScriptedKind::FreezeScans => {
                let repeat = Disturbance::Repeat { repeats: lasts };
                devices.lidar.disturb(repeat, now_ns);
            }
            ScriptedKind::FreezeLidar => {
                let repeat = Disturbance::RepeatAgain { repeats: lasts };
                devices.lidar.disturb(repeat, now_ns);
            }
            ScriptedKind::Unplug if lasts => devices.lidar.unplug(),
            ScriptedKind::Unplug => devices.lidar.plug_in(now_ns),
            _ => {}
        }
    }
}
