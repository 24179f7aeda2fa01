//! Whether fences of an area grow.

use std::collections::BTreeMap;

use crate::network::observations::Owning;
use crate::scenario::Scenario;

/// Messages of two senders may be heard in the wrong order, and a lost one is repeated after 0.2 s.
const ORDER_NS: u64 = 300_000_000;

/// Grants whose fence should be larger, as robot, time, and a sentence.
///
/// Each journal counts fences of its own. Of one area and journal no two robots get the same, and a grant that was asked for
/// after another one was heard has a larger one than that. Those under way at the same time may be heard in any order. Where an older copy
/// of a journal is in use nothing is asked, nor of what is first heard of when it is over: a robot that is registered anew says so of what
/// an earlier journal gave it.
#[must_use]
pub fn fences_not_grown(scenario: &Scenario, ownings: &[Owning]) -> Vec<(String, u64, String)> {
    if scenario.uses_older_journal() {
        return Vec::new();
    }
    let mut by_area: BTreeMap<_, Vec<&Owning>> = BTreeMap::new();
    let held = |own: &&Owning| own.released_ns != Some(own.granted_ns);
    for own in ownings.iter().filter(held) {
        let key = (own.area.as_str(), own.journal);
        by_area.entry(key).or_default().push(own);
    }
    let mut found = Vec::new();
    for own in by_area.values() {
        for new in own {
            let earlier = { own.iter() }.find(|old| {
                let twice = old.fence == new.fence && old.robot != new.robot;
                twice && old.granted_ns < new.granted_ns
                    || asked_after(new, old) && new.fence <= old.fence
            });
            if let Some(old) = earlier {
                let detail = format!(
                    "area {}: {} is granted it with fence {}, after {} with fence {}",
                    new.area, new.robot, new.fence, old.robot, old.fence
                );
                found.push((new.robot.clone(), new.granted_ns, detail));
            }
        }
    }
    found
}

/// Whether `new` was asked for when `old` had been heard. A robot that is told anew what it has, has not asked for it.
fn asked_after(new: &Owning, old: &Owning) -> bool {
    let told_anew = new.robot == old.robot && new.fence == old.fence;
    let asked_ns = { new.requested_ns }.filter(|asked_ns| *asked_ns < new.granted_ns && !told_anew);
    asked_ns.is_some_and(|asked_ns| asked_ns > old.granted_ns.saturating_add(ORDER_NS))
}
