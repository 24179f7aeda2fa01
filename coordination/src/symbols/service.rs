//! Which of iceoryx2's mechanisms the table is made of.

use std::fmt::Debug;

use iceoryx2::prelude::ZeroCopySend;
use iceoryx2::service;
use iceoryx2::service::internal::ServiceInternal;
use iceoryx2::service::{ipc_threadsafe, local_threadsafe};
use iceoryx2_bb_elementary_traits::testing::abandonable::Abandonable;

/// iceoryx2's variant for several processes, but for its counter of nodes. Handles can be sent to, and dropped in, any thread.
///
/// iceoryx2 keeps that counter in shared memory which it makes writable by everybody (mode 0666, whatever the umask). It only
/// tells apart nodes of one process, since their ids also name process and time; so here each process counts for itself.
#[derive(Clone, Debug)]
pub(super) struct Service {}

type Shared = ipc_threadsafe::Service;
type Local = local_threadsafe::Service;

impl service::Service for Service {
    type PersistentDynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> =
        <Local as service::Service>::PersistentDynamicStorage<T>;

    type StaticStorage = <Shared as service::Service>::StaticStorage;
    type ConfigSerializer = <Shared as service::Service>::ConfigSerializer;
    type Bag = <Shared as service::Service>::Bag;
    type DynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> =
        <Shared as service::Service>::DynamicStorage<T>;
    type ServiceNameHasher = <Shared as service::Service>::ServiceNameHasher;
    type SharedMemory = <Shared as service::Service>::SharedMemory;
    type ResizableSharedMemory = <Shared as service::Service>::ResizableSharedMemory;
    type Connection = <Shared as service::Service>::Connection;
    type Event = <Shared as service::Service>::Event;
    type Monitoring = <Shared as service::Service>::Monitoring;
    type Reactor = <Shared as service::Service>::Reactor;
    type ArcThreadSafetyPolicy<T: Send + Debug + Abandonable> =
        <Shared as service::Service>::ArcThreadSafetyPolicy<T>;
    type BlackboardMgmt<T: Send + Sync + Debug + ZeroCopySend + 'static> =
        <Shared as service::Service>::BlackboardMgmt<T>;
    type BlackboardPayload = <Shared as service::Service>::BlackboardPayload;
    type UniqueId = <Shared as service::Service>::UniqueId;
}

impl ServiceInternal<Service> for Service {}
