//! Whether two nets commanded one robot at once.

use crate::network::observations::Controlled;
use crate::scenario::Scenario;

/// Coordinations that went on after another one had taken a robot from them, as robot, time, and a sentence. Where an older copy of a
/// journal is in use nothing is asked: the one that was at work when it was made goes on, until robots say what came after it.
#[must_use]
pub fn two_nets(scenario: &Scenario, controlled: &[Controlled]) -> Vec<(String, u64, String)> {
    if scenario.uses_older_journal() {
        return Vec::new();
    }
    { controlled.iter() }
        .filter_map(|own| {
            let (rival, at_ns) = own.rival?;
            let detail = format!(
                "coordination {rival} has taken over {}, and coordination {} ({}) goes on",
                own.robot, own.number, own.net
            );
            Some((own.robot.clone(), at_ns, detail))
        })
        .collect()
}
