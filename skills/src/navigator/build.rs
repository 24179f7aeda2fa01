//! A navigator from its setup.

use super::instruction::{Inbox, Parameters};
use super::output::NavigationCounters;
use super::setup::NavigatorSetup;
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
use crate::schedule::{RobotLimits, compile, machine};
use coordination::event::EventTable;
use description::keys::{KeyError, KeyErrors, Section};

/// Poses of the planned path are at least this far apart.
const PATH_STEP_M: f64 = 0.05;
/// Between the footprint and a border, beside the uncertainty of the pose.
const BORDER_MARGIN_M: f64 = 0.01;

impl Navigator {
    /// Checks the setup and starts in the robot's start state.
    ///
    /// # Errors
    /// The keys of the robot's or the site's file that do not fit.
    pub fn new(setup: NavigatorSetup) -> Result<Self, KeyErrors> {
        let NavigatorSetup {
            ref site,
            gains,
            max_speed_m_s,
            footprint,
            ..
        } = setup;
        gains.check().map_err(|error| error.below("navigation"))?;
        footprint
            .check()
            .map_err(|error| error.below("footprint"))?;
        let key = format!("robots.{}", setup.robot);
        let robot = { site.robots.get(&setup.robot) }
            .ok_or_else(|| KeyError::unknown(key.as_str(), "robot", &setup.robot))?;
        let map = SemanticMap::new(site)?;
        let mut events = EventTable::new();
        let mut machine = machine(site, &robot.role, &mut events)?;
        let limits = RobotLimits {
            max_speed_m_s,
            max_curvature_1_m: gains.max_curvature_1_m,
            footprint,
        };
        let schedules = compile(site, &robot.role, &map, &machine, &events, &limits)?;
        if let Some(name) = &robot.start_state {
            let unknown = || KeyError::unknown(format!("{key}.start_state"), "state", name);
            machine.restart_in(machine.state_id(name).ok_or_else(unknown)?);
        }
        let matcher = WallMatcher::new(&map, setup.beams, gains);
        let guard = BorderGuard::new(
            map.areas().iter().map(|area| area.region),
            footprint,
            BorderGains {
                sigmas: gains.border_sigma,
                map_error_m: gains.map_error_m,
                margin_m: BORDER_MARGIN_M,
            },
        );
        let mut navigator = Self {
            map,
            machine,
            events,
            schedules,
            skill_names: site.skills.iter().map(|skill| skill.id.clone()).collect(),
            gains,
            pose: PoseFilter::new(gains, robot.start, gains.start_std_m, gains.start_std_rad),
            fitter: LineFitter::new(setup.beams, gains),
            points: Vec::with_capacity(setup.beams),
            corridor: CorridorTracker::new(gains),
            lane_end: LaneEndTracker::new(gains),
            matcher,
            guard,
            footprint,
            max_speed_m_s,
            motion: Motion::Still,
            began: robot.start,
            stopping: Stopping::default(),
            instructed: None,
            halting: Stopping::default(),
            ramp: SpeedRamp::new(setup.acceleration_m_s2, gains.deceleration_m_s2),
            last_curvature_1_m: 0.0,
            path: Vec::with_capacity(PATH_POSES),
            path_step_m: path_step_m(max_speed_m_s, gains.deceleration_m_s2),
            inbox: Inbox::default(),
            parameters: Parameters::default(),
            in_state_s: 0.0,
            by_hand: false,
            last_step_ns: 0,
            last_scan_ns: 0,
            blind: false,
            check: None,
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
