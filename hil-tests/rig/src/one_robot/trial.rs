//! What makes a trial: how the world is furnished, what is asked, when it is done.

use config::{ControllerConfig, FsmConfig, MonitorKind, SiteConfig};
use sim::world::{Truth, World, WorldError};

use crate::judge::Figures;
use crate::judge::Rules;

/// One kind of trial.
pub trait Scenario: Sync {
    /// Its name, as on the command line.
    fn name(&self) -> &'static str;

    /// What the judge asks for.
    fn rules(&self) -> Rules;

    /// Puts what the site's file does not know into the world, before its clock starts.
    ///
    /// # Errors
    /// [`WorldError`] of something that makes no sense.
    fn furnish(&self, world: &mut World, seed: u64) -> Result<(), WorldError>;

    /// Whether leave for areas is withheld at random, where the harness can do so.
    fn withholds_leave(&self) -> bool;

    /// Longest time that the trial may take.
    fn patience_s(&self) -> f64;

    /// Whether the robot has done what it should.
    fn is_done(&self, site: &SiteConfig, fsm: &FsmConfig, figures: &Figures, truth: &Truth)
    -> bool;

    /// What is still to be done, in words.
    fn missing(&self, site: &SiteConfig, fsm: &FsmConfig, figures: &Figures) -> String;

    /// Smallest share of runs that must be done.
    fn least_done_share(&self) -> f64;
}

/// States that a robot passes through when all goes well: all that can be reached without straying and without an
/// operator's reset.
#[must_use]
pub fn regular_states(site: &SiteConfig, fsm: &FsmConfig, start: &str) -> Vec<String> {
    let strays = |event: &str| {
        event == "reset"
            || site
                .monitor(event)
                .is_some_and(|monitor| matches!(monitor.kind, MonitorKind::Deviation { .. }))
    };
    let mut reached = vec![start.to_owned()];
    let mut next = 0;
    while let Some(state) = reached.get(next).cloned() {
        next += 1;
        let outgoing = fsm.transitions.iter().filter(|one| one.from == state);
        for transition in outgoing.filter(|one| !strays(&one.on)) {
            if !reached.contains(&transition.to) && !is_halt(site, fsm, &transition.to) {
                reached.push(transition.to.clone());
            }
        }
    }
    reached
}

/// A state that only an operator's reset ends.
fn is_halt(site: &SiteConfig, fsm: &FsmConfig, state: &str) -> bool {
    let stops = fsm
        .state(state)
        .and_then(|state| site.skill(&state.skill))
        .is_some_and(|skill| skill.controller == ControllerConfig::Stop);
    let mut outgoing = fsm.transitions.iter().filter(|one| one.from == state);
    stops && outgoing.all(|one| one.on == "reset")
}
