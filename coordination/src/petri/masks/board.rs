//! One block that runs, in registers; see [masks](super).

use super::layout::{BITS, Layout, Row};
use super::state::{Block, State};
use crate::petri::bits::lowest;
use crate::petri::ports::{PortChange, Ports};
use crate::petri::span::Span;

/// How many of the next transitions are asked one by one.
const NEAR: usize = 2;

/// What changes while a block runs.
#[derive(Clone, Copy)]
pub(super) struct Board {
    pub(super) marks: u64,
    pub(super) todo: u64,
    pub(super) fresh: u64,
}

/// The ports, and what the transitions of a block do to them.
pub(super) struct Outside<'a> {
    /// Empty unless `PORTS`: the net has ports.
    changes_of: &'a [Span],
    changes: &'a [PortChange],
    ports: &'a mut Ports,
}

impl<'a> Outside<'a> {
    #[inline(always)]
    pub(super) fn of<const PORTS: bool>(
        layout: &'a Layout,
        ports: &'a mut Ports,
        block: &Block,
    ) -> Self {
        Self {
            changes_of: if PORTS {
                &layout.ports_of[block.first..block.end]
            } else {
                &[]
            },
            changes: &layout.port_changes,
            ports,
        }
    }

    #[inline(always)]
    fn change(&mut self, lane: usize) {
        for &change in self.changes_of[lane].of(self.changes) {
            self.ports.change(change);
        }
    }
}

impl Board {
    #[inline(always)]
    pub(super) fn of(state: &State) -> Self {
        Self {
            marks: state.now.marks,
            todo: state.now.todo,
            fresh: state.now.fresh,
        }
    }

    #[inline(always)]
    fn fire(&mut self, row: &Row) {
        self.marks ^= row.flip;
        self.todo |= row.wakes;
    }

    /// Of the transitions that are to do and in `among`, the first that is enabled; takes out those
    /// before it.
    #[inline(always)]
    pub(super) fn search(&mut self, all: &[Row], mut among: u64) -> Option<usize> {
        loop {
            among &= self.todo;
            let lane = lowest(among)?;
            if all[lane].is_met(self.marks) {
                return Some(lane);
            }
            self.todo &= !(among & among.wrapping_neg());
        }
    }

    /// Fires `lane`, which is enabled, and what is ready behind it. Returns which fired last. All that fired stay to do: they may not
    /// fire again in this round. `COUNTED`: at most `left` fire, which is used up; otherwise it is not looked at.
    #[inline(always)]
    pub(super) fn run<const PORTS: bool, const COUNTED: bool>(
        &mut self,
        all: &[Row],
        outside: &mut Outside<'_>,
        lane: usize,
        left: &mut u32,
        mut on_fire: impl FnMut(usize),
    ) -> usize {
        let mut board = *self;
        let mut more = *left;
        let mut bit: u64 = 1 << lane;
        let mut rest = all[lane..].iter();
        let mut next = rest.next();
        while let Some(one) = next {
            board.fire(one);
            board.fresh ^= bit;
            let lane = bit.trailing_zeros() as usize;
            on_fire(lane);
            if PORTS {
                outside.change(lane);
            }
            if COUNTED {
                more -= 1;
                if more == 0 {
                    break;
                }
            }
            // Often one of the next is ready. To ask for just these first lets the processor go on with them
            // before it knows.
            let mut behind = bit << 1;
            let mut ready = None;
            for ahead in 0..NEAR {
                if board.fresh & behind != 0 {
                    ready = rest
                        .as_slice()
                        .get(ahead)
                        .filter(|row| row.is_met(board.marks));
                    if ready.is_some() {
                        rest.nth(ahead);
                        break;
                    }
                }
                behind <<= 1;
            }
            if ready.is_some() {
                (next, bit) = (ready, behind);
                continue;
            }
            let among = board.fresh & behind.wrapping_neg();
            let Some(found) = board.search(all, among) else {
                break;
            };
            bit = 1 << (found % BITS);
            rest = all[found..].iter();
            next = rest.next();
        }
        *self = board;
        if COUNTED {
            *left = more;
        }
        bit.trailing_zeros() as usize
    }
}
