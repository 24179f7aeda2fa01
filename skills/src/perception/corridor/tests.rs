use super::*;
use crate::map::SemanticMap;
use description::geometry::{Point2, Segment};
use description::robot::Navigation;
use description::site::{Lane, Site, Wall};

fn map(both: bool) -> SemanticMap {
    let wall = |id: &str, y_m| Wall {
        id: id.into(),
        line: Segment::new(Point2::new(0.0, y_m), Point2::new(10.0, y_m)),
    };
    let mut walls = vec![wall("south", -1.6)];
    if both {
        walls.push(wall("north", 1.6));
    }
    SemanticMap::new(&Site {
        walls,
        lanes: vec![Lane {
            id: "east".into(),
            line: Segment::new(Point2::new(1.0, -0.5), Point2::new(9.0, -0.5)),
            end_wall: None,
        }],
        ..Site::default()
    })
    .unwrap()
}

/// Points on the walls at these distances, as seen from `pose`.
fn points(pose: Pose2, walls_m: &[f64]) -> Vec<Point2> {
    let seen = |&y_m: &f64| {
        (-15..20).map(move |i| {
            let wobble_m = 0.01 * (f64::from(i) * 1.7).sin();
            pose.inverse_transform(Point2::new(5.0 + 0.1 * f64::from(i), y_m + wobble_m))
        })
    };
    walls_m.iter().flat_map(seen).collect()
}

struct Scene {
    map: SemanticMap,
    tracker: CorridorTracker,
    fitter: LineFitter,
}

impl Scene {
    fn new(both: bool) -> Self {
        let gains = Navigation::default();
        let mut scene = Self {
            map: map(both),
            tracker: CorridorTracker::new(gains),
            fitter: LineFitter::new(700, gains),
        };
        scene.restart(Pose2::new(5.0, -0.5, 0.0));
        scene
    }

    fn restart(&mut self, pose: Pose2) {
        self.tracker.start(&self.map.lanes()[0], pose, 0.1, 0.1);
    }

    fn observe(&mut self, points: &[Point2]) -> CorridorEstimate {
        let lane = &self.map.lanes()[0];
        self.tracker
            .observe(&mut self.fitter, ScanPoints::all(points), lane, 4.0);
        self.tracker.estimate().unwrap()
    }
}

#[test]
fn both_walls_tell_offset_and_heading() {
    let mut scene = Scene::new(true);
    let truth = Pose2::new(5.0, -0.42, 0.05);
    for _ in 0..3 {
        scene.observe(&points(truth, &[1.6, -1.6]));
    }
    let estimate = scene.tracker.estimate().unwrap();
    assert!((estimate.lateral_m - 0.08).abs() < 0.01, "{estimate:?}");
    assert!((estimate.heading_rad - 0.05).abs() < 0.01, "{estimate:?}");
    assert!(estimate.left_seen && estimate.right_seen && estimate.usable);
    assert_eq!(estimate.consistent_scans, 3);
    assert!(estimate.quality > 0.9);
}

#[test]
fn one_wall_is_enough() {
    let mut scene = Scene::new(true);
    let truth = Pose2::new(5.0, -0.55, -0.04);
    for _ in 0..4 {
        scene.observe(&points(truth, &[-1.6]));
    }
    let estimate = scene.tracker.estimate().unwrap();
    assert!((estimate.lateral_m + 0.05).abs() < 0.01, "{estimate:?}");
    assert!((estimate.heading_rad + 0.04).abs() < 0.01, "{estimate:?}");
    assert!(!estimate.left_seen && estimate.right_seen && estimate.quality < 0.6);
    let mut scene = Scene::new(false);
    let estimate = scene.observe(&points(truth, &[1.6, -1.6]));
    assert!(!estimate.left_seen && estimate.right_seen);
}

#[test]
fn between_scans_it_follows_odometry_and_grows_less_certain() {
    let mut scene = Scene::new(true);
    let seen = scene.observe(&points(Pose2::new(5.0, -0.5, 0.0), &[1.6, -1.6]));
    for _ in 0..100 {
        scene.tracker.predict(Pose2::new(0.01, 0.0, 0.002), 0.025);
    }
    let moved = scene.tracker.estimate().unwrap();
    assert!((moved.heading_rad - 0.2).abs() < 0.01);
    assert!((moved.lateral_m - 0.1).abs() < 0.02, "{moved:?}");
    assert!(moved.lateral_std_m > 2.0 * seen.lateral_std_m);
    for _ in 0..1000 {
        scene.tracker.predict(Pose2::new(0.01, 0.0, 0.0), 0.025);
    }
    assert!(!scene.tracker.estimate().unwrap().usable);
}

#[test]
fn nothing_seen_ends_the_row_of_consistent_scans() {
    let mut scene = Scene::new(true);
    scene.observe(&points(Pose2::new(5.0, -0.5, 0.0), &[1.6, -1.6]));
    let estimate = scene.observe(&[]);
    assert_eq!(estimate.consistent_scans, 0);
    assert!(!scene.tracker.is_lost());
}

#[test]
fn walls_that_insist_on_being_elsewhere_make_it_lost() {
    let mut scene = Scene::new(true);
    for _ in 0..10 {
        scene.observe(&points(Pose2::new(5.0, -0.5, 0.0), &[1.6, -1.6]));
    }
    let shifted = points(Pose2::new(5.0, -0.41, 0.0), &[1.6, -1.6]);
    let before = scene.tracker.estimate().unwrap();
    for _ in 0..REFUSALS_TO_RESTART {
        assert!(!scene.tracker.is_lost());
        scene.observe(&shifted);
    }
    assert!(scene.tracker.is_lost());
    assert!((scene.tracker.estimate().unwrap().lateral_m - before.lateral_m).abs() < 1e-9);
    scene.restart(Pose2::new(5.0, -0.5, 0.0));
    assert!((scene.observe(&shifted).lateral_m - 0.09).abs() < 0.02);
}

#[test]
fn nothing_is_expected_in_an_opening_and_every_piece_counts() {
    let wall = |id: &str, ax, ay, bx, by| Wall {
        id: id.into(),
        line: Segment::new(Point2::new(ax, ay), Point2::new(bx, by)),
    };
    // To the right: wall, opening, and a wall that is set back.
    let map = SemanticMap::new(&Site {
        walls: vec![
            wall("near", 0.0, -1.2, 4.2, -1.2),
            wall("far", 5.6, -1.5, 10.0, -1.5),
        ],
        lanes: vec![Lane {
            id: "east".into(),
            line: Segment::new(Point2::new(1.0, -0.5), Point2::new(9.0, -0.5)),
            end_wall: None,
        }],
        ..Site::default()
    })
    .unwrap();
    let lane = &map.lanes()[0];
    let gains = Navigation::default();
    let mut tracker = CorridorTracker::new(gains);
    let mut fitter = LineFitter::new(700, gains);
    let truth = Pose2::new(5.0, -0.46, 0.03);
    tracker.start(lane, Pose2::new(5.0, -0.5, 0.0), 0.1, 0.1);
    let seen = |from: f64, to: f64, y_m: f64| {
        let count = ((to - from) / 0.05) as i32;
        (0..count).map(move |i| {
            let wobble_m = 0.01 * (f64::from(i) * 1.7).sin();
            truth.inverse_transform(Point2::new(from + 0.05 * f64::from(i), y_m + wobble_m))
        })
    };
    // A box in the opening, in line with the near wall, is on no wall.
    let points: Vec<_> = seen(3.0, 4.2, -1.2)
        .chain(seen(4.3, 5.5, -1.08))
        .chain(seen(5.6, 7.5, -1.5))
        .collect();
    for _ in 0..4 {
        let walls = tracker.observe(&mut fitter, ScanPoints::all(&points), lane, 4.0);
        let lines: Vec<f64> = walls.fits().map(|(wall, _)| wall.line.a.y_m).collect();
        assert_eq!(lines, [-1.2, -1.5]);
    }
    let estimate = tracker.estimate().unwrap();
    assert!((estimate.lateral_m - 0.04).abs() < 0.01, "{estimate:?}");
    assert!((estimate.heading_rad - 0.03).abs() < 0.01, "{estimate:?}");
    assert!(estimate.right_seen && !estimate.left_seen);
    // Where no piece is near, nothing is looked for.
    let none = tracker.observe(&mut fitter, ScanPoints::all(&points), lane, 40.0);
    assert_eq!(none.fits().count(), 0);
}
