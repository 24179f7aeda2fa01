//! The reference maps and ways through them.

use description::geometry::{Point2, Pose2, Segment};
use description::site::{Site, Wall};
use skills::map::SemanticMap;

pub struct Place {
    pub map: SemanticMap,
    /// Corners of the way, rounded when driven.
    pub way: Vec<Point2>,
}

impl Place {
    pub fn start(&self) -> Pose2 {
        let along = self.way[1] - self.way[0];
        Pose2::new(self.way[0].x_m, self.way[0].y_m, along.direction_rad())
    }

    pub fn walls(&self) -> impl Iterator<Item = Segment> + '_ {
        self.map.walls().iter().map(|wall| wall.line)
    }
}

pub fn map(walls: &[[f64; 4]]) -> SemanticMap {
    let walls = walls
        .iter()
        .enumerate()
        .map(|(index, &[ax, ay, bx, by])| Wall {
            id: index.to_string(),
            line: Segment::new(Point2::new(ax, ay), Point2::new(bx, by)),
        });
    SemanticMap::new(&Site {
        walls: walls.collect(),
        ..Site::default()
    })
    .expect("a sound map")
}

fn way(points: &[[f64; 2]]) -> Vec<Point2> {
    points.iter().map(|&[x, y]| Point2::new(x, y)).collect()
}

fn hall(x0: f64, x1: f64, half: f64) -> SemanticMap {
    map(&[
        [x0, -half, x1, -half],
        [x0, half, x1, half],
        [x1, -half, x1, half],
        [x0, -half, x0, half],
    ])
}

pub fn corridor() -> Place {
    Place {
        map: hall(0.0, 10.0, 1.6),
        way: way(&[
            [2.0, -0.5],
            [9.0, -0.5],
            [9.0, 0.5],
            [1.0, 0.5],
            [1.0, -0.5],
            [9.0, -0.5],
            [9.0, 0.5],
            [3.0, 0.5],
        ]),
    }
}

pub fn docking() -> Place {
    Place {
        map: hall(0.0, 12.0, 1.2),
        way: way(&[
            [1.0, -0.5],
            [11.0, -0.5],
            [11.0, 0.5],
            [1.0, 0.5],
            [1.0, -0.5],
            [9.0, -0.5],
        ]),
    }
}

/// Three arms 2.4 m wide and 5 m long.
pub fn t_junction() -> Place {
    Place {
        map: map(&[
            [-6.2, 1.2, 6.2, 1.2],
            [-6.2, -1.2, -1.2, -1.2],
            [1.2, -1.2, 6.2, -1.2],
            [-1.2, -6.2, -1.2, -1.2],
            [1.2, -6.2, 1.2, -1.2],
            [-1.2, -6.2, 1.2, -6.2],
            [-6.2, -1.2, -6.2, 1.2],
            [6.2, -1.2, 6.2, 1.2],
        ]),
        way: way(&[
            [-5.0, -0.5],
            [-0.5, -0.5],
            [-0.5, -5.2],
            [0.5, -5.2],
            [0.5, -0.5],
            [5.2, -0.5],
            [5.2, 0.5],
            [-5.2, 0.5],
            [-5.2, -0.5],
            [-1.0, -0.5],
        ]),
    }
}

/// A corridor whose sides are several walls with openings, niches and pillars.
pub fn pieces() -> Place {
    Place {
        map: map(&[
            [0.0, -1.4, 2.0, -1.4],
            [2.0, -1.4, 3.1, -1.4],
            [4.3, -1.4, 7.0, -1.4],
            [7.0, -1.4, 7.0, -2.0],
            [7.0, -2.0, 8.2, -2.0],
            [8.2, -2.0, 8.2, -1.4],
            [8.2, -1.4, 10.0, -1.4],
            [3.1, -1.4, 3.1, -3.4],
            [4.3, -1.4, 4.3, -3.4],
            [0.0, 1.4, 5.0, 1.4],
            [5.6, 1.4, 10.0, 1.4],
            [5.1, 1.2, 5.5, 1.2],
            [0.0, -1.4, 0.0, 1.4],
            [10.0, -1.4, 10.0, 1.4],
        ]),
        way: way(&[
            [1.2, -0.4],
            [9.0, -0.4],
            [9.0, 0.5],
            [1.2, 0.5],
            [1.2, -0.4],
            [4.0, -0.4],
        ]),
    }
}
