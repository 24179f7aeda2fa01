//! The states of a role, with all that they name.

use description::site::{Area, FsmConfig, FsmState, Lane, Site, SkillConfig};

/// The states of one role.
pub(super) struct States<'a> {
    pub(super) site: &'a Site,
    pub(super) role: &'a str,
    pub(super) fsm: &'a FsmConfig,
}

impl<'a> States<'a> {
    /// A state with all that it names; none where a name is unknown, which the loader refuses.
    pub(super) fn named(&self, name: &str) -> Option<Resolved<'a>> {
        let state = self.fsm.state(name)?;
        let area = self.site.area(&state.area)?;
        let lane = state.lane.as_deref().or(area.lane.as_deref());
        Some(Resolved {
            state,
            area,
            skill: self.site.skill(&state.skill)?,
            lane: lane.and_then(|lane| self.site.lane(lane)),
        })
    }

    pub(super) fn all(&self) -> impl Iterator<Item = Resolved<'a>> {
        { self.fsm.states.iter() }.filter_map(|state| self.named(&state.name))
    }

    pub(super) fn key(&self, state: &FsmState) -> String {
        format!("fsm.{}.states.{}", self.role, state.name)
    }
}

/// A state with everything that it names.
#[derive(Clone, Copy)]
pub(super) struct Resolved<'a> {
    pub(super) state: &'a FsmState,
    pub(super) area: &'a Area,
    pub(super) skill: &'a SkillConfig,
    /// The state's own lane, or the area's.
    pub(super) lane: Option<&'a Lane>,
}
