//! Nets bound to protocols. In the crate itself, because some of these nets no analysis lets pass.

mod aborts;
mod fit;
mod kinds;
mod lossy;
mod net;
mod proof;

use std::sync::Arc;

use crate::protocol::{Protocol, ProtocolModel};

/// A robot asks, the mediator grants, the robot leaves; `keeper` may abort.
pub fn area(keeper: &str) -> Arc<Protocol> {
    let mut model = ProtocolModel::new("area", "robot", "mediator");
    model.keeper(keeper).array(
        "all",
        &[
            ("request", "robot"),
            ("granted", "mediator"),
            ("released", "robot"),
        ],
    );
    Arc::new(model.compile().unwrap())
}
