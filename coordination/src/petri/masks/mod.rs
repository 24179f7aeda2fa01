//! Nets whose transitions are masks.
//!
//! **Representation.** A place is a bit of a word, set while it is marked. A transition asks with a mask
//! and a value whether it is enabled, `marks & mask == value`: its inputs are set and its outputs, other
//! than its own inputs, are not. Firing flips what changes, `marks ^= flip`. Sources and sinks are
//! places like others. So a full output place is asked for at no cost, proved or not.
//!
//! A net of up to 64 places and 64 transitions is one word, as those are that robots need. A larger one
//! is cut into *blocks* of up to 64 consecutive transitions, each with a word of its own. Places that
//! several blocks mention are *shared*: they are the highest bits of every word, and the other bits are the
//! places that no other block mentions. The block that runs has the marks of the shared ones; the next to
//! run takes them over. The cuts are where few places reach across, so that processes declared one after
//! another with some resources between them fit; a net that does not fit is laid out in
//! [other blocks](super::blocks).
//!
//! **To do.** Each block has a set of transitions to look at, `todo`, a bit for each. A search for one that is enabled takes out
//! those that are not. What a firing could enable, it puts in, by a mask: those of its own block that need marked
//! what it has marked, or empty what it has emptied. What has fired stays in, which costs nothing. A block that is left for another one
//! tells the blocks that need a shared place as it is now, and was not before. Since the processor guesses that one of the next two in
//! the order is enabled, a firing does not wait for the one before it; these two are asked whether they are to do or not.
//!
//! **Bound.** A firing costs the same in all nets. The search for the next looks at the one or two behind it, and at each transition that has
//! fired or was put in since it was looked at last, once; at most at all of the net. A net has at most
//! [`MAX_BLOCKS`] blocks, so that an evaluation costs at most a constant, plus another for each firing.
//!
//! **Contract.** Between any two firings: (1) a transition that is enabled is in `todo`, or it needs a
//! shared place and its block is in `active`, or will be once the block that runs has told how the shared
//! places are now; (2) every block with something to do that may fire in this round, other than the one
//! that runs and those that it has yet to tell, is in `active`; (3) the state of the block that runs is in
//! `now`, and its entry in `blocks` is out of date, as are the shared places of all others. Between any two
//! evaluations (4) all of `fresh` is set, and (5) `next` is what the order of choice has next to fire, a
//! transition of the block in `now`, or it is unknown; every change from outside makes it so.

mod board;
mod compile;
mod cuts;
mod layout;
mod run;
mod state;
#[cfg(test)]
mod tests;

pub(super) use compile::{compile, nothing};
pub(super) use layout::Layout;
pub(super) use state::State;
