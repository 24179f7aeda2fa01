//! Whether there is room: the footprint along a path and the walls of the map, borders ahead on a lane.

use crate::control::Track;
use description::geometry::{Footprint, Point2, Pose2, Rect, Segment};

/// Step between the poses that are checked.
const STEP_M: f64 = 0.04;
/// Distance to walls that a plan keeps on each side.
const CLEARANCE_M: f64 = 0.03;

/// The first of the walls that the footprint comes closer to than a few centimetres on the track, up to the lane.
pub(super) fn wall_in_the_way<'a>(
    track: &Track,
    footprint: &Footprint,
    mut walls: impl Iterator<Item = (&'a str, Segment)> + Clone,
) -> Option<&'a str> {
    let body = footprint.grown(CLEARANCE_M).as_rect();
    let steps = (track.length_m() / STEP_M).ceil() as usize;
    let poses = |step: usize| track.pose_at((step as f64 * STEP_M).min(track.length_m()));
    walls
        .find(|(_, line)| (0..=steps).any(|step| touches(&body, poses(step), line)))
        .map(|(name, _)| name)
}

fn touches(body: &Rect, pose: Pose2, wall: &Segment) -> bool {
    let seen = wall.seen_from(pose);
    let along = seen.b - seen.a;
    // The part of the segment inside both pairs of sides.
    let mut span = (0.0, 1.0);
    for (low_m, high_m, at_m, slope_m) in [
        (body.min.x_m, body.max.x_m, seen.a.x_m, along.x_m),
        (body.min.y_m, body.max.y_m, seen.a.y_m, along.y_m),
    ] {
        if slope_m.abs() < 1e-12 {
            if at_m < low_m || at_m > high_m {
                return false;
            }
            continue;
        }
        let (one, other) = ((low_m - at_m) / slope_m, (high_m - at_m) / slope_m);
        span = (
            f64::max(span.0, one.min(other)),
            f64::min(span.1, one.max(other)),
        );
    }
    span.0 <= span.1
}

/// Where along the lane a body of the footprint's width first comes to the region; none when it passes beside it.
pub(super) fn border_ahead_m(lane: &Segment, region: &Rect, footprint: &Footprint) -> Option<f64> {
    let (left_m, right_m) = (
        footprint.left_m + CLEARANCE_M,
        footprint.right_m + CLEARANCE_M,
    );
    let corners = [
        region.min,
        Point2::new(region.max.x_m, region.min.y_m),
        region.max,
        Point2::new(region.min.x_m, region.max.y_m),
    ]
    .map(|corner| Point2::new(lane.along_m(corner), lane.lateral_m(corner)));
    let mut nearest_m: Option<f64> = None;
    for (index, from) in corners.iter().enumerate() {
        let to = &corners[(index + 1) % corners.len()];
        // The part of the edge within the body's width.
        let rise_m = to.y_m - from.y_m;
        let share = |lateral_m: f64| ((lateral_m - from.y_m) / rise_m).clamp(0.0, 1.0);
        let shares = if rise_m.abs() < 1e-9 {
            [0.0, 1.0]
        } else {
            [share(-right_m), share(left_m)]
        };
        for share in shares {
            let point = *from + (*to - *from) * share;
            let within = point.y_m > -right_m - 1e-9 && point.y_m < left_m + 1e-9;
            if within && nearest_m.is_none_or(|nearest_m| point.x_m < nearest_m) {
                nearest_m = Some(point.x_m);
            }
        }
    }
    nearest_m
}

#[cfg(test)]
mod tests {
    use super::*;

    const FOOTPRINT: Footprint = Footprint {
        front_m: 0.32,
        rear_m: 0.08,
        left_m: 0.15,
        right_m: 0.15,
    };

    fn segment(ax: f64, ay: f64, bx: f64, by: f64) -> Segment {
        Segment::new(Point2::new(ax, ay), Point2::new(bx, by))
    }

    #[test]
    fn the_border_is_where_the_body_first_meets_it() {
        let lane = segment(1.0, -0.5, 9.0, -0.5);
        let ahead = Rect::new(Point2::new(5.5, -0.9), Point2::new(8.5, 0.0));
        let found = border_ahead_m(&lane, &ahead, &FOOTPRINT);
        assert!((found.unwrap() - 4.5).abs() < 1e-9);
        let beside = Rect::new(Point2::new(3.0, -1.6), Point2::new(5.0, -0.9));
        assert_eq!(border_ahead_m(&lane, &beside, &FOOTPRINT), None);
        let behind = Rect::new(Point2::new(-2.0, -1.0), Point2::new(0.0, 1.0));
        assert!(border_ahead_m(&lane, &behind, &FOOTPRINT).unwrap() < 0.0);
        // A lane at an angle: the corner counts.
        let oblique = segment(0.0, 0.0, 7.0, 7.0);
        let square = Rect::new(Point2::new(3.0, 3.0), Point2::new(4.0, 4.0));
        let found = border_ahead_m(&oblique, &square, &FOOTPRINT).unwrap();
        assert!((found - 18.0f64.sqrt()).abs() < 1e-9, "{found}");
    }

    #[test]
    fn a_wall_within_the_swept_room_is_found() {
        let lane = segment(0.0, 0.0, 5.0, 0.0);
        let back = segment(5.0, 1.0, 0.0, 1.0);
        let track = crate::control::manoeuvre::u_turn(
            description::site::TurnDirection::Left,
            0.5,
            2.5,
            &lane,
            &back,
            Pose2::new(3.0, 0.0, 0.0),
        )
        .unwrap();
        let look = |x_m: f64| {
            let walls = [
                ("aside", segment(0.0, -1.0, 9.0, -1.0)),
                ("ahead", segment(x_m, -2.0, x_m, 2.0)),
            ];
            wall_in_the_way(&track, &FOOTPRINT, walls.into_iter())
        };
        // The front corner sweeps 0.72 m from the centre of the turn.
        assert_eq!(look(3.80), None);
        assert_eq!(look(3.70), Some("ahead"));
    }
}
