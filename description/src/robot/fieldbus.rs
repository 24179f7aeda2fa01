//! `[ethercat]`: how the wheel unit is reached.

use std::net::SocketAddr;

use super::{DURATION, TIMEOUT_MS};
use crate::keys::{Count, Fault, Flat, KeyError, Need, Page, Section, Source};
use crate::section;

const CODE: Count = Count::new("a number that SubDevices report", 1, u32::MAX);

section! {
    /// How the wheel unit is reached, and what it must report.
    pub struct Ethercat {
        /// Where the frames go.
        pub link: Link as Flat,
        /// The vendor that the SubDevice must report.
        pub vendor_id: u32 as CODE,
        /// The product codes that are accepted.
        pub product_codes: Vec<u32> as CODE,
        /// A cycle's answer later than this counts as lost.
        pub deadline_us: u32 as Count::new("a time in µs", 50, 100_000) => 500,
        /// The SubDevice's process-data watchdog: set at bring-up, and verified.
        pub watchdog_ms: u32 as TIMEOUT_MS => 100,
        /// Longest time that one attempt to bring the bus up may take.
        pub bring_up_s: f64 as DURATION => 3.0,
    }
}

/// Where the EtherCAT frames go: exactly one of `interface` and `udp`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Link {
    /// Raw Ethernet frames on this network interface.
    Interface(String),
    /// The same datagrams over UDP, to this address.
    Udp(SocketAddr),
}

const INTERFACE: &str = "a network interface, such as \"eth0\"";
const UDP: &str = "an address with port, such as \"127.0.0.1:34980\"";
const ONE: &str = "exactly one of `interface` and `udp`";

impl Section for Link {
    const ABOUT: &'static str =
        "Where the EtherCAT frames go: exactly one of `interface` and `udp`.";
    const KEYS: &'static [&'static str] = &["interface", "udp"];

    fn read(s: &dyn Source) -> Self {
        let text = |key, expected| s.text(key, expected, Need::Optional);
        match (text("interface", INTERFACE), text("udp", UDP)) {
            (Some(interface), None) => {
                // The kernel's IFNAMSIZ, and what `ip link` accepts.
                if interface.len() > 15 || interface.contains(['/', ' ']) {
                    let expected = "the name of a network interface, at most 15 characters";
                    let found = format!("text {interface:?}");
                    s.refuse(Fault::OutOfRange, "interface", found, expected.to_owned());
                }
                return Self::Interface(interface);
            }
            (None, Some(text)) => match text.parse::<SocketAddr>() {
                Ok(address) if address.port() != 0 => return Self::Udp(address),
                _ if text.is_empty() => {}
                _ => s.refuse(
                    Fault::OutOfRange,
                    "udp",
                    format!("text {text:?}"),
                    "an IP address with port, such as \"127.0.0.1:34980\"".to_owned(),
                ),
            },
            (Some(_), Some(_)) => {
                s.refuse(
                    Fault::Inconsistent,
                    "udp",
                    "both of them".to_owned(),
                    ONE.to_owned(),
                );
            }
            (None, None) => {
                s.refuse(
                    Fault::Missing,
                    "interface",
                    "neither".to_owned(),
                    ONE.to_owned(),
                );
            }
        }
        Self::Interface(String::new())
    }

    fn check(&self) -> Result<(), KeyError> {
        Ok(())
    }

    fn excuse(s: &dyn Source) {
        let _ = (s.has("interface"), s.has("udp"));
    }

    fn document(page: &mut Page) {
        let or = |other: &str| Some(format!("`{other}`"));
        page.key(
            "interface",
            INTERFACE,
            or("udp"),
            "Raw Ethernet frames on this network interface.",
        );
        page.key(
            "udp",
            UDP,
            or("interface"),
            "The same datagrams over UDP, to this address.",
        );
    }
}
