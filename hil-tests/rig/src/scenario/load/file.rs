//! The keys of a scenario file.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;
use toml::Spanned;

use crate::scenario::clutter::Clutter;
use crate::scenario::fault::ScriptedFault;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub(super) name: Spanned<String>,
    #[serde(default)]
    pub(super) about: String,
    pub(super) site: Spanned<PathBuf>,
    #[serde(default)]
    pub(super) set: Vec<String>,
    pub(super) patience_s: Spanned<f64>,
    pub(super) patience_round_s: Option<Spanned<f64>>,
    pub(super) standstill_s: Option<Spanned<f64>>,
    pub(super) start_delay_s: Option<Spanned<f64>>,
    pub(super) least_clearance_m: Option<Spanned<f64>>,
    pub(super) least_done_share: Option<Spanned<f64>>,
    pub(super) faults_until_s: Option<Spanned<f64>>,
    #[serde(default)]
    pub(super) withhold_areas: bool,
    #[serde(default)]
    pub(super) limits: Limits,
    #[serde(default)]
    pub(super) faults: Vec<Spanned<ScriptedFault>>,
    pub(super) clutter: Option<Spanned<Clutter>>,
    pub(super) robots: BTreeMap<Spanned<String>, Robot>,
    #[serde(default)]
    pub(super) coordinations: BTreeMap<Spanned<String>, Spanned<u32>>,
    #[serde(default)]
    pub(super) during: Vec<Rule>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Limits {
    #[serde(default)]
    pub(super) may_be_run_into: bool,
    pub(super) lateral_error_m: Option<Spanned<f64>>,
    pub(super) over_speed: Option<Spanned<f64>>,
    pub(super) pose_error_m: Option<Spanned<f64>>,
    pub(super) heading_error_deg: Option<Spanned<f64>>,
    pub(super) dock_error_m: Option<Spanned<f64>>,
    pub(super) pose_stop_error_m: Option<Spanned<f64>>,
    pub(super) border_stop_error_m: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Robot {
    pub(super) file: Spanned<PathBuf>,
    #[serde(default)]
    pub(super) set: Vec<Spanned<String>>,
    pub(super) goal: Spanned<Way>,
    #[serde(default)]
    pub(super) operator: bool,
    pub(super) driven_h: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Way {
    pub(super) rounds: Option<Spanned<u32>>,
    pub(super) through: Option<Spanned<Vec<Waypoint>>>,
    #[serde(default)]
    pub(super) then: Vec<Waypoint>,
    pub(super) laps: Option<Spanned<u32>>,
    #[serde(default)]
    pub(super) every_state: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Waypoint {
    pub(super) name: Option<String>,
    pub(super) area: Option<Spanned<String>>,
    pub(super) region: Option<Spanned<Corners>>,
    pub(super) stands_s: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Corners {
    pub(super) min_m: [f64; 2],
    pub(super) max_m: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Rule {
    #[serde(rename = "while")]
    pub(super) condition: Condition,
    #[serde(rename = "is")]
    pub(super) claim: Claim,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Condition {
    pub(super) robot: Spanned<String>,
    pub(super) area: Spanned<String>,
    pub(super) coordination: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Claim {
    pub(super) robot: Spanned<String>,
    pub(super) area: Spanned<String>,
}
