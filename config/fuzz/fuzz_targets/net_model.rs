//! Nets of any shape, with protocols of any shape, built in code: checked, compiled, analysed with a
//! small bound and run. What the analysis passes must not do in a run what the analysis excludes.

#![no_main]

use std::sync::Arc;

use arbitrary::{Result, Unstructured};
use config_fuzz::{LIMITS, run};
use coordination::analysis::{Use, check};
use coordination::petri::{Binding, Dot, NetModel};
use coordination::protocol::{Party, ProtocolModel};
use libfuzzer_sys::fuzz_target;

const PLACES: &[&str] = &["a", "b", "c", "d", "e", "f", "g", "h"];
const SOURCES: &[&str] = &["s0", "s1", "s2", "s3", "s4", "s5"];
const SINKS: &[&str] = &["k0", "k1", "k2", "k3", "k4", "k5"];
const FLAGS: &[&str] = &["f0", "f1", "f2", "f3", "f4", "f5"];
const ARRAYS: &[&str] = &["x", "y", "z"];
const PARTIES: [&str; 2] = ["robot", "mediator"];

fn protocol(input: &mut Unstructured<'_>, name: &str) -> Result<Option<Use>> {
    let mut model = ProtocolModel::new(name, PARTIES[0], PARTIES[1]);
    for &array in &ARRAYS[..input.int_in_range(1..=3)?] {
        let count = input.int_in_range(1..=4)?;
        let entries = (0..count)
            .map(|_| Ok((*input.choose(FLAGS)?, *input.choose(&PARTIES)?)))
            .collect::<Result<Vec<_>>>()?;
        model.array(array, &entries);
        if input.ratio(1, 2)? {
            model.follow(array, *input.choose(ARRAYS)?);
        }
        if input.ratio(1, 4)? {
            model.start(array);
        }
    }
    if input.ratio(1, 3)? {
        model.keeper(*input.choose(&PARTIES)?);
    }
    let errors = model.check();
    match model.compile() {
        Ok(protocol) => {
            assert_eq!(errors, []);
            Ok(Some(Use::new(name, Arc::new(protocol), Party::Second)))
        }
        Err(error) => {
            assert!(errors.contains(&error) && !error.to_string().is_empty());
            Ok(None)
        }
    }
}

/// Bound to a flag of the right owner most of the time; else nothing would ever run.
fn binding(input: &mut Unstructured<'_>, uses: &[Use], owner: Party) -> Result<Binding> {
    if uses.is_empty() || input.ratio(1, 6)? {
        return Ok(Binding::event(*input.choose(FLAGS)?));
    }
    let used = input.choose(uses)?;
    let all = used.protocol.flags().map(|(_, name, _)| name);
    let own = used.protocol.flags().filter(|&(_, _, by)| by == owner);
    let own: Vec<&str> = own.map(|(_, name, _)| name).collect();
    let flag = match own.as_slice() {
        [] => all.last().unwrap_or("aborted"),
        _ if input.ratio(1, 30)? => "aborted",
        own => input.choose(own)?,
    };
    Ok(Binding::flag(&used.name, flag))
}

fn some<'a>(input: &mut Unstructured<'_>, names: &[&'a str], most: usize) -> Result<Vec<&'a str>> {
    let count = input.int_in_range(0..=most)?;
    let mut chosen: Vec<&str> = Vec::new();
    for _ in 0..count {
        let name = *input.choose(names)?;
        // Twice is an error, which need not come often.
        if !chosen.contains(&name) || input.ratio(1, 50)? {
            chosen.push(name);
        }
    }
    Ok(chosen)
}

fn fuzz(input: &mut Unstructured<'_>) -> Result<()> {
    let mut uses = Vec::new();
    for name in ["p", "q"] {
        if input.ratio(3, 4)? {
            uses.extend(protocol(input, name)?);
        }
    }
    let mut net = NetModel::new("net");
    let (places, sources, sinks) = (
        &PLACES[..input.int_in_range(0..=PLACES.len())?],
        &SOURCES[..input.int_in_range(0..=SOURCES.len())?],
        &SINKS[..input.int_in_range(0..=SINKS.len())?],
    );
    for place in places {
        net.place(place);
        if input.ratio(1, 3)? {
            net.mark(place);
        }
    }
    for source in sources {
        net.source(source, binding(input, &uses, Party::First)?);
    }
    for sink in sinks {
        net.sink(sink, binding(input, &uses, Party::Second)?);
    }
    let inputs: Vec<&str> = places.iter().chain(sources).copied().collect();
    let outputs: Vec<&str> = places.iter().chain(sinks).copied().collect();
    for number in 0..input.int_in_range(1..=10)? {
        let (from, to) = (some(input, &inputs, 3)?, some(input, &outputs, 3)?);
        net.transition(format!("t{number}"), &from, &to);
    }
    if input.ratio(1, 2)? {
        net.exclusion("x", &some(input, places, 4)?);
    }
    if input.ratio(1, 2)? {
        net.end("end", &some(input, places, 4)?);
    }
    let proof = match check(&net, &uses, &LIMITS) {
        Ok(proof) => {
            let report = proof.report();
            assert!(report.states <= LIMITS.states as u128 && report.steps <= LIMITS.steps as u128);
            Some(proof)
        }
        Err(refusal) => {
            assert!(!refusal.to_string().is_empty());
            None
        }
    };
    assert!(Dot::new(&net).to_string().ends_with("}\n"));
    run(&net, &uses, proof.as_ref(), input.arbitrary().unwrap_or(1));
    Ok(())
}

fuzz_target!(|bytes: &[u8]| {
    // Input that ends early is an input that does nothing.
    let _ = fuzz(&mut Unstructured::new(bytes));
});
