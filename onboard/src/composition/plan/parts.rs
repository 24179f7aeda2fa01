//! The parts that activities run, made of what the files say.

use contract::network::NetworkSettings;
use coordination::event::EventTable;
use coordination::fsm::MachineModel;
use drivers::ethercat::Expectation;
use drivers::hokuyo::{self, ScanFormat};
use drivers::kelo::{self, VoltageLimits};
use skills::drive::{DriveLimits, WheelController};
use skills::navigator::{NavigationGains, Navigator, NavigatorSetup};
use skills::odometry::{DeadReckoning, TricycleGeometry};
use skills::scan::ScanGeometry;
use skills::tubes::{MotionTubes, StopRules, TubeReport, TubeSet};

use super::contents::{Plan, ns_from_ms};
use super::error::PlanError;
use super::site_parts;
use crate::activities::{communication, drive, lidar};

impl Plan {
    /// Vehicle geometry.
    #[must_use]
    pub fn tricycle(&self) -> TricycleGeometry {
        let drive = &self.robot.drive;
        TricycleGeometry {
            wheelbase_m: drive.wheelbase_m,
            wheel_diameter_m: drive.wheel_diameter_m,
            wheel_separation_m: drive.wheel_separation_m,
            caster_offset_m: drive.caster_offset_m,
        }
    }

    /// Dead reckoning.
    ///
    /// # Errors
    /// [`PlanError::Geometry`].
    pub fn dead_reckoning(&self) -> Result<DeadReckoning, PlanError> {
        Ok(DeadReckoning::new(
            self.tricycle(),
            self.robot.drive.max_wheel_speed_rad_s,
        )?)
    }

    /// The controller of wheels and pivot.
    ///
    /// # Errors
    /// [`PlanError::Limits`].
    pub fn wheel_controller(&self) -> Result<WheelController, PlanError> {
        let drive = &self.robot.drive;
        let limits = DriveLimits {
            max_wheel_speed_rad_s: drive.max_wheel_speed_rad_s,
            max_speed_m_s: drive.max_speed_m_s,
            max_steering_rad: drive.max_steering_rad,
            max_steering_rate_rad_s: drive.max_steering_rate_rad_s,
            acceleration_m_s2: drive.acceleration_m_s2,
            deceleration_m_s2: drive.deceleration_m_s2,
            stop_deceleration_m_s2: commanded_stop_m_s2(drive.stop_deceleration_m_s2),
            pivot_gain_1_s: self.robot.control.pivot_gain_1_s,
            pivot_error_max_rad: self.robot.control.pivot_error_max_rad,
            align_rad: self.robot.control.align_rad,
        };
        Ok(WheelController::new(self.tricycle(), limits)?)
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
    /// [`PlanError::Tubes`], or as [`Plan::scan_format`].
    pub fn motion_tubes(&self) -> Result<MotionTubes, PlanError> {
        let (set, _) = self.tube_set()?;
        let rules = StopRules {
            deceleration_m_s2: self.robot.drive.stop_deceleration_m_s2,
            scan_timeout_s: f64::from(self.robot.lidar.scan_timeout_ms) / 1000.0,
            good_scans_s: self.robot.lidar.good_scans_s,
        };
        Ok(MotionTubes::new(set, self.robot.tubes.adapt, rules)?)
    }

    /// Navigation, at the robot's start.
    ///
    /// # Errors
    /// [`PlanError::Machine`] or [`PlanError::Navigation`].
    pub fn navigator(&self) -> Result<Navigator, PlanError> {
        let mut events = EventTable::new();
        let mut model = MachineModel::new(self.role.as_str());
        model.initial(self.fsm.initial.as_str());
        for state in &self.fsm.states {
            model.state(state.name.as_str());
        }
        for transition in &self.fsm.transitions {
            let outputs: Vec<&str> = transition.outputs.iter().map(String::as_str).collect();
            model.transition(&transition.from, &transition.on, &transition.to, &outputs);
        }
        let machine = model.compile(&mut events)?;
        let gains = &self.robot.navigation;
        Ok(Navigator::new(NavigatorSetup {
            map: site_parts::map(&self.site),
            states: site_parts::states(&self.fsm),
            skills: site_parts::skills(&self.site),
            monitors: site_parts::monitors(&self.site, &mut events)?,
            machine,
            gains: NavigationGains {
                lateral_gain_1_m2: gains.lateral_gain_1_m2,
                heading_gain_1_m: gains.heading_gain_1_m,
                lookahead_m: gains.lookahead_m,
                max_curvature_1_m: gains.max_curvature_1_m,
                acceleration_m_s2: self.robot.drive.acceleration_m_s2,
                deceleration_m_s2: gains.deceleration_m_s2,
                steering_lag_s: gains.steering_lag_s,
                range_std_m: gains.range_std_m,
                wall_inlier_m: gains.wall_inlier_m,
                wall_min_points: gains.wall_min_points,
                gate_sigma: gains.gate_sigma,
                odometry_std_m_per_m: gains.odometry_std_m_per_m,
                odometry_std_rad_per_m: gains.odometry_std_rad_per_m,
                start_std_m: gains.start_std_m,
                start_std_rad: gains.start_std_rad,
                max_std_m: gains.max_std_m,
                max_std_rad: gains.max_std_rad,
                border_sigma: gains.border_sigma,
            },
            footprint: self.robot.footprint,
            max_speed_m_s: self.robot.drive.max_speed_m_s,
            beams: self.scan_geometry()?.beams,
            start: self.start.start,
            start_state: self.start.start_state.clone(),
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
            deadline_ns: u64::from(ethercat.deadline_us) * 1000,
            setpoint_timeout_ns: ns_from_ms(drive.setpoint_timeout_ms),
            hold_ns: ns_from_ms(drive.hold_ms),
            bring_ups_per_minute: drive.bringups_per_minute as usize,
            max_wheel_speed_rad_s: drive.max_wheel_speed_rad_s,
            stop_deceleration_rad_s2: commanded_stop_m_s2(drive.stop_deceleration_m_s2)
                / (drive.wheel_diameter_m / 2.0),
            drive_current_a: drive.drive_current_a as f32,
            stop_current_a: drive.stop_current_a as f32,
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
        Ok(lidar::Settings {
            device: self.robot.lidar.device.clone(),
            options: self.lidar_options(),
            format: self.scan_format()?,
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
            },
        }
    }
}

/// The deceleration to command so that the wheels, which follow with a lag, keep the guaranteed one.
fn commanded_stop_m_s2(guaranteed_m_s2: f64) -> f64 {
    guaranteed_m_s2 * 1.2
}
