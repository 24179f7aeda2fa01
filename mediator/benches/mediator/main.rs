//! `cargo bench -p mediator [steps]`: what the mediator can do.
//!
//! * `steps`: the manager alone, from the bytes of a report to the bytes of the answers, with the journal in memory and on
//!   disk.

mod figures;
mod floor;
mod steps;

fn main() {
    // Cargo adds `--bench`; anything else picks parts by name.
    let wanted: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with('-'))
        .collect();
    let parts: [(&str, fn()); 1] = [("steps", steps::run)];
    println!("{}", figures::machine());
    for (name, run) in parts {
        if wanted.is_empty() || wanted.iter().any(|wanted| wanted == name) {
            run();
        }
    }
}
