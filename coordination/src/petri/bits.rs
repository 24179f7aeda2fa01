//! The search for bits in a word.

/// The bits above bit `lane`.
#[inline]
pub(in crate::petri) fn above(lane: usize) -> u64 {
    (!0 << lane) << 1
}

/// The lowest bit set above `lane`.
#[inline]
pub(in crate::petri) fn next_behind(bits: u64, lane: usize) -> Option<usize> {
    // Often that is the next one. To test for just this one lets the processor go on with it before
    // it knows.
    if bits >> lane & 2 != 0 {
        Some(lane + 1)
    } else {
        lowest(bits & above(lane))
    }
}

#[inline]
pub(in crate::petri) fn lowest(bits: u64) -> Option<usize> {
    (bits != 0).then_some(bits.trailing_zeros() as usize)
}
