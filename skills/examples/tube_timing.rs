//! How long motion tubes take on this machine: `cargo run --release -p skills --example tube_timing`.
//!
//! One lap of the loop over all tubes is timed many times; the median lap is shown, in a corridor where every tube
//! near straight ahead is free, which is the slow case: a blocked tube is left early.

use skills::geometry::{Footprint, MotionCommand, Pose2, Twist2};
use skills::history::OdometryHistory;
use skills::scan::{AlignedScan, ScanGeometry};
use skills::tubes::{AdaptPolicy, KnownRanges, MotionTubes, Surroundings, TubeParameters, TubeSet};
use std::hint::black_box;
use std::time::{Duration, Instant};

fn median(mut lap: impl FnMut(), laps: usize) -> Duration {
    let mut times: Vec<Duration> = (0..laps)
        .map(|_| {
            let begin = Instant::now();
            lap();
            begin.elapsed()
        })
        .collect();
    times.sort_unstable();
    times[laps / 2]
}

fn corridor_mm(geometry: &ScanGeometry) -> Vec<u16> {
    (0..geometry.beams)
        .map(|beam| {
            let (sin, cos) = geometry.beam_angle_rad(beam).sin_cos();
            let side_m: f64 = if sin > 0.0 { 2.1 } else { 1.1 };
            let range_m = (side_m / sin.abs()).min(6.0 / cos.max(1e-3));
            if range_m < 4.0 {
                (range_m * 1e3) as u16
            } else {
                0
            }
        })
        .collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let geometry = ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0);
    let footprint = Footprint {
        front_m: 0.32,
        rear_m: 0.08,
        left_m: 0.15,
        right_m: 0.15,
    };
    let raw = corridor_mm(&geometry);
    for d_sample_m in [0.05, 0.1, 0.2] {
        let parameters = TubeParameters {
            d_sample_m,
            d_aug_m: d_sample_m / 2.0 + 0.02,
            ..TubeParameters::default()
        };
        let begin = Instant::now();
        let (set, report) = TubeSet::generate(&parameters, &footprint, &geometry)?;
        let generation = begin.elapsed();
        println!(
            "d_sample {d_sample_m} m: {}",
            report.to_string().lines().next().unwrap_or("")
        );
        println!(
            "  generation of the whole set: {:.1} ms",
            generation.as_secs_f64() * 1e3
        );

        let mut history = OdometryHistory::default();
        let mut scan = AlignedScan::new(geometry)?.without_frozen_check();
        let mut tubes = MotionTubes::new(set.clone(), AdaptPolicy::default())?;
        let mut now_ns = 0;
        let mut look = |tubes: &mut MotionTubes, now_ns: &mut u64| {
            let stamp_ns = *now_ns + 1;
            for _ in 0..20 {
                *now_ns += 5_000_000;
                let pose = Pose2::new(*now_ns as f64 * 0.4e-9, 0.0, 0.0);
                let _ = history.push(*now_ns, pose, Twist2::new(0.4, 0.0));
            }
            let begin = Instant::now();
            let aligned = scan.align(&raw, stamp_ns + 30_000_000, &history);
            let align = begin.elapsed();
            let begin = Instant::now();
            let seen = aligned.is_ok() && tubes.observe(&scan, *now_ns).is_ok();
            (align, begin.elapsed(), seen)
        };
        let mut laps: Vec<(Duration, Duration, bool)> =
            (0..200).map(|_| look(&mut tubes, &mut now_ns)).collect();
        laps.retain(|lap| lap.2);
        laps.sort_unstable_by_key(|lap| lap.1);
        let middle = laps[laps.len() / 2];
        println!(
            "  a scan: aligned in {:.1} µs, all tubes, memory and clearance in {:.1} µs",
            middle.0.as_secs_f64() * 1e6,
            middle.1.as_secs_f64() * 1e6
        );

        let mut known = KnownRanges::new(&geometry, d_sample_m);
        known.load(scan.ranges_m());
        let occupied = tubes.memory().occupied().to_vec();
        let near = Surroundings {
            occupied: &occupied,
            unknown: &occupied,
        };
        let free: Vec<_> = set
            .ids()
            .filter(|&id| set.is_free(id, &known, near))
            .collect();
        let samples: usize = free.iter().map(|&id| set.samples(id)).sum();
        let lap = median(
            || {
                for &id in &free {
                    black_box(set.is_free(id, black_box(&known), near));
                }
            },
            20_001,
        );
        let per_tube_ns = lap.as_secs_f64() * 1e9 / free.len() as f64;
        println!(
            "  evaluation: {} free tubes of {:.0} samples, {:.0} ns per tube, {:.0} tubes per ms",
            free.len(),
            samples as f64 / free.len() as f64,
            per_tube_ns,
            1e6 / per_tube_ns
        );
        let adapt = median(
            || {
                let wanted = MotionCommand::new(0.4, 0.05);
                black_box(tubes.adapt(black_box(wanted), Twist2::new(0.4, 0.0), now_ns));
            },
            2_001,
        );
        println!("  a command adapted in {:.2} µs", adapt.as_secs_f64() * 1e6);
    }
    Ok(())
}
