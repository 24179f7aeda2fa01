//! The symbol table as its users see it: within a process, and from other processes.

mod changing;
mod common;
mod example;
mod processes;
mod within;
