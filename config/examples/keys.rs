//! Prints the reference page of all keys: `cargo run -p config --example keys > config/KEYS.md`.

fn main() {
    print!("{}", config::reference_page());
}
