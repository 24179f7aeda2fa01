//! Protocol 2 for messages: flags and paths of a protocol, and the array by which robots yield.

use std::sync::Arc;

use super::plan::Script;
use contract::protocols::{self, RELEASE};
use contract::wire::{ControlFlag, ControlPath, Instruction};
use coordination::protocol::{Party, Protocol};

/// The mediator tells a robot to get out of the way.
pub(crate) const HALT: &str = "halt";
/// The robot has read that; whether it is out of the way, its state tells.
pub(crate) const HALTED: &str = "halted";

/// All paths of a protocol, as messages list them.
pub(crate) fn paths(protocol: &Protocol) -> Vec<ControlPath> {
    let ends = protocol.positions().filter(|&at| protocol.is_end(at));
    ends.map(|end| ControlPath {
        flags: protocol
            .set_flags(end)
            .map(|(flag, _)| u32::from(flag.0))
            .collect(),
    })
    .collect()
}

/// All flags of a protocol, as messages list them, without what they mean.
pub(crate) fn flags(protocol: &Protocol) -> Vec<ControlFlag> {
    let flags = protocol.flags();
    flags
        .map(|(_, name, owner)| ControlFlag {
            name: name.to_owned(),
            by_mediator: owner == Party::Second,
            ..ControlFlag::default()
        })
        .collect()
}

/// The array by which a robot yields, and what it does when it is released from that.
pub(crate) fn yielding(
    event: &str,
    enters: Vec<usize>,
    areas: Vec<String>,
    release: Option<Instruction>,
) -> Script {
    let protocol = protocols::control([(HALT, true), (HALTED, false)])
        .expect("these flags make a protocol; a test compiles them");
    let mut flags = flags(&protocol);
    let mut entered = vec![Vec::new(); flags.len()];
    if let Some(halt) = protocol.flag(HALT) {
        flags[halt.index()].instruction = Some(Instruction {
            event: event.to_owned(),
            areas,
            ..Instruction::default()
        });
        entered[halt.index()] = enters;
    }
    if let Some(flag) = protocol.flag(RELEASE) {
        flags[flag.index()].instruction = release;
    }
    Script {
        paths: paths(&protocol),
        flags,
        enters: entered.into(),
        protocol: Arc::new(protocol),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_yield_by_an_array_that_they_can_rebuild() {
        let script = yielding("halt", vec![4], vec!["5".into()], None);
        let flags: Vec<(&str, bool)> = script
            .flags
            .iter()
            .map(|flag| (flag.name.as_str(), flag.by_mediator))
            .collect();
        let paths: Vec<Vec<usize>> = script
            .paths
            .iter()
            .map(|path| path.flags.iter().map(|&flag| flag as usize).collect())
            .collect();
        let rebuilt = protocols::control_paths(&flags, &paths).expect("valid");
        assert_eq!(rebuilt.paths(), 1);
        assert_eq!(rebuilt.flags().count(), 6);
    }
}
