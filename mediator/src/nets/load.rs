//! From site and net files to plans: names resolved, protocols recognised, nets analysed.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::control;
use super::plan::{
    Cast, Kind, Passage, Plan, PreemptPlan, RolePlan, Script, SituationPlan, Wired, YieldPlan,
};
use crate::setup::Setup;
use config::{NetConfig, NetFlag, SiteConfig};
use contract::protocols::{ACQUIRE, ACQUIRED, RELEASE, RELEASED};
use contract::wire::{Instruction, Pose};
use coordination::analysis::Limits;
use coordination::event::EventTable;
use coordination::petri::{Binding, Net, PlaceKind};
use coordination::protocol::{FlagId, Party, Position, Protocol};
use description::site::{CastConfig, CoordinationConfig, YieldConfig};

/// Why a coordination cannot run on its site.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("coordinations.{coordination}{}{place}: {what}", if .place.is_empty() { "" } else { "." })]
pub struct PlanError {
    /// Its id in the site file.
    pub coordination: String,
    /// Where in its section.
    pub place: String,
    /// What is wrong.
    pub what: String,
}

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

struct Loader<'a> {
    id: &'a str,
    coordination: &'a CoordinationConfig,
    site: &'a SiteConfig,
    areas: HashMap<&'a str, usize>,
    robots: HashMap<&'a str, usize>,
    errors: Vec<PlanError>,
}

impl<'a> Loader<'a> {
    fn wrong(&mut self, place: impl Into<String>, what: impl Into<String>) {
        self.errors.push(PlanError {
            coordination: self.id.to_owned(),
            place: place.into(),
            what: what.into(),
        });
    }

    fn plan(&mut self, net: &'a NetConfig, limits: &Limits) -> Option<Plan> {
        if let Err(refusal) = net.analyse(limits) {
            self.wrong("net", format!("the net may not run: {refusal}"));
            return None;
        }
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
        let mut events = EventTable::new();
        let situations: Vec<SituationPlan> = { self.coordination.situations.iter() }
            .filter_map(|situation| {
                for role in situation.roles.keys() {
                    let place = format!("situations.{}.{role}", situation.situation);
                    self.is_role(place, role, &known);
                }
                self.situation(net, &roles, situation, &mut events)
            })
            .collect();
        if self.coordination.situations.is_empty() {
            self.wrong("situations", "there is none, so the net would never start");
        }
        let preempt = self.preempt(&roles, &situations);
        if !self.errors.is_empty() {
            return None;
        }
        Some(Plan {
            id: self.id.to_owned(),
            net: net.name.clone(),
            alarm_after_ns: nanoseconds(self.coordination.alarm_after_s),
            roles,
            situations,
            preempt,
            governed,
            meanings: { net.places.iter() }
                .filter(|place| place.kind == PlaceKind::Internal)
                .map(|place| (place.id.clone(), place.about.clone()))
                .collect(),
        })
    }

    fn is_role(&mut self, place: String, role: &str, known: &[&str]) {
        if !known.contains(&role) {
            let known = known.join(", ");
            self.wrong(
                place,
                format!("the net has no role `{role}`; it has {known}"),
            );
        }
    }

    fn areas(&mut self, place: &str, ids: &[String]) -> Vec<usize> {
        let mut found = Vec::new();
        for id in ids {
            match self.areas.get(id.as_str()) {
                Some(&area) => found.push(area),
                None => self.wrong(place, format!("the site has no area `{id}`")),
            }
        }
        found
    }

    // ---------------------------------------------------------------- roles

    fn role(&mut self, net: &NetConfig, role: &str, protocol: Arc<Protocol>) -> Option<RolePlan> {
        let place = format!("flags.{role}");
        if protocol.keeper() == Some(Party::First) {
            let what = "the robot is the keeper of its protocol: only the mediator can be";
            self.wrong(&place, what);
            return None;
        }
        let mut enters = Vec::new();
        for (_, flag, _) in protocol.flags() {
            let areas = { net.flag(role, flag) }.map_or(&[][..], |flag| &flag.command.enters);
            enters.push(self.areas(&format!("{place}.{flag}"), areas));
        }
        let is_control = protocol.flag(ACQUIRE).is_some();
        let kind = if is_control {
            self.check_control(&place, &protocol);
            Kind::Control
        } else {
            Kind::Access(self.passages(&place, &protocol, &enters)?)
        };
        let mut flags = control::flags(&protocol);
        let meanings = self
            .coordination
            .flags
            .get(role)
            .cloned()
            .unwrap_or_default();
        for own in meanings.keys() {
            if protocol.flag(own).is_none() {
                let known: Vec<&str> = protocol.flags().map(|(_, flag, _)| flag).collect();
                let known = known.join(", ");
                let what = format!("the protocol has no flag `{own}`; it has {known}");
                self.wrong(format!("{place}.{own}"), what);
            }
        }
        for flag in flags.iter_mut().filter(|_| is_control) {
            let meaning = meanings.get(&flag.name).cloned().unwrap_or_default();
            let place = format!("{place}.{}", flag.name);
            if flag.by_mediator && meaning.on_output.is_some() {
                self.wrong(&place, "it is the mediator's flag, so it has an `event`");
            } else if !flag.by_mediator && meaning.event.is_some() {
                self.wrong(&place, "it is the robot's flag, so it has an `on_output`");
            }
            let said = net.flag(role, &flag.name);
            flag.instruction = instruction(meaning.event.as_deref(), said);
            flag.on_output = meaning.on_output.unwrap_or_default();
            self.check_machine(&place, role, meaning.event.as_deref(), &flag.on_output);
        }
        if !is_control && !meanings.is_empty() {
            let what = "the protocol is request, granted, entered, released, which means areas and no events";
            self.wrong(&place, what);
        }
        Some(RolePlan {
            name: role.to_owned(),
            script: Script {
                paths: control::paths(&protocol),
                flags,
                enters,
                protocol,
            },
            kind,
        })
    }

    /// Each path begins with acquire, acquired and ends with release, released.
    fn check_control(&mut self, place: &str, protocol: &Protocol) {
        for end in protocol.positions().filter(|&at| protocol.is_end(at)) {
            let path: Vec<(&str, bool)> = protocol
                .set_flags(end)
                .map(|(flag, _)| {
                    let mine = protocol.owner(flag) == Some(Party::Second);
                    (protocol.flag_name(flag), mine)
                })
                .collect();
            let begins = path.starts_with(&[(ACQUIRE, true), (ACQUIRED, false)]);
            let ends = path.ends_with(&[(RELEASE, true), (RELEASED, false)]);
            if !begins || !ends || path.len() < 4 {
                let flags: Vec<&str> = path.iter().map(|(flag, _)| *flag).collect();
                let what = format!(
                    "a protocol that acquires a robot must begin with `acquire` (mediator), `acquired` (robot) and end with `release` (mediator), `released` (robot); one path is {}",
                    flags.join(", ")
                );
                self.wrong(place, what);
            }
        }
    }

    /// The paths of a protocol that is request, granted, entered, released.
    fn passages(
        &mut self,
        place: &str,
        protocol: &Protocol,
        enters: &[Vec<usize>],
    ) -> Option<Vec<Passage>> {
        let mut passages: Vec<Passage> = Vec::new();
        for end in protocol.positions().filter(|&at| protocol.is_end(at)) {
            let path: Vec<(FlagId, Position)> = protocol.set_flags(end).collect();
            let owners: Vec<bool> = { path.iter() }
                .map(|&(flag, _)| protocol.owner(flag) == Some(Party::Second))
                .collect();
            let fits = owners == [false, true, false, false]
                && !enters[path[1].0.index()].is_empty()
                && passages.iter().all(|other| other.request != path[0].0);
            if !fits {
                let what = format!(
                    "neither begins the protocol with `acquire`, nor is each of its paths a request (robot), a grant with `enters` (mediator), entered (robot) and released (robot), told apart by the request; one path is {}",
                    protocol.describe(end)
                );
                self.wrong(place, what);
                return None;
            }
            passages.push(Passage {
                request: path[0].0,
                granted_at: path[1].1,
                entered: path[2].0,
                entered_at: path[2].1,
                released: path[3].0,
                areas: enters[path[1].0.index()].clone(),
            });
        }
        Some(passages)
    }

    /// Events and outputs must be ones of the machines of all robots that may play the role.
    fn check_machine(&mut self, place: &str, role: &str, event: Option<&str>, output: &str) {
        let site = self.site;
        let mut machines: Vec<&str> = Vec::new();
        for cast in { self.coordination.situations.iter() }.filter_map(|own| own.roles.get(role)) {
            machines.extend(cast.role.as_deref());
            let robot = cast.robot.as_ref().and_then(|robot| site.robots.get(robot));
            machines.extend(robot.map(|robot| robot.role.as_str()));
        }
        machines.sort_unstable();
        machines.dedup();
        for machine in machines {
            let Some(fsm) = site.fsm.get(machine) else {
                continue;
            };
            if let Some(event) = event
                && !fsm
                    .transitions
                    .iter()
                    .any(|transition| transition.on == event)
            {
                let what = format!("no transition of [fsm.{machine}] is on the event `{event}`");
                self.wrong(place, what);
            }
            let mut outputs = fsm
                .transitions
                .iter()
                .flat_map(|transition| &transition.outputs);
            if !output.is_empty() && !outputs.any(|own| own == output) {
                let what = format!("no transition of [fsm.{machine}] has the output `{output}`");
                self.wrong(place, what);
            }
        }
    }

    // ---------------------------------------------------------------- situations

    fn situation(
        &mut self,
        net: &NetConfig,
        roles: &[RolePlan],
        situation: &description::site::SituationConfig,
        events: &mut EventTable,
    ) -> Option<SituationPlan> {
        let name = &situation.situation;
        let place = format!("situations.{name}");
        let Some(model) = net.model(name) else {
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
        let compiled = match model.compile(events) {
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
            wired: self.wire(&place, compiled, roles)?,
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

    /// Which flag each source and sink hangs on.
    fn wire(&mut self, place: &str, net: Net, roles: &[RolePlan]) -> Option<Wired> {
        let mut wired = Wired {
            sources: { roles.iter() }
                .map(|role| vec![None; role.script.protocol.flags().count()])
                .collect(),
            sinks: BTreeMap::new(),
            net: net.clone(),
        };
        let model = net.model();
        let places: Vec<_> = model.places().collect();
        for (list, is_source) in [(net.sources(), true), (net.sinks(), false)] {
            for &(id, event) in list {
                let found = &places[id.index()];
                let hangs = match found.binding {
                    Some(Binding::Flag { protocol, flag }) => {
                        let role = roles.iter().position(|role| role.name == *protocol);
                        role.and_then(|role| Some((role, roles[role].script.protocol.flag(flag)?)))
                    }
                    _ => None,
                };
                let Some((role, flag)) = hangs else {
                    let what = format!(
                        "place `{}` hangs on no flag of a role, and nothing else is known here",
                        found.name
                    );
                    self.wrong(place, what);
                    return None;
                };
                if is_source {
                    let source = &mut wired.sources[role][flag.index()];
                    source.get_or_insert_with(|| (event, Vec::new())).1.push(id);
                } else {
                    wired.sinks.insert(event, (role, flag));
                }
            }
        }
        Some(wired)
    }

    // ---------------------------------------------------------------- pre-emption

    fn preempt(&mut self, roles: &[RolePlan], situations: &[SituationPlan]) -> Option<PreemptPlan> {
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

fn instruction(event: Option<&str>, said: Option<&NetFlag>) -> Option<Instruction> {
    let command = said.map(|flag| &flag.command);
    let instruction = Instruction {
        event: event.unwrap_or_default().to_owned(),
        speed_limit_m_s: { command }
            .and_then(|command| command.speed_limit_m_s)
            .unwrap_or_default(),
        stop_at: { command }
            .and_then(|command| command.stop_pose)
            .map(|pose| Pose {
                x_m: pose.x_m,
                y_m: pose.y_m,
                theta_rad: pose.theta_rad,
                ..Pose::default()
            }),
        areas: command.map_or_else(Vec::new, |command| command.enters.clone()),
    };
    (instruction != Instruction::default()).then_some(instruction)
}

fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9) as u64
}
