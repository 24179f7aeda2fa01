//! How fast the mediator answers, as a third party hears it.
//!
//! Both messages also travel to this listener, which delays both alike. A robot's message that is heard after the answer to
//! it is not measured.

use std::collections::BTreeMap;

use super::access::Deeds;
use super::control;

/// What was measured.
#[derive(Clone, Debug, Default)]
pub struct Latencies {
    /// From requests that could be granted at once to their grants.
    pub grants_ns: Vec<u64>,
    /// From a robot's flag to the mediator's next command through the net.
    pub commands_ns: Vec<u64>,
    /// Areas that nets let robots into by protocol 1, and the number of the net.
    governed: BTreeMap<String, usize>,
    /// By robot and area: requests that could be granted at once, and when they were heard.
    requests: BTreeMap<(String, String), u64>,
    /// By net with protocol 1: the last flag, of which robot and area and when it was heard, while no command has
    /// followed.
    accesses: BTreeMap<usize, ((String, String), u64)>,
    /// By coordination with protocol 2: the same.
    controls: BTreeMap<u64, u64>,
}

impl Latencies {
    pub(super) fn new(governed: BTreeMap<String, usize>) -> Self {
        Self {
            governed,
            ..Self::default()
        }
    }

    /// A robot's levels of protocol 1; `free` says whether its request could be granted at once.
    pub(super) fn robot(&mut self, robot: &str, area: &str, deeds: Deeds, free: bool, at_ns: u64) {
        let key = (robot.to_owned(), area.to_owned());
        if deeds.granted {
            // Heard from the robot first: when it was sent is not known.
            self.requests.remove(&key);
        } else if deeds.requested && free {
            self.requests.insert(key.clone(), at_ns);
        }
        if let Some(&net) = self.governed.get(area) {
            if deeds.granted {
                self.accesses.remove(&net);
            } else if deeds.requested || deeds.moved {
                self.accesses.insert(net, (key, at_ns));
            }
        }
    }

    /// The mediator's levels of protocol 1: whether it says that the robot has to wait, and whether the area is full as far
    /// as was heard before.
    pub(super) fn mediator(
        &mut self,
        robot: &str,
        area: &str,
        deeds: Deeds,
        waits: bool,
        full: bool,
        at_ns: u64,
    ) {
        let request = (robot.to_owned(), area.to_owned());
        if waits {
            self.requests.remove(&request);
        }
        let net = self.governed.get(area).copied();
        if waits && let Some(net) = net {
            // The net has heard this robot and makes it wait: what comes later does not answer it.
            if { self.accesses.get(&net) }.is_some_and(|(last, _)| *last == request) {
                self.accesses.remove(&net);
            }
        }
        if (deeds.requested || deeds.moved)
            && let Some(net) = net
        {
            // A robot's flag, heard from the mediator only.
            self.accesses.remove(&net);
        }
        if !deeds.granted {
            return;
        }
        if let Some(requested_ns) = self.requests.remove(&request) {
            self.grants_ns.push(at_ns.saturating_sub(requested_ns));
        }
        if let Some((_, flag_ns)) = net.and_then(|net| self.accesses.remove(&net))
            && !full
        {
            self.commands_ns.push(at_ns.saturating_sub(flag_ns));
        }
    }

    /// A robot's levels of protocol 2.
    pub(super) fn control(&mut self, coordination: u64, deeds: control::Deeds, at_ns: u64) {
        if deeds.by_mediator {
            self.controls.remove(&coordination);
        } else if deeds.by_robot {
            self.controls.insert(coordination, at_ns);
        }
    }

    /// The mediator's levels of protocol 2.
    pub(super) fn command(&mut self, coordination: u64, deeds: control::Deeds, at_ns: u64) {
        let flag_ns = (deeds.by_mediator || deeds.by_robot)
            .then(|| self.controls.remove(&coordination))
            .flatten();
        if let Some(flag_ns) = flag_ns
            && deeds.by_mediator
            && !deeds.by_robot
        {
            self.commands_ns.push(at_ns.saturating_sub(flag_ns));
        }
    }
}
