//! Priorities, and when robots are coordinated.

use std::collections::BTreeMap;

use crate::geometry::Rect;
use crate::keys::{
    Corners, Count, Each, Map, Name, Need, Optional, POSITION, Quantity, Table, Text, Texts,
};
use crate::section;

const PATIENCE: Quantity = Quantity::new("a time", "s").above(0.0).at_most(3600.0);
const AREA: &str = "an area's id";
const STATE: &str = "the name of a state";

section! {
    /// What the mediator knows of robots in a role.
    #[derive(Eq)]
    pub struct RoleConfig {
        /// Who goes first: the larger one.
        pub priority: u32 as Count::new("a priority", 0, 1000) => 0,
        /// A request of such a robot goes by one priority more each time that so many later ones went first; 0: it may wait for ever.
        pub ages_after: u32 as Count::new("a number of requests", 0, 1000) => 0,
    }
}

section! {
    /// When a net is started, and what its flags mean for the robots of this site.
    pub struct CoordinationConfig {
        /// The net's name: `nets/<net>.toml` beside the folder of the site file.
        pub net: String as Text("the name of a net"),
        /// An alarm is raised when nothing has gone on for this long.
        pub alarm_after_s: f64 as PATIENCE => 30.0,
        /// By situation of the net: which robot plays which role. The first that fits is taken.
        pub situations: Vec<SituationConfig> as Map(
            "sections [coordinations.<id>.situations.<situation>.<net role>]",
            Need::Required,
        ),
        /// By role of the net, then by flag.
        pub flags: BTreeMap<String, BTreeMap<String, FlagMeaning>> as Map("a table", Need::Optional),
        /// What is done when nothing has gone on for longer.
        pub preempt: Option<PreemptConfig> as Optional(Table("a table")),
    }
}

section! {
    /// A situation of the net, and who plays its roles.
    pub struct SituationConfig {
        /// The net's situation.
        pub situation: String as Name,
        /// By role of the net.
        pub roles: BTreeMap<String, CastConfig> as Each("<net role>"),
    }
}

section! {
    /// Which robot fits a role of a net: one for which all of this is true.
    #[derive(Default)]
    pub struct CastConfig {
        /// It is this robot.
        pub robot: Option<String> as Optional(Text("a robot's id, as in [robots.<id>]")),
        /// It has this role on the site.
        pub role: Option<String> as Optional(Text("a role of this site, as in [fsm.<role>]")),
        /// It has these areas, by a grant.
        pub holds: Vec<String> as Texts(AREA),
        /// It is in these areas, whole or in part.
        pub stands_in: Vec<String> as Texts(AREA),
        /// It neither has nor is in any of these areas.
        pub without: Vec<String> as Texts(AREA),
        /// It waits for these areas.
        pub asks: Vec<String> as Texts(AREA),
        /// Its state machine is in one of these states; empty: in any.
        pub states: Vec<String> as Texts(STATE),
        /// Its `base_link` is there.
        pub within: Option<Rect> as Optional(Corners(POSITION)),
    }
}

section! {
    /// What a flag of a net means for a robot.
    #[derive(Default, Eq)]
    pub struct FlagMeaning {
        /// A flag of the mediator: this event is posted to the robot's state machine.
        pub event: Option<String> as Optional(Text("an event of the robot's state machine")),
        /// A flag of the robot: it is set when its state machine fires this output.
        pub on_output: Option<String> as Optional(Text("an output of the robot's state machine")),
    }
}

section! {
    /// What is done when nothing goes on.
    pub struct PreemptConfig {
        /// When nothing has gone on for this long.
        pub after_s: f64 as PATIENCE,
        /// From which situation of the net it begins again when all have yielded; left out: all are released.
        pub situation: Option<String> as Optional(Text("a situation of the net")),
        /// By role of the net.
        pub yields: BTreeMap<String, YieldConfig> as Map(
            "sections [coordinations.<id>.preempt.yields.<net role>]",
            Need::Required,
        ),
    }
}

section! {
    /// How a robot gets out of the way.
    pub struct YieldConfig {
        /// Posted to its state machine.
        pub event: String as Text("an event of the robot's state machine"),
        /// States in which it is out of the way. At least one.
        pub states: Vec<String> as Texts(STATE),
        /// Areas that it needs for that; they are kept for it.
        pub enters: Vec<String> as Texts(AREA),
    }
}
