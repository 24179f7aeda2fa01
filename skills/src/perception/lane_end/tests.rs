use super::*;
use description::robot::Navigation;

const WALL: Segment = Segment::new(Point2::new(10.0, -1.6), Point2::new(10.0, 1.6));

fn points(pose: Pose2, wall_x_m: f64) -> Vec<Point2> {
    (-14..15)
        .map(|i| {
            let wobble_m = 0.01 * (f64::from(i) * 1.7).sin();
            pose.inverse_transform(Point2::new(wall_x_m + wobble_m, 0.1 * f64::from(i)))
        })
        .collect()
}

struct Scene {
    tracker: LaneEndTracker,
    fitter: LineFitter,
}

impl Scene {
    fn new() -> Self {
        let gains = Navigation::default();
        Self {
            tracker: LaneEndTracker::new(gains),
            fitter: LineFitter::new(700, gains),
        }
    }

    fn observe(&mut self, points: &[Point2], believed: Pose2) -> Option<LaneEndEstimate> {
        self.tracker.observe(
            &mut self.fitter,
            ScanPoints::all(points),
            &WALL,
            believed,
            0.1,
        );
        self.tracker.estimate()
    }
}

#[test]
fn measures_the_wall_and_not_the_map() {
    let mut scene = Scene::new();
    let (truth, believed) = (Pose2::new(7.0, -0.5, 0.0), Pose2::new(7.2, -0.5, 0.0));
    for _ in 0..5 {
        scene.observe(&points(truth, 10.0), believed);
    }
    let end = scene.tracker.estimate().unwrap();
    assert!((end.distance_m - 3.0).abs() < 0.01, "{end:?}");
    assert!(end.seen && end.std_m < 0.01 && end.consistent_scans == 5);
}

#[test]
fn follows_the_robot_between_scans_from_either_side() {
    for (pose, wall) in [
        (Pose2::new(7.0, -0.5, 0.0), WALL),
        (Pose2::new(7.0, -0.5, 0.0), Segment::new(WALL.b, WALL.a)),
    ] {
        let mut scene = Scene::new();
        scene.tracker.observe(
            &mut scene.fitter,
            ScanPoints::all(&points(pose, 10.0)),
            &wall,
            pose,
            0.1,
        );
        let before = scene.tracker.estimate().unwrap();
        scene
            .tracker
            .predict(Pose2::new(0.3, 0.0, 0.0), pose, &wall, 0.5);
        let after = scene.tracker.estimate().unwrap();
        assert!((before.distance_m - after.distance_m - 0.3).abs() < 1e-9);
        assert!(after.std_m > before.std_m);
    }
}

#[test]
fn a_row_of_scans_without_it_is_not_stable_any_more() {
    let mut scene = Scene::new();
    let pose = Pose2::new(7.0, -0.5, 0.0);
    assert_eq!(scene.observe(&[], pose), None);
    for _ in 0..6 {
        scene.observe(&points(pose, 10.0), pose);
    }
    let once = scene.observe(&[], pose).unwrap();
    assert!(!once.seen && once.consistent_scans == 6);
    scene.observe(&[], pose);
    assert_eq!(scene.observe(&[], pose).unwrap().consistent_scans, 0);
}

#[test]
fn a_wall_that_leaps_is_searched_anew() {
    let mut scene = Scene::new();
    let pose = Pose2::new(7.0, -0.5, 0.0);
    for _ in 0..6 {
        scene.observe(&points(pose, 10.0), pose);
    }
    let leapt = points(pose, 9.9);
    let contradicted = scene.observe(&leapt, pose).unwrap();
    assert_eq!(contradicted.consistent_scans, 0);
    assert!((contradicted.distance_m - 3.0).abs() < 0.01);
    for _ in 0..4 {
        scene.observe(&leapt, pose);
    }
    let end = scene.tracker.estimate().unwrap();
    assert!(
        (end.distance_m - 2.9).abs() < 0.01 && end.consistent_scans < 3,
        "{end:?}"
    );
}

#[test]
fn a_robot_in_front_of_the_wall_is_not_it() {
    let mut scene = Scene::new();
    let pose = Pose2::new(6.0, -0.5, 0.0);
    let robot: Vec<_> = (0..40)
        .map(|i| Point2::new(3.6, -0.2 + 0.01 * f64::from(i)))
        .collect();
    assert_eq!(scene.observe(&robot, pose), None);
}

#[test]
fn what_is_not_seen_for_long_is_searched_anew_and_what_lies_askew_is_no_end() {
    let mut scene = Scene::new();
    let pose = Pose2::new(7.0, -0.5, 0.0);
    for _ in 0..6 {
        scene.observe(&points(pose, 9.4), pose);
    }
    // It was a truck: it drives away, and the wall behind it is out of the gate.
    for _ in 0..MISSES_TO_SEARCH {
        assert!(scene.tracker.estimate().is_some());
        scene.observe(&points(pose, 10.0), pose);
    }
    let end = scene.observe(&points(pose, 10.0), pose).unwrap();
    assert!((end.distance_m - 3.0).abs() < 0.01, "{end:?}");

    let mut scene = Scene::new();
    let askew = points(Pose2::new(7.0, -0.5, 0.2), 10.0);
    assert_eq!(scene.observe(&askew, pose), None);
}

/// Of a wall a little farther than the sensor sees it shows those points that noise has made shorter, which lie on a line of their own.
#[test]
fn a_wall_at_the_end_of_sight_is_not_where_its_nearest_points_are() {
    let mut scene = Scene::new();
    let sight_m = 4.0;
    for (distance_m, is_seen) in [(4.04, false), (3.98, false), (3.7, true)] {
        scene.tracker.clear();
        let pose = Pose2::new(10.0 - distance_m, 0.0, 0.0);
        let points: Vec<Point2> = (-150..150)
            .filter_map(|i| {
                let ray = Point2::new(10.0, 0.01 * f64::from(i)) - pose.position();
                // Of a standard deviation of 4 cm, as a hundredth of the range.
                let sines = [12.9898, 78.233, 37.719].map(|turn| (f64::from(i) * turn).sin());
                let noise_m = 0.04 * (2.0_f64 / 3.0).sqrt() * sines.iter().sum::<f64>();
                let range_m = ray.norm_m();
                (range_m + noise_m < sight_m).then(|| ray * ((range_m + noise_m) / range_m))
            })
            .collect();
        assert!(points.len() >= 10, "{distance_m} m: {}", points.len());
        let points = ScanPoints {
            points: &points,
            eye: Point2::default(),
            sight_m,
        };
        let tracker = &mut scene.tracker;
        let fit = tracker.observe(&mut scene.fitter, points, &WALL, pose, 0.1);
        assert_eq!(fit.is_some(), is_seen, "{distance_m} m: {fit:?}");
        if let Some(end) = tracker.estimate() {
            assert!((end.distance_m - distance_m).abs() < 0.02, "{end:?}");
        }
    }
}
