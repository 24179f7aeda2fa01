//! What surrounds a lane: the walls beside it, in pieces, and the wall that closes it.

use description::geometry::{Point2, Pose2, Segment, wrap_angle};
use description::keys::KeyError;
use description::site::{Lane, Wall};
use std::f64::consts::{FRAC_PI_2, PI};

/// Walls beside a lane are parallel to it within this.
const PARALLEL_RAD: f64 = 0.06;
/// The wall that ends a lane crosses it at this angle or more.
const CROSSING_RAD: f64 = 0.8;
/// Farther from the lane a wall is not part of its corridor.
const BESIDE_M: f64 = 4.0;
/// A wall must run beside the lane for this length to be its main one.
const OVERLAP_M: f64 = 1.0;
/// Shorter pieces are left out: their direction cannot be measured.
const PIECE_M: f64 = 0.3;
/// A lane sees walls this far before its start and behind its end.
const REACH_M: f64 = 4.0;
/// A lane's end wall lies at most this far behind its end.
const AHEAD_M: f64 = 5.0;
/// Step along the lane in which the walls beside it are sampled.
const STEP_M: f64 = 0.05;

/// A wall as a lane knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneWall {
    /// Index of the wall in the map.
    pub index: usize,
    /// Directed like the lane when it runs beside it.
    pub line: Segment,
    /// Direction of `line`.
    pub direction_rad: f64,
}

/// A lane with its surroundings.
#[derive(Clone, Debug, PartialEq)]
pub struct LaneGeometry {
    /// Name.
    pub id: String,
    /// Centre line.
    pub line: Segment,
    /// Direction of driving.
    pub direction_rad: f64,
    /// The nearest wall to the left that runs along a good part of the lane.
    pub left: Option<LaneWall>,
    /// The same to the right.
    pub right: Option<LaneWall>,
    /// All pieces of wall that face the lane from the left, from its start to its end; between them it is open.
    pub left_walls: Vec<LaneWall>,
    /// The same from the right.
    pub right_walls: Vec<LaneWall>,
    /// The wall that closes the lane.
    pub end: Option<LaneWall>,
}

impl LaneGeometry {
    /// The pose in `map` at a place along the lane, off its centre, turned against it.
    #[must_use]
    pub fn pose_at(&self, along_m: f64, lateral_m: f64, heading_rad: f64) -> Pose2 {
        let unit = self.line.unit();
        let left = Point2::new(-unit.y_m, unit.x_m);
        let position = self.line.a + unit * along_m + left * lateral_m;
        Pose2::new(
            position.x_m,
            position.y_m,
            wrap_angle(self.direction_rad + heading_rad),
        )
    }
}

pub(super) fn lane_geometry(lane: &Lane, walls: &[Wall]) -> Result<LaneGeometry, KeyError> {
    let key = || format!("lanes.{}.end_wall", lane.id);
    let end = match &lane.end_wall {
        None => nearest_end(&lane.line, walls),
        Some(name) => {
            let index = walls.iter().position(|wall| wall.id == *name);
            let index = index.ok_or_else(|| KeyError::unknown(key(), "wall", name))?;
            if distance_ahead_m(&lane.line, &walls[index].line).is_none() {
                let found = format!("wall `{name}`, which does not close lane `{}`", lane.id);
                let expected = "a wall that crosses the lane's line ahead of its start";
                return Err(KeyError::new(key(), found, expected));
            }
            Some(index)
        }
    };
    Ok(LaneGeometry {
        id: lane.id.clone(),
        line: lane.line,
        direction_rad: lane.line.direction_rad(),
        left: nearest_beside(&lane.line, walls, 1.0),
        right: nearest_beside(&lane.line, walls, -1.0),
        left_walls: facing(&lane.line, walls, 1.0),
        right_walls: facing(&lane.line, walls, -1.0),
        end: end.map(|index| lane_wall(index, walls[index].line)),
    })
}

fn lane_wall(index: usize, line: Segment) -> LaneWall {
    LaneWall {
        index,
        line,
        direction_rad: line.direction_rad(),
    }
}

/// The wall's line in the direction of the lane.
fn directed(wall: Segment, lane: &Segment) -> Segment {
    let turned_rad = wrap_angle(wall.direction_rad() - lane.direction_rad()).abs();
    if turned_rad > FRAC_PI_2 {
        Segment::new(wall.b, wall.a)
    } else {
        wall
    }
}

/// The pieces of parallel wall that face the lane from one side: what other walls hide from it is left out, and so is
/// the wall behind a gap only where that gap lets it be seen.
fn facing(lane: &Segment, walls: &[Wall], side: f64) -> Vec<LaneWall> {
    let unit = lane.unit();
    let outwards = Point2::new(-unit.y_m, unit.x_m) * side;
    // What lies behind the walls that close the lane is another corridor.
    let free_m = |direction_rad: f64, from: Point2| {
        walls
            .iter()
            .filter_map(|wall| wall.line.ray_range_m(from, direction_rad))
            .fold(REACH_M, f64::min)
    };
    let from_m = -free_m(lane.direction_rad() + PI, lane.a);
    let to_m = lane.length_m() + free_m(lane.direction_rad(), lane.b);
    let steps = ((to_m - from_m) / STEP_M).ceil() as usize;
    let mut pieces: Vec<LaneWall> = Vec::new();
    // The piece that the walk is on: its wall, and where along the lane it begins and ends.
    let mut open: Option<(usize, f64, f64)> = None;
    let mut close = |piece: Option<(usize, f64, f64)>| {
        let Some((index, begin_m, end_m)) = piece else {
            return;
        };
        let line = directed(walls[index].line, lane);
        let off_rad = wrap_angle(line.direction_rad() - lane.direction_rad()).abs();
        if off_rad >= PARALLEL_RAD {
            return;
        }
        let place = |along_m: f64| {
            let foot = line.along_m(lane.a + unit * along_m);
            line.a + line.unit() * foot.clamp(0.0, line.length_m())
        };
        let seen = Segment::new(place(begin_m - STEP_M / 2.0), place(end_m + STEP_M / 2.0));
        if seen.length_m() >= PIECE_M {
            pieces.push(lane_wall(index, seen));
        }
    };
    for step in 0..=steps {
        let along_m = from_m + step as f64 * STEP_M;
        let foot = lane.a + unit * along_m;
        let facing = walls
            .iter()
            .enumerate()
            .filter_map(|(index, wall)| {
                let range_m = wall.line.ray_range_m(foot, outwards.direction_rad())?;
                (range_m < BESIDE_M).then_some((range_m, index))
            })
            .min_by(|(one, _), (other, _)| one.total_cmp(other))
            .map(|(_, index)| index);
        open = match (open, facing) {
            (Some((index, begin_m, _)), Some(next)) if index == next => {
                Some((index, begin_m, along_m))
            }
            (piece, next) => {
                close(piece);
                next.map(|index| (index, along_m, along_m))
            }
        };
    }
    close(open);
    pieces
}

/// The nearest parallel wall to the left (`side` 1) or right (−1) that runs along the lane.
fn nearest_beside(lane: &Segment, walls: &[Wall], side: f64) -> Option<LaneWall> {
    let beside = |(index, wall): (usize, &Wall)| {
        let line = directed(wall.line, lane);
        let off_rad = wrap_angle(line.direction_rad() - lane.direction_rad()).abs();
        let middle = (line.a + line.b) * 0.5;
        let lateral_m = side * lane.lateral_m(middle);
        let from_m = lane.along_m(line.a).max(0.0);
        let to_m = lane.along_m(line.b).min(lane.length_m());
        let enough_m = OVERLAP_M.min(lane.length_m() / 2.0);
        (off_rad < PARALLEL_RAD
            && lateral_m > 0.0
            && lateral_m < BESIDE_M
            && to_m - from_m >= enough_m)
            .then(|| (lateral_m, lane_wall(index, line)))
    };
    walls
        .iter()
        .enumerate()
        .filter_map(beside)
        .min_by(|(one, _), (other, _)| one.total_cmp(other))
        .map(|(_, wall)| wall)
}

/// How far after the lane's start its line meets the wall.
fn distance_ahead_m(lane: &Segment, wall: &Segment) -> Option<f64> {
    let crossing_rad = wrap_angle(wall.direction_rad() - lane.direction_rad());
    if crossing_rad.sin().abs() < CROSSING_RAD.sin() {
        return None;
    }
    wall.ray_range_m(lane.a, lane.direction_rad())
}

fn nearest_end(lane: &Segment, walls: &[Wall]) -> Option<usize> {
    walls
        .iter()
        .enumerate()
        .filter_map(|(index, wall)| Some((distance_ahead_m(lane, &wall.line)?, index)))
        .filter(|&(ahead_m, _)| ahead_m <= lane.length_m() + AHEAD_M)
        .min_by(|(one, _), (other, _)| one.total_cmp(other))
        .map(|(_, index)| index)
}
