//! Directions and cells of beams and points, as fast as a thousand of them for each scan ask for.

/// No [`direction_rad`] is off by this much.
pub(crate) const DIRECTION_DOUBT_RAD: f64 = 1e-4;

/// The largest whole number that is not above, without a call: not every processor has an instruction for it, nor one that makes an
/// integer of 64 bits.
#[must_use]
#[inline]
pub(crate) fn floor(number: f64) -> i64 {
    if number.abs() < f64::from(i32::MAX) {
        let towards_zero = number as i32;
        return i64::from(towards_zero) - i64::from(f64::from(towards_zero) > number);
    }
    let towards_zero = number as i64;
    towards_zero.saturating_sub(i64::from(towards_zero as f64 > number))
}

/// Arc tangent of `y / x` in all quadrants to 0.00002 rad, a small part of a beam, without a call.
#[must_use]
#[inline]
pub(crate) fn direction_rad(y: f32, x: f32) -> f32 {
    use std::f32::consts::{FRAC_PI_2, PI};
    let (large, small) = (x.abs().max(y.abs()), x.abs().min(y.abs()));
    let slope = if large > 0.0 { small / large } else { 0.0 };
    let square = slope * slope;
    let series = [
        -0.011_721_2,
        0.052_653_32,
        -0.116_432_87,
        0.193_543_46,
        -0.332_623_47,
        0.999_977_26,
    ];
    let angle = slope * series.iter().fold(0.0, |sum, term| sum * square + term);
    let angle = if y.abs() > x.abs() {
        FRAC_PI_2 - angle
    } else {
        angle
    };
    let angle = if x < 0.0 { PI - angle } else { angle };
    if y < 0.0 { -angle } else { angle }
}

/// An angle less than a turn away from (−π, π], brought into it.
#[must_use]
#[inline]
pub(crate) fn wrapped(angle_rad: f32) -> f32 {
    use std::f32::consts::{PI, TAU};
    if angle_rad > PI {
        angle_rad - TAU
    } else if angle_rad <= -PI {
        angle_rad + TAU
    } else {
        angle_rad
    }
}

/// Cosine of a direction that is out of view for sure, where a sensor looks that far to the left and right; −2: there is none.
#[must_use]
pub(crate) fn behind_cos(view_rad: f32) -> f32 {
    const BESIDE_RAD: f32 = 0.01;
    let beside_rad = view_rad + BESIDE_RAD;
    if beside_rad < std::f32::consts::PI {
        beside_rad.cos()
    } else {
        -2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floors_are_those_of_the_library() {
        let numbers = [
            0.0,
            -0.0,
            0.5,
            -0.5,
            1.0,
            -1.0,
            1.0 - 1e-16,
            2_147_483_646.5,
            -2_147_483_646.5,
            2_147_483_647.5,
            -2_147_483_648.5,
            1e15 + 0.5,
            -1e15 - 0.5,
        ];
        let beyond = [
            f64::MAX,
            f64::MIN,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
        ];
        for number in numbers.into_iter().chain(beyond) {
            assert_eq!(floor(number), number.floor() as i64, "{number}");
        }
    }

    #[test]
    fn directions_are_as_good_as_the_libraries() {
        for i in 0..10_000 {
            let angle_rad = 6.2e-4 * (i - 5_000) as f32;
            let found_rad = direction_rad(angle_rad.sin(), angle_rad.cos());
            assert!((found_rad - angle_rad).abs() < 3e-5, "{angle_rad}");
        }
        assert_eq!(direction_rad(0.0, 0.0), 0.0);
    }
}
