//! Rules that can be taken away, each at the border of the product: what it is told, when, and what is done with its answers.

use contract::timing::{ENTERS_NO_MORE_NS, SILENT_AFTER_NS};

use super::world::{AWAY, FENCES, Limits, MEDIATOR, MESSAGES, PROCESSES, SECOND};

/// A rule of `contract/PROTOCOL.md`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// No part of a robot is in an area that it was not granted.
    Grant,
    /// It newly reaches into one only while it has a lease.
    Lease,
    /// It has entered, or stands, 3.9 s after it last might.
    EntersWithin,
    /// Before a silent robot enters nothing any more, an operator takes nothing from it.
    EntersNoMore,
    /// Until then 0.1 s pass for clocks that differ.
    Drift,
    /// Who clears an area in which a robot stands, as it has said, is asked whether it was taken away.
    AsksTwice,
    /// A silent robot blocks its areas until an operator has looked.
    SilenceBlocks,
    /// A mediator that has started waits until every robot has said where it stands.
    Awaited,
    /// What was heard before a start counts as heard then.
    BeforeStart,
    /// Until it would enter nothing any more, a mediator that has started does not believe a process that it does not know where the
    /// body goes.
    NewProcess,
    /// A robot is believed the grants that the journal has lost.
    Adopted,
    /// A new process is taken in when the one before enters nothing any more.
    OneProcess,
    /// Reports of an earlier boot, session or epoch do not count.
    Session,
    /// Messages of an earlier start of the mediator are from the past.
    Epoch,
    /// What gives a grant back names it by its fence.
    Fence,
}

impl Rule {
    pub const ALL: [Self; 15] = [
        Self::Grant,
        Self::Lease,
        Self::EntersWithin,
        Self::EntersNoMore,
        Self::Drift,
        Self::AsksTwice,
        Self::SilenceBlocks,
        Self::Awaited,
        Self::BeforeStart,
        Self::NewProcess,
        Self::Adopted,
        Self::OneProcess,
        Self::Session,
        Self::Epoch,
        Self::Fence,
    ];

    /// Searches each of which finds two robots in one area without the rule.
    pub fn searches(self) -> Vec<Limits> {
        let searches: &[(u8, u8, u8, u8)] = match self {
            Self::Grant => &[(0, 0, 0, 1)],
            Self::SilenceBlocks => &[(1, AWAY, 0, 5)],
            Self::Awaited | Self::Adopted => &[(1, MEDIATOR, 0, 5)],
            Self::OneProcess => &[(1, PROCESSES, 0, 5), (1, SECOND, 0, 5)],
            Self::Fence => &[(1, FENCES, 0, 5)],
            Self::EntersNoMore => &[(1, AWAY, 1, 4)],
            Self::BeforeStart => &[(1, MEDIATOR, 1, 4)],
            Self::Lease | Self::EntersWithin | Self::Drift | Self::AsksTwice => &[(1, AWAY, 1, 7)],
            Self::NewProcess => &[
                (2, PROCESSES | MEDIATOR, 0, 3),
                (2, SECOND | MEDIATOR, 0, 3),
            ],
            Self::Session | Self::Epoch => &[(2, MESSAGES | MEDIATOR, 0, 4)],
        };
        let all = searches.iter();
        all.map(|&(faults, kinds, orders, ticks)| Limits {
            without: Some(self),
            ..Limits::new(faults, kinds, orders, ticks)
        })
        .collect()
    }
}

/// Later than all times that the mediator waits for.
pub const AFTER_ALL_NS: u64 = ENTERS_NO_MORE_NS + SILENT_AFTER_NS;
