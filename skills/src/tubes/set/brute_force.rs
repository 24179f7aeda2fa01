//! What a set of tubes is measured against, not for robots: every tube is a limit for every beam of the scan, all of them compared. By the
//! vector unit where the compiler may: four at a time on x86-64, which is built for SSE2; one by one on ARMv7, whose NEON is not IEEE 754.

use super::tube_set::{TubeId, TubeSet};
use crate::tubes::memory::known::KnownRanges;

/// A limit per tube for every beam.
#[derive(Clone, Debug)]
pub struct BruteForce {
    /// Of each tube, metres; less than any range where it does not compare.
    limits_m: Vec<Vec<f32>>,
}

impl BruteForce {
    /// The same tubes.
    #[must_use]
    pub fn of(set: &TubeSet) -> Self {
        let limits = |id| {
            let mut limits_m = vec![-1.0_f32; set.geometry().beams];
            for (beam, range_m) in set.compared(id) {
                limits_m[beam] = limits_m[beam].max(range_m);
            }
            limits_m
        };
        Self {
            limits_m: set.ids().map(limits).collect(),
        }
    }

    /// Whether every beam measures farther than the tube reaches. What was seen before, out of view, is not asked.
    ///
    /// # Panics
    /// When the tube is of another set.
    #[must_use]
    pub fn is_free(&self, id: TubeId, known: &KnownRanges) -> bool {
        let limits_m = &self.limits_m[id.0 as usize];
        // No early way out, so that the compiler may compare several at once.
        { known.as_array().iter().zip(limits_m) }
            .fold(true, |all, (range_m, limit_m)| all & (range_m > limit_m))
    }
}

#[cfg(test)]
mod tests {
    use description::geometry::{Footprint, Pose2};
    use description::robot::Tubes;

    use super::*;
    use crate::scan::ScanGeometry;
    use crate::tubes::Surroundings;

    #[test]
    fn it_comes_to_the_same_where_nothing_is_remembered() {
        let geometry = ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0);
        let footprint = Footprint {
            front_m: 0.32,
            rear_m: 0.08,
            left_m: 0.15,
            right_m: 0.15,
        };
        let parameters = Tubes {
            omega_steps: 41,
            ..Tubes::default()
        };
        let set = TubeSet::generate(&parameters, &footprint, &geometry);
        let (set, _) = set.expect("tubes");
        let brute = BruteForce::of(&set);
        let nothing = vec![0; set.grid().words()];
        let near = Surroundings {
            occupied: &nothing,
            unknown: &nothing,
            unassumed: &nothing,
        };
        let mut known = KnownRanges::new(&geometry, parameters.sample_step_m);
        let mut seen = [0, 0];
        for wall_m in [0.1, 0.4, 0.8, 1.5, 3.9_f32] {
            // To the left it is half as far.
            let range_m = |beam| wall_m * if beam < geometry.beams / 2 { 1.0 } else { 0.5 };
            known.load(&(0..geometry.beams).map(range_m).collect::<Vec<_>>());
            for id in set.ids().filter(|id| !set.is_refused(*id)) {
                let free = set.is_free(id, &known, near);
                assert_eq!(brute.is_free(id, &known), free, "{id:?} at {wall_m} m");
                seen[usize::from(free)] += 1;
            }
        }
        assert!(seen.iter().all(|count| *count > 10), "{seen:?}");
    }
}
