//! Where a net of several words is cut into blocks; see [masks](super).

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use super::layout::{BITS, MAX_BLOCKS, Spot};
use crate::petri::model::{Structure, Use};

/// How many transitions a block may be shorter, if fewer places reach across its end then; at most half.
const SHORTER: usize = 31;

pub(super) struct Cuts {
    /// The transitions of each block.
    pub(super) blocks: Vec<Range<usize>>,
    /// By place.
    pub(super) spots: Vec<Spot>,
    /// The bits of the shared places, the lowest ones.
    pub(super) shared: u64,
}

impl Cuts {
    /// Nothing if the net does not fit.
    pub(super) fn of(structure: &Structure) -> Option<Self> {
        let (places, transitions) = (structure.place_count(), structure.transition_count());
        if transitions > BITS * MAX_BLOCKS || places > BITS * (MAX_BLOCKS + 1) {
            return None;
        }
        let mut block_of = vec![0; transitions];
        // Shorter blocks may share more places, which leaves less room for others, and so on.
        let mut room = BITS;
        loop {
            let blocks = blocks(structure, room)?;
            for (block, number) in blocks.iter().zip(0..) {
                block_of[block.clone()].fill(number);
            }
            // Where all places fit into a word, that is the word of all.
            let block_of = |user: &Use| {
                let [first, last] = user.transitions().map(|transition| block_of[transition]);
                (first == last && places > BITS).then_some(first)
            };
            let own = structure.uses.iter().filter_map(block_of);
            let mut count = [0; MAX_BLOCKS];
            own.for_each(|block| count[usize::from(block)] += 1);
            let shared = places - count.iter().sum::<usize>();
            let most = count.iter().max().copied().unwrap_or_default();
            if shared > BITS {
                return None;
            }
            if most + shared > BITS {
                // Fewer each time.
                room = (BITS - shared).min(room - 1);
                continue;
            }
            let mut next = [shared as u8; MAX_BLOCKS];
            let mut next_shared = 0;
            let spots = { structure.uses.iter().map(block_of) }.map(|block| {
                let (block, next) = match block {
                    Some(block) => (block, &mut next[usize::from(block)]),
                    None => (Spot::SHARED, &mut next_shared),
                };
                *next += 1;
                Spot {
                    block,
                    bit: *next - 1,
                }
            });
            return Some(Self {
                spots: spots.collect(),
                blocks,
                shared: !(!0_u64).checked_shl(shared as u32).unwrap_or_default(),
            });
        }
    }
}

/// As few as the places allow, `room` in each, and each cut where few places reach across.
fn blocks(structure: &Structure, room: usize) -> Option<Vec<Range<usize>>> {
    let transitions = structure.transition_count();
    // By transition: how many places it is the first to mention, and the last.
    let mut begin = vec![0_u16; transitions];
    let mut end = vec![0_u16; transitions];
    for user in &structure.uses {
        let [first, last] = user.transitions();
        begin[first] += 1;
        end[last] += 1;
    }
    let mut blocks = Vec::new();
    let (mut start, mut across) = (0, 0);
    while start < transitions {
        if blocks.len() == MAX_BLOCKS {
            return None;
        }
        // The places that some transition of the block is the first to mention fit into its word.
        let (mut places, mut reach) = (0, across);
        let (mut stop, mut fewest) = (start + 1, usize::MAX);
        let (mut ahead, mut farthest) = ([0; BITS], 0);
        for transition in start..transitions.min(start + BITS) {
            places += usize::from(begin[transition]);
            if places > room && transition > start {
                break;
            }
            reach = reach + usize::from(begin[transition]) - usize::from(end[transition]);
            ahead[transition - start] = reach;
            farthest = transition - start + 1;
        }
        let nearest = farthest.saturating_sub(SHORTER + 1).max(farthest / 2);
        for (&reach, length) in ahead[nearest..farthest].iter().zip(nearest + 1..) {
            if reach <= fewest {
                (stop, fewest) = (start + length, reach);
            }
        }
        across = fewest;
        blocks.push(start..stop);
        start = stop;
    }
    Some(blocks)
}
