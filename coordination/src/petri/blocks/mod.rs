//! Nets that are too large for [masks](super::masks).
//!
//! **Representation.** What a transition needs is a set of conditions: *this input is marked*, *that
//! output is empty*. The state of a net is the truth of these conditions, one bit each. Transitions
//! are grouped into blocks of 64, in the model's order, and bit t of a word belongs to the block's
//! t-th transition:
//!
//! | word | bit t is set while |
//! |---|---|
//! | `conditions[0..4]` | one condition of t on a local place each holds; without such a condition, always |
//! | `open` | the condition of t on a shared place holds, if it has just one |
//! | `fresh` | t has not fired in this round |
//!
//! The transitions that may fire are the AND of these words, but for those with several conditions
//! on shared places, of which each is looked at when its turn comes. There is no to-do list, so none
//! can repeat, overflow or lag. A place that changes flips its bit in every condition that mentions
//! it, whatever the direction; the flips of all places that one firing changes are combined at
//! compile time. So firing is a few XORs with constants.
//!
//! A place is *local* if few conditions mention it or all of them are in one block; its mark is
//! nowhere but in these conditions. Other places are *shared*: one resource of many processes. So
//! are those for which a transition with more than four conditions has no word left. Shared places
//! have their marks in a set of bits of their own, from which the word `open` of a block is made when
//! the net comes to that block. Only the block that runs keeps one up to date. Thus a firing costs
//! the same, however many transitions wait for a shared place.
//!
//! Blocks that may have something to fire are in a set, `active`, which is all that a search goes
//! through. What changes local conditions puts their block in or out. What marks a shared place puts
//! in all blocks that need it marked, what empties it those that need it empty, 64 at a time, and the
//! search puts out those that turn out to have nothing.
//!
//! **Bound.** A firing costs its arcs, and a word per 4,096 transitions of the net for each shared
//! place that it changes. A search looks in vain only at blocks where a transition waits for a shared
//! place that another one took before its turn came, or for the local places of a block that a
//! shared place put in; each such block is put out. There may be one in each block, after each
//! firing, so looks have a limit of their own, that grows with the budget of firings: then the
//! evaluation ends, and the next goes on behind the last block looked at, whatever happens in between,
//! so that all have their turn. A look costs the conditions of 64 transitions on shared places. So an
//! evaluation costs at most a constant plus its firings times another, in nets of any size.
//!
//! **Contract.** Between any two firings: (1) a bit in `conditions` equals its condition; (2) `open`
//! belongs to the block of the transition that fired last; (3) every other block with a transition
//! that may fire is active; (4) the bits of transitions that do not exist are 0 in `conditions[0]`.
//! Between any two evaluations all of `fresh` is set.

mod compile;
mod layout;
mod state;

pub(super) use compile::compile;
pub(super) use layout::Layout;
pub(super) use state::State;
