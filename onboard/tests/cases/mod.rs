//! A program of tests that starts itself again as one of its cases: what may end a process is tried in one of its own.

use std::process::{Command, Output};

/// This program again, as one case: `variable` names it to the test `the_cases`. With `more` in its environment.
pub fn case(variable: &str, name: &str, more: &[(&str, &str)]) -> Output {
    let this = std::env::current_exe().expect("known");
    let output = Command::new(this)
        .args(["--exact", "the_cases", "--nocapture"])
        .env(variable, name)
        .envs(more.iter().copied())
        .output();
    output.expect("it starts")
}
