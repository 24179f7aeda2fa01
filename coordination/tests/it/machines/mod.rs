//! Machines that property tests draw.

use std::collections::HashMap;

use coordination::fsm::MachineModel;

/// Outputs, which may repeat and be inputs too.
type Outputs = Vec<u8>;

/// Six states with these transitions: from, input, to. A ring keeps every state reachable.
pub fn drawn(arcs: &HashMap<(u8, u8), (u8, Outputs)>) -> MachineModel {
    let mut model = MachineModel::new("random");
    for state in 0..6 {
        model.state(format!("s{state}"));
    }
    model.initial("s0");
    for state in 0..6 {
        let next = format!("s{}", (state + 1) % 6);
        model.transition(&format!("s{state}"), "ring", &next, &[]);
    }
    for (&(from, on), (to, outputs)) in arcs {
        let outputs: Vec<String> = outputs.iter().map(|o| format!("e{o}")).collect();
        let outputs: Vec<&str> = outputs.iter().map(String::as_str).collect();
        let (from, on, to) = (format!("s{from}"), format!("e{on}"), format!("s{to}"));
        model.transition(&from, &on, &to, &outputs);
    }
    model
}
