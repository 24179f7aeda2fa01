//! Protocol flag arrays: their models, both kinds of side, and many threads.

mod channel;
mod common;
mod model;
mod random;
mod replica;
mod threads;
