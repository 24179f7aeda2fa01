//! When robots said something, and when the mediator answered.

use std::collections::BTreeMap;

use contract::wire::{Access, Control, Level, MediatorReport};
use sim::rt::monotonic_ns;

use super::robot::flags;
use crate::bench::samples::Sample;

/// A robot, and a flag of its protocol.
type Flag = (&'static str, &'static str);

/// Each command of the net, and the flags that it waits for.
const COMMANDS: [(&str, &str, &[Flag]); 7] = [
    ("fast", "slow", &[("fast", "acquired")]),
    ("slow", "e5", &[("slow", "acquired")]),
    ("fast", "e1", &[("fast", "slowed"), ("slow", "done5")]),
    ("fast", "e2", &[("fast", "done1")]),
    ("fast", "release", &[("fast", "done2")]),
    ("slow", "e1", &[("fast", "done2")]),
    ("slow", "release", &[("slow", "done1")]),
];
/// Areas that are not free when they are asked for: somebody stands there.
const TAKEN: [&str; 2] = ["1", "5"];

/// All times are nanoseconds of the monotonic clock.
#[derive(Default)]
pub(super) struct Clocks {
    /// By robot and area: when the present request was sent.
    asked: BTreeMap<(String, String), (Level, u64)>,
    /// By robot and flag: when it was set in the present coordination.
    set: BTreeMap<(String, String), (u64, u64)>,
    /// By robot and flag: in which coordination the command came.
    told: BTreeMap<(String, String), u64>,
    /// From requests to grants.
    pub(super) grants: Vec<Sample>,
    /// From flags to commands.
    pub(super) commands: Vec<Sample>,
}

impl Clocks {
    /// Just before a report is sent.
    pub(super) fn send(
        &mut self,
        id: &str,
        access: &[Access],
        control: Option<&Control>,
        meaning: Option<&Control>,
    ) {
        let now_ns = monotonic_ns();
        for own in access {
            let Some(level) = own.level.filter(|level| level.progress == 1) else {
                continue;
            };
            if TAKEN.contains(&own.area.as_str()) {
                continue;
            }
            let place = (id.to_owned(), own.area.clone());
            let known = self.asked.get(&place).is_some_and(|asked| asked.0 == level);
            if !known {
                self.asked.insert(place, (level, now_ns));
            }
        }
        if let (Some(own), Some(meaning)) = (control, meaning)
            && own.coordination == meaning.coordination
        {
            for flag in flags(meaning, own.level.as_ref()) {
                let set = self.set.entry((id.to_owned(), flag)).or_insert((0, now_ns));
                if set.0 != own.coordination {
                    *set = (own.coordination, now_ns);
                }
            }
        }
    }

    /// When a message has come.
    pub(super) fn receive(&mut self, at_ns: u64, message: &MediatorReport) {
        let id = &message.robot_id;
        for grant in &message.access {
            let place = (id.clone(), grant.area.clone());
            if let Some((level, asked_ns)) = self.asked.get(&place)
                && let Some(now) = grant.level
                && now.run == level.run
                && now.progress >= 2
            {
                self.grants.push(Sample::from_to(*asked_ns, at_ns));
                self.asked.remove(&place);
            }
        }
        let Some(control) = &message.control else {
            return;
        };
        let number = control.coordination;
        for flag in flags(control, control.level.as_ref()) {
            let Some((_, _, enablers)) = COMMANDS.iter().find(|own| own.0 == id && own.1 == flag)
            else {
                continue;
            };
            if self.told.insert((id.clone(), flag), number) == Some(number) {
                continue;
            }
            let set = enablers.iter().map(|(robot, flag)| {
                let set = self.set.get(&((*robot).to_owned(), (*flag).to_owned()));
                set.filter(|set| set.0 == number).map(|set| set.1)
            });
            if let Some(set) = set.collect::<Option<Vec<u64>>>()
                && let Some(last_ns) = set.into_iter().max()
            {
                self.commands.push(Sample::from_to(last_ns, at_ns));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use contract::wire::AccessGrant;

    use super::*;

    #[test]
    fn a_grant_counts_from_its_request_and_once() {
        let mut clocks = Clocks::default();
        let level = |progress| Level {
            run: 4,
            progress,
            ..Level::default()
        };
        let access = |area: &str, progress| Access {
            area: area.to_owned(),
            level: Some(level(progress)),
            ..Access::default()
        };
        let before_ns = monotonic_ns();
        clocks.send("fast", &[access("2", 1), access("1", 1)], None, None);
        // Said again, which is no new request.
        clocks.send("fast", &[access("2", 1)], None, None);
        let after_ns = monotonic_ns();
        let message = MediatorReport {
            robot_id: "fast".to_owned(),
            ..MediatorReport::default()
        };
        let grant = |area: &str, progress| AccessGrant {
            area: area.to_owned(),
            level: Some(level(progress)),
            ..AccessGrant::default()
        };
        let granted = |access: Vec<AccessGrant>| MediatorReport {
            access,
            ..message.clone()
        };
        clocks.receive(after_ns + 100, &granted(vec![grant("2", 1)]));
        assert!(clocks.grants.is_empty());
        for _ in 0..2 {
            let both = vec![grant("2", 2), grant("1", 2)];
            clocks.receive(after_ns + 200, &granted(both));
        }
        let [grant] = clocks.grants[..] else {
            panic!("{:?}", clocks.grants)
        };
        let most_ns = (after_ns + 200 - before_ns) as f64;
        assert!((200.0..=most_ns).contains(&grant.value), "{grant:?}");
    }
}
