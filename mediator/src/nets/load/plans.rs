//! Plans of all coordinations of a site.

use std::sync::Arc;

use super::loader::{Loader, PlanError, nanoseconds};
use crate::nets::plan::{Kind, Plan, Script, SituationPlan};
use crate::setup::Setup;
use config::{NetConfig, SiteConfig};
use coordination::analysis::Limits;
use coordination::petri::PlaceKind;

/// Makes plans of all coordinations of a site; `setup` is made from the same site.
///
/// # Errors
/// Everything that does not fit, at once.
pub fn plans(
    site: &SiteConfig,
    setup: &Setup,
    nets: &[NetConfig],
    limits: &Limits,
) -> Result<Vec<Arc<Plan>>, Vec<PlanError>> {
    let mut errors = Vec::new();
    let mut plans: Vec<Arc<Plan>> = Vec::new();
    for (id, coordination) in &site.coordinations {
        let mut loader = Loader {
            id,
            coordination,
            site,
            areas: { setup.areas.iter().enumerate() }
                .map(|(index, area)| (area.id.as_str(), index))
                .collect(),
            robots: { setup.robots.iter().enumerate() }
                .map(|(index, robot)| (robot.id.as_str(), index))
                .collect(),
            errors: Vec::new(),
        };
        let Some(net) = nets.iter().find(|net| net.name == coordination.net) else {
            let known: Vec<&str> = nets.iter().map(|net| net.name.as_str()).collect();
            let what = format!(
                "there is no net `{}`; in the folder `nets` beside the site's are: {}",
                coordination.net,
                known.join(", ")
            );
            loader.wrong("net", what);
            errors.append(&mut loader.errors);
            continue;
        };
        let plan = loader.plan(net, limits);
        for area in plan.iter().flat_map(|plan| &plan.governed) {
            if let Some(other) = plans.iter().find(|other| other.governed.contains(area)) {
                let area = &setup.areas[*area].id;
                let what = format!("area `{area}` is let into by `{}` already", other.id);
                loader.wrong("", what);
            }
        }
        if loader.errors.is_empty() {
            plans.extend(plan.map(Arc::new));
        }
        errors.append(&mut loader.errors);
    }
    if errors.is_empty() {
        Ok(plans)
    } else {
        Err(errors)
    }
}

impl<'a> Loader<'a> {
    fn plan(&mut self, net: &'a NetConfig, limits: &Limits) -> Option<Plan> {
        let proofs = match net.analyse(limits) {
            Ok(proofs) => proofs,
            Err(refusal) => {
                self.wrong("net", format!("the net may not run: {refusal}"));
                return None;
            }
        };
        let known: Vec<&str> = net.roles.iter().map(|role| role.id.as_str()).collect();
        for role in self.coordination.flags.keys() {
            self.is_role(format!("flags.{role}"), role, &known);
        }
        let mut roles = Vec::new();
        for role in &net.roles {
            let protocol = Arc::clone(net.protocol(&role.id)?);
            roles.push(self.role(net, &role.id, protocol)?);
        }
        let mut governed: Vec<usize> = { roles.iter() }
            .flat_map(|role| match &role.kind {
                Kind::Access(passages) => &passages[..],
                Kind::Control => &[],
            })
            .flat_map(|passage| passage.areas.iter().copied())
            .collect();
        governed.sort_unstable();
        governed.dedup();
        let situations: Vec<SituationPlan> = { self.coordination.situations.iter() }
            .filter_map(|situation| {
                for role in situation.roles.keys() {
                    let place = format!("situations.{}.{role}", situation.situation);
                    self.is_role(place, role, &known);
                }
                self.situation(net, &proofs, &roles, situation)
            })
            .collect();
        if self.coordination.situations.is_empty() {
            self.wrong("situations", "there is none, so the net would never start");
        }
        let preempt = self.preempt(&roles, &situations);
        if !self.errors.is_empty() {
            return None;
        }
        let yields = preempt.iter().flat_map(|own| &own.yields);
        let scripts =
            { roles.iter().map(|role| &role.script) }.chain(yields.map(|yields| &yields.script));
        let mut concerned: Vec<usize> = { governed.iter().copied() }
            .chain(scripts.flat_map(Script::areas))
            .collect();
        concerned.sort_unstable();
        concerned.dedup();
        Some(Plan {
            id: self.id.to_owned(),
            net: net.name.clone(),
            alarm_after_ns: nanoseconds(self.coordination.alarm_after_s),
            roles,
            situations,
            preempt,
            governed,
            concerned,
            meanings: { net.places.iter() }
                .filter(|place| place.kind == PlaceKind::Internal)
                .map(|place| (place.id.clone(), place.about.clone()))
                .collect(),
        })
    }
}
