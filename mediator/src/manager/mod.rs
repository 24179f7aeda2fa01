//! The area manager: protocol 1 with every robot, for every area, and protocol 2 with the robots of coordinations.
//!
//! * `sessions`: who speaks for a robot, and whether it is heard;
//! * `areas`: who may be where;
//! * `coordinations`: which nets run, and what they keep for whom;
//! * `peers`: whether robots follow another mediator, and this one stands by;
//! * [`Manager`] hands every report to these, in this order, and then serves the areas that have changed.
//!
//! After a start nothing is granted until every robot of the site has said where it stands, or an operator that it is absent; what
//! robots may have been granted by other mediators is theirs to say (`takeover`).
//!
//! The manager is pure: the same reports at the same times give the same entries and messages. After every call, write
//! [`Manager::entries`] to the journal, then send what [`Manager::next_message`] gives.

mod alarm;
mod areas;
mod circle;
mod coordinations;
mod effects;
mod error;
mod lanes;
mod message;
mod names;
mod peers;
mod routing;
mod seconds;
mod sessions;
mod stalls;
mod status;
mod takeover;
mod view;

pub use alarm::{Alarm, BadReport};
pub use coordinations::CoordinationStatus;
pub use effects::Counters;
pub use error::{
    AbsentError, ClearError, CloseError, EndError, NotRunning, RestoreError, StandsBy, UnknownArea,
    UnknownRobot,
};
pub use lanes::Inside;
pub(crate) use names::second_of;
pub use routing::Manager;
pub use sessions::Factsheet;
pub use stalls::Precedence;
pub use status::{AreaStatus, RobotStatus, Status};
pub use takeover::Cleared;
