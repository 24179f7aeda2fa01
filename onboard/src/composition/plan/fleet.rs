//! What the robot's side of the mediator is made of.

use contract::floor::Floor;
use contract::timing::SILENT_AFTER_NS;
use contract::wire::Factsheet;
use coordination::fsm::Machine;
use skills::borders::BorderGains;
use skills::map::SemanticMap;
use skills::navigator::Navigator;
use skills::schedule::Schedule;

use super::contents::Plan;
use crate::fleet::{AreaPlace, Began, Setup, StatePlan};

impl Plan {
    /// The robot's side of the mediator, for the navigator of this plan; `None` where nobody manages the areas.
    #[must_use]
    pub fn fleet_setup(&self, navigator: &Navigator, boot_epoch: u64) -> Option<Setup> {
        if !self.site.areas_managed {
            return None;
        }
        let (gains, drive, map) = (&self.robot.navigation, &self.robot.drive, navigator.map());
        let areas = map.areas().iter().map(|area| AreaPlace {
            id: area.id.clone(),
            region: area.region,
        });
        let machine = navigator.machine();
        Some(Setup {
            robot_id: self.robot.identity.id.clone(),
            site: self.site.name.clone(),
            boot_epoch,
            began: Began::Afresh { ended: None },
            start: self.start.start,
            areas: areas.collect(),
            floor: Floor::of(&self.site.areas),
            states: machine
                .states()
                .map(|(state, name)| self.state_plan(name, machine, map, navigator.schedule(state)))
                .collect(),
            footprint: self.robot.footprint,
            borders: BorderGains {
                sigmas: gains.border_sigma,
                map_error_m: gains.map_error_m,
                ..BorderGains::default()
            },
            deceleration_m_s2: gains.deceleration_m_s2,
            max_speed_m_s: drive.limits.max_speed_m_s,
            request_ahead_m: self.robot.fleet.request_ahead_m,
            silent_after_ns: SILENT_AFTER_NS,
            factsheet: self.factsheet(),
        })
    }

    /// What kind of robot it is.
    fn factsheet(&self) -> Factsheet {
        let (identity, footprint) = (&self.robot.identity, &self.robot.footprint);
        Factsheet {
            manufacturer: identity.manufacturer.clone(),
            model: identity.model.clone(),
            software: concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")).to_owned(),
            front_m: footprint.front_m,
            rear_m: footprint.rear_m,
            left_m: footprint.left_m,
            right_m: footprint.right_m,
            max_speed_m_s: self.robot.drive.limits.max_speed_m_s,
            deceleration_m_s2: self.robot.navigation.deceleration_m_s2,
            // The client says which.
            protocols: Vec::new(),
        }
    }

    fn state_plan(
        &self,
        name: &str,
        machine: &Machine,
        map: &SemanticMap,
        schedule: Option<&Schedule>,
    ) -> StatePlan {
        let areas = { self.fsm.state(name).into_iter() }
            .flat_map(description::site::FsmState::areas)
            .filter_map(|area| map.area_index(area));
        let number = |name: &str| { self.fsm.states.iter() }.position(|state| state.name == name);
        let from = || self.fsm.transitions.iter().filter(|one| one.from == name);
        let mut next: Vec<usize> = from()
            .filter(|transition| !self.fsm.external.contains(&transition.on))
            .filter_map(|transition| number(&transition.to))
            .collect();
        next.sort_unstable();
        next.dedup();
        StatePlan {
            name: name.to_owned(),
            areas: areas.collect(),
            next,
            least_way_m: schedule.map_or(0.0, |schedule| schedule.least_way_m(map)),
            accepts: from()
                .filter_map(|transition| {
                    let event = machine.input(&transition.on)?;
                    Some((transition.on.clone(), event))
                })
                .collect(),
        }
    }

    /// The first key that differs of those by which a robot with a mediator reckons before which border it can still stop: its side of the
    /// mediator goes on with what it was started with.
    pub(super) fn fixed_for_the_fleet(&self, other: &Self) -> Option<String> {
        let (ours, theirs) = (&self.robot.navigation, &other.robot.navigation);
        let keys = [
            (
                "navigation.deceleration_m_s2",
                ours.deceleration_m_s2 == theirs.deceleration_m_s2,
            ),
            (
                "navigation.border_sigma",
                ours.border_sigma == theirs.border_sigma,
            ),
            (
                "navigation.map_error_m",
                ours.map_error_m == theirs.map_error_m,
            ),
        ];
        let key = keys.into_iter().find(|(_, same)| !same);
        key.filter(|_| self.site.areas_managed)
            .map(|(key, _)| format!("{key} on a site whose areas are managed"))
    }

    /// Whether a robot that runs this plan with a mediator can go on under the other: areas and states keep their numbers
    /// and their meaning.
    pub(super) fn has_same_fleet_as(&self, other: &Self) -> bool {
        let managed = self.site.areas_managed || other.site.areas_managed;
        let (ours, theirs) = (&self.site, &other.site);
        !managed
            || (ours.areas_managed == theirs.areas_managed
                && ours.name == theirs.name
                && ours.areas == theirs.areas
                && ours.monitors == theirs.monitors
                && self.fsm == other.fsm)
    }
}

#[cfg(test)]
mod tests {
    use description::areas::AreaIndex;
    use std::f64::consts::PI;
    use std::path::PathBuf;

    use super::*;
    use crate::composition::files::Files;

    fn plan(robot: &str, site: &str, id: &str, managed: bool) -> Plan {
        let files = concat!(env!("CARGO_MANIFEST_DIR"), "/../config");
        let files = Files {
            robot: PathBuf::from(format!("{files}/robots/{robot}.toml")),
            site: PathBuf::from(format!("{files}/sites/{site}.toml")),
            set: vec![
                format!("areas.managed={managed}"),
                format!("identity.id={id}"),
            ],
        };
        match Plan::load(&files) {
            Ok(plan) => plan,
            Err(failure) => panic!("{failure:?}"),
        }
    }

    fn setup(robot: &str, site: &str, id: &str, managed: bool) -> Option<Setup> {
        let plan = plan(robot, site, id, managed);
        let navigator = plan.navigator().expect("a navigator");
        plan.fleet_setup(&navigator, 1)
    }

    #[test]
    fn only_a_managed_site_needs_a_mediator() {
        assert!(setup("amr-1", "corridor", "amr-1", false).is_none());
        assert!(setup("amr-1", "corridor", "amr-1", true).is_some());
    }

    #[test]
    fn a_factsheet_says_what_the_robots_file_says() {
        let facts = |robot: &str| {
            let setup = setup(robot, "docking", robot, true).expect("managed");
            setup.factsheet
        };
        let software = format!("onboard {}", env!("CARGO_PKG_VERSION"));
        let expected = Factsheet {
            manufacturer: "unknown".to_owned(),
            model: "0.4 x 0.3 m platform, KELO drive 100, URG-04LX".to_owned(),
            software,
            front_m: 0.32,
            rear_m: 0.08,
            left_m: 0.15,
            right_m: 0.15,
            max_speed_m_s: 0.40,
            deceleration_m_s2: 0.4,
            ..Factsheet::default()
        };
        assert_eq!(facts("amr-1"), expected);
        assert_eq!(facts("amr-big").max_speed_m_s, 0.20);
    }

    #[test]
    fn states_know_their_areas_what_follows_and_how_long_they_last() {
        let setup = setup("amr-1", "corridor", "amr-1", true).expect("managed");
        let state = |name: &str| {
            let number = setup.states.iter().position(|state| state.name == name);
            number.expect("a state")
        };
        let names = |areas: &[AreaIndex]| -> Vec<String> {
            areas
                .iter()
                .map(|&area| setup.areas[area.place()].id.clone())
                .collect()
        };
        let turn = &setup.states[state("u-turn-3")];
        assert_eq!(names(&turn.areas), ["3"]);
        assert_eq!(turn.next, [state("drive-4")]);
        assert!((turn.least_way_m - 0.5 * PI).abs() < 1e-9);
        let halt = &setup.states[state("halt-1")];
        assert!(halt.next.is_empty(), "only an operator leads on");
        assert!(halt.accepts("reset").is_some());
    }

    #[test]
    fn a_state_of_several_areas_has_them_all() {
        let setup = setup("amr-big", "docking", "amr-big", true).expect("managed");
        let middle = setup.states.iter().find(|state| state.name == "to-middle");
        let middle = middle.expect("a state");
        assert_eq!(middle.areas.len(), 3);
        assert!(middle.least_way_m > 0.0);
    }

    #[test]
    fn a_crossing_takes_its_curve() {
        let setup = setup("amr-1", "t-junction", "amr-2", true).expect("managed");
        let state = |name: &str| setup.states.iter().find(|state| state.name == name);
        let left = state("cross-to-3").expect("a state").least_way_m;
        assert!((left - 0.5 * PI).abs() < 1e-6, "{left}");
        let right = state("cross-to-2").expect("a state").least_way_m;
        assert!((right - 0.3 * PI).abs() < 1e-6, "{right}");
    }

    #[test]
    fn areas_of_a_managed_site_stay_while_a_robot_drives() {
        let mut changed = plan("amr-1", "corridor", "amr-1", true);
        let present = changed.clone();
        assert!(present.has_same_fleet_as(&changed));
        changed.site.areas.swap(0, 1);
        assert!(!present.has_same_fleet_as(&changed));
        let alone = plan("amr-1", "corridor", "amr-1", false);
        assert!(!present.has_same_fleet_as(&alone));
    }
}
