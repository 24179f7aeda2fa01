//! The roles of a net: what their protocols are about, and what their flags mean.

use std::sync::Arc;

use super::loader::Loader;
use crate::nets::plan::{Kind, Passage, RolePlan, Script};
use config::{NetConfig, NetFlag};
use contract::protocols::{ACQUIRE, ACQUIRED, RELEASE, RELEASED};
use contract::wire::{Instruction, Pose};
use coordination::acquire_release::{OtherPath, Resource};
use coordination::protocol::{FlagId, Party, Position, Protocol};

impl Loader<'_> {
    pub(super) fn role(
        &mut self,
        net: &NetConfig,
        role: &str,
        protocol: Arc<Protocol>,
    ) -> Option<RolePlan> {
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
        let mut script = Script::new(Arc::clone(&protocol), enters);
        for flag in script.flags.iter_mut().filter(|_| is_control) {
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
            script,
            kind,
        })
    }

    /// Each path begins with acquire, acquired and ends with release, released.
    fn check_control(&mut self, place: &str, protocol: &Arc<Protocol>) {
        let control = Resource::of(
            protocol,
            Party::Second,
            [ACQUIRE, ACQUIRED],
            [RELEASE, RELEASED],
        );
        if let Err(OtherPath { end }) = control {
            let what = format!(
                "a protocol that acquires a robot must begin with `acquire` (mediator), `acquired` (robot) and end with `release` (mediator), `released` (robot); one path is {}",
                protocol.describe(end)
            );
            self.wrong(place, what);
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
    pub(super) fn check_machine(
        &mut self,
        place: &str,
        role: &str,
        event: Option<&str>,
        output: &str,
    ) {
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
            .map(Pose::from),
        areas: command.map_or_else(Vec::new, |command| command.enters.clone()),
    };
    (instruction != Instruction::default()).then_some(instruction)
}
