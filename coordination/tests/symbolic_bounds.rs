//! What nets with far more states than can be looked at one by one take of a core and of memory.
//!
//! A program of its own, whose tests take turns: the search has a thread of its own, so that only the
//! processor time of the whole process shows what it took.

#[path = "it/nets/mod.rs"]
mod nets;
#[path = "../examples/petri_families/shipped.rs"]
mod shipped;

use std::fs;
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use coordination::analysis::{Limits, Reason, check};
use coordination::petri::{NetModel, PlaceKind};
use rustix::time::{ClockId, clock_gettime};

use nets::gate;

/// The longest that a net may take of a core, whatever else the machine does: twice what the slowest of these takes;
const LONGEST: Duration = Duration::from_secs(10);
/// and the most memory that this program may ever have had.
const LARGEST_KIB: u64 = 1 << 20;

static TURN: Mutex<()> = Mutex::new(());

/// Does this within what a net may take. A system that does not tell the memory is believed.
fn within_bounds<R>(work: impl FnOnce() -> R) -> R {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let before = processor_time();
    let result = work();
    let took = processor_time() - before;
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let peak_kib = peak.and_then(|peak| peak.split_whitespace().next()?.parse().ok());
    println!("{took:?} of a core, {peak_kib:?} KiB at most");
    assert!(took < LONGEST, "{took:?}");
    assert!(peak_kib.unwrap_or(0) < LARGEST_KIB, "{peak_kib:?} KiB");
    result
}

/// What all threads of this process have had of cores, ended ones too.
fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::try_from(time).unwrap_or_default()
}

/// Else a search of a minute would pass as one of no time.
#[test]
fn time_of_other_threads_counts() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let before = processor_time();
    let enough = Duration::from_millis(20);
    let work = move || while processor_time() - before < enough {};
    std::thread::spawn(work).join().unwrap();
    assert!(processor_time() - before >= enough);
}

#[test]
fn a_gate_with_a_hundred_robots_passes() {
    let (net, uses) = gate(100);
    let proof = within_bounds(|| check(&net, &uses, &Limits::default()));
    let proof = proof.unwrap_or_else(|refusal| panic!("{refusal}"));
    assert!(proof.report().states > 1 << 100);
}

/// Those with which this crate was published have none.
#[test]
fn each_shipped_net_passes_one_state_at_a_time_and_all_at_once() {
    let shipped = shipped::all();
    assert_eq!(shipped.is_empty(), !shipped::folder().is_dir());
    let all_at_once = Limits {
        states: 0,
        ..Limits::default()
    };
    for net in shipped {
        let model = net.shuffled(|limit| limit - 1);
        for limits in [Limits::default(), all_at_once] {
            let proof = within_bounds(|| check(&model, &net.uses, &limits));
            assert!(proof.is_ok(), "{}: {proof:?}", net.name);
        }
    }
}

fn philosophers(count: usize) -> NetModel {
    let mut net = NetModel::new("philosophers");
    for own in 0..count {
        let place = |what: &str| format!("{what}{own}");
        for what in ["think", "fork"] {
            net.place(place(what)).mark(&place(what));
        }
        for what in ["left", "right", "eat"] {
            net.place(place(what));
        }
        let (fork, next) = (place("fork"), format!("fork{}", (own + 1) % count));
        let [think, left, right, eat] = ["think", "left", "right", "eat"].map(place);
        net.transition(place("takes left "), &[&think, &fork], &[&left]);
        net.transition(place("takes right "), &[&left, &next], &[&eat]);
        net.transition(place("puts down "), &[&eat], &[&right, &fork, &next]);
        net.transition(place("thinks "), &[&right], &[&think]);
    }
    net.allow_endless();
    net
}

#[test]
fn a_hundred_philosophers_starve() {
    let net = philosophers(100);
    let refusal = within_bounds(|| check(&net, &[], &Limits::default())).unwrap_err();
    assert!(matches!(*refusal.reason, Reason::Deadlock { .. }));
    assert_eq!(refusal.trace.unwrap().steps.len(), 100);
}

#[test]
fn a_gate_that_one_of_a_hundred_robots_does_not_give_back_is_refused() {
    let (net, uses) = gate(100);
    // The same net, but for the last robot's way out.
    let mut faulty = NetModel::new("faulty");
    for place in net.places() {
        match (place.kind, place.binding) {
            (PlaceKind::Source, Some(binding)) => faulty.source(place.name, binding.clone()),
            (PlaceKind::Sink, Some(binding)) => faulty.sink(place.name, binding.clone()),
            _ => faulty.place(place.name),
        };
        if place.marked {
            faulty.mark(place.name);
        }
    }
    for transition in net.transitions() {
        let is_last = transition.name == "r99 leaves";
        let outputs = if is_last {
            &[][..]
        } else {
            &transition.outputs
        };
        faulty.transition(transition.name, &transition.inputs, outputs);
    }
    faulty.end("idle", &["free"]);
    let refusal = within_bounds(|| check(&faulty, &uses, &Limits::default())).unwrap_err();
    // The others ask, and wait for ever.
    let Reason::Deadlock { marked, .. } = &*refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(marked.len(), 100);
    assert!(marked.contains(&"r99 asks".to_owned()), "{refusal}");
    assert_eq!(refusal.trace.unwrap().steps.len(), 5 + 100);
}

/// As on 32 bits, where a stack as large as the library likes it may not be had.
#[test]
fn a_stack_that_cannot_be_had_is_a_refusal() {
    const CASE: &str = "a_stack_that_cannot_be_had_is_a_refusal";
    const VARIABLE: &str = "OXIDD_STACK_SIZE";
    let told = std::env::var(VARIABLE).ok();
    if told.as_deref() != Some(&*usize::MAX.to_string()) {
        let this = std::env::current_exe().unwrap();
        let output = Command::new(this)
            .args(["--exact", CASE])
            .env(VARIABLE, usize::MAX.to_string())
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
        return;
    }
    let (net, uses) = gate(100);
    let refusal = check(&net, &uses, &Limits::default()).unwrap_err();
    let text = refusal.to_string();
    assert!(
        text.contains("bytes of stack") && text.contains(VARIABLE),
        "{text}"
    );
}
