//! The files that users write, as the loader takes them.

mod common;

mod coordinations;
mod floors;
mod keys_page;
mod mutations;
mod net_file;
mod nets;
mod overrides;
mod robot_file;
mod site_file;
