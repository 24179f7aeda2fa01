//! What the generation of a set of tubes has to say.

use super::parameters::Horizon;
use crate::geometry::Point2;
use std::fmt;
use thiserror::Error;

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
    /// The beams lie too far apart to find what `d_sample_m` promises.
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

/// A tube that is never free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefusedTube {
    /// Its horizon.
    pub horizon: Horizon,
    /// Its curvature.
    pub curvature_1_m: f64,
    /// Why.
    pub why: Refusal,
}

/// A sample that no beam sees, near enough to be judged by what is remembered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnseenSample {
    /// Curvature of its tube.
    pub curvature_1_m: f64,
    /// Horizon of its tube.
    pub horizon: Horizon,
    /// In `base_link` at the beginning of the tube.
    pub point: Point2,
}

/// What was generated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TubeReport {
    /// Usable tubes.
    pub tubes: usize,
    /// Samples on their borders.
    pub samples: usize,
    /// Samples compared at run time, after those on one beam of a tube are merged.
    pub compared: usize,
    /// Different beams that any tube looks at.
    pub beams: usize,
    /// Tubes that are never free.
    pub refused: Vec<RefusedTube>,
    /// Samples judged by memory.
    pub unseen: Vec<UnseenSample>,
    /// Bytes of the flat arrays.
    pub bytes: usize,
}

impl fmt::Display for TubeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} motion tubes, {} samples ({} compared) on {} beams, {} samples out of view judged by memory, {} KiB; {} tubes refused",
            self.tubes,
            self.samples,
            self.compared,
            self.beams,
            self.unseen.len(),
            self.bytes.div_ceil(1024),
            self.refused.len()
        )?;
        for refused in &self.refused {
            writeln!(
                f,
                "  refused: {} s at {} m/s, curvature {:+.3} 1/m: {}",
                refused.horizon.duration_s,
                refused.horizon.speed_m_s,
                refused.curvature_1_m,
                refused.why
            )?;
        }
        Ok(())
    }
}
