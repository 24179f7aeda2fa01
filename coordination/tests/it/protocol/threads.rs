//! Two real threads on one channel, as fast as they can.

use std::cell::UnsafeCell;
use std::collections::HashMap;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use coordination::protocol::{
    Change, End, FlagId, Position, ProtocolModel, SetError, Side, channel,
};

use super::common::{crossing, flag};

/// Where others have the cores, each step of one waits for a turn of the other.
const RUNS: u32 = 5_000;
const PATIENCE: Duration = Duration::from_secs(240);

/// Pseudo-random numbers (xorshift) that leave the threads independent of each other.
struct Random(u64);

impl Random {
    fn one_in(&mut self, limit: u64) -> bool {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0.is_multiple_of(limit)
    }
}

struct Outcome {
    /// What the party set, with its run.
    set: Vec<(u32, FlagId)>,
    read: Vec<Change>,
    /// Which runs the party aborted, and how far they had come.
    aborted: HashMap<u32, Position>,
}

/// Sets one of the flags that are next whenever it is this party's turn, until run `RUNS`.
fn play(mut end: End, seed: u64, aborts: bool) -> Outcome {
    let mut random = Random(seed);
    let mut outcome = Outcome {
        set: Vec::new(),
        read: Vec::new(),
        aborted: HashMap::new(),
    };
    let begin = Instant::now();
    loop {
        assert!(begin.elapsed() < PATIENCE, "stuck in run {}", end.run());
        let mut idle = true;
        while let Some(change) = end.poll() {
            outcome.read.push(change);
            idle = false;
        }
        if aborts && random.one_in(50) {
            let cut = end.abort().expect("this party is the keeper");
            if cut != Position::START {
                outcome.aborted.insert(end.run() - 1, cut);
            }
        }
        // This party may know the run to be complete, and the other have read that by now.
        let at = end.level(0);
        if at.run >= RUNS {
            return outcome;
        }
        let at = end.protocol().position(at.path, at.progress);
        let next = end
            .protocol()
            .next(at.expect("it is a level of the protocol"));
        let next: Vec<FlagId> = next.map(|(flag, _)| flag).collect();
        let choice = usize::from(random.one_in(3)).min(next.len().saturating_sub(1));
        if let Some(&flag) = next.get(choice) {
            match end.set(flag) {
                Ok(()) => {
                    outcome.set.push((end.run(), flag));
                    idle = false;
                }
                Err(
                    SetError::NotYours { .. }
                    | SetError::Unread { .. }
                    | SetError::Complete
                    | SetError::Aborted,
                ) => {}
                Err(error) => panic!("{}", error.describe(end.protocol())),
            }
        }
        if idle {
            thread::yield_now();
        }
    }
}

fn play_both(aborts: bool) -> (Outcome, Outcome) {
    let (robot, mediator) = channel(&crossing());
    thread::scope(|scope| {
        let robot = scope.spawn(move || play(robot, 1, false));
        let mediator = scope.spawn(move || play(mediator, 2, aborts));
        (robot.join().unwrap(), mediator.join().unwrap())
    })
}

#[test]
fn nothing_is_missed_repeated_or_reordered() {
    let (robot, mediator) = play_both(false);
    for (set, read) in [(&robot.set, &mediator.read), (&mediator.set, &robot.read)] {
        let set: Vec<_> = set.iter().map(|&(_, flag)| Change::Flag(flag)).collect();
        assert!(set.len() >= RUNS as usize);
        assert_eq!(*read, set);
    }
}

/// The flags that stand in each run are exactly those on the path that it took, up to its end or to
/// where the keeper says that it was cut off.
#[test]
fn aborts_cut_runs_off_where_they_say() {
    let protocol = crossing();
    let (robot, mediator) = play_both(true);
    assert!(mediator.aborted.len() > 100, "{}", mediator.aborted.len());
    let mut set: HashMap<u32, Vec<FlagId>> = HashMap::new();
    for &(run, flag) in robot.set.iter().chain(&mediator.set) {
        set.entry(run).or_default().push(flag);
    }
    let refused = flag(&protocol, "refused");
    for run in 0..RUNS {
        let mut set = set.remove(&run).unwrap_or_default();
        set.sort_unstable();
        let end = match mediator.aborted.get(&run) {
            Some(&cut) => cut,
            None if set.contains(&refused) => protocol.position(1, 2).unwrap(),
            None => protocol.position(0, 4).unwrap(),
        };
        let mut expected: Vec<_> = protocol.set_flags(end).map(|(flag, _)| flag).collect();
        expected.sort_unstable();
        assert_eq!(set, expected, "run {run}");
    }
    let aborts_read = robot
        .read
        .iter()
        .filter(|&&read| read == Change::Aborted)
        .count();
    assert!(aborts_read > 0 && aborts_read <= mediator.aborted.len());
}

/// A value without any lock or atomic, which belongs to whoever's turn it is.
struct Handed(UnsafeCell<u64>);

// SAFETY: the protocol of the test hands the value from one thread to the other.
unsafe impl Sync for Handed {}

/// For a thread sanitizer: what was written before a flag is seen by whoever has read it.
#[test]
fn flags_hand_memory_over() {
    let mut model = ProtocolModel::new("p", "a", "b");
    model.array("all", &[("there", "a"), ("back", "b")]);
    let protocol = Arc::new(model.compile().unwrap());
    let (there, back) = (flag(&protocol, "there"), flag(&protocol, "back"));
    let (mut a, mut b) = channel(&protocol);
    let value = Handed(UnsafeCell::new(0));
    let wait = |end: &mut End| {
        let begin = Instant::now();
        while end.poll().is_none() {
            assert!(begin.elapsed() < PATIENCE, "stuck in run {}", end.run());
            thread::yield_now();
        }
    };
    let add = |value: &Handed| {
        // SAFETY: called by the thread whose turn it is, between reading a flag and setting one.
        unsafe { *value.0.get() += 1 }
    };
    thread::scope(|scope| {
        let value = &value;
        scope.spawn(move || {
            for _ in 0..RUNS {
                wait(&mut b);
                add(value);
                b.set(back).unwrap();
            }
        });
        for _ in 0..RUNS {
            add(value);
            a.set(there).unwrap();
            wait(&mut a);
        }
    });
    assert_eq!(value.0.into_inner(), 2 * u64::from(RUNS));
}
