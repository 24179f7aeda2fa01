//! Random nets with branches and aborts: gates that are right, and what becomes of them when arcs are
//! added and left out.

use std::collections::BTreeSet;

use coordination::analysis::Use;
use coordination::petri::{Binding, NetModel};
use coordination::protocol::{ABORTED, Party, ProtocolModel};

/// Random numbers, the same for the same seed.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 20) as usize % limit
    }

    fn one_in(&mut self, many: usize) -> bool {
        self.below(many) == 0
    }

    fn of<'a>(&mut self, list: &'a [String]) -> &'a String {
        &list[self.below(list.len())]
    }
}

#[derive(Default)]
struct Parts {
    internal: Vec<String>,
    marked: Vec<String>,
    sources: Vec<(String, Binding)>,
    sinks: Vec<(String, Binding)>,
    transitions: Vec<(String, Vec<String>, Vec<String>)>,
    uses: Vec<Use>,
}

impl Parts {
    fn place(&mut self, name: String) -> String {
        self.internal.push(name.clone());
        name
    }

    fn source(&mut self, robot: &str, flag: &str) -> String {
        let name = format!("{robot} {flag}");
        self.sources
            .push((name.clone(), Binding::flag(robot, flag)));
        name
    }

    fn sink(&mut self, robot: &str, flag: &str) -> String {
        let name = format!("{robot} {flag}");
        self.sinks.push((name.clone(), Binding::flag(robot, flag)));
        name
    }

    fn transition(&mut self, name: String, inputs: &[&String], outputs: &[&String]) {
        let own = |list: &[&String]| list.iter().map(|&place| place.clone()).collect();
        self.transitions.push((name, own(inputs), own(outputs)));
    }

    fn names<T>(list: &[(String, T)]) -> Vec<String> {
        list.iter().map(|(name, _)| name.clone()).collect()
    }
}

/// A robot that asks for the road and may be told to wait, or choose to stop on it.
fn robot(random: &mut Random, parts: &mut Parts, robot: &str, free: &String) {
    let mut model = ProtocolModel::new(robot, robot, "mediator");
    let (refuses, stops, aborts) = (random.one_in(2), random.one_in(3), random.one_in(3));
    model.array("ask", &[("request", robot)]);
    model.array("may", &[("granted", "mediator")]);
    model.array("pass", &[("released", robot)]);
    model
        .start("ask")
        .follow("ask", "may")
        .follow("may", "pass");
    if refuses {
        model
            .array("no", &[("refused", "mediator")])
            .follow("ask", "no");
    }
    if stops {
        model.array("halt", &[("stopped", robot), ("gone", robot)]);
        model.follow("may", "halt");
    }
    if aborts {
        model.keeper(robot);
    } else if random.one_in(4) {
        model.keeper("mediator");
    }
    let Ok(protocol) = model.compile() else {
        panic!("the protocol is right: {:?}", model.check());
    };
    parts
        .uses
        .push(Use::new(robot, protocol.into(), Party::Second));

    let [outside, inside] =
        ["outside", "inside"].map(|what| parts.place(format!("{robot} {what}")));
    parts.marked.push(outside.clone());
    let [asks, left] = ["request", "released"].map(|flag| parts.source(robot, flag));
    let may = parts.sink(robot, "granted");
    let name = |what: &str| format!("{robot} {what}");
    parts.transition(name("enters"), &[&asks, free, &outside], &[&may, &inside]);
    parts.transition(name("leaves"), &[&left, &inside], &[free, &outside]);
    if refuses {
        let no = parts.sink(robot, "refused");
        parts.transition(name("waits"), &[&asks, &outside], &[&no, &outside]);
    }
    if stops {
        let [stopped, gone] = ["stopped", "gone"].map(|flag| parts.source(robot, flag));
        let halted = parts.place(name("halted"));
        parts.transition(name("halts"), &[&stopped, &inside], &[&halted]);
        parts.transition(name("goes"), &[&gone, &halted], &[free, &outside]);
        if aborts {
            let over = name(ABORTED);
            parts.transition(name("towed"), &[&over, &halted], &[free, &outside]);
        }
    }
    if aborts {
        let over = parts.source(robot, ABORTED);
        parts.transition(name("ignored"), &[&over, &outside], &[&outside]);
        parts.transition(name("cleared"), &[&over, &inside], &[free, &outside]);
    }
}

/// Adds, moves and leaves out arcs.
fn spoil(random: &mut Random, parts: &mut Parts) {
    let takes: Vec<_> = [parts.internal.clone(), Parts::names(&parts.sources)].concat();
    let puts: Vec<_> = [parts.internal.clone(), Parts::names(&parts.sinks)].concat();
    let number = random.below(parts.transitions.len());
    let kind = random.below(6);
    let (name, mut inputs, mut outputs) = parts.transitions[number].clone();
    let (list, from) = match random.one_in(2) {
        true => (&mut inputs, &takes),
        false => (&mut outputs, &puts),
    };
    match kind {
        0 if !list.is_empty() => drop(list.remove(random.below(list.len()))),
        1 | 2 => list.push(random.of(from).clone()),
        3 if !list.is_empty() => {
            let at = random.below(list.len());
            list[at] = random.of(from).clone();
        }
        4 => {
            let at = random.of(from).clone();
            list.push(at);
            let copy = (format!("{name} too"), inputs, outputs);
            return parts.transitions.push(copy);
        }
        _ => {
            let place = random.of(&parts.internal).clone();
            match parts.marked.iter().position(|marked| *marked == place) {
                Some(at) => drop(parts.marked.remove(at)),
                None => parts.marked.push(place),
            }
        }
    }
    parts.transitions[number] = (name, inputs, outputs);
}

/// A net and its protocols; it may be wrong in any way.
pub fn draw(random: &mut Random) -> (NetModel, Vec<Use>) {
    let mut parts = Parts::default();
    let free = parts.place("free".to_owned());
    parts.marked.push(free.clone());
    for number in 0..1 + random.below(2) {
        robot(random, &mut parts, &format!("r{number}"), &free);
    }
    if random.one_in(3) {
        let (tick, bell) = ("tick".to_owned(), "bell".to_owned());
        parts.sources.push((tick.clone(), Binding::event("tick")));
        parts.sinks.push((bell.clone(), Binding::event("bell")));
        parts.transition("rings".to_owned(), &[&tick], &[&bell]);
    }
    if random.one_in(4) {
        let [here, there] = ["here", "there"].map(|name| parts.place(name.to_owned()));
        parts.marked.push(here.clone());
        parts.transition("goes".to_owned(), &[&here], &[&there]);
        let road = if random.one_in(2) { &free } else { &there };
        parts.transition("comes".to_owned(), &[&there, road], &[&here, road]);
    }
    let right_ends = parts.marked.clone();
    for _ in 0..random.below(4) {
        spoil(random, &mut parts);
    }
    let mut net = NetModel::new("drawn");
    for place in &parts.internal {
        net.place(place);
    }
    for (place, binding) in &parts.sources {
        net.source(place, binding.clone());
    }
    for (place, binding) in &parts.sinks {
        net.sink(place, binding.clone());
    }
    for place in &parts.marked {
        net.mark(place);
    }
    for (name, inputs, outputs) in &parts.transitions {
        let (inputs, outputs) = (each_once(inputs), each_once(outputs));
        net.transition(name, &inputs, &outputs);
    }
    if !random.one_in(3) {
        let marked: Vec<&str> = right_ends.iter().map(String::as_str).collect();
        net.end("rest", &marked);
    }
    if random.one_in(3) {
        let [one, other] = [random.of(&parts.internal), random.of(&parts.internal)];
        if one != other {
            net.exclusion("both", &[one, other]);
        }
    }
    if random.one_in(4) {
        net.allow_endless();
    }
    (net, parts.uses)
}

fn each_once(list: &[String]) -> Vec<&str> {
    let set: BTreeSet<&str> = list.iter().map(String::as_str).collect();
    set.into_iter().collect()
}
