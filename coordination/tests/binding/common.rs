//! Protocols for the tests.

use std::sync::Arc;

use coordination::protocol::{Protocol, ProtocolModel};

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
