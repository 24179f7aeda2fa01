//! Paths of manoeuvres: a few pieces of straight line, circle and blend, the last of them a lane without end.

use super::steer::PathError;
use description::geometry::{Point2, Pose2, Segment, Twist2, wrap_angle};
use std::f64::consts::PI;

/// Pieces of a track, at most.
const PIECES: usize = 4;
/// Way between the poses of a track that is looked at as a whole.
const SAMPLE_M: f64 = 0.05;

/// A direction that differs counts as this way.
const TURNED_M_PER_RAD: f64 = 0.5;

/// A piece of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Piece {
    /// Straight or round from a pose, for a length.
    Arc {
        start: Pose2,
        curvature_1_m: f64,
        length_m: f64,
    },
    /// Beside a line, from an offset and slope to zero, with continuous curvature.
    Blend {
        /// On the line where it begins, along the line.
        frame: Pose2,
        length_m: f64,
        offset_m: f64,
        slope: f64,
    },
}

/// A path from where a manoeuvre begins onto a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Track {
    pieces: [Piece; PIECES],
    len: usize,
}

/// Where a robot is relative to a track.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrackPlace {
    /// From the start of the track.
    pub along_m: f64,
    /// Relative to the track there.
    pub error: PathError,
    /// It is on the lane that the track ends on.
    pub on_lane: bool,
}

impl Track {
    /// A lane alone, entered from anywhere.
    #[must_use]
    pub fn lane(lane: &Segment, from: Point2) -> Self {
        let foot = lane.a + lane.unit() * lane.along_m(from);
        let last = Piece::Arc {
            start: Pose2::new(foot.x_m, foot.y_m, lane.direction_rad()),
            curvature_1_m: 0.0,
            length_m: f64::INFINITY,
        };
        Self {
            pieces: [last; PIECES],
            len: 1,
        }
    }

    /// A curve that begins at `start`; continued by the others.
    #[must_use]
    pub(super) fn starting(start: Pose2, curvature_1_m: f64, length_m: f64) -> Self {
        let first = Piece::Arc {
            start,
            curvature_1_m,
            length_m,
        };
        Self {
            pieces: [first; PIECES],
            len: 1,
        }
    }

    /// Beside `lane`, from an offset onto it within a length, then on it.
    #[must_use]
    pub(super) fn blending(
        lane: &Segment,
        from: Point2,
        offset_m: f64,
        slope: f64,
        length_m: f64,
    ) -> Self {
        let foot = lane.a + lane.unit() * lane.along_m(from);
        let frame = Pose2::new(foot.x_m, foot.y_m, lane.direction_rad());
        let blend = Piece::Blend {
            frame,
            length_m,
            offset_m,
            slope,
        };
        let track = Self {
            pieces: [blend; PIECES],
            len: 1,
        };
        track.onto(lane)
    }

    /// Goes on with a curve where it ends now.
    #[must_use]
    pub(super) fn then(mut self, curvature_1_m: f64, length_m: f64) -> Self {
        if length_m > 1e-6 && self.len < PIECES {
            self.pieces[self.len] = Piece::Arc {
                start: self.pieces[self.len - 1].end(),
                curvature_1_m,
                length_m,
            };
            self.len += 1;
        }
        self
    }

    /// Ends on a lane, beside the end of what there is.
    #[must_use]
    pub(super) fn onto(mut self, lane: &Segment) -> Self {
        let end = self.pieces[self.len - 1].end();
        let place = self.len.min(PIECES - 1);
        self.pieces[place] = Self::lane(lane, end.position()).pieces[0];
        self.len = place + 1;
        self
    }

    /// Length up to the lane.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        self.before_m(self.len - 1)
    }

    /// Tightest curve of it.
    #[must_use]
    pub fn max_curvature_1_m(&self) -> f64 {
        let samples = (self.length_m() / SAMPLE_M).ceil() as usize;
        (0..=samples)
            .map(|sample| self.curvature_1_m(sample as f64 * SAMPLE_M).abs())
            .fold(0.0, f64::max)
    }

    /// How far it leads, before it is on its lane, to the other side of the lane than it begins on.
    #[must_use]
    pub(super) fn beyond_m(&self) -> f64 {
        let lane = self.pieces[self.len - 1].pose_at(0.0);
        let aside_m = |along_m: f64| lane.between(self.pose_at(along_m)).y_m;
        let (begin_m, samples) = (aside_m(0.0), (self.length_m() / SAMPLE_M).ceil() as usize);
        (0..=samples)
            .map(|sample| -aside_m(sample as f64 * SAMPLE_M) * begin_m.signum())
            .fold(0.0, f64::max)
    }

    /// The pose at a way along it.
    #[must_use]
    pub fn pose_at(&self, along_m: f64) -> Pose2 {
        let (index, in_piece_m) = self.find(along_m);
        self.pieces[index].pose_at(in_piece_m)
    }

    /// The curvature at a way along it.
    #[must_use]
    pub fn curvature_1_m(&self, along_m: f64) -> f64 {
        let (index, in_piece_m) = self.find(along_m);
        self.pieces[index].curvature_1_m(in_piece_m)
    }

    /// How far along it a point of the lane at its end lies.
    #[must_use]
    pub fn along_lane_m(&self, point: Point2) -> TrackPlace {
        let last = &self.pieces[self.len - 1];
        let pose = Pose2::new(point.x_m, point.y_m, last.pose_at(0.0).theta_rad);
        let (along_m, error) = last.place(pose, 0.0);
        TrackPlace {
            along_m: self.length_m() + along_m,
            error,
            on_lane: along_m >= 0.0,
        }
    }

    /// How far along it, before its lane, a robot is that drives along it: where position and direction differ least.
    #[must_use]
    pub fn nearest_m(&self, pose: Pose2) -> f64 {
        let samples = (self.length_m() / SAMPLE_M).ceil() as usize;
        let off_m = |along_m: f64| {
            let off = self.pose_at(along_m).between(pose);
            off.position().norm_m() + TURNED_M_PER_RAD * off.theta_rad.abs()
        };
        (0..=samples)
            .map(|sample| (sample as f64 * SAMPLE_M).min(self.length_m()))
            .min_by(|one_m, other_m| off_m(*one_m).total_cmp(&off_m(*other_m)))
            .unwrap_or(0.0)
    }

    /// Direction of the lane at its end.
    #[must_use]
    pub fn lane_direction_rad(&self) -> f64 {
        self.pieces[self.len - 1].pose_at(0.0).theta_rad
    }

    /// Where a pose is relative to it, given the place before: places are passed one after the other.
    #[must_use]
    pub fn place(&self, pose: Pose2, before_m: f64) -> TrackPlace {
        let (mut index, mut in_piece_m) = self.find(before_m);
        loop {
            let piece = &self.pieces[index];
            let (along_m, error) = piece.place(pose, in_piece_m);
            let last = index + 1 == self.len;
            if last || along_m < piece.length_m() {
                return TrackPlace {
                    along_m: self.before_m(index) + along_m.max(0.0),
                    error,
                    on_lane: last,
                };
            }
            index += 1;
            in_piece_m = 0.0;
        }
    }

    fn before_m(&self, index: usize) -> f64 {
        self.pieces[..index].iter().map(Piece::length_m).sum()
    }

    fn find(&self, along_m: f64) -> (usize, f64) {
        let mut left_m = along_m.max(0.0);
        for index in 0..self.len - 1 {
            let length_m = self.pieces[index].length_m();
            if left_m < length_m {
                return (index, left_m);
            }
            left_m -= length_m;
        }
        (self.len - 1, left_m)
    }
}

impl Piece {
    fn length_m(&self) -> f64 {
        match *self {
            Self::Arc { length_m, .. } | Self::Blend { length_m, .. } => length_m,
        }
    }

    fn end(&self) -> Pose2 {
        self.pose_at(self.length_m())
    }

    fn pose_at(&self, along_m: f64) -> Pose2 {
        match *self {
            Self::Arc {
                start,
                curvature_1_m,
                ..
            } => start.compose(Twist2::new(along_m, along_m * curvature_1_m).displacement(1.0)),
            Self::Blend { frame, .. } => {
                let (lateral_m, slope, _) = self.blend(along_m);
                frame.compose(Pose2::new(along_m, lateral_m, slope.atan()))
            }
        }
    }

    fn curvature_1_m(&self, along_m: f64) -> f64 {
        match *self {
            Self::Arc { curvature_1_m, .. } => curvature_1_m,
            Self::Blend { .. } => {
                let (_, slope, bend) = self.blend(along_m);
                bend / (1.0 + slope * slope).powf(1.5)
            }
        }
    }

    /// How far along the piece a pose is, near `before_m`, and its error there.
    fn place(&self, pose: Pose2, before_m: f64) -> (f64, PathError) {
        match *self {
            Self::Arc {
                start,
                curvature_1_m,
                ..
            } if curvature_1_m.abs() > 1e-6 => {
                let local = start.between(pose);
                let radius_m = 1.0 / curvature_1_m;
                let (across_m, sign) = (radius_m - local.y_m, radius_m.signum());
                let swept_rad = local.x_m.atan2(across_m * sign);
                let before_rad = before_m * curvature_1_m.abs();
                // Unwrapped around what was swept before: half a turn lies on the seam of the wrapped angle.
                let now_rad =
                    (before_rad + wrap_angle(swept_rad - before_rad)).clamp(-PI, 1.9 * PI);
                let error = PathError {
                    lateral_m: sign * (radius_m.abs() - local.x_m.hypot(across_m)),
                    heading_rad: wrap_angle(local.theta_rad - sign * swept_rad),
                };
                (now_rad * radius_m.abs(), error)
            }
            Self::Arc { start, .. } => {
                let local = start.between(pose);
                let error = PathError {
                    lateral_m: local.y_m,
                    heading_rad: local.theta_rad,
                };
                (local.x_m, error)
            }
            Self::Blend { frame, .. } => {
                let local = frame.between(pose);
                let (lateral_m, slope, _) = self.blend(local.x_m);
                let heading_rad = slope.atan();
                let error = PathError {
                    lateral_m: (local.y_m - lateral_m) * heading_rad.cos(),
                    heading_rad: wrap_angle(local.theta_rad - heading_rad),
                };
                (local.x_m, error)
            }
        }
    }

    /// Offset, slope and second derivative of a blend: a polynomial of fifth degree.
    fn blend(&self, along_m: f64) -> (f64, f64, f64) {
        let Self::Blend {
            length_m,
            offset_m,
            slope,
            ..
        } = *self
        else {
            return (0.0, 0.0, 0.0);
        };
        let t = (along_m / length_m).clamp(0.0, 1.0);
        let (t2, t3) = (t * t, t * t * t);
        let rise_m = slope * length_m;
        let value = offset_m * (1.0 - 10.0 * t3 + 15.0 * t3 * t - 6.0 * t3 * t2)
            + rise_m * (t - 6.0 * t3 + 8.0 * t3 * t - 3.0 * t3 * t2);
        let first = offset_m * (-30.0 * t2 + 60.0 * t3 - 30.0 * t2 * t2)
            + rise_m * (1.0 - 18.0 * t2 + 32.0 * t3 - 15.0 * t2 * t2);
        let second = offset_m * (-60.0 * t + 180.0 * t2 - 120.0 * t3)
            + rise_m * (-36.0 * t + 96.0 * t2 - 60.0 * t3);
        (value, first / length_m, second / (length_m * length_m))
    }
}
