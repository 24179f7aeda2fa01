//! What an executor promises beside firing right: no allocation, bounded queues, errors that change
//! nothing.

mod counting;

use coordination::event::{EventId, EventTable};
use coordination::petri::{
    Binding, Budget, Executor, Net, NetModel, Obstacle, OfferError, PlaceId, TransitionId,
    WrongMarking,
};
use counting::allocations;

/// Many processes that wait for events, share resources and produce events.
fn busy_net(processes: usize, events: &mut EventTable) -> Net {
    let mut model = NetModel::new("busy");
    model.place("one").mark("one").place("two").mark("two");
    for i in 0..processes {
        let [idle, waiting, using, ask, done] =
            ["idle", "waiting", "using", "ask", "done"].map(|name| format!("{name}{i}"));
        model.place(&idle).mark(&idle).place(&waiting).place(&using);
        model.source(&ask, Binding::event(format!("ask{}", i % 7)));
        model.sink(&done, Binding::flag("robot", format!("done{i}")));
        model.transition(format!("ask{i}_"), &[&idle, &ask], &[&waiting]);
        model.transition(format!("take{i}"), &[&waiting, "one", "two"], &[&using]);
        let outputs = [&*idle, &*done, "one", "two"];
        model.transition(format!("give{i}"), &[&using], &outputs);
    }
    model.compile(events).unwrap()
}

#[test]
fn running_does_not_allocate() {
    for processes in [3, 30, 300] {
        let mut events = EventTable::new();
        let net = busy_net(processes, &mut events);
        let asks: Vec<_> = (0..7)
            .filter_map(|i| events.id(&format!("ask{i}")))
            .collect();
        let marking: Vec<_> = net.initial_marking().collect();
        let mut executor = net.executor();
        let mut trace = vec![TransitionId(0); 100];
        let mut fired = 0;
        let found = allocations(|| {
            for step in 0..200_u32 {
                for &ask in &asks {
                    let _ = executor.offer(ask);
                }
                let budget = Budget {
                    firings: 1 + step % 50,
                    rounds: 1 + step % 3,
                };
                fired += executor.evaluate(budget).fired;
                fired += executor.evaluate_traced(Budget::ROUND, &mut trace).fired;
                fired += executor.evaluate(Budget::ONE).fired;
                let next = executor.enabled().next();
                if let Some(next) = next {
                    executor.fire(next).expect("it is enabled");
                    fired += 1;
                }
                let mut kept = 0;
                executor.drain_sinks(|_| {
                    kept += 1;
                    kept % 3 != 0
                });
                let full = executor.marked_sinks().next();
                if let Some((sink, _)) = full {
                    assert!(executor.take(sink));
                }
                assert!(executor.marking().count() >= processes);
                if step == 100 {
                    executor.reset();
                    executor.set_marking(&marking).unwrap();
                }
            }
        });
        assert_eq!(found, 0);
        assert!(fired > 400, "only {fired} fired");
    }
}

#[test]
fn an_executor_goes_to_another_thread() {
    fn is_send<T: Send>() {}
    is_send::<Executor>();
    fn is_shared<T: Send + Sync>() {}
    is_shared::<Net>();
}

#[test]
fn a_clone_goes_its_own_way_without_allocating() {
    let mut events = EventTable::new();
    let net = busy_net(5, &mut events);
    let original = net.executor();
    let mut copy = original.clone();
    copy.offer(events.id("ask0").unwrap()).unwrap();
    let found = allocations(|| {
        assert_eq!(copy.evaluate(Budget::ROUND).fired, 3);
    });
    assert_eq!(found, 0);
    assert_eq!(
        original.marking().collect::<Vec<_>>(),
        net.initial_marking().collect::<Vec<_>>()
    );
}

#[test]
fn an_event_without_a_source_is_refused_and_counted() {
    let mut events = EventTable::new();
    let mut executor = busy_net(1, &mut events).executor();
    let done = events.id("robot.done0").unwrap();
    for event in [done, EventId(u16::MAX)] {
        assert_eq!(executor.offer(event), Err(OfferError::UnknownEvent(event)));
    }
    assert_eq!(executor.refused(), 2);
    assert!(!executor.evaluate(Budget::ROUND).remaining);
}

#[test]
fn a_queue_that_is_full_refuses_for_all_its_sources() {
    let mut model = NetModel::new("two");
    model.place("p").mark("p");
    model
        .source("a", Binding::event("e"))
        .source("b", Binding::event("e"));
    model.transition("t", &["p", "a"], &["p"]);
    model.transition("u", &["p", "b"], &["p"]);
    let mut events = EventTable::new();
    let net = model.compile(&mut events).unwrap();
    let event = events.id("e").unwrap();
    let [a, b] = ["a", "b"].map(|name| net.place_id(name).unwrap());
    let mut executor = net.executor();
    for _ in 0..Executor::MAX_WAITING {
        executor.offer(event).unwrap();
    }
    assert_eq!(executor.offer(event), Err(OfferError::Full(a)));
    assert_eq!(executor.waiting(b), Executor::MAX_WAITING);
    let evaluation = executor.evaluate(Budget::ROUND);
    assert_eq!((evaluation.fired, evaluation.remaining), (2, true));
    executor.offer(event).unwrap();
    assert_eq!(executor.waiting(a), Executor::MAX_WAITING);
    // Every event is used in the end, none twice.
    let mut fired = 0;
    while executor.evaluate(Budget::ROUND).remaining {
        fired += 1;
    }
    assert_eq!(fired, Executor::MAX_WAITING - 1);
    assert_eq!(executor.firings(), 2 * u64::from(Executor::MAX_WAITING + 1));
}

#[test]
fn a_wrong_marking_changes_nothing() {
    let mut events = EventTable::new();
    let net = busy_net(2, &mut events);
    let mut executor = net.executor();
    let before: Vec<_> = executor.marking().collect();
    let places = net.places().len();
    let place = PlaceId(places as u16);
    let wrong = executor.set_marking(&[PlaceId(0), place]);
    assert_eq!(wrong, Err(WrongMarking { place, places }));
    assert_eq!(executor.marking().collect::<Vec<_>>(), before);
    assert!(!executor.is_marked(place));
    assert!(!executor.take(place));
    assert!(!executor.take(PlaceId(0)), "an internal place is no sink");
    assert_eq!(executor.waiting(place), 0);
}

#[test]
fn a_full_sink_blocks_until_it_is_taken() {
    let mut events = EventTable::new();
    let net = busy_net(1, &mut events);
    let ask = events.id("ask0").unwrap();
    let mut executor = net.executor();
    executor.offer(ask).unwrap();
    executor.offer(ask).unwrap();
    assert_eq!(executor.evaluate(Budget::ROUND).fired, 3);
    // The second time stops before `give`, whose sink is full.
    let evaluation = executor.evaluate(Budget::ROUND);
    assert_eq!((evaluation.fired, evaluation.remaining), (2, false));
    assert_eq!(executor.drain_sinks(|_| false), 0);
    assert_eq!(executor.evaluate(Budget::ROUND).fired, 0);
    assert_eq!(executor.drain_sinks(|_| true), 1);
    assert_eq!(executor.evaluate(Budget::ROUND).fired, 1);
}

#[test]
fn sinks_are_shown_in_the_order_in_which_they_filled() {
    let mut model = NetModel::new("order");
    model.place("p").mark("p").place("q");
    model
        .sink("late", Binding::event("late"))
        .sink("early", Binding::event("early"));
    model.transition("second", &["q"], &["p", "late"]);
    model.transition("first", &["p"], &["q", "early"]);
    let mut events = EventTable::new();
    let mut executor = model.compile(&mut events).unwrap().executor();
    assert_eq!(executor.evaluate(Budget::ROUND).fired, 2);
    let mut names = Vec::new();
    executor.drain_sinks(|event| {
        names.push(events.name(event).unwrap().to_owned());
        true
    });
    assert_eq!(names, ["early", "late"]);
}

#[test]
fn choice_goes_round() {
    let mut model = NetModel::new("fair");
    model.place("p").mark("p");
    for name in ["a", "b", "c"] {
        model.transition(name, &["p"], &["p"]);
    }
    let net = model.compile(&mut EventTable::new()).unwrap();
    let mut executor = net.executor();
    let mut fired = String::new();
    for _ in 0..7 {
        let mut trace = [TransitionId(0)];
        executor.evaluate_traced(Budget::ONE, &mut trace);
        fired += net.transition_name(trace[0]);
    }
    assert_eq!(fired, "abcabca");
    // In one round each fires once, whoever is next.
    let evaluation = executor.evaluate(Budget::ROUND);
    assert_eq!((evaluation.fired, evaluation.remaining), (3, true));
    let nothing = Budget {
        firings: 5,
        rounds: 0,
    };
    assert_eq!(executor.evaluate(nothing).fired, 0);
}

#[test]
fn a_reset_forgets_what_waits_and_begins_anew() {
    let mut events = EventTable::new();
    let net = busy_net(40, &mut events);
    let ask = events.id("ask0").unwrap();
    let [mut used, mut fresh] = [net.executor(), net.executor()];
    for _ in 0..3 {
        used.offer(ask).unwrap();
    }
    used.evaluate(Budget {
        firings: 7,
        rounds: 2,
    });
    used.reset();
    let source = net.place_id("ask0").unwrap();
    assert_eq!(used.waiting(source), 0);
    assert_eq!(used.marked_sinks().len(), 0);
    for executor in [&mut used, &mut fresh] {
        assert_eq!(executor.evaluate(Budget::ROUND).fired, 0);
        executor.offer(ask).unwrap();
    }
    let mut traces = [[TransitionId(0); 50]; 2];
    for (executor, trace) in [&mut used, &mut fresh].into_iter().zip(&mut traces) {
        assert!(executor.evaluate_traced(Budget::ROUND, trace).fired > 3);
    }
    assert_eq!(traces[0], traces[1]);
}

#[test]
fn obstacles_are_named() {
    let mut model = NetModel::new("gate");
    model.source("asked", Binding::event("ask"));
    model.sink("granted", Binding::event("grant"));
    model.place("free").mark("free").place("inside");
    model.source("left", Binding::event("leave"));
    model.transition("enter", &["asked", "free"], &["inside", "granted"]);
    model.transition("leave", &["inside", "left"], &["free"]);
    let mut events = EventTable::new();
    let net = model.compile(&mut events).unwrap();
    let [enter, leave] = ["enter", "leave"].map(|name| net.transition_id(name).unwrap());
    let [ask, left] = ["ask", "leave"].map(|name| events.id(name).unwrap());
    let mut gate = net.executor();
    let why = |gate: &Executor, transition| -> Vec<String> {
        let obstacles = gate.why_not(transition);
        obstacles.map(|obstacle| obstacle.describe(&net)).collect()
    };
    assert_eq!(why(&gate, enter), ["no event fills `asked`"]);
    assert_eq!(
        why(&gate, leave),
        [
            "`inside` is empty",
            "no event fills `left`",
            "`free` is full"
        ]
    );
    // An event that waits counts, and is used up.
    gate.offer(ask).unwrap();
    gate.offer(ask).unwrap();
    assert!(gate.is_enabled(enter));
    gate.fire(enter).unwrap();
    assert_eq!((gate.firings(), gate.marked_sinks().len()), (1, 1));
    gate.offer(left).unwrap();
    gate.fire(leave).unwrap();
    assert_eq!(why(&gate, enter), ["nobody has taken `granted`"]);
    assert_eq!(
        gate.fire(enter).unwrap_err().to_string(),
        "output place 1 is full"
    );
    assert_eq!(gate.drain_sinks(|_| true), 1);
    // The executor goes on from there by itself.
    assert_eq!(gate.evaluate(Budget::default()).fired, 1);
    assert_eq!(gate.waiting(net.place_id("asked").unwrap()), 0);
    let unknown = TransitionId(7);
    assert_eq!(why(&gate, unknown), ["the net has no transition 7"]);
    let strange = Obstacle::Empty(PlaceId(99));
    assert_eq!(strange.describe(&net), "`?` is empty");
}
