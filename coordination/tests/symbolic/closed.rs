//! Nets with their protocols looked at once more, from what the documentation of the analysis says, with sets and maps and
//! nothing of the analysis itself: the same verdicts, numbers of states and steps, and lengths of traces.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use coordination::analysis::{Limits, Use};
use coordination::petri::{Binding, NetModel, PlaceKind};
use coordination::protocol::{ABORTED, Position};

use super::drawn::{Random, draw};
use super::{each, each_is_met, name};

type Places = BTreeSet<String>;

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct State {
    marked: Places,
    /// By use, the flags that are set in the present run.
    set: Vec<Vec<String>>,
    /// By source, how many events wait for it.
    waiting: BTreeMap<String, u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fault {
    Exclusion,
    OutOfOrder,
    Unsafe,
    Overflow,
    Deadlock,
}

/// What a step is, as far as that matters.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Fires(String),
    Other,
}

struct Closed<'a> {
    net: &'a NetModel,
    uses: &'a [Use],
    most_waiting: u8,
}

struct Transition {
    name: String,
    inputs: Places,
    outputs: Places,
}

impl Closed<'_> {
    fn position(&self, number: usize, set: &[String]) -> Position {
        let protocol = &self.uses[number].protocol;
        set.iter().fold(Position::START, |at, flag| {
            let flag = protocol.flag(flag).expect("it was set");
            protocol.after(at, flag).expect("in order")
        })
    }

    fn bound(&self, kind: PlaceKind) -> Vec<(String, Binding)> {
        let places = self.net.places().filter(|place| place.kind == kind);
        let bound = places.filter_map(|own| Some((own.name.to_owned(), own.binding?.clone())));
        bound.collect()
    }

    fn transitions(&self) -> Vec<Transition> {
        let set = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        let all = self.net.transitions().map(|own| Transition {
            name: own.name.to_owned(),
            inputs: set(&own.inputs),
            outputs: set(&own.outputs),
        });
        all.collect()
    }

    fn start(&self) -> State {
        let marked = self.net.places().filter(|place| place.marked);
        State {
            marked: marked.map(|place| place.name.to_owned()).collect(),
            set: vec![Vec::new(); self.uses.len()],
            waiting: BTreeMap::new(),
        }
    }

    /// Sources of a flag of a use.
    fn sources(&self, number: usize, flag: &str) -> Vec<String> {
        let binding = Binding::flag(&self.uses[number].name, flag);
        let all = self.bound(PlaceKind::Source).into_iter();
        all.filter(|(_, own)| *own == binding)
            .map(|(name, _)| name)
            .collect()
    }

    /// An event comes to a source.
    fn arrive(&self, state: &mut State, source: &str) -> Result<(), Fault> {
        if state.marked.insert(source.to_owned()) {
            return Ok(());
        }
        let waiting = state.waiting.entry(source.to_owned()).or_default();
        *waiting += 1;
        if *waiting > self.most_waiting {
            return Err(Fault::Overflow);
        }
        Ok(())
    }

    fn set_flag(&self, state: &mut State, number: usize, flag: &str) {
        let set = &mut state.set[number];
        set.push(flag.to_owned());
        let at = self.position(number, set);
        if self.uses[number].protocol.is_end(at) {
            state.set[number].clear();
        }
    }

    /// All that can happen next, and the faults that happen instead.
    fn steps(&self, from: &State) -> (Vec<(Kind, State)>, BTreeSet<Fault>) {
        let (mut steps, mut faults) = (Vec::new(), BTreeSet::new());
        let sinks = self.bound(PlaceKind::Sink);
        let is_sink = |name: &String| sinks.iter().any(|(own, _)| own == name);
        for transition in self.transitions() {
            let new: Vec<&String> = transition.outputs.difference(&transition.inputs).collect();
            let is_full = |place: &&String| from.marked.contains(*place);
            let full_sink = new.iter().any(|place| is_sink(place) && is_full(place));
            if !transition.inputs.is_subset(&from.marked) || full_sink {
                continue;
            }
            if new.iter().any(is_full) {
                faults.insert(Fault::Unsafe);
                continue;
            }
            let mut after = from.clone();
            for input in transition.inputs.difference(&transition.outputs) {
                match after.waiting.get_mut(input) {
                    Some(waiting) if *waiting > 1 => *waiting -= 1,
                    Some(_) => drop(after.waiting.remove(input)),
                    None => drop(after.marked.remove(input)),
                }
            }
            after.marked.extend(transition.outputs);
            steps.push((Kind::Fires(transition.name), after));
        }
        for number in 0..self.uses.len() {
            self.protocol_steps(from, number, &mut steps, &mut faults);
        }
        for (source, binding) in self.bound(PlaceKind::Source) {
            if matches!(binding, Binding::Event(_)) && !from.marked.contains(&source) {
                let mut after = from.clone();
                after.marked.insert(source);
                steps.push((Kind::Other, after));
            }
        }
        for (sink, binding) in sinks {
            if matches!(binding, Binding::Event(_)) && from.marked.contains(&sink) {
                let mut after = from.clone();
                after.marked.remove(&sink);
                steps.push((Kind::Other, after));
            }
        }
        (steps, faults)
    }

    fn protocol_steps(
        &self,
        from: &State,
        number: usize,
        steps: &mut Vec<(Kind, State)>,
        faults: &mut BTreeSet<Fault>,
    ) {
        let used = &self.uses[number];
        let (protocol, other) = (&used.protocol, used.net_party.other());
        let at = self.position(number, &from.set[number]);
        let aborts = self.sources(number, ABORTED);
        let deaf = aborts.iter().any(|source| from.marked.contains(source));
        let next: Vec<_> = protocol.next(at).map(|(flag, _)| flag).collect();
        for &flag in &next {
            let name = protocol.flag_name(flag);
            if protocol.owner(flag) == Some(other) && !deaf {
                let mut after = from.clone();
                self.set_flag(&mut after, number, name);
                let mut sources = self.sources(number, name).into_iter();
                match sources.try_for_each(|source| self.arrive(&mut after, &source)) {
                    Ok(()) => steps.push((Kind::Other, after)),
                    Err(fault) => drop(faults.insert(fault)),
                }
            }
        }
        for (sink, binding) in self.bound(PlaceKind::Sink) {
            let flag = next.iter().map(|&flag| protocol.flag_name(flag));
            let mut flag = flag.filter(|flag| binding == Binding::flag(&used.name, *flag));
            if let Some(flag) = flag.next().filter(|_| from.marked.contains(&sink)) {
                let mut after = from.clone();
                after.marked.remove(&sink);
                self.set_flag(&mut after, number, flag);
                steps.push((Kind::Other, after));
            }
        }
        if !aborts.is_empty() && !deaf && !from.set[number].is_empty() {
            let mut after = from.clone();
            after.set[number].clear();
            for (_, flag, _) in protocol.flags() {
                for source in self.sources(number, flag) {
                    after.marked.remove(&source);
                    after.waiting.remove(&source);
                }
                let binding = Binding::flag(&used.name, flag);
                for (sink, own) in self.bound(PlaceKind::Sink) {
                    if own == binding {
                        after.marked.remove(&sink);
                    }
                }
            }
            let mut sources = aborts.iter();
            match sources.try_for_each(|source| self.arrive(&mut after, source)) {
                Ok(()) => steps.push((Kind::Other, after)),
                Err(fault) => drop(faults.insert(fault)),
            }
        }
    }

    /// What is wrong with a state as such.
    fn fault(&self, state: &State) -> Option<Fault> {
        let mut exclusions = self.net.exclusions();
        let both = |places: &[&str]| {
            let marked = places.iter().filter(|&&place| state.marked.contains(place));
            marked.count() > 1
        };
        if exclusions.any(|own| both(&own.places)) {
            return Some(Fault::Exclusion);
        }
        (0..self.uses.len())
            .any(|number| !self.is_in_order(state, number))
            .then_some(Fault::OutOfOrder)
    }

    /// Each marked sink's flag is next, or comes after flags alone whose sinks are marked too.
    fn is_in_order(&self, state: &State, number: usize) -> bool {
        let (used, protocol) = (&self.uses[number], &self.uses[number].protocol);
        let marked: BTreeSet<String> = { self.bound(PlaceKind::Sink).into_iter() }
            .filter(|(name, _)| state.marked.contains(name))
            .flat_map(|(_, own)| {
                protocol
                    .flags()
                    .map(move |flag| (own.clone(), flag.1.to_owned()))
            })
            .filter(|(own, flag)| *own == Binding::flag(&used.name, flag))
            .map(|(_, flag)| flag)
            .collect();
        let mut reached = BTreeSet::new();
        let mut open = vec![self.position(number, &state.set[number])];
        while let Some(at) = open.pop() {
            for (flag, to) in protocol.next(at) {
                let name = protocol.flag_name(flag);
                if marked.contains(name) {
                    reached.insert(name.to_owned());
                    open.push(to);
                }
            }
        }
        reached == marked
    }

    fn is_end(&self, state: &State, end: &[&str]) -> bool {
        let internal: BTreeSet<&str> = { self.net.places() }
            .filter(|place| place.kind == PlaceKind::Internal && state.marked.contains(place.name))
            .map(|place| place.name)
            .collect();
        internal == end.iter().copied().collect() && self.rests(state)
    }

    /// Nothing is under way: sinks and sources of flags are empty, and protocols between two runs.
    fn rests(&self, state: &State) -> bool {
        let is_quiet = |(name, binding): &(String, Binding)| {
            matches!(binding, Binding::Event(_)) || !state.marked.contains(name)
        };
        let sinks = self.bound(PlaceKind::Sink);
        self.bound(PlaceKind::Source).iter().all(is_quiet)
            && !sinks.iter().any(|(name, _)| state.marked.contains(name))
            && state.set.iter().all(Vec::is_empty)
            && state.waiting.is_empty()
    }
}

/// All states, each with the steps from it.
struct Graph {
    states: Vec<State>,
    distance: Vec<usize>,
    edges: Vec<Vec<(Kind, usize)>>,
}

/// All states, or the nearest fault and how many steps lead to it.
fn explore(closed: &Closed<'_>) -> Result<Graph, (Fault, usize)> {
    let start = closed.start();
    let mut numbers = BTreeMap::from([(start.clone(), 0)]);
    let mut graph = Graph {
        states: vec![start],
        distance: vec![0],
        edges: Vec::new(),
    };
    let mut open = VecDeque::from([0]);
    let mut found: Option<(usize, Fault)> = None;
    while let Some(number) = open.pop_front() {
        let (state, distance) = (graph.states[number].clone(), graph.distance[number]);
        if found.is_some_and(|(least, _)| distance > least) {
            break;
        }
        let (steps, faults) = closed.steps(&state);
        let ends = closed
            .net
            .ends()
            .any(|end| closed.is_end(&state, &end.places));
        let stops = steps.is_empty() && faults.is_empty() && !ends;
        let here = { closed.fault(&state).into_iter() }
            .chain(faults)
            .chain(stops.then_some(Fault::Deadlock));
        found = { here.map(|fault| (distance, fault)) }.chain(found).min();
        let mut edges = Vec::new();
        for (kind, after) in steps {
            let next = numbers.len();
            let to = *numbers.entry(after.clone()).or_insert(next);
            if to == next {
                graph.states.push(after);
                graph.distance.push(distance + 1);
                open.push_back(to);
            }
            edges.push((kind, to));
        }
        graph.edges.push(edges);
    }
    match found {
        Some((distance, fault)) => Err((fault, distance)),
        None => Ok(graph),
    }
}

impl Graph {
    /// Whether each state leads to one that is wanted.
    fn leads(&self, wanted: impl Fn(&State) -> bool) -> Vec<bool> {
        let mut leads: Vec<bool> = self.states.iter().map(wanted).collect();
        loop {
            let more: Vec<usize> = (0..leads.len())
                .filter(|&from| !leads[from] && self.edges[from].iter().any(|&(_, to)| leads[to]))
                .collect();
            if more.is_empty() {
                return leads;
            }
            more.into_iter().for_each(|from| leads[from] = true);
        }
    }

    /// Transitions alone lead round.
    fn fires_for_ever(&self) -> bool {
        let mut rests = vec![false; self.states.len()];
        loop {
            let fires = |from: usize| {
                let mut steps = self.edges[from].iter();
                steps.any(|(kind, to)| matches!(kind, Kind::Fires(_)) && !rests[*to])
            };
            let more: Vec<usize> = (0..rests.len())
                .filter(|&from| !rests[from] && !fires(from))
                .collect();
            if more.is_empty() {
                return rests.contains(&false);
            }
            more.into_iter().for_each(|from| rests[from] = true);
        }
    }

    /// What is wrong with the whole, by the names of reasons, each with how many steps lead there.
    fn wrong(&self, closed: &Closed<'_>) -> BTreeSet<(&'static str, Option<usize>)> {
        let mut wrong = BTreeSet::new();
        let nearest = |leads: &[bool]| {
            let stuck = self
                .distance
                .iter()
                .zip(leads)
                .filter(|(_, leads)| !**leads);
            stuck.map(|(&distance, _)| distance).min()
        };
        let ends: Vec<_> = closed.net.ends().collect();
        if ends.is_empty() {
            for number in 0..closed.uses.len() {
                let leads = self.leads(|state| state.set[number].is_empty());
                wrong.extend(nearest(&leads).map(|least| ("Unfinished", Some(least))));
            }
        } else {
            let is_end = |state: &State| ends.iter().any(|end| closed.is_end(state, &end.places));
            wrong.extend(nearest(&self.leads(is_end)).map(|least| ("Livelock", Some(least))));
            let mut unreached = ends.iter().filter(|end| {
                !{ self.states.iter() }.any(|state| closed.is_end(state, &end.places))
            });
            wrong.extend(unreached.next().map(|_| ("EndUnreached", None)));
        }
        if !closed.net.allows_endless() && self.fires_for_ever() {
            wrong.insert(("Endless", None));
        }
        let fired: BTreeSet<&Kind> = self.edges.iter().flatten().map(|(kind, _)| kind).collect();
        let mut dead = { closed.transitions().into_iter() }
            .filter(|own| !fired.contains(&Kind::Fires(own.name.clone())));
        wrong.extend(dead.next().map(|_| ("DeadTransitions", None)));
        wrong
    }
}

#[test]
fn an_independent_look_at_random_nets_with_branches_and_aborts_comes_to_the_same() {
    let mut random = Random(0x5ca1_ab1e_0ddb_a115);
    let mut met: BTreeMap<String, usize> = BTreeMap::new();
    for number in 0..4000 {
        let (net, uses) = draw(&mut random);
        let closed = Closed {
            net: &net,
            uses: &uses,
            most_waiting: Limits::default().waiting,
        };
        let product = each(&net, &uses);
        let verdict = match &product {
            Ok(_) => "passes".to_owned(),
            Err(refusal) => name(&refusal.reason),
        };
        *met.entry(verdict.clone()).or_default() += 1;
        let before = [
            "Model",
            "UnreadAbort",
            "SeveralSources",
            "UnknownFlag",
            "WrongOwner",
        ];
        if before.contains(&verdict.as_str()) {
            continue;
        }
        let length = product.as_ref().err().and_then(|refusal| {
            let trace = refusal.trace.as_ref()?;
            Some(trace.steps.len())
        });
        let told = || format!("net {number}: {:?}\n{net:?}", product.as_ref().err());
        match explore(&closed) {
            Err((fault, distance)) => {
                assert_eq!(verdict, format!("{fault:?}"), "{}", told());
                assert_eq!(length, Some(distance), "{}", told());
            }
            Ok(graph) => {
                let wrong = graph.wrong(&closed);
                if wrong.is_empty() {
                    let report = product.as_ref().map(|proof| proof.report().clone());
                    let report = report.unwrap_or_else(|_| panic!("refused: {}", told()));
                    let steps: usize = graph.edges.iter().map(Vec::len).sum();
                    let numbers = (graph.states.len() as u128, steps as u128);
                    assert_eq!((report.states, report.steps), numbers, "{}", told());
                } else {
                    let same = |&(own, least): &(&str, Option<usize>)| {
                        own == verdict && least.is_none_or(|least| length == Some(least))
                    };
                    assert!(wrong.iter().any(same), "{wrong:?}: {}", told());
                }
            }
        }
    }
    each_is_met(
        &met,
        &[
            ("passes", 100),
            ("Deadlock", 20),
            ("Unsafe", 20),
            ("OutOfOrder", 5),
            ("Exclusion", 5),
            ("Livelock", 5),
            ("DeadTransitions", 5),
        ],
    );
}
