//! The guard of system calls, in a process of its own: it ends what breaks the rules, and lets pass what may be.

mod cases;

use std::fs::File;
use std::process::Output;
use std::sync::Mutex;
use std::sync::mpsc::channel;
use std::time::Duration;

use onboard::realtime::clock::{MILLISECOND_NS, Monotonic, now_ns, sleep_until};
use onboard::realtime::guard::{real_time, relaxed};
use onboard::realtime::system_calls::guard_this_thread;
use onboard::realtime::wake::Wake;
use rustix::fd::{AsFd, BorrowedFd};
use rustix::pty::{OpenptFlags, openpt};

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
    let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
    let file = tempfile::tempfile().expect("a file");
    let lock = Mutex::new(());
    // Who holds the lock, for as long as nobody has sent anything.
    let (release, released) = channel::<()>();
    std::thread::scope(|scope| {
        if case == "lock" {
            let (held, is_held) = channel();
            let lock = &lock;
            scope.spawn(move || {
                let _guard = lock.lock();
                held.send(()).expect("awaited");
                released.recv()
            });
            is_held.recv().expect("it is held");
        }
        scope.spawn(|| {
            guard_this_thread("guarded").expect("the kernel has filters");
            let open = || drop(File::open("/proc/self/stat").expect("a file"));
            let write = |to: BorrowedFd<'_>| assert_eq!(rustix::io::write(to, b"."), Ok(1));
            open();
            match case.as_str() {
                // Who asks for the time first looks for the kernel's page with it.
                "own" if now_ns() > 0 => real_time(|| {
                    let soon_ns = now_ns() + MILLISECOND_NS;
                    sleep_until(soon_ns);
                    Wake::default().wake(now_ns());
                    let _ = Wake::default().wait_beyond(&Monotonic, 0, soon_ns + MILLISECOND_NS);
                    drop(lock.lock());
                    write(device.as_fd());
                    relaxed(|| write(file.as_fd()));
                    relaxed(open);
                }),
                "file" => real_time(open),
                "yield" => real_time(std::thread::yield_now),
                "lock" => real_time(|| drop(lock.lock())),
                "print" => real_time(|| write(rustix::stdio::stdout())),
                "disk" => real_time(|| write(file.as_fd())),
                other => panic!("no case {other}"),
            }
            open();
            drop(release);
            println!("through");
        });
    });
    std::thread::sleep(Duration::from_millis(1));
}

/// A thread that is being guarded makes no call of its own before somebody looks: what allocates may make one, depending on how much is
/// allocated already.
#[test]
fn a_thread_is_guarded_however_much_it_has_allocated() {
    const THREADS: usize = 1000;
    for number in 0..THREADS {
        let (done, is_done) = channel();
        std::thread::spawn(move || {
            let kept = Vec::<u8>::with_capacity(64 * (number % 64) + 16);
            std::mem::forget(std::hint::black_box(kept));
            guard_this_thread("guarded").expect("the kernel has filters");
            drop(File::open("/proc/self/stat").expect("a file"));
            done.send(()).expect("awaited");
        });
        if is_done.recv_timeout(Duration::from_secs(20)).is_err() {
            // One that hangs while it allocates keeps others from it: nothing can be said in words that are made up now.
            let _ = rustix::io::write(rustix::stdio::stderr(), b"a thread that is guarded hangs\n");
            std::process::abort();
        }
    }
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
    for (name, call) in [
        ("file", libc::SYS_openat),
        ("yield", libc::SYS_sched_yield),
        ("lock", libc::SYS_futex),
        ("print", libc::SYS_write),
        ("disk", libc::SYS_write),
    ] {
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
