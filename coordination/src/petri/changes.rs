//! What happens when shared places change; see [the layout](super::layout).

use std::collections::HashMap;

use super::layout::{BLOCK, CHUNK, Change, JointChange, OpenFlip, Span};

/// The index of a shared place, and whether it becomes or has to be marked.
pub(super) type SharedMark = (u32, bool);

/// What depends on one shared place.
#[derive(Clone, Default)]
pub(super) struct Dependents {
    /// The transitions for which it is the one shared place.
    pub(super) open: Vec<OpenFlip>,
    /// The joints with a condition on it, and whether that holds while it is marked.
    pub(super) joints: Vec<(u32, bool)>,
}

/// Adds a transition's bit; transitions come in order.
pub(super) fn add_bit(flips: &mut Vec<OpenFlip>, block: usize, bit: u64) {
    let chunk = (block / CHUNK) as u32;
    if flips.last().is_none_or(|last| last.chunk != chunk) {
        flips.push(OpenFlip {
            chunk,
            ..OpenFlip::default()
        });
    }
    if let Some(flip) = flips.last_mut() {
        flip.blocks |= 1 << (block % BLOCK);
        flip.bits[block % CHUNK] |= bit;
    }
}

/// The tables of changes, while they are filled.
#[derive(Default)]
pub(super) struct Changes {
    pub(super) open: Vec<OpenFlip>,
    pub(super) joints: Vec<JointChange>,
    pub(super) several: Vec<Change>,
    combined: HashMap<Vec<SharedMark>, Option<Change>>,
}

impl Changes {
    /// Puts a list of flips into the table.
    pub(super) fn add(&mut self, flips: &[OpenFlip]) -> Span {
        let start = self.open.len();
        self.open.extend_from_slice(flips);
        span(start, self.open.len())
    }

    /// When a place is emptied, and when it is marked.
    pub(super) fn of_place(&mut self, dependents: &Dependents) -> [Change; 2] {
        let open = self.add(&dependents.open);
        [false, true].map(|marked| {
            let start = self.joints.len();
            let changes = dependents.joints.iter().map(|&(joint, when_marked)| {
                let unmet = if marked == when_marked { -1 } else { 1 };
                JointChange { joint, unmet }
            });
            self.joints.extend(changes);
            Change {
                open,
                joints: span(start, self.joints.len()),
            }
        })
    }

    /// When several places change at once: one change, and a list of further ones.
    pub(super) fn of_places(
        &mut self,
        marks: &[SharedMark],
        shared: &[[Change; 2]],
    ) -> (Change, Span) {
        let change = |&(place, marked): &SharedMark| shared[place as usize][usize::from(marked)];
        let first = match marks {
            [] => return Default::default(),
            [one] => return (change(one), Span::default()),
            [first, ..] => change(first),
        };
        let known = self.combined.get(marks).copied();
        let combined = known.unwrap_or_else(|| {
            let combined = self.combine(marks.iter().map(change));
            self.combined.insert(marks.to_vec(), combined);
            combined
        });
        match combined {
            Some(combined) => (combined, Span::default()),
            None => {
                let start = self.several.len();
                self.several.extend(marks[1..].iter().map(change));
                (first, span(start, self.several.len()))
            }
        }
    }

    /// Several changes in one, unless that would be longer than their list.
    fn combine(&mut self, changes: impl ExactSizeIterator<Item = Change>) -> Option<Change> {
        let limit = 2 * changes.len();
        let (open_start, joint_start) = (self.open.len(), self.joints.len());
        for change in changes {
            for index in change.open.start as usize..change.open.end as usize {
                let flip = self.open[index];
                let mut known = self.open[open_start..].iter_mut();
                match known.find(|known| known.chunk == flip.chunk) {
                    Some(known) => {
                        known.blocks |= flip.blocks;
                        for (known, bits) in known.bits.iter_mut().zip(flip.bits) {
                            *known ^= bits;
                        }
                    }
                    None => self.open.push(flip),
                }
            }
            for index in change.joints.start as usize..change.joints.end as usize {
                let change = self.joints[index];
                let mut known = self.joints[joint_start..].iter_mut();
                match known.find(|known| known.joint == change.joint) {
                    Some(known) => known.unmet += change.unmet,
                    None => self.joints.push(change),
                }
            }
            if self.open.len() - open_start + self.joints.len() - joint_start > limit {
                self.open.truncate(open_start);
                self.joints.truncate(joint_start);
                return None;
            }
        }
        Some(Change {
            open: span(open_start, self.open.len()),
            joints: span(joint_start, self.joints.len()),
        })
    }
}

pub(super) fn span(start: usize, end: usize) -> Span {
    Span {
        start: start as u32,
        end: end as u32,
    }
}
