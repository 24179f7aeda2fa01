//! `cargo bench -p mediator [steps] [load] [sessions] [latency]`: what the mediator can do.
//!
//! * `steps`: the manager alone, from the bytes of a report to the bytes of the answers, with the journal in memory and on
//!   disk;
//! * `load`: the real program over zenoh on the loopback, at ten thousand reports a second;
//! * `sessions`: the real program with a thousand robots on a session each, on a floor with fifty nets; for comparison with a
//!   hundred, and with a certificate each;
//! * `latency`: the real program with few robots: from a request to the grant of a free area, and from a robot's flag to the
//!   mediator's command that its net has been waiting to give.

mod figures;
mod floor;
mod latency;
mod load;
#[path = "../../tests/it/program/mod.rs"]
mod program;
#[allow(dead_code, reason = "tests use all of it")]
#[path = "../../tests/it/random.rs"]
mod random;
mod sessions;
mod steps;
mod wire;

fn main() {
    // Cargo adds `--bench`; anything else picks parts by name.
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with('-'))
        .collect();
    let parts: [(&str, fn()); 4] = [
        ("steps", steps::run),
        ("load", load::run),
        ("sessions", sessions::run),
        ("latency", latency::run),
    ];
    println!("{}", figures::machine());
    for (name, run) in parts {
        if wanted.is_empty() || wanted.iter().any(|wanted| wanted == name) {
            run();
        }
    }
}
