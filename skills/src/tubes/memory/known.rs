//! What one scan says per beam: free up to this range.
//!
//! An unknown beam says nothing. Something that is hidden from a few of them alone is narrower than the gap between
//! their known neighbours; so up to the range where that gap spans `sample_step_m` the nearer neighbour answers for
//! them, and beyond they count as blocked.

use crate::scan::{MAX_BEAMS, ScanGeometry};
use description::geometry::Point2;

/// Free range per beam. A fixed array, so that a beam of a sample needs no bounds check.
#[derive(Clone, Debug)]
pub struct KnownRanges {
    ranges_m: Box<[f32; MAX_BEAMS]>,
    beams: usize,
    angle_step_rad: f32,
    sample_step_m: f32,
    /// Directions of the beams, and the sensor, in `base_link`.
    directions: Box<[Point2]>,
    sensor: Point2,
}

impl KnownRanges {
    /// Nothing known: all blocked.
    #[must_use]
    pub fn new(geometry: &ScanGeometry, sample_step_m: f64) -> Self {
        Self {
            ranges_m: Box::new([0.0; MAX_BEAMS]),
            beams: geometry.beams.min(MAX_BEAMS),
            angle_step_rad: geometry.angle_step_rad as f32,
            sample_step_m: sample_step_m as f32,
            directions: (0..geometry.beams)
                .map(|beam| {
                    let angle_rad = geometry.mount.theta_rad + geometry.beam_angle_rad(beam);
                    Point2::new(angle_rad.cos(), angle_rad.sin())
                })
                .collect(),
            sensor: geometry.mount.position(),
        }
    }

    /// Takes ranges as `AlignedScan::ranges_m` gives them, negative or NaN where unknown. Extra beams are ignored,
    /// missing ones are unknown.
    pub fn load(&mut self, ranges_m: &[f32]) {
        let mut beam = 0;
        let range_at = |beam: usize| {
            ranges_m
                .get(beam)
                .copied()
                .filter(|range_m| *range_m >= 0.0)
        };
        while beam < self.beams {
            if let Some(range_m) = range_at(beam) {
                self.ranges_m[beam] = range_m;
                beam += 1;
                continue;
            }
            let end = (beam..self.beams)
                .find(|&next| range_at(next).is_some())
                .unwrap_or(self.beams);
            let before = beam.checked_sub(1).and_then(range_at);
            let after = range_at(end);
            let gap_rad = self.angle_step_rad * (end - beam + 1) as f32;
            let free_m = match (before, after) {
                (Some(before), Some(after)) => before.min(after).min(self.sample_step_m / gap_rad),
                // At the edge of the view the other half of a thing may lie outside.
                (Some(one), None) | (None, Some(one)) => {
                    one.min(self.sample_step_m / (2.0 * gap_rad))
                }
                (None, None) => 0.0,
            };
            self.ranges_m[beam..end].fill(free_m);
            beam = end;
        }
    }

    /// How far a strip of floor from `base_link` in a direction is free: up to the nearest end of a beam inside it.
    #[must_use]
    pub fn strip_m(&self, direction_rad: f64, half_width_m: f64) -> f64 {
        let (sin, cos) = direction_rad.sin_cos();
        let along = Point2::new(cos, sin);
        let mut free_m = f64::INFINITY;
        for (&range_m, &direction) in self.ranges_m.iter().zip(&*self.directions) {
            let end = self.sensor + direction * f64::from(range_m);
            let ahead_m = along.dot(end);
            if ahead_m > 0.0 && along.cross(end).abs() < half_width_m {
                free_m = free_m.min(ahead_m);
            }
        }
        free_m
    }

    /// Free range of every beam.
    #[must_use]
    pub fn as_array(&self) -> &[f32; MAX_BEAMS] {
        &self.ranges_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use description::geometry::Pose2;

    fn known(ranges_m: &[f32]) -> KnownRanges {
        let geometry = ScanGeometry::urg_04lx(Pose2::IDENTITY, 4.0);
        let mut known = KnownRanges::new(&geometry, 0.05);
        known.load(ranges_m);
        known
    }

    #[test]
    fn known_beams_stay_as_they_are() {
        let ranges_m: Vec<f32> = (0..682).map(|beam| 0.5 + beam as f32 * 1e-3).collect();
        assert_eq!(&known(&ranges_m).as_array()[..682], &ranges_m[..]);
    }

    #[test]
    fn a_narrow_unknown_takes_its_nearer_neighbour() {
        let mut ranges_m = vec![3.0; 682];
        ranges_m[101] = 2.0;
        ranges_m[100] = -1.0;
        assert_eq!(known(&ranges_m).as_array()[100], 2.0);
    }

    #[test]
    fn a_wide_unknown_is_blocked_where_it_spans_a_sample() {
        let mut ranges_m = vec![4.0; 682];
        ranges_m[100..109].fill(-1.0);
        // Ten steps of 0.00614 rad span 0.05 m at 0.81 m.
        let free_m = known(&ranges_m).as_array()[104];
        assert!((free_m - 0.815).abs() < 0.002, "{free_m}");
        ranges_m[..50].fill(f32::NAN);
        let free_m = known(&ranges_m).as_array()[0];
        assert!(free_m < 0.1, "{free_m}");
    }

    #[test]
    fn nothing_known_is_nothing_free() {
        for ranges_m in [vec![-1.0; 682], vec![], vec![f32::NAN; 682]] {
            assert!(known(&ranges_m).as_array()[..682].iter().all(|&r| r == 0.0));
        }
    }
}
