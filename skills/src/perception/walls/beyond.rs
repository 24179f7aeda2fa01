//! What is seen beyond a line: nothing is seen through a wall.

use description::geometry::{Point2, Segment};

/// Coverage is counted in pieces of this length.
const PIECE_M: f64 = 0.1;
const PIECES: usize = 128;
/// The piece at the foot of the perpendicular from the eye.
const FOOT: usize = PIECES / 2;
/// A beam passes through a line when it ends this far beyond it plus this many standard deviations of its noise.
const BEYOND_M: f64 = 0.03;
const BEYOND_SIGMA: f64 = 2.0;
/// A wall may look open over this share of its seen length: dark paint, a door;
const MAX_THROUGH_SHARE: f64 = 0.35;
/// over a smaller share only where something is seen within `BEHIND_M` behind it: then that is the wall.
const MAX_NEAR_SHARE: f64 = 0.15;
const BEHIND_M: f64 = 0.8;
/// This length may be open in any case.
const OPEN_M: f64 = 0.2;

/// A beam, placed in `base_link` now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    pub(super) end: Point2,
    pub(super) range_std_m: f64,
    /// The same, in parts of the range.
    pub(super) range_std_share: f64,
    /// The wall that it was given to, and how far from it that wall is looked for.
    pub(super) wall: Option<u32>,
    pub(super) gate_m: f64,
}

/// Beams that cross a short piece of a line or end there.
#[derive(Clone, Copy, Debug, Default)]
struct Piece {
    beams: u16,
    through: u16,
    near: u16,
}

/// How much of a line is looked through.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beyond {
    /// Altogether.
    pub(super) all_m: f64,
    /// Where what is seen lies close behind the line.
    near_m: f64,
}

impl Beyond {
    /// Too much lies beyond a line of which `covered_m` was seen: it cannot be the wall.
    pub(super) fn refutes(&self, covered_m: f64) -> bool {
        self.near_m > OPEN_M.max(MAX_NEAR_SHARE * covered_m)
            || self.all_m > OPEN_M.max(MAX_THROUGH_SHARE * covered_m)
    }
}

/// What is seen beyond a segment (in `base_link`), its ends left out; what ends within `slack_m` behind it still
/// counts as on it.
pub(super) fn seen_beyond(
    beams: &[Beam],
    segment: &Segment,
    eye: Point2,
    ends_m: f64,
    slack_m: f64,
) -> Beyond {
    let (unit, length_m) = (segment.unit(), segment.length_m());
    let eye_m = unit.cross(eye - segment.a);
    let eye_along_m = unit.dot(eye - segment.a);
    let (first_m, last_m) = (ends_m - eye_along_m, length_m - ends_m - eye_along_m);
    let mut pieces = [Piece::default(); PIECES];
    let mut place = FOOT;
    for beam in beams {
        let from_start = beam.end - segment.a;
        let beyond_m = -unit.cross(from_start) * eye_m.signum();
        // Noise along the beam counts for no more than all of it: most beams end before the line.
        if beyond_m < -(BEYOND_M + BEYOND_SIGMA * beam.range_std_m) {
            continue;
        }
        let depth_m = beyond_m + eye_m.abs();
        if depth_m <= 1e-3 {
            continue;
        }
        let reach_m = BEYOND_M + BEYOND_SIGMA * beam.range_std_share * depth_m;
        if beyond_m < -reach_m {
            continue;
        }
        // Where the beam crosses the line, from the foot of the perpendicular, times its depth: nothing is divided by it here.
        let crossing_m2 = eye_m.abs() * (unit.dot(from_start) - eye_along_m);
        if !(crossing_m2 > first_m * depth_m && crossing_m2 < last_m * depth_m) {
            continue;
        }
        place = piece_at(crossing_m2, depth_m, place);
        let piece = &mut pieces[place];
        piece.beams += 1;
        if beyond_m > slack_m + reach_m {
            piece.through += 1;
            piece.near += u16::from(beyond_m < slack_m + BEHIND_M);
        }
    }
    let length = |open: fn(&Piece) -> u16| {
        let open = |piece: &&Piece| 2 * open(piece) > piece.beams;
        PIECE_M * pieces.iter().filter(open).count() as f64
    };
    Beyond {
        all_m: length(|piece| piece.through),
        near_m: length(|piece| piece.near),
    }
}

/// The piece in which a beam crosses the line, `crossing_m2 / depth_m` from the foot; what is farther than there are pieces counts for the
/// last one. It is looked for from the piece of the beam before, which is next to it.
fn piece_at(crossing_m2: f64, depth_m: f64, before: usize) -> usize {
    let step_m2 = PIECE_M * depth_m;
    let begin_m2 = |piece: usize| (piece as f64 - FOOT as f64) * step_m2;
    let mut piece = before;
    while piece > 0 && crossing_m2 < begin_m2(piece) {
        piece -= 1;
    }
    while piece + 1 < PIECES && crossing_m2 >= begin_m2(piece + 1) {
        piece += 1;
    }
    piece
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_piece_of_a_crossing_is_found_from_any_other() {
        for (crossing_m, expected) in [
            (0.05, FOOT),
            (-0.05, FOOT - 1),
            (1.23, FOOT + 12),
            (-3.01, FOOT - 31),
            (6.35, PIECES - 1),
            (100.0, PIECES - 1),
            (-100.0, 0),
        ] {
            for depth_m in [0.002, 0.7, 4.0] {
                for before in [0, 17, FOOT, PIECES - 1] {
                    let found = piece_at(crossing_m * depth_m, depth_m, before);
                    assert_eq!(found, expected, "{crossing_m} m, from {before}");
                }
            }
        }
    }
}
