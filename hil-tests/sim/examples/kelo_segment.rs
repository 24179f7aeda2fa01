//! Serves one KELO drive on a test stand until Enter is pressed or the input ends.
//!
//! `cargo run -p sim --example kelo_segment -- udp:127.0.0.1:34980`, or a network interface instead of `udp:…`.

use std::error::Error;

use sim::ethercat::{ServeOptions, serve_raw, serve_udp};
use sim::kelo::{KeloOptions, SimulatedDrive};
use sim::plant::TestStand;

fn main() -> Result<(), Box<dyn Error>> {
    let place = std::env::args()
        .nth(1)
        .ok_or("usage: kelo_segment udp:ADDRESS:PORT | INTERFACE")?;
    let simulated = SimulatedDrive::new(Box::new(TestStand::new()), KeloOptions::default());
    let options = ServeOptions { priority: Some(90) };
    let server = match place.strip_prefix("udp:") {
        Some(address) => serve_udp(address.parse()?, simulated.segment, options)?,
        None => serve_raw(&place, simulated.segment, options)?,
    };
    match server.local_addr() {
        Some(address) => println!("serving on udp:{address}"),
        None => println!("serving on {place}"),
    }
    std::io::stdin().read_line(&mut String::new())?;
    println!(
        "{:#?}\n{:#?}",
        simulated.statistics.snapshot(),
        simulated.drive.statistics()
    );
    Ok(())
}
