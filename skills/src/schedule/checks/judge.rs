//! All checks, one after the other.

use super::findings::Findings;
use super::reach::RobotReach;
use super::role::States;
use super::{perception, states, turns, waiting, width};
use description::keys::{KeyError, KeyErrors};
use description::site::{Site, SiteRobot};

/// Checks every skill of the site, and the state machine that the robot runs there.
///
/// # Errors
/// Every key to blame, once.
pub fn check(site: &Site, robot: &str, reach: &RobotReach) -> Result<(), KeyErrors> {
    let key = format!("robots.{robot}");
    let unknown = || KeyError::unknown(key.as_str(), "robot", robot);
    let SiteRobot { role, start, .. } = site.robots.get(robot).ok_or_else(unknown)?;
    let unknown = || KeyError::unknown(format!("{key}.role"), "role", role);
    let fsm = site.fsm.get(role).ok_or_else(unknown)?;
    let mut findings = Findings::default();
    perception::check(site, &mut findings);
    let states = States { site, role, fsm };
    states::check(&states, &mut findings);
    turns::check(&states, reach, &mut findings);
    waiting::check(&states, reach, &mut findings);
    width::check(&states, &reach.footprint, &mut findings);
    width::start_is_free(site, &reach.footprint, robot, *start, &mut findings);
    KeyErrors::any(findings)
}
