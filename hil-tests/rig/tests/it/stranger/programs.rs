//! A MainDevice that was not written for our segment drives the devices of `rig devices` over a network interface.
//!
//! Needs CAP_NET_ADMIN for a virtual pair of interfaces, and a Python with pysoem: `RIG_PYTHON`, else `python3`.
//! Where these are missing it is skipped, and says so.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use rig::interfaces::{Pair, said};
use rustix::process::{Pid, Signal, kill_process};

use crate::programs::late::once_more_if_late;
use crate::programs::turn::Turn;

const CONFIG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config");
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/it/stranger/soem.py");

#[test]
fn soem_turns_a_wheel_of_the_simulated_robot() {
    once_more_if_late(|| {
        let _turn = Turn::of_robots(1);
        let python = std::env::var("RIG_PYTHON").unwrap_or_else(|_| "python3".to_owned());
        let import = said(Command::new(&python).args(["-c", "import pysoem"]));
        if let Err(why) = import {
            println!(
                "skipped: {python} has no pysoem (pip install pysoem, RIG_PYTHON names another): {why}"
            );
            return;
        }
        let pair = match Pair::new("rs") {
            Ok(pair) => pair,
            Err(why) => {
                println!(
                    "skipped: no virtual pair of interfaces, which needs CAP_NET_ADMIN: {why}"
                );
                return;
            }
        };
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut devices = Devices::start(&pair.near, &folder.path().join("lidar"));
        let soem = Command::new(&python)
            .args([SCRIPT, &pair.far])
            .stdin(Stdio::null())
            .output()
            .expect("python starts");
        let text = String::from_utf8_lossy(&soem.stdout).into_owned();
        println!("{text}{}", String::from_utf8_lossy(&soem.stderr));
        if soem.status.code() == Some(2) {
            println!("skipped: it could not be tried, see above");
            return;
        }
        assert!(soem.status.success(), "{}", soem.status);
        assert!(text.contains("SOEM believes it"));
        devices.end();
        assert!(
            !folder.path().join("lidar").is_symlink(),
            "the link to the lidar was left behind"
        );
    });
}

/// `rig devices` as a process.
struct Devices {
    child: Child,
    // Kept open: a program whose reader has gone fails to print.
    _output: BufReader<std::process::ChildStdout>,
}

impl Devices {
    /// Starts it and waits until it serves.
    fn start(interface: &str, lidar: &std::path::Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_rig"))
            .arg("devices")
            .arg("--robot")
            .arg(format!("{CONFIG}/robots/amr-1.toml"))
            .arg("--site")
            .arg(format!("{CONFIG}/sites/corridor.toml"))
            .args(["--ethercat", interface, "--lidar"])
            .arg(lidar)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut output = BufReader::new(child.stdout.take().expect("piped"));
        let mut line = String::new();
        while !line.starts_with("Ctrl-C") {
            line.clear();
            let read = output.read_line(&mut line).expect("text");
            assert!(read > 0, "rig devices ended: {:?}", child.wait());
            print!("{line}");
        }
        Self {
            child,
            _output: output,
        }
    }

    /// Ctrl-C, which is to end it well.
    fn end(&mut self) {
        let pid = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw);
        kill_process(pid.expect("a process id"), Signal::INT).expect("it runs");
        let asked = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("a child") {
                assert!(status.success(), "rig devices ended with {status}");
                return;
            }
            assert!(asked.elapsed() < Duration::from_secs(5), "it does not end");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Devices {
    fn drop(&mut self) {
        // Ended already is as good.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
