//! `cargo bench -p mediator [steps] [load] [latency]`: what the mediator can do.
//!
//! * `steps`: the manager alone, from the bytes of a report to the bytes of the answers, with the journal in memory and on
//!   disk;
//! * `load`: the real program over zenoh on the loopback, at ten thousand reports a second;
//! * `latency`: the real program with few robots: from a request to the grant of a free area, and from a robot's flag to the
//!   mediator's command that its net has been waiting to give.

mod figures;
mod floor;
mod latency;
mod load;
#[path = "../../tests/it/program/mod.rs"]
mod program;
mod steps;
mod wire;

fn main() {
    // Cargo adds `--bench`; anything else picks parts by name.
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with('-'))
        .collect();
    let parts: [(&str, fn()); 3] = [
        ("steps", steps::run),
        ("load", load::run),
        ("latency", latency::run),
    ];
    println!("{}", figures::machine());
    for (name, run) in parts {
        if wanted.is_empty() || wanted.iter().any(|wanted| wanted == name) {
            run();
        }
    }
}
