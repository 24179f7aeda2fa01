//! Protocol 2: the mediator acquires and releases the discrete control of a robot, which the robot owns.

use std::collections::BTreeMap;

use coordination::acquire_release::{AcquireRelease, By, PatternError};
use coordination::protocol::{ModelError, Protocol};

use super::model;
use super::names::{ACQUIRE, ACQUIRED, MEDIATOR, MEDIATOR_PARTY, RELEASE, RELEASED, ROBOT};
use crate::wire::{ControlFlag, ControlPath};

/// Protocol 2 of a coordination without alternatives: acquire, acquired, then `steps` (a flag, and whether it is the
/// mediator's), then release and released.
///
/// # Errors
/// [`ControlError`] when a flag is empty, is listed twice, or has the name of one of those four.
pub fn control<'a>(
    steps: impl IntoIterator<Item = (&'a str, bool)>,
) -> Result<Protocol, ControlError> {
    let mut model = AcquireRelease::new("control", MEDIATOR, ROBOT);
    model
        .owner_first()
        .keeper(By::User)
        .acquire(ACQUIRE, ACQUIRED);
    for (flag, by_mediator) in steps {
        model.using(flag, if by_mediator { By::User } else { By::Owner });
    }
    model.release(RELEASE).confirm(RELEASED);
    model.protocol().map_err(|error| match error {
        PatternError::Model(error) => ControlError::Model(error),
        error => unreachable!("it acquires and releases: {error}"),
    })
}

fn flag(name: &str, by_mediator: bool) -> ControlFlag {
    ControlFlag {
        name: name.to_owned(),
        by_mediator,
        ..ControlFlag::default()
    }
}

/// Flags and paths of a protocol for a message, without what the flags mean; [`control_paths`] makes the protocol of them.
#[must_use]
pub fn flags_and_paths(protocol: &Protocol) -> (Vec<ControlFlag>, Vec<ControlPath>) {
    let flags = protocol.flags();
    let flags = flags.map(|(_, name, owner)| flag(name, owner == MEDIATOR_PARTY));
    let ends = protocol.positions().filter(|&at| protocol.is_end(at));
    let paths = ends.map(|end| ControlPath {
        flags: { protocol.set_flags(end) }
            .map(|(flag, _)| flag.0.into())
            .collect(),
    });
    (flags.collect(), paths.collect())
}

/// Protocol 2 as a message gives it: paths list flags by number, and no path means one of all flags in their order.
///
/// # Errors
/// [`ControlError`] when flags or paths make no protocol.
pub fn control_paths(
    flags: &[ControlFlag],
    paths: &[ControlPath],
) -> Result<Protocol, ControlError> {
    let all = [ControlPath {
        flags: { 0.. }.take(flags.len()).collect(),
    }];
    let paths = if paths.is_empty() { &all } else { paths };
    // Paths that begin alike share a position; each position is an array of one flag.
    let mut begins: BTreeMap<&[u32], usize> = BTreeMap::new();
    let mut model = model::model("control");
    for (number, ControlPath { flags: path }) in paths.iter().enumerate() {
        for end in 1..=path.len() {
            let found = path[end - 1];
            let flag = flags.get(found as usize).ok_or(ControlError::NoSuchFlag {
                path: number,
                found,
                flags: flags.len(),
            })?;
            if begins.contains_key(&path[..end]) {
                continue;
            }
            let array = begins.len().to_string();
            let party = if flag.by_mediator { MEDIATOR } else { ROBOT };
            model.array(&array, &[(&flag.name, party)]);
            match begins.get(&path[..end - 1]) {
                Some(before) => model.follow(before.to_string(), &array),
                None => model.start(&array),
            };
            begins.insert(&path[..end], begins.len());
        }
    }
    let protocol = model.compile()?;
    // Both sides must number the paths alike.
    for (number, ControlPath { flags: path }) in paths.iter().enumerate() {
        let end = u16::try_from(path.len()).ok();
        let end = end.and_then(|end| protocol.position(number.try_into().ok()?, end));
        let same = end.is_some_and(|end| {
            let names = path.iter().map(|&flag| flags[flag as usize].name.as_str());
            let set = protocol.set_flags(end);
            protocol.is_end(end) && names.eq(set.map(|(flag, _)| protocol.flag_name(flag)))
        });
        if !same {
            return Err(ControlError::Order { path: number });
        }
    }
    Ok(protocol)
}

/// Flags and paths that make no protocol.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum ControlError {
    /// A path names a flag that is not there.
    #[error("path {path} names flag {found}, and there are {flags}, numbered from 0")]
    NoSuchFlag {
        path: usize,
        /// As found.
        found: u32,
        /// How many there are.
        flags: usize,
    },
    /// Paths that begin alike must stand together, each once, and none may be the beginning of another.
    #[error(
        "path {path} is not where it belongs: paths that begin alike stand together, each once"
    )]
    Order { path: usize },
    /// What protocols in general must keep.
    #[error(transparent)]
    Model(#[from] ModelError),
}
