use crate::closed_loop::robot::Robot;
use description::geometry::{Pose2, wrap_angle};

const START: Pose2 = Pose2::new(2.0, -0.5, 0.0);
/// No lap takes longer.
const LAP_LIMIT_S: f64 = 90.0;

#[derive(Debug, Default)]
struct Report {
    laps: u32,
    duration_s: f64,
    max_lateral_m: f64,
    max_pose_error_m: f64,
    min_clearance_m: f64,
    max_speed_m_s: f64,
    turn_starts_m: Vec<f64>,
    turn_ends: Vec<(f64, f64)>,
    allocations: u64,
    visited: Vec<String>,
}

fn drive(seed: u64, laps: u32) -> Report {
    let mut robot = Robot::new(seed, START);
    let lap = robot.events.id("lap").expect("the machine fires it");
    let mut report = Report {
        min_clearance_m: f64::INFINITY,
        ..Report::default()
    };
    let mut before_m = 0.0;
    for step in 0..(f64::from(laps) * LAP_LIMIT_S * 1e3) as u64 {
        report.duration_s = step as f64 * 1e-3;
        let said = robot.step();
        let truth = robot.plant.pose;
        if let Some(clearance_m) = robot.plant.clearance_within_m(report.min_clearance_m) {
            report.min_clearance_m = clearance_m;
        }
        let speed_m_s = (robot.plant.driven_m - before_m) / 1e-3;
        before_m = robot.plant.driven_m;
        report.max_speed_m_s = report.max_speed_m_s.max(speed_m_s);
        let Some(output) = said else { continue };
        let machine = robot.navigator.machine();
        let state = machine.state_name(output.state).to_owned();
        assert!(
            !output.pose_uncertain && !state.starts_with("halt"),
            "seed {seed}: {output:?}"
        );
        let error_m = truth.position().distance_m(output.pose.position());
        report.max_pose_error_m = report.max_pose_error_m.max(error_m);
        if output.schedule_changed {
            report.visited.push(state.clone());
            let east = truth.x_m > 5.0;
            if state.starts_with("u-turn") {
                report
                    .turn_starts_m
                    .push(if east { 10.0 - truth.x_m } else { truth.x_m });
            }
            if state == "drive-4" || state == "drive-1" {
                let (lane_m, heading_rad) = if east {
                    (0.5, std::f64::consts::PI)
                } else {
                    (-0.5, 0.0)
                };
                report.turn_ends.push((
                    truth.y_m - lane_m,
                    wrap_angle(truth.theta_rad - heading_rad),
                ));
            }
        }
        if !state.starts_with("u-turn") {
            let lane_m = if truth.theta_rad.abs() < 1.57 {
                -0.5
            } else {
                0.5
            };
            let lateral_m = (truth.y_m - lane_m).abs();
            report.max_lateral_m = report.max_lateral_m.max(lateral_m);
        }
        if output.outputs.as_slice().contains(&lap) {
            report.laps += 1;
            if report.laps == laps {
                break;
            }
        }
    }
    report.allocations = robot.allocations;
    report
}

#[test]
fn three_laps_for_several_seeds() {
    for seed in 1..=6 {
        let report = drive(seed, 3);
        println!("seed {seed}: {report:.3?}");
        assert_eq!(report.laps, 3, "seed {seed}: {report:?}");
        assert!(report.max_lateral_m < 0.06, "seed {seed}: {report:?}");
        assert!(report.min_clearance_m > 0.10, "seed {seed}: {report:?}");
        assert!(report.max_speed_m_s < 0.4 * 1.03, "seed {seed}: {report:?}");
        assert_eq!(report.turn_starts_m.len(), 6);
        for start_m in &report.turn_starts_m {
            assert!((start_m - 1.2).abs() < 0.06, "seed {seed}: {report:?}");
        }
        assert_eq!(report.allocations, 0, "seed {seed}");
    }
}
