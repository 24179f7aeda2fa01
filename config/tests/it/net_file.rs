//! The net file: every kind of mistake is named precisely, and whatever a file holds, reading it
//! returns.

use crate::common::{Mistake, check, edit, lines, render};
use config::ProblemKind::{
    Duplicate, Inconsistent, MissingKey, OutOfRange, UnknownKey, UnknownReference, WrongType,
};
use config::{ConfigError, NetParty, load_net, parse_net};
use coordination::petri::Binding;
use description::geometry::Pose2;
use proptest::prelude::*;

const T_JUNCTION: &str = include_str!("../../nets/t-junction.toml");
const OVERTAKING: &str = include_str!("../../nets/overtaking.toml");
const DOCKING: &str = include_str!("../../nets/docking.toml");

fn fails(file: &str, text: &str) -> Option<ConfigError> {
    parse_net(file, text).err()
}

#[test]
fn a_file_says_what_its_net_is() {
    let net = load_net("nets/overtaking.toml").unwrap_or_else(|error| panic!("{}", lines(&error)));
    assert_eq!(net.name, "overtaking");
    let roles: Vec<_> = net.roles.iter().map(|role| role.id.as_str()).collect();
    assert_eq!(roles, ["emergency", "normal"]);
    let place = net.place("normal-e5").unwrap();
    assert_eq!(place.binding, Some(Binding::flag("normal", "e5")));
    assert_eq!(place.about, "");
    assert_eq!(
        net.place("normal-in-5").unwrap().about,
        "the normal robot waits in area 5"
    );
    let e5 = net.flag("normal", "e5").unwrap();
    assert_eq!(e5.by, NetParty::Mediator);
    assert_eq!(e5.command.enters, ["5"]);
    assert_eq!(e5.command.speed_limit_m_s, Some(0.2));
    let pose = Pose2 {
        x_m: 4.5,
        y_m: -1.25,
        theta_rad: 0.0,
    };
    assert_eq!(e5.command.stop_pose, Some(pose));
    assert_eq!(net.flag("emergency", "e5"), None);
    assert_eq!(net.flag("nobody", "e5"), None);
    assert_eq!(net.areas().into_iter().collect::<Vec<_>>(), ["1", "2", "5"]);
    let protocol = net.protocol("normal").unwrap();
    assert_eq!(protocol.parties(), ["normal", "mediator"]);
    // Aside first, or from area 5 at once.
    assert_eq!(protocol.paths(), 2);
    let model = net.model("normal-ahead").unwrap();
    assert_eq!(model.check(), []);
    let marked: Vec<_> = model
        .places()
        .filter(|p| p.marked)
        .map(|p| p.name)
        .collect();
    assert_eq!(marked, ["emergency-behind", "normal-in-1"]);
    assert!(net.model("normal-behind").is_none());
}

#[test]
fn what_cannot_happen_in_a_situation_is_left_out_of_its_net() {
    let net = load_net("nets/overtaking.toml").unwrap();
    let names = |situation| -> Vec<String> {
        let model = net.model(situation).unwrap();
        model.transitions().map(|t| t.name.to_owned()).collect()
    };
    let (ahead, aside) = (names("normal-ahead"), names("normal-aside"));
    assert!(ahead.iter().any(|t| t == "send-aside") && !aside.iter().any(|t| t == "send-aside"));
    assert!(aside.iter().any(|t| t == "stay-aside") && !ahead.iter().any(|t| t == "stay-aside"));
    assert!(aside.iter().any(|t| t == "passed"));
    let model = net.model("normal-aside").unwrap();
    assert!(
        model
            .places()
            .all(|place| place.name != "normal-done5" && place.name != "normal-to-5")
    );
}

#[test]
fn roles_and_protocols() {
    let mistakes = [
        Mistake {
            name: "a role with an unknown protocol",
            from: "[roles.west]\nprotocol = \"crossing\"",
            to: "[roles.west]\nprotocol = \"crosing\"",
            kind: UnknownReference,
            key: "roles.west.protocol",
            line: "protocol = \"crosing\"",
            found: "protocol `crosing`, which does not exist",
            expected: "the name of a protocol",
            hint: "did you mean `crossing`?",
        },
        Mistake {
            name: "a flag set by nobody",
            from: "{ robot = \"request\" }",
            to: "{ robt = \"request\" }",
            kind: UnknownKey,
            key: "protocols.crossing.flags[0].robt",
            line: "{ robt",
            found: "unknown key `robt`",
            expected: "a known key in [protocols.crossing.flags[0]]",
            hint: "did you mean `robot`?",
        },
        Mistake {
            name: "an empty flag",
            from: "{ robot = \"request\" }",
            to: "{}",
            kind: MissingKey,
            key: "protocols.crossing.flags[0].robot",
            line: "{},",
            found: "nothing",
            expected: "exactly one of `robot` and `mediator`",
            hint: "",
        },
        Mistake {
            name: "a flag set by both",
            from: "{ robot = \"request\" }",
            to: "{ robot = \"request\", mediator = \"request\" }",
            kind: Inconsistent,
            key: "protocols.crossing.flags[0].mediator",
            line: "{ robot = \"request\", mediator",
            found: "both of them",
            expected: "exactly one of `robot` and `mediator`",
            hint: "",
        },
        Mistake {
            name: "a command with a robot's flag",
            from: "{ robot = \"entered\" }",
            to: "{ robot = \"entered\", enters = [\"Cr\"] }",
            kind: Inconsistent,
            key: "protocols.crossing.flags[2].enters",
            line: "{ robot = \"entered\", enters",
            found: "`enters` with the robot's flag `entered`",
            expected: "commands only with flags of the mediator",
            hint: "",
        },
        Mistake {
            name: "a flag twice in a run",
            from: "{ robot = \"entered\" }",
            to: "{ robot = \"request\" }",
            kind: Inconsistent,
            key: "protocols.crossing",
            line: "[protocols.crossing]",
            found: "protocol `crossing`: flag `request` of array `flags` is already set when the run gets there",
            expected: "flags in an order that both parties can follow to an end",
            hint: "",
        },
        Mistake {
            name: "a keeper who is nobody",
            from: "keeper = \"mediator\"\nflags",
            to: "keeper = \"west\"\nflags",
            kind: OutOfRange,
            key: "protocols.crossing.keeper",
            line: "keeper = \"west\"",
            found: "text \"west\"",
            expected: "`robot` or `mediator`",
            hint: "",
        },
        Mistake {
            name: "no flags",
            from: "[protocols.crossing]\n",
            to: "[protocols.crossing]\nflags = []\n[protocols.other]\n",
            kind: OutOfRange,
            key: "protocols.crossing.flags",
            line: "flags = []",
            found: "an empty array",
            expected: "an array of { robot",
            hint: "",
        },
    ];
    // The last one leaves a protocol over as well.
    check(&mistakes[..7], T_JUNCTION, fails);
    let text = edit(T_JUNCTION, mistakes[7].from, mistakes[7].to);
    let error = fails("some.toml", &text).unwrap();
    let keys: Vec<_> = error.problems().iter().map(|p| p.key.as_str()).collect();
    assert_eq!(
        keys,
        [mistakes[7].key, "protocols.other"],
        "{}",
        lines(&error)
    );
}

#[test]
fn alternatives() {
    let mistakes = [
        Mistake {
            name: "an unknown array",
            from: "then = [\"aside\", \"back\"]",
            to: "then = [\"aside\", \"bakc\"]",
            kind: UnknownReference,
            key: "protocols.giving-way.arrays.take.then[1]",
            line: "then = [\"aside\", \"bakc\"]",
            found: "array `bakc`, which does not exist",
            expected: "the name of an array",
            hint: "there are `take`, `aside` and `back`",
        },
        Mistake {
            name: "an array that follows itself",
            from: "then = [\"aside\", \"back\"]",
            to: "then = [\"aside\", \"take\"]",
            kind: Inconsistent,
            key: "protocols.giving-way.arrays.take",
            line: "[protocols.giving-way.arrays.take]",
            found: "protocol `giving-way`: array `take` would follow itself; a run must end",
            expected: "flags in an order that both parties can follow to an end",
            hint: "",
        },
        Mistake {
            name: "the same alternative twice",
            from: "then = [\"aside\", \"back\"]",
            to: "then = [\"aside\", \"back\", \"aside\"]",
            kind: Duplicate,
            key: "protocols.giving-way.arrays.take.then[2]",
            line: "then = [\"aside\", \"back\", \"aside\"]",
            found: "`aside` a second time",
            expected: "each name once",
            hint: "",
        },
        Mistake {
            name: "two who could choose",
            from: "{ mediator = \"e1\", enters = [\"1\"] },\n    { robot = \"done1\" },\n    { mediator = \"release\" },\n    { robot = \"released\" },\n]\n\n# --",
            to: "{ robot = \"e1\" },\n    { robot = \"done1\" },\n    { mediator = \"release\" },\n    { robot = \"released\" },\n]\n\n# --",
            kind: Inconsistent,
            key: "protocols.giving-way",
            line: "[protocols.giving-way]",
            found: "protocol `giving-way`: array `take` can go on with `aside`, begun by `mediator`, or `back`, begun by `normal`; one party must choose",
            expected: "flags in an order",
            hint: "",
        },
        Mistake {
            name: "a speed in the wrong unit",
            from: "{ mediator = \"slow\", speed_limit_m_s = 0.20 }",
            to: "{ mediator = \"slow\", speed_limit_m_s = 200 }",
            kind: OutOfRange,
            key: "protocols.passing.flags[2].speed_limit_m_s",
            line: "speed_limit_m_s = 200",
            found: "200",
            expected: "a speed above 0 and at most 3 m/s",
            hint: "200 mm/s is 0.2 m/s",
        },
        Mistake {
            name: "half a pose",
            from: "stop_pose = { x_m = 4.5, y_m = -1.25, theta_rad = 0.0 }",
            to: "stop_pose = { x_m = 4.5, y_m = -1.2 }",
            kind: MissingKey,
            key: "protocols.giving-way.arrays.aside.flags[0].stop_pose.theta_rad",
            line: "stop_pose = { x_m = 4.5, y_m = -1.2 }",
            found: "nothing",
            expected: "an angle",
            hint: "",
        },
    ];
    check(&mistakes, OVERTAKING, fails);
}

#[test]
fn places_and_bindings() {
    let mistakes = [
        Mistake {
            name: "a place and a transition of one name",
            from: "west-in = { from = [\"west-enters",
            to: "free = { from = [\"west-enters",
            kind: Duplicate,
            key: "transitions.free",
            line: "free = { from",
            found: "the name `free` a second time",
            expected: "each name for one place or transition",
            hint: "",
        },
        Mistake {
            name: "an unknown role",
            from: "west-asks = \"west.request\"",
            to: "west-asks = \"wets.request\"",
            kind: UnknownReference,
            key: "sources.west-asks",
            line: "west-asks = \"wets.request\"",
            found: "role `wets`, which does not exist",
            expected: "the name of a role",
            hint: "there are `west`, `east` and `south`",
        },
        Mistake {
            name: "an unknown flag",
            from: "west-asks = \"west.request\"",
            to: "west-asks = \"west.requested\"",
            kind: UnknownReference,
            key: "sources.west-asks",
            line: "west-asks = \"west.requested\"",
            found: "flag `requested`, which does not exist",
            expected: "the name of a flag",
            hint: "did you mean `request`?",
        },
        Mistake {
            name: "a source of the mediator's own flag",
            from: "west-asks = \"west.request\"",
            to: "west-asks = \"west.granted\"",
            kind: Inconsistent,
            key: "sources.west-asks",
            line: "west-asks = \"west.granted\"",
            found: "flag `granted` of the mediator",
            expected: "a flag of the robot, which a source waits for",
            hint: "",
        },
        Mistake {
            name: "a sink of the robot's flag",
            from: "west-go = \"west.granted\"",
            to: "west-go = \"west.entered\"",
            kind: Inconsistent,
            key: "sinks.west-go",
            line: "west-go = \"west.entered\"",
            found: "flag `entered` of the robot",
            expected: "a flag of the mediator, which a sink sets",
            hint: "",
        },
        Mistake {
            name: "an abort that nobody can do",
            from: "west-asks = \"west.request\"",
            to: "west-asks = \"west.aborted\"",
            kind: UnknownReference,
            key: "sources.west-asks",
            line: "west-asks = \"west.aborted\"",
            found: "flag `aborted`, which does not exist",
            expected: "the name of a flag",
            hint: "there are `request`, `entered` and `released`",
        },
        Mistake {
            name: "an event with a space",
            from: "west-asks = \"west.request\"",
            to: "west-asks = \"west asks\"",
            kind: OutOfRange,
            key: "sources.west-asks",
            line: "west-asks = \"west asks\"",
            found: "\"west asks\"",
            expected: "\"<role>.<flag>\", or an event's name",
            hint: "",
        },
        Mistake {
            name: "a binding that is no text",
            from: "west-asks = \"west.request\"",
            to: "west-asks = [\"west.request\"]",
            kind: WrongType,
            key: "sources.west-asks",
            line: "west-asks = [",
            found: "an array of 1 value",
            expected: "a flag as \"<role>.<flag>\", or an event's name",
            hint: "",
        },
        Mistake {
            name: "a place that nobody uses",
            from: "free = \"nobody",
            to: "spare = \"for later\"\nfree = \"nobody",
            kind: Inconsistent,
            key: "places.spare",
            line: "spare = ",
            found: "place `spare`, which no transition touches",
            expected: "places that tokens enter and leave",
            hint: "",
        },
        Mistake {
            name: "a place without a meaning",
            from: "free = \"nobody is on the crossing or may come\"",
            to: "free = \"\"",
            kind: OutOfRange,
            key: "places.free",
            line: "free = \"\"",
            found: "text \"\"",
            expected: "what a token in the place means",
            hint: "",
        },
    ];
    check(&mistakes, T_JUNCTION, fails);
}

#[test]
fn arcs_and_sets() {
    let mistakes = [
        Mistake {
            name: "an unknown place",
            from: "from = [\"west-asks\", \"free\"]",
            to: "from = [\"west-asks\", \"fre\"]",
            kind: UnknownReference,
            key: "transitions.let-west-in.from[1]",
            line: "let-west-in = ",
            found: "place `fre`, which does not exist",
            expected: "the name of a place",
            hint: "did you mean `free`?",
        },
        Mistake {
            name: "an arc to a transition",
            from: "to = [\"west-inside\"]",
            to: "to = [\"west-inside\", \"west-out\"]",
            kind: UnknownReference,
            key: "transitions.west-in.to[1]",
            line: "west-in = { from = [\"west-e",
            found: "place `west-out`, which does not exist",
            expected: "the name of a place",
            hint: "",
        },
        Mistake {
            name: "a transition without input",
            from: "{ from = [\"west-enters\", \"west-may-come\"], ",
            to: "{ ",
            kind: OutOfRange,
            key: "transitions.west-in.from",
            line: "west-in = { to = [\"west-inside",
            found: "no places",
            expected: "at least one place",
            hint: "",
        },
        Mistake {
            name: "an arc into a source",
            from: "to = [\"west-inside\"]",
            to: "to = [\"west-inside\", \"west-leaves\"]",
            kind: Inconsistent,
            key: "transitions.west-in.to[1]",
            line: "west-in = { from = [\"west-e",
            found: "the source `west-leaves`",
            expected: "another place: only its flag or event fills it",
            hint: "",
        },
        Mistake {
            name: "an arc out of a sink",
            from: "from = [\"west-enters\", \"west-may-come\"]",
            to: "from = [\"west-enters\", \"west-may-come\", \"west-go\"]",
            kind: Inconsistent,
            key: "transitions.west-in.from[2]",
            line: "west-in = { from = [\"west-e",
            found: "the sink `west-go`",
            expected: "another place: only its consumer empties it",
            hint: "",
        },
        Mistake {
            name: "the same arc twice",
            from: "from = [\"west-asks\", \"free\"]",
            to: "from = [\"west-asks\", \"free\", \"free\"]",
            kind: Duplicate,
            key: "transitions.let-west-in.from[2]",
            line: "let-west-in = ",
            found: "`free` a second time",
            expected: "each name once",
            hint: "",
        },
        Mistake {
            name: "an end with a sink",
            from: "idle = [\"free\"]",
            to: "idle = [\"free\", \"west-go\"]",
            kind: Inconsistent,
            key: "ends.idle[1]",
            line: "idle = ",
            found: "the sink `west-go`",
            expected: "an internal place",
            hint: "",
        },
        Mistake {
            name: "an exclusion of one",
            from: "[ends]",
            to: "lonely = [\"free\"]\n\n[ends]",
            kind: OutOfRange,
            key: "exclusions.lonely",
            line: "lonely = ",
            found: "1 places",
            expected: "at least two places",
            hint: "",
        },
        Mistake {
            name: "a situation with an unknown place",
            from: "marked = [\"free\"]",
            to: "marked = [\"free\", \"west-in\"]",
            kind: UnknownReference,
            key: "situations.all-outside.marked[1]",
            line: "marked = ",
            found: "place `west-in`, which does not exist",
            expected: "the name of a place",
            hint: "",
        },
        Mistake {
            name: "a situation that is no table",
            from: "[situations.all-outside]\nabout = \"no robot is on the crossing\"\nmarked = [\"free\"]",
            to: "[situations]\nall-outside = [\"free\"]",
            kind: WrongType,
            key: "situations.all-outside",
            line: "all-outside = ",
            found: "an array of 1 value",
            expected: "a table",
            hint: "",
        },
    ];
    check(&mistakes, T_JUNCTION, fails);
}

#[test]
fn everything_wrong_is_said_at_once_and_not_twice() {
    let mut text = edit(T_JUNCTION, "[roles.east]", "[roles.mediator]");
    text = edit(&text, "marked = [\"free\"]", "marked = []");
    text = edit(&text, "\nsouth-in = {", "\nsouth_in = { form = [],");
    let error = fails("some.toml", &text).unwrap();
    let keys: Vec<_> = error.problems().iter().map(|p| p.key.as_str()).collect();
    assert_eq!(
        keys,
        [
            "roles.mediator",
            "sources.east-asks",
            "sources.east-enters",
            "sources.east-leaves",
            "sinks.east-go",
            "transitions.south_in.form",
        ],
        "{}",
        lines(&error)
    );
    let empty = fails("some.toml", "").unwrap();
    let keys: Vec<_> = empty.problems().iter().map(|p| p.key.as_str()).collect();
    assert_eq!(
        keys,
        ["name", "roles", "protocols", "transitions", "situations"]
    );
}

#[test]
fn a_situation_in_which_the_net_does_not_compile_is_refused_where_it_stands() {
    // Without the emergency robot, nobody ever takes the tokens that say that area 1 is free.
    let alone = "\n[situations.alone]\nmarked = [\"normal-in-1\"]\n";
    let text = format!("{OVERTAKING}{alone}");
    let error = fails("some.toml", &text).unwrap();
    for problem in error.problems() {
        assert_eq!(problem.key, "situations.alone", "{problem}");
        assert_eq!(
            problem.line,
            Some(crate::common::line_of(&text, "[situations.alone]"))
        );
    }
    assert!(
        lines(&error).contains("place `area-1-free` is never emptied"),
        "{}",
        lines(&error)
    );
}

#[test]
fn huge_files_are_refused_quickly() {
    let many = |line: &dyn Fn(usize) -> String, count: usize| -> String {
        (0..count).map(|number| line(number) + "\n").collect()
    };
    let files = [
        many(&|n| format!("[roles.r{n}]\nprotocol = \"p{n}\""), 20_000),
        format!("[places]\n{}", many(&|n| format!("p{n} = \"x\""), 60_000)),
        format!(
            "[transitions]\n{}",
            many(&|n| format!("t{n} = {{ from = [\"a{n}\"] }}"), 30_000)
        ),
        format!(
            "[transitions.t]\nfrom = [{}]",
            "\"abcdefgh\",".repeat(80_000)
        ),
        format!(
            "[transitions.t]\n{}",
            many(&|n| format!("k{n}k = 1"), 80_000)
        ),
        format!(
            "[protocols.p]\nflags = [{}]",
            "{ robot = \"f\" },".repeat(50_000)
        ),
    ];
    for text in files {
        let start = std::time::Instant::now();
        let error = fails("some.toml", &text).unwrap();
        assert!(!error.problems().is_empty());
        // Far more than it takes, far less than a mistake with squares in it.
        assert!(
            start.elapsed().as_secs() < 20,
            "{} bytes, {}",
            text.len(),
            &text[..40]
        );
    }
}

/// One change to a text.
#[derive(Clone, Debug)]
enum Change {
    Remove(usize),
    Repeat(usize, usize),
    Value(usize, String),
    Insert(usize, String),
    Cut(usize),
}

fn change() -> impl Strategy<Value = Change> {
    let at = 0..10_000_usize;
    let value = prop_oneof![
        "[a-z0-9.\\-]{0,8}".prop_map(|text| format!("\"{text}\"")),
        Just("[]".to_owned()),
        Just("{}".to_owned()),
        Just("[\"free\", \"free\"]".to_owned()),
        Just("{ from = [\"free\"], to = [\"free\"] }".to_owned()),
        any::<f64>().prop_map(|number| format!("{number:?}")),
    ];
    prop_oneof![
        at.clone().prop_map(Change::Remove),
        (at.clone(), at.clone()).prop_map(|(a, b)| Change::Repeat(a, b)),
        (at.clone(), value).prop_map(|(a, text)| Change::Value(a, text)),
        (at.clone(), "[a-z\"'\\[\\]{}=.,# 0-9é\\-]{0,8}")
            .prop_map(|(a, text)| Change::Insert(a, text)),
        at.prop_map(Change::Cut),
    ]
}

fn apply(text: &str, changes: &[Change]) -> String {
    let keep = |line: &&str| !line.starts_with('#') && !line.is_empty();
    let mut lines: Vec<String> = text.lines().filter(keep).map(str::to_owned).collect();
    for change in changes {
        let count = lines.len().max(1);
        if lines.is_empty() {
            lines.push(String::new());
        }
        match change {
            Change::Remove(at) => drop(lines.remove(at % count)),
            Change::Repeat(from, to) => {
                let line = lines[from % count].clone();
                lines.insert(to % count, line);
            }
            Change::Value(at, value) => {
                if let Some((key, _)) = lines[at % count].clone().split_once('=') {
                    lines[at % count] = format!("{key}= {value}");
                }
            }
            Change::Insert(at, text) => {
                let line = &mut lines[at % count];
                let at = line
                    .char_indices()
                    .nth(at / 7 % (line.len() + 1))
                    .map_or(0, |(at, _)| at);
                line.insert_str(at, text);
            }
            Change::Cut(at) => lines.truncate(at % count),
        }
    }
    lines.join("\n")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_mutated_net_file_never_panics(which in 0..3_usize, changes in prop::collection::vec(change(), 1..5)) {
        let text = apply([T_JUNCTION, OVERTAKING, DOCKING][which], &changes);
        match parse_net("some.toml", &text) {
            // What is read compiles, in every situation.
            Ok(net) => {
                for (situation, model) in net.models() {
                    prop_assert_eq!(model.check(), [], "{}", situation);
                }
            }
            Err(error) => {
                prop_assert!(!error.problems().is_empty());
                for problem in error.problems() {
                    prop_assert!(problem.line.is_some(), "{}", problem);
                }
                prop_assert!(!render(&error).is_empty());
            }
        }
    }
}
