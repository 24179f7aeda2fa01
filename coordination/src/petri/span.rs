//! A part of an array.

/// Some consecutive entries of an array.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::petri) struct Span {
    pub(in crate::petri) start: u32,
    pub(in crate::petri) end: u32,
}

impl Span {
    pub(in crate::petri) fn contains(self, index: u32) -> bool {
        (self.start..self.end).contains(&index)
    }

    pub(in crate::petri) fn of<T>(self, all: &[T]) -> &[T] {
        &all[self.start as usize..self.end as usize]
    }
}

/// From `start` to `end`.
pub(in crate::petri) fn span(start: usize, end: usize) -> Span {
    Span {
        start: start as u32,
        end: end as u32,
    }
}
