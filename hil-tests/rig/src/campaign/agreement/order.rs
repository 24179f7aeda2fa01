//! Whether the transitions of a net fired in the same order, as far as the net orders them.

use std::collections::{BTreeMap, BTreeSet};

use config::NetConfig;

use crate::summary::FiringSummary;

/// What fires within this time fires at once.
const AT_ONCE_S: f64 = 0.1;

/// The places that each transition of a net takes tokens from or puts tokens into. Two that have none in common do not depend on
/// each other: which of them comes first hangs on whose answer is there first, and the net comes to the same.
pub(super) struct Touched(BTreeMap<String, BTreeSet<String>>);

impl Touched {
    /// Of a net. Where there is none, every transition depends on every other one.
    pub(super) fn by(net: Option<&NetConfig>) -> Self {
        let transitions = net.into_iter().flat_map(|net| &net.transitions);
        let places = transitions.map(|own| {
            let places = own.from.iter().chain(&own.to).cloned();
            (own.id.clone(), places.collect())
        });
        Self(places.collect())
    }

    fn depend(&self, one: &str, other: &str) -> bool {
        match (self.0.get(one), self.0.get(other)) {
            (Some(one), Some(other)) => !one.is_disjoint(other),
            _ => true,
        }
    }

    /// Where a real and a stepped run of the net do not agree: something fired more often in one of them, or they have another order of
    /// two firings that depend on each other, or that neither has at once.
    pub(super) fn difference(
        &self,
        real: &[FiringSummary],
        stepped: &[FiringSummary],
    ) -> Option<String> {
        let (firings, others) = (numbered(real), numbered(stepped));
        let places: BTreeMap<Firing, usize> = others.iter().copied().zip(0..).collect();
        let fired: BTreeSet<Firing> = firings.iter().copied().collect();
        if !fired.iter().eq(places.keys()) {
            let [real, stepped] = [real, stepped].map(|run| {
                let names = run.iter().map(|own| own.transition.as_str());
                names.collect::<Vec<_>>()
            });
            return Some(format!("real {real:?}, stepped {stepped:?}"));
        }
        for (first, one) in firings.iter().enumerate() {
            for (second, other) in firings.iter().enumerate().skip(first + 1) {
                let (at, other_at) = (places[one], places[other]);
                let gaps_s = [
                    real[second].at_s - real[first].at_s,
                    stepped[at].at_s - stepped[other_at].at_s,
                ];
                let ordered =
                    self.depend(one.0, other.0) || gaps_s.iter().all(|&gap_s| gap_s > AT_ONCE_S);
                if other_at < at && ordered {
                    return Some(format!(
                        "`{}` before `{}` in the real run, after it in the stepped one",
                        one.0, other.0
                    ));
                }
            }
        }
        None
    }
}

/// A transition, and how often it had fired before.
type Firing<'a> = (&'a str, usize);

fn numbered(firings: &[FiringSummary]) -> Vec<Firing<'_>> {
    let mut fired: BTreeMap<&str, usize> = BTreeMap::new();
    let mut numbered = Vec::with_capacity(firings.len());
    for firing in firings {
        let before = fired.entry(&firing.transition).or_default();
        numbered.push((firing.transition.as_str(), *before));
        *before += 1;
    }
    numbered
}
