//! How long motion tubes take on this machine: `cargo run --example tube_timing`.
//!
//! Every figure is of one call, timed many times: the median and the 99th percentile. The robot stands or drives in a
//! corridor where most tubes are free, which is the slow case: a blocked tube is left early.
//!
//! Tubes are compared with brute force: a limit per tube for every beam of the scan, all compared, four at a time on
//! x86-64 (SSE2), one by one on ARMv7.

use description::geometry::{Footprint, MotionCommand, Point2, Pose2, Segment, Twist2};
use description::robot::Navigation;
use description::robot::{AdaptPolicy, Horizon, Tubes};
use description::site::{Lane, Site, Wall};
use skills::history::OdometryHistory;
use skills::map::SemanticMap;
use skills::perception::corridor::CorridorTracker;
use skills::perception::line::{LineFitter, ScanPoints};
use skills::scan::{AlignedScan, ScanGeometry};
use skills::tubes::{
    BruteForce, KnownRanges, MotionTubes, StopRules, Surroundings, TubeId, TubeSet,
};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Median and 99th percentile.
struct Times(Duration, Duration);

fn times(laps: usize, mut lap: impl FnMut() -> Duration) -> Times {
    let mut times: Vec<Duration> = (0..laps).map(|_| lap()).collect();
    times.sort_unstable();
    Times(times[laps / 2], times[laps * 99 / 100])
}

fn timed(call: impl FnOnce()) -> Duration {
    let begin = Instant::now();
    call();
    begin.elapsed()
}

impl Times {
    fn show(&self, what: &str) {
        let us = |time: Duration| time.as_secs_f64() * 1e6;
        println!(
            "  {what:<58} {:>9.2} µs, p99 {:>9.2} µs",
            us(self.0),
            us(self.1)
        );
    }

    fn show_tubes(&self, what: &str, tubes: usize) {
        self.show(what);
        let ns = |time: Duration| time.as_secs_f64() * 1e9 / tubes as f64;
        println!(
            "  {:<58} {:>9.1} ns a tube, p99 {:.1} ns; {:.0} tubes per ms, at p99 {:.0}",
            "",
            ns(self.0),
            ns(self.1),
            1e6 / ns(self.0),
            1e6 / ns(self.1)
        );
    }
}

/// What the sensor sees at 0.5 m to the right of the middle of a corridor 3.2 m wide.
fn corridor_mm(geometry: &ScanGeometry) -> Vec<u16> {
    (0..geometry.beams)
        .map(|beam| {
            let (sin, _) = geometry.beam_angle_rad(beam).sin_cos();
            let side_m: f64 = if sin > 0.0 { 2.1 } else { 1.1 };
            let range_m = side_m / sin.abs().max(1e-6);
            if range_m < 4.0 {
                (range_m * 1e3) as u16
            } else {
                0
            }
        })
        .collect()
}

/// A robot that has driven along the corridor for a while.
struct Scene {
    geometry: ScanGeometry,
    raw: Vec<u16>,
    history: OdometryHistory,
    scan: AlignedScan,
    now_ns: u64,
}

impl Scene {
    fn new(geometry: ScanGeometry) -> Result<Self, Box<dyn std::error::Error>> {
        Ok(Self {
            raw: corridor_mm(&geometry),
            history: OdometryHistory::default(),
            scan: AlignedScan::new(geometry)?.without_frozen_check(),
            geometry,
            now_ns: 0,
        })
    }

    /// Drives on for 100 ms and aligns a scan; gives how long that took.
    fn next(&mut self) -> Duration {
        for _ in 0..20 {
            self.now_ns += 5_000_000;
            let pose = Pose2::new(self.now_ns as f64 * 0.4e-9, 0.0, 0.0);
            let _ = self.history.push(self.now_ns, pose, Twist2::new(0.4, 0.0));
        }
        let stamp_ns = self.now_ns - self.geometry.duration_ns();
        let Self {
            scan, raw, history, ..
        } = self;
        timed(|| {
            let _ = black_box(scan.align(black_box(raw), stamp_ns, history));
        })
    }
}

/// One set of tubes: generation, reaction to a scan, evaluation beside brute force.
fn measure(name: &str, parameters: &Tubes) -> Result<(), Box<dyn std::error::Error>> {
    let geometry = ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0);
    let footprint = Footprint {
        front_m: 0.32,
        rear_m: 0.08,
        left_m: 0.15,
        right_m: 0.15,
    };
    let begin = Instant::now();
    let (set, report) = TubeSet::generate(parameters, &footprint, &geometry)?;
    let generation = begin.elapsed();
    println!(
        "{name}: {}",
        report.to_string().lines().next().unwrap_or("")
    );
    println!("  generated in {:.1} ms", generation.as_secs_f64() * 1e3);
    let mut scene = Scene::new(geometry)?;
    let mut tubes = MotionTubes::new(set.clone(), AdaptPolicy::default(), StopRules::default())?;
    let mut observe = || {
        scene.next();
        timed(|| {
            let _ = black_box(tubes.observe(&scene.scan, scene.now_ns));
        })
    };
    times(2_000, &mut observe).show("a scan: memory, floor, motion, all tubes, clearance");

    let mut known = KnownRanges::new(&geometry, parameters.sample_step_m);
    known.load(scene.scan.ranges_m());
    let occupied = tubes.memory().occupied().to_vec();
    let nothing = vec![0; occupied.len()];
    let near = Surroundings {
        occupied: &occupied,
        unknown: &nothing,
        unassumed: &nothing,
    };
    let usable: Vec<TubeId> = set.ids().filter(|&id| !set.is_refused(id)).collect();
    let free: Vec<TubeId> = usable
        .iter()
        .copied()
        .filter(|&id| set.is_free(id, &known, near))
        .collect();
    let mean = |ids: &[TubeId]| {
        ids.iter().map(|&id| set.samples(id)).sum::<usize>() as f64 / ids.len() as f64
    };
    let evaluate = |ids: &[TubeId]| {
        times(5_000, || {
            timed(|| {
                for &id in ids {
                    black_box(set.is_free(id, black_box(&known), near));
                }
            })
        })
    };
    let what = format!("{} tubes of {:.0} samples", usable.len(), mean(&usable));
    evaluate(&usable).show_tubes(&what, usable.len());
    let what = format!("  of these the {} free, of {:.0}", free.len(), mean(&free));
    evaluate(&free).show_tubes(&what, free.len());
    let all = BruteForce::of(&set);
    let brute = times(2_000, || {
        timed(|| {
            for &id in &usable {
                black_box(all.is_free(id, black_box(&known)));
            }
        })
    });
    let what = format!(
        "brute force: {} tubes of {} beams",
        usable.len(),
        geometry.beams
    );
    brute.show_tubes(&what, usable.len());
    let adapt = times(5_000, || {
        let wanted = MotionCommand::new(0.4, 0.05);
        timed(|| {
            black_box(tubes.adapt(black_box(wanted), Twist2::new(0.4, 0.0), scene.now_ns));
        })
    });
    adapt.show("a command adapted");
    Ok(())
}

fn measure_scan() -> Result<(), Box<dyn std::error::Error>> {
    let geometry = ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0);
    let mut scene = Scene::new(geometry)?;
    times(2_000, || scene.next()).show("a scan of 682 beams aligned to the motion");

    let wall = |id: &str, y_m: f64| Wall {
        id: id.into(),
        line: Segment::new(Point2::new(-10.0, y_m), Point2::new(10.0, y_m)),
    };
    let map = SemanticMap::new(&Site {
        walls: vec![wall("south", -1.1), wall("north", 2.1)],
        lanes: vec![Lane {
            id: "east".into(),
            line: Segment::new(Point2::new(-9.0, 0.0), Point2::new(9.0, 0.0)),
            end_wall: None,
        }],
        ..Site::default()
    })?;
    let lane = &map.lanes()[0];
    let gains = Navigation::default();
    let mut tracker = CorridorTracker::new(gains);
    let mut fitter = LineFitter::new(geometry.beams, gains);
    tracker.start(lane, Pose2::IDENTITY, 0.1, 0.1);
    let points: Vec<Point2> = scene.scan.hits().collect();
    let seen = ScanPoints {
        points: &points,
        eye: geometry.mount.position(),
        sight_m: geometry.range_max_m,
    };
    let fit = times(2_000, || {
        timed(|| {
            black_box(tracker.observe(&mut fitter, black_box(seen), lane, 9.0));
        })
    });
    fit.show("corridor fit: both walls");
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("scan");
    measure_scan()?;
    let amr_1 = Tubes {
        backward_horizons: vec![Horizon {
            horizon_s: 1.5,
            speed_m_s: 0.10,
        }],
        ..Tubes::default()
    };
    measure("robot file amr-1", &amr_1)?;
    // Rows and turn rates for more than two thousand usable tubes.
    measure(
        "large set",
        &Tubes {
            sample_step_m: 0.082,
            omega_steps: 621,
            ..amr_1
        },
    )?;
    Ok(())
}
