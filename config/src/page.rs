//! The reference page of all keys of robot, site and net files.

use crate::net::NetFile;
use description::keys::Page;
use description::robot::Robot;
use description::site::Site;

/// The page `KEYS.md`, made from the declarations of the keys.
#[must_use]
pub fn reference_page() -> String {
    format!(
        "# Keys of robot, site and net files\n\n\
         Made from the declarations in `description` and `config/src/net`: `cargo run -p config --example keys > config/KEYS.md`.\n\
         A key without a default must be written.\n\n\
         ## Robot files\n{}\n## Site files\n{}\n## Net files\n{}",
        Page::of::<Robot>().markdown(),
        Page::of::<Site>().markdown(),
        Page::of::<NetFile>().markdown()
    )
}
