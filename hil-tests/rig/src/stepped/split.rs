//! Two mediators, of which some robots hear only the one, others only the other.

use sim::world::Random;

use crate::scenario::{Scenario, ScriptedFault, ScriptedKind, WhichMediator};

/// Splits come from the seed, apart from the faults that they belong to.
const SPLIT_STREAM: u64 = 0x5350_4C49;
/// The share of second mediators with which the network is split.
const SPLIT: f64 = 0.5;

/// For second mediators among these faults: each robot is cut off from the one or the other, or from neither, while both speak.
pub(super) fn splits(
    scenario: &Scenario,
    seed: u64,
    faults: &[ScriptedFault],
) -> Vec<ScriptedFault> {
    let mut random = Random::new(seed, SPLIT_STREAM);
    let mut splits = Vec::new();
    let seconds = [ScriptedKind::SecondMediator, ScriptedKind::CopiedMediator];
    for fault in faults.iter().filter(|fault| seconds.contains(&fault.what)) {
        if random.unit() >= SPLIT {
            continue;
        }
        for robot in &scenario.robots {
            let mediator = match random.unit() {
                ..0.333 => WhichMediator::First,
                0.333..0.667 => WhichMediator::Second,
                _ => continue,
            };
            splits.push(ScriptedFault {
                what: ScriptedKind::Partition,
                robot: Some(robot.id.clone()),
                mediator: Some(mediator),
                ..fault.clone()
            });
        }
    }
    splits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_robot_of_half_the_second_mediators_hears_one_both_or_neither() {
        let scenario = crate::testing::scenario("overtaking");
        let fault = "at_s = 20.0\nfor_s = 7.5\nwhat = \"second-mediator\"";
        let fault: ScriptedFault = toml::from_str(fault).expect("a fault");
        let of = |seed| splits(&scenario, seed, std::slice::from_ref(&fault));
        let drawn: Vec<_> = (0..400).map(of).collect();
        let split = drawn.iter().filter(|own| !own.is_empty()).count();
        // Of a split of two robots one in nine cuts off nobody.
        assert!((140..216).contains(&split), "{split}");
        let both = |own: &&Vec<ScriptedFault>| own.len() == 2 && own[0].mediator != own[1].mediator;
        let apart = drawn.iter().filter(both).count();
        assert!((25..65).contains(&apart), "{apart}");
        for own in drawn.iter().flatten() {
            assert_eq!((own.at_s, own.for_s), (fault.at_s, fault.for_s));
            assert_eq!(
                own.complaints(&[("amr-1", vec![]), ("amr-2", vec![])]),
                [""; 0]
            );
        }
        let none = ScriptedFault {
            what: ScriptedKind::SlowDisk,
            by_s: Some(0.1),
            ..fault
        };
        assert!(
            (0..50).all(|seed| splits(&scenario, seed, std::slice::from_ref(&none)).is_empty())
        );
    }
}
