//! What the tests of all reports share.

use config::SiteConfig;

use crate::machine::Machine;
use crate::record::Record;
use crate::scenario::Limits;
use crate::summary::{Latency, Summary};

/// A run of a scenario in which nothing happened.
pub(super) fn empty(scenario: &str, site: SiteConfig) -> Record {
    Record {
        about: String::new(),
        site,
        nets: Vec::new(),
        limits: Limits::default(),
        robots: Vec::new(),
        obstacles: Vec::new(),
        holdings: Vec::new(),
        waits: Vec::new(),
        mediator: Vec::new(),
        incidents: Vec::new(),
        grant_latency_ms: Vec::new(),
        command_latency_ms: Vec::new(),
        summary: Summary {
            scenario: scenario.to_owned(),
            outcome: "done".to_owned(),
            seed: 0,
            duration_s: 0.0,
            machine: Machine {
                processor: "some processor".to_owned(),
                cores: 2,
                kernel: "6.1".to_owned(),
            },
            stalls: None,
            long_stalls: Vec::new(),
            stranded_by: None,
            stranded_since_s: None,
            spoiled: None,
            robots: Vec::new(),
            mediator: None,
            areas: Vec::new(),
            coordinations: Vec::new(),
            grants: Latency::default(),
            commands: Latency::default(),
            during: Vec::new(),
            violations: Vec::new(),
        },
    }
}

/// Repeatable numbers from 0 to 1.
pub(super) fn noise() -> impl FnMut() -> f64 {
    let mut state = 1_u64;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Checks that tags are closed in order, attributes quoted and `&` escaped; returns all texts.
pub(super) fn check_body(body: &str) -> Vec<String> {
    let mut open: Vec<&str> = Vec::new();
    let mut texts = Vec::new();
    for piece in body.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').expect("a tag ends");
        assert!(
            !text.contains('>') && tag.matches('"').count() % 2 == 0,
            "{piece}"
        );
        for entity in piece.split('&').skip(1) {
            let (name, _) = entity.split_once(';').expect("an entity ends");
            assert!(
                ["amp", "lt", "gt", "quot", "apos"].contains(&name),
                "{name}"
            );
        }
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(tag.split(' ').next().unwrap_or(tag));
        }
        for (index, part) in tag
            .split('"')
            .enumerate()
            .filter(|(index, _)| index % 2 == 0)
        {
            assert!(
                index == 0 || part.is_empty() || part == "/" || part.ends_with('='),
                "{tag}"
            );
        }
        assert!(!tag.contains("NaN") && !tag.contains("inf"), "{tag}");
        if !open.is_empty() {
            texts.push(text.trim().to_owned());
        }
    }
    assert_eq!(open, Vec::<&str>::new());
    texts
}
