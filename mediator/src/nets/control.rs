//! The array by which robots yield.

use std::sync::Arc;

use super::plan::Script;
use contract::protocols::{self, RELEASE};
use contract::wire::Instruction;

/// The mediator tells a robot to get out of the way.
const HALT: &str = "halt";
/// The robot has read that; whether it is out of the way, its state tells.
const HALTED: &str = "halted";

/// The array by which a robot yields, and what it does when it is released from that.
pub(crate) fn yielding(
    event: &str,
    enters: Vec<usize>,
    areas: Vec<String>,
    release: Option<Instruction>,
) -> Script {
    let protocol = protocols::control([(HALT, true), (HALTED, false)])
        .expect("these flags make a protocol; a test compiles them");
    let (halt, flags) = (protocol.flag(HALT), protocol.flags());
    let enters = flags.map(|(flag, ..)| { Some(flag) == halt }.then(|| enters.clone()));
    let enters = enters.map(Option::unwrap_or_default).collect();
    let mut script = Script::new(Arc::new(protocol), enters);
    for flag in &mut script.flags {
        flag.instruction = match flag.name.as_str() {
            HALT => Some(Instruction {
                event: event.to_owned(),
                areas: areas.clone(),
                ..Instruction::default()
            }),
            RELEASE => release.clone(),
            _ => None,
        };
    }
    script
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_yield_by_an_array_that_they_can_rebuild() {
        let script = yielding("halt", vec![4], vec!["5".into()], None);
        let rebuilt = protocols::control_paths(&script.flags, &script.paths).expect("valid");
        assert_eq!(rebuilt, *script.protocol);
        assert_eq!((rebuilt.paths(), rebuilt.flags().count()), (1, 6));
        let entered: Vec<usize> = script.enters.concat();
        assert_eq!(entered, [4]);
    }
}
