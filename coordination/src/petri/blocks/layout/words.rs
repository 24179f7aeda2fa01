//! The words of a block; see [blocks](crate::petri::blocks).

use super::tables::{BLOCK, Bits};
use crate::petri::bits::next_behind;

/// The words of a block while it runs, in registers.
#[derive(Clone, Copy, Debug)]
pub(in crate::petri) struct Words {
    pub(in crate::petri) conditions: Bits,
    pub(in crate::petri) open: u64,
    pub(in crate::petri) fresh: u64,
}

impl Words {
    #[inline]
    pub(in crate::petri) fn enabled(&self) -> u64 {
        let [a, b, c, d] = self.conditions;
        a & b & c & d & self.open
    }

    #[inline]
    pub(in crate::petri) fn ready(&self) -> u64 {
        self.enabled() & self.fresh
    }

    #[inline]
    pub(in crate::petri) fn flip(&mut self, flips: &Bits) {
        let [a, b, c, d] = &mut self.conditions;
        let [flip_a, flip_b, flip_c, flip_d] = flips;
        *a ^= flip_a;
        *b ^= flip_b;
        *c ^= flip_c;
        *d ^= flip_d;
    }

    #[inline]
    pub(in crate::petri) fn fire(&mut self, flips: &[Bits; BLOCK], lane: usize) {
        self.flip(&flips[lane % BLOCK]);
        self.fresh &= !(1 << lane);
    }

    /// Fires `lane` and what is ready behind it, at most `left` and up to the next special one.
    /// Returns the last that fired.
    #[inline(never)]
    pub(in crate::petri) fn run_plain(
        &mut self,
        flips: &[Bits; BLOCK],
        special: u64,
        mut lane: usize,
        left: &mut u32,
        mut on_fire: impl FnMut(usize),
    ) -> usize {
        let mut now = *self;
        let mut more = *left;
        loop {
            now.fire(flips, lane);
            on_fire(lane);
            more -= 1;
            if more == 0 {
                break;
            }
            match next_behind(now.ready(), lane) {
                Some(next) if special >> next & 1 == 0 => lane = next,
                _ => break,
            }
        }
        *self = now;
        *left = more;
        lane
    }
}
