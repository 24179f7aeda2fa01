use super::view::View;
use super::*;
use crate::history::OdometryHistory;
use crate::map::SemanticMap;
use crate::scan::{AlignedScan, ScanGeometry};
use description::geometry::{Point2, Pose2, Segment, Twist2};
use description::robot::Navigation;
use description::site::{Site, Wall};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

fn segment(ax: f64, ay: f64, bx: f64, by: f64) -> Segment {
    Segment::new(Point2::new(ax, ay), Point2::new(bx, by))
}

fn map(walls: &[Segment]) -> SemanticMap {
    let walls = walls.iter().enumerate().map(|(index, &line)| Wall {
        id: index.to_string(),
        line,
    });
    SemanticMap::new(&Site {
        walls: walls.collect(),
        ..Site::default()
    })
    .unwrap()
}

/// What a lidar in the middle of the robot at `truth` sees of what stands there, with a wobble for noise.
fn scan(standing: &[Segment], truth: Pose2) -> AlignedScan {
    let lidar = ScanGeometry {
        turn_s: 0.0,
        ..ScanGeometry::urg_04lx(Pose2::IDENTITY, 4.0)
    };
    let beam = |beam: usize| {
        let direction_rad = truth.theta_rad + lidar.beam_angle_rad(beam);
        let ranges = standing
            .iter()
            .filter_map(|line| line.ray_range_m(truth.position(), direction_rad));
        let range_m = ranges.fold(f64::INFINITY, f64::min);
        let wobble_m = 0.01 * (beam as f64 * 2.4).sin();
        if range_m < 4.0 {
            ((range_m + wobble_m) * 1e3) as u16
        } else {
            0
        }
    };
    let raw: Vec<u16> = (0..lidar.beams).map(beam).collect();
    let mut history = OdometryHistory::new(4);
    for stamp_ns in [1, 1_000_000_000] {
        history
            .push(stamp_ns, Pose2::IDENTITY, Twist2::default())
            .unwrap();
    }
    let mut scan = AlignedScan::new(lidar).unwrap();
    scan.align(&raw, 500_000_000, &history).unwrap();
    scan
}

fn known_to(std_m: f64, std_rad: f64) -> Matrix3<f64> {
    let variance = std_m * std_m;
    Matrix3::from_diagonal(&Vector3::new(variance, variance, std_rad * std_rad))
}

/// The walls that are recognised, and how the beams agree.
fn look(
    walls: &[Segment],
    standing: &[Segment],
    truth: Pose2,
    believed: Pose2,
    covariance: &Matrix3<f64>,
) -> (Vec<SeenWall>, bool, BeamCounts) {
    let mut matcher = WallMatcher::new(&map(walls), 700, Navigation::default());
    let seen = matcher.observe(
        &scan(standing, truth),
        Pose2::IDENTITY,
        believed,
        covariance,
    );
    (seen.seen.to_vec(), seen.expected, seen.beams)
}

fn indices(seen: &[SeenWall]) -> Vec<usize> {
    let mut walls: Vec<usize> = seen.iter().map(|seen| seen.wall).collect();
    walls.sort_unstable();
    walls
}

/// A corridor with an opening to the south, and a wall behind the northern one.
fn site() -> Vec<Segment> {
    vec![
        segment(0.0, 1.2, 10.0, 1.2),
        segment(0.0, -1.2, 4.0, -1.2),
        segment(5.2, -1.2, 10.0, -1.2),
        segment(0.0, 2.0, 10.0, 2.0),
        segment(4.0, -3.0, 5.2, -3.0),
    ]
}

#[test]
fn walls_hide_each_other_and_openings_show_what_is_behind() {
    let walls = site();
    let truth = Pose2::new(4.5, -0.3, -0.4);
    let believed = Pose2::new(4.47, -0.28, -0.38);
    let (seen, expected, beams) = look(&walls, &walls, truth, believed, &known_to(0.03, 0.03));
    assert!(expected && beams.walls_through == 0, "{beams:?}");
    assert!(beams.agreeing + 20 > beams.expected, "{beams:?}");
    assert_eq!(indices(&seen), [0, 1, 2, 4]);
    for wall in &seen {
        let fit = &wall.fit;
        let lateral_m = wall.line.lateral_m(truth.position());
        assert!((fit.lateral_m - lateral_m).abs() < 3.0 * fit.lateral_std_m());
        let heading_rad = description::geometry::wrap_angle(
            truth.theta_rad - wall.line.direction_rad() - fit.heading_rad,
        );
        assert!(heading_rad.abs() < 3.0 * fit.heading_std_rad());
    }
    assert!(seen.is_sorted_by(|one, other| one.fit.covered_m >= other.fit.covered_m));
}

#[test]
fn a_short_wall_helps_who_knows_where_it_should_be() {
    let walls = [segment(2.0, -0.2, 2.0, 0.2)];
    let truth = Pose2::new(0.0, 0.0, 0.0);
    let sure = look(&walls, &walls, truth, truth, &known_to(0.02, 0.01));
    assert_eq!(indices(&sure.0), [0]);
    assert!((sure.0[0].fit.lateral_m.abs() - 2.0).abs() < 0.02);
    // Anything may be as long as that.
    let unsure = look(&walls, &walls, truth, truth, &known_to(0.15, 0.01));
    assert!(unsure.0.is_empty());
}

#[test]
fn a_side_with_the_wall_to_be_seen_behind_it_is_not_the_wall() {
    let wall = segment(3.0, -1.6, 3.0, 1.6);
    let truth = Pose2::IDENTITY;
    let robot = segment(2.75, -0.5, 2.75, 0.4);
    let covariance = known_to(0.1, 0.02);
    // The wall beside it is seen, and taken.
    let (seen, _, beams) = look(&[wall], &[wall, robot], truth, truth, &covariance);
    assert_eq!((indices(&seen), beams.walls_through), (vec![0], 0));
    assert!((seen[0].fit.lateral_m.abs() - 3.0).abs() < 0.02);
    // It is out of sight, but then nothing should be seen beside the robot.
    let far = Pose2::new(-0.95, 0.0, 0.0);
    let long = [wall, segment(2.75, -0.6, 2.75, 0.6)];
    let (seen, _, _) = look(&[wall], &long, far, far, &covariance);
    assert!(seen.is_empty(), "{seen:?}");
}

#[test]
fn looking_through_a_wall_is_told_and_being_hidden_is_not() {
    let walls = [segment(2.0, -1.6, 2.0, 1.6)];
    let covariance = known_to(0.02, 0.01);
    let truth = Pose2::IDENTITY;
    let (seen, expected, beams) = look(&walls, &[], truth, truth, &covariance);
    assert_eq!((seen.len(), expected, beams.walls_through), (0, true, 1));
    let people = [segment(1.0, -1.0, 1.2, 1.0), segment(0.9, 1.0, 0.5, 3.0)];
    let (seen, expected, beams) = look(&walls, &people, truth, truth, &covariance);
    assert_eq!((seen.len(), expected, beams.walls_through), (0, true, 0));
    let (seen, expected, _) = look(
        &[segment(9.0, -1.6, 9.0, 1.6)],
        &[],
        truth,
        truth,
        &covariance,
    );
    assert!(seen.is_empty() && !expected);
}

#[test]
fn nonsense_shows_nothing() {
    let walls = site();
    let truth = Pose2::new(4.5, -0.3, -0.4);
    for (pose, covariance) in [
        (Pose2::new(f64::NAN, 0.0, 0.0), known_to(0.1, 0.1)),
        (truth, known_to(f64::INFINITY, 0.1)),
    ] {
        let (seen, expected, beams) = look(&walls, &walls, truth, pose, &covariance);
        assert!(seen.is_empty() && !expected && beams == BeamCounts::default());
    }
    // In the middle of a wall, or at its end, there is no telling either.
    for place in [Pose2::new(2.0, 1.2, 0.0), Pose2::new(4.0, -1.2, PI)] {
        let _ = look(&walls, &walls, place, place, &known_to(0.1, 0.1));
    }
}

#[test]
fn the_view_tells_the_nearest_wall_all_around() {
    let mut view = View::new();
    let walls = [
        segment(-2.0, -1.0, -2.0, 1.0),
        segment(-3.0, -3.0, -3.0, 3.0),
        segment(1.0, 5.0, 2.0, 5.0),
    ];
    view.look(&walls, Pose2::IDENTITY, 4.0);
    let at = |angle_rad: f64| {
        let ray = Point2::new(angle_rad.cos(), angle_rad.sin());
        view.expected(ray, 0.0).nearest
    };
    for angle_rad in [PI, -PI + 0.1, PI - 0.1] {
        let (wall, range_m) = at(angle_rad).unwrap();
        assert!(wall == 0 && (range_m + 2.0 / angle_rad.cos()).abs() < 0.02);
    }
    // Beside the nearer one shows the farther one, as far as it reaches and the sensor sees.
    assert_eq!(at(PI - 0.6).unwrap().0, 1);
    assert!(at(PI - 0.77).is_none() && at(0.0).is_none() && at(1.3).is_none());
    let ray = Point2::new((PI - 0.4).cos(), (PI - 0.4).sin());
    let around: Vec<usize> = view.expected(ray, 0.15).walls().collect();
    assert!(around.contains(&0) && around.contains(&1));
}

#[test]
fn a_wall_seen_from_its_own_line_hides_nothing() {
    let mut view = View::new();
    let walls = [
        segment(1.0, 0.0, 2.0, 0.0),
        segment(-1.0, 0.0, 1.0, 0.0),
        segment(3.0, -1.0, 3.0, 1.0),
    ];
    view.look(&walls, Pose2::IDENTITY, 4.0);
    let (wall, range_m) = view.expected(Point2::new(1.0, 0.0), 0.0).nearest.unwrap();
    assert!(wall == 2 && (range_m - 3.0).abs() < 0.01);
}

#[test]
fn a_scan_of_nothing_is_blind_where_walls_are_and_nowhere_else() {
    let side = |y_m| segment(-10.0, y_m, 10.0, y_m);
    let corridor = [side(1.5), side(-1.5)];
    let far = [side(3.5), side(-3.5)];
    let door = [segment(1.0, -0.5, 1.0, 0.5)];
    let judge_at = |mapped: &[Segment], standing: &[Segment], pose: Option<Pose2>| {
        let scan = scan(standing, Pose2::IDENTITY);
        let gains = Navigation::default();
        let mut matcher = WallMatcher::new(&map(mapped), scan.geometry().beams, gains);
        matcher.is_blind(&scan, Pose2::IDENTITY, pose)
    };
    let judge = |mapped: &[Segment], standing: &[Segment]| {
        judge_at(mapped, standing, Some(Pose2::IDENTITY))
    };
    assert!(judge(&corridor, &[]));
    // A covered window may still reflect here and there.
    assert!(judge(&corridor, &[segment(0.3, -0.01, 0.3, 0.01)]));
    // One of both walls is black or of glass, or somebody stands there: it sees.
    assert!(!judge(&corridor, &corridor[..1]));
    assert!(!judge(&corridor, &[segment(0.5, -0.2, 0.5, 0.2)]));
    // The walls are too far off to be sure, or a door of glass is all that the map has here.
    assert!(!judge(&far, &[]));
    assert!(!judge(&door, &[]));
    assert!(!judge(&[], &[]));
    // Where it may be anywhere, it may be between walls.
    assert!(judge_at(&door, &[], None) && !judge_at(&door, &corridor[..1], None));
}
