//! An operator talks to the robot while it drives.

use std::fs;
use std::time::Duration;

use contract::wire::Load;
use serde_json::Value as Json;
use sim::world::{Pose, RobotModel};

use crate::programs::bench::{Bench, ROBOT, onboard, said};
use crate::programs::late::once_more_if_late;

/// A request is served by the supervisor, ten times a second.
const SERVED: Duration = Duration::from_millis(250);

#[test]
fn pause_resume_stop_and_reset_do_what_they_say() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        bench.ask("pause");
        bench.until_standing(Duration::from_secs(3));
        bench.ask("load pallet --mass-kg 40");
        bench.stands_for(Duration::from_millis(500));
        let load = Load {
            name: "pallet".to_owned(),
            mass_kg: 40.0,
        };
        let state = bench.published();
        assert_eq!((state.mode.as_str(), state.load), ("paused", Some(load)));
        let battery = state.battery.expect("the drive answers");
        let supply_v = RobotModel::new(ROBOT, Pose::default()).bus_voltage_v;
        assert!((battery.voltage_v - supply_v).abs() < 0.1, "{battery:?}");
        bench.ask("unload");
        bench.ask("resume");
        bench.until_driving();
        let state = bench.published();
        assert_eq!((state.mode.as_str(), state.load), ("running", None));

        bench.is_stopped(SERVED, |bench| bench.ask("stop"));
        bench.until_published("operator-stop", Duration::from_secs(1));
        let resume = bench.ctl("resume");
        assert_eq!(resume.status.code(), Some(1), "{}", said(&resume));
        bench.stands_for(Duration::from_secs(1));
        bench.ask("reset");
        bench.until_driving();
        assert!(!bench.publishes("operator-stop"));

        inspect(&bench);
        bench.finish();
    });
}

#[test]
fn an_operator_says_where_the_robot_stands_and_what_is_behind_it() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        for request in ["place start", "free-behind 1.5"] {
            bench.is_refused(request, "stop");
        }
        bench.ask("stop");
        bench.until_standing(Duration::from_secs(3));
        for (wrong, expected) in [("free-behind 20", "2.5"), ("place 1.0,2.0", "X,Y,THETA")] {
            let output = bench.ctl(wrong);
            let text = said(&output);
            assert!(
                output.status.code() == Some(2) && text.contains(expected),
                "{text}"
            );
        }
        bench.ask("free-behind 1.5");
        let truth = bench.truth().pose;
        let said = format!("{:.3},{:.3},{:.4}", truth.x_m, truth.y_m, truth.theta_rad);
        bench.ask(&format!("place {said}"));
        bench.ask("reset");
        bench.until_driving();
        let (truth, says) = (bench.truth().pose, bench.published().pose.expect("a pose"));
        let apart_m = (truth.x_m - says.x_m).hypot(truth.y_m - says.y_m);
        // It says where it was a tenth of a second ago.
        assert!(apart_m < 0.2, "{truth:?} {says:?}");
        bench.finish();
    });
}

fn inspect(bench: &Bench) {
    let runtime = bench.runtime_folder();
    let runtime = runtime.to_str().expect("a plain path");
    let output = onboard(&["inspect", "--json", "--robot", ROBOT, "--runtime", runtime]);
    assert!(output.status.success(), "{}", said(&output));
    let seen: Json = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(seen["robot"], ROBOT);
    let symbols = seen["symbols"].as_array().expect("a list");
    let of = |datatype: &str| -> Vec<&Json> {
        let listed = symbols.iter();
        listed
            .filter(|symbol| symbol["datatype"] == datatype)
            .collect()
    };
    let mut threads: Vec<&str> = of("thread_report")
        .iter()
        .filter_map(|thread| thread["model"].as_str())
        .collect();
    threads.sort_unstable();
    let expected = ["communication", "fieldbus", "lidar", "motion", "navigation"];
    assert_eq!(threads, expected);
    for thread in of("thread_report") {
        let value = &thread["value"];
        assert!(value["cycles"].as_u64() > Some(0), "{thread}");
        assert!(value["granted"]["policy"].is_string(), "{thread}");
        // A robot that may lock its memory has all pages that it needs before it drives.
        let locked = !bench.log().contains("memory is not");
        let faults = value["page_faults"].as_u64().expect("it runs");
        let real_time = value["granted"]["policy"] == "fifo";
        assert!(!(locked && real_time) || faults < 10, "{thread}");
        assert!(
            value["wakeup"]["p50"].is_number() && value["exec"]["max"].is_number(),
            "{thread}"
        );
    }
    assert_eq!(of("activity_state").len(), 7);
    let encoders = of("encoders");
    assert_eq!(encoders.len(), 1);
    assert_eq!(encoders[0]["owner"], "drive");
    assert!(
        encoders[0]["age_ms"]
            .as_f64()
            .is_some_and(|age| age < 500.0),
        "{}",
        encoders[0]
    );
    // Its wheels turn as the world says that they do.
    let speed_m_s = encoders[0]["value"]["left_rad_s"]
        .as_f64()
        .expect("a number")
        * bench.config.drive.geometry.wheel_diameter_m
        / 2.0;
    let true_m_s = bench.truth().twist.v_m_s;
    assert!(
        (speed_m_s - true_m_s).abs() < 0.15,
        "{speed_m_s:.3} m/s, truly {true_m_s:.3}"
    );
}

#[test]
fn a_reload_is_all_or_nothing() {
    once_more_if_late(|| {
        let mut bench = Bench::driving();
        let site = fs::read_to_string(bench.site_file()).expect("readable");
        let robot = fs::read_to_string(bench.robot_file()).expect("readable");
        let slow = site.replace("speed_limit_m_s = 0.40", "speed_limit_m_s = 0.20");
        assert_ne!(slow, site);
        bench.until_fast();

        // A bad site file changes nothing.
        fs::write(bench.site_file(), format!("{slow}\nnonsense = 1\n")).expect("written");
        bench.is_refused("reload", "nonsense");
        bench.drives_for(Duration::from_millis(500));
        bench.until_fast();

        // Nor does a good one beside a robot file with a change that takes a restart.
        fs::write(bench.site_file(), &slow).expect("written");
        let other = robot.replace("wheelbase_m = 0.25", "wheelbase_m = 0.26");
        assert_ne!(other, robot);
        fs::write(bench.robot_file(), other).expect("written");
        bench.is_refused("reload", "drive");
        bench.drives_for(Duration::from_millis(500));
        bench.until_fast();

        // Good ones take effect, and it drives on by itself.
        fs::write(bench.robot_file(), robot).expect("written");
        bench.ask("reload");
        bench.until_driving();
        let fastest = bench.fastest_m_s(Duration::from_secs(1));
        assert!(fastest < 0.3, "{fastest:.3} m/s, expected about 0.20 m/s");
        bench.finish();
    });
}
