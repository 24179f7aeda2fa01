//! What a registry refuses.

use thiserror::Error;

use super::registry::Handle;
use super::semantic_id::SemanticId;
use crate::activity::{LifeCycleEvent, LifeCycleState};

/// Why a registry did not do what was asked. Nothing changed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RegistryError {
    /// Every place is taken.
    #[error("no room for `{id}`: {capacity} are registered already")]
    Full {
        /// What found no room.
        id: SemanticId,
        /// How many fit.
        capacity: usize,
    },
    /// The id is taken.
    #[error("`{id}` is registered already, by `{owner}`")]
    Taken {
        /// The id.
        id: SemanticId,
        /// Who owns it.
        owner: String,
    },
    /// The handle's registration was deleted, or never was one of this registry's.
    #[error("handle {handle} stands for nothing that is registered")]
    Stale {
        /// The handle.
        handle: Handle,
    },
    /// The life cycle does not allow that now.
    #[error("`{id}` is {state}, so it cannot {wanted}")]
    NotNow {
        /// The registration.
        id: SemanticId,
        /// Where it is in its life.
        state: LifeCycleState,
        /// What was asked.
        wanted: LifeCycleEvent,
    },
    /// Only something that runs can be used.
    #[error("`{id}` is {state}, not running")]
    NotRunning {
        /// The registration.
        id: SemanticId,
        /// Where it is in its life.
        state: LifeCycleState,
    },
    /// Something that runs must be stopped or paused before it is deleted.
    #[error("`{id}` is running, so it cannot be deleted")]
    InUse {
        /// The registration.
        id: SemanticId,
    },
}

/// Why a registration was not configured.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ConfigureError<E> {
    /// The registry refused; nothing changed.
    #[error(transparent)]
    Registry(#[from] RegistryError),
    /// The object could not be made or changed. The registration holds none now and is configuring.
    #[error("{0}")]
    Failed(E),
}
