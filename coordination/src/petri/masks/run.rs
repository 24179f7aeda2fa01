//! Firing; see [masks](super).

use super::board::{Board, Outside};
use super::layout::{BITS, Layout, Row};
use super::state::State;
use crate::petri::bits::{above, lowest};
use crate::petri::evaluation::Allowance;
use crate::petri::ports::Ports;

impl State {
    /// Fires the transition that is known to be next, if there is one and no source is to be filled
    /// before. Returns which, and whether something is left to do then. This is the shortest way for one
    /// firing. Between two evaluations only.
    #[inline(always)]
    pub(in crate::petri) fn step(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
    ) -> Option<(usize, bool)> {
        let [one, behind] = layout.rows.get(self.next..)?.first_chunk()?;
        if layout.has_ports && ports.can_fill() {
            return None;
        }
        let fired = self.fire_next(one);
        // Often the next one is enabled. To ask for just this one first lets the processor go on with it
        // before it knows.
        if behind.is_met(self.now.marks) && self.next != self.now.end && !layout.has_ports {
            return Some((fired, true));
        }
        Some((fired, self.finish_step(layout, ports)))
    }

    /// Fires the next one, which has this row, and returns which it is. The one behind it is next.
    #[inline(always)]
    fn fire_next(&mut self, row: &Row) -> usize {
        let fired = self.next;
        self.now.marks ^= row.flip;
        self.now.todo |= row.wakes;
        self.last = fired;
        self.next = fired.wrapping_add(1);
        fired
    }

    /// What the firing of the last one does to ports, and whether something is left to do.
    #[inline(never)]
    fn finish_step(&mut self, layout: &Layout, ports: &mut Ports) -> bool {
        if !layout.has_ports {
            return self.find_next(layout);
        }
        for change in layout.port_changes(self.last) {
            ports.change(*change);
        }
        self.find_next(layout) || ports.can_fill()
    }

    /// Fires as far as `left` allows, and uses it up. Each round begins behind the last that fired:
    /// first what is behind it in its block, then block by block, at last the rest of its block.
    /// Returns whether a transition is enabled.
    pub(in crate::petri) fn run(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        left: &mut Allowance,
        on_fire: impl FnMut(usize),
    ) -> bool {
        // Mostly it is known, without a call.
        let enabled = self.next != Self::UNKNOWN || self.is_any_enabled(layout);
        if left.firings == 0 || left.rounds == 0 || !enabled {
            return enabled;
        }
        match (self.is_one_block(), layout.has_ports) {
            (true, false) => self.run_one_block::<false>(layout, ports, left, on_fire),
            (true, true) => self.run_one_block::<true>(layout, ports, left, on_fire),
            (false, false) => self.run_blocks::<false>(layout, ports, left, on_fire),
            (false, true) => self.run_blocks::<true>(layout, ports, left, on_fire),
        }
    }

    /// The only block, from the next on, which is known. It stays in registers from round to round.
    fn run_one_block<const PORTS: bool>(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        left: &mut Allowance,
        mut on_fire: impl FnMut(usize),
    ) -> bool {
        let all = &layout.rows[..self.now.end];
        let mut outside = Outside::of::<PORTS>(layout, ports, &self.now);
        let mut board = Board::of(self);
        let mut lane = self.next;
        let next = loop {
            // More than all do not fire in a round.
            let is_counted = left.firings as usize <= BITS;
            // A round: until none is ready that has not fired in it.
            let last = loop {
                let firings = &mut left.firings;
                let last = if is_counted {
                    board.run::<PORTS, true>(all, &mut outside, lane, firings, &mut on_fire)
                } else {
                    board.run::<PORTS, false>(all, &mut outside, lane, firings, &mut on_fire)
                };
                match board.search(all, board.fresh) {
                    Some(ready) if left.firings > 0 => lane = ready,
                    _ => break last,
                }
            };
            if !is_counted {
                left.firings -= (!board.fresh).count_ones();
            }
            self.last = last;
            board.fresh = !0;
            left.rounds -= 1;
            let behind = board.search(all, above(last));
            match behind.or_else(|| board.search(all, !0)) {
                Some(next) if left.firings > 0 && left.rounds > 0 => lane = next,
                next => break next,
            }
        };
        self.now.marks = board.marks;
        self.now.todo = board.todo;
        self.next = next.unwrap_or(Self::UNKNOWN);
        next.is_some()
    }

    /// Block by block, from the next transition on, which is known.
    fn run_blocks<const PORTS: bool>(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        left: &mut Allowance,
        mut on_fire: impl FnMut(usize),
    ) -> bool {
        loop {
            let mut lane = Some(self.next - self.now.first);
            self.next = Self::UNKNOWN;
            loop {
                self.run_block::<PORTS>(
                    layout,
                    ports,
                    lane.take(),
                    &mut left.firings,
                    &mut on_fire,
                );
                if left.firings == 0 || !self.next_block(layout, |block| block.fresh) {
                    break;
                }
            }
            self.begin_round();
            left.rounds -= 1;
            let enabled = self.is_any_enabled(layout);
            if left.firings == 0 || left.rounds == 0 || !enabled {
                return enabled;
            }
        }
    }

    /// Fires those of the block that runs that are ready, in order, from this one on if it is known, until none
    /// behind the last is, or `left` is used up.
    #[inline(always)]
    fn run_block<const PORTS: bool>(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        lane: Option<usize>,
        left: &mut u32,
        mut on_fire: impl FnMut(usize),
    ) {
        let first = self.now.first;
        let all = &layout.rows[first..self.now.end];
        let mut outside = Outside::of::<PORTS>(layout, ports, &self.now);
        let mut board = Board::of(self);
        // Other blocks come before the beginning of this one.
        if let Some(lane) = lane.or_else(|| board.search(all, board.fresh)) {
            let on_fire = |lane| on_fire(first + lane);
            let fresh = board.fresh;
            let last = if *left as usize > BITS {
                // More than all of a block do not fire in a round.
                let last = board.run::<PORTS, false>(all, &mut outside, lane, left, on_fire);
                *left -= (fresh ^ board.fresh).count_ones();
                last
            } else {
                board.run::<PORTS, true>(all, &mut outside, lane, left, on_fire)
            };
            self.last = first + last;
            self.last_block = self.block;
            self.used |= 1 << self.block;
        }
        self.now.marks = board.marks;
        self.now.todo = board.todo;
        self.now.fresh = board.fresh;
        self.set_active(board.todo & board.fresh != 0);
    }

    /// Lets every transition fire again.
    #[inline(always)]
    fn begin_round(&mut self) {
        self.now.fresh = !0;
        while let Some(used) = lowest(self.used) {
            self.used &= self.used - 1;
            self.active |= 1 << used;
            if used != self.block {
                self.blocks[used].fresh = !0;
            }
        }
    }

    /// Whether a transition is enabled, and if so which is next; between two rounds only. Takes out what
    /// is not, on the way.
    #[inline(never)]
    pub(in crate::petri) fn is_any_enabled(&mut self, layout: &Layout) -> bool {
        self.next != Self::UNKNOWN || self.find_next(layout)
    }

    #[inline(always)]
    fn find_next(&mut self, layout: &Layout) -> bool {
        self.load_last(layout);
        let behind = above(self.last - self.now.first);
        self.find_in(layout, behind)
            || match self.is_one_block() {
                true => self.find_in(layout, !0),
                false => self.find_far(layout),
            }
    }

    /// Searches block by block, last in the one that runs.
    fn find_far(&mut self, layout: &Layout) -> bool {
        self.set_active(self.now.todo != 0);
        while self.next_block(layout, |_| !0) {
            if self.find_in(layout, !0) {
                return true;
            }
            self.set_active(false);
        }
        false
    }

    /// Searches the block that runs.
    #[inline(always)]
    fn find_in(&mut self, layout: &Layout, among: u64) -> bool {
        let all = &layout.rows[self.now.first..self.now.end];
        let mut board = Board::of(self);
        let found = board.search(all, among);
        self.now.todo = board.todo;
        self.next = found.map_or(Self::UNKNOWN, |lane| self.now.first + lane);
        found.is_some()
    }
}
