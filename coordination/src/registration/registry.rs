//! The table of registrations.

use std::collections::BTreeMap;
use std::fmt;

use super::error::{ConfigureError, RegistryError};
use super::semantic_id::SemanticId;
use crate::activity::{LifeCycle, LifeCycleEvent, LifeCycleState};

/// Stands for one registration, from its creation to its deletion, in the registry that gave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Handle {
    slot: u32,
    generation: u32,
}

impl fmt::Display for Handle {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}.{}", self.slot, self.generation)
    }
}

/// A registration, to look at.
#[derive(Debug, PartialEq, Eq)]
pub struct Registered<'a, T> {
    /// What it is called.
    pub id: &'a SemanticId,
    /// The one activity that is responsible for it.
    pub owner: &'a str,
    /// Where it is in its life.
    pub state: LifeCycleState,
    /// The object; none before it is configured.
    pub object: Option<&'a T>,
}

#[derive(Debug)]
struct Entry<T> {
    id: SemanticId,
    owner: Box<str>,
    life: LifeCycle,
    object: Option<T>,
}

impl<T> Entry<T> {
    fn step(&mut self, event: LifeCycleEvent) -> Result<(), RegistryError> {
        if self.life.accepts(event) {
            self.life.step(event);
            return Ok(());
        }
        Err(RegistryError::NotNow {
            id: self.id.clone(),
            state: self.life.state(),
            wanted: event,
        })
    }

    fn view(&self) -> Registered<'_, T> {
        Registered {
            id: &self.id,
            owner: &self.owner,
            state: self.life.state(),
            object: self.object.as_ref(),
        }
    }
}

#[derive(Debug)]
struct Slot<T> {
    /// Of the entry, or of the next one.
    generation: u32,
    entry: Option<Entry<T>>,
}

/// Objects under their semantic ids; see [the module](super).
#[derive(Debug)]
pub struct Registry<T> {
    slots: Vec<Slot<T>>,
    free: Vec<u32>,
    by_id: BTreeMap<SemanticId, u32>,
    capacity: usize,
}

impl<T> Registry<T> {
    /// An empty registry for at most `capacity` registrations at a time.
    pub fn new(capacity: usize) -> Self {
        let capacity = capacity.min(u32::MAX as usize);
        Self {
            slots: Vec::new(),
            free: Vec::new(),
            by_id: BTreeMap::new(),
            capacity,
        }
    }

    /// Registers `id` for the activity `owner`, without an object yet.
    pub fn create(
        &mut self,
        id: SemanticId,
        owner: impl Into<Box<str>>,
    ) -> Result<Handle, RegistryError> {
        if let Some(&slot) = self.by_id.get(&id) {
            let entry = self.slots[slot as usize].entry.as_ref();
            let owner = entry.map_or("", |entry| &entry.owner).to_owned();
            return Err(RegistryError::Taken { id, owner });
        }
        if self.by_id.len() >= self.capacity {
            let capacity = self.capacity;
            return Err(RegistryError::Full { id, capacity });
        }
        let slot = self.free.pop().unwrap_or_else(|| {
            self.slots.push(Slot {
                generation: 0,
                entry: None,
            });
            (self.slots.len() - 1) as u32
        });
        self.by_id.insert(id.clone(), slot);
        let place = &mut self.slots[slot as usize];
        place.entry = Some(Entry {
            id,
            owner: owner.into(),
            life: LifeCycle::new(),
            object: None,
        });
        Ok(Handle {
            slot,
            generation: place.generation,
        })
    }

    /// Makes the object with `build`, after dropping what there was; then it is ready. If `build`
    /// fails, the registration stays configuring and can be configured again.
    pub fn configure<E>(
        &mut self,
        handle: Handle,
        build: impl FnOnce(&SemanticId) -> Result<T, E>,
    ) -> Result<(), ConfigureError<E>> {
        let entry = self.entry_mut(handle)?;
        if entry.life.state() != LifeCycleState::Configuring {
            entry.step(LifeCycleEvent::Configure)?;
        }
        entry.object = None;
        match build(&entry.id) {
            Ok(object) => {
                entry.object = Some(object);
                Ok(entry.step(LifeCycleEvent::Configured)?)
            }
            Err(error) => Err(ConfigureError::Failed(error)),
        }
    }

    /// Changes the object with `change`; then it is ready, whether it ran before or not. If
    /// `change` fails, the object is dropped and has to be configured.
    pub fn reconfigure<E>(
        &mut self,
        handle: Handle,
        change: impl FnOnce(&mut T) -> Result<(), E>,
    ) -> Result<(), ConfigureError<E>> {
        let entry = self.entry_mut(handle)?;
        entry.step(LifeCycleEvent::Reconfigure)?;
        // Whoever may be reconfigured holds an object.
        match entry.object.as_mut().map_or(Ok(()), change) {
            Ok(()) => Ok(entry.step(LifeCycleEvent::Configured)?),
            Err(error) => {
                entry.object = None;
                entry.step(LifeCycleEvent::Fault)?;
                Err(ConfigureError::Failed(error))
            }
        }
    }

    /// Starts or continues it. Real time.
    pub fn run(&mut self, handle: Handle) -> Result<(), RegistryError> {
        self.entry_mut(handle)?.step(LifeCycleEvent::Run)
    }

    /// Lets it rest; it keeps its object. Real time.
    pub fn pause(&mut self, handle: Handle) -> Result<(), RegistryError> {
        self.entry_mut(handle)?.step(LifeCycleEvent::Pause)
    }

    /// Ends it. The object can still be looked at, until it is deleted or configured again.
    pub fn stop(&mut self, handle: Handle) -> Result<(), RegistryError> {
        self.entry_mut(handle)?.step(LifeCycleEvent::Stop)
    }

    /// Deletes a registration that does not run, and gives its object back. The handle is stale
    /// from now on, and the id is free.
    pub fn delete(&mut self, handle: Handle) -> Result<Option<T>, RegistryError> {
        let entry = self.entry_mut(handle)?;
        if entry.life.state() == LifeCycleState::Running {
            let id = entry.id.clone();
            return Err(RegistryError::InUse { id });
        }
        let place = &mut self.slots[handle.slot as usize];
        let entry = place.entry.take().ok_or(RegistryError::Stale { handle })?;
        self.by_id.remove(&entry.id);
        // A slot that has seen every generation is never used again.
        if let Some(next) = place.generation.checked_add(1) {
            place.generation = next;
            self.free.push(handle.slot);
        }
        Ok(entry.object)
    }

    /// The registration behind a handle. Real time.
    pub fn get(&self, handle: Handle) -> Result<Registered<'_, T>, RegistryError> {
        let slot = self.slots.get(handle.slot as usize);
        slot.filter(|slot| slot.generation == handle.generation)
            .and_then(|slot| slot.entry.as_ref())
            .map(Entry::view)
            .ok_or(RegistryError::Stale { handle })
    }

    /// The object behind a handle, if it is running. Real time.
    pub fn running(&mut self, handle: Handle) -> Result<&mut T, RegistryError> {
        let entry = self.entry_mut(handle)?;
        let state = entry.life.state();
        match (&mut entry.object, state) {
            (Some(object), LifeCycleState::Running) => Ok(object),
            _ => Err(RegistryError::NotRunning {
                id: entry.id.clone(),
                state,
            }),
        }
    }

    /// The handle of an id.
    pub fn find(&self, id: &SemanticId) -> Option<Handle> {
        let &slot = self.by_id.get(id)?;
        let generation = self.slots[slot as usize].generation;
        Some(Handle { slot, generation })
    }

    /// All registrations, in the order of their ids.
    pub fn iter(&self) -> impl Iterator<Item = (Handle, Registered<'_, T>)> {
        self.by_id.values().filter_map(|&slot| {
            let place = &self.slots[slot as usize];
            let generation = place.generation;
            let view = place.entry.as_ref()?.view();
            Some((Handle { slot, generation }, view))
        })
    }

    /// All objects that are running, in no order that means anything. Real time.
    pub fn iter_running(&mut self) -> impl Iterator<Item = (Handle, &SemanticId, &mut T)> {
        self.slots.iter_mut().zip(0..).filter_map(|(place, slot)| {
            let generation = place.generation;
            let entry = place.entry.as_mut()?;
            let running = entry.life.state() == LifeCycleState::Running;
            let object = entry.object.as_mut().filter(|_| running)?;
            Some((Handle { slot, generation }, &entry.id, object))
        })
    }

    /// How many registrations there are.
    pub fn len(&self) -> usize {
        self.by_id.len()
    }

    /// Whether nothing is registered.
    pub fn is_empty(&self) -> bool {
        self.by_id.is_empty()
    }

    /// How many registrations fit.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    fn entry_mut(&mut self, handle: Handle) -> Result<&mut Entry<T>, RegistryError> {
        let slot = self.slots.get_mut(handle.slot as usize);
        slot.filter(|slot| slot.generation == handle.generation)
            .and_then(|slot| slot.entry.as_mut())
            .ok_or(RegistryError::Stale { handle })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slot_that_has_seen_every_generation_is_retired() {
        let mut registry = Registry::<()>::new(1);
        let id = SemanticId::new("thing", "one");
        let first = registry.create(id.clone(), "me").unwrap();
        registry.slots[0].generation = u32::MAX;
        let last = Handle {
            generation: u32::MAX,
            ..first
        };
        registry.delete(last).unwrap();
        assert_eq!(
            registry.get(last),
            Err(RegistryError::Stale { handle: last })
        );
        let next = registry.create(id, "me").unwrap();
        assert_eq!((next.slot, next.generation), (1, 0));
    }
}
