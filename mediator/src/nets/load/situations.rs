//! In which situations a net starts, and who plays its roles.

use super::loader::Loader;
use crate::nets::participant::Participant;
use crate::nets::plan::{Cast, Kind, RolePlan, SituationPlan};
use config::NetConfig;
use coordination::analysis::Proof;
use coordination::binding::NetBinding;
use coordination::event::EventTable;
use coordination::petri::{Binding, Net};
use description::site::{CastConfig, SituationConfig};

impl Loader<'_> {
    pub(super) fn situation(
        &mut self,
        net: &NetConfig,
        proofs: &[Proof],
        roles: &[RolePlan],
        situation: &SituationConfig,
    ) -> Option<SituationPlan> {
        let name = &situation.situation;
        let place = format!("situations.{name}");
        let mut all = net.situations.iter().zip(proofs);
        let Some((_, proof)) = all.find(|(own, _)| own.id == *name) else {
            let known: Vec<&str> = { net.situations.iter() }
                .map(|own| own.id.as_str())
                .collect();
            let known = known.join(", ");
            self.wrong(
                place,
                format!("the net has no such situation; it has {known}"),
            );
            return None;
        };
        let mut casts = Vec::new();
        for role in roles {
            let Some(cast) = situation.roles.get(&role.name) else {
                let what = format!("it does not say who plays the role `{}`", role.name);
                self.wrong(&place, what);
                continue;
            };
            casts.push(self.cast(&format!("{place}.{}", role.name), role, cast));
        }
        let compiled = match proof.model().compile(&mut EventTable::new()) {
            Ok(net) => net,
            Err(errors) => {
                for error in errors {
                    self.wrong(&place, error.to_string());
                }
                return None;
            }
        };
        Some(SituationPlan {
            name: name.clone(),
            casts,
            net: self.bindable(&place, compiled, proof, roles)?,
            proof: proof.clone(),
        })
    }

    fn cast(&mut self, place: &str, role: &RolePlan, cast: &CastConfig) -> Cast {
        let fits = |id: &str| {
            let site_role = self.site.robots.get(id).map(|robot| robot.role.as_str());
            cast.robot.as_deref().is_none_or(|own| own == id)
                && cast
                    .role
                    .as_deref()
                    .is_none_or(|own| Some(own) == site_role)
        };
        let mut robots: Vec<usize> = { self.robots.iter() }
            .filter(|(id, _)| fits(id))
            .map(|(_, &robot)| robot)
            .collect();
        robots.sort_unstable();
        if robots.is_empty() {
            self.wrong(place, "no robot of this site fits");
        }
        let conditions = !(cast.holds.is_empty()
            && cast.stands_in.is_empty()
            && cast.without.is_empty()
            && cast.asks.is_empty()
            && cast.states.is_empty()
            && cast.within.is_none());
        match role.kind {
            Kind::Access(_) if conditions => {
                let what = "a role that is only let into areas plays from the start, so only `robot` and `role` say who plays it";
                self.wrong(place, what);
            }
            Kind::Control
                if cast.asks.is_empty() && cast.holds.is_empty() && cast.stands_in.is_empty() =>
            {
                let what = "it says neither which areas the robot has or is in nor which it asks for, so it would be coordinated anywhere";
                self.wrong(place, what);
            }
            _ => {}
        }
        Cast {
            robots,
            holds: self.areas(place, &cast.holds),
            stands_in: self.areas(place, &cast.stands_in),
            without: self.areas(place, &cast.without),
            asks: self.areas(place, &cast.asks),
            states: cast.states.clone(),
            within: cast.within,
        }
    }

    /// The net, if its instances can be made: every source and sink hangs on a flag of a role.
    fn bindable(
        &mut self,
        place: &str,
        net: Net,
        proof: &Proof,
        roles: &[RolePlan],
    ) -> Option<Net> {
        let model = net.model();
        let mut places = model.places();
        let event = places.find(|own| matches!(own.binding, Some(Binding::Event(_))));
        if let Some(event) = event {
            let what = format!(
                "place `{}` hangs on no flag of a role, and nothing else is known here",
                event.name
            );
            self.wrong(place, what);
            return None;
        }
        let sides = roles.iter().map(|role| {
            let derived = matches!(role.kind, Kind::Access(_));
            (
                role.name.as_str(),
                Participant::new(0, &role.script, derived),
            )
        });
        if let Err(errors) = NetBinding::new(proof, &net, sides) {
            for error in errors {
                self.wrong(place, error.to_string());
            }
            return None;
        }
        drop(places);
        Some(net)
    }
}
