//! The channel's atomic word under loom, which runs every interleaving of two threads and every
//! order in which memory may show them:
//! `RUSTFLAGS="--cfg loom" cargo test -p coordination --release --test loom_protocol`.
#![cfg(loom)]

use std::sync::Arc;

use coordination::protocol::{
    Change, End, FlagId, Party, Position, Protocol, ProtocolModel, SetError, Side, channel,
    channel_at,
};
use loom::cell::UnsafeCell;
use loom::thread;

fn compile(build: impl FnOnce(&mut ProtocolModel)) -> Arc<Protocol> {
    let mut model = ProtocolModel::new("p", "a", "b");
    build(&mut model);
    Arc::new(model.compile().expect("the model is right"))
}

fn flag(protocol: &Protocol, name: &str) -> FlagId {
    protocol.flag(name).expect("the protocol has it")
}

fn explore(scenario: impl Fn() + Sync + Send + 'static) {
    loom::model::Builder::new().check(scenario);
}

/// Polls until there is something.
fn wait(end: &mut End) -> Change {
    loop {
        if let Some(change) = end.poll() {
            return change;
        }
        thread::yield_now();
    }
}

/// Question and answer, two runs: each side reads each flag of the other exactly once.
#[test]
fn two_runs_of_question_and_answer() {
    let protocol = compile(|model| {
        model.array("only", &[("ask", "a"), ("answer", "b")]);
    });
    explore(move || {
        let (ask, answer) = (flag(&protocol, "ask"), flag(&protocol, "answer"));
        let (mut a, mut b) = channel(&protocol);
        let other = thread::spawn(move || {
            for _ in 0..2 {
                assert_eq!(wait(&mut b), Change::Flag(ask));
                assert_eq!(b.poll(), None);
                b.set(answer).unwrap();
            }
            b
        });
        for run in 0..2 {
            assert_eq!(a.run(), run);
            a.set(ask).unwrap();
            assert_eq!(wait(&mut a), Change::Flag(answer));
            assert_eq!(a.poll(), None);
        }
        let b = other.join().unwrap();
        assert_eq!((a.level(0), a.level(0).run), (b.level(0), 2));
    });
}

/// One party ends a run and begins the next; the other polls whenever it likes and, though runs
/// take different paths, misses and repeats nothing.
#[test]
fn a_run_that_ends_and_begins_between_two_polls_loses_nothing() {
    let protocol = compile(|model| {
        model.array("x", &[("x", "a")]).array("y", &[("y", "a")]);
        model.start("x").start("y");
    });
    explore(move || {
        let wanted = ["x", "y", "x"].map(|name| flag(&protocol, name));
        let (mut a, mut b) = channel(&protocol);
        let other = thread::spawn(move || {
            for flag in wanted {
                loop {
                    match a.set(flag) {
                        Ok(()) => break,
                        Err(error) => assert_eq!(error, SetError::Complete),
                    }
                    thread::yield_now();
                }
            }
        });
        for flag in wanted {
            assert_eq!(wait(&mut b), Change::Flag(flag));
        }
        other.join().unwrap();
        assert_eq!(b.poll(), None);
    });
}

/// A party that tries to set before it has read, and reads while it tries, stays in order.
#[test]
fn setting_early_is_refused_and_harmless() {
    let protocol = compile(|model| {
        model.array("only", &[("first", "a"), ("second", "b"), ("third", "a")]);
    });
    explore(move || {
        let [first, second, third] = ["first", "second", "third"].map(|n| flag(&protocol, n));
        let (mut a, mut b) = channel(&protocol);
        let other = thread::spawn(move || {
            let early = b.set(second).unwrap_err();
            let expected = [
                SetError::Unread { unread: first },
                SetError::OutOfOrder {
                    flag: second,
                    at: Position::START,
                },
            ];
            assert!(expected.contains(&early));
            assert_eq!(wait(&mut b), Change::Flag(first));
            b.set(second).unwrap();
            assert_eq!(wait(&mut b), Change::Flag(third));
            assert_eq!(b.poll(), None);
            assert_eq!(b.run(), 1);
        });
        a.set(first).unwrap();
        while let Err(error) = a.set(third) {
            match error {
                SetError::OutOfOrder { .. } => thread::yield_now(),
                SetError::Unread { unread } => assert_eq!(a.poll(), Some(Change::Flag(unread))),
                other => panic!("{other}"),
            }
        }
        other.join().unwrap();
    });
}

/// The keeper aborts while the other sets two flags: what the abort reports is exactly what was
/// set, a flag set later is refused, and the other reads one abort.
#[test]
fn an_abort_knows_what_it_cuts_off() {
    let protocol = compile(|model| {
        model.array("only", &[("one", "a"), ("two", "a"), ("three", "b")]);
        model.keeper("b");
    });
    explore(move || {
        let (one, two) = (flag(&protocol, "one"), flag(&protocol, "two"));
        let after = |flags: u16| protocol.position(0, flags).unwrap();
        let (start, after_one, after_two) = (after(0), after(1), after(2));
        let (mut a, mut b) = channel(&protocol);
        let other = thread::spawn(move || {
            let set = [a.set(one), a.set(two)];
            (a, set)
        });
        let cut = b.abort().unwrap();
        let (mut a, set) = other.join().unwrap();
        if cut == start {
            // Nothing to abort yet: both flags stand, and the keeper still reads them.
            assert_eq!(set, [Ok(()), Ok(())]);
            assert_eq!(b.poll(), Some(Change::Flag(one)));
            assert_eq!(b.poll(), Some(Change::Flag(two)));
            assert_eq!(a.poll(), None);
        } else if cut == after_one {
            assert_eq!(set, [Ok(()), Err(SetError::Aborted)]);
            assert_eq!((a.poll(), a.poll()), (Some(Change::Aborted), None));
            assert_eq!(a.set(one), Ok(()));
            assert_eq!(b.poll(), Some(Change::Flag(one)));
        } else {
            assert_eq!(cut, after_two);
            assert_eq!(set, [Ok(()), Ok(())]);
            assert_eq!((a.poll(), a.poll()), (Some(Change::Aborted), None));
        }
        assert_eq!(b.poll(), None);
    });
}

/// The keeper aborts while the other sets the last flag: the abort says whether that was in time,
/// the other reads the abort, and both go on in the same run.
#[test]
fn an_abort_races_with_the_last_flag() {
    let protocol = compile(|model| {
        model.array("only", &[("one", "a"), ("two", "b")]);
        model.keeper("a");
    });
    explore(move || {
        let (one, two) = (flag(&protocol, "one"), flag(&protocol, "two"));
        let (mut a, mut b) = channel(&protocol);
        a.set(one).unwrap();
        assert_eq!(b.poll(), Some(Change::Flag(one)));
        let other = thread::spawn(move || {
            let set = b.set(two);
            (b, set)
        });
        let cut = protocol.progress(a.abort().unwrap());
        let (mut b, set) = other.join().unwrap();
        match cut {
            1 => assert_eq!(set, Err(SetError::Aborted)),
            2 => assert_eq!(set, Ok(())),
            flags => panic!("aborted after {flags} flags"),
        }
        assert_eq!((b.poll(), b.poll()), (Some(Change::Aborted), None));
        assert_eq!((a.run(), a.poll()), (1, None));
        a.set(one).unwrap();
        assert_eq!(b.poll(), Some(Change::Flag(one)));
    });
}

/// The keeper aborts while the other reads the last flag: if it was read, the run has ended and there
/// is nothing to abort.
#[test]
fn an_abort_races_with_the_reading_of_the_end() {
    let protocol = compile(|model| {
        model.array("only", &[("one", "a")]);
        model.keeper("a");
    });
    explore(move || {
        let one = flag(&protocol, "one");
        let (mut a, mut b) = channel(&protocol);
        a.set(one).unwrap();
        let other = thread::spawn(move || {
            let changes = [b.poll(), b.poll(), b.poll()];
            (b, changes)
        });
        let cut = a.abort().unwrap();
        let (mut b, changes) = other.join().unwrap();
        let rest = b.poll();
        let all: Vec<_> = changes.into_iter().chain([rest]).flatten().collect();
        if cut == Position::START {
            assert_eq!(all, [Change::Flag(one)], "it was read to the end");
        } else {
            let read_first = [Change::Flag(one), Change::Aborted];
            assert!(all == [Change::Aborted] || all == read_first, "{all:?}");
        }
        assert_eq!(a.set(one), Ok(()));
        assert_eq!(b.poll(), Some(Change::Flag(one)));
        assert_eq!(b.poll(), None);
        assert_eq!((a.run(), b.run()), (1, 2), "b has read the end");
        assert_eq!((a.poll(), a.run()), (None, 2));
    });
}

/// What was written before a flag is there for whoever has read the flag, in both directions.
#[test]
fn flags_publish_what_was_written_before() {
    let protocol = compile(|model| {
        model.array("only", &[("ask", "a"), ("answer", "b")]);
    });
    explore(move || {
        let (ask, answer) = (flag(&protocol, "ask"), flag(&protocol, "answer"));
        let (mut a, mut b) = channel(&protocol);
        let cell = Arc::new(UnsafeCell::new(0));
        let theirs = Arc::clone(&cell);
        let other = thread::spawn(move || {
            for _ in 0..2 {
                wait(&mut b);
                // SAFETY: between question and answer the cell is this thread's; loom checks it.
                theirs.with_mut(|value| unsafe { *value += 1 });
                b.set(answer).unwrap();
            }
        });
        for expected in [0, 2] {
            // SAFETY: before the question and after the answer the cell is this thread's.
            cell.with(|value| assert_eq!(unsafe { *value }, expected));
            // SAFETY: as above.
            cell.with_mut(|value| unsafe { *value += 1 });
            a.set(ask).unwrap();
            wait(&mut a);
        }
        other.join().unwrap();
        // SAFETY: the other thread has ended.
        cell.with(|value| assert_eq!(unsafe { *value }, 4));
    });
}

/// The last run that has a number ends like any other, and nothing begins after it.
#[test]
fn the_last_run_stays_complete() {
    let protocol = compile(|model| {
        model.array("only", &[("one", "a")]);
    });
    explore(move || {
        let one = flag(&protocol, "one");
        let (mut a, mut b) = channel_at(&protocol, u32::MAX);
        let other = thread::spawn(move || {
            assert_eq!(wait(&mut b), Change::Flag(one));
            assert_eq!(b.poll(), None);
            b
        });
        a.set(one).unwrap();
        assert_eq!(a.set(one), Err(SetError::Exhausted));
        let b = other.join().unwrap();
        assert_eq!(b.party(), Party::Second);
        assert_eq!(a.set(one), Err(SetError::Exhausted));
    });
}

/// Whoever finds the other end gone then finds its last flag.
#[test]
fn the_last_flag_of_an_end_that_is_gone_is_not_missed() {
    let protocol = compile(|model| {
        model.array("only", &[("one", "a"), ("two", "a"), ("three", "b")]);
    });
    explore(move || {
        let (one, two) = (flag(&protocol, "one"), flag(&protocol, "two"));
        let (mut a, mut b) = channel(&protocol);
        let other = thread::spawn(move || {
            a.set(one).unwrap();
            a.set(two).unwrap();
        });
        while !b.is_abandoned() {
            thread::yield_now();
        }
        assert_eq!(b.poll(), Some(Change::Flag(one)));
        assert_eq!(b.poll(), Some(Change::Flag(two)));
        assert_eq!(b.poll(), None);
        other.join().unwrap();
    });
}
