//! Angles and speeds of the two hub wheels of a drive: the one form between process data, odometry and wheel controller.

/// Faster than any wheel; stands for infinity where speeds are scaled.
const FASTEST_RAD_S: f64 = 1e9;

/// What the encoders of a drive say; positive wheel angles drive the unit forward along its heading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "pod",
    derive(bytemuck::Pod, bytemuck::Zeroable, serde::Serialize)
)]
#[repr(C)]
pub struct EncoderAngles {
    /// Left hub wheel, accumulated.
    pub left_rad: f64,
    /// Right hub wheel, accumulated.
    pub right_rad: f64,
    /// Pivot, its zero already subtracted, positive to the left; may wrap at ±π.
    pub pivot_rad: f64,
}

/// Speeds of the two hub wheels, positive drives the unit forward along its heading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "pod",
    derive(bytemuck::Pod, bytemuck::Zeroable, serde::Serialize)
)]
#[repr(C)]
pub struct WheelSpeeds {
    /// Left hub wheel.
    pub left_rad_s: f64,
    /// Right hub wheel.
    pub right_rad_s: f64,
}

impl WheelSpeeds {
    /// Both wheels at rest.
    pub const STANDING: Self = Self::new(0.0, 0.0);

    /// Left and right.
    #[must_use]
    pub const fn new(left_rad_s: f64, right_rad_s: f64) -> Self {
        Self {
            left_rad_s,
            right_rad_s,
        }
    }

    /// Both speeds are finite.
    #[must_use]
    pub const fn is_finite(self) -> bool {
        self.left_rad_s.is_finite() && self.right_rad_s.is_finite()
    }

    /// Magnitude of the faster wheel.
    #[must_use]
    pub const fn fastest_rad_s(self) -> f64 {
        self.left_rad_s.abs().max(self.right_rad_s.abs())
    }

    /// Both times `share`: the curve that the unit drives stays.
    #[must_use]
    pub fn scaled(self, share: f64) -> Self {
        Self::new(self.left_rad_s * share, self.right_rad_s * share)
    }

    /// Scaled down together when one wheel is faster than `limit_rad_s`. Not a number counts as standing.
    #[must_use]
    pub fn limited(self, limit_rad_s: f64) -> Self {
        let bounded = |rad_s: f64| match rad_s {
            rad_s if rad_s.is_nan() => 0.0,
            rad_s => rad_s.clamp(-FASTEST_RAD_S, FASTEST_RAD_S),
        };
        let speeds = Self::new(bounded(self.left_rad_s), bounded(self.right_rad_s));
        let fastest_rad_s = speeds.fastest_rad_s();
        if fastest_rad_s > limit_rad_s {
            speeds.scaled(limit_rad_s / fastest_rad_s)
        } else {
            speeds
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_faster_wheel_sets_the_scale() {
        let limited = |left, right| WheelSpeeds::new(left, right).limited(10.0);
        assert_eq!(limited(10.0, -4.0), WheelSpeeds::new(10.0, -4.0));
        assert_eq!(limited(-40.0, 20.0), WheelSpeeds::new(-10.0, 5.0));
        assert_eq!(limited(f64::NAN, 3.0), WheelSpeeds::new(0.0, 3.0));
        let infinite = limited(f64::INFINITY, 1.0);
        assert!((infinite.left_rad_s - 10.0).abs() < 1e-9 && infinite.right_rad_s < 1e-6);
    }

    proptest! {
        #[test]
        fn no_wheel_is_over_the_limit_and_the_curve_stays(left in -1e6_f64..1e6, right in -1e6_f64..1e6, limit in 0.0_f64..100.0) {
            let limited = WheelSpeeds::new(left, right).limited(limit);
            prop_assert!(limited.fastest_rad_s() <= limit * (1.0 + 1e-12));
            prop_assert!((limited.left_rad_s * right - limited.right_rad_s * left).abs() <= 1e-3);
        }
    }
}
