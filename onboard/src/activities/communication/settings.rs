//! What the communication activity needs to know.

use contract::network::NetworkSettings;

/// What the communication activity needs to know.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Robot, as its file names it.
    pub robot_id: String,
    /// Role that the site gives it.
    pub role: String,
    /// Tells this start of the process from others.
    pub boot_epoch: u64,
    /// Prefix of all keys.
    pub key_prefix: String,
    /// The network, without who this is.
    pub network: NetworkSettings,
    /// File of the robot's certificate.
    pub keys: Option<String>,
}
