//! `cargo bench -p mediator [steps] [load] [sessions]`: what the mediator can do.
//!
//! * `steps`: the manager alone, from the bytes of a report to the bytes of the answers, with the journal in memory and on
//!   disk;
//! * `load`: the real program over zenoh on the loopback, at ten thousand reports a second;
//! * `sessions`: the real program with a thousand robots on a session each, on a floor with fifty nets; for comparison with a
//!   hundred, and with a certificate each.
//!
//! How soon it answers few robots with nothing in its way is measured by `rig bench --only mediator`.

mod figures;
mod floor;
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
    let parts: [(&str, fn()); 3] = [
        ("steps", steps::run),
        ("load", load::run),
        ("sessions", sessions::run),
    ];
    println!("{}", figures::machine());
    for (name, run) in parts {
        if wanted.is_empty() || wanted.iter().any(|wanted| wanted == name) {
            run();
        }
    }
}
