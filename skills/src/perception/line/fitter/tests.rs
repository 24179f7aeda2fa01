use super::*;
use description::geometry::Pose2;

fn wall_points(wall: &Segment, pose: Pose2, noise_m: f64) -> Vec<Point2> {
    (0..120)
        .map(|i| {
            let along = wall.a + (wall.b - wall.a) * (f64::from(i) / 119.0);
            let wobble = noise_m * (f64::from(i) * 2.4).sin();
            let inner = pose.inverse_transform(along);
            inner + inner * (wobble / inner.norm_m())
        })
        .collect()
}

fn fitter() -> LineFitter {
    LineFitter::new(700, Navigation::default())
}

#[test]
fn finds_offset_and_heading_of_a_wall_that_is_elsewhere_than_expected() {
    let wall = Segment::new(Point2::new(0.0, 1.6), Point2::new(4.0, 1.6));
    let truth = Pose2::new(1.0, -0.43, 0.07);
    let expected = wall.seen_from(Pose2::new(1.05, -0.5, 0.0));
    let points = wall_points(&wall, truth, 0.01);
    let fit = fitter()
        .fit(ScanPoints::all(&points), &expected, 0.4, 0.4)
        .unwrap();
    assert!(
        (fit.lateral_m - wall.lateral_m(truth.position())).abs() < 0.01,
        "{fit:?}"
    );
    assert!((fit.heading_rad - 0.07).abs() < 0.01, "{fit:?}");
    assert!(fit.lateral_std_m() < 0.02 && fit.heading_std_rad() < 0.01);
}

#[test]
fn what_stands_before_the_wall_does_not_pull_it() {
    let wall = Segment::new(Point2::new(0.0, 1.6), Point2::new(4.0, 1.6));
    let truth = Pose2::new(1.0, -0.5, 0.0);
    let mut points = wall_points(&wall, truth, 0.01);
    for (i, point) in points.iter_mut().enumerate() {
        if (30..75).contains(&i) {
            point.y_m -= 0.15;
        }
    }
    let expected = wall.seen_from(truth);
    let fit = fitter()
        .fit(ScanPoints::all(&points), &expected, 0.4, 0.4)
        .unwrap();
    assert!((fit.lateral_m + 2.1).abs() < 0.01, "{fit:?}");
    assert!(fit.share < 0.7);
}

#[test]
fn too_few_points_or_a_short_piece_is_no_wall() {
    let wall = Segment::new(Point2::new(0.0, 1.6), Point2::new(4.0, 1.6));
    let truth = Pose2::new(1.0, -0.5, 0.0);
    let points = wall_points(&wall, truth, 0.0);
    let expected = wall.seen_from(truth);
    assert!(
        fitter()
            .fit(ScanPoints::all(&points[..6]), &expected, 0.4, 0.4)
            .is_none()
    );
    let short: Vec<_> = (0..40)
        .map(|i| Point2::new(1.0 + f64::from(i) * 0.006, 2.1))
        .collect();
    assert!(
        fitter()
            .fit(ScanPoints::all(&short), &expected, 0.4, 0.4)
            .is_none()
    );
    assert!(
        fitter()
            .fit(ScanPoints::all(&[]), &expected, 0.4, 0.4)
            .is_none()
    );
}

#[test]
fn support_is_what_all_points_add_to_it() {
    let wall = Segment::new(Point2::new(0.0, 1.6), Point2::new(4.0, 1.6));
    let pose = Pose2::new(1.0, -0.5, 0.05);
    let mut fitter = fitter();
    for left_out in 0..5 {
        fitter.begin(&wall.seen_from(pose), Point2::default(), f64::INFINITY);
        for point in &wall_points(&wall, pose, 0.02)[left_out..] {
            fitter.offer(*point, 0.4);
        }
        assert!(fitter.solve(0.4).is_some());
        for number in 0..400 {
            let line = Line {
                centre_m: 0.5,
                offset_m: f64::from(number % 20) * 0.01 - 0.1,
                slope: f64::from(number / 20) * 0.02 - 0.2,
            };
            let beyond = if fitter.eye.y_m > 0.0 { -1.0 } else { 1.0 };
            let all = fitter.near.iter().map(|point| {
                let off = line.residual_m(point.along_m, point.across_m) / point.reach_m;
                match off.abs() < 1.0 {
                    true => point.share * (1.0 - off * off),
                    false if off * beyond > 0.0 => -point.share,
                    false => 0.0,
                }
            });
            let all = all.sum::<f64>();
            let support = fitter.support(&line, f64::NEG_INFINITY).unwrap();
            assert!((support - all).abs() < 1e-9);
            assert_eq!(fitter.support(&line, all - 1e-6), Some(support));
            assert_eq!(fitter.support(&line, all + 1e-6), None);
        }
    }
}

#[test]
fn scattered_points_are_no_wall() {
    let expected = Segment::new(Point2::new(0.0, 2.0), Point2::new(4.0, 2.0));
    let points: Vec<_> = (0..60)
        .map(|i| {
            let i = f64::from(i);
            Point2::new(i / 15.0, 2.0 + 0.4 * (i * 12.9898).sin())
        })
        .collect();
    let fit = fitter().fit(ScanPoints::all(&points), &expected, 0.4, 0.4);
    assert!(fit.is_none(), "{fit:?}");
}
