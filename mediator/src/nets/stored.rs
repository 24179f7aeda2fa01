//! What the journal knows of an instance, and the way back.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::instance::{Instance, Phase};
use super::participant::{Kept, Participant};
use super::plan::{Kind, Plan};
use crate::journal::{CoordinationRecord, LevelRecord, PartRecord};
use coordination::binding::{NetBinding, Standing};
use coordination::petri::Net;

/// Why an instance of the journal cannot go on.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Unrestorable(pub(crate) String);

impl Instance {
    pub(crate) fn record(
        &self,
        robot: impl Fn(usize) -> String,
        area: impl Fn(usize) -> String,
    ) -> CoordinationRecord {
        let participants = self.participants().iter().zip(&self.plan.roles);
        CoordinationRecord {
            coordination: self.plan.id.clone(),
            situation: match &self.phase {
                Phase::Running { situation, .. } => {
                    Some(self.plan.situations[*situation].name.clone())
                }
                Phase::Yielding(_) => None,
            },
            marking: self.marking(),
            waiting: self.waiting(),
            parts: participants
                .map(|(participant, role)| PartRecord {
                    role: role.name.clone(),
                    robot: robot(participant.robot),
                    level: participant.read_level().into(),
                    own: participant.own.as_ref().map(|own| own.level().into()),
                    kept: { participant.kept.iter() }
                        .map(|kept| (area(kept.area), kept.granted))
                        .collect(),
                })
                .collect(),
        }
    }

    /// By the name of the source: how many events wait for it.
    fn waiting(&self) -> BTreeMap<String, u32> {
        let Phase::Running { net, .. } = &self.phase else {
            return BTreeMap::new();
        };
        let waiting = net.standing().waiting.into_iter();
        let name = |place| net.executor().net().place_name(place).to_owned();
        waiting.map(|(place, count)| (name(place), count)).collect()
    }

    /// Goes on where the journal says that it was, if its net can have come there.
    pub(crate) fn restore(
        plan: &Arc<Plan>,
        number: u64,
        record: &CoordinationRecord,
        robot: impl Fn(&str) -> Option<usize>,
        area: impl Fn(&str) -> Option<usize>,
        now_ns: u64,
    ) -> Result<Self, Unrestorable> {
        let lost = |what: String| Unrestorable(what);
        let names = record
            .parts
            .iter()
            .map(|participant| participant.role.as_str());
        if !names.eq(plan.roles.iter().map(|role| role.name.as_str())) {
            return Err(lost("its net has other roles now".into()));
        }
        let participants = { record.parts.iter().enumerate() }.map(|(role, stored)| {
            let robot = { robot(&stored.robot) }
                .ok_or_else(|| lost(format!("there is no robot `{}` any more", stored.robot)))?;
            participant(plan, role, robot, record.situation.is_none(), stored, &area)
        });
        let participants = participants.collect::<Result<Vec<Participant>, _>>()?;
        let Some(name) = &record.situation else {
            if plan.preempt.is_none() {
                return Err(lost("it has no `preempt` any more".into()));
            }
            return Ok(Self::new(
                plan,
                number,
                Phase::Yielding(participants),
                now_ns,
            ));
        };
        let situation = { plan.situations.iter() }
            .position(|own| own.name == *name)
            .ok_or_else(|| lost(format!("it has no situation `{name}` any more")))?;
        let own = &plan.situations[situation];
        let names = plan.roles.iter().map(|role| role.name.as_str());
        let standing = standing(&own.net, record)?;
        let net = NetBinding::resume(&own.proof, &own.net, names.zip(participants), &standing)
            .map_err(|errors| {
                let texts: Vec<String> = errors.iter().map(ToString::to_string).collect();
                lost(texts.join("; "))
            })?;
        let phase = Phase::Running {
            situation,
            net: Box::new(net),
        };
        let mut instance = Self::new(plan, number, phase, now_ns);
        for (participant, role) in instance.participants_mut().iter_mut().zip(&plan.roles) {
            if let Some(own) = &participant.own {
                let level = own.level();
                { participant.merge(level) }
                    .map_err(|error| lost(format!("role `{}`: {error}", role.name)))?;
            }
        }
        Ok(instance)
    }
}

fn participant(
    plan: &Plan,
    role: usize,
    robot: usize,
    yields: bool,
    stored: &PartRecord,
    area: impl Fn(&str) -> Option<usize>,
) -> Result<Participant, Unrestorable> {
    let lost = |what: String| Unrestorable(what);
    let preempt = plan.preempt.as_ref().filter(|_| yields);
    let own = &plan.roles[role];
    let script = preempt.map_or(&own.script, |preempt| &preempt.yields[role].script);
    let derived = matches!(own.kind, Kind::Access(_));
    let own = stored.own.filter(|_| derived).map(LevelRecord::level);
    if derived && own.is_none() {
        return Err(lost(format!("role `{}` has no side", stored.role)));
    }
    let mut participant = Participant::resume(robot, script, stored.level.level(), own)
        .map_err(|error| lost(format!("role `{}`: {error}", stored.role)))?;
    for (id, granted) in &stored.kept {
        let area = area(id).ok_or_else(|| lost(format!("there is no area `{id}` any more")))?;
        participant.kept.push(Kept {
            area,
            granted: *granted,
            left: false,
        });
    }
    Ok(participant)
}

fn standing(net: &Net, record: &CoordinationRecord) -> Result<Standing, Unrestorable> {
    let find = |place: &String| {
        let found = net.place_id(place);
        found.ok_or_else(|| Unrestorable(format!("its net has no place `{place}` any more")))
    };
    let waiting = record.waiting.iter();
    Ok(Standing {
        marked: record.marking.iter().map(find).collect::<Result<_, _>>()?,
        waiting: waiting
            .map(|(place, &count)| Ok((find(place)?, count)))
            .collect::<Result<_, _>>()?,
    })
}
