//! The guard of system calls, in a process of its own: it ends what breaks the rules, and lets pass what may be.

mod cases;

use std::fs::File;
use std::process::Output;
use std::time::Duration;

use onboard::realtime::clock::{MILLISECOND_NS, now_ns, sleep_until};
use onboard::realtime::guard::{real_time, relaxed};
use onboard::realtime::system_calls::guard_this_thread;
use onboard::realtime::wake::Wake;

/// Says to this program which case to be.
const CASE: &str = "SYSTEM_CALL_GUARD_CASE";

/// One case, in which a thread is guarded.
fn case(name: &str) -> Output {
    cases::case(CASE, name, &[])
}

/// Not a test of its own: what the other tests start.
#[test]
fn the_cases() {
    let Ok(case) = std::env::var(CASE) else {
        return;
    };
    let guarded = std::thread::spawn(move || {
        guard_this_thread("guarded").expect("the kernel has filters");
        let open = || drop(File::open("/proc/self/stat").expect("a file"));
        open();
        match case.as_str() {
            // Who asks for the time first looks for the kernel's page with it.
            "own" if now_ns() > 0 => real_time(|| {
                sleep_until(now_ns() + MILLISECOND_NS);
                Wake::default().wake(now_ns());
                relaxed(open);
            }),
            "file" => real_time(open),
            "yield" => real_time(std::thread::yield_now),
            other => panic!("no case {other}"),
        }
        open();
        println!("through");
    });
    guarded.join().expect("it ends well");
    std::thread::sleep(Duration::from_millis(1));
}

#[test]
fn a_thread_makes_its_own_calls_and_others_while_it_is_not_running() {
    let output = case("own");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success() && said.contains("through"),
        "{output:?}"
    );
}

#[test]
fn a_call_that_is_not_its_own_ends_the_process_and_says_so() {
    for (name, call) in [("file", libc::SYS_openat), ("yield", libc::SYS_sched_yield)] {
        let output = case(name);
        let said = String::from_utf8_lossy(&output.stderr);
        let expected = format!(
            "guard of system calls: real-time thread guarded made call {call} in state running"
        );
        assert!(
            !output.status.success() && said.contains(&expected),
            "{output:?}"
        );
    }
}
