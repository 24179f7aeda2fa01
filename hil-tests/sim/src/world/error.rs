//! Why a world cannot be built or changed.

/// Why a world cannot be built or changed as asked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WorldError {
    /// A robot's model makes no sense.
    #[error("robot \"{id}\": {reason}")]
    Robot {
        /// Its name.
        id: String,
        /// What was expected and found.
        reason: String,
    },
    /// An obstacle makes no sense.
    #[error("obstacle: {0}")]
    Obstacle(String),
    /// A walker makes no sense.
    #[error("walker: {0}")]
    Walker(String),
    /// There is no robot of that name.
    #[error("no robot \"{id}\" in this world; it has: {known}")]
    UnknownRobot {
        /// The name asked for.
        id: String,
        /// The names there are.
        known: String,
    },
}
