//! Where a net stands, and whether its proof reaches there.

use super::error::BindError;
use super::wiring::Wiring;
use crate::analysis::Proof;
use crate::petri::{Executor, PlaceId};
use crate::protocol::{Position, Side};

/// Where a net stands, for a journal: together with the levels up to which its sides have read
/// ([`Replica::read_level`](crate::protocol::Replica::read_level)) it is the whole state.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Standing {
    /// The marked places.
    pub marked: Vec<PlaceId>,
    /// Sources and how many events wait for each, as far as some do.
    pub waiting: Vec<(PlaceId, u32)>,
}

impl Standing {
    pub(super) fn of(executor: &Executor) -> Self {
        let sources = executor.net().sources().iter();
        let waiting = sources.map(|&(place, _)| (place, executor.waiting(place)));
        Self {
            marked: executor.marking().collect(),
            waiting: waiting.filter(|&(_, count)| count > 0).collect(),
        }
    }

    pub(super) fn restore(&self, executor: &mut Executor) -> Result<(), Vec<BindError>> {
        let unknown = |place: PlaceId| vec![BindError::UnknownPlace { place: place.0 }];
        { executor.set_marking(&self.marked) }.map_err(|error| unknown(error.place))?;
        for &(source, count) in &self.waiting {
            if count > Executor::MAX_WAITING {
                let (place, found) = (source.0, count);
                return Err(vec![BindError::TooManyWait { place, found }]);
            }
            if !executor.set_waiting(source, count) {
                return Err(unknown(source));
            }
        }
        Ok(())
    }
}

/// Whether `proof` is one of this net with these sides, and reaches the state that they are in.
pub(super) fn check_proof<S: Side>(
    proof: &Proof,
    executor: &Executor,
    wiring: &Wiring,
    sides: &[S],
) -> Result<(), Vec<BindError>> {
    let net = executor.net();
    if !proof.model().is_same(&net.model()) {
        return Err(vec![BindError::OtherModel {
            net: net.name().to_owned(),
            proved: proof.model().name().to_owned(),
        }]);
    }
    let mut errors = Vec::new();
    for port in &wiring.ports {
        if proof.uses().iter().all(|used| *used.name != *port.name) {
            let protocol = port.name.to_string();
            errors.push(BindError::NotInProof { protocol });
        }
    }
    let mut positions = vec![Position::START; proof.uses().len()];
    for (position, used) in positions.iter_mut().zip(proof.uses()) {
        let protocol = used.name.clone();
        let Some(number) = { wiring.ports.iter() }.position(|port| *port.name == *used.name) else {
            errors.push(BindError::NoSide { protocol });
            continue;
        };
        let side = &sides[number];
        if side.party() != used.net_party || *side.protocol() != *used.protocol {
            errors.push(BindError::OtherProtocol { protocol });
        }
        *position = side.read_to();
    }
    if errors.is_empty()
        && !proof.reaches(
            |p| executor.is_marked(p),
            |p| executor.waiting(p),
            &positions,
        )
    {
        let marked = executor.marking().map(|place| net.place_name(place));
        let at = proof.uses().iter().zip(&positions);
        let at = at.map(|(used, &at)| format!("{}: {}", used.name, used.protocol.describe(at)));
        errors.push(BindError::NotReached {
            net: net.name().to_owned(),
            marked: marked.collect::<Vec<_>>().join(", "),
            positions: at.collect::<Vec<_>>().join("; "),
        });
    }
    if errors.is_empty() {
        Ok(())
    } else {
        Err(errors)
    }
}
