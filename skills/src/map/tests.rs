use super::*;
use description::geometry::{Point2, Rect, Segment, wrap_angle};
use description::site::{Area, ControlLayer, Lane, Manoeuvre, Site, Wall};

type Spoil = fn(&mut Site);

fn line(ax: f64, ay: f64, bx: f64, by: f64) -> Segment {
    Segment::new(Point2::new(ax, ay), Point2::new(bx, by))
}

fn wall(id: &str, line: Segment) -> Wall {
    Wall {
        id: id.into(),
        line,
    }
}

fn lane(id: &str, line: Segment, end_wall: Option<&str>) -> Lane {
    Lane {
        id: id.into(),
        line,
        end_wall: end_wall.map(Into::into),
    }
}

fn corridor() -> Site {
    Site {
        walls: vec![
            wall("south", line(0.0, -1.6, 10.0, -1.6)),
            wall("north", line(10.0, 1.6, 0.0, 1.6)),
            wall("east", line(10.0, -1.6, 10.0, 1.6)),
            wall("west", line(0.0, -1.6, 0.0, 1.6)),
            wall("far north", line(0.0, 2.5, 10.0, 2.5)),
            wall("stub", line(4.0, 0.8, 4.3, 0.8)),
        ],
        lanes: vec![
            lane("east", line(1.2, -0.5, 8.8, -0.5), None),
            lane("west", line(8.8, 0.5, 1.2, 0.5), Some("west")),
        ],
        areas: vec![Area {
            id: "1".into(),
            region: Rect::new(Point2::new(1.5, -0.9), Point2::new(5.5, 0.0)),
            lane: Some("east".into()),
            capacity: 1,
            control: ControlLayer {
                manoeuvre: Manoeuvre::Any,
                speed_limit_m_s: 0.4,
                deviation_limit_m: 0.3,
            },
        }],
        ..Site::default()
    }
}

#[test]
fn lanes_know_the_nearest_walls_directed_like_them() {
    let data = corridor();
    let map = SemanticMap::new(&data).unwrap();
    let name = |wall: &Option<LaneWall>| data.walls[wall.unwrap().index].id.clone();
    let east = &map.lanes()[0];
    assert_eq!(
        (name(&east.left), name(&east.right), name(&east.end)),
        ("north".into(), "south".into(), "east".into())
    );
    let west = &map.lanes()[1];
    assert_eq!(
        (name(&west.left), name(&west.right), name(&west.end)),
        ("south".into(), "north".into(), "west".into())
    );
    for (lane, wall) in [(east, east.left), (east, east.right), (west, west.left)] {
        assert!(wrap_angle(wall.unwrap().direction_rad - lane.direction_rad).abs() < 1e-9);
    }
    assert_eq!(map.area_at(Point2::new(2.0, -0.5)), map.area_index("1"));
    assert_eq!(map.area_at(Point2::new(9.0, 0.0)), None);
    let pose = west.pose_at(2.0, 0.1, 0.0);
    assert!(pose.position().distance_m(Point2::new(6.8, 0.4)) < 1e-12);
}

/// An arm from the west, one to the south, one to the east; a pillar before the north wall, another hall behind the end.
fn junction() -> Site {
    Site {
        walls: vec![
            wall("north", line(-6.2, 1.2, 6.2, 1.2)),
            wall("south-west", line(-1.2, -1.2, -6.2, -1.2)),
            wall("south-east", line(1.2, -1.2, 6.2, -1.2)),
            wall("arm-west", line(-1.2, -6.2, -1.2, -1.2)),
            wall("arm-east", line(1.2, -6.2, 1.2, -1.2)),
            wall("arm-end", line(-1.2, -6.2, 1.2, -6.2)),
            wall("east", line(6.2, -1.2, 6.2, 1.2)),
            wall("west", line(-6.2, -1.2, -6.2, 1.2)),
            wall("pillar", line(-4.0, 1.0, -3.4, 1.0)),
            wall("next hall", line(-12.0, -0.9, -6.4, -0.9)),
        ],
        lanes: vec![
            lane("in", line(-5.0, -0.5, -1.2, -0.5), None),
            lane("down", line(-0.5, -1.2, -0.5, -5.0), None),
        ],
        ..Site::default()
    }
}

#[test]
fn a_side_of_a_lane_may_be_pieces_with_openings() {
    let data = junction();
    let map = SemanticMap::new(&data).unwrap();
    let pieces = |walls: &[LaneWall]| -> Vec<(String, f64, f64)> {
        let round = |m: f64| (m * 10.0).round() / 10.0;
        let piece = |wall: &LaneWall| {
            let name = data.walls[wall.index].id.clone();
            (name, round(wall.line.a.x_m), round(wall.line.b.x_m))
        };
        walls.iter().map(piece).collect()
    };
    let lane = &map.lanes()[0];
    let expected = |all: &[(&str, f64, f64)]| -> Vec<(String, f64, f64)> {
        all.iter()
            .map(|&(name, a, b)| (name.into(), a, b))
            .collect()
    };
    assert_eq!(
        pieces(&lane.left_walls),
        expected(&[
            ("north", -6.2, -4.0),
            ("pillar", -4.0, -3.4),
            ("north", -3.4, 2.8)
        ])
    );
    assert_eq!(
        pieces(&lane.right_walls),
        expected(&[("south-west", -6.2, -1.2), ("south-east", 1.2, 2.8)])
    );
    // Directed like the lane, whichever way the map draws them.
    for wall in lane.left_walls.iter().chain(&lane.right_walls) {
        assert!(wrap_angle(wall.direction_rad - lane.direction_rad).abs() < 1e-9);
    }
    let down = &map.lanes()[1];
    let names = |walls: &[LaneWall]| -> Vec<String> {
        pieces(walls).into_iter().map(|(name, _, _)| name).collect()
    };
    assert_eq!(names(&down.left_walls), ["arm-east"]);
    assert_eq!(names(&down.right_walls), ["arm-west"]);
}

#[test]
fn what_does_not_fit_is_refused_with_names() {
    let cases: [(Spoil, &str); 9] = [
        (
            |map| map.walls[1].id = "south".into(),
            "walls: found `south` a second time",
        ),
        (
            |map| map.lanes[0].line.b = map.lanes[0].line.a,
            "lanes.east: found a length of 0 m",
        ),
        (
            |map| map.walls[0].line.a.x_m = f64::NAN,
            "walls.south.from_m: found NaN",
        ),
        (
            |map| map.areas[0].lane = Some("nowhere".into()),
            "areas.1.lane: found lane `nowhere`, which does not exist",
        ),
        (
            |map| map.lanes[0].end_wall = Some("nowhere".into()),
            "lanes.east.end_wall: found wall `nowhere`, which does not exist",
        ),
        (
            |map| map.lanes[0].end_wall = Some("west".into()),
            "lanes.east.end_wall: found wall `west`, which does not close lane `east`",
        ),
        (
            |map| map.areas[0].region.max.x_m = f64::INFINITY,
            "areas.1.region.max_m: found inf",
        ),
        (
            |map| {
                let area = map.areas[0].clone();
                let many = (0..300).map(|n| Area {
                    id: n.to_string(),
                    ..area.clone()
                });
                map.areas = many.collect();
            },
            "areas: found 300 areas, expected at most 256",
        ),
        (
            |map| map.areas[0].control.speed_limit_m_s = -0.4,
            "areas.1.speed_limit_m_s: found -0.4, expected a speed above 0",
        ),
    ];
    for (spoil, expected) in cases {
        let mut data = corridor();
        spoil(&mut data);
        let message = SemanticMap::new(&data).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
}
