//! Whether two nets commanded one robot at once.

use crate::network::observations::Controlled;

/// Coordinations that went on after another one had taken a robot from them, as robot, time, and a sentence.
#[must_use]
pub fn two_nets(controlled: &[Controlled]) -> Vec<(String, u64, String)> {
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
