//! What the manager knows of its site before any robot speaks.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::time::Duration;

use contract::floor::Floor;

/// No robot reaches farther than this from its `base_link`: areas within this distance of its start count as occupied until it is
/// heard.
pub const LONGEST_REACH_M: f64 = 1.0;

/// A piece of floor that is owned as a whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AreaSetup {
    /// Its semantic id.
    pub id: String,
    /// How many robots it holds.
    pub capacity: u32,
}

/// A robot that may register.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotSetup {
    /// Its semantic id.
    pub id: String,
    /// What it is on this site, such as "normal" or "emergency". Never taken from a message.
    pub role: String,
    /// Who goes first: the larger one.
    pub priority: u32,
    /// Its request goes by one priority more each time that so many later ones went first; 0: never.
    pub ages_after: u32,
    /// Areas that it reaches into at its start pose. Until it is first heard, it is taken to be there.
    pub starts_in: Vec<String>,
}

/// A site.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// The site's name, as the robots' site files say it.
    pub site: String,
    /// All managed areas.
    pub areas: Vec<AreaSetup>,
    /// The same with their places, as robots must know them.
    pub floor: Floor,
    /// All robots of the site.
    pub robots: Vec<RobotSetup>,
    /// A robot that was not heard for longer is silent.
    pub silent_after: Duration,
}

impl Setup {
    /// Checks that all names are unique and known, and that every area holds a robot.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), SetupError> {
        let areas = index("area", self.areas.iter().map(|area| &area.id))?;
        index("robot", self.robots.iter().map(|robot| &robot.id))?;
        if let Some(area) = self.areas.iter().find(|area| area.capacity == 0) {
            return Err(SetupError::NoCapacity(area.id.clone()));
        }
        for robot in &self.robots {
            if let Some(area) = robot
                .starts_in
                .iter()
                .find(|area| !areas.contains_key(*area))
            {
                return Err(SetupError::UnknownStart {
                    robot: robot.id.clone(),
                    area: area.clone(),
                });
            }
        }
        Ok(())
    }
}

/// What is wrong with a setup.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum SetupError {
    /// An id is used twice.
    #[error("two {kind}s have the id `{id}`")]
    Duplicate {
        /// Area or robot.
        kind: &'static str,
        id: String,
    },
    /// An id that cannot be part of a key of the journal.
    #[error("{kind} `{id}`: expected an id that is not empty and has no `/`")]
    Name {
        /// Area or robot.
        kind: &'static str,
        id: String,
    },
    /// A robot starts where no area is.
    #[error("robot `{robot}` starts in area `{area}`, which the site does not have")]
    UnknownStart { robot: String, area: String },
    /// No robot fits into it.
    #[error("area `{0}` has capacity 0, expected at least 1")]
    NoCapacity(String),
}

/// Dense indices by id. All ids are the site file's own, so nobody can make them collide.
pub(crate) type Index = HashMap<String, usize, BuildHasherDefault<Fnv>>;

/// FNV-1a (Fowler, Noll, Vo), which is fast for short names.
#[derive(Clone)]
pub(crate) struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Hasher for Fnv {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

/// Dense indices by id.
pub(crate) fn index<'a>(
    kind: &'static str,
    ids: impl Iterator<Item = &'a String>,
) -> Result<Index, SetupError> {
    let mut index = Index::default();
    for (number, id) in ids.enumerate() {
        if id.is_empty() || id.contains('/') {
            let id = id.clone();
            return Err(SetupError::Name { kind, id });
        }
        if index.insert(id.clone(), number).is_some() {
            let id = id.clone();
            return Err(SetupError::Duplicate { kind, id });
        }
    }
    Ok(index)
}
