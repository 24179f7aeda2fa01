//! `course`: one robot, one map, every skill.

use config::{FsmConfig, SiteConfig};
use sim::world::{Truth, World, WorldError};

use crate::judge::Figures;
use crate::judge::Rules;
use crate::one_robot::trial::{Scenario, regular_states};

/// Every regular state of the robot's machine once, and back to where it began.
#[derive(Clone, Debug)]
pub struct Course {
    /// State of the machine that the robot starts in.
    pub start_state: String,
    /// Longest time.
    pub patience_s: f64,
}

impl Course {
    fn missing_states(&self, site: &SiteConfig, fsm: &FsmConfig, figures: &Figures) -> Vec<String> {
        regular_states(site, fsm, &self.start_state)
            .into_iter()
            .filter(|state| !figures.states.contains(state))
            .collect()
    }
}

impl Scenario for Course {
    fn name(&self) -> &'static str {
        "course"
    }

    fn rules(&self) -> Rules {
        Rules {
            may_be_run_into: false,
            pose: true,
        }
    }

    fn furnish(&self, _world: &mut World, _seed: u64) -> Result<(), WorldError> {
        Ok(())
    }

    fn withholds_leave(&self) -> bool {
        true
    }

    fn patience_s(&self) -> f64 {
        self.patience_s
    }

    fn is_done(
        &self,
        site: &SiteConfig,
        fsm: &FsmConfig,
        figures: &Figures,
        _truth: &Truth,
    ) -> bool {
        // The machine says what is scheduled; that it was driven, the areas say, by the world's truth.
        let back = figures.states.len() > 1 && figures.states.last() == Some(&self.start_state);
        back && self.missing_states(site, fsm, figures).is_empty()
            && regular_states(site, fsm, &self.start_state)
                .iter()
                .filter_map(|state| fsm.state(state))
                .all(|state| state.areas().any(|area| figures.areas.contains(area)))
    }

    fn missing(&self, site: &SiteConfig, fsm: &FsmConfig, figures: &Figures) -> String {
        let missing = self.missing_states(site, fsm, figures);
        let last = figures.states.last().map_or("none", String::as_str);
        format!(
            "{} states were not reached ({}); it ended in {last}",
            missing.len(),
            missing.join(", ")
        )
    }

    fn least_done_share(&self) -> f64 {
        1.0
    }
}
