//! Random protocols, random parties, a network that loses, repeats and reorders.

use std::sync::Arc;

use coordination::protocol::{
    AbortError, Change, FlagId, Level, Merged, Party, Position, Protocol, Replica, SetError, Side,
    channel,
};
use proptest::prelude::*;

use super::common::any_protocol;

#[derive(Clone, Copy, Debug)]
enum Step {
    /// The side tries to set a flag: one that is next if it is its turn, or any.
    SetNext(usize, usize),
    SetAny(usize, usize),
    Poll(usize),
    /// The side sends its level.
    Send(usize),
    /// The side receives any of the levels that the other ever sent.
    Deliver(usize, usize),
    Abort(usize),
}

fn any_step(aborts: bool) -> impl Strategy<Value = Step> {
    let side = || 0..2_usize;
    prop_oneof![
        8 => (side(), any::<usize>()).prop_map(|(s, n)| Step::SetNext(s, n)),
        1 => (side(), any::<usize>()).prop_map(|(s, n)| Step::SetAny(s, n)),
        6 => side().prop_map(Step::Poll),
        5 => side().prop_map(Step::Send),
        8 => (side(), any::<usize>()).prop_map(|(s, n)| Step::Deliver(s, n)),
        u32::from(aborts) => side().prop_map(Step::Abort),
    ]
}

/// What one party set, or read of the other, by run.
type Log = Vec<(u32, FlagId)>;

/// What a side answers: to a poll, to a flag set, to an abort.
type Answer = (
    Option<Change>,
    Result<(), SetError>,
    Result<Position, AbortError>,
);

struct Network {
    protocol: Arc<Protocol>,
    sides: [Replica; 2],
    sent: [Vec<Level>; 2],
    set: [Log; 2],
    read: [Log; 2],
    aborts_read: [usize; 2],
}

impl Network {
    fn new(protocol: &Arc<Protocol>) -> Self {
        let side = |party| Replica::new(protocol, 3, party, 5);
        Self {
            protocol: Arc::clone(protocol),
            sides: [side(Party::First), side(Party::Second)],
            sent: Default::default(),
            set: Default::default(),
            read: Default::default(),
            aborts_read: [0; 2],
        }
    }

    fn choose(&self, side: usize, step: Step) -> FlagId {
        let all = self.protocol.flags().count();
        match step {
            Step::SetNext(_, number) => {
                let next: Vec<_> = self.protocol.next(self.sides[side].position()).collect();
                let mine = next.get(number % next.len().max(1)).map(|&(flag, _)| flag);
                mine.unwrap_or(FlagId(0))
            }
            Step::SetAny(_, number) => FlagId((number % (all + 1)) as u16),
            _ => unreachable!("only these set flags"),
        }
    }

    fn step(&mut self, step: Step) {
        match step {
            Step::SetNext(side, _) | Step::SetAny(side, _) => {
                let flag = self.choose(side, step);
                let before = (self.sides[side].level(), self.sides[side].peek());
                match self.sides[side].set(flag) {
                    Ok(()) => self.set[side].push((self.sides[side].run(), flag)),
                    Err(_) => {
                        let after = (self.sides[side].level(), self.sides[side].peek());
                        assert_eq!(after, before, "an error changes nothing");
                    }
                }
            }
            Step::Poll(side) => self.poll(side),
            Step::Send(side) => self.sent[side].push(self.sides[side].level()),
            Step::Deliver(side, number) => {
                let sent = &self.sent[1 - side];
                if let Some(&level) = sent.get(number % sent.len().max(1)) {
                    self.sides[side]
                        .merge(level)
                        .expect("both sides are honest");
                }
            }
            Step::Abort(side) => {
                let _ = self.sides[side].abort();
            }
        }
    }

    fn poll(&mut self, side: usize) {
        // Reading the last flag begins the next run.
        let run = self.sides[side].run();
        match self.sides[side].poll() {
            Some(Change::Flag(flag)) => self.read[side].push((run, flag)),
            Some(Change::Aborted) => self.aborts_read[side] += 1,
            None => {}
        }
    }

    /// A network that works again, for a while.
    fn settle(&mut self) {
        for _ in 0..4 {
            for side in [0, 1] {
                let level = self.sides[1 - side].level();
                self.sides[side]
                    .merge(level)
                    .expect("both sides are honest");
                while self.sides[side].peek().is_some() {
                    self.poll(side);
                }
            }
        }
    }
}

fn of_run(log: &Log, run: u32) -> Vec<FlagId> {
    let flags = log.iter().filter(|(of, _)| *of == run);
    flags.map(|&(_, flag)| flag).collect()
}

proptest! {
    /// Whatever the network does, what was read is what was set, in order, none missing; and when it
    /// works again, both sides agree.
    #[test]
    fn replicas_converge(
        protocol in any_protocol(),
        steps in proptest::collection::vec(any_step(false), 0..200),
    ) {
        let mut network = Network::new(&protocol);
        for step in steps {
            network.step(step);
            for side in [0, 1] {
                prop_assert!(network.set[1 - side].starts_with(&network.read[side]));
            }
        }
        network.settle();
        prop_assert_eq!(network.sides[0].level(), network.sides[1].level());
        for side in [0, 1] {
            prop_assert_eq!(&network.set[1 - side], &network.read[side]);
        }
    }

    /// The same with a keeper that aborts: within each run what was read is a beginning of what was
    /// set, a run is cut short only by an abort, and both sides agree in the end.
    #[test]
    fn replicas_converge_although_runs_are_aborted(
        protocol in any_protocol(),
        steps in proptest::collection::vec(any_step(true), 0..200),
    ) {
        let mut network = Network::new(&protocol);
        for step in steps {
            network.step(step);
        }
        network.settle();
        let [a, b] = &network.sides;
        prop_assert_eq!((a.run(), a.position()), (b.run(), b.position()));
        for side in [0, 1] {
            let other = 1 - side;
            prop_assert!(network.read[side].is_sorted_by_key(|&(run, _)| run));
            let mut cut = 0;
            for run in 5..=network.sides[side].run() {
                let set = of_run(&network.set[other], run);
                let read = of_run(&network.read[side], run);
                prop_assert!(set.starts_with(&read), "run {}: {:?} of {:?}", run, read, set);
                cut += usize::from(read.len() < set.len());
            }
            let keeper = protocol.keeper().map(Party::index) == Some(side);
            prop_assert!(cut == 0 || keeper || network.aborts_read[side] > 0);
            prop_assert!(!keeper || network.aborts_read[side] == 0);
        }
    }

    /// A level that is nonsense, or another's, is refused and changes nothing, or claims only flags
    /// that the other side may set.
    #[test]
    fn no_level_sets_a_flag_of_ones_own(
        protocol in any_protocol(),
        steps in proptest::collection::vec(any_step(true), 0..60),
        levels in proptest::collection::vec(
            (2..5_u16, 0..9_u32, 0..12_u16, 0..12_u16, any::<bool>()), 1..40),
    ) {
        let mut network = Network::new(&protocol);
        for step in steps {
            network.step(step);
        }
        for mut side in network.sides {
            for &(id, run, path, progress, after_abort) in &levels {
                let level = Level { protocol: id, run, path, progress, after_abort };
                let (before, was) = (side.level(), side.peek());
                match side.merge(level) {
                    Err(_) | Ok(Merged::Nothing) => {
                        prop_assert_eq!((side.level(), side.peek()), (before, was));
                    }
                    Ok(Merged::Risen | Merged::Aborted) => {
                        prop_assert_eq!(side.level().run, run);
                        let from = if before.run == run {
                            protocol.position(before.path, before.progress).unwrap()
                        } else {
                            Position::START
                        };
                        let mut at = from;
                        while let Some((flag, next)) = protocol.towards(at, side.position()) {
                            prop_assert_ne!(protocol.owner(flag), Some(side.party()));
                            at = next;
                        }
                        prop_assert_eq!(at, side.position());
                        prop_assert!((before.run, before.progress) <= (run, progress));
                    }
                }
            }
        }
    }

    /// A channel is a pair of replicas whose levels arrive at once: the same answers to everything.
    #[test]
    fn a_channel_agrees_with_replicas(
        protocol in any_protocol(),
        steps in proptest::collection::vec(any_step(true), 0..200),
    ) {
        let (first, second) = channel(&protocol);
        let mut ends = [first, second];
        let mut network = Network::new(&protocol);
        for step in steps {
            let (Step::SetNext(side, _)
            | Step::SetAny(side, _)
            | Step::Poll(side)
            | Step::Send(side)
            | Step::Deliver(side, _)
            | Step::Abort(side)) = step;
            let answers: [Answer; 2] = {
                let flag = matches!(step, Step::SetNext(..) | Step::SetAny(..))
                    .then(|| network.choose(side, step));
                let sides: [&mut dyn Side; 2] = [&mut ends[side], &mut network.sides[side]];
                sides.map(|side| match step {
                    Step::SetNext(..) | Step::SetAny(..) => {
                        (None, side.set(flag.unwrap()), Ok(Position::START))
                    }
                    Step::Poll(_) => (side.poll(), Ok(()), Ok(Position::START)),
                    Step::Abort(_) => (None, Ok(()), side.abort()),
                    Step::Send(_) | Step::Deliver(..) => (side.peek(), Ok(()), Ok(Position::START)),
                })
            };
            prop_assert_eq!(&answers[0], &answers[1]);
            let level = network.sides[side].level();
            network.sides[1 - side].merge(level).unwrap();
            let word = ends[0].level(3);
            prop_assert_eq!((word.run + 5, word.path, word.progress, word.after_abort),
                (level.run, level.path, level.progress, level.after_abort));
        }
    }
}
