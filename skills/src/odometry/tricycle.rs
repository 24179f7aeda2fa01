//! Measures of the vehicle and its kinematics.

use description::geometry::Twist2;

/// Measures of the wheel unit and where it sits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TricycleGeometry {
    /// From the fixed axle to the pivot.
    pub wheelbase_m: f64,
    /// Of both hub wheels.
    pub wheel_diameter_m: f64,
    /// Between the two hub wheels.
    pub wheel_separation_m: f64,
    /// How far the hub wheels' axle trails the pivot.
    pub caster_offset_m: f64,
}

impl Default for TricycleGeometry {
    /// A KELO drive 100 under a platform of 0.4 m × 0.3 m.
    fn default() -> Self {
        Self {
            wheelbase_m: 0.25,
            wheel_diameter_m: 0.105,
            wheel_separation_m: 0.0775,
            caster_offset_m: 0.01,
        }
    }
}

impl TricycleGeometry {
    /// Half the diameter.
    #[must_use]
    pub fn wheel_radius_m(&self) -> f64 {
        self.wheel_diameter_m / 2.0
    }

    /// Checks that the numbers describe a vehicle.
    ///
    /// # Errors
    /// The first number that describes no vehicle.
    pub fn validate(&self) -> Result<(), GeometryError> {
        for (name, value) in [
            ("wheelbase", self.wheelbase_m),
            ("wheel diameter", self.wheel_diameter_m),
            ("wheel separation", self.wheel_separation_m),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(GeometryError::NotPositive { name, value });
            }
        }
        let (caster_m, wheelbase_m) = (self.caster_offset_m, self.wheelbase_m);
        if !(caster_m.is_finite() && (0.0..wheelbase_m / 2.0).contains(&caster_m)) {
            return Err(GeometryError::Caster {
                caster_m,
                wheelbase_m,
            });
        }
        Ok(())
    }

    /// Twist of `base_link` from the unit's speed, the pivot angle and its rate.
    #[must_use]
    pub fn twist(&self, unit_m_s: f64, pivot_rad: f64, pivot_rate_rad_s: f64) -> Twist2 {
        let (sin, cos) = pivot_rad.sin_cos();
        let caster_m = self.caster_offset_m;
        let omega_rad_s = (unit_m_s * sin + caster_m * pivot_rate_rad_s * cos)
            / (self.wheelbase_m - caster_m * cos);
        let v_m_s = unit_m_s * cos - caster_m * (omega_rad_s + pivot_rate_rad_s) * sin;
        Twist2::new(v_m_s, omega_rad_s)
    }
}

/// Numbers that describe no vehicle.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// A length that must be positive.
    #[error("{name} must be a positive length, found {value} m")]
    NotPositive {
        /// Which.
        name: &'static str,
        /// Found, in metres.
        value: f64,
    },
    /// The caster offset does not fit the wheelbase.
    #[error(
        "caster offset must lie between 0 and half the wheelbase ({wheelbase_m} m), found {caster_m} m"
    )]
    Caster {
        /// Found.
        caster_m: f64,
        /// The wheelbase.
        wheelbase_m: f64,
    },
    /// The fastest wheel speed.
    #[error("maximum wheel speed must be positive, found {0} rad/s")]
    WheelSpeed(f64),
}
