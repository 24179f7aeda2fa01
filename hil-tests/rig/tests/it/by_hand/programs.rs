//! Somebody drives the robot by hand, with the program that people use.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use onboard::process::teleop::Status;
use rig::process::robot::SUBCOMMAND;

use crate::programs::bench::{Bench, RIG, ROBOT, onboard, said};
use crate::programs::late::once_more_if_late;

/// A program says what is wanted this often.
const PERIOD: Duration = Duration::from_millis(50);
/// From the last wish until the robot stands: its deadline, a cycle of navigation, braking from the speed of teleoperation.
const SILENT_STOP: Duration = Duration::from_millis(250 + 50 + 350);
/// From the end of a connection: the same without the deadline.
const CLOSED_STOP: Duration = Duration::from_millis(50 + 50 + 350);

/// `onboard teleop --stdin`, and what it prints.
struct Hand {
    program: Child,
    status: Receiver<Status>,
    newest: Status,
}

impl Hand {
    fn on(bench: &Bench) -> Self {
        let runtime = bench.runtime_folder();
        let mut program = Command::new(RIG)
            .arg(SUBCOMMAND)
            .args(["teleop", ROBOT, "--stdin", "--runtime"])
            .arg(runtime)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        let printed = program.stdout.take().expect("piped");
        let (sender, status) = channel();
        // Ends with the program.
        thread::spawn(move || {
            for line in BufReader::new(printed).lines().map_while(Result::ok) {
                let said = serde_json::from_str(&line).expect("a status");
                if sender.send(said).is_err() {
                    return;
                }
            }
        });
        Self {
            program,
            status,
            newest: Status::default(),
        }
    }

    /// Wants this for a while.
    fn wants(&mut self, forward_m_s: f64, turn_rad_s: f64, seconds: f64) {
        let input = self.program.stdin.as_mut().expect("piped");
        for _ in 0..(seconds / PERIOD.as_secs_f64()).ceil() as u32 {
            writeln!(input, "{forward_m_s} {turn_rad_s}").expect("it reads");
            thread::sleep(PERIOD);
        }
    }

    /// What the robot said last.
    fn says(&mut self) -> &Status {
        while let Ok(status) = self.status.try_recv() {
            self.newest = status;
        }
        &self.newest
    }
}

impl Drop for Hand {
    fn drop(&mut self) {
        // It may have ended before.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// A robot that is driven by hand.
fn driven() -> (Bench, Hand) {
    let bench = Bench::driving();
    let mut hand = Hand::on(&bench);
    hand.wants(0.0, 0.0, 1.5);
    // How fast is judged on the simulated clock.
    let mut drives = || {
        hand.wants(0.2, 0.0, 0.2);
        bench.truth().twist.v_m_s > 0.05
    };
    assert!((0..50).any(|_| drives()), "{:?}", bench.truth());
    assert_eq!(bench.published().mode, "teleop");
    (bench, hand)
}

#[test]
fn a_hand_drives_the_robot_and_whatever_ends_it_stops_it() {
    once_more_if_late(|| {
        let (mut bench, mut hand) = driven();
        // Up its ramp.
        hand.wants(0.2, 0.0, 1.5);
        let status = hand.says().clone();
        assert!(
            status.limit.is_empty() && (status.pose.x_m - bench.truth().pose.x_m).abs() < 0.2,
            "{status:?}"
        );

        // A second person is refused.
        let runtime = bench.runtime_folder();
        let runtime = runtime.to_str().expect("a plain path");
        let second = onboard(&["teleop", ROBOT, "--stdin", "--runtime", runtime]);
        let why = said(&second);
        assert!(
            second.status.code() == Some(1) && why.contains("another teleoperator"),
            "{why}"
        );
        let plain = onboard(&["teleop", ROBOT, "--runtime", runtime]);
        let why = said(&plain);
        assert!(
            plain.status.code() == Some(2) && why.contains("--stdin"),
            "{why}"
        );

        // It says nothing any more.
        hand.wants(0.2, 0.0, 0.5);
        bench.until_standing(SILENT_STOP);
        bench.stands_for(Duration::from_millis(500));

        // It is killed.
        hand.wants(0.0, 0.0, 0.2);
        hand.wants(0.2, 0.0, 1.5);
        hand.program.kill().expect("it ran");
        bench.until_standing(CLOSED_STOP);
        bench.stands_for(Duration::from_secs(1));
        assert_eq!(bench.published().mode, "paused");

        // An operator's stop wins.
        let mut hand = Hand::on(&bench);
        hand.wants(0.2, 0.0, 2.0);
        bench.ask("stop");
        bench.until_standing(Duration::from_millis(400));
        bench.stands_for(Duration::from_millis(500));
        let ended = hand.program.wait().expect("it ran");
        assert_eq!(ended.code(), Some(1));

        // After that it goes on when it is told to.
        bench.ask("reset");
        bench.stands_for(Duration::from_secs(1));
        bench.ask("resume");
        bench.until_driving();
        bench.finish();
    });
}
