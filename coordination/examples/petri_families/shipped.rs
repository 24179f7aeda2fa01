//! The nets that the project ships, `config/nets/*.toml`, as far as a net, its protocols and their roles go:
//! the crate does not know the loader of those files, which checks them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use coordination::analysis::Use;
use coordination::petri::{Binding, NetModel};
use coordination::protocol::{Party, ProtocolModel};
use toml::{Table, Value};

const MEDIATOR: &str = "mediator";

/// A net in its first situation, with the protocols that it takes part in.
pub struct Shipped {
    pub name: String,
    pub uses: Vec<Use>,
    places: Vec<Place>,
    transitions: Vec<Transition>,
    marked: BTreeSet<String>,
    ends: Vec<(String, Vec<String>)>,
}

struct Place {
    name: String,
    kind: &'static str,
    binding: String,
}

struct Transition {
    name: String,
    from: Vec<String>,
    to: Vec<String>,
}

/// Where they are, beside the crate.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/nets")
}

/// All of them, by name; none where the crate stands alone.
pub fn all() -> Vec<Shipped> {
    let files = folder().read_dir().into_iter().flatten().flatten();
    let mut texts: Vec<_> = { files.map(|file| file.path()) }
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .map(|path| std::fs::read_to_string(path).expect("the file can be read"))
        .collect();
    texts.sort();
    texts.iter().map(|text| Shipped::of(text)).collect()
}

impl Shipped {
    fn of(text: &str) -> Self {
        let file: Table = text.parse().expect("the file is TOML");
        let mut places = Vec::new();
        for kind in ["places", "sources", "sinks"] {
            places.extend(table(&file, kind).iter().map(|(name, binding)| Place {
                name: name.clone(),
                kind,
                binding: string(binding),
            }));
        }
        let mut transitions: Vec<_> = { table(&file, "transitions").iter() }
            .map(|(name, arcs)| Transition {
                name: name.clone(),
                from: strings(&arcs["from"]),
                to: strings(&arcs["to"]),
            })
            .collect();
        let situations = table(&file, "situations");
        let first = situations.values().next().expect("there is a situation");
        let marked: BTreeSet<_> = strings(&first["marked"]).into_iter().collect();
        // As the loader does: what nothing can mark from there is left out.
        let sources = places.iter().filter(|place| place.kind == "sources");
        let mut reached = marked.clone();
        reached.extend(sources.map(|place| place.name.clone()));
        loop {
            let before = reached.len();
            for transition in &transitions {
                if transition.from.iter().all(|place| reached.contains(place)) {
                    reached.extend(transition.to.iter().cloned());
                }
            }
            if reached.len() == before {
                break;
            }
        }
        transitions.retain(|one| one.from.iter().all(|place| reached.contains(place)));
        let touched = |place: &Place| {
            let mut all = transitions.iter();
            all.any(|one| one.from.contains(&place.name) || one.to.contains(&place.name))
        };
        places.retain(touched);
        let ends = table(&file, "ends").iter();
        Self {
            name: string(&file["name"]),
            uses: { table(&file, "roles").iter() }
                .map(|(role, about)| {
                    let protocol =
                        table(&file, "protocols")[&string(&about["protocol"])].as_table();
                    protocol_of(role, protocol.expect("a protocol is a table"))
                })
                .collect(),
            ends: { ends.map(|(name, places)| (name.clone(), strings(places))) }.collect(),
            places,
            transitions,
            marked,
        }
    }

    /// The net, with its places and transitions declared in an order that `below`, a source of random
    /// numbers below a limit, makes.
    pub fn shuffled(&self, mut below: impl FnMut(usize) -> usize) -> NetModel {
        let mut order = |count: usize| {
            let mut order: Vec<_> = (0..count).collect();
            for last in (1..count).rev() {
                order.swap(last, below(last + 1));
            }
            order
        };
        let mut model = NetModel::new(&self.name);
        for place in order(self.places.len()) {
            let Place {
                name,
                kind,
                binding,
            } = &self.places[place];
            let flag = || {
                let (role, flag) = binding.split_once('.').expect("all are flags");
                Binding::flag(role, flag)
            };
            match *kind {
                "sources" => model.source(name, flag()),
                "sinks" => model.sink(name, flag()),
                _ => model.place(name),
            };
        }
        for transition in order(self.transitions.len()) {
            let Transition { name, from, to } = &self.transitions[transition];
            model.transition(name, &borrowed(from), &borrowed(to));
        }
        for place in &self.marked {
            model.mark(place);
        }
        for (name, places) in &self.ends {
            model.end(name, &borrowed(places));
        }
        model
    }
}

fn protocol_of(role: &str, file: &Table) -> Use {
    let mut model = ProtocolModel::new(role, role, MEDIATOR);
    if let Some(keeper) = file.get("keeper") {
        let is_robot = keeper.as_str() == Some("robot");
        model.keeper(if is_robot { role } else { MEDIATOR });
    }
    let mut array = |name: &str, flags: &Value| {
        let flags = flags.as_array().expect("flags are a list");
        let entries: Vec<_> = { flags.iter().filter_map(Value::as_table) }
            .map(|flag| match flag.get("robot") {
                Some(name) => (string(name), role),
                None => (string(&flag[MEDIATOR]), MEDIATOR),
            })
            .collect();
        let entries: Vec<_> = entries.iter().map(|(flag, by)| (&**flag, *by)).collect();
        model.array(name, &entries);
    };
    match file.get("flags") {
        Some(flags) => array("all", flags),
        None => {
            let arrays = table(file, "arrays");
            for (name, about) in arrays {
                array(name, &about["flags"]);
            }
            for (name, about) in arrays {
                for next in about.get("then").map(strings).unwrap_or_default() {
                    model.follow(name, next);
                }
            }
            let starts = file.get("start").map(strings);
            for start in starts.unwrap_or_else(|| first_arrays(arrays)) {
                model.start(start);
            }
        }
    }
    let protocol = model.compile().expect("the protocol is sound");
    Use::new(role, Arc::new(protocol), Party::Second)
}

/// Those that follow no other: the table has lost their order.
fn first_arrays(arrays: &Table) -> Vec<String> {
    let then = arrays.values().filter_map(|about| about.get("then"));
    let later: BTreeSet<_> = then.flat_map(strings).collect();
    { arrays.keys().filter(|name| !later.contains(*name)) }
        .cloned()
        .collect()
}

fn table<'a>(table: &'a Table, key: &str) -> &'a Table {
    table[key].as_table().expect("it is a table")
}

fn string(value: &Value) -> String {
    value.as_str().expect("it is a string").to_owned()
}

fn strings(value: &Value) -> Vec<String> {
    let list = value.as_array().expect("it is a list");
    list.iter().map(string).collect()
}

fn borrowed(names: &[String]) -> Vec<&str> {
    names.iter().map(String::as_str).collect()
}
