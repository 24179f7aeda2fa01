//! A fleet with certificates on every link: they are renewed, revoked and exchanged while robots drive.

use std::path::PathBuf;
use std::time::Duration;

use contract::network::Party;
use contract::private;
use mediator::keys::Keys;
use onboard::symbols::faults::Fault;
use rig::run::Ending;
use serde_json::Value as Json;

use crate::programs::fleet::{Bench, Run, has, overtaking, waits};
use crate::programs::late::once_more_if_late;

const PATIENCE: Duration = Duration::from_secs(60);
const ROBOTS: [&str; 2] = ["amr-1", "amr-2"];

fn file(run: &Run, robot: &str) -> PathBuf {
    run.stage.folder().join(format!("{robot}.pem"))
}

fn text(run: &Run, robot: &str) -> String {
    std::fs::read_to_string(file(run, robot)).unwrap_or_default()
}

/// How often a robot has found its mediator silent.
fn silences(summary: &Json, robot: &str) -> u64 {
    let robots = summary["robots"].as_array().into_iter().flatten();
    let faults = robots
        .filter(|own| own["id"] == robot)
        .filter_map(|own| own["faults"].as_array())
        .flatten();
    faults
        .filter(|fault| fault[0] == Fault::MediatorSilent.name())
        .filter_map(|fault| fault[1].as_u64())
        .sum()
}

#[test]
#[ignore = "CI makes these runs"]
fn robots_overtake_while_certificates_are_renewed_revoked_and_exchanged() {
    once_more_if_late(|| {
        let mut bench = Bench::start_secured(overtaking());
        let first = ROBOTS.map(|robot| text(&bench.run, robot));
        bench.until("both have other certificates", PATIENCE, |run| {
            { ROBOTS.iter().zip(&first) }.all(|(robot, first)| {
                let now = text(run, robot);
                !now.is_empty() && now != *first
            })
        });
        bench.until("both have where they stand", PATIENCE, |run| {
            has(run, "amr-1", "6") && has(run, "amr-2", "4")
        });
        let keys = Keys::new(bench.run.stage.folder().join("keys"));
        let amr_1 = || Party::Robot("amr-1".to_owned());
        keys.revoke(&amr_1()).expect("revoked");
        // It stands in area 6, in front of the other one, and goes nowhere.
        bench.until("amr-2 asks for area 6", PATIENCE, |run| {
            waits(run, "amr-2", "6")
        });
        bench.holds_for("nobody gets area 6", Duration::from_secs(3), |run| {
            !has(run, "amr-2", "6") && run.judge.violations().is_empty()
        });
        let identity = keys.issue(amr_1()).expect("made");
        let path = file(&bench.run, "amr-1");
        private::replace(&path, identity.to_pem().as_bytes()).expect("written");
        let ending = bench.until_end();
        let (result, summary, _) = bench.finish(&ending);
        assert_eq!(ending, Ending::Done, "{summary:#}");
        assert!(result.is_ok(), "{result:?}");
        assert!(silences(&summary, "amr-1") > 0, "{summary:#}");
        // The mediator has opened its network anew twice meanwhile.
        assert_eq!(silences(&summary, "amr-2"), 0, "{summary:#}");
    });
}
