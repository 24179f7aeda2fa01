//! The files that ship, for tests.

use config::{NetConfig, RobotConfig, SiteConfig};

use crate::scenario::{Changes, Scenario, load};

fn file(folder: &str, name: &str) -> String {
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config");
    format!("{config}/{folder}/{name}.toml")
}

pub(crate) fn site(name: &str) -> SiteConfig {
    config::load_site(file("sites", name), &[]).expect("the site that ships is good")
}

pub(crate) fn net(name: &str) -> NetConfig {
    config::load_net(file("nets", name)).expect("the net that ships is good")
}

pub(crate) fn robot(name: &str) -> RobotConfig {
    config::load_robot(file("robots", name), &[]).expect("the robot that ships is good")
}

pub(crate) fn scenario(name: &str) -> Scenario {
    let loaded = load(file("scenarios", name).as_ref(), &Changes::default());
    loaded.expect("the scenario that ships is good")
}
