//! The guard of allocations, in a process of its own: it ends what breaks the rules, and lets pass what may be.

mod cases;

use std::hint::black_box;
use std::process::Output;

use onboard::realtime::guard::{ENVIRONMENT_VARIABLE, arm_from_environment, real_time, relaxed};

/// Says to this program which case to be.
const CASE: &str = "ALLOCATION_GUARD_CASE";

/// One case; with the guard, or without.
fn case(name: &str, guard: &str) -> Output {
    cases::case(CASE, name, &[(ENVIRONMENT_VARIABLE, guard)])
}

/// Not a test of its own: what the other tests start.
#[test]
fn the_cases() {
    let Ok(case) = std::env::var(CASE) else {
        return;
    };
    arm_from_environment();
    let allocate = || black_box(Vec::<u64>::with_capacity(black_box(4)));
    let mut kept = allocate();
    match case.as_str() {
        "own" => real_time(|| {
            // What fits into what is there is not allocated.
            kept.push(1);
            relaxed(|| drop(allocate()));
        }),
        "allocated" => real_time(|| kept = allocate()),
        "released" => real_time(|| drop(kept)),
        "reallocated" => real_time(|| kept.extend(black_box([0; 64]))),
        other => panic!("no case {other}"),
    }
    drop(allocate());
    println!("through");
}

fn is_through(output: &Output) -> bool {
    output.status.success() && String::from_utf8_lossy(&output.stdout).contains("through")
}

#[test]
fn what_allocates_outside_the_rules_goes_on() {
    let output = case("own", "1");
    assert!(is_through(&output), "{output:?}");
}

#[test]
fn what_allocates_under_the_rules_ends_the_process_and_says_where() {
    for what in ["allocated", "released", "reallocated"] {
        let output = case(what, "1");
        let said = String::from_utf8_lossy(&output.stderr);
        let expected = format!("allocation guard: a real-time thread {what} ");
        assert!(
            !output.status.success() && said.contains(&expected) && said.contains("the_cases"),
            "{output:?}"
        );
    }
}

#[test]
fn a_guard_that_is_set_to_0_is_none() {
    for guard in ["", "0"] {
        let output = case("allocated", guard);
        assert_eq!(is_through(&output), guard == "0", "{output:?}");
    }
}
