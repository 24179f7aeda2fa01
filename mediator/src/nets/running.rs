//! The coordinations that run.

use super::instance::Instance;

/// One of those that run, for as long as it does, whatever [replaces](Running::replace) it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Handle(u64);

/// Instances in the order of their start. An instance can give way to another one that has a number of
/// its own; both have the handle, and the name for people, of the first.
#[derive(Debug, Default)]
pub(crate) struct Running {
    all: Vec<(Handle, Instance)>,
}

impl Running {
    /// Takes in an instance, whose number no other one has had.
    pub(crate) fn start(&mut self, instance: Instance) -> Handle {
        let handle = Handle(instance.number);
        self.all.push((handle, instance));
        handle
    }

    pub(crate) fn handles(&self) -> Vec<Handle> {
        self.all.iter().map(|&(handle, _)| handle).collect()
    }

    pub(crate) fn instances(&self) -> impl Iterator<Item = &Instance> {
        self.all.iter().map(|(_, instance)| instance)
    }

    /// The first instance for which `fits` holds.
    pub(crate) fn find(&self, fits: impl Fn(&Instance) -> bool) -> Option<Handle> {
        let found = self.all.iter().find(|(_, instance)| fits(instance));
        found.map(|&(handle, _)| handle)
    }

    pub(crate) fn get(&self, handle: Handle) -> Option<&Instance> {
        let found = self.all.iter().find(|(other, _)| *other == handle);
        found.map(|(_, instance)| instance)
    }

    pub(crate) fn get_mut(&mut self, handle: Handle) -> Option<&mut Instance> {
        let found = self.all.iter_mut().find(|(other, _)| *other == handle);
        found.map(|(_, instance)| instance)
    }

    /// Puts `next` in the place of an instance, which is returned.
    pub(crate) fn replace(&mut self, handle: Handle, next: Instance) -> Option<Instance> {
        self.get_mut(handle)
            .map(|instance| std::mem::replace(instance, next))
    }

    pub(crate) fn end(&mut self, handle: Handle) -> Option<Instance> {
        let index = self.all.iter().position(|(other, _)| *other == handle)?;
        Some(self.all.remove(index).1)
    }

    /// What people call it: `<coordination>/<number>`.
    pub(crate) fn name(&self, handle: Handle) -> String {
        let instance = self.get(handle);
        instance.map_or_else(String::new, |own| format!("{}/{}", own.plan.id, handle.0))
    }
}
