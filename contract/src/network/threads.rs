//! Which threads of zenoh's carry links: one, for all of them.
//!
//! zenoh's TLS link (1.10.2) reads and writes one rustls connection from two tasks without a lock between them. On two threads that is
//! undefined behaviour: links break where both ends talk at once, and the process may crash (eclipse-zenoh/zenoh issue 2557). On
//! one thread the tasks never run at the same time: each holds the connection only while it runs, never while it waits, and a link
//! is closed only after both have ended, or by a third task on the same thread.

/// What zenoh reads its threads from when the first session opens, in any program that uses it.
const VARIABLE: &str = "ZENOH_RUNTIME";

/// What receives also sends, accepts, and ends links whose certificates have ended.
const ONE_THREAD: &str = "(rx: (worker_threads: 1), tx: (handover: rx), acc: (handover: rx))";

/// Lets one thread carry all links of this process, whatever the environment says. Every program that opens a network with certificates
/// calls it first.
///
/// # Safety
/// No other thread runs yet: it changes the environment.
pub unsafe fn carry_links_on_one_thread() {
    // SAFETY: the caller's.
    unsafe { std::env::set_var(VARIABLE, ONE_THREAD) };
}

/// Whether [`carry_links_on_one_thread`] was called, or the environment said the same.
pub(super) fn check() -> Result<(), String> {
    match std::env::var(VARIABLE) {
        Ok(found) if found == ONE_THREAD => Ok(()),
        found => Err(format!(
            "certificates need one thread for all links: {VARIABLE} is {}, expected `{ONE_THREAD}`",
            found.map_or("not set".into(), |found| format!("`{found}`"))
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::{ONE_THREAD, check};

    #[test]
    fn tests_the_kit_and_the_page_say_the_same() {
        let pages = [
            include_str!("../../../.cargo/config.toml"),
            include_str!("../../kit/network.py"),
            include_str!("../../PROTOCOL.md"),
        ];
        for page in pages {
            assert!(page.contains(ONE_THREAD), "{page}");
        }
        assert_eq!(check(), Ok(()));
    }
}
