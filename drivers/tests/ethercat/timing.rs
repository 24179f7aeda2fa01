//! How long an exchange takes. Figures depend on the machine; the tests here check the data and print the rest.

use crate::interfaces::{MAIN_DEVICE, SEGMENT, with_own_network};
use crate::support::{Mirror, expectation, in_us, patient, segment, served_over_udp};
use drivers::ethercat::{Bus, Link, RawLink, UdpLink};
use drivers::monotonic_ns;
use sim::ethercat::serve_raw;
use sim::ethercat::server::ServeOptions;
use sim::rt;
use std::fmt;
use std::thread;
use std::time::Duration;

pub const PERIOD: Duration = Duration::from_millis(1);

/// Time from sending a frame to having its answer.
pub struct Times {
    link: String,
    period: Duration,
    sorted_us: Vec<f64>,
}

impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at = |q: f64| self.sorted_us[(q * (self.sorted_us.len() - 1) as f64) as usize];
        let (median, p99, p999, worst) = (at(0.5), at(0.99), at(0.999), at(1.0));
        write!(
            f,
            "{}, {} exchanges every {:?}: median {median:.1} µs, p99 {p99:.1} µs, p99.9 {p999:.1} µs, worst {worst:.1} µs",
            self.link,
            self.sorted_us.len(),
            self.period,
        )
    }
}

/// Exchanges and checks that each cycle's inputs are its own. A period of zero is back to back.
pub fn measure(bus: &mut Bus, cycles: usize, period: Duration) -> Times {
    let mut inputs = [0; 172];
    let mut sorted_us = Vec::with_capacity(cycles);
    let mut next_ns = monotonic_ns();
    for cycle in 0..cycles {
        let exchange = bus
            .exchange(&[cycle as u8; 36], &mut inputs, in_us(500_000))
            .unwrap();
        if cycle > 0 {
            assert_eq!(inputs[0], (cycle - 1) as u8, "inputs of the right cycle");
        }
        sorted_us.push((exchange.received_ns - exchange.sent_ns) as f64 / 1000.0);
        next_ns += period.as_nanos() as u64;
        thread::sleep(Duration::from_nanos(next_ns.saturating_sub(monotonic_ns())));
    }
    sorted_us.sort_by(f64::total_cmp);
    Times {
        link: bus.identity().link.clone(),
        period,
        sorted_us,
    }
}

fn print_times(link: Box<dyn Link>) {
    let mut bus = Bus::bring_up(link, &expectation(), patient()).unwrap();
    for period in [Duration::ZERO, PERIOD] {
        measure(&mut bus, 500, period);
        println!("{}", measure(&mut bus, 20_000, period));
    }
}

/// With real-time priority where permitted, the segment above the MainDevice, as robots are tested.
#[test]
#[ignore = "takes a minute: cargo test -p drivers --release --test ethercat -- --ignored --nocapture timing"]
fn with_real_time_priority() {
    let options = ServeOptions { priority: Some(85) };
    let over_udp = thread::spawn(move || {
        let (server, address, _) = served_over_udp(options);
        println!(
            "segment: {:?}, MainDevice: {}",
            server.granted(),
            rt::promote(80)
        );
        print_times(Box::new(UdpLink::open(address).unwrap()));
    });
    over_udp.join().unwrap();
    with_own_network(move || {
        let server = serve_raw(SEGMENT, segment([Mirror::default()]), options).unwrap();
        println!(
            "segment: {:?}, MainDevice: {}",
            server.granted(),
            rt::promote(80)
        );
        print_times(Box::new(RawLink::open(MAIN_DEVICE).unwrap()));
    });
}
