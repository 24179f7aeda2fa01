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
        let bit = 1 << (fired.wrapping_sub(self.now.first) % BITS);
        self.now.marks ^= row.flip;
        self.now.todo = (self.now.todo & !bit) | row.wakes;
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
        if left.firings == 0 || left.rounds == 0 {
            return self.is_any_enabled(layout);
        }
        match (self.is_one_block(), layout.has_ports) {
            (true, false) => self.rounds::<false, false>(layout, ports, left, on_fire),
            (true, true) => self.rounds::<false, true>(layout, ports, left, on_fire),
            (false, false) => self.rounds::<true, false>(layout, ports, left, on_fire),
            (false, true) => self.rounds::<true, true>(layout, ports, left, on_fire),
        }
    }

    /// `SEVERAL` blocks, and `PORTS`, or none.
    fn rounds<const SEVERAL: bool, const PORTS: bool>(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        left: &mut Allowance,
        mut on_fire: impl FnMut(usize),
    ) -> bool {
        loop {
            self.load_last(layout);
            self.next = Self::UNKNOWN;
            let mut from = above(self.last - self.now.first);
            loop {
                let firings = &mut left.firings;
                let on_fire = &mut on_fire;
                self.run_block::<SEVERAL, PORTS>(layout, ports, from, firings, on_fire);
                from = !0;
                if left.firings == 0 || !SEVERAL || !self.next_block(layout, |block| block.fresh) {
                    break;
                }
            }
            self.begin_round::<SEVERAL>();
            left.rounds -= 1;
            let enabled = self.is_any_enabled(layout);
            if left.firings == 0 || left.rounds == 0 || !enabled {
                return enabled;
            }
        }
    }

    /// Fires those of the block that runs that are ready, in order, first those in `from`; if it is the
    /// only block until none is ready, else until none behind the last is, or `left` is used up.
    #[inline(always)]
    fn run_block<const SEVERAL: bool, const PORTS: bool>(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        from: u64,
        left: &mut u32,
        mut on_fire: impl FnMut(usize),
    ) {
        let first = self.now.first;
        let all = &layout.rows[first..self.now.end];
        let mut outside = Outside::of::<PORTS>(layout, ports, &self.now);
        let mut board = Board::of(self);
        let mut next = board.search(all, board.fresh & from);
        if next.is_none() && !SEVERAL {
            next = board.search(all, board.fresh);
        }
        let has_fired = next.is_some();
        while let Some(lane) = next {
            let on_fire = |lane| on_fire(first + lane);
            let last = board.run::<PORTS>(all, &mut outside, lane, left, on_fire);
            self.last = first + last;
            // Other blocks come before the beginning of this one.
            if SEVERAL || *left == 0 {
                break;
            }
            next = board.search(all, board.fresh);
        }
        self.now.marks = board.marks;
        self.now.todo = board.todo;
        self.now.fresh = board.fresh;
        if SEVERAL {
            if has_fired {
                self.last_block = self.block;
                self.used |= 1 << self.block;
            }
            self.set_active(board.todo & board.fresh != 0);
        }
    }

    /// Lets every transition fire again.
    #[inline(always)]
    fn begin_round<const SEVERAL: bool>(&mut self) {
        self.now.fresh = !0;
        if SEVERAL {
            while let Some(used) = lowest(self.used) {
                self.used &= self.used - 1;
                self.active |= 1 << used;
                if used != self.block {
                    self.blocks[used].fresh = !0;
                }
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
