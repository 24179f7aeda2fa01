//! What a rig that was killed leaves behind.

use std::fs;
use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use rig::process::janitor::Janitor;

const RIG: &str = env!("CARGO_BIN_EXE_rig");

/// A process whose command names something in the folder, and that makes its own folder there when it has started up.
fn starting_up(folder: &Path) -> Child {
    Command::new("sh")
        .args(["-c", "sleep 0.5; mkdir -p \"$0\"; sleep 0.2"])
        .arg(folder.join("run"))
        .spawn()
        .expect("started")
}

#[test]
fn the_folder_stays_until_the_last_that_was_starting_up_has_ended() {
    let around = tempfile::tempdir().expect("a folder");
    let folder = around.path().join("rig");
    fs::create_dir_all(folder.join("run")).expect("made");
    let began = Instant::now();
    let mut robot = starting_up(&folder);
    // As when the rig ends.
    drop(Janitor::start(Path::new(RIG), &folder).expect("started"));
    assert!(!folder.exists());
    let took = began.elapsed();
    assert!(
        took >= Duration::from_millis(500) && took < Duration::from_secs(10),
        "{took:?}"
    );
    assert!(robot.wait().expect("a child").success());
    assert!(!folder.exists());
}
