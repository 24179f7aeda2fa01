//! A navigator from its setup.

use super::instruction::{Inbox, Parameters};
use super::output::NavigationCounters;
use super::setup::{NavigatorSetup, SetupError};
use super::state::Navigator;
use crate::borders::{BorderGains, BorderGuard};
use crate::control::{SpeedRamp, Stopping};
use crate::localisation::PoseFilter;
use crate::map::SemanticMap;
use crate::perception::corridor::CorridorTracker;
use crate::perception::lane_end::LaneEndTracker;
use crate::perception::line::LineFitter;
use crate::perception::walls::WallMatcher;
use crate::schedule::controllers::motion::{Motion, PATH_POSES};
use crate::schedule::{RobotLimits, compile};

/// Poses of the planned path are at least this far apart.
const PATH_STEP_M: f64 = 0.05;
/// Between the footprint and a border, beside the uncertainty of the pose.
const BORDER_MARGIN_M: f64 = 0.01;

impl Navigator {
    /// Checks the setup and starts in its start state.
    ///
    /// # Errors
    /// [`SetupError`]: the first part of the setup that is refused.
    pub fn new(setup: NavigatorSetup) -> Result<Self, SetupError> {
        setup.gains.validate()?;
        let max_speed_m_s = setup.max_speed_m_s;
        if !(max_speed_m_s.is_finite() && max_speed_m_s > 0.0) {
            let what = "maximum speed";
            let found = max_speed_m_s;
            return Err(SetupError::NotPositive { what, found });
        }
        if !setup.footprint.is_valid() {
            return Err(SetupError::Footprint);
        }
        if !setup.start.is_finite() {
            return Err(SetupError::Start);
        }
        let map = SemanticMap::new(&setup.map)?;
        let mut machine = setup.machine;
        let schedules = compile(
            &map,
            &machine,
            &setup.states,
            &setup.skills,
            &setup.monitors,
            &RobotLimits {
                max_speed_m_s,
                max_curvature_1_m: setup.gains.max_curvature_1_m,
                footprint: setup.footprint,
            },
        )?;
        if let Some(name) = &setup.start_state {
            let state = machine
                .state_id(name)
                .ok_or_else(|| SetupError::StartState(name.clone()))?;
            machine.restart_in(state);
        }
        let gains = setup.gains;
        let matcher = WallMatcher::new(&map, setup.beams, gains.perception());
        let guard = BorderGuard::new(
            map.areas().iter().map(|area| area.region),
            setup.footprint,
            BorderGains {
                sigmas: gains.border_sigma,
                margin_m: BORDER_MARGIN_M,
            },
        );
        let mut navigator = Self {
            map,
            machine,
            schedules,
            skill_names: setup.skills.into_iter().map(|skill| skill.id).collect(),
            control: gains.control(),
            pose: PoseFilter::new(
                gains.pose(),
                setup.start,
                gains.start_std_m,
                gains.start_std_rad,
            ),
            fitter: LineFitter::new(setup.beams, gains.perception()),
            points: Vec::with_capacity(setup.beams),
            corridor: CorridorTracker::new(gains.perception()),
            lane_end: LaneEndTracker::new(gains.perception()),
            matcher,
            guard,
            footprint: setup.footprint,
            border_sigma: gains.border_sigma,
            max_speed_m_s,
            motion: Motion::Still,
            stopping: Stopping::default(),
            instructed: None,
            halting: Stopping::default(),
            ramp: SpeedRamp::new(gains.acceleration_m_s2, gains.deceleration_m_s2),
            last_curvature_1_m: 0.0,
            path: Vec::with_capacity(PATH_POSES),
            path_step_m: path_step_m(max_speed_m_s, gains.deceleration_m_s2),
            inbox: Inbox::default(),
            parameters: Parameters::default(),
            in_state_s: 0.0,
            last_step_ns: 0,
            last_scan_ns: 0,
            counters: NavigationCounters::default(),
        };
        navigator.activate(None);
        Ok(navigator)
    }
}

/// Spacing with which the planned path is long enough to stop on, from the fastest speed.
fn path_step_m(max_speed_m_s: f64, deceleration_m_s2: f64) -> f64 {
    let stop_m = max_speed_m_s * max_speed_m_s / (2.0 * deceleration_m_s2) + max_speed_m_s;
    PATH_STEP_M.max(1.2 * stop_m / PATH_POSES as f64)
}
