//! Answers robots that ask for their next certificate.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use contract::wire::{CertificateAnswer, CertificateRequest};

use super::Snapshot;

/// A robot gets no certificate sooner than this after its last one: making one takes a signature.
const PAUSE: Duration = Duration::from_secs(1);

/// Answers those on the list.
pub(crate) struct Renewals {
    snapshot: Snapshot,
    last: BTreeMap<String, Instant>,
}

impl Renewals {
    pub(crate) fn new(snapshot: Snapshot) -> Self {
        Self {
            snapshot,
            last: BTreeMap::new(),
        }
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
        match self.snapshot.certificate(robot, &request.request_pem) {
            Ok(certificate_pem) => {
                self.last.insert(robot.to_owned(), Instant::now());
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
