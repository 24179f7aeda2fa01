//! A log that nobody takes: a pager that waits, a stopped terminal, a pipe whose reader hangs.

use std::time::Duration;

use crate::program::{Program, Site, folder};

#[test]
fn a_mediator_whose_log_nobody_takes_goes_on() {
    let folder = folder();
    let site = Site {
        name: "unread".into(),
        areas: vec![("room".into(), 1)],
        robots: vec![("amr-1".into(), "normal", 0)],
        events: Vec::new(),
        more: String::new(),
        nets: Vec::new(),
        own_nets: Vec::new(),
    };
    let mut program = Program::new(folder.path(), &site, Vec::new());
    program.start_unread();
    program.wait_ready(Duration::from_secs(20));
    program.kill();
}
