//! Answers robots that ask for their next certificate.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use contract::wire::{CertificateAnswer, CertificateRequest};

use super::Snapshot;

/// A robot gets no certificate sooner than this after it has asked for its last one: making one takes a signature.
const PAUSE: Duration = Duration::from_secs(1);
/// That it has got one is logged no sooner than this after the last time.
const LOGGED_AGAIN: Duration = Duration::from_secs(60);

/// Answers those on the list.
pub(crate) struct Renewals {
    snapshot: Snapshot,
    last: BTreeMap<String, Instant>,
    logged: BTreeMap<String, Instant>,
}

impl Renewals {
    pub(crate) fn new(snapshot: Snapshot) -> Self {
        Self {
            snapshot,
            last: BTreeMap::new(),
            logged: BTreeMap::new(),
        }
    }

    /// Whether that `robot` has got one is to be logged now: one that asks again and again fills no disk.
    pub(crate) fn is_news(&mut self, robot: &str) -> bool {
        if { self.logged.get(robot) }.is_some_and(|last| last.elapsed() < LOGGED_AGAIN) {
            return false;
        }
        self.logged.insert(robot.to_owned(), Instant::now());
        true
    }

    /// The answer to `robot`, whose certificate has let it ask under its name.
    pub(crate) fn answer(
        &mut self,
        robot: &str,
        request: &CertificateRequest,
    ) -> CertificateAnswer {
        let refused = |refusal: String| CertificateAnswer {
            refusal,
            ..CertificateAnswer::default()
        };
        if { self.last.get(robot) }.is_some_and(|last| last.elapsed() < PAUSE) {
            return refused(format!("expected one request in {PAUSE:?} at most"));
        }
        // Also to read one that is no good takes time, on the thread that carries all links.
        self.last.insert(robot.to_owned(), Instant::now());
        match self.snapshot.certificate(robot, &request.request_pem) {
            Ok(certificate_pem) => {
                let half_s = self.snapshot.registry().days * 43_200.0;
                CertificateAnswer {
                    certificate_pem,
                    renew_after_s: half_s.min(f64::from(u32::MAX)) as u32,
                    refusal: String::new(),
                }
            }
            Err(why) => refused(why),
        }
    }
}
