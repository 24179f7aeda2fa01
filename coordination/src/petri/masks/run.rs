//! Firing; see [masks](super).

use super::board::{Ask, Board, Outside};
use super::layout::{BITS, Layout, Pair, Row};
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
        let Some([one, behind]) = layout.rows.get(self.next..).and_then(<[_]>::first_chunk) else {
            return self.step_in_pairs(layout, ports);
        };
        if layout.has_ports && ports.can_fill() {
            return None;
        }
        let fired = self.step_own(one);
        // Often the next one is enabled. To ask for just this one first lets the processor go on with it
        // before it knows.
        if behind.is_met(self.now.marks) && self.next != self.now.end && !layout.has_ports {
            return Some((fired, true));
        }
        Some((fired, self.finish_step(layout, ports)))
    }

    /// As [`step`](Self::step), in a net with shared places.
    #[inline(always)]
    fn step_in_pairs(&mut self, layout: &Layout, ports: &mut Ports) -> Option<(usize, bool)> {
        let [one, behind] = layout.pairs.get(self.next..)?.first_chunk()?;
        if layout.has_ports && ports.can_fill() {
            return None;
        }
        let fired = self.step_own(&one.own);
        self.shared ^= one.shared.flip;
        self.active |= one.shared.wakes;
        if behind.own.is_met(self.now.marks)
            && behind.shared.is_met(self.shared)
            && self.next != self.now.end
            && !layout.has_ports
        {
            return Some((fired, true));
        }
        Some((fired, self.finish_step(layout, ports)))
    }

    /// Fires the next one, which has this row, as far as its own word goes; returns which it is. The one
    /// behind it is next.
    #[inline(always)]
    fn step_own(&mut self, row: &Row) -> usize {
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
        match (
            self.is_one_block(),
            layout.pairs.is_empty(),
            layout.has_ports,
        ) {
            (true, _, false) => self.rounds::<Row, false, false>(layout, ports, left, on_fire),
            (true, _, true) => self.rounds::<Row, false, true>(layout, ports, left, on_fire),
            (_, true, false) => self.rounds::<Row, true, false>(layout, ports, left, on_fire),
            (_, true, true) => self.rounds::<Row, true, true>(layout, ports, left, on_fire),
            (_, false, false) => self.rounds::<Pair, true, false>(layout, ports, left, on_fire),
            (_, false, true) => self.rounds::<Pair, true, true>(layout, ports, left, on_fire),
        }
    }

    /// `SEVERAL` blocks, and `PORTS`, or none.
    fn rounds<A: Ask, const SEVERAL: bool, const PORTS: bool>(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        left: &mut Allowance,
        mut on_fire: impl FnMut(usize),
    ) -> bool {
        loop {
            self.load_last();
            self.next = Self::UNKNOWN;
            let mut from = above(self.last - self.now.first);
            loop {
                let firings = &mut left.firings;
                let on_fire = &mut on_fire;
                self.run_block::<A, SEVERAL, PORTS>(layout, ports, from, firings, on_fire);
                from = !0;
                if left.firings == 0 || !SEVERAL || !self.next_block(|block| block.fresh) {
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
    fn run_block<A: Ask, const SEVERAL: bool, const PORTS: bool>(
        &mut self,
        layout: &Layout,
        ports: &mut Ports,
        from: u64,
        left: &mut u32,
        mut on_fire: impl FnMut(usize),
    ) {
        let first = self.now.first;
        let all = &A::all(layout)[first..self.now.end];
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
            self.shared = board.shared;
            self.active = board.active;
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
        self.load_last();
        let behind = above(self.last - self.now.first);
        match (self.is_one_block(), layout.pairs.is_empty()) {
            (true, _) => self.find_in::<Row>(layout, behind) || self.find_in::<Row>(layout, !0),
            (false, true) => self.find_in::<Row>(layout, behind) || self.find_far::<Row>(layout),
            (false, false) => self.find_in::<Pair>(layout, behind) || self.find_far::<Pair>(layout),
        }
    }

    /// Searches block by block, last in the one that runs.
    fn find_far<A: Ask>(&mut self, layout: &Layout) -> bool {
        self.set_active(self.now.todo != 0);
        while self.next_block(|_| !0) {
            if self.find_in::<A>(layout, !0) {
                return true;
            }
            self.set_active(false);
        }
        false
    }

    /// Searches the block that runs.
    #[inline(always)]
    fn find_in<A: Ask>(&mut self, layout: &Layout, among: u64) -> bool {
        let all = &A::all(layout)[self.now.first..self.now.end];
        let mut board = Board::of(self);
        let found = board.search(all, among);
        self.now.todo = board.todo;
        self.next = found.map_or(Self::UNKNOWN, |lane| self.now.first + lane);
        found.is_some()
    }
}
