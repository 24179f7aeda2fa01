//! What a robot file says: the robot's hardware, limits, threads and gains.

mod drive;
mod fieldbus;
mod fleet;
mod lidar;
mod navigation;
mod teleop;
mod tubes;
mod watchdog;

pub use drive::{Control, Drive, DriveLimits, TricycleGeometry};
pub use fieldbus::{Ethercat, Link};
pub use fleet::Fleet;
pub use lidar::{
    BIT_RATES, BitRate, Lidar, URG_04LX_HZ, URG_04LX_STEPS, check_mount, scan_bit_s, scan_bytes,
};
pub use navigation::Navigation;
pub use teleop::Teleop;
pub use tubes::{AdaptPolicy, DetourPolicy, Horizon, MovingPolicy, Tubes};
pub use watchdog::Watchdog;

use crate::geometry::Footprint;
use crate::keys::{Count, Id, Map, Need, Quantity, Table, TableOrDefaults, Text, Word};
use crate::threads::ThreadConfig;
use crate::{section, words};

pub(crate) const LENGTH: Quantity = Quantity::new("a length", "m").above(0.0).at_most(5.0);
pub(crate) const ACCELERATION: Quantity = Quantity::new("an acceleration", "m/s²")
    .above(0.0)
    .at_most(10.0);
pub(crate) const GAIN: Quantity = Quantity::new("a gain", "").above(0.0).at_most(1000.0);
pub(crate) const DURATION: Quantity = Quantity::new("a duration", "s").above(0.0).at_most(60.0);
pub(crate) const TIMEOUT_MS: Count = Count::new("a time in ms", 1, 10_000);

words! {
    /// What a robot file conforms to: the keys that `config/KEYS.md` lists, their units and what they mean. It changes when a file
    /// of before would mean something else.
    pub enum RobotMetamodel {
        /// The first.
        V1 "urn:kelo-onboard:robot:1",
    }
}

section! {
    /// A robot file says what one robot is made of.
    pub struct Robot {
        /// What the file conforms to; another one is refused.
        pub metamodel: RobotMetamodel as Word => RobotMetamodel::V1,
        /// Who it is.
        pub identity: Identity as Table("a section [identity]"),
        /// The floor that it covers.
        pub footprint: Footprint as Table("a section [footprint]"),
        /// Its wheel unit, and its limits of motion.
        pub drive: Drive as Table("a section [drive]"),
        /// How the wheel unit is reached.
        pub ethercat: Ethercat as Table("a section [ethercat]"),
        /// Its range sensor.
        pub lidar: Lidar as Table("a section [lidar]"),
        /// Which activity runs where, and when.
        pub threads: Vec<ThreadConfig> as Map("sections [threads.<name>]", Need::Required),
        /// Gains of the motion thread.
        pub control: Control as TableOrDefaults,
        /// Gains and limits of navigation.
        pub navigation: Navigation as TableOrDefaults,
        /// The motion tubes.
        pub tubes: Tubes as Table("a section [tubes]"),
        /// How a person drives it by hand.
        pub teleop: Teleop as TableOrDefaults,
        /// How it meets the rest of the fleet.
        pub fleet: Fleet as TableOrDefaults,
        /// Who restarts its computer when the program hangs.
        pub watchdog: Watchdog as TableOrDefaults,
    }
}

section! {
    /// Who the robot is.
    pub struct Identity {
        /// Unique name in the fleet; also names shared memory and network keys.
        pub id: String as Id("the robot's unique name"),
        /// What kind of robot this is, for people.
        pub model: String as Text("a description") => "unknown".to_owned(),
        /// Who made it, for people.
        pub manufacturer: String as Text("a name") => "unknown".to_owned(),
    }
}
