//! How robots get out of the way when nothing goes on.

use super::loader::{Loader, nanoseconds};
use crate::nets::control;
use crate::nets::plan::{Kind, PreemptPlan, RolePlan, SituationPlan, YieldPlan};
use contract::protocols::RELEASE;
use description::site::YieldConfig;

impl Loader<'_> {
    pub(super) fn preempt(
        &mut self,
        roles: &[RolePlan],
        situations: &[SituationPlan],
    ) -> Option<PreemptPlan> {
        let preempt = self.coordination.preempt.as_ref()?;
        let known: Vec<&str> = roles.iter().map(|role| role.name.as_str()).collect();
        for role in preempt.yields.keys() {
            self.is_role(format!("preempt.yields.{role}"), role, &known);
        }
        let situation = preempt.situation.as_ref().map(|name| {
            let found = situations.iter().position(|own| own.name == *name);
            found.unwrap_or_else(|| {
                let what = format!("`{name}` is none of the situations here");
                self.wrong("preempt.situation", what);
                0
            })
        });
        let mut yields = Vec::new();
        for role in roles {
            if matches!(role.kind, Kind::Access(_)) {
                let what = format!(
                    "role `{}` gives no control away, so it cannot be told to yield",
                    role.name
                );
                self.wrong("preempt", what);
                continue;
            }
            let Some(own) = preempt.yields.get(&role.name) else {
                let what = format!(
                    "it does not say how role `{}` gets out of the way",
                    role.name
                );
                self.wrong("preempt.yields", what);
                continue;
            };
            yields.push(self.yields(role, own));
        }
        Some(PreemptPlan {
            after_ns: nanoseconds(preempt.after_s),
            situation,
            yields,
        })
    }

    fn yields(&mut self, role: &RolePlan, own: &YieldConfig) -> YieldPlan {
        let place = format!("preempt.yields.{}", role.name);
        let mut flags = role.script.flags.iter();
        let release = flags.find(|flag| flag.name == RELEASE);
        let release = release.and_then(|flag| flag.instruction.clone());
        let enters = self.areas(&place, &own.enters);
        self.check_machine(&place, &role.name, Some(&own.event), "");
        YieldPlan {
            script: control::yielding(&own.event, enters, own.enters.clone(), release),
            states: own.states.clone(),
        }
    }
}
