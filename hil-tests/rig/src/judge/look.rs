//! What a judge sees of one robot at one time.

use config::SiteConfig;
use description::site::FsmConfig;
use sim::world::{Footprint, Pose, Truth, World};

use crate::belief::Belief;
use crate::network::observations::Observations;
use crate::scenario::{Player, Scenario};
use crate::shapes;

/// One look at a robot.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    /// The robot's number in scenario and world; a clone's in the world.
    pub robot: usize,
    /// The truth about it.
    pub truth: &'a Truth,
    /// The world, now.
    pub world: &'a World,
    /// What the robot believes, where that is asked for.
    pub belief: Option<&'a Belief>,
    /// Leave for each area, where the rig withholds it; empty: it does not.
    pub leave: &'a [bool],
    /// What was heard on the network until now.
    pub observations: &'a Observations,
}

/// Where a pose is, in words.
pub(super) fn place(pose: &Pose) -> String {
    format!("at x = {:.2} m, y = {:.2} m", pose.x_m, pose.y_m)
}

/// Whether somebody has carried a robot from one look to the next: it is farther away than it has driven.
pub(super) fn is_carried(was: &Truth, is: &Truth) -> bool {
    const CARRIED_M: f64 = 0.1;
    let way_m = (is.pose.x_m - was.pose.x_m).hypot(is.pose.y_m - was.pose.y_m);
    way_m > CARRIED_M + (is.distance_m - was.distance_m)
}

/// What a judge knows of a robot from the files.
#[derive(Debug)]
pub(super) struct Robot {
    /// By which it is known on the network.
    pub(super) id: String,
    /// How it is called in violations.
    pub(super) name: String,
    /// It is a second one of its identity.
    pub(super) is_clone: bool,
    pub(super) site: SiteConfig,
    pub(super) fsm: FsmConfig,
    pub(super) footprint: Footprint,
    /// With which it stops before borders.
    pub(super) deceleration_m_s2: f64,
    /// Of the lidar, from `base_link`.
    pub(super) lidar: Pose,
}

impl Robot {
    pub(super) fn new(scenario: &Scenario, player: &Player) -> Self {
        let mount = &player.config.lidar.mount;
        Self {
            id: player.id.clone(),
            name: player.id.clone(),
            is_clone: false,
            site: scenario.site.clone(),
            fsm: player.fsm.clone(),
            footprint: shapes::footprint(&player.config),
            deceleration_m_s2: player.config.navigation.deceleration_m_s2,
            lidar: Pose::new(mount.x_m, mount.y_m, mount.theta_rad),
        }
    }

    /// A second robot of its identity.
    pub(super) fn clone_of(scenario: &Scenario, player: &Player) -> Self {
        Self {
            name: format!("clone of {}", player.id),
            is_clone: true,
            ..Self::new(scenario, player)
        }
    }
}
