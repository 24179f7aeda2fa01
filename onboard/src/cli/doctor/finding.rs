//! What was found about one thing of the computer.

use std::fmt;

use serde::Serialize;

/// How good it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// As it should be.
    Good,
    /// It cannot be seen from here.
    Unknown,
    /// The robot drives; its threads may be late now and then.
    Weak,
    /// The robot does not start, or stops while it drives.
    Bad,
}

impl Verdict {
    fn word(self) -> &'static str {
        match self {
            Self::Good => "ok",
            Self::Unknown => "?",
            Self::Weak => "weak",
            Self::Bad => "bad",
        }
    }
}

/// What is, what should be, and the command that makes it so.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Which thing.
    pub subject: &'static str,
    /// How good it is.
    pub verdict: Verdict,
    /// What is.
    pub is: String,
    /// What should be; none where it is so. Of what cannot be seen, too.
    pub should: Option<String>,
    /// What makes it so, or shows what is in the way.
    pub command: Option<String>,
}

impl Finding {
    /// It is as it should be.
    pub fn good(subject: &'static str, is: impl Into<String>) -> Self {
        Self {
            subject,
            verdict: Verdict::Good,
            is: is.into(),
            should: None,
            command: None,
        }
    }

    /// It cannot be seen from here.
    pub fn unknown(
        subject: &'static str,
        is: impl Into<String>,
        should: impl Into<String>,
    ) -> Self {
        Self {
            verdict: Verdict::Unknown,
            ..Self::weak(subject, is, should)
        }
    }

    /// It may make threads late.
    pub fn weak(subject: &'static str, is: impl Into<String>, should: impl Into<String>) -> Self {
        Self {
            verdict: Verdict::Weak,
            should: Some(should.into()),
            ..Self::good(subject, is)
        }
    }

    /// It stops the robot.
    pub fn bad(subject: &'static str, is: impl Into<String>, should: impl Into<String>) -> Self {
        Self {
            verdict: Verdict::Bad,
            ..Self::weak(subject, is, should)
        }
    }

    /// With the command that helps.
    pub fn with(self, command: impl Into<String>) -> Self {
        Self {
            command: Some(command.into()),
            ..self
        }
    }
}

/// A word of a command as a shell takes it.
pub fn quoted(word: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_./=:,".contains(&byte);
    if !word.is_empty() && word.bytes().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { subject, is, .. } = self;
        write!(f, "{:<5} {subject:<20} {is}", self.verdict.word())?;
        if let Some(should) = &self.should {
            write!(f, "\n{:27}should be: {should}", "")?;
        }
        if let Some(command) = &self.command {
            write!(f, "\n{:27}$ {command}", "")?;
        }
        Ok(())
    }
}
