//! What all parts of loading share: names, and what is wrong so far.

use std::collections::HashMap;

use config::SiteConfig;
use description::site::CoordinationConfig;

/// Why a coordination cannot run on its site.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("coordinations.{coordination}{}{place}: {what}", if .place.is_empty() { "" } else { "." })]
#[expect(missing_docs, reason = "the message says what each field is")]
pub struct PlanError {
    pub coordination: String,
    pub place: String,
    pub what: String,
}

pub(super) struct Loader<'a> {
    pub(super) id: &'a str,
    pub(super) coordination: &'a CoordinationConfig,
    pub(super) site: &'a SiteConfig,
    pub(super) areas: HashMap<&'a str, usize>,
    pub(super) robots: HashMap<&'a str, usize>,
    pub(super) errors: Vec<PlanError>,
}

impl<'a> Loader<'a> {
    pub(super) fn wrong(&mut self, place: impl Into<String>, what: impl Into<String>) {
        self.errors.push(PlanError {
            coordination: self.id.to_owned(),
            place: place.into(),
            what: what.into(),
        });
    }

    pub(super) fn is_role(&mut self, place: String, role: &str, known: &[&str]) {
        if !known.contains(&role) {
            let known = known.join(", ");
            self.wrong(
                place,
                format!("the net has no role `{role}`; it has {known}"),
            );
        }
    }

    pub(super) fn areas(&mut self, place: &str, ids: &[String]) -> Vec<usize> {
        let mut found = Vec::new();
        for id in ids {
            match self.areas.get(id.as_str()) {
                Some(&area) => found.push(area),
                None => self.wrong(place, format!("the site has no area `{id}`")),
            }
        }
        found
    }
}

pub(super) fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9) as u64
}
