//! The tracks of manoeuvres between lanes, and why there is none.

use super::track::Track;
use description::geometry::{Point2, Pose2, Segment, wrap_angle};
use description::site::TurnDirection;
use std::f64::consts::{FRAC_PI_2, PI};

/// Lanes of a U-turn run against each other, and lanes of a shift along each other, within this.
const PARALLEL_RAD: f64 = 0.1;
/// Lanes that differ by less need no curve: the junction is crossed straight.
const STRAIGHT_RAD: f64 = 0.3;
/// Such a robot is on the other lane within so many radii.
const STRAIGHT_RADII: f64 = 4.0;
/// A junction turn is at most this sharp.
const SHARPEST_RAD: f64 = 2.6;
/// A robot that has turned by more is on its way round.
const BEGUN_RAD: f64 = 0.25;
/// With less to go the lane's own law leads onto it.
const ENDED_RAD: f64 = 0.1;
/// Tolerance by which lanes may be closer than a U-turn's circle is wide.
const CLOSER_M: f64 = 0.02;
/// A shift does not leave its lane steeper than this: 45°.
const STEEPEST: f64 = 1.0;
/// Of the tightest curve, the share that a shift is planned with; the rest is for corrections.
const PLANNED_SHARE: f64 = 0.85;
/// Steepest slope, and sharpest bend, of a shift of 1 m within 1 m.
const BLEND_SLOPE: f64 = 1.875;
const BLEND_BEND: f64 = 5.773_502_7;

/// Why a manoeuvre cannot be driven.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TrackError {
    /// The lanes of a U-turn are too close.
    #[error("its lanes are {apart_m:.3} m apart, and half a turn of radius {radius_m} m needs {:.3} m", 2.0 * radius_m)]
    TooClose {
        /// Between the lanes.
        apart_m: f64,
        /// Asked for.
        radius_m: f64,
    },
    /// The lanes of a U-turn do not run against each other.
    #[error("its lanes must run against each other, and differ by {:.0}° from that", off_rad.to_degrees())]
    NotBack {
        /// From antiparallel.
        off_rad: f64,
    },
    /// The lanes of a shift do not run along each other.
    #[error("its lanes must run along each other, and differ by {:.0}°", off_rad.to_degrees())]
    NotBeside {
        /// Between them.
        off_rad: f64,
    },
    /// The lanes of a junction turn back.
    #[error("a turn of {:.0}° is a U-turn", turn_rad.to_degrees())]
    TooSharp {
        /// Between the lanes.
        turn_rad: f64,
    },
    /// The curve does not fit between the lanes.
    #[error(
        "a curve of radius {radius_m} m begins {needed_m:.2} m before the lanes meet, and the lane {which} the turn leaves {left_m:.2} m"
    )]
    DoesNotFit {
        /// Asked for.
        radius_m: f64,
        /// From the lanes' crossing to where the curve touches them.
        needed_m: f64,
        /// What there is.
        left_m: f64,
        /// `before` or `after`.
        which: &'static str,
    },
    /// The shift is too short.
    #[error("{aside_m:.2} m aside within {within_m} m is too sharp: it takes {needed_m:.2} m")]
    TooShort {
        /// To the side.
        aside_m: f64,
        /// Asked for.
        within_m: f64,
        /// Needed.
        needed_m: f64,
    },
}

/// Half a turn from beside `from` on the incoming lane onto the outgoing one, with a straight piece between when they are
/// farther apart than the circle is wide. It starts on the lane, so that an offset from it is corrected on the way round.
///
/// # Errors
/// [`TrackError::NotBack`] or [`TrackError::TooClose`] when the lanes do not fit half a turn.
pub fn u_turn(
    direction: TurnDirection,
    radius_m: f64,
    max_curvature_1_m: f64,
    incoming: &Segment,
    outgoing: &Segment,
    from: Pose2,
) -> Result<Track, TrackError> {
    let sign = direction.sign();
    let heading_rad = incoming.direction_rad();
    let off_rad = wrap_angle(outgoing.direction_rad() - heading_rad - PI);
    if off_rad.abs() > PARALLEL_RAD {
        return Err(TrackError::NotBack { off_rad });
    }
    if let Some(rest) = rest_of_turn(sign * PI, radius_m, max_curvature_1_m, outgoing, from) {
        return Ok(rest);
    }
    let from = from.position();
    let foot = incoming.a + incoming.unit() * incoming.along_m(from);
    // Both lateral distances are positive towards the side it turns to.
    let apart_m = sign * outgoing.lateral_m(foot);
    if apart_m < 2.0 * radius_m - CLOSER_M {
        return Err(TrackError::TooClose { apart_m, radius_m });
    }
    let radius_m = radius_m.min(apart_m / 2.0);
    let start = Pose2::new(foot.x_m, foot.y_m, heading_rad);
    let (curvature_1_m, quarter_m) = (sign / radius_m, FRAC_PI_2 * radius_m);
    let across_m = apart_m - 2.0 * radius_m;
    let track = if across_m < CLOSER_M {
        Track::starting(start, curvature_1_m, 2.0 * quarter_m)
    } else {
        Track::starting(start, curvature_1_m, quarter_m)
            .then(0.0, across_m)
            .then(curvature_1_m, quarter_m)
    };
    Ok(track.onto(outgoing))
}

/// Where the curve of a junction turn touches the two lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fillet {
    /// Angle turned, positive to the left; small: straight on.
    pub turn_rad: f64,
    /// Where the lanes' lines meet, along the incoming one.
    pub crossing_in_m: f64,
    /// The same along the outgoing one.
    pub crossing_out_m: f64,
    /// From there to where the curve touches them.
    pub tangent_m: f64,
}

impl Fillet {
    /// The curve of `radius_m` between two lanes; none when they run (nearly) the same way.
    ///
    /// # Errors
    /// [`TrackError::TooSharp`] when the lanes turn back.
    pub fn between(
        incoming: &Segment,
        outgoing: &Segment,
        radius_m: f64,
    ) -> Result<Option<Self>, TrackError> {
        let turn_rad = wrap_angle(outgoing.direction_rad() - incoming.direction_rad());
        if turn_rad.abs() < STRAIGHT_RAD {
            return Ok(None);
        }
        if turn_rad.abs() > SHARPEST_RAD {
            return Err(TrackError::TooSharp { turn_rad });
        }
        let (one, other) = (incoming.unit(), outgoing.unit());
        let between = outgoing.a - incoming.a;
        let sine = one.cross(other);
        Ok(Some(Self {
            turn_rad,
            crossing_in_m: between.cross(other) / sine,
            crossing_out_m: between.cross(one) / sine,
            tangent_m: radius_m * (turn_rad.abs() / 2.0).tan(),
        }))
    }

    /// Checks that the curve lies between the start of the incoming lane and the end of the outgoing one.
    ///
    /// # Errors
    /// [`TrackError::DoesNotFit`] with the lane that is too short.
    pub fn check(&self, outgoing: &Segment, radius_m: f64) -> Result<(), TrackError> {
        let needed_m = self.tangent_m;
        let after_m = outgoing.length_m() - self.crossing_out_m;
        for (which, left_m) in [("before", self.crossing_in_m), ("after", after_m)] {
            if left_m < needed_m {
                return Err(TrackError::DoesNotFit {
                    radius_m,
                    needed_m,
                    left_m,
                    which,
                });
            }
        }
        Ok(())
    }
}

/// At a junction: along the incoming lane, round a curve, onto the outgoing lane. A robot that is already too close to
/// the other lane for the curve gets a tighter one, down to the tightest. Straight on, it is on the outgoing lane four radii after
/// the end of the incoming one, wherever it begins.
///
/// # Errors
/// [`TrackError::TooSharp`], or for lanes without a curve those of [`shift`].
pub fn turn(
    radius_m: f64,
    max_curvature_1_m: f64,
    incoming: &Segment,
    outgoing: &Segment,
    from: Pose2,
) -> Result<Track, TrackError> {
    let Some(fillet) = Fillet::between(incoming, outgoing, radius_m)? else {
        let within_m = STRAIGHT_RADII * radius_m;
        let begun_m = outgoing.along_m(from.position()) - outgoing.along_m(incoming.b);
        let left_m = (within_m - begun_m).clamp(0.0, within_m);
        return shift(outgoing, 0.0, left_m, max_curvature_1_m, from);
    };
    let turn_rad = fillet.turn_rad;
    if let Some(rest) = rest_of_turn(turn_rad, radius_m, max_curvature_1_m, outgoing, from) {
        return Ok(rest);
    }
    let here_m = incoming.along_m(from.position());
    let left_m = (fillet.crossing_in_m - here_m).max(0.0);
    let half = (fillet.turn_rad.abs() / 2.0).tan();
    let radius_m = radius_m.min(left_m / half).max(1.0 / max_curvature_1_m);
    let straight_m = (left_m - radius_m * half).max(0.0);
    let foot = incoming.a + incoming.unit() * here_m;
    let start = Pose2::new(foot.x_m, foot.y_m, incoming.direction_rad());
    let (curvature_1_m, length_m) = (
        fillet.turn_rad.signum() / radius_m,
        fillet.turn_rad.abs() * radius_m,
    );
    let track = if straight_m > 1e-3 {
        Track::starting(start, 0.0, straight_m).then(curvature_1_m, length_m)
    } else {
        Track::starting(start, curvature_1_m, length_m)
    };
    Ok(track.onto(outgoing))
}

/// What is left of a turn by `turn_rad` onto `outgoing` for a robot that is found on its way round: straight on, then round the
/// curve; of one that has ended, the lane. `None`: the turn has not begun.
///
/// A robot that restarts, or is told where it is, without knowing where its turn began must not begin it again.
#[must_use]
pub fn rest_of_turn(
    turn_rad: f64,
    radius_m: f64,
    max_curvature_1_m: f64,
    outgoing: &Segment,
    from: Pose2,
) -> Option<Track> {
    let sign = turn_rad.signum();
    let left_rad = sign * wrap_angle(outgoing.direction_rad() - from.theta_rad);
    // A turn of half a circle may have its start on the seam of the angle.
    if left_rad <= -BEGUN_RAD || left_rad >= turn_rad.abs() - BEGUN_RAD {
        return None;
    }
    if left_rad <= ENDED_RAD {
        return Some(Track::lane(outgoing, from.position()));
    }
    // On the side that the turn comes from, a circle that touches the lane passes this direction this far beside it.
    let beside_m = sign * outgoing.lateral_m(from.position());
    let depth = 1.0 - left_rad.cos();
    let fitting_m = (beside_m / depth).max(1.0 / max_curvature_1_m);
    let radius_m = radius_m.min(fitting_m);
    let farther_m = beside_m - radius_m * depth;
    let curve = sign / radius_m;
    let track = if farther_m < CLOSER_M {
        Track::starting(from, curve, left_rad * radius_m)
    } else if left_rad > FRAC_PI_2 {
        // Straight across between two curves.
        let (first_m, last_m) = ((left_rad - FRAC_PI_2) * radius_m, FRAC_PI_2 * radius_m);
        let first = Track::starting(from, curve, first_m);
        first.then(0.0, farther_m).then(curve, last_m)
    } else {
        let straight = Track::starting(from, 0.0, farther_m / left_rad.sin());
        straight.then(curve, left_rad * radius_m)
    };
    Some(track.onto(outgoing))
}

/// Length that a change by `aside_m` needs.
#[must_use]
pub fn shift_length_m(aside_m: f64, max_curvature_1_m: f64) -> f64 {
    let bent_m = (BLEND_BEND * aside_m.abs() / (PLANNED_SHARE * max_curvature_1_m)).sqrt();
    bent_m.max(BLEND_SLOPE * aside_m.abs() / STEEPEST)
}

/// Checks that a change by `aside_m` fits.
///
/// # Errors
/// [`TrackError::TooShort`] with the length that it needs.
pub fn check_shift(aside_m: f64, within_m: f64, max_curvature_1_m: f64) -> Result<(), TrackError> {
    let needed_m = shift_length_m(aside_m, max_curvature_1_m);
    if within_m >= needed_m - 1e-6 {
        return Ok(());
    }
    Err(TrackError::TooShort {
        aside_m: aside_m.abs(),
        within_m,
        needed_m,
    })
}

/// From a pose beside a lane onto it (or to `offset_m` left of it). A robot farther aside than planned takes a longer way; one that is
/// turned to the lane, as when it is found on its way there, takes a shorter one, that does not lead beyond it.
///
/// # Errors
/// [`TrackError::NotBeside`] when the robot is turned too far from the lane.
pub fn shift(
    lane: &Segment,
    offset_m: f64,
    within_m: f64,
    max_curvature_1_m: f64,
    from: Pose2,
) -> Result<Track, TrackError> {
    let off_rad = wrap_angle(from.theta_rad - lane.direction_rad());
    if off_rad.abs() > SHARPEST_SHIFT_RAD {
        return Err(TrackError::NotBeside { off_rad });
    }
    let lane = beside(lane, offset_m);
    let aside_m = lane.lateral_m(from.position());
    let length_m = within_m
        .max(shift_length_m(aside_m, max_curvature_1_m))
        .max(0.2);
    let slope = off_rad.tan();
    let track = |length_m| Track::blending(&lane, from.position(), aside_m, slope, length_m);
    let sharpest_1_m = PLANNED_SHARE * max_curvature_1_m;
    // A circle that touches the lane, as the last part of the way from farther aside is: for one that is turned to the lane so far that
    // it is the shorter way.
    let curvature_1_m = (1.0 - off_rad.cos()) / aside_m.abs();
    let round_m = off_rad.abs() / curvature_1_m;
    if aside_m * off_rad < 0.0 && curvature_1_m <= sharpest_1_m && round_m < length_m {
        let curvature_1_m = aside_m.signum() * curvature_1_m;
        return Ok(Track::starting(from, curvature_1_m, round_m).onto(&lane));
    }
    let whole = track(length_m);
    if whole.beyond_m() <= BEYOND_M {
        return Ok(whole);
    }
    let shorter = (1..SHIFT_LENGTHS).map(|step| f64::from(step) / f64::from(SHIFT_LENGTHS));
    Ok({ shorter.map(|share| track(share * length_m)) }
        .filter(|track| track.max_curvature_1_m() <= sharpest_1_m)
        .min_by(|one, other| one.beyond_m().total_cmp(&other.beyond_m()))
        .unwrap_or(whole))
}

/// Lengths of a shift that are tried.
const SHIFT_LENGTHS: u32 = 15;
/// So far a shift may lead beyond the lane.
const BEYOND_M: f64 = 0.01;

/// A robot that is turned farther than this from the lane does not start a shift. On its way in one it may be turned by 45°.
const SHARPEST_SHIFT_RAD: f64 = 0.9;

/// Checks that two lanes run along each other.
///
/// # Errors
/// [`TrackError::NotBeside`] with the angle between them.
pub fn check_beside(one: &Segment, other: &Segment) -> Result<(), TrackError> {
    let off_rad = wrap_angle(one.direction_rad() - other.direction_rad());
    if off_rad.abs() <= PARALLEL_RAD {
        return Ok(());
    }
    Err(TrackError::NotBeside { off_rad })
}

/// A line beside another, positive to the left.
#[must_use]
pub fn beside(line: &Segment, offset_m: f64) -> Segment {
    let unit = line.unit();
    let aside = Point2::new(-unit.y_m, unit.x_m) * offset_m;
    Segment::new(line.a + aside, line.b + aside)
}
