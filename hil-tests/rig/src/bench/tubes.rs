//! Motion tubes against a scan, beside brute force: a limit per tube for every beam, all compared, four at a time on x86-64 (SSE2) and one by
//! one on ARMv7.
//!
//! The robot stands in a corridor where most tubes are free, which is the slow case: a blocked tube is left early. The set is larger than
//! a robot's, as the authors of the tubes had it.

use std::hint::black_box;
use std::time::Duration;

use description::geometry::{Footprint, Pose2};
use description::robot::{Horizon, Tubes};
use onboard::cli::Failure;
use sim::rt::monotonic_ns;
use skills::scan::ScanGeometry;
use skills::tubes::{BruteForce, KnownRanges, Surroundings, TubeId, TubeSet};

use super::promises::{Figure, Most, Promise};
use super::report::{PartReport, Unit, What};
use super::samples::Sample;
use super::windows::{Contender, Meter};

/// Where the lidar is mounted, ahead of `base_link`, and how far it sees.
const LIDAR_AHEAD_M: f64 = 0.28;
const RANGE_M: f64 = 4.0;
/// From the robot to the walls, left and right.
const WALLS_M: [f64; 2] = [2.1, 1.1];
const FOOTPRINT: Footprint = Footprint {
    front_m: 0.32,
    rear_m: 0.08,
    left_m: 0.15,
    right_m: 0.15,
};

/// A set of tubes and what the robot sees.
struct Scene {
    set: TubeSet,
    known: KnownRanges,
    /// Tubes that are not refused.
    ids: Vec<TubeId>,
    /// No cell of the grid: nothing is remembered, and no floor is missing.
    nothing: Vec<u64>,
}

impl Scene {
    /// With so many turn rates, which decides how many tubes there are.
    fn new(omega_steps: u32) -> Result<Self, Failure> {
        let parameters = Tubes {
            // About thirty samples in a tube.
            sample_step_m: 0.082,
            omega_steps,
            backward_horizons: vec![Horizon {
                horizon_s: 1.5,
                speed_m_s: 0.10,
            }],
            ..Tubes::default()
        };
        let geometry = ScanGeometry::urg_04lx(Pose2::new(LIDAR_AHEAD_M, 0.0, 0.0), RANGE_M);
        let (set, _) =
            TubeSet::generate(&parameters, &FOOTPRINT, &geometry).map_err(Failure::failed)?;
        let mut known = KnownRanges::new(&geometry, parameters.sample_step_m);
        let ranges_m = (0..geometry.beams).map(|beam| {
            let sin = geometry.beam_angle_rad(beam).sin();
            let side_m = WALLS_M[usize::from(sin <= 0.0)];
            (side_m / sin.abs().max(1e-6)).min(RANGE_M) as f32
        });
        known.load(&ranges_m.collect::<Vec<_>>());
        Ok(Self {
            ids: set.ids().filter(|&id| !set.is_refused(id)).collect(),
            nothing: vec![0; set.grid().words()],
            known,
            set,
        })
    }

    fn title(&self) -> String {
        let samples: usize = self.ids.iter().map(|&id| self.set.samples(id)).sum();
        let mean = samples as f64 / self.ids.len().max(1) as f64;
        format!("{} tubes of {mean:.0} samples", self.ids.len())
    }
}

/// Measures for so long.
///
/// # Errors
/// [`Failure`] when there are no tubes.
pub fn measure(meter: &Meter, time: Duration, part: &mut PartReport) -> Result<(), Failure> {
    /// For two thousand tubes.
    const OMEGA_STEPS: u32 = 621;
    let scene = Scene::new(OMEGA_STEPS)?;
    let title = scene.title();
    let promises = [Promise(Figure::P50, Most::Value(50.0))];
    let what = What::new(&title, Unit::Us).promising(&promises);
    meter.compare(part, &what, time, contenders(&scene))
}

fn contenders(scene: &Scene) -> Vec<Box<dyn Contender + '_>> {
    let brute = BruteForce::of(&scene.set);
    let near = Surroundings {
        occupied: &scene.nothing,
        unknown: &scene.nothing,
        unassumed: &scene.nothing,
    };
    vec![
        Box::new(Judge {
            name: "tubes",
            scene,
            is_free: move |id| scene.set.is_free(id, &scene.known, near),
        }),
        Box::new(Judge {
            name: "brute force",
            scene,
            is_free: move |id| brute.is_free(id, &scene.known),
        }),
    ]
}

/// Judges all tubes.
struct Judge<'a, F> {
    name: &'static str,
    scene: &'a Scene,
    is_free: F,
}

impl<F: Fn(TubeId) -> bool> Judge<'_, F> {
    /// How many are free.
    fn free(&self) -> usize {
        let ids = black_box(&self.scene.ids).iter();
        ids.filter(|id| (self.is_free)(**id)).count()
    }
}

impl<F: Fn(TubeId) -> bool> Contender for Judge<'_, F> {
    fn name(&self) -> String {
        self.name.to_owned()
    }

    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
        let end_ns = monotonic_ns() + length.as_nanos() as u64;
        loop {
            let began_ns = monotonic_ns();
            black_box(self.free());
            let now_ns = monotonic_ns();
            into.push(Sample::from_to(began_ns, now_ns));
            if now_ns >= end_ns {
                return Ok(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_tubes_are_free_and_each_contender_judges_all_of_them() {
        let Ok(scene) = Scene::new(41) else {
            panic!("no tubes")
        };
        let near = Surroundings {
            occupied: &scene.nothing,
            unknown: &scene.nothing,
            unassumed: &scene.nothing,
        };
        let ids = scene.ids.iter();
        let free = ids.filter(|&&id| scene.set.is_free(id, &scene.known, near));
        let free = free.count();
        assert!(2 * free > scene.ids.len(), "{free} of {}", scene.title());
        for mut contender in contenders(&scene) {
            let mut samples = Vec::new();
            let worked = contender.window(Duration::from_millis(1), &mut samples);
            assert!(worked.is_ok() && !samples.is_empty());
        }
    }
}
