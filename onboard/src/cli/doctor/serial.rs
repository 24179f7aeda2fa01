//! The lidar's serial device: there, ours, under a name that stays, with nobody else at it.

use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::Path;

use rustix::fs::{Access, access, major, minor};

use super::computer::{Computer, end_rivals, is_one_robot, listed};
use super::finding::Finding;

const BY_ID: &str = "/dev/serial/by-id";
/// An FTDI chip keeps bytes for so long before it sends them, ms; a scan takes 100.
const LONGEST_LATENCY_MS: u32 = 2;
/// Programs that open serial devices to see what they are.
const CURIOUS: [&str; 2] = ["ModemManager", "brltty"];

/// All of them. `as_root`: the command that looks again, as root.
pub fn findings(computer: &Computer, device: &Path, as_root: &str) -> Vec<Finding> {
    let shown = device.display();
    let Ok(metadata) = device.metadata() else {
        let finding = Finding::bad(
            "serial device",
            format!("there is no {shown}"),
            "lidar.device names it; is it plugged in, and has it power?",
        );
        return vec![finding.with(format!("ls -l {BY_ID}   # those that are plugged in"))];
    };
    if !metadata.file_type().is_char_device() {
        let finding = Finding::bad(
            "serial device",
            format!("{shown} is no device"),
            "a serial device",
        );
        return vec![finding.with(format!("ls -l {BY_ID}   # those that are plugged in"))];
    }
    let number = (major(metadata.rdev()), minor(metadata.rdev()));
    let mut found = vec![
        may_use(device),
        name(computer, device),
        rivals(computer, device, as_root),
    ];
    found.push(curious(computer, number));
    found.extend(latency(computer, device));
    found
}

fn may_use(device: &Path) -> Finding {
    const SUBJECT: &str = "serial device";
    match access(device, Access::READ_OK | Access::WRITE_OK) {
        Ok(()) => Finding::good(
            SUBJECT,
            format!("{} may be read and written", device.display()),
        ),
        Err(error) => Finding::bad(
            SUBJECT,
            format!("{}: {error}", device.display()),
            "in a group of this user",
        )
        .with("sudo usermod --append --groups dialout \"$USER\"   # then log in again"),
    }
}

/// `ttyACM0` is whoever was plugged in first.
fn name(computer: &Computer, device: &Path) -> Finding {
    const SUBJECT: &str = "its name";
    let counted = device.to_str().is_some_and(|path| {
        ["/dev/ttyACM", "/dev/ttyUSB"]
            .iter()
            .any(|first| path.starts_with(first))
    });
    if !counted {
        return Finding::good(SUBJECT, "stays with the device");
    }
    let wanted = device.file_name();
    let own = computer.names(BY_ID).into_iter().find(|name| {
        computer
            .link(&format!("{BY_ID}/{name}"))
            .is_some_and(|target| target.file_name() == wanted)
    });
    let finding = Finding::weak(
        SUBJECT,
        "counts in the order in which devices are plugged in",
        "the name of this one device, or of where it is plugged in",
    );
    finding.with(match own {
        Some(own) => format!("lidar.device = \"{BY_ID}/{own}\"   # in the robot file"),
        None => format!(
            "udevadm info --query=symlink --name={}   # its other names, below /dev",
            device.display()
        ),
    })
}

fn rivals(computer: &Computer, device: &Path, as_root: &str) -> Finding {
    const SUBJECT: &str = "nobody else at it";
    let real = std::fs::canonicalize(device);
    let is_it = |path: &Path| real.as_ref().is_ok_and(|real| path == real);
    let programs = computer.who_has_open(is_it);
    if is_one_robot(&programs) {
        Finding::unknown(
            SUBJECT,
            format!("{} drives by it", listed(&programs)),
            "this robot alone: look again when it is stopped",
        )
    } else if !programs.is_empty() {
        let verb = match programs.len() {
            1 => "has",
            _ => "have",
        };
        Finding::bad(
            SUBJECT,
            format!("{} {verb} it open", listed(&programs)),
            "the robot alone",
        )
        .with(end_rivals(&programs))
    } else if computer.sees_all() {
        Finding::good(SUBJECT, "nobody has it open")
    } else {
        Finding::unknown(
            SUBJECT,
            "nobody that this user can see has it open",
            "the robot alone: as root all are seen",
        )
        .with(as_root)
    }
}

fn curious(computer: &Computer, (major, minor): (u32, u32)) -> Finding {
    const SUBJECT: &str = "ModemManager";
    let running: Vec<_> = CURIOUS
        .into_iter()
        .filter_map(|name| computer.runs(name))
        .collect();
    if running.is_empty() {
        return Finding::good(
            SUBJECT,
            "nobody asks serial devices whether they are modems",
        );
    }
    let known = computer
        .text(&format!("/run/udev/data/c{major}:{minor}"))
        .unwrap_or_default();
    let told = known.lines().any(|line| line == "E:ID_MM_DEVICE_IGNORE=1");
    let only_modems = running.iter().all(|program| program.name == "ModemManager");
    if told && only_modems {
        return Finding::good(SUBJECT, "it runs, and leaves this device alone");
    }
    Finding::weak(
        SUBJECT,
        format!(
            "{} sends bytes to each device that is plugged in",
            listed(&running)
        ),
        "a rule of udev that keeps this device from it, or no such program",
    )
    .with(format!("sudo systemctl disable --now {}", running[0].name))
}

/// Only some chips have it.
fn latency(computer: &Computer, device: &Path) -> Option<Finding> {
    const SUBJECT: &str = "latency timer";
    let real = std::fs::canonicalize(device).ok()?;
    let file = format!(
        "/sys/class/tty/{}/device/latency_timer",
        real.file_name()?.to_str()?
    );
    let ms = computer.number::<u32>(&file)?;
    let is = format!("{ms} ms");
    Some(if ms <= LONGEST_LATENCY_MS {
        Finding::good(SUBJECT, is)
    } else {
        Finding::weak(SUBJECT, is, "1 ms: scans come that much later")
            .with(format!("echo 1 | sudo tee {file}"))
    })
}

#[cfg(test)]
mod tests {
    use super::super::computer::tests::Fake;
    use super::super::finding::Verdict;
    use super::*;

    const AS_ROOT: &str = "sudo onboard doctor";

    #[test]
    fn a_name_that_counts_is_told_with_the_one_that_stays() {
        let fake = Fake::new().linking("/dev/serial/by-id/usb-Hokuyo_URG-if00", "../../ttyACM0");
        let found = name(&fake.computer(), Path::new("/dev/ttyACM0"));
        assert_eq!(found.verdict, Verdict::Weak);
        assert!(
            found
                .command
                .is_some_and(|text| text.contains("by-id/usb-Hokuyo_URG-if00\""))
        );
        let other = name(&fake.computer(), Path::new("/dev/ttyACM1"));
        assert_eq!(other.verdict, Verdict::Weak);
        assert!(
            other
                .command
                .is_some_and(|text| text.contains("--name=/dev/ttyACM1 "))
        );
        assert_eq!(
            name(&fake.computer(), Path::new("/dev/lidar")).verdict,
            Verdict::Good
        );
    }

    #[test]
    fn modem_manager_is_told_unless_udev_keeps_it_away() {
        let fake = Fake::new();
        assert_eq!(curious(&fake.computer(), (166, 0)).verdict, Verdict::Good);
        let fake = fake.with("/proc/70/comm", "ModemManager\n");
        assert_eq!(curious(&fake.computer(), (166, 0)).verdict, Verdict::Weak);
        let fake = fake.with(
            "/run/udev/data/c166:0",
            "N:ttyACM0\nE:ID_MM_DEVICE_IGNORE=1\n",
        );
        assert_eq!(curious(&fake.computer(), (166, 0)).verdict, Verdict::Good);
        let fake = fake.with("/proc/71/comm", "brltty\n");
        assert_eq!(curious(&fake.computer(), (166, 0)).verdict, Verdict::Weak);
    }

    #[test]
    fn a_device_that_is_missing_or_none_or_in_use_is_bad() {
        let none = Fake::new().computer();
        let of = |path: &str| findings(&none, Path::new(path), AS_ROOT);
        assert!(of("/dev/no-such-lidar")[0].is.starts_with("there is no"));
        assert!(of("/proc/version")[0].is.ends_with("is no device"));
        let fake = Fake::new()
            .with("/proc/9/comm", "cat\n")
            .linking("/proc/9/fd/0", "/dev/null");
        let found = rivals(&fake.computer(), Path::new("/dev/null"), AS_ROOT);
        assert_eq!(
            (found.verdict, found.is.as_str()),
            (Verdict::Bad, "cat (9) has it open")
        );
        assert_eq!(found.command.as_deref(), Some("sudo kill 9"));
    }

    #[test]
    fn one_robot_has_a_device_open_or_nobody_if_all_are_seen() {
        let of = |fake: &Fake| rivals(&fake.computer(), Path::new("/dev/null"), AS_ROOT);
        let unseen = of(&Fake::new());
        assert_eq!(
            (unseen.verdict, unseen.command.as_deref()),
            (Verdict::Unknown, Some(AS_ROOT))
        );
        let seen = Fake::new().with("/proc/1/comm", "systemd\n");
        assert_eq!(of(&seen).verdict, Verdict::Good);
        let robot = |fake: Fake, pid: u32| {
            fake.with(&format!("/proc/{pid}/comm"), "onboard\n")
                .linking(&format!("/proc/{pid}/fd/7"), "/dev/null")
        };
        let one = robot(seen, 40);
        assert_eq!(of(&one).verdict, Verdict::Unknown);
        let two = of(&robot(one, 41));
        assert_eq!(two.verdict, Verdict::Bad);
        assert_eq!(two.is, "onboard (40), onboard (41) have it open");
    }
}
