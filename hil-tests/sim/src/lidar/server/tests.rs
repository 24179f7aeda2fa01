//! Through a real terminal, as a host sees it.

use std::fs;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use super::*;
use crate::lidar::Protocol;
use crate::lidar::{DeviceOptions, RangeSource};
use crate::world::{Obstacle, Pose, RANGE_STEPS, RobotModel, SharedWorld, WorldConfig};

/// A test that takes this long has failed.
const WATCHDOG: Duration = Duration::from_secs(10);

struct Flat;

impl RangeSource for Flat {
    fn measure(&mut self, _: u64, _: u64, readings_mm: &mut [u16; RANGE_STEPS]) {
        readings_mm.fill(1234);
    }
}

struct Host(OwnedFd);

impl Host {
    fn open(path: &Path, bit_rate: u32) -> Host {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let host = Host(rustix::fs::open(path, flags, Mode::empty()).unwrap());
        host.set_bit_rate(bit_rate);
        host
    }

    fn set_bit_rate(&self, bit_rate: u32) {
        let mut settings = tcgetattr(&self.0).unwrap();
        settings.make_raw();
        settings.set_speed(bit_rate).unwrap();
        tcsetattr(&self.0, OptionalActions::Now, &settings).unwrap();
    }

    fn write(&self, text: &str) {
        assert_eq!(rustix::io::write(&self.0, text.as_bytes()), Ok(text.len()));
    }

    fn wait(&self, timeout: Duration) -> bool {
        let mut fds = [PollFd::new(&self.0, PollFlags::IN)];
        poll(&mut fds, Some(&Timespec::try_from(timeout).unwrap())).unwrap() > 0
    }

    /// What arrives within `duration`.
    fn listen(&self, duration: Duration) -> Vec<u8> {
        let end = Instant::now() + duration;
        let mut heard = Vec::new();
        while let Some(left) = end.checked_duration_since(Instant::now()) {
            if self.wait(left) {
                let mut buffer = [0; 4096];
                match rustix::io::read(&self.0, &mut buffer) {
                    Ok(count) if count > 0 => heard.extend_from_slice(&buffer[..count]),
                    Ok(_) | Err(Errno::IO) => break,
                    Err(Errno::AGAIN) => {}
                    Err(error) => panic!("{error}"),
                }
            }
        }
        heard
    }

    /// Listens until a text has arrived, and returns everything up to its end.
    fn until(&self, text: &str) -> String {
        let end = Instant::now() + WATCHDOG;
        let mut heard = String::new();
        while Instant::now() < end {
            if self.wait(Duration::from_millis(100)) {
                let mut byte = [0];
                if rustix::io::read(&self.0, &mut byte) == Ok(1) {
                    heard.push(char::from(byte[0]));
                }
            }
            if heard.ends_with(text) {
                return heard;
            }
        }
        panic!("{text:?} did not come, but {heard:?}");
    }

    fn ask(&self, command: &str) -> String {
        self.write(command);
        self.until("\n\n")
    }
}

fn options(bit_rate: u32) -> LidarOptions {
    LidarOptions {
        device: DeviceOptions {
            bit_rate,
            protocol: Protocol::Scip20,
            ..DeviceOptions::default()
        },
        ..LidarOptions::default()
    }
}

fn serve(options: LidarOptions) -> LidarServer {
    LidarServer::start_with(Box::new(Flat), options).unwrap()
}

fn eventually(what: &str, mut condition: impl FnMut() -> bool) {
    let end = Instant::now() + WATCHDOG;
    while !condition() {
        assert!(Instant::now() < end, "never happened: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn scratch(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("sim-lidar-{}-{name}", std::process::id()));
    let _ = fs::remove_file(&path);
    path
}

#[test]
fn a_conversation_at_a_new_bit_rate() {
    let server = serve(options(19_200));
    let host = Host::open(&server.path().unwrap(), 19_200);
    assert_eq!(host.ask("QT\n"), "QT\n00P\n\n");
    assert_eq!(host.ask("SS500000\n"), "SS500000\n00P\n\n");
    host.set_bit_rate(500_000);
    assert_eq!(host.ask("MD0044072501003\n"), "MD0044072501003\n00P\n\n");
    for remaining in ["02", "01", "00"] {
        let scan = host.until("\n\n");
        assert!(
            scan.starts_with(&format!("MD00440725010{remaining}\n99b\n")),
            "{scan}"
        );
        assert_eq!(scan.len(), 2137);
    }
    assert_eq!(server.counters().scans, 3);
    server.stop();
}

#[test]
fn a_robot_in_a_world_sees_its_wall() {
    let world = SharedWorld::new(WorldConfig {
        robots: vec![RobotModel::new("amr", Pose::new(-0.28, 0.0, 0.0))],
        obstacles: vec![Obstacle::wall([2.0, -9.0], [2.0, 9.0])],
        ..WorldConfig::default()
    })
    .unwrap();
    assert!(matches!(
        LidarServer::start(&world, "other", options(750_000)),
        Err(LidarError::World(_))
    ));
    let server = LidarServer::start(&world, "amr", options(750_000)).unwrap();
    let host = Host::open(&server.path().unwrap(), 750_000);
    host.ask("MD0384038401001\n");
    let scan = host.until("\n\n");
    let data = scan.lines().nth(3).unwrap().as_bytes();
    let value = data[..3]
        .iter()
        .fold(0u32, |v, c| (v << 6) | u32::from(c - 0x30));
    assert!((1900..2100).contains(&value), "{scan}");
}

#[test]
fn another_bit_rate_is_noise_in_both_directions() {
    let server = serve(options(115_200));
    let host = Host::open(&server.path().unwrap(), 19_200);
    host.write("MD0044072501000\n");
    eventually("garbled input", || server.counters().garbled_bytes >= 16);
    assert!(!server.counters().streaming);
    host.set_bit_rate(115_200);
    host.listen(Duration::from_millis(50));
    host.ask("MD0044072501000\n");
    host.set_bit_rate(57_600);
    host.listen(Duration::from_millis(50));
    let heard = host.listen(Duration::from_millis(300));
    assert!(!heard.is_empty() && !heard.windows(4).any(|w| w == b"99b\n"));
}

#[test]
fn the_wire_is_as_slow_as_its_bit_rate() {
    let server = serve(options(19_200));
    let host = Host::open(&server.path().unwrap(), 19_200);
    let asked = Instant::now();
    host.ask("MD0044072501001\n");
    let scan = host.until("\n\n");
    assert_eq!(scan.len(), 2137);
    assert!(asked.elapsed() > Duration::from_millis(1100));
    host.ask("MD0044072501000\n");
    host.listen(Duration::from_millis(1500));
    assert!(server.counters().dropped_scans > 5);
}

#[test]
fn nobody_reads_and_nothing_grows_or_blocks() {
    let mut options = options(750_000);
    options.device.streaming = true;
    let server = serve(options);
    eventually("scans are thrown away", || {
        let counters = server.counters();
        counters.unread_bytes > 8000 && counters.dropped_scans > 0
    });
    let host = Host::open(&server.path().unwrap(), 750_000);
    host.write("QT\n");
    host.until("QT\n00P\n\n");
}

#[test]
fn a_reply_waits_for_its_reader() {
    let mut options = options(750_000);
    options.device.protocol = Protocol::Scip20;
    let server = serve(options);
    let host = Host::open(&server.path().unwrap(), 750_000);
    host.write("QT\n");
    std::thread::sleep(Duration::from_millis(900));
    assert_eq!(host.listen(Duration::from_millis(100)), b"QT\n00P\n\n");
}

#[test]
fn unplugged_and_back_under_the_same_name() {
    let link = scratch("replug");
    let mut options = options(115_200);
    options.link = Some(link.clone());
    let server = serve(options);
    assert_eq!(fs::read_link(&link).ok(), server.terminal());
    let host = Host::open(&link, 115_200);
    assert_eq!(host.ask("BM\n"), "BM\n00P\n\n");
    let faults = server.faults();
    faults.unplug();
    eventually("unplugged", || !server.counters().plugged);
    assert!(host.listen(WATCHDOG).is_empty(), "a hang-up ends listening");
    assert!(fs::symlink_metadata(&link).is_err() && server.terminal().is_none());
    faults.replug();
    eventually("plugged", || server.counters().plugged);
    let host = Host::open(&link, 115_200);
    assert_eq!(
        host.ask("BM\n"),
        "BM\n00P\n\n",
        "the laser went off with the power"
    );
    server.stop();
    assert!(fs::symlink_metadata(&link).is_err());
}

#[test]
fn only_links_are_replaced() {
    let path = scratch("taken");
    fs::write(&path, "precious").unwrap();
    let mut options = options(115_200);
    options.link = Some(path.clone());
    let error = LidarServer::start_with(Box::new(Flat), options.clone()).unwrap_err();
    assert!(error.to_string().contains("not a symbolic link"), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
    fs::remove_file(&path).unwrap();
    std::os::unix::fs::symlink("/nowhere/stale", &path).unwrap();
    drop(serve(options.clone()));
    assert!(fs::symlink_metadata(&path).is_err());
    options.device.bit_rate = 9600;
    let error = LidarServer::start_with(Box::new(Flat), options).unwrap_err();
    assert!(error.to_string().contains("9600"), "{error}");
}

#[test]
fn broken_scans_and_silence() {
    let server = serve(options(750_000));
    let host = Host::open(&server.path().unwrap(), 750_000);
    let faults = server.faults();
    host.ask("MD0044072501000\n");
    let damaged = |scan: &str| {
        let lines = scan.lines().skip(1).filter(|line| !line.is_empty());
        lines.fold(0, |bad, line| {
            let (data, sum) = line.split_at(line.len() - 1);
            bad + u32::from(crate::lidar::checksum(data.as_bytes()) != sum.as_bytes()[0])
        })
    };
    assert_eq!(damaged(&host.until("\n\n")), 0);
    faults.corrupt_checksums(1);
    eventually("one damaged line", || damaged(&host.until("\n\n")) == 1);
    faults.truncate_scans(1);
    eventually("a scan without its end", || {
        host.until("\n\n").matches("99b").count() == 2
    });
    faults.garbage(100);
    faults.silence(Duration::from_secs(1));
    // Between two scans it is silent for 72 ms only.
    let hears_nothing = || host.listen(Duration::from_millis(150)).is_empty();
    eventually("silence", hears_nothing);
    eventually("scans again", || damaged(&host.until("\n\n")) == 0);
    faults.freeze();
    eventually("a frozen device", hears_nothing);
    faults.thaw();
    host.until("99b");
}
