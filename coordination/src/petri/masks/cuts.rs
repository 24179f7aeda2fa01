//! Where a net of several words is cut into blocks; see [masks](super).

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use super::layout::{BITS, MAX_BLOCKS, Spot};
use crate::petri::model::Structure;

/// How many transitions a block may be shorter, if fewer places reach across its end then.
const SHORTER: usize = 31;

pub(super) struct Cuts {
    /// The transitions of each block.
    pub(super) blocks: Vec<Range<usize>>,
    /// By place.
    pub(super) spots: Vec<Spot>,
}

impl Cuts {
    /// Nothing if the net does not fit.
    pub(super) fn of(structure: &Structure) -> Option<Self> {
        let (places, transitions) = (structure.place_count(), structure.transition_count());
        if transitions > BITS * MAX_BLOCKS || places > BITS * (MAX_BLOCKS + 1) {
            return None;
        }
        let blocks = blocks(structure)?;
        let mut block_of = vec![0; transitions];
        for (block, number) in blocks.iter().zip(0..) {
            block_of[block.clone()].fill(number);
        }
        // How many bits of each word are used; of the shared one last.
        let mut used = [0; MAX_BLOCKS + 1];
        let mut spots = Vec::with_capacity(places);
        for user in &structure.uses {
            let [first, last] = user.transitions().map(|transition| block_of[transition]);
            let (block, word) = if first == last && places > BITS {
                (first, usize::from(first))
            } else {
                (Spot::SHARED, MAX_BLOCKS)
            };
            if used[word] == BITS as u8 {
                return None;
            }
            let bit = used[word];
            used[word] += 1;
            spots.push(Spot { block, bit });
        }
        Some(Self { blocks, spots })
    }
}

/// As few as the places allow, and each cut where few places reach across.
fn blocks(structure: &Structure) -> Option<Vec<Range<usize>>> {
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
            if places > BITS && transition > start {
                break;
            }
            reach = reach + usize::from(begin[transition]) - usize::from(end[transition]);
            ahead[transition - start] = reach;
            farthest = transition - start + 1;
        }
        let nearest = farthest.saturating_sub(SHORTER + 1);
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
