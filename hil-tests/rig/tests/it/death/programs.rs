//! The robot's program is killed, or told to end.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::net::UnixDatagram;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Signal, kill_process};
use sim::rt::monotonic_ns;

use crate::programs::bench::Bench;
use crate::programs::figures::{LATE_BESIDE_OTHERS_US, all_are_punctual, all_keep_their_time};
use crate::programs::held::HeldThread;
use crate::programs::late::once_more_if_late;
use crate::programs::watch::SURELY_STANDS;

/// A pipe with less than a long line free is full.
const FREE_BYTES: u64 = 4096;
/// The drive's own watchdog; then the wheels roll out by friction.
const WATCHDOG: Duration = Duration::from_millis(100);

fn names_of(paths: &[String]) -> BTreeSet<&str> {
    { paths.iter() }
        .filter_map(|path| path.rsplit('/').next())
        .collect()
}

#[test]
fn killed_while_driving_it_stands_and_can_start_again() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        assert_ne!(
            bench.left_behind(),
            Vec::<String>::new(),
            "it has names while it runs"
        );
        kill(&mut bench);
        // The rig cleans up after its robots, and leaves what is for the next one.
        bench.robot = None;
        assert_eq!(
            names_of(&bench.left_behind()),
            ["amr-1.checkpoint", "amr-1.journey"].into()
        );

        bench.start();
        bench.until_driving();
        let said = bench.log();
        assert!(said.contains("going on from"), "{said}");
        // At its start it would believe to be far behind.
        let (truth, believed) = (bench.truth().pose, bench.published().pose);
        let off_m = believed.map(|pose| (pose.x_m - truth.x_m).hypot(pose.y_m - truth.y_m));
        assert!(off_m.is_some_and(|off_m| off_m < 0.15), "{off_m:?}");
        kill(&mut bench);
        // Nobody cleans up: the next robot does it itself.
        assert_ne!(bench.left_behind(), Vec::<String>::new());
        let output = bench.ctl("pause");
        assert_eq!(
            output.status.code(),
            Some(1),
            "a dead robot answers nobody: {output:?}"
        );
        let dead = bench.start();
        bench.until_driving();
        let status = bench.process().stop();
        assert!(status.success(), "{status}");
        // Where it has ended.
        assert_eq!(names_of(&bench.left_behind()), ["amr-1.journey"].into());
        assert_eq!(bench.truth().collisions, 0);
        drop(dead);
    });
}

/// As after `systemctl restart`, or a reboot.
#[test]
fn told_to_end_while_it_waits_for_an_operator_the_next_one_waits_too() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        bench.devices.drive.set_emergency_stop(true);
        bench.until("it says so", Duration::from_secs(5), |bench| {
            bench.publishes("motors-off")
        });
        bench.until_standing(SURELY_STANDS);
        let ended = bench.process().stop();
        assert!(ended.success(), "{ended}");
        bench.devices.drive.set_emergency_stop(false);
        bench.start();
        bench.until("it says why it stands", Duration::from_secs(20), |bench| {
            bench.publishes("operator-stop")
        });
        assert!(
            bench
                .log()
                .contains("stays stopped until `onboard ctl reset`"),
            "{}",
            bench.log()
        );
        bench.stands_for(Duration::from_secs(5));
        bench.ask("reset");
        bench.until_driving();
        bench.finish();
    });
}

#[test]
fn switched_off_while_driving_it_waits_to_be_told_where_it_stands() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        kill(&mut bench);
        bench.robot = None;
        // What its computer had in memory is gone.
        let left = bench.left_behind();
        let checkpoint = left.iter().find(|path| path.ends_with(".checkpoint"));
        fs::remove_file(checkpoint.expect("there was one")).expect("removed");
        bench.start();
        bench.until("it asks", Duration::from_secs(20), |bench| {
            bench.publishes("place-unknown")
        });
        assert!(bench.log().contains("onboard ctl place"), "{}", bench.log());
        bench.is_refused("reset", "ctl place");
        bench.is_refused("resume", "stopped");
        bench.stands_for(Duration::from_secs(3));
        let truth = bench.truth().pose;
        let here = format!("{:.3},{:.3},{:.4}", truth.x_m, truth.y_m, truth.theta_rad);
        bench.ask(&format!("place {here}"));
        bench.stands_for(Duration::from_millis(500));
        bench.ask("reset");
        bench.until_driving();
        bench.finish();
    });
}

fn kill(bench: &mut Bench) {
    let killed_ns = monotonic_ns();
    bench.process().signal(Signal::KILL);
    bench.until_standing(SURELY_STANDS);
    let log = bench.since(killed_ns);
    let (first, last) = (log[0], log[log.len() - 1]);
    // v0 for the watchdog's time, then v0² / 2a at 1.5 m/s², and as much again for wide margins.
    let way_m = last.distance_m - first.distance_m;
    let most_m = first.twist.v_m_s * 2.0 * WATCHDOG.as_secs_f64() + 0.15;
    assert!(
        way_m < most_m,
        "{way_m:.3} m, expected at most {most_m:.3} m"
    );
    bench.stands_for(Duration::from_millis(500));
    assert_eq!(bench.truth().collisions, 0);
}

/// Killed when the test is over.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A terminal that was stopped, a pipe that nobody reads, a disk that hangs: all are a standard error that takes nothing.
#[test]
fn a_log_that_nobody_takes_holds_up_nothing() {
    once_more_if_late(|| {
        let mut bench = Bench::new();
        let mut command = bench.command(&bench.robot_file());
        command.env("ONBOARD_LOG", "trace").stderr(Stdio::piped());
        let mut robot = Running(command.spawn().expect("it starts"));
        let log = robot.0.stderr.take().expect("piped");
        bench.until_driving();
        let before = bench.threads();
        bench.until("the pipe is full", Duration::from_secs(30), |bench| {
            // Something to say, if there is nothing else.
            bench.ask("resume");
            let waiting = rustix::io::ioctl_fionread(&log).expect("a pipe");
            waiting + FREE_BYTES >= rustix::pipe::fcntl_getpipe_size(&log).expect("a pipe") as u64
        });
        std::thread::sleep(Duration::from_secs(1));
        let after = bench.threads();
        all_keep_their_time(&before, &after);
        all_are_punctual(&before, &after, LATE_BESIDE_OTHERS_US);
        bench.is_stopped(Duration::from_millis(250), |bench| bench.ask("stop"));
        bench.ask("reset");
        bench.until_driving();
        let pid = rustix::process::Pid::from_child(&robot.0);
        bench.is_stopped(Duration::from_millis(250), |_| {
            kill_process(pid, Signal::TERM).expect("it runs");
        });
        bench.until("it has ended", Duration::from_secs(10), |_| {
            robot.0.try_wait().expect("a child").is_some()
        });
        assert!(robot.0.wait().expect("ended").success());
        assert_eq!(bench.truth().collisions, 0);
    });
}

/// A robot whose program a service manager watches, which wants to hear of it at least as often, and where it hears it.
fn watched(bench: &Bench, patience: Duration) -> (UnixDatagram, Running) {
    let place = bench.path("notify");
    let socket = UnixDatagram::bind(&place).expect("a socket");
    socket.set_nonblocking(true).expect("a socket");
    let mut command = bench.command(&bench.robot_file());
    command
        .env("NOTIFY_SOCKET", &place)
        .env("WATCHDOG_USEC", patience.as_micros().to_string())
        .stderr(Stdio::null());
    (socket, Running(command.spawn().expect("it starts")))
}

/// What a service manager's socket takes in, one line each, until the socket is empty.
fn heard(socket: &UnixDatagram) -> Vec<String> {
    let mut bytes = [0; 1024];
    std::iter::from_fn(|| {
        let count = socket.recv(&mut bytes).ok()?;
        Some(String::from_utf8_lossy(&bytes[..count]).trim().to_owned())
    })
    .collect()
}

#[test]
fn a_service_manager_hears_that_it_is_ready_lives_stands_and_ends() {
    once_more_if_late(|| {
        let mut bench = Bench::new();
        let (socket, mut robot) = watched(&bench, Duration::from_secs(3));
        let mut said = Vec::new();
        let hears = |wanted: &str, said: &mut Vec<String>| {
            said.extend(heard(&socket));
            said.iter().any(|line| line == wanted)
        };
        for wanted in ["READY=1", "STATUS=running", "WATCHDOG=1"] {
            bench.until(wanted, Duration::from_secs(20), |_| {
                hears(wanted, &mut said)
            });
        }
        bench.ask("stop");
        let status = "STATUS=stopped: operator-stop";
        bench.until(status, Duration::from_secs(5), |_| hears(status, &mut said));
        // A program that is held up does not live.
        let pid = rustix::process::Pid::from_child(&robot.0);
        kill_process(pid, Signal::STOP).expect("it runs");
        // What it was saying when the signal came is said.
        std::thread::sleep(Duration::from_millis(300));
        said.clear();
        hears("", &mut said);
        std::thread::sleep(Duration::from_secs(1));
        said.clear();
        assert!(!hears("WATCHDOG=1", &mut said), "{said:?}");
        kill_process(pid, Signal::CONT).expect("it runs");
        bench.until("a sign of life", Duration::from_secs(5), |_| {
            hears("WATCHDOG=1", &mut said)
        });
        kill_process(pid, Signal::TERM).expect("it runs");
        bench.until("STOPPING=1", Duration::from_secs(10), |_| {
            hears("STOPPING=1", &mut said)
        });
        assert!(robot.0.wait().expect("ended").success());
    });
}

/// Only this one: its program goes on, and so do those who watch it from the inside.
#[test]
fn a_service_manager_hears_no_more_of_a_program_with_a_thread_that_hangs() {
    once_more_if_late(|| {
        let mut bench = Bench::new();
        let (socket, mut robot) = watched(&bench, Duration::from_secs(2));
        let lives = || heard(&socket).iter().any(|line| line == "WATCHDOG=1");
        bench.until("it drives", Duration::from_secs(20), |bench| {
            bench.truth().twist.v_m_s > 0.1
        });
        assert!(lives());
        let held = HeldThread::of(robot.0.id(), "navigation");
        let mut last_life = Instant::now();
        bench.until("silence", Duration::from_secs(15), |_| {
            if lives() {
                last_life = Instant::now();
            }
            last_life.elapsed() > Duration::from_secs(3)
        });
        bench.until_standing(SURELY_STANDS);
        drop(held);
        bench.until("a sign of life", Duration::from_secs(5), |_| lives());
        let pid = rustix::process::Pid::from_child(&robot.0);
        kill_process(pid, Signal::TERM).expect("it runs");
        assert!(robot.0.wait().expect("ended").success());
    });
}

#[test]
fn told_to_end_it_stands_first_and_leaves_nothing() {
    once_more_if_late(|| {
        for signal in [Signal::TERM, Signal::INT] {
            let mut bench = Bench::driving();
            let told_ns = monotonic_ns();
            bench.process().signal(signal);
            let status = bench.process().stop();
            assert_eq!(status.code(), Some(0), "{signal:?}: {status}");
            // It was at rest by its own doing, not by the watchdog's: motors were told to hold zero speed.
            bench.stopped_in_time(told_ns, Duration::from_millis(150));
            let told = bench.devices.drive.statistics().last_rad_s;
            assert_eq!(told, (0.0, 0.0), "the last setpoints");
            assert!(bench.truth().twist.v_m_s.abs() < 0.01);
            bench.finish();
        }
    });
}
