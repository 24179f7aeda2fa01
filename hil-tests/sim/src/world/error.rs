//! Why a world cannot be built or changed.

/// Why a world cannot be built or changed as asked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what each field is")]
pub enum WorldError {
    /// A robot's model makes no sense.
    #[error("robot \"{id}\": {reason}")]
    Robot { id: String, reason: String },
    /// An obstacle makes no sense.
    #[error("obstacle: {0}")]
    Obstacle(String),
    /// A walker makes no sense.
    #[error("walker: {0}")]
    Walker(String),
    /// There is no robot of that name.
    #[error("no robot \"{id}\" in this world; it has: {known}")]
    UnknownRobot { id: String, known: String },
}
