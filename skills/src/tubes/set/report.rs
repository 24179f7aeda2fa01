//! The report on a generated set of tubes.

use crate::tubes::error::Refusal;
use description::geometry::Point2;
use description::robot::Horizon;
use std::fmt;
use std::mem::discriminant;

/// A tube that is never free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefusedTube {
    /// Its horizon.
    pub horizon: Horizon,
    /// It is driven backwards.
    pub backward: bool,
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
    /// Its tube is driven backwards.
    pub backward: bool,
    /// In `base_link` at the beginning of the tube.
    pub point: Point2,
}

/// What was generated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TubeReport {
    /// Usable tubes.
    pub tubes: usize,
    /// Of these, driven backwards.
    pub backward: usize,
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

fn backwards(backward: bool) -> &'static str {
    if backward { " backwards" } else { "" }
}

impl TubeReport {
    /// How many tubes are refused for which reason, and the end of the line.
    fn write_reasons(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = ": ";
        for kind in Refusal::KINDS {
            let of_kind = |refused: &&RefusedTube| refused.why.kind() == kind;
            let count = self.refused.iter().filter(of_kind).count();
            if count > 0 {
                write!(f, "{separator}{count} {kind}")?;
                separator = ", ";
            }
        }
        writeln!(f)
    }
}

impl fmt::Display for TubeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} motion tubes, {} of them backwards, {} samples ({} compared) on {} beams, {} samples out of view judged by memory, {} KiB; {} tubes refused",
            self.tubes,
            self.backward,
            self.samples,
            self.compared,
            self.beams,
            self.unseen.len(),
            self.bytes.div_ceil(1024),
            self.refused.len()
        )?;
        self.write_reasons(f)?;
        let alike = |a: &RefusedTube, b: &RefusedTube| {
            a.horizon == b.horizon
                && a.backward == b.backward
                && a.curvature_1_m.is_sign_negative() == b.curvature_1_m.is_sign_negative()
                && discriminant(&a.why) == discriminant(&b.why)
        };
        for refused in self.refused.chunk_by(alike) {
            let (first, last) = (&refused[0], &refused[refused.len() - 1]);
            writeln!(
                f,
                "  refused: {} of {} s at {} m/s{}, curvature {:+.2} to {:+.2} 1/m; the first: {}",
                refused.len(),
                first.horizon.horizon_s,
                first.horizon.speed_m_s,
                backwards(first.backward),
                first.curvature_1_m,
                last.curvature_1_m,
                first.why
            )?;
        }
        for unseen in self.unseen.chunk_by(|a, b| {
            a.horizon == b.horizon && a.backward == b.backward && a.curvature_1_m == b.curvature_1_m
        }) {
            let reach_m = unseen
                .iter()
                .map(|sample| sample.point.norm_m())
                .fold(0.0, f64::max);
            writeln!(
                f,
                "  by memory: {} samples of {} s at {} m/s{}, curvature {:+.2} 1/m, up to {reach_m:.2} m from base_link",
                unseen.len(),
                unseen[0].horizon.horizon_s,
                unseen[0].horizon.speed_m_s,
                backwards(unseen[0].backward),
                unseen[0].curvature_1_m,
            )?;
        }
        Ok(())
    }
}
