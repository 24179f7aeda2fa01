//! `[roles.<role>]` and `[coordinations.<id>]`

use std::collections::BTreeMap;

use crate::quantity::{Count, POSITION, Quantity};
use crate::reader::Section;
use crate::site::{
    CastConfig, CoordinationConfig, FlagMeaning, PreemptConfig, RoleConfig, SituationConfig,
    YieldConfig,
};

const PATIENCE: Quantity = Quantity::new("a time", "s").above(0.0).at_most(3600.0);
const AREA: &str = "an area's id";
const STATE: &str = "the name of a state";

pub(super) fn role(id: &str, s: &Section<'_>) -> (String, RoleConfig) {
    let priority = s.integer_or("priority", Count::new("a priority", 0, 1000), 0);
    (id.to_owned(), RoleConfig { priority })
}

pub(super) fn read(id: &str, s: &Section<'_>) -> (String, CoordinationConfig) {
    let coordination = CoordinationConfig {
        net: s.text("net", "the name of a net"),
        alarm_after_s: s.number_or("alarm_after_s", PATIENCE, 30.0),
        situations: s.section(
            "situations",
            "sections [coordinations.<id>.situations.<situation>.<net role>]",
            |s| {
                s.each(|situation, s| SituationConfig {
                    situation: situation.to_owned(),
                    roles: map(s.each(cast)),
                })
            },
        ),
        flags: s.section_or_defaults("flags", |s| {
            map(s.each(|role, s| (role.to_owned(), map(s.each(meaning)))))
        }),
        preempt: s.has("preempt").then(|| {
            s.section("preempt", "a table", |s| PreemptConfig {
                after_s: s.number("after_s", PATIENCE),
                situation: s.text_if("situation", "a situation of the net"),
                yields: map(s.section(
                    "yields",
                    "sections [coordinations.<id>.preempt.yields.<net role>]",
                    |s| s.each(yields),
                )),
            })
        }),
    };
    (id.to_owned(), coordination)
}

fn cast(role: &str, s: &Section<'_>) -> (String, CastConfig) {
    let cast = CastConfig {
        robot: s.text_if("robot", "a robot's id, as in [robots.<id>]"),
        role: s.text_if("role", "a role of this site, as in [fsm.<role>]"),
        holds: s.texts("holds", AREA),
        stands_in: s.texts("stands_in", AREA),
        without: s.texts("without", AREA),
        asks: s.texts("asks", AREA),
        states: s.texts("states", STATE),
        within: s.has("within").then(|| s.rect("within", POSITION)),
    };
    (role.to_owned(), cast)
}

fn meaning(flag: &str, s: &Section<'_>) -> (String, FlagMeaning) {
    let meaning = FlagMeaning {
        event: s.text_if("event", "an event of the robot's state machine"),
        on_output: s.text_if("on_output", "an output of the robot's state machine"),
    };
    (flag.to_owned(), meaning)
}

fn yields(role: &str, s: &Section<'_>) -> (String, YieldConfig) {
    let yields = YieldConfig {
        event: s.text("event", "an event of the robot's state machine"),
        states: s.texts("states", STATE),
        enters: s.texts("enters", AREA),
    };
    (role.to_owned(), yields)
}

fn map<T>(entries: Vec<(String, T)>) -> BTreeMap<String, T> {
    entries.into_iter().collect()
}
