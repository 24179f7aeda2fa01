//! `[fleet]`: the network between this robot and everybody else.

use crate::keys::{Optional, Quantity, Text, Texts, Truth};
use crate::section;

const ENDPOINT: &str = "an endpoint such as \"tls/192.168.1.20:7447\"";

section! {
    /// The network (zenoh) between this robot and everybody else.
    pub struct Fleet: Default {
        /// Endpoints to listen on.
        pub listen: Vec<String> as Texts(ENDPOINT) => Vec::new(),
        /// Endpoints to connect to.
        pub connect: Vec<String> as Texts(ENDPOINT) => Vec::new(),
        /// Whether to look for others by multicast.
        pub scouting: bool as Truth => false,
        /// The network interface for scouting; never the fieldbus.
        pub interface: Option<String> as Optional(Text("a network interface, such as \"wlan0\"")) => None,
        /// First part of every key.
        pub key_prefix: String as Text("the first part of every key") => "fleet".to_owned(),
        /// The robot's certificate, as `mediator keys robot` has made it: every link then shows certificates on both ends. It is
        /// renewed in place.
        pub keys: Option<String> as Optional(Text("a file, such as \"/var/lib/onboard/amr-1.pem\"")) => None,
        /// Whether to leave this computer without certificates: whoever is on the network can then hear, speak for and move
        /// the robot.
        pub insecure: bool as Truth => false,
        /// An area that the mediator grants is asked for this far ahead, beyond the distance that the robot needs to
        /// stop.
        pub request_ahead_m: f64 as Quantity::new("a length", "m").at_least(0.0).at_most(20.0) => 0.5,
    }
}
