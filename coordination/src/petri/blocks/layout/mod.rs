//! The tables of a net, and the words of its blocks.

mod tables;
mod words;

pub(in crate::petri) use tables::*;
pub(in crate::petri) use words::*;
