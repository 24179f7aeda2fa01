//! Protocol 2, as heard by a third party.

use std::collections::BTreeMap;

use contract::wire::Control;

/// Messages to two robots may be heard in the wrong order.
const ORDER_NS: u64 = 300_000_000;

/// A net had the discrete control of a robot.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Controlled {
    /// Number of the coordination.
    pub number: u64,
    /// Name of the net.
    pub net: String,
    /// Robot.
    pub robot: String,
    /// When it was first asked for.
    pub from_ns: u64,
    /// When the robot said that it has given it away; none: not yet.
    pub acquired_ns: Option<u64>,
    /// Areas that its orders have named so far.
    pub areas: Vec<String>,
    /// When the robot had it back; none: not yet.
    pub to_ns: Option<u64>,
    /// Another coordination that took the robot over, and when.
    pub replaced: Option<(u64, u64)>,
    /// The same, and when this one was heard to go on all the same.
    pub rival: Option<(u64, u64)>,
}

impl Controlled {
    /// Whether it was in force at this time.
    #[must_use]
    pub fn covers(&self, at_ns: u64) -> bool {
        self.from_ns <= at_ns && self.to_ns.is_none_or(|to_ns| to_ns >= at_ns)
    }
}

/// Whose flags in a level are new.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Deeds {
    pub(super) by_mediator: bool,
    pub(super) by_robot: bool,
}

/// One robot in one coordination.
#[derive(Clone, Debug)]
struct Part {
    /// In the list of all.
    index: usize,
    progress: u32,
    /// Of each flag, whether it is the mediator's.
    flags: Vec<bool>,
    /// Of each flag, the areas that its order names.
    areas: Vec<Vec<String>>,
    paths: Vec<Vec<u32>>,
}

/// All robots in all coordinations.
#[derive(Clone, Debug, Default)]
pub(super) struct Controls {
    parts: BTreeMap<(u64, String), Part>,
    all: Vec<Controlled>,
    /// Of the present journal are those from this one on.
    present: usize,
}

impl Controls {
    pub(super) fn all(&self) -> &[Controlled] {
        &self.all
    }

    pub(super) fn is_controlled(&self, robot: &str) -> bool {
        self.all
            .iter()
            .any(|own| own.robot == robot && own.to_ns.is_none())
    }

    /// What the mediator says.
    pub(super) fn order(&mut self, robot: &str, control: &Control, at_ns: u64) -> Deeds {
        // A larger number replaces a smaller one: that one is broken off, and commands nobody any more.
        for own in &mut self.all[self.present..] {
            if own.robot == robot && own.number < control.coordination && own.to_ns.is_none() {
                own.to_ns = Some(at_ns);
                own.replaced = Some((control.coordination, at_ns));
            }
            if own.number == control.coordination
                && let Some((rival, since_ns)) = own.replaced
                && at_ns > since_ns + ORDER_NS
            {
                own.rival.get_or_insert((rival, at_ns));
            }
        }
        let key = (control.coordination, robot.to_owned());
        let part = self.parts.entry(key).or_insert_with(|| {
            self.all.push(Controlled {
                number: control.coordination,
                net: control.net.clone(),
                robot: robot.to_owned(),
                from_ns: at_ns,
                acquired_ns: None,
                areas: Vec::new(),
                to_ns: None,
                replaced: None,
                rival: None,
            });
            Part {
                index: self.all.len() - 1,
                progress: 0,
                flags: Vec::new(),
                areas: Vec::new(),
                paths: Vec::new(),
            }
        });
        if part.flags.is_empty() {
            part.flags = control.flags.iter().map(|flag| flag.by_mediator).collect();
            let orders = control.flags.iter().map(|flag| flag.instruction.as_ref());
            part.areas = orders
                .map(|order| order.map(|own| own.areas.clone()).unwrap_or_default())
                .collect();
            part.paths = { control.paths.iter() }
                .map(|path| path.flags.clone())
                .collect();
        }
        advance(part, &mut self.all, control, at_ns)
    }

    /// What a robot says. Before the mediator's first word the flags are not known.
    pub(super) fn answer(&mut self, robot: &str, control: &Control, at_ns: u64) -> Deeds {
        let key = (control.coordination, robot.to_owned());
        let Some(part) = self.parts.get_mut(&key) else {
            return Deeds::default();
        };
        advance(part, &mut self.all, control, at_ns)
    }

    /// A mediator with another journal goes on, and counts coordinations anew.
    pub(super) fn free_all(&mut self, at_ns: u64) {
        self.parts.clear();
        self.present = self.all.len();
        for own in &mut self.all {
            own.to_ns.get_or_insert(at_ns);
        }
    }

    /// The mediator says that the robot is free.
    pub(super) fn free(&mut self, robot: &str, at_ns: u64) {
        for own in &mut self.all {
            if own.robot == robot {
                own.to_ns.get_or_insert(at_ns);
            }
        }
    }
}

/// Takes in a level of either side. Returns whose flags are new.
fn advance(part: &mut Part, all: &mut [Controlled], control: &Control, at_ns: u64) -> Deeds {
    let mut deeds = Deeds::default();
    let Some(level) = &control.level else {
        return deeds;
    };
    let own = &mut all[part.index];
    let path = part.paths.get(level.path as usize);
    let length = path.map_or(part.flags.len(), Vec::len);
    for position in part.progress as usize..(level.progress as usize).min(length) {
        let flag = path.map_or(position, |path| path[position] as usize);
        match part.flags.get(flag) {
            Some(true) => deeds.by_mediator = true,
            Some(false) => {
                deeds.by_robot = true;
                own.acquired_ns.get_or_insert(at_ns);
            }
            None => {}
        }
        own.areas
            .extend(part.areas.get(flag).into_iter().flatten().cloned());
    }
    part.progress = part.progress.max(level.progress);
    if length > 0 && part.progress as usize >= length {
        own.to_ns.get_or_insert(at_ns);
    }
    deeds
}
