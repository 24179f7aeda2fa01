//! Models, levels and findings go through serde and come back.

#[path = "it/nets/mod.rs"]
mod nets;

use std::sync::Arc;

use coordination::analysis::{Limits, Marking, Properties, check, properties};
use coordination::event::EventTable;
use coordination::fsm::MachineModel;
use coordination::petri::{Binding, NetModel};
use coordination::protocol::{Level, Party, ProtocolModel, Replica, Side};
use nets::gate;
use serde::Serialize;
use serde::de::DeserializeOwned;

fn there_and_back<T: Serialize + DeserializeOwned>(value: &T) -> (String, T) {
    let text = toml::to_string(value).unwrap_or_else(|error| panic!("{error}"));
    let back = toml::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
    (text, back)
}

#[test]
fn a_net_is_the_same() {
    let (mut net, uses) = gate(2);
    net.exclusion("one", &["r0 in", "r1 in"]).allow_endless();
    net.source("tick", Binding::event("tick"));
    net.transition("ticks", &["tick", "free"], &["free"]);
    let (text, back) = there_and_back(&net);
    // Places and transitions are written in the order of their names; from then on nothing changes at all.
    let (again, twice) = there_and_back(&back);
    assert_eq!(text, again);
    assert!(twice.is_same(&back), "{text}");
    let limits = Limits::default();
    let [one, other] = [&net, &back].map(|net| check(net, &uses, &limits).unwrap());
    assert_eq!(one.report(), other.report());
    there_and_back(one.report());
}

#[test]
fn a_net_can_be_written_by_hand_and_is_checked() {
    let text = r#"
        name = "gate"
        places = [
            { name = "free", marked = true },
            { name = "inside" },
            { name = "asked", source = { Event = "ask" } },
            { name = "left", source = { Flag = { protocol = "robot", flag = "released" } } },
        ]
        transitions = [
            { name = "enter", inputs = ["asked", "free"], outputs = ["inside"] },
            { name = "leave", inputs = ["left", "inside"], outputs = ["free"] },
        ]
    "#;
    let net: NetModel = toml::from_str(text).unwrap();
    assert!(net.compile(&mut EventTable::new()).is_ok());
    let read = |text: &str| toml::from_str::<NetModel>(text);
    // What is wrong with the net is the net's to say, what is wrong with the form is not.
    let wrong = read(&text.replace(r#""inside"], outputs"#, r#""outside"], outputs"#)).unwrap();
    assert!(wrong.check()[0].to_string().contains("`outside`"));
    let error = read(&text.replace("inputs", "feeds")).unwrap_err();
    assert!(
        error.to_string().contains("unknown field `feeds`"),
        "{error}"
    );
    let both = text.replace(
        r#"source = { Event = "ask" }"#,
        r#"source = { Event = "ask" }, sink = { Event = "go" }"#,
    );
    let error = read(&both).unwrap_err().to_string();
    assert!(error.contains("place `asked` is a source and a sink; expected one"));
}

#[test]
fn protocols_and_machines_are_the_same() {
    let mut model = ProtocolModel::new("crossing", "robot", "mediator");
    model
        .array("ask", &[("request", "robot")])
        .keeper("mediator");
    model.array("yes", &[("granted", "mediator"), ("released", "robot")]);
    model.array("no", &[("refused", "mediator")]).start("ask");
    model.follow("ask", "yes").follow("ask", "no");
    let (_, back) = there_and_back(&model);
    assert_eq!(back.compile(), model.compile());
    let text = r#"
        name = "gate"
        parties = ["robot", "mediator"]
        arrays = [{ name = "all", entries = [["request", "robot"], ["granted", "mediator"]] }]
    "#;
    let short: ProtocolModel = toml::from_str(text).unwrap();
    assert!(short.check().is_empty());

    let mut model = MachineModel::new("door");
    model.state("closed").state("open").initial("closed");
    model.transition("closed", "push", "open", &["light on"]);
    model.transition("open", "pull", "closed", &[]);
    let (text, back) = there_and_back(&model);
    assert!(text.contains("[[transitions]]"), "{text}");
    let mut events = EventTable::new();
    let mut machine = back.compile(&mut events).unwrap();
    let push = events.id("push").unwrap();
    assert_eq!(machine.step(push).outputs, [events.id("light on").unwrap()]);
}

#[test]
fn a_side_goes_on_from_a_level_that_was_stored() {
    let mut model = ProtocolModel::new("gate", "robot", "mediator");
    model.array("all", &[("request", "robot"), ("granted", "mediator")]);
    let protocol = Arc::new(model.compile().unwrap());
    let mut robot = Replica::new(&protocol, 3, Party::First, 5);
    robot.set(protocol.flag("request").unwrap()).unwrap();
    let (_, level): (_, Level) = there_and_back(&robot.level());
    assert_eq!(level, robot.level());
    assert!(Replica::resume(&protocol, Party::First, level).is_ok());
    let (_, party) = there_and_back(&Parties { own: Party::Second });
    assert_eq!(party.own, Party::Second);
}

#[derive(serde::Serialize, serde::Deserialize)]
struct Parties {
    own: Party,
}

#[test]
fn findings_are_the_same() {
    let (net, uses) = gate(2);
    let asked = [Marking::new(&["r0 in"], &["free"])];
    let limits = Limits::default();
    assert_eq!(there_and_back(&limits).1, limits);
    assert_eq!(there_and_back(&asked[0]).1, asked[0]);
    let found: Properties = properties(&net, &uses, &limits, &asked).unwrap();
    let invariants = coordination::analysis::place_invariants(&net);
    assert_eq!(there_and_back(&invariants).1, invariants);
    assert_eq!(there_and_back(&found).1, found);
}

#[test]
fn a_refusal_can_be_kept() {
    let mut net = NetModel::new("stuck");
    net.place("free").mark("free").place("gone");
    net.transition("go", &["free"], &["gone"]);
    net.source("never", Binding::event("never"));
    net.transition("end", &["never", "gone"], &["free"]);
    net.transition("both", &["free", "gone"], &["free", "gone"]);
    let refusal = check(&net, &[], &Limits::default()).unwrap_err();
    let text = toml::to_string(&refusal).unwrap();
    assert!(
        text.contains("net = \"stuck\"") && text.contains("reason"),
        "{text}"
    );
}
