//! What the Debian package brings besides the programs, tried with a computer of files and programs that only note how they are called.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

fn package(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../onboard/debian")
        .join(name)
}

fn read(name: &str) -> String {
    fs::read_to_string(package(name)).expect("it is in the package")
}

/// A folder for a computer's files, and programs that write down how they are called.
struct Computer(TempDir);

impl Computer {
    fn new() -> Self {
        let own = Self(tempfile::tempdir().expect("a folder"));
        fs::create_dir(own.path("bin")).expect("made");
        own
    }

    fn path(&self, path: &str) -> PathBuf {
        self.0.path().join(path)
    }

    fn with(self, path: &str, text: &str) -> Self {
        let path = self.path(path);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(path, text).expect("written");
        self
    }

    /// A program that notes its name and its arguments, and ends with this code.
    fn having(self, program: &str, code: u8) -> Self {
        let calls = self.path("calls").display().to_string();
        let script = format!("#!/bin/sh\necho {program} \"$@\" >>{calls}\nexit {code}\n");
        let own = self.with(&format!("bin/{program}"), &script);
        let path = own.path(&format!("bin/{program}"));
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).expect("set");
        own
    }

    /// Runs a script of the package with these arguments.
    fn run(&self, script: &str, arguments: &[&str]) -> Output {
        let path = format!("{}:/usr/bin:/bin", self.path("bin").display());
        let mut command = Command::new("sh");
        command.arg(package(script)).args(arguments);
        command.env("PATH", path).output().expect("a shell")
    }

    fn calls(&self) -> String {
        fs::read_to_string(self.path("calls")).unwrap_or_default()
    }
}

#[test]
fn an_upgrade_stops_no_robot_and_a_removal_does() {
    let computer = Computer::new().having("systemctl", 0);
    assert!(
        computer
            .run("prerm", &["upgrade", "0.2.0"])
            .status
            .success()
    );
    assert_eq!(computer.calls(), "");
    assert!(computer.run("prerm", &["remove"]).status.success());
    let stopped = "systemctl stop onboard.service\nsystemctl --no-reload disable onboard.service\n";
    assert_eq!(computer.calls(), stopped);
}

/// Two interfaces, a core whose governor takes no word, and an adapter that knows only one of the times.
#[test]
fn the_computer_is_prepared_as_far_as_it_can_be() {
    let robot =
        "[fleet]\ninterface = \"wlan0\"\n\n[ethercat]\ninterface = \"eth0\"   # the drive\n";
    let governor = |core: u8| format!("sys/devices/system/cpu/cpu{core}/cpufreq/scaling_governor");
    let table = "           CPU0\n 24:  1  PCI-MSI  eth0-rx-0\n 25:  1  PCI-MSI  wlan0\n";
    let computer = Computer::new()
        .having("ethtool", 1)
        .having("pgrep", 1)
        .having("chrt", 0)
        .with("etc/onboard/robot.toml", robot)
        .with("proc/interrupts", table)
        .with("proc/sys/kernel/sched_autogroup_enabled", "1\n")
        .with(&governor(0), "powersave\n")
        // Where nothing can be written, not even by root.
        .with(&(governor(1) + "/file"), "");
    let root = computer.0.path().display().to_string();
    let done = computer.run("prepare-computer", &[&root]);
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{said}");
    let set = fs::read_to_string(computer.path(&governor(0))).expect("written");
    assert_eq!(set, "performance\n");
    let autogroups = computer.path("proc/sys/kernel/sched_autogroup_enabled");
    assert_eq!(fs::read_to_string(autogroups).expect("written"), "0\n");
    assert!(
        said.contains("cpu1/cpufreq/scaling_governor takes no"),
        "{said}"
    );
    let calls = "ethtool -C eth0 rx-usecs 0\nethtool -C eth0 tx-usecs 0\npgrep ^irq/24-\n";
    assert_eq!(computer.calls(), calls);
}

#[test]
fn the_interface_of_the_bus_is_found_however_the_file_is_written() {
    for robot in [
        "[ethercat]\n  interface = 'eth0'\n",
        "  [ethercat] # the drive\n\tinterface=\"eth0\"\n",
        "ethercat.interface = 'eth0'\n",
        "ethercat = { watchdog_ms = 50, interface = \"eth0\" }\n",
    ] {
        let computer = Computer::new()
            .having("ethtool", 0)
            .with("etc/onboard/robot.toml", robot)
            .with("proc/interrupts", "");
        let root = computer.0.path().display().to_string();
        assert!(computer.run("prepare-computer", &[&root]).status.success());
        let calls = "ethtool -C eth0 rx-usecs 0\nethtool -C eth0 tx-usecs 0\n";
        assert_eq!(computer.calls(), calls, "{robot}");
    }
}

/// As on the ODROID XU4, whose cores 0 to 3 are slow.
#[test]
fn the_interrupt_of_the_bus_leaves_the_fast_cores() {
    let affinity = "proc/irq/24/smp_affinity_list";
    let set = |cores: u32, slow: u32| {
        let mut computer = Computer::new()
            .having("ethtool", 0)
            .having("pgrep", 1)
            .with("etc/onboard/robot.toml", "ethercat.interface = 'eth0'\n")
            .with("proc/interrupts", " 24:  1  PCI-MSI  eth0\n")
            .with(affinity, "0-11\n");
        for core in 0..cores {
            let speed = match core {
                _ if core >= slow => "1024\n",
                core if core % 2 == 0 => "448\n",
                _ => "500\n",
            };
            let file = format!("sys/devices/system/cpu/cpu{core}/cpu_capacity");
            computer = computer.with(&file, speed);
        }
        let root = computer.0.path().display().to_string();
        let done = computer.run("prepare-computer", &[&root]);
        assert!(done.status.success(), "{done:?}");
        fs::read_to_string(computer.path(affinity)).expect("it is there")
    };
    assert_eq!(set(8, 4), "3\n");
    assert_eq!(set(12, 11), "10\n");
    // All are alike, or the kernel does not tell.
    assert_eq!(set(8, 0), "0-11\n");
    assert_eq!(set(0, 0), "0-11\n");
}

/// A robot that is not there yet has no bus.
#[test]
fn without_an_interface_nothing_is_asked_of_one() {
    let robot = "[ethercat]\nudp = \"127.0.0.1:7\"\n[fleet]\ninterface = \"wlan0\"\n";
    let computer = Computer::new()
        .having("ethtool", 0)
        .with("etc/onboard/robot.toml", robot);
    let root = computer.0.path().display().to_string();
    let done = computer.run("prepare-computer", &[&root]);
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(
        done.status.success() && said.contains("no interface"),
        "{said}"
    );
    assert_eq!(computer.calls(), "");
}

#[test]
fn doctor_has_the_rights_and_folders_of_the_robot() {
    let settings = |text: &str| -> BTreeMap<String, String> {
        let pairs = text.lines().filter_map(|line| line.trim().split_once('='));
        pairs
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .collect()
    };
    let unit = settings(&read("onboard.service"));
    let script = read("onboard-doctor");
    let doctor = settings(
        &script
            .replace("--property=\"", "\n")
            .replace("--property=", "\n")
            .replace(['"', '\\'], "\n"),
    );
    assert!(doctor.len() >= 10, "{doctor:?}");
    for (key, value) in &doctor {
        let expected = match key.as_str() {
            // The robot's folder must not go when the look is over.
            "RuntimeDirectoryPreserve" => "yes",
            key => unit.get(key).map_or("", String::as_str),
        };
        assert_eq!(value.trim(), expected, "{key}");
    }
    let command = "run --robot /etc/onboard/robot.toml --site /etc/onboard/site.toml --runtime /run/onboard --state /var/lib/onboard";
    assert!(unit["ExecStart"].ends_with(command));
    assert!(script.contains(&command.replacen("run ", "doctor ", 1)));
}

#[test]
fn no_port_is_taken_that_nobody_has_given() {
    for file in ["70-fieldbus.network", "fieldbus.conf"] {
        let text = read(file);
        let own: Vec<&str> = { text.lines() }
            .filter(|line| !line.starts_with('#'))
            .collect();
        assert!(own.iter().any(|line| line.contains("fieldbus")), "{file}");
        assert!(!own.iter().any(|line| line.contains("eth")), "{file}");
    }
    let found = Computer::new().run("take-port", &["no-such-port"]);
    assert_eq!(found.status.code(), Some(2));
    let said = String::from_utf8_lossy(&found.stderr).into_owned();
    assert!(
        said.contains("found port 'no-such-port', expected one of:"),
        "{said}"
    );
}

/// systemd's rules find out where a device is plugged in, in a file that is read before.
#[test]
fn names_of_devices_are_known_when_they_are_given() {
    let name = "65-onboard.rules";
    assert!(name > "60-serial.rules");
    let rules = read(name);
    let lines = || { rules.lines() }.filter(|line| !line.starts_with('#'));
    for line in lines().filter(|line| line.contains("SYMLINK")) {
        assert!(line.contains("ENV{ID_PATH}==\"?*\""), "{line}");
    }
    // `/dev/watchdog` is a device of another subsystem than `/dev/watchdog0`.
    let watchdog = lines()
        .find(|line| line.contains("watchdog"))
        .expect("a rule");
    assert!(!watchdog.contains("SUBSYSTEM"), "{watchdog}");
}
