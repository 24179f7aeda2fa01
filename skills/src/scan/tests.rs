//! Tests of `scan`.

use super::*;
use crate::history::OdometryHistory;
use description::geometry::{Point2, Pose2, Segment, Twist2};

const MS: u64 = 1_000_000;

fn urg() -> ScanGeometry {
    ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0)
}

fn history(twist: Twist2) -> OdometryHistory {
    let mut history = OdometryHistory::default();
    for i in 0..=100u64 {
        let pose = Pose2::new(1.0, -2.0, 0.7).advance(twist, i as f64 * 0.005);
        history.push(i * 5 * MS + 1, pose, twist).unwrap();
    }
    history
}

/// Ranges that the turning sensor of a moving robot measures of walls fixed in `odom`.
fn measure(
    geometry: &ScanGeometry,
    walls: &[Segment],
    history: &OdometryHistory,
    stamp_ns: u64,
) -> Vec<u16> {
    (0..geometry.beams)
        .map(|beam| {
            let at_ns =
                stamp_ns + geometry.duration_ns() * beam as u64 / (geometry.beams as u64 - 1);
            let sensor = history.at(at_ns).unwrap().compose(geometry.mount);
            let direction_rad = sensor.theta_rad + geometry.beam_angle_rad(beam);
            walls
                .iter()
                .filter_map(|wall| wall.ray_range_m(sensor.position(), direction_rad))
                .min_by(f64::total_cmp)
                .map_or(0, |range_m| (range_m * 1e3).round() as u16)
        })
        .collect()
}

#[test]
fn the_beam_at_a_point_is_the_one_nearest_to_its_direction() {
    let mount = Pose2::IDENTITY;
    let whole_turn = ScanGeometry::from_steps(mount, 1000, 500, (0, 999), 1, (0.02, 4.0), 0.1);
    let clustered = ScanGeometry::from_steps(mount, 1024, 384, (44, 725), 3, (0.02, 4.0), 0.1);
    for geometry in [urg(), whole_turn, clustered] {
        for step in 0..200_000 {
            let angle_rad = f64::from(step) * 6.4e-5 - 6.4;
            for range_m in [1e-9, 0.03, 3.9] {
                let (sin, cos) = angle_rad.sin_cos();
                let point = Point2::new(cos, sin) * range_m;
                let direction_rad = point.direction_rad();
                assert_eq!(
                    geometry.beam_at(point),
                    geometry.nearest_beam(direction_rad)
                );
                let number = geometry.beam_position(direction_rad).round() as i64;
                assert_eq!(geometry.beam_grid().beam_number(point), number);
            }
        }
    }
}

#[test]
fn the_urg_looks_where_its_data_sheet_says() {
    let geometry = urg();
    assert_eq!(geometry.beams, 682);
    assert!((geometry.beam_angle_rad(340)).abs() < 1e-12);
    assert!((geometry.angle_first_rad.to_degrees() + 119.53).abs() < 0.01);
    assert!((geometry.duration_ns() as f64 * 1e-9 - 0.0665).abs() < 1e-4);
    assert_eq!(geometry.nearest_beam(0.0), Some(340));
    assert_eq!(geometry.nearest_beam(std::f64::consts::PI), None);
    assert_eq!(geometry.nearest_beam(geometry.angle_first_rad), Some(0));
    assert_eq!(
        geometry.beam_at(Point2::default()),
        Some(340),
        "at the sensor"
    );
    let clustered =
        ScanGeometry::from_steps(geometry.mount, 1024, 384, (44, 725), 3, (0.02, 4.0), 0.1);
    assert_eq!(clustered.beams, 228);
    assert!((clustered.angle_first_rad - geometry.beam_angle_rad(1)).abs() < 1e-12);
}

#[test]
fn a_robot_that_stands_gets_its_ranges_back() {
    let geometry = urg();
    let mut scan = AlignedScan::new(geometry).unwrap();
    let raw: Vec<u16> = (0..682u16).map(|beam| 500 + (beam * 37) % 3000).collect();
    scan.align(&raw, 100 * MS, &history(Twist2::default()))
        .unwrap();
    for (range_m, raw) in scan.ranges_m().iter().zip(&raw) {
        assert!((range_m - f32::from(*raw) * 1e-3).abs() < 1e-4);
    }
}

#[test]
fn codes_are_not_lengths() {
    let mut scan = AlignedScan::new(urg()).unwrap();
    let mut raw = vec![1500u16; 682];
    raw[10] = 0;
    raw[20] = 1;
    raw[21] = 19;
    raw[30] = 20;
    raw[40] = 5600;
    raw[41] = u16::MAX;
    scan.align(&raw, 100 * MS, &history(Twist2::default()))
        .unwrap();
    let states = |beam: usize| scan.points()[beam].state;
    assert_eq!(states(10), BeamState::Free);
    assert_eq!(states(20), BeamState::Unknown);
    assert_eq!(states(21), BeamState::Unknown);
    assert_eq!(states(30), BeamState::Hit);
    assert_eq!(states(40), BeamState::Free);
    assert_eq!(states(41), BeamState::Free);
    assert!((scan.ranges_m()[10] - 4.0).abs() < 1e-5);
    assert_eq!(scan.ranges_m()[20], UNKNOWN_RANGE_M);
    assert_eq!(scan.hits().count(), 682 - 5);
}

#[test]
fn a_wall_stays_straight_while_the_robot_turns_and_drives() {
    let geometry = urg();
    let wall = Segment::new(Point2::new(-5.0, 0.0), Point2::new(9.0, 0.0));
    for twist in [
        Twist2::new(0.4, 0.0),
        Twist2::new(0.3, 0.6),
        Twist2::new(0.3, -0.6),
    ] {
        let history = history(twist);
        let stamp_ns = 200 * MS;
        let raw = measure(&geometry, &[wall], &history, stamp_ns);
        let mut scan = AlignedScan::new(geometry).unwrap();
        scan.align(&raw, stamp_ns, &history).unwrap();
        assert_eq!(scan.reference_ns(), stamp_ns + geometry.duration_ns());
        let mut hits = 0;
        for point in scan.hits() {
            assert!(wall.distance_m(scan.odom_pose().transform(point)) < 0.002);
            hits += 1;
        }
        assert!(hits > 100, "{hits} hits");
        // What the sensor would have measured had all beams been taken at the reference time.
        let sensor = scan.odom_pose().compose(geometry.mount);
        for (beam, &range_m) in scan.ranges_m().iter().enumerate() {
            let direction_rad = sensor.theta_rad + geometry.beam_angle_rad(beam);
            let true_m = wall
                .ray_range_m(sensor.position(), direction_rad)
                .unwrap_or(f64::MAX)
                .min(4.0);
            if range_m >= 0.0 && true_m < 3.0 {
                // Half a beam of direction, at the angle under which the wall is seen.
                let slack_m = 0.004 + true_m * true_m / 1.5 * geometry.angle_step_rad;
                assert!(
                    (f64::from(range_m) - true_m).abs() < slack_m,
                    "beam {beam}: {range_m} {true_m}"
                );
            }
        }
    }
}

#[test]
fn readings_nearer_than_the_least_range_are_unknown() {
    let geometry = ScanGeometry {
        range_min_m: 0.15,
        ..urg()
    };
    let mut scan = AlignedScan::new(geometry).unwrap();
    let mut raw = vec![1000; geometry.beams];
    (raw[300], raw[301], raw[302]) = (20, 149, 150);
    scan.align(&raw, 200 * MS, &history(Twist2::default()))
        .unwrap();
    let ranges_m = &scan.ranges_m()[300..303];
    assert!(ranges_m[0] < 0.0 && ranges_m[1] < 0.0, "{ranges_m:?}");
    assert!((ranges_m[2] - 0.15).abs() < 1e-4, "{ranges_m:?}");
}

#[test]
fn bad_scans_are_refused_and_change_nothing() {
    let mut scan = AlignedScan::new(urg()).unwrap();
    let history = history(Twist2::new(0.4, 0.0));
    let raw = vec![1500u16; 682];
    assert!(!scan.is_valid());
    assert!(matches!(
        scan.align(&raw[1..], 100 * MS, &history),
        Err(AlignError::BeamCount {
            expected: 682,
            found: 681
        })
    ));
    assert!(matches!(
        scan.align(&[], 100 * MS, &history),
        Err(AlignError::BeamCount { .. })
    ));
    assert!(matches!(
        scan.align(&raw, 5000 * MS, &history),
        Err(AlignError::NoOdometry { .. })
    ));
    assert!(matches!(
        scan.align(&raw, 0, &history),
        Err(AlignError::NoOdometry { .. })
    ));
    assert!(matches!(
        scan.align(&raw, u64::MAX, &history),
        Err(AlignError::NoOdometry { .. })
    ));
    assert!(!scan.is_valid());
    scan.align(&raw, 100 * MS, &history).unwrap();
    assert!(matches!(
        scan.align(&raw, 100 * MS, &history),
        Err(AlignError::NotAfter { .. })
    ));
    assert_eq!(scan.stamp_ns(), 100 * MS);
}

#[test]
fn a_frozen_source_is_found_out_when_the_robot_moves() {
    let raw = vec![1500u16; 682];
    let moving = history(Twist2::new(0.4, 0.0));
    let mut scan = AlignedScan::new(urg()).unwrap();
    scan.align(&raw, 10 * MS, &moving).unwrap();
    // Soon it says nothing of where the robot is now.
    assert!(matches!(
        scan.align(&raw, 110 * MS, &moving),
        Err(AlignError::Repeated { .. })
    ));
    assert!(matches!(
        scan.align(&raw, 400 * MS, &moving),
        Err(AlignError::Frozen { .. })
    ));
    let mut other = raw.clone();
    other[5] += 1;
    scan.align(&other, 401 * MS, &moving).unwrap();

    let standing = history(Twist2::default());
    let mut scan = AlignedScan::new(urg()).unwrap();
    scan.align(&raw, 10 * MS, &standing).unwrap();
    for repeat in 1..5 {
        let aligned = scan.align(&raw, (10 + repeat) * MS, &standing);
        assert!(matches!(aligned, Err(AlignError::Repeated { .. })));
    }
    // Too often for chance, though it stands.
    for repeat in 5..8 {
        let aligned = scan.align(&raw, (10 + repeat) * MS, &standing);
        assert!(matches!(aligned, Err(AlignError::Frozen { .. })));
    }
    scan.align(&other, 100 * MS, &standing).unwrap();
    scan.align(&raw, 400 * MS, &standing).unwrap();

    let empty = vec![0u16; 682];
    let mut scan = AlignedScan::new(urg()).unwrap();
    scan.align(&empty, 10 * MS, &moving).unwrap();
    scan.align(&empty, 400 * MS, &moving).unwrap();
}

#[test]
fn nonsense_geometry_is_refused() {
    let good = urg();
    let bad = [
        ScanGeometry { beams: 1, ..good },
        ScanGeometry {
            beams: MAX_BEAMS + 1,
            ..good
        },
        ScanGeometry {
            angle_step_rad: 0.0,
            ..good
        },
        ScanGeometry {
            angle_step_rad: -0.01,
            ..good
        },
        ScanGeometry {
            angle_step_rad: 0.1,
            ..good
        },
        ScanGeometry {
            angle_first_rad: f64::NAN,
            ..good
        },
        ScanGeometry {
            mount: Pose2::new(f64::INFINITY, 0.0, 0.0),
            ..good
        },
        ScanGeometry {
            range_max_m: 0.01,
            ..good
        },
        ScanGeometry {
            range_min_m: -0.1,
            ..good
        },
        ScanGeometry {
            turn_s: -0.1,
            ..good
        },
    ];
    for geometry in bad {
        assert!(AlignedScan::new(geometry).is_err(), "{geometry:?}");
    }
}
