//! Why a set of tubes, its policy, or a single tube is refused.

use crate::scan::ScanGeometryError;
use description::keys::KeyError;
use thiserror::Error;

/// Why no set of tubes could be made, or no adaptation be set up.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TubeError {
    /// A parameter, by its key in a robot file.
    #[error(transparent)]
    Key(#[from] KeyError),
    /// The scan geometry is unusable.
    #[error("scan geometry: {0}")]
    Scan(#[from] ScanGeometryError),
    /// Too many samples for their index.
    #[error("{samples} samples are too many")]
    TooLarge {
        /// How many.
        samples: usize,
    },
    /// The sensor can judge none of the tubes.
    #[error("all {tubes} tubes are refused, the first because {first}")]
    NothingLeft {
        /// How many were tried.
        tubes: usize,
        /// Why the first was refused.
        first: Refusal,
    },
}

/// Why a tube is refused: the sensor could not judge it.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Refusal {
    /// The inner side would move backwards.
    #[error("it turns about a point inside the robot's width, {radius_m:.2} m from base_link")]
    TurnsOnTheSpot {
        /// Radius of the path of `base_link`.
        radius_m: f64,
    },
    /// It comes back to where the robot stands.
    #[error("it turns by {angle_rad:.2} rad; at most half a turn can be judged")]
    TurnsTooFar {
        /// The angle turned.
        angle_rad: f64,
    },
    /// A sample out of view, and too far away to have been seen a moment ago.
    #[error(
        "no beam looks at its sample at ({x_m:.2}, {y_m:.2}) m, which is farther than one footprint from base_link"
    )]
    Unseen {
        /// Forward.
        x_m: f64,
        /// Left.
        y_m: f64,
    },
    /// A sample beyond the sensor's range.
    #[error("its sample at {range_m:.2} m is beyond the sensor's range of {range_max_m:.2} m")]
    BeyondRange {
        /// Range of the sample.
        range_m: f64,
        /// Largest range.
        range_max_m: f64,
    },
    /// The beams lie too far apart to find what `sample_step_m` promises.
    #[error(
        "beams are {beam_gap_m:.3} m apart at its end; at most {allowed_m:.3} m can find what is asked for"
    )]
    BeamsTooCoarse {
        /// Distance of neighbouring beams at the farthest sample.
        beam_gap_m: f64,
        /// What would do.
        allowed_m: f64,
    },
}

impl Refusal {
    pub(super) const KINDS: [&'static str; 5] = [
        "turn about a point inside the robot's width",
        "turn too far",
        "have samples that neither sensor nor memory sees",
        "reach beyond the sensor's range",
        "end where beams are too far apart",
    ];

    /// The reason, in a few words for many tubes.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::TurnsOnTheSpot { .. } => Self::KINDS[0],
            Self::TurnsTooFar { .. } => Self::KINDS[1],
            Self::Unseen { .. } => Self::KINDS[2],
            Self::BeyondRange { .. } => Self::KINDS[3],
            Self::BeamsTooCoarse { .. } => Self::KINDS[4],
        }
    }
}
