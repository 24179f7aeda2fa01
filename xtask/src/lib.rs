//! What must hold of the workspace itself, checked from its sources.
//!
//! - [`source`] reads a crate into modules, one for each file, with the names that each uses;
//! - [`circles`]: no file may depend on itself through others, and no part of a crate either;
//! - [`arrows`]: a crate uses only crates below it;
//! - [`lengths`]: a long file says why it is long;
//! - [`wide`]: what runs on the board has no number of 128 bits.
//! - [`pages`]: the commands that pages tell a reader to type.
//! - [`fuzz`]: the fuzz targets of `config/fuzz`, built and run.
//!
//! `cargo xtask house` prints all findings; `tests/house.rs` holds them at none.

pub mod arrows;
pub mod circles;
mod files;
pub mod fuzz;
mod house;
pub mod lengths;
pub mod pages;
pub mod source;
pub mod wide;

pub use files::ReadError;
pub use house::findings;
