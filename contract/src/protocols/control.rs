//! Protocol 2: the mediator acquires and releases the discrete control of a robot.

use std::collections::BTreeMap;

use coordination::protocol::{ModelError, Protocol};

use super::model;
use super::names::{ACQUIRE, ACQUIRED, MEDIATOR, RELEASE, RELEASED, ROBOT};

/// Protocol 2 of a coordination without alternatives: acquire, acquired, then `steps` (a flag, and whether it is the
/// mediator's), then release and released.
///
/// # Errors
/// [`ControlError`] when a flag is empty, is listed twice, or has the name of one of those four.
pub fn control<'a>(
    steps: impl IntoIterator<Item = (&'a str, bool)>,
) -> Result<Protocol, ControlError> {
    let mut flags = vec![(ACQUIRE, true), (ACQUIRED, false)];
    flags.extend(steps);
    flags.extend([(RELEASE, true), (RELEASED, false)]);
    control_paths(&flags, &[])
}

/// Protocol 2 as a message gives it: flags, each with whether it is the mediator's, and paths of flags by number. No path
/// means one of all flags in their order.
///
/// # Errors
/// [`ControlError`] when flags or paths make no protocol.
pub fn control_paths(
    flags: &[(&str, bool)],
    paths: &[Vec<usize>],
) -> Result<Protocol, ControlError> {
    let all = [(0..flags.len()).collect()];
    let paths = if paths.is_empty() { &all } else { paths };
    // Paths that begin alike share a position; each position is an array of one flag.
    let mut begins: BTreeMap<&[usize], usize> = BTreeMap::new();
    let mut model = model::model("control");
    for (number, path) in paths.iter().enumerate() {
        for end in 1..=path.len() {
            let flag = path[end - 1];
            let &(name, by_mediator) = flags.get(flag).ok_or(ControlError::NoSuchFlag {
                path: number,
                found: flag,
                flags: flags.len(),
            })?;
            if begins.contains_key(&path[..end]) {
                continue;
            }
            let array = begins.len().to_string();
            let party = if by_mediator { MEDIATOR } else { ROBOT };
            model.array(&array, &[(name, party)]);
            match begins.get(&path[..end - 1]) {
                Some(before) => model.follow(before.to_string(), &array),
                None => model.start(&array),
            };
            begins.insert(&path[..end], begins.len());
        }
    }
    let protocol = model.compile()?;
    // Both sides must number the paths alike.
    for (number, path) in paths.iter().enumerate() {
        let end = u16::try_from(path.len()).ok();
        let end = end.and_then(|end| protocol.position(number.try_into().ok()?, end));
        let same = end.is_some_and(|end| {
            protocol.is_end(end)
                && path.iter().map(|&flag| flags[flag].0).eq(protocol
                    .set_flags(end)
                    .map(|(flag, _)| protocol.flag_name(flag)))
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
        found: usize,
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
