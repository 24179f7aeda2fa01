//! All flags of an activity, by number.

use alloc::boxed::Box;
use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::vec;
use alloc::vec::Vec;

use thiserror::Error;

use super::condition::{Change, Edge, Flag, Monitor};
use crate::event::{EventId, EventTable, TooManyEvents};

/// What is wrong with a [`FlagsModel`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum FlagsError {
    /// A flag or an event has an empty name.
    #[error("flags of `{owner}`: {what} has no name")]
    EmptyName { owner: String, what: &'static str },
    /// Two flags have the same name.
    #[error("flags of `{owner}`: two are called `{flag}`")]
    Duplicate { owner: String, flag: String },
    /// A monitor is on a flag that does not exist.
    #[error(
        "flags of `{owner}`: the monitor that fires `{event}` is on `{flag}`; there are: {known}"
    )]
    UnknownFlag {
        owner: String,
        event: String,
        flag: String,
        known: String,
    },
    /// More flags or monitors than fit.
    #[error("flags of `{owner}`: {found} {what}; at most {limit} fit")]
    TooMany {
        owner: String,
        what: &'static str,
        found: usize,
        limit: usize,
    },
    /// The event table is full.
    #[error("flags of `{owner}`: {reason}")]
    Events {
        owner: String,
        reason: TooManyEvents,
    },
}

/// The number of a flag in the [`Flags`] that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FlagIndex(u16);

impl FlagIndex {
    /// The number as an index into an array with one entry per flag.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// Flags and their monitors in names. Adding never fails; [`compile`](Self::compile) says what is wrong with the whole.
#[derive(Clone, Debug)]
pub struct FlagsModel {
    owner: String,
    flags: Vec<(String, bool)>,
    /// Flag, edge, event.
    monitors: Vec<(String, Edge, String)>,
}

impl FlagsModel {
    /// No flags yet, of the activity `owner`.
    pub fn new(owner: impl Into<String>) -> Self {
        Self {
            owner: owner.into(),
            flags: Vec::new(),
            monitors: Vec::new(),
        }
    }

    /// Adds a flag and what it is at first.
    pub fn flag(&mut self, name: impl Into<String>, is_set: bool) -> &mut Self {
        self.flags.push((name.into(), is_set));
        self
    }

    /// Lets changes of `flag`, which is added elsewhere, fire `event`.
    pub fn monitor(
        &mut self,
        flag: impl Into<String>,
        edge: Edge,
        event: impl Into<String>,
    ) -> &mut Self {
        self.monitors.push((flag.into(), edge, event.into()));
        self
    }

    /// Checks the model and makes the flags, whose events are entered into `events`. Not for real-time threads.
    ///
    /// # Errors
    /// The first thing that is wrong: names, numbers, or a full table of events.
    pub fn compile(&self, events: &mut EventTable) -> Result<Flags, FlagsError> {
        self.check_names()?;
        let mut by_flag: Vec<Vec<Monitor>> = vec![Vec::new(); self.flags.len()];
        let numbers = self.flags.iter().map(|(name, _)| name.as_str()).zip(0..);
        let numbers: BTreeMap<&str, usize> = numbers.collect();
        for (flag, edge, event) in &self.monitors {
            let number = numbers.get(flag.as_str()).ok_or_else(|| {
                let known: Vec<&str> = self.flags.iter().map(|(name, _)| name.as_str()).collect();
                FlagsError::UnknownFlag {
                    owner: self.owner.clone(),
                    event: event.clone(),
                    flag: flag.clone(),
                    known: known.join(", "),
                }
            })?;
            let event = events.intern(event).map_err(|reason| FlagsError::Events {
                owner: self.owner.clone(),
                reason,
            })?;
            by_flag[*number].push(Monitor { edge: *edge, event });
        }
        let mut starts = vec![0];
        starts.extend(by_flag.iter().scan(0, |end, monitors| {
            *end += monitors.len() as u16;
            Some(*end)
        }));
        Ok(Flags {
            names: self
                .flags
                .iter()
                .map(|(name, _)| name.as_str().into())
                .collect(),
            flags: self
                .flags
                .iter()
                .map(|&(_, is_set)| Flag::new(is_set))
                .collect(),
            starts: starts.into(),
            monitors: by_flag.concat().into(),
        })
    }

    fn check_names(&self) -> Result<(), FlagsError> {
        let owner = || self.owner.clone();
        for (what, found) in [
            ("flags", self.flags.len()),
            ("monitors", self.monitors.len()),
        ] {
            if found > Flags::LIMIT {
                return Err(FlagsError::TooMany {
                    owner: owner(),
                    what,
                    found,
                    limit: Flags::LIMIT,
                });
            }
        }
        let mut names: Vec<&String> = self.flags.iter().map(|(name, _)| name).collect();
        names.sort_unstable();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(FlagsError::Duplicate {
                owner: owner(),
                flag: twice[0].clone(),
            });
        }
        let has_empty = |what, is_empty: bool| match is_empty {
            true => Err(FlagsError::EmptyName {
                owner: owner(),
                what,
            }),
            false => Ok(()),
        };
        has_empty("a flag", names.iter().any(|name| name.is_empty()))?;
        has_empty(
            "an event",
            self.monitors.iter().any(|(.., event)| event.is_empty()),
        )
    }
}

/// The flags of one activity with their monitors; see [the module](super).
#[derive(Clone, Debug)]
pub struct Flags {
    names: Box<[Box<str>]>,
    flags: Box<[Flag]>,
    /// Where the monitors of each flag begin, and where all end.
    starts: Box<[u16]>,
    monitors: Box<[Monitor]>,
}

impl Flags {
    /// The most flags, and the most monitors, of one activity.
    pub const LIMIT: usize = 4_096;

    /// The flag called `name`. Searches; meant for start-up.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<FlagIndex> {
        let index = self.names.iter().position(|own| **own == *name)?;
        Some(FlagIndex(index as u16))
    }

    /// Notes whether the condition of a flag holds now. Returns what that changes: nothing for a flag of others. Real time: costs
    /// the same whether it changes or not.
    pub fn set(&mut self, flag: FlagIndex, holds: bool) -> Changed<'_> {
        let index = flag.index();
        let Some(own) = self.flags.get_mut(index) else {
            return Changed {
                change: None,
                monitors: &[],
            };
        };
        let range = usize::from(self.starts[index])..usize::from(self.starts[index + 1]);
        Changed {
            change: own.set(holds),
            monitors: &self.monitors[range],
        }
    }

    /// A flag; nothing for one of others.
    #[must_use]
    pub fn get(&self, flag: FlagIndex) -> Option<&Flag> {
        self.flags.get(flag.index())
    }

    /// All flags with their names, in the model's order.
    pub fn iter(&self) -> impl Iterator<Item = (FlagIndex, &str, &Flag)> {
        let named = self.names.iter().zip(&self.flags).zip(0..);
        named.map(|((name, flag), index)| (FlagIndex(index), &**name, flag))
    }
}

/// What setting a flag changed.
#[derive(Clone, Copy, Debug)]
pub struct Changed<'a> {
    /// Nothing if the flag was so before.
    pub change: Option<Change>,
    monitors: &'a [Monitor],
}

impl Changed<'_> {
    /// The events of the monitors that tell of the change, in the model's order. Real time.
    pub fn events(&self) -> impl Iterator<Item = EventId> {
        let told = |change| {
            self.monitors
                .iter()
                .filter_map(move |each| each.event_of(change))
        };
        self.change.into_iter().flat_map(told)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn error(model: &FlagsModel) -> String {
        model
            .compile(&mut EventTable::new())
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn a_wrong_model_is_refused_with_its_reason() {
        let model = || {
            let mut model = FlagsModel::new("lidar");
            model.flag("near", false).flag("far", true);
            model
        };
        assert_eq!(
            error(model().flag("near", true)),
            "flags of `lidar`: two are called `near`"
        );
        assert_eq!(
            error(model().flag("", true)),
            "flags of `lidar`: a flag has no name"
        );
        assert_eq!(
            error(model().monitor("near", Edge::Rise, "")),
            "flags of `lidar`: an event has no name"
        );
        assert_eq!(
            error(model().monitor("nea", Edge::Rise, "stop")),
            "flags of `lidar`: the monitor that fires `stop` is on `nea`; there are: near, far"
        );
        let mut many = FlagsModel::new("lidar");
        for number in 0..=Flags::LIMIT {
            many.flag(number.to_string(), false);
        }
        assert_eq!(
            error(&many),
            "flags of `lidar`: 4097 flags; at most 4096 fit"
        );
    }

    #[test]
    fn flags_of_others_are_left_alone() {
        let mut model = FlagsModel::new("a");
        model.flag("one", false);
        let mut flags = model.compile(&mut EventTable::new()).unwrap();
        let foreign = FlagIndex(1);
        assert_eq!(flags.set(foreign, true).change, None);
        assert_eq!(flags.get(foreign), None);
        assert_eq!(flags.find("two"), None);
    }

    proptest! {
        /// Events and counts are those of the changes in what was set.
        #[test]
        fn events_are_the_changes(
            initial in proptest::collection::vec(any::<bool>(), 1..6),
            monitors in proptest::collection::vec((0usize..6, 0usize..3), 0..12),
            sets in proptest::collection::vec((0usize..6, any::<bool>()), 0..80),
        ) {
            let mut model = FlagsModel::new("random");
            for (number, &is_set) in initial.iter().enumerate() {
                model.flag(number.to_string(), is_set);
            }
            let edges = [Edge::Rise, Edge::Fall, Edge::Either];
            let on = |number: usize| number % initial.len();
            for (number, &(flag, edge)) in monitors.iter().enumerate() {
                model.monitor(on(flag).to_string(), edges[edge], format!("e{number}"));
            }
            let mut events = EventTable::new();
            let mut flags = model.compile(&mut events).unwrap();
            let mut values = initial.clone();
            let mut changes = vec![[0, 0]; initial.len()];
            for (flag, holds) in sets {
                let flag = on(flag);
                let changed = flags.set(flags.find(&flag.to_string()).unwrap(), holds);
                let expected = (values[flag] != holds).then_some(if holds { Change::Rise } else { Change::Fall });
                prop_assert_eq!(changed.change, expected);
                let told = monitors.iter().enumerate().filter(|&(_, &(of, edge))| {
                    on(of) == flag && expected.is_some() && (edge == 2 || holds == (edge == 0))
                });
                let told: Vec<_> = told.map(|(number, _)| events.id(&format!("e{number}")).unwrap()).collect();
                prop_assert_eq!(changed.events().collect::<Vec<_>>(), told);
                changes[flag][usize::from(holds)] += u64::from(expected.is_some());
                values[flag] = holds;
            }
            for (flag, _, state) in flags.iter() {
                let [falls, rises] = changes[flag.index()];
                prop_assert_eq!((state.is_set(), state.rises(), state.falls()), (values[flag.index()], rises, falls));
            }
        }
    }
}
