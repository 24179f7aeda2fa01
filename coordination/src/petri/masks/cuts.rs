//! Where a net of several words is cut into blocks; see [masks](super).

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

use super::layout::{BITS, MAX_BLOCKS, Spot};
use crate::petri::model::Structure;

/// How many transitions a block may be shorter, if fewer places reach across its end then; at most half.
const SHORTER: usize = 31;

pub(super) struct Cuts {
    /// The transitions of each block.
    pub(super) blocks: Vec<Range<usize>>,
    /// By place.
    pub(super) spots: Vec<Spot>,
    /// The bits of the shared places, the highest ones.
    pub(super) shared: u64,
}

impl Cuts {
    /// Nothing if the net does not fit.
    pub(super) fn of(structure: &Structure) -> Option<Self> {
        let (places, transitions) = (structure.place_count(), structure.transition_count());
        if transitions > BITS * MAX_BLOCKS || places > BITS * (MAX_BLOCKS + 1) {
            return None;
        }
        // By transition: how many places it is the first to mention, and the last.
        let mut ends = vec![[0_u16; 2]; transitions];
        // Places that are in two blocks, wherever the cuts are.
        let mut far = 0;
        for user in &structure.uses {
            let [first, last] = user.transitions();
            ends[first][0] += 1;
            ends[last][1] += 1;
            far += usize::from(last - first >= BITS);
        }
        let mut block_of = vec![0_u8; transitions];
        let mut spots = vec![Spot::default(); places];
        let most = BITS.saturating_sub(far);
        // Where processes share something, mostly one more place reaches across each cut.
        let likely = most.saturating_sub(if far == 0 { 0 } else { places / BITS });
        let mut room = likely;
        let mut is_first = true;
        // Shorter blocks may share more places, which leaves less room for others, and so on.
        loop {
            let is_likely = core::mem::take(&mut is_first);
            let blocks = match blocks(&ends, room) {
                // Later, with less and less room, it can come to the likely one again.
                None if is_likely && likely < most => {
                    room = most;
                    continue;
                }
                blocks => blocks?,
            };
            for (block, number) in blocks.iter().zip(0..) {
                block_of[block.clone()].fill(number);
            }
            // How many each block has of its own; that of the block before is at hand.
            let (mut own, mut before, mut count) = ([0_usize; MAX_BLOCKS], 0_u8, 0_usize);
            let mut shared = 0;
            for (spot, user) in spots.iter_mut().zip(&structure.uses) {
                let [first, last] = user.transitions().map(|transition| block_of[transition]);
                // Where all places fit into a word, that is the word of all.
                *spot = if first == last && places > BITS {
                    if first != before {
                        own[before as usize % MAX_BLOCKS] = count;
                        count = own[first as usize % MAX_BLOCKS];
                        before = first;
                    }
                    count += 1;
                    Spot {
                        block: first,
                        // Too many do not fit: the largest is looked at below.
                        bit: (count - 1) as u8,
                    }
                } else {
                    shared += 1;
                    if usize::from(shared) > BITS {
                        return None;
                    }
                    Spot {
                        block: Spot::SHARED,
                        bit: BITS as u8 - shared,
                    }
                };
            }
            own[before as usize % MAX_BLOCKS] = count;
            let shared = usize::from(shared);
            let largest = own.iter().max().copied().unwrap_or_default();
            if largest + shared <= BITS {
                return Some(Self {
                    blocks,
                    spots,
                    shared: !(!0_u64).checked_shr(shared as u32).unwrap_or_default(),
                });
            }
            // Fewer each time.
            room = (BITS - shared).min(room.checked_sub(1)?);
        }
    }
}

/// As few as the places allow, `room` in each, and each cut where few places reach across. By transition: how many places it is
/// the first to mention, and the last.
fn blocks(ends: &[[u16; 2]], room: usize) -> Option<Vec<Range<usize>>> {
    let mut blocks = Vec::with_capacity(MAX_BLOCKS);
    let (mut start, mut across) = (0, 0);
    while start < ends.len() {
        if blocks.len() == MAX_BLOCKS {
            return None;
        }
        // The places that some transition of the block is the first to mention fit into its word.
        let (mut places, mut reach) = (0, across);
        let (mut stop, mut fewest) = (start + 1, u16::MAX);
        let (mut ahead, mut farthest) = ([0; BITS], 0_usize);
        for (&[begin, end], ahead) in ends[start..].iter().zip(&mut ahead) {
            places += usize::from(begin);
            if places > room && farthest > 0 {
                break;
            }
            reach = reach + begin - end;
            *ahead = reach;
            farthest += 1;
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
