//! The robot's program is killed, or told to end.

use std::time::Duration;

use rustix::process::Signal;
use sim::rt::monotonic_ns;

use crate::bad_days::bench::Bench;
use crate::bad_days::watch::SURELY_STANDS;
use crate::late::once_more_if_late;

/// The drive's own watchdog; then the wheels roll out by friction.
const WATCHDOG: Duration = Duration::from_millis(100);

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
        let left = bench.left_behind();
        let [checkpoint] = left.as_slice() else {
            panic!("{left:?}");
        };
        assert!(checkpoint.ends_with("amr-1.checkpoint"), "{checkpoint}");

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
        assert_eq!(bench.left_behind(), Vec::<String>::new());
        assert_eq!(bench.truth().collisions, 0);
        drop(dead);
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
