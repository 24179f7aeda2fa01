//! What of this library can be registered, and how it is made.

use std::sync::Arc;

use thiserror::Error;

use crate::analysis::{Limits, Refusal, Report, Use, check};
use crate::binding::{BindError, NetBinding};
use crate::event::EventTable;
use crate::fsm::{self, Machine, MachineModel};
use crate::petri::{self, Executor, NetModel};
use crate::protocol::{self, End, Protocol, ProtocolModel, Side};

/// A coordination object.
#[derive(Debug)]
pub enum Mechanism<S = End> {
    /// A net whose events the owner carries in and out.
    Net(Executor),
    /// A state machine.
    Machine(Machine),
    /// A protocol, of which channels and replicas are made.
    Protocol(Arc<Protocol>),
    /// A net together with the protocols that it is bound to.
    Coordination(NetBinding<S>),
}

/// Why a mechanism was not made.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MechanismError {
    /// The analysis refused the net.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The net does not compile.
    #[error("{}", joined(.0))]
    Net(Vec<petri::ModelError>),
    /// The machine does not compile.
    #[error(transparent)]
    Machine(#[from] fsm::ModelError),
    /// The protocol does not compile.
    #[error(transparent)]
    Protocol(#[from] protocol::ModelError),
    /// The net does not fit its protocols.
    #[error("{}", joined(.0))]
    Bind(Vec<BindError>),
}

impl<S> Mechanism<S> {
    /// A net that passes the analysis with `uses`, in its initial marking.
    pub fn net(
        model: &NetModel,
        uses: &[Use],
        limits: &Limits,
        events: &mut EventTable,
    ) -> Result<(Self, Report), MechanismError> {
        let report = check(model, uses, limits)?;
        let net = model.compile(events).map_err(MechanismError::Net)?;
        Ok((Self::Net(net.executor()), report))
    }

    /// A machine in its initial state.
    pub fn machine(model: &MachineModel, events: &mut EventTable) -> Result<Self, MechanismError> {
        Ok(Self::Machine(model.compile(events)?))
    }

    /// A protocol.
    pub fn protocol(model: &ProtocolModel) -> Result<Self, MechanismError> {
        Ok(Self::Protocol(Arc::new(model.compile()?)))
    }
}

impl<S: Side> Mechanism<S> {
    /// A net that passes the analysis with the protocols of `sides`, bound to them, in its initial
    /// marking. The sides come under the names that the net's bindings use.
    pub fn coordination(
        model: &NetModel,
        sides: Vec<(Box<str>, S)>,
        limits: &Limits,
        events: &mut EventTable,
    ) -> Result<(Self, Report), MechanismError> {
        let uses: Vec<Use> = sides
            .iter()
            .map(|(name, side)| {
                let protocol = Arc::new(side.protocol().clone());
                Use::new(&**name, protocol, side.party())
            })
            .collect();
        let report = check(model, &uses, limits)?;
        let net = model.compile(events).map_err(MechanismError::Net)?;
        let binding = NetBinding::new(&net, sides).map_err(MechanismError::Bind)?;
        Ok((Self::Coordination(binding), report))
    }
}

fn joined<T: ToString>(errors: &[T]) -> String {
    let texts: Vec<String> = errors.iter().map(T::to_string).collect();
    texts.join("; ")
}
