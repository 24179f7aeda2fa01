//! Each check of the analysis on a net that is wrong in just that way, with the way there.

use crate::nets::{gate, protocol, robot};
use coordination::analysis::{Limits, Proof, Reason, Refusal, Report, Situation, Use, Warning};
use coordination::analysis::{check, check_situations};
use coordination::petri::{Binding, NetModel};
use coordination::protocol::{ABORTED, Party, ProtocolModel};

fn refused(model: &NetModel, uses: &[Use]) -> Refusal {
    check(model, uses, &Limits::default()).expect_err("the net is wrong")
}

fn passed(model: &NetModel, uses: &[Use]) -> Report {
    let proof =
        check(model, uses, &Limits::default()).unwrap_or_else(|refusal| panic!("{refusal}"));
    assert!(proof.model().is_same(model) && proof.uses().len() == uses.len());
    proof.report().clone()
}

fn way(refusal: &Refusal) -> String {
    refusal.trace.as_ref().expect("a way there").to_string()
}

/// A net that fires `request` into `granted`, robot by robot, without any common place.
fn answering() -> NetModel {
    let mut net = NetModel::new("answering");
    net.source("asked", Binding::flag("robot", "request"));
    net.sink("granted", Binding::flag("robot", "granted"));
    net.source("left", Binding::flag("robot", "released"));
    net
}

#[test]
fn a_gate_for_two_robots_passes() {
    let (net, uses) = gate(2);
    let report = passed(&net, &uses);
    assert_eq!(report.ends, ["idle"]);
    assert_eq!(report.warnings, []);
    // Six phases each (outside, asked, granted, told, left), less those in which both are inside.
    assert!(report.states > 10 && report.states < 100, "{report:?}");
}

#[test]
fn states_of_the_gate_grow_with_robots_and_stay_exact() {
    // With one robot: outside; asked; sink full; told; left; left and asked again.
    let (net, uses) = gate(1);
    let report = passed(&net, &uses);
    assert_eq!((report.states, report.steps), (6, 7));
}

#[test]
fn a_second_token_is_unsafe() {
    let mut net = answering();
    net.place("free").mark("free").end("idle", &["free"]);
    net.transition("enter", &["asked"], &["granted"]);
    net.transition("leave", &["left"], &["free"]);
    net.transition("never mind", &["free", "left"], &[]);
    let refusal = refused(&net, &[robot("robot")]);
    assert_eq!(
        *refusal.reason,
        Reason::Unsafe {
            transition: "leave".to_owned(),
            place: "free".to_owned()
        }
    );
    assert_eq!(
        way(&refusal),
        "robot sets request; enter; mediator raises robot.granted; robot sets released"
    );
    assert!(
        refusal.to_string().contains(
            "net `answering`: it is not safe: transition `leave` would put a second token into place `free`, after `robot sets request; "
        ),
        "{refusal}"
    );
}

#[test]
fn a_full_sink_holds_a_transition_back_and_is_no_fault() {
    let mut net = NetModel::new("bell");
    net.source("ring", Binding::event("ring"))
        .sink("bell", Binding::event("bell"));
    net.transition("pull", &["ring"], &["bell"]);
    let report = passed(&net, &[]);
    assert_eq!(report.states, 4);
    assert_eq!(report.warnings, [Warning::NoEnds]);
}

#[test]
fn a_net_that_loses_a_token_stops() {
    let mut net = answering();
    net.place("free")
        .mark("free")
        .place("taken")
        .end("idle", &["free"]);
    net.transition("enter", &["asked", "free"], &["taken", "granted"]);
    net.transition("leave", &["left", "taken"], &[]);
    let refusal = refused(&net, &[robot("robot")]);
    let Reason::Deadlock { marked, missed } = &*refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(marked, &["asked"]);
    assert_eq!(
        missed,
        &["protocol `robot` waits for `granted` of `mediator`"]
    );
    assert!(way(&refusal).ends_with("robot sets released; leave; robot sets request"));
}

#[test]
fn two_robots_that_each_hold_what_the_other_needs_stop() {
    let mut net = NetModel::new("philosophers");
    for (own, first, second) in [("a", "left", "right"), ("b", "right", "left")] {
        let place = |what: &str| format!("{own} {what}");
        net.source(place("asks"), Binding::flag(own, "request"));
        net.sink(place("may"), Binding::flag(own, "granted"));
        net.source(place("gone"), Binding::flag(own, "released"));
        net.place(place("half")).place(place("in"));
        net.transition(
            place("takes one"),
            &[&place("asks"), first],
            &[&place("half")],
        );
        net.transition(
            place("takes both"),
            &[&place("half"), second],
            &[&place("in"), &place("may")],
        );
        net.transition(
            place("leaves"),
            &[&place("gone"), &place("in")],
            &["left", "right"],
        );
    }
    net.place("left").mark("left").place("right").mark("right");
    net.end("idle", &["left", "right"]);
    let refusal = refused(&net, &[robot("a"), robot("b")]);
    assert!(
        matches!(*refusal.reason, Reason::Deadlock { .. }),
        "{refusal}"
    );
    assert_eq!(
        way(&refusal),
        "a sets request; a takes one; b sets request; b takes one"
    );
    assert!(
        refusal.to_string().contains("`a half`, `b half`"),
        "{refusal}"
    );
}

#[test]
fn an_end_may_be_dead_but_not_in_the_middle_of_a_run() {
    let mut net = NetModel::new("once");
    net.place("begun")
        .mark("begun")
        .place("waiting")
        .place("done")
        .end("done", &["done"]);
    net.sink("go", Binding::flag("robot", "go"));
    net.source("there", Binding::flag("robot", "there"));
    net.transition("start", &["begun"], &["waiting", "go"]);
    net.transition("finish", &["waiting", "there"], &["done"]);
    let short = [protocol("robot", &[("go", "mediator"), ("there", "robot")])];
    assert_eq!(passed(&net, &short).ends, ["done"]);

    let entries = [("go", "mediator"), ("there", "robot"), ("bye", "mediator")];
    let refusal = refused(&net, &[protocol("robot", &entries)]);
    let Reason::Deadlock { missed, .. } = &*refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(missed, &["protocol `robot` waits for `bye` of `mediator`"]);
}

#[test]
fn a_broken_exclusion_shows_how() {
    let (mut net, uses) = gate(2);
    net.exclusion("road", &["r0 in", "r1 in"]);
    passed(&net, &uses);

    let mut net = NetModel::new("two doors");
    for own in ["r0", "r1"] {
        let place = |what: &str| format!("{own} {what}");
        net.source(place("asks"), Binding::flag(own, "request"));
        net.sink(place("may"), Binding::flag(own, "granted"));
        net.source(place("gone"), Binding::flag(own, "released"));
        net.place(place("free"))
            .mark(&place("free"))
            .place(place("in"));
        net.transition(
            place("enters"),
            &[&place("asks"), &place("free")],
            &[&place("in"), &place("may")],
        );
        net.transition(
            place("leaves"),
            &[&place("gone"), &place("in")],
            &[&place("free")],
        );
    }
    net.exclusion("crossing", &["r0 in", "r1 in"]);
    let refusal = refused(&net, &[robot("r0"), robot("r1")]);
    assert_eq!(
        *refusal.reason,
        Reason::Exclusion {
            exclusion: "crossing".to_owned(),
            places: vec!["r0 in".to_owned(), "r1 in".to_owned()]
        }
    );
    assert_eq!(
        way(&refusal),
        "r0 sets request; r0 enters; r1 sets request; r1 enters"
    );
}

#[test]
fn an_exclusion_can_be_broken_from_the_beginning() {
    let (mut net, uses) = gate(1);
    net.place("r0 out").mark("r0 out");
    net.transition("stays", &["r0 out", "free"], &["r0 out", "free"]);
    net.exclusion("both", &["r0 out", "free"]);
    let refusal = refused(&net, &uses);
    assert!(
        refusal
            .to_string()
            .ends_with("are marked together, from the beginning"),
        "{refusal}"
    );
}

#[test]
fn a_transition_that_never_fires_names_what_it_lacks_and_its_sinks() {
    let (mut net, uses) = gate(1);
    net.place("key")
        .place("keyhole")
        .sink("alarm", Binding::event("alarm"));
    net.transition("turn", &["keyhole", "free"], &["alarm", "key"]);
    net.transition("back", &["key"], &["keyhole", "free"]);
    let refusal = refused(&net, &uses);
    let Reason::DeadTransitions { transitions, sinks } = &*refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(sinks, &["alarm"]);
    let names: Vec<_> = transitions
        .iter()
        .map(|dead| dead.transition.as_str())
        .collect();
    assert_eq!(names, ["turn", "back"]);
    assert_eq!(transitions[0].lacks, ["keyhole"]);
    assert_eq!(transitions[0].nearest.to_string(), "nothing");
    let text = refusal.to_string();
    assert!(
        text.contains("so these sinks are never marked: `alarm`"),
        "{text}"
    );
}

#[test]
fn the_nearest_miss_is_shown_where_it_happens() {
    let (mut net, uses) = gate(2);
    net.sink("crash", Binding::event("crash"));
    net.transition("both", &["r0 in", "r1 in"], &["crash"]);
    let refusal = refused(&net, &uses);
    let Reason::DeadTransitions { transitions, sinks } = &*refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(sinks, &["crash"]);
    assert_eq!(transitions[0].lacks, ["r1 in"]);
    assert_eq!(
        transitions[0].nearest.to_string(),
        "r0 sets request; r0 enters"
    );
}

#[test]
fn a_flag_before_its_turn_is_out_of_order() {
    // It says `granted` to whoever is there, asked or not.
    let mut net = answering();
    net.place("idle")
        .mark("idle")
        .place("busy")
        .end("idle", &["idle"]);
    net.transition("enter", &["idle"], &["granted", "busy"]);
    net.transition("leave", &["left", "busy", "asked"], &["idle"]);
    let refusal = refused(&net, &[robot("robot")]);
    assert_eq!(
        *refusal.reason,
        Reason::OutOfOrder {
            sink: "granted".to_owned(),
            protocol: "robot".to_owned(),
            flag: "granted".to_owned(),
            done: String::new(),
            next: "`request` of `robot`".to_owned(),
        }
    );
    assert_eq!(way(&refusal), "enter");
    assert!(
        refusal
            .to_string()
            .contains("after the beginning of a run comes `request` of `robot`"),
        "{refusal}"
    );
}

#[test]
fn flags_that_follow_each_other_may_wait_together() {
    let mut net = NetModel::new("two steps");
    net.source("asked", Binding::flag("r", "ask"));
    net.sink("slow", Binding::flag("r", "slow"))
        .sink("stop", Binding::flag("r", "stop"));
    net.transition("answer", &["asked"], &["slow", "stop"]);
    let order = |first, second| {
        let entries = [("ask", "robot"), (first, "mediator"), (second, "mediator")];
        [protocol("r", &entries)]
    };
    passed(&net, &order("slow", "stop"));
    passed(&net, &order("stop", "slow"));
    let entries = [
        ("ask", "robot"),
        ("slow", "mediator"),
        ("ok", "robot"),
        ("stop", "mediator"),
    ];
    let refusal = refused(&net, &[protocol("r", &entries)]);
    assert!(matches!(&*refusal.reason, Reason::OutOfOrder { flag, .. } if flag == "stop"));
}

#[test]
fn both_answers_at_once_are_out_of_order() {
    let mut model = ProtocolModel::new("ask", "robot", "mediator");
    model.array("ask", &[("request", "robot")]);
    model.array("yes", &[("granted", "mediator"), ("left", "robot")]);
    model.array("no", &[("refused", "mediator")]);
    model.follow("ask", "yes").follow("ask", "no");
    let ask = [Use::new(
        "r",
        model.compile().unwrap().into(),
        Party::Second,
    )];
    let mut net = NetModel::new("answers");
    net.source("asked", Binding::flag("r", "request"))
        .source("left", Binding::flag("r", "left"));
    net.sink("yes", Binding::flag("r", "granted"))
        .sink("no", Binding::flag("r", "refused"));
    net.place("free")
        .mark("free")
        .place("taken")
        .end("idle", &["free"]);
    let mut good = net.clone();
    good.transition("let in", &["asked", "free"], &["taken", "yes"]);
    good.transition("send away", &["asked", "free"], &["free", "no"]);
    good.transition("leave", &["left", "taken"], &["free"]);
    passed(&good, &ask);

    net.transition("say anything", &["asked", "free"], &["taken", "yes", "no"]);
    net.transition("leave", &["left", "taken"], &["free"]);
    let refusal = refused(&net, &ask);
    assert!(
        matches!(*refusal.reason, Reason::OutOfOrder { .. }),
        "{refusal}"
    );
    // Not before one of them is said: until then either could be.
    assert_eq!(
        way(&refusal),
        "robot sets r.request; say anything; mediator raises r.granted"
    );
}

#[test]
fn a_livelock_shows_where_the_last_way_to_an_end_is_lost() {
    let (mut net, uses) = gate(1);
    net.source("lost", Binding::event("cable cut"));
    net.place("round").place("and round");
    net.transition("panic", &["lost", "free"], &["round"]);
    net.transition("there", &["round"], &["and round"]);
    net.transition("back", &["and round"], &["round"]);
    let refusal = refused(&net, &uses);
    assert_eq!(
        *refusal.reason,
        Reason::Livelock {
            marked: vec!["round".to_owned()]
        }
    );
    assert_eq!(way(&refusal), "event cable cut arrives; panic");
}

#[test]
fn without_ends_a_run_that_cannot_complete_is_refused() {
    let mut net = answering();
    net.source("bell", Binding::event("bell"));
    net.place("free").mark("free").place("taken");
    net.transition("enter", &["asked", "free"], &["taken", "granted"]);
    net.transition("leave", &["left", "taken"], &["free"]);
    net.transition("close", &["bell", "free"], &[]);
    net.transition("ignore", &["bell", "taken"], &["taken"]);
    // A second robot goes on for ever, so nothing ever stops.
    net.source("other asked", Binding::flag("other", "request"));
    net.sink("other granted", Binding::flag("other", "granted"));
    net.source("other left", Binding::flag("other", "released"));
    net.place("other in").place("other out").mark("other out");
    net.transition(
        "other enters",
        &["other asked", "other out"],
        &["other in", "other granted"],
    );
    net.transition("other leaves", &["other left", "other in"], &["other out"]);
    let refusal = refused(&net, &[robot("robot"), robot("other")]);
    let Reason::Unfinished {
        protocol, missed, ..
    } = &*refusal.reason
    else {
        panic!("{refusal}");
    };
    assert_eq!(protocol, "robot");
    assert_eq!(missed, "protocol `robot` waits for `granted` of `mediator`");
    assert!(way(&refusal).contains("close"), "{refusal}");
}

#[test]
fn an_end_that_never_comes_is_refused() {
    let (mut net, uses) = gate(1);
    net.end("party", &["free", "r0 in"]);
    let refusal = refused(&net, &uses);
    let end = "party".to_owned();
    assert_eq!(*refusal.reason, Reason::EndUnreached { end });
}

#[test]
fn events_that_pile_up_are_refused() {
    let mut net = NetModel::new("counter");
    net.source("tick", Binding::flag("clock", "tick"))
        .place("ready")
        .mark("ready");
    net.sink("tock", Binding::event("tock"));
    net.transition("count", &["tick", "ready"], &["ready", "tock"]);
    let refusal = refused(&net, &[protocol("clock", &[("tick", "robot")])]);
    assert_eq!(
        *refusal.reason,
        Reason::Overflow {
            place: "tick".to_owned(),
            event: "clock.tick".to_owned(),
            waiting: Limits::default().waiting,
        }
    );
    assert_eq!(way(&refusal).matches("clock sets tick").count(), 5);
}

#[test]
fn a_net_beyond_the_limits_is_refused_and_says_so() {
    let (net, uses) = gate(6);
    // One state after another, and no further.
    let limits = Limits {
        nodes: 0,
        ..Limits::default()
    };
    let found = check(&net, &uses, &limits).unwrap().report().states;
    let states = usize::try_from(found).unwrap();
    for (limits, what) in [
        (
            Limits {
                states: states - 1,
                ..limits
            },
            "states",
        ),
        (
            Limits {
                steps: 1000,
                ..limits
            },
            "steps",
        ),
        (
            Limits {
                looks: 1000,
                ..limits
            },
            "transitions to look at",
        ),
    ] {
        let refusal = check(&net, &uses, &limits).unwrap_err();
        let Reason::TooLarge { what: found, .. } = *refusal.reason else {
            panic!("{refusal}");
        };
        assert_eq!(found, what);
        assert!(
            refusal.to_string().contains("too large to analyse"),
            "{refusal}"
        );
    }
    let exact = Limits { states, ..limits };
    assert_eq!(check(&net, &uses, &exact).unwrap().report().states, found);
}

#[test]
fn bindings_are_checked_first() {
    let with = |source: Binding, sink: Binding| {
        let mut net = NetModel::new("bound");
        net.source("in", source).sink("out", sink);
        net.transition("t", &["in"], &["out"]);
        refused(&net, &[robot("robot")])
    };
    let event = || Binding::event("e");
    let cases = [
        (
            with(Binding::flag("rabot", "request"), event()),
            "place `in` is bound to the unknown protocol `rabot`; known: robot",
        ),
        (
            with(Binding::flag("robot", "asked"), event()),
            "place `in` is bound to the unknown flag `asked` of protocol `robot`; known: request, granted, released",
        ),
        (
            with(Binding::flag("robot", "granted"), event()),
            "source `in` is bound to flag `granted` of protocol `robot`, which belongs to `mediator`; expected a flag of `robot`",
        ),
        (
            with(event(), Binding::flag("robot", "request")),
            "sink `out` is bound to flag `request` of protocol `robot`, which belongs to `robot`; expected a flag of `mediator`",
        ),
        (
            with(Binding::flag("robot", ABORTED), event()),
            "place `in` is bound to the unknown flag `aborted` of protocol `robot`; known: request, granted, released",
        ),
    ];
    for (refusal, text) in cases {
        assert_eq!(refusal.to_string(), format!("net `bound`: {text}"));
        assert_eq!(refusal.trace, None);
    }
    let (net, _) = gate(1);
    let twice = refused(&net, &[robot("r0"), robot("r0")]);
    assert!(
        twice.to_string().contains("two protocols are called `r0`"),
        "{twice}"
    );
    let broken = refused(
        NetModel::new("broken").transition("t", &["nowhere"], &[]),
        &[],
    );
    assert!(matches!(*broken.reason, Reason::Model(_)), "{broken}");
    assert!(broken.to_string().contains("nowhere"), "{broken}");
}

/// A gate for `r`, which may give up.
fn gate_of_a_keeper() -> (NetModel, [Use; 1]) {
    let mut model = ProtocolModel::new("ask", "robot", "mediator");
    model.array(
        "all",
        &[
            ("request", "robot"),
            ("granted", "mediator"),
            ("released", "robot"),
        ],
    );
    model.keeper("robot");
    let uses = [Use::new(
        "r",
        model.compile().unwrap().into(),
        Party::Second,
    )];
    let mut net = NetModel::new("gate");
    net.source("asked", Binding::flag("r", "request"))
        .source("left", Binding::flag("r", "released"));
    net.sink("may", Binding::flag("r", "granted"));
    net.place("free")
        .mark("free")
        .place("taken")
        .end("idle", &["free"]);
    net.transition("enter", &["asked", "free"], &["taken", "may"]);
    net.transition("leave", &["left", "taken"], &["free"]);
    (net, uses)
}

#[test]
fn a_source_of_aborts_is_filled_when_the_other_gives_up() {
    let (mut net, uses) = gate_of_a_keeper();
    net.source("gone", Binding::flag("r", ABORTED));
    net.transition("ignore", &["gone", "free"], &["free"]);
    let refusal = refused(&net, &uses);
    assert!(
        matches!(*refusal.reason, Reason::Deadlock { .. }),
        "{refusal}"
    );
    assert!(way(&refusal).contains("robot gives up r"), "{refusal}");

    // What waited for it was voided, so `asked` and `left` need no clearing.
    net.transition("clear", &["gone", "taken"], &["free"]);
    assert_eq!(passed(&net, &uses).ends, ["idle"]);
}

#[test]
fn an_abort_that_nothing_reads_is_refused() {
    let (net, uses) = gate_of_a_keeper();
    let refusal = refused(&net, &uses);
    let protocol = "r".to_owned();
    assert_eq!(*refusal.reason, Reason::UnreadAbort { protocol });
    assert_eq!(
        refusal.to_string(),
        "net `gate`: no source is bound to `aborted` of protocol `r`, whose other party can give up its runs"
    );
}

#[test]
fn no_flag_comes_before_the_abort_in_front_of_it_is_read() {
    let (mut net, uses) = gate_of_a_keeper();
    net.source("gone", Binding::flag("r", ABORTED));
    net.transition("ignore", &["gone", "free"], &["free"]);
    let mut late = net.clone();
    net.transition("clear", &["gone", "taken"], &["free"]);
    net.transition("overtaken", &["gone", "asked", "taken"], &["free"]);
    let refusal = refused(&net, &uses);
    let Reason::DeadTransitions { transitions, .. } = &*refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(transitions.len(), 1);
    assert_eq!(transitions[0].transition, "overtaken");

    // Nor may a net wait for the next request to deal with an abort.
    late.transition("clear late", &["gone", "taken", "asked"], &["free"]);
    let refusal = refused(&late, &uses);
    let Reason::Deadlock { marked, .. } = &*refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(marked, &["taken", "gone"]);
}

#[test]
fn a_flag_for_several_sources_must_not_be_given_up() {
    let (mut net, uses) = gate_of_a_keeper();
    net.source("gone", Binding::flag("r", ABORTED))
        .source("also asked", Binding::flag("r", "request"));
    net.transition("ignore", &["gone", "free"], &["free"]);
    net.transition("clear", &["gone", "taken"], &["free"]);
    net.transition("listen", &["also asked", "taken"], &["taken"]);
    let refusal = refused(&net, &uses);
    let (protocol, flag) = ("r".to_owned(), "request".to_owned());
    assert_eq!(*refusal.reason, Reason::SeveralSources { protocol, flag });
    assert!(
        refusal
            .to_string()
            .contains("flag `request` of protocol `r` fills several sources"),
        "{refusal}"
    );
}

#[test]
fn what_only_one_situation_does_is_enough() {
    let model = |mark: &str| {
        let mut net = NetModel::new("two rings");
        net.source("push", Binding::event("push")).mark(mark);
        for ring in ["a", "b"] {
            let (here, there) = (format!("{ring} here"), format!("{ring} there"));
            net.place(&here).place(&there).end(ring, &[&here]);
            net.transition(format!("{ring} out"), &["push", &here], &[&there]);
            net.transition(format!("{ring} back"), &["push", &there], &[&here]);
        }
        net
    };
    let (a, b) = (model("a here"), model("b here"));
    let at_a = Situation {
        name: "at a",
        model: &a,
    };
    let at_b = Situation {
        name: "at b",
        model: &b,
    };
    let limits = Limits::default();
    let proofs = check_situations(&[at_b, at_a], &[], &limits).unwrap();
    let reports: Vec<&Report> = proofs.iter().map(Proof::report).collect();
    assert_eq!((reports[0].states, reports[1].states), (4, 4));
    assert_eq!(
        (&reports[0].ends[..], &reports[1].ends[..]),
        (&["b".to_owned()][..], &["a".to_owned()][..])
    );
    let refusal = check_situations(&[at_b], &[], &limits).unwrap_err();
    assert!(
        refusal.to_string().starts_with(
            "net `two rings` in situation `at b`: transition `a out` never fires: it comes nearest after `event push arrives`, and then lacks `a here`"
        ),
        "{refusal}"
    );
    let none = check_situations(&[], &[], &limits).unwrap_err();
    assert_eq!(*none.reason, Reason::NoSituation);
}

#[test]
fn what_is_odd_but_works_is_warned_of() {
    let mut net = answering();
    net.place("free").mark("free").place("taken");
    net.transition("enter", &["asked", "free"], &["taken", "granted"]);
    net.transition("leave", &["left", "taken"], &["free"]);
    net.transition("spin", &["taken"], &["taken"]);
    let entries = [
        ("request", "robot"),
        ("granted", "mediator"),
        ("entered", "robot"),
        ("released", "robot"),
    ];
    let uses = [protocol("robot", &entries)];
    let refusal = refused(&net, &uses);
    assert_eq!(*refusal.reason, Reason::Endless);
    assert_eq!(way(&refusal), "robot sets request");
    net.allow_endless();
    let report = passed(&net, &uses);
    let texts: Vec<_> = report.warnings.iter().map(Warning::to_string).collect();
    assert_eq!(
        texts,
        [
            "no end is declared",
            "no source reads flag `entered` of protocol `robot`",
            "after `robot sets request` it can fire for ever without any flag or event from outside",
        ]
    );
}

#[test]
fn a_transition_dead_everywhere_is_found_behind_many_that_are_dead_here() {
    let model = |mark: &str| {
        let mut net = NetModel::new("rings");
        for ring in 0..100 {
            let (here, there) = (format!("h{ring}"), format!("t{ring}"));
            net.place(&here).place(&there);
            net.transition(format!("out{ring}"), &["push", "a", &here], &["a", &there]);
            net.transition(format!("back{ring}"), &["push", "a", &there], &["a", &here]);
            net.end(format!("e{ring}"), &["a", &here]);
        }
        net.source("push", Binding::event("push"))
            .place("a")
            .mark("a");
        net.place("other")
            .transition("never", &["other"], &["other"]);
        net.mark(mark);
        net
    };
    let models: Vec<(String, NetModel)> = (0..100)
        .map(|ring| (format!("s{ring}"), model(&format!("h{ring}"))))
        .collect();
    let situations: Vec<Situation<'_>> = models
        .iter()
        .map(|(name, model)| Situation { name, model })
        .collect();
    let refusal = check_situations(&situations, &[], &Limits::default()).unwrap_err();
    let Reason::DeadTransitions { transitions, .. } = &*refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(transitions.len(), 1);
    assert_eq!(transitions[0].transition, "never");
}
