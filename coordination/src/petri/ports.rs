//! The sources and sinks of a running net, as indices into the net's lists of them.

use alloc::boxed::Box;
use alloc::vec;

/// A source or sink, an index into the net's list of them, changes.
#[derive(Clone, Copy, Debug)]
pub(in crate::petri) enum PortChange {
    SourceEmptied(u16),
    SinkFilled(u16),
}

/// What waits at the sources, and which sinks are full.
#[derive(Clone, Debug)]
pub(in crate::petri) struct Ports {
    /// By source: how many events wait.
    waiting: Box<[u32]>,
    /// Sources that are empty and have an event waiting; each once.
    to_fill: Stack,
    /// Full sinks, in the order in which they filled.
    full: Stack,
}

impl Ports {
    pub(in crate::petri) fn new(sources: usize, sinks: usize) -> Self {
        Self {
            waiting: vec![0; sources].into(),
            to_fill: Stack::with_capacity(sources),
            full: Stack::with_capacity(sinks),
        }
    }

    pub(in crate::petri) fn waiting(&self, source: usize) -> u32 {
        self.waiting[source]
    }

    /// [`restart_sources`](Self::restart_sources) follows.
    pub(in crate::petri) fn set_waiting(&mut self, source: usize, count: u32) {
        self.waiting[source] = count;
    }

    /// One more event waits for `source`.
    pub(in crate::petri) fn wait(&mut self, source: usize, is_empty: bool) {
        self.waiting[source] += 1;
        if is_empty && self.waiting[source] == 1 {
            self.to_fill.push(source);
        }
    }

    /// Takes note of what a firing did.
    #[inline(always)]
    pub(in crate::petri) fn change(&mut self, change: PortChange) {
        match change {
            PortChange::SourceEmptied(source) => self.emptied(usize::from(source)),
            PortChange::SinkFilled(sink) => self.filled(usize::from(sink)),
        }
    }

    pub(in crate::petri) fn emptied(&mut self, source: usize) {
        if self.waiting[source] > 0 {
            self.to_fill.push(source);
        }
    }

    /// A source that is empty and has an event waiting, which is used up.
    pub(in crate::petri) fn next_to_fill(&mut self) -> Option<usize> {
        let source = self.to_fill.pop()?;
        self.waiting[source] -= 1;
        Some(source)
    }

    pub(in crate::petri) fn can_fill(&self) -> bool {
        self.to_fill.len > 0
    }

    pub(in crate::petri) fn filled(&mut self, sink: usize) {
        self.full.push(sink);
    }

    pub(in crate::petri) fn full(&self) -> &[u16] {
        &self.full.items[..self.full.len]
    }

    /// Empties the full sinks that `keep` refuses, asking in order; how many.
    pub(in crate::petri) fn empty_sinks(&mut self, keep: impl FnMut(usize) -> bool) -> usize {
        self.full.retain(keep)
    }

    /// Nothing waits for `source` any more; how many events did. Looks at all sources that are to be
    /// filled if some did.
    pub(in crate::petri) fn forget_waiting(&mut self, source: usize) -> u32 {
        let waiting = core::mem::take(&mut self.waiting[source]);
        if waiting > 0 {
            self.to_fill.retain(|other| other != source);
        }
        waiting
    }

    /// Nothing waits for these sources any more; [`restart_sources`](Self::restart_sources) follows.
    pub(in crate::petri) fn forget_those(&mut self, forgets: impl Fn(usize) -> bool) {
        for (source, waiting) in self.waiting.iter_mut().enumerate() {
            if forgets(source) {
                *waiting = 0;
            }
        }
    }

    /// Nothing waits any more.
    pub(in crate::petri) fn forget(&mut self) {
        self.waiting.fill(0);
    }

    /// Takes note of a new marking.
    pub(in crate::petri) fn restart(
        &mut self,
        source_is_empty: impl Fn(usize) -> bool,
        sink_is_full: impl Fn(usize) -> bool,
    ) {
        self.restart_sources(source_is_empty);
        self.full.len = 0;
        for sink in 0..self.full.items.len() {
            if sink_is_full(sink) {
                self.full.push(sink);
            }
        }
    }

    /// Takes note of which sources are empty now.
    pub(in crate::petri) fn restart_sources(&mut self, source_is_empty: impl Fn(usize) -> bool) {
        self.to_fill.len = 0;
        for (source, &waiting) in self.waiting.iter().enumerate() {
            if waiting > 0 && source_is_empty(source) {
                self.to_fill.push(source);
            }
        }
    }
}

/// Small numbers in a memory of fixed size.
#[derive(Clone, Debug)]
struct Stack {
    items: Box<[u16]>,
    len: usize,
}

impl Stack {
    fn with_capacity(capacity: usize) -> Self {
        Self {
            items: vec![0; capacity].into(),
            len: 0,
        }
    }

    fn push(&mut self, item: usize) {
        self.items[self.len] = item as u16;
        self.len += 1;
    }

    fn pop(&mut self) -> Option<usize> {
        self.len = self.len.checked_sub(1)?;
        Some(usize::from(self.items[self.len]))
    }

    /// Drops the items that `keep` refuses, asking in order; how many.
    fn retain(&mut self, mut keep: impl FnMut(usize) -> bool) -> usize {
        let before = self.len;
        self.len = 0;
        for index in 0..before {
            let item = usize::from(self.items[index]);
            if keep(item) {
                self.push(item);
            }
        }
        before - self.len
    }
}
