//! Levels of protocols, between messages and [`coordination::protocol`].

use crate::wire;
use coordination::protocol::Level;

/// In a message the place says which protocol a level is of, so its number is always this one.
pub const PROTOCOL_ID: u16 = 0;

/// A level in a message that cannot be one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum LevelError {
    /// The message leaves it out.
    #[error("level is missing")]
    Missing,
    /// A number is larger than any protocol has.
    #[error("level has {what} {found}, expected at most {max}", max = u16::MAX)]
    TooLarge { what: &'static str, found: u32 },
}

/// Puts a level into a message.
#[must_use]
pub fn encode(level: Level) -> wire::Level {
    wire::Level {
        run: level.run,
        path: level.path.into(),
        progress: level.progress.into(),
        after_abort: level.after_abort,
    }
}

/// Takes a level out of a message; whether its protocol has such a level is seen when it is merged.
///
/// # Errors
/// [`LevelError`] when it is missing or its numbers are too large.
pub fn decode(level: Option<&wire::Level>) -> Result<Level, LevelError> {
    let level = level.ok_or(LevelError::Missing)?;
    let small =
        |what, found| u16::try_from(found).map_err(|_| LevelError::TooLarge { what, found });
    Ok(Level {
        protocol: PROTOCOL_ID,
        run: level.run,
        path: small("path", level.path)?,
        progress: small("progress", level.progress)?,
        after_abort: level.after_abort,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_survives_the_message() {
        let level = Level {
            protocol: PROTOCOL_ID,
            run: u32::MAX,
            path: 1,
            progress: u16::MAX,
            after_abort: true,
        };
        assert_eq!(decode(Some(&encode(level))), Ok(level));
    }

    #[test]
    fn what_no_level_has_is_refused() {
        assert_eq!(decode(None), Err(LevelError::Missing));
        let level = wire::Level {
            progress: 70_000,
            ..wire::Level::default()
        };
        let error = decode(Some(&level)).expect_err("too large");
        assert_eq!(
            error.to_string(),
            "level has progress 70000, expected at most 65535"
        );
    }
}
