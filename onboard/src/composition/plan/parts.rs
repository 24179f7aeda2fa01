//! The parts that activities run, made of what the files say.

use std::time::Duration;

use contract::network::NetworkSettings;
use description::keys::KeyError;
use description::robot::DriveLimits;
use drivers::ethercat::{BringUpOptions, Expectation};
use drivers::hokuyo::{self, ScanFormat};
use drivers::kelo::{self, VoltageLimits};
use skills::drive::WheelController;
use skills::navigator::{Navigator, NavigatorSetup};
use skills::odometry::DeadReckoning;
use skills::scan::ScanGeometry;
use skills::tubes::{MotionTubes, StopRules, TubeReport, TubeSet};

use super::contents::{Plan, ns_from_ms};
use super::error::PlanError;
use crate::activities::{communication, drive, lidar};

impl Plan {
    /// Dead reckoning.
    ///
    /// # Errors
    /// The key of `[drive]` that describes no vehicle.
    pub fn dead_reckoning(&self) -> Result<DeadReckoning, KeyError> {
        let drive = &self.robot.drive;
        DeadReckoning::new(drive.geometry, drive.limits.max_wheel_speed_rad_s)
    }

    /// The controller of wheels and pivot.
    ///
    /// # Errors
    /// The key of `[drive]` or `[control]` that does not fit.
    pub fn wheel_controller(&self) -> Result<WheelController, KeyError> {
        let drive = &self.robot.drive;
        let limits = DriveLimits {
            stop_deceleration_m_s2: commanded_stop_m_s2(drive.limits.stop_deceleration_m_s2),
            ..drive.limits
        };
        WheelController::new(drive.geometry, limits, self.robot.control)
    }

    /// What the lidar is asked for.
    #[must_use]
    pub fn lidar_options(&self) -> hokuyo::Options {
        let lidar = &self.robot.lidar;
        hokuyo::Options {
            bit_rate: lidar.bit_rate,
            // The loader bounds both far below.
            cluster: u8::try_from(lidar.cluster).unwrap_or(u8::MAX),
            skip: u8::try_from(lidar.skip).unwrap_or(u8::MAX),
            ..hokuyo::Options::default()
        }
    }

    /// The scans that a URG-04LX gives when asked so.
    ///
    /// # Errors
    /// [`PlanError::Lidar`] when such scans do not fit through the line, with advice.
    pub fn scan_format(&self) -> Result<ScanFormat, PlanError> {
        let device = hokuyo::Parameters::urg_04lx();
        self.lidar_options()
            .format(&device)
            .map_err(|error| PlanError::Lidar(error.to_string()))
    }

    /// Where the beams of a scan look.
    ///
    /// # Errors
    /// As [`Plan::scan_format`].
    pub fn scan_geometry(&self) -> Result<ScanGeometry, PlanError> {
        let (lidar, format) = (&self.robot.lidar, self.scan_format()?);
        let device = hokuyo::Parameters::urg_04lx();
        let mount = lidar.mount;
        Ok(ScanGeometry::from_steps(
            mount,
            u32::from(device.ares),
            u32::from(device.afrt),
            (u32::from(format.first_step), u32::from(format.last_step)),
            u32::from(format.cluster),
            (lidar.range_min_m, lidar.range_max_m),
            device.turn().as_secs_f64(),
        ))
    }

    pub(super) fn tube_set(&self) -> Result<(TubeSet, TubeReport), PlanError> {
        let (tubes, footprint) = (&self.robot.tubes, &self.robot.footprint);
        Ok(TubeSet::generate(tubes, footprint, &self.scan_geometry()?)?)
    }

    /// The motion tubes, at rest until scans come.
    ///
    /// # Errors
    /// The key of `[tubes]` that does not fit, [`PlanError::Tubes`], or as [`Plan::scan_format`].
    pub fn motion_tubes(&self) -> Result<MotionTubes, PlanError> {
        let set = match &self.tubes {
            Some(set) => set.clone(),
            None => self.tube_set()?.0,
        };
        let rules = StopRules {
            deceleration_m_s2: self.robot.drive.limits.stop_deceleration_m_s2,
            scan_timeout_s: f64::from(self.robot.lidar.scan_timeout_ms) / 1000.0,
            good_scans_s: self.robot.lidar.good_scans_s,
        };
        Ok(MotionTubes::new(set, self.robot.tubes.adapt, rules)?)
    }

    /// Navigation, at the robot's start.
    ///
    /// # Errors
    /// The key of either file that does not fit, or as [`Plan::scan_format`].
    pub fn navigator(&self) -> Result<Navigator, PlanError> {
        let (robot, limits) = (&self.robot, &self.robot.drive.limits);
        Ok(Navigator::new(NavigatorSetup {
            site: self.site.value.clone(),
            robot: robot.identity.id.clone(),
            gains: robot.navigation,
            acceleration_m_s2: limits.acceleration_m_s2,
            max_speed_m_s: limits.max_speed_m_s,
            footprint: robot.footprint,
            beams: self.scan_geometry()?.beams,
        })?)
    }

    /// What the drive activity needs to know.
    #[must_use]
    pub fn drive_settings(&self) -> drive::Settings {
        let (drive, ethercat) = (&self.robot.drive, &self.robot.ethercat);
        drive::Settings {
            expectation: Expectation {
                vendor_id: ethercat.vendor_id,
                product_codes: ethercat.product_codes.clone(),
                outputs_bytes: kelo::OUTPUTS_BYTES,
                inputs_bytes: kelo::INPUTS_BYTES,
                watchdog_ms: ethercat.watchdog_ms,
            },
            bring_up: BringUpOptions {
                timeout: Duration::from_secs_f64(ethercat.bring_up_s),
                frame_timeout: Duration::from_millis(20),
                frame_attempts: 10,
                cycle: Duration::from_millis(1),
            },
            deadline_ns: u64::from(ethercat.deadline_us) * 1000,
            setpoint_timeout_ns: ns_from_ms(drive.setpoint_timeout_ms),
            hold_ns: ns_from_ms(drive.hold_ms),
            bring_ups_per_minute: drive.bringups_per_minute as usize,
            awaited_ns: (drive.awaited_s * 1e9) as u64,
            max_wheel_speed_rad_s: drive.limits.max_wheel_speed_rad_s,
            stop_deceleration_rad_s2: commanded_stop_m_s2(drive.limits.stop_deceleration_m_s2)
                / drive.geometry.wheel_radius_m(),
            drive_current_a: drive.drive_current_a as f32,
            stop_current_a: drive.stop_current_a as f32,
            obedience_rad: drive.following_error_m / drive.geometry.wheel_radius_m(),
            emergency_bits: drive.emergency_bits,
            voltage: VoltageLimits {
                min_v: drive.min_bus_voltage_v as f32,
                max_v: drive.max_bus_voltage_v as f32,
            },
            pivot_zero_rad: drive.pivot_zero_rad,
        }
    }

    /// What the lidar activity needs to know.
    ///
    /// # Errors
    /// As [`Plan::scan_format`].
    pub fn lidar_settings(&self) -> Result<lidar::Settings, PlanError> {
        // What does not fit through the line is said before the first connection.
        self.scan_format()?;
        Ok(lidar::Settings {
            device: self.robot.lidar.device.clone(),
            options: self.lidar_options(),
            silent_ns: 4 * ns_from_ms(self.robot.lidar.scan_timeout_ms),
        })
    }

    /// What the communication activity needs to know.
    #[must_use]
    pub fn communication_settings(&self, boot_epoch: u64) -> communication::Settings {
        let fleet = &self.robot.fleet;
        communication::Settings {
            robot_id: self.robot.identity.id.clone(),
            role: self.role.clone(),
            boot_epoch,
            key_prefix: fleet.key_prefix.clone(),
            network: NetworkSettings {
                listen: fleet.listen.clone(),
                connect: fleet.connect.clone(),
                scouting: fleet.scouting,
                interface: fleet.interface.clone(),
                ..NetworkSettings::default()
            },
            keys: fleet.keys.clone(),
        }
    }
}

/// The deceleration to command so that the wheels, which follow with a lag, keep the guaranteed one.
fn commanded_stop_m_s2(guaranteed_m_s2: f64) -> f64 {
    guaranteed_m_s2 * 1.2
}
