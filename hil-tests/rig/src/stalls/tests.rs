//! What counts as a stall, and what it may be to blame for.

use std::cell::Cell;

use super::*;

/// A watch without threads, begun at a time, that saw these stalls.
fn watch(start_ns: u64, seen: &[(u64, u64)]) -> StallWatch {
    let threads = Watching::default();
    lock(&threads.cores).extend(seen);
    StallWatch {
        start_ns,
        ..StallWatch::of(Arc::new(threads))
    }
}

#[test]
fn stalls_are_counted_from_a_time_on() {
    let watch = watch(150, &[(100, 7_000_000), (200, 31_000_000)]);
    let of = |stalls: Stalls| (stalls.count, stalls.longest_ms);
    assert_eq!(of(watch.since(0)), (2, 31.0));
    assert_eq!(of(watch.since(101)), (1, 31.0));
    assert_eq!(watch.since(201), Stalls::default());
    // Not those of before its own start.
    let own = watch.stalls();
    assert_eq!(of(own), (1, 31.0));
    assert!(own.steal_ms >= 0.0);
}

#[test]
fn all_watches_of_a_process_look_through_the_same_threads() {
    let watches = [(); 2].map(|()| StallWatch::start().expect("threads"));
    assert!(Arc::ptr_eq(&watches[0].threads, &watches[1].threads));
    assert!(watches[1].start_ns >= watches[0].start_ns);
}

#[test]
fn what_is_overslept_by_more_than_five_milliseconds_is_a_stall() {
    const MS: u64 = 1_000_000;
    // How late each wake-up is, on a clock that begins at one second.
    let late_ns = [0, 5 * MS, 7 * MS, MS / 2, 31 * MS, 0, 0];
    let (clock_ns, wakes) = (Cell::new(1000 * MS), Cell::new(0));
    let (seen, stop) = (Mutex::default(), AtomicBool::new(false));
    let sleep_until = |until_ns: u64| {
        assert!(until_ns > clock_ns.get(), "it sleeps each time");
        clock_ns.set(until_ns + late_ns[wakes.get()]);
        wakes.set(wakes.get() + 1);
        stop.store(wakes.get() == late_ns.len(), Ordering::Relaxed);
    };
    look(&seen, &stop, || clock_ns.get(), sleep_until);
    assert_eq!(wakes.get(), late_ns.len());
    // The next period begins after a stall, which counts once.
    let seen = seen.into_inner().expect("not poisoned");
    let expected = [(1015 * MS, 7 * MS), (1048 * MS + MS / 2, 31 * MS)];
    assert_eq!(seen, expected);
}

#[test]
fn a_byte_that_the_kernel_keeps_is_a_stall() {
    const MS: u64 = 1_000_000;
    let take_ms = [1, 50, 51, 2000];
    let (clock_ns, sent) = (Cell::new(1000 * MS), Cell::new(0));
    let (seen, stop) = (Mutex::default(), AtomicBool::new(false));
    let sleep_until = |until_ns: u64| clock_ns.set(until_ns.max(clock_ns.get()));
    let pass_byte = || {
        clock_ns.set(clock_ns.get() + take_ms[sent.get()] * MS);
        sent.set(sent.get() + 1);
        stop.store(sent.get() == take_ms.len(), Ordering::Relaxed);
        true
    };
    send_bytes(&seen, &stop, (|| clock_ns.get(), sleep_until), pass_byte);
    let expected = [(1111 * MS, 51 * MS), (3111 * MS, 2000 * MS)];
    assert_eq!(*lock(&seen), expected);
    // One that the kernel has taken away is not waited for.
    send_bytes(&seen, &AtomicBool::new(false), (|| 0, |_| ()), || false);

    let threads = Watching::default();
    lock(&threads.terminal).extend(expected);
    let watch = StallWatch::of(Arc::new(threads));
    let all = watch.since(0);
    assert_eq!((all.count, all.longest_ms, all.spoil()), (2, 2000.0, true));
    assert!(watch.stalled(1100 * MS, 1101 * MS) && !watch.stalled(0, 1059 * MS));
    // No core was gone.
    assert_eq!(watch.spans_since(0).first(), None);
}

#[test]
fn only_long_stalls_spoil_a_run() {
    let stalls = |count, longest_ms| Stalls {
        count,
        longest_ms,
        steal_ms: 1.0,
        ..Stalls::default()
    };
    assert!(!stalls(900, 14.9).spoil() && stalls(1, 15.0).spoil());
    let both = Stalls::together([stalls(2, 31.0), stalls(3, 7.0)].into_iter());
    assert_eq!((both.count, both.longest_ms, both.steal_ms), (5, 31.0, 2.0));
    let said = "the machine stalled 5 times, 31 ms at most";
    assert_eq!(both.to_string(), said);
}

#[test]
fn a_stall_lasts_from_its_begin_to_its_end() {
    let watch = watch(0, &[(100, 20)]);
    assert_eq!(watch.spans_since(100).first(), Some(&(80..100)));
    assert_eq!(watch.spans_since(101).first(), None);
    for (from_ns, to_ns, expected) in [(0, 79, false), (0, 80, true), (90, 95, true)] {
        assert_eq!(
            watch.stalled(from_ns, to_ns),
            expected,
            "{from_ns}..{to_ns}"
        );
    }
    assert!(watch.stalled(100, 200) && !watch.stalled(101, 200));
}

#[test]
fn long_stalls_are_kept_with_their_times() {
    const MS: u64 = 1_000_000;
    let seen = [(40, 31), (90, 14), (100, 15)];
    let watch = watch(50 * MS, &seen.map(|(end_ms, ms)| (end_ms * MS, ms * MS)));
    lock(&watch.threads.terminal).push((160 * MS, 60 * MS));
    // Neither the one before its own start nor the short one.
    assert_eq!(watch.long(), [85 * MS..100 * MS, 100 * MS..160 * MS]);
}

#[test]
fn a_stall_is_near_to_what_it_may_have_caused() {
    let stall = LongStall {
        from_s: 10.0,
        to_s: 10.5,
    };
    for (at_s, expected) in [
        (9.9, false),
        (10.0, true),
        (10.4, true),
        (12.5, true),
        (12.6, false),
        (300.0, false),
    ] {
        assert_eq!(stall.is_near(at_s, LATCHES_WITHIN_NS), expected, "{at_s} s");
    }
    assert!(stall.is_near(15.5, VIOLATES_WITHIN_NS) && !stall.is_near(15.6, VIOLATES_WITHIN_NS));
}

#[test]
fn who_saw_stalls_without_priority_says_so() {
    let watch = watch(0, &[(100, 31_000_000)]);
    assert!(!watch.since(0).without_priority);
    watch.threads.refused.store(true, Ordering::Relaxed);
    let said = "the machine stalled 1 times, 31 ms at most, seen without real-time priority: load counts, too";
    assert_eq!(watch.since(0).to_string(), said);
    let quiet = Stalls::default();
    let all = Stalls::together([quiet, watch.since(0), quiet].into_iter());
    assert!(all.without_priority);
    // As older programs have written it.
    let older = r#"{ "count": 2, "longest_ms": 7.0, "steal_ms": 0.5 }"#;
    let older: Stalls = serde_json::from_str(older).expect("JSON");
    assert_eq!((older.count, older.without_priority), (2, false));
}
