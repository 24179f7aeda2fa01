//! Integration tests, in one binary so that the network is linked once. They begin by their names: what takes longest first.

mod at_any_moment;
mod bounds;
mod check;
mod circle;
mod cost;
mod crossing;
mod doors;
mod flood;
mod full_disk;
mod growth;
mod lanes;
mod large_nets;
mod liveliness;
mod model;
mod passage;
mod plans;
mod privacy;
mod program;
mod random;
mod scripted;
mod seconds;
mod shipped;
mod sites;
mod stall;
mod takeover;
mod unread;
