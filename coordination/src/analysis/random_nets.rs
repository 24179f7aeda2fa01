//! Random nets that the analysis lets pass never block when they run with their protocols, whatever
//! the order and the budgets; and those that it refuses for a deadlock are among the same nets.

use std::sync::Arc;

use super::closed::Closed;
use super::explored::Explored;
use crate::analysis::{Limits, Marking, Proof, Reason, Use, check, place_invariants, properties};
use crate::binding::NetBinding;
use crate::event::EventTable;
use crate::petri::{Binding, Budget, NetModel, PlaceKind};
use crate::protocol::{End, Party, Protocol, ProtocolModel, Side, channel};

/// By robot.
type Protocols = Vec<(String, Arc<Protocol>)>;

struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 20) as usize % limit
    }

    fn shuffled(&mut self, count: usize) -> Vec<usize> {
        let mut all: Vec<_> = (0..count).collect();
        for index in (1..count).rev() {
            all.swap(index, self.below(index + 1));
        }
        all
    }
}

/// Robots that each take some areas one after another, in an order of their own, are told at some
/// point that they may go, and give the areas back in another order.
fn draw(random: &mut Random) -> (NetModel, Protocols, Vec<String>) {
    let mut net = NetModel::new("drawn");
    let areas = 2 + random.below(2);
    let free: Vec<_> = (0..areas).map(|area| format!("free{area}")).collect();
    for free in &free {
        net.place(free).mark(free);
    }
    let (mut protocols, mut transitions) = (Vec::new(), Vec::new());
    for number in 0..2 + random.below(2) {
        let robot = format!("r{number}");
        let mut model = ProtocolModel::new(&robot, &robot, "mediator");
        let (asks, may, gone) = ("request", "granted", "released");
        model.array("all", &[(asks, &robot), (may, "mediator"), (gone, &robot)]);
        protocols.push((robot.clone(), Arc::new(model.compile().unwrap())));
        let place = |what: &str| format!("{robot} {what}");
        net.source(place(asks), Binding::flag(&robot, asks));
        net.sink(place(may), Binding::flag(&robot, may));
        net.source(place(gone), Binding::flag(&robot, gone));

        let wanted: Vec<_> = random.shuffled(areas).into_iter().take(2).collect();
        let told_at = random.below(wanted.len());
        let mut steps: Vec<(Vec<String>, Vec<String>)> = Vec::new();
        for (index, &area) in wanted.iter().enumerate() {
            let mut outputs = Vec::new();
            if index == told_at {
                outputs.push(place(may));
            }
            steps.push((vec![free[area].clone()], outputs));
        }
        let back = random.shuffled(wanted.len());
        for (index, &which) in back.iter().enumerate() {
            let inputs = match index {
                0 => vec![place(gone)],
                _ => Vec::new(),
            };
            steps.push((inputs, vec![free[wanted[which]].clone()]));
        }
        let last = steps.len() - 1;
        for (index, (mut inputs, mut outputs)) in steps.into_iter().enumerate() {
            inputs.push(match index {
                0 => place(asks),
                _ => place(&format!("at{}", index - 1)),
            });
            if index < last {
                let next = place(&format!("at{index}"));
                net.place(&next);
                outputs.push(next);
            }
            transitions.push((place(&format!("step{index}")), inputs, outputs));
        }
    }
    // In another order, as the one behind the last that fired comes next.
    for index in random.shuffled(transitions.len()) {
        let (name, inputs, outputs) = &transitions[index];
        let [inputs, outputs] =
            [inputs, outputs].map(|list| list.iter().map(|name| &**name).collect::<Vec<_>>());
        net.transition(name, &inputs, &outputs);
    }
    let all: Vec<_> = free.iter().map(|name| &**name).collect();
    net.end("idle", &all);
    (net, protocols, free)
}

/// The robot's next flag, if it is its turn; one that rests begins no new run.
fn act(robot: &mut End, protocol: &Protocol, rests: bool) -> bool {
    while robot.poll().is_some() {}
    let position = robot.position();
    if protocol.turn(position) != Some(Party::First) || rests && protocol.progress(position) == 0 {
        return false;
    }
    let (flag, _) = protocol.next(position).next().expect("somebody's turn");
    robot.set(flag).is_ok()
}

/// Runs it at random, and then to its end; or what came in between.
fn run(
    (net, proof): (&NetModel, Option<&Proof>),
    protocols: &Protocols,
    end: &[String],
    seed: u64,
) -> Result<(), String> {
    let mut random = Random(seed);
    let compiled = net.compile(&mut EventTable::new()).unwrap();
    let (mut robots, mut sides) = (Vec::new(), Vec::new());
    for (name, protocol) in protocols {
        let (robot, mediator) = channel(protocol);
        robots.push(robot);
        sides.push((&**name, mediator));
    }
    let mut binding = match proof {
        Some(proof) => NetBinding::new(proof, &compiled, sides).unwrap(),
        None => NetBinding::unproved(&compiled, sides).unwrap(),
    };
    let mut since_change = 0;
    for _ in 0..600 {
        let mut acted = false;
        for (robot, (_, protocol)) in robots.iter_mut().zip(protocols) {
            acted |= random.below(2) == 0 && act(robot, protocol, false);
        }
        let budget = Budget {
            firings: random.below(3) as u32,
            rounds: 1 + random.below(2) as u32,
        };
        let progress = binding.step(budget, |_| true);
        if proof.is_some_and(|proof| !binding.is_proved_by(proof)) {
            return Err("it is where the analysis has not looked".to_owned());
        }
        since_change = match acted || progress.evaluation.fired > 0 || progress.set > 0 {
            true => 0,
            false => since_change + 1,
        };
        if since_change >= 60 {
            return Err("nothing happens any more".to_owned());
        }
    }
    for _ in 0..60 {
        for (robot, (_, protocol)) in robots.iter_mut().zip(protocols) {
            act(robot, protocol, true);
        }
        binding.step(Budget::default(), |_| true);
    }
    for (robot, (name, protocol)) in robots.iter_mut().zip(protocols) {
        while robot.poll().is_some() {}
        if protocol.progress(robot.position()) != 0 || robot.run() == 0 {
            return Err(format!("{name} does not come through"));
        }
    }
    let marking: Vec<_> = { binding.executor().marking() }
        .map(|place| compiled.place_name(place))
        .collect();
    if marking != end {
        return Err(format!("it ends with {marking:?} marked"));
    }
    Ok(())
}

#[test]
fn what_passes_never_blocks() {
    let mut random = Random(0x1234_5678_9abc_def1);
    let (mut passed, mut refused, mut blocked) = (0, 0, 0);
    for round in 0..150 {
        let (net, protocols, end) = draw(&mut random);
        let uses: Vec<_> = protocols
            .iter()
            .map(|(name, protocol)| Use::new(name, Arc::clone(protocol), Party::Second))
            .collect();
        let mut seeds = 77 * round + 1..77 * round + 6;
        let run = |proof, seed| run((&net, proof), &protocols, &end, seed);
        match check(&net, &uses, &Limits::default()) {
            Ok(proof) => {
                passed += 1;
                for seed in seeds {
                    assert_eq!(run(Some(&proof), seed), Ok(()), "net {round}, seed {seed}");
                }
            }
            Err(refusal) => {
                let is_deadlock = matches!(&*refusal.reason, Reason::Deadlock { .. });
                refused += usize::from(is_deadlock);
                blocked += usize::from(is_deadlock && seeds.any(|seed| run(None, seed).is_err()));
            }
        }
    }
    assert!(passed > 20, "only {passed} of 150 passed");
    // Else the runs would show nothing.
    assert!(
        refused > 20,
        "only {refused} of 150 were refused for a deadlock"
    );
    assert!(
        blocked * 2 > refused,
        "only {blocked} of {refused} refused nets blocked"
    );
}

/// What invariants say holds in every state that is looked at, and what follows from them is so.
#[test]
fn invariants_hold_in_every_state() {
    let mut random = Random(0x0123_4567_89ab_cdef);
    let (mut sums, mut exclusions) = (0, 0);
    for _ in 0..300 {
        let (mut net, protocols, _) = draw(&mut random);
        let internal = |net: &NetModel| -> Vec<String> {
            let internal = net
                .places()
                .filter(|place| place.kind == PlaceKind::Internal);
            internal.map(|place| place.name.to_owned()).collect()
        };
        let places = internal(&net);
        let [one, other] = [0, 1].map(|_| &places[random.below(places.len())]);
        if one != other {
            net.exclusion("both", &[one, other]);
        }
        let invariants = place_invariants(&net);
        assert!(invariants.is_complete);
        let uses: Vec<Use> = { protocols.iter() }
            .map(|(name, protocol)| Use::new(name, Arc::clone(protocol), Party::Second))
            .collect();
        let limits = Limits::default();
        let closed = Closed::of_any(&net, &uses, &limits).unwrap();
        let Ok(explored) = Explored::listed(closed, &limits) else {
            continue;
        };
        let number = |place: &str| explored.closed.place_number(place).unwrap();
        for invariant in &invariants.found {
            sums += 1;
            for state in 0..explored.store.len() as u32 {
                let state = explored.store.get(state);
                let is_marked =
                    |place: &str| explored.closed.layout.is_marked(state, number(place));
                let marked = { invariant.places.iter() }
                    .filter(|(place, _)| is_marked(place))
                    .map(|&(_, weight)| u64::from(weight));
                assert_eq!(marked.sum::<u64>(), invariant.tokens, "{invariant}");
            }
        }
        if let Some(exclusion) = net.exclusions().next()
            && invariants.excludes(&exclusion.places)
        {
            exclusions += 1;
            let [one, other] = exclusion.places[..] else {
                panic!("there are two");
            };
            let both = [Marking::new(&[one, other], &[])];
            let found = properties(&net, &uses, &limits, &both).unwrap();
            assert_eq!(found.by_invariants.exclusions, ["both"]);
            assert_eq!(found.reached, [None]);
        }
    }
    assert!(
        sums > 500 && exclusions > 20,
        "{sums} sums, {exclusions} exclusions"
    );
}
