//! Differences between two plans that a running robot cannot take over.

use description::robot::{Control, Drive, DriveLimits, Tubes};

use super::contents::Plan;

impl Plan {
    /// The first key or section that differs and takes a restart: hardware, geometry, threads, and what the drive
    /// activity enforces by itself. Limits of motion, gains, tubes and the site can be exchanged.
    #[must_use]
    pub fn first_fixed_difference(&self, other: &Self) -> Option<String> {
        let (ours, theirs) = (&self.robot, &other.robot);
        let sections = [
            ("identity", ours.identity == theirs.identity),
            ("footprint", ours.footprint == theirs.footprint),
            ("ethercat", ours.ethercat == theirs.ethercat),
            ("lidar", ours.lidar == theirs.lidar),
            ("threads", ours.threads == theirs.threads),
            ("fleet", ours.fleet == theirs.fleet),
            ("watchdog", ours.watchdog == theirs.watchdog),
            ("robots.<id>.role", self.role == other.role),
            (
                "areas, monitors or state machine of a managed site",
                self.has_same_fleet_as(other),
            ),
        ];
        let section = sections.into_iter().find(|(_, same)| !same);
        section
            .map(|(name, _)| name.replace("<id>", &ours.identity.id))
            .or_else(|| fixed_in_drive(&ours.drive, &theirs.drive))
            .or_else(|| fixed_in_control(&ours.control, &theirs.control))
            .or_else(|| fixed_in_tubes(&ours.tubes, &theirs.tubes))
            .or_else(|| self.fixed_for_the_fleet(other))
    }
}

fn fixed_in_drive(ours: &Drive, theirs: &Drive) -> Option<String> {
    // What can be exchanged counts as the same.
    let limits = DriveLimits {
        max_wheel_speed_rad_s: theirs.limits.max_wheel_speed_rad_s,
        stop_deceleration_m_s2: theirs.limits.stop_deceleration_m_s2,
        ..ours.limits
    };
    let theirs = Drive { limits, ..*theirs };
    macro_rules! first_of {
        ($($key:ident $(. $part:ident)?),* $(,)?) => {
            [$((
                [stringify!($key), $(stringify!($part))?].last().copied().unwrap_or_default(),
                ours.$key$(.$part)? == theirs.$key$(.$part)?,
            )),*]
            .into_iter()
            .find(|(_, same)| !same)
        };
    }
    let key = first_of!(
        geometry.wheelbase_m,
        geometry.wheel_diameter_m,
        geometry.wheel_separation_m,
        geometry.caster_offset_m,
        pivot_zero_rad,
        limits.max_wheel_speed_rad_s,
        limits.stop_deceleration_m_s2,
        unpowered_deceleration_m_s2,
        lag_ms,
        drive_current_a,
        stop_current_a,
        min_bus_voltage_v,
        max_bus_voltage_v,
        setpoint_timeout_ms,
        hold_ms,
        bringups_per_minute,
        awaited_s,
        following_error_m,
        emergency_bits,
    );
    match key {
        Some((key, _)) => Some(format!("drive.{key}")),
        None => (*ours != theirs).then(|| "drive".to_owned()),
    }
}

/// What is remembered of the floor is kept in cells of this size, so many of them, for so long.
fn fixed_in_tubes(ours: &Tubes, theirs: &Tubes) -> Option<String> {
    let keys = [
        ("sample_step_m", ours.sample_step_m == theirs.sample_step_m),
        ("augment_m", ours.augment_m == theirs.augment_m),
        (
            "floor_memory_m",
            ours.floor_memory_m == theirs.floor_memory_m,
        ),
    ];
    let key = keys.into_iter().find(|(_, same)| !same);
    key.map(|(key, _)| format!("tubes.{key}"))
}

fn fixed_in_control(ours: &Control, theirs: &Control) -> Option<String> {
    (ours.command_timeout_ms != theirs.command_timeout_ms)
        .then(|| "control.command_timeout_ms".to_owned())
}
