//! What generation counts, reports and refuses.

use super::stand::parameters;
use super::world::{SMALL, urg};
use crate::scan::ScanGeometry;
use crate::tubes::{Refusal, TubeError, TubeSet};
use description::geometry::{Footprint, Pose2};
use description::robot::{Horizon, Tubes};

fn one(length_m: f64, sample_step_m: f64) -> Tubes {
    Tubes {
        horizons: vec![Horizon {
            horizon_s: length_m / 0.4,
            speed_m_s: 0.4,
        }],
        omega_max_rad_s: 0.8,
        omega_steps: 41,
        sample_step_m,
        augment_m: sample_step_m / 2.0,
        backward_horizons: Vec::new(),
        ..parameters()
    }
}

#[test]
fn straight_samples_are_as_many_as_the_formula_says() {
    let parameters = Tubes {
        omega_steps: 3,
        omega_max_rad_s: 1e-7,
        ..one(1.2, 0.05)
    };
    let (set, report) = TubeSet::generate(&parameters, &SMALL, &urg()).unwrap();
    // The farthest sample: a front corner at the end, rounded by 0.025.
    let farthest_m = (1.24f64 + 0.025).hypot(0.15);
    let step_m = 0.05 - 1.5 * farthest_m * urg().angle_step_rad;
    let count = |length_m: f64, step_m: f64| (length_m / step_m).ceil() as usize + 1;
    let corner = count(0.025 * std::f64::consts::FRAC_PI_2, step_m / 2.0);
    let expected = 2 * count(1.2, step_m) + count(0.3, step_m) + 2 * corner;
    let per_tube = report.samples / 3;
    assert!(per_tube.abs_diff(expected) <= 2, "{per_tube} {expected}");
    assert!(report.compared <= report.samples);
    assert_eq!(report.tubes, 3);
    assert!(report.unseen.is_empty(), "straight ahead needs no memory");
    assert!(
        set.ids()
            .all(|id| set.samples(id) > 0 && !set.is_refused(id))
    );
}

#[test]
fn a_turning_tube_lists_what_memory_must_answer_for() {
    let (set, report) = TubeSet::generate(&parameters(), &SMALL, &urg()).unwrap();
    assert_eq!(report.tubes + report.refused.len(), set.len());
    let u_turn = report
        .unseen
        .iter()
        .filter(|sample| sample.curvature_1_m > 1.5);
    assert!(u_turn.clone().count() > 0);
    for sample in &report.unseen {
        assert!(sample.point.norm_m() <= 0.4 + 1e-9, "{sample:?}");
        let in_laser = urg().mount.inverse_transform(sample.point);
        assert!(urg().nearest_beam(in_laser.direction_rad()).is_none());
    }
    let text = report.to_string();
    assert!(
        text.contains("motion tubes") && text.contains("refused"),
        "{text}"
    );
}

#[test]
fn tubes_are_refused_for_a_reason() {
    let (_, report) = TubeSet::generate(&parameters(), &SMALL, &urg()).unwrap();
    assert!(
        report
            .refused
            .iter()
            .any(|refused| matches!(refused.why, Refusal::TurnsTooFar { .. }))
    );
    assert!(
        report
            .refused
            .iter()
            .any(|refused| matches!(refused.why, Refusal::Unseen { .. }))
    );
    // What the reference corridor needs is there.
    for refused in &report.refused {
        assert!(refused.curvature_1_m.abs() > 1.8, "{refused:?}");
        assert!(
            refused.curvature_1_m.abs() > 2.4 || refused.horizon.horizon_s > 3.5,
            "{refused:?}"
        );
    }

    let wide = Footprint {
        left_m: 0.5,
        right_m: 0.5,
        ..SMALL
    };
    let (_, report) = TubeSet::generate(&parameters(), &wide, &urg()).unwrap();
    assert!(
        report
            .refused
            .iter()
            .any(|refused| matches!(refused.why, Refusal::TurnsOnTheSpot { .. }))
    );

    let short_sighted = ScanGeometry {
        range_max_m: 1.5,
        ..urg()
    };
    let (_, report) = TubeSet::generate(&parameters(), &SMALL, &short_sighted).unwrap();
    assert!(
        report
            .refused
            .iter()
            .any(|refused| matches!(refused.why, Refusal::BeyondRange { .. }))
    );

    let coarse = ScanGeometry {
        angle_step_rad: urg().angle_step_rad * 6.0,
        beams: 114,
        ..urg()
    };
    let (_, report) = TubeSet::generate(&parameters(), &SMALL, &coarse).unwrap();
    assert!(
        report
            .refused
            .iter()
            .any(|refused| matches!(refused.why, Refusal::BeamsTooCoarse { .. }))
    );
}

#[test]
fn a_sensor_that_looks_backwards_judges_nothing() {
    let backwards = ScanGeometry {
        mount: Pose2::new(0.28, 0.0, std::f64::consts::PI),
        ..urg()
    };
    let parameters = Tubes {
        backward_horizons: Vec::new(),
        ..parameters()
    };
    let error = TubeSet::generate(&parameters, &SMALL, &backwards).unwrap_err();
    assert!(matches!(error, TubeError::NothingLeft { .. }), "{error}");
}

#[test]
fn nonsense_is_refused_with_what_was_found() {
    let good = parameters();
    let with = |change: fn(&mut Tubes)| {
        let mut parameters = good.clone();
        change(&mut parameters);
        TubeSet::generate(&parameters, &SMALL, &urg()).unwrap_err()
    };
    for (key, error) in [
        ("tubes.horizons", with(|p| p.horizons.clear())),
        (
            "tubes.horizons[5].horizon_s",
            with(|p| p.horizons.push(p.horizons[0])),
        ),
        (
            "tubes.horizons[0].speed_m_s",
            with(|p| p.horizons[0].speed_m_s = f64::NAN),
        ),
        (
            "tubes.horizons[0].horizon_s",
            with(|p| p.horizons[0].horizon_s = -1.0),
        ),
        (
            "tubes.horizons[3].horizon_s",
            with(|p| p.horizons[3].horizon_s = 0.7),
        ),
        ("tubes.omega_steps", with(|p| p.omega_steps = 40)),
        ("tubes.omega_steps", with(|p| p.omega_steps = 1)),
        ("tubes.omega_steps", with(|p| p.omega_steps = 1003)),
        ("tubes.omega_steps", with(|p| p.omega_steps = 11)),
        (
            "tubes.omega_max_rad_s",
            with(|p| p.omega_max_rad_s = f64::NAN),
        ),
        ("tubes.sample_step_m", with(|p| p.sample_step_m = 0.0)),
        ("tubes.augment_m", with(|p| p.augment_m = 0.02)),
        ("tubes.memory_s", with(|p| p.memory_s = f64::INFINITY)),
    ] {
        assert!(
            matches!(&error, TubeError::Key(error) if error.key == key),
            "{key}: {error}"
        );
    }

    let with = |footprint| TubeSet::generate(&parameters(), &footprint, &urg()).unwrap_err();
    let (left_m, front_m) = (0.0, 0.2);
    let flat = with(Footprint { left_m, ..SMALL });
    assert!(matches!(&flat, TubeError::Key(error) if error.key == "footprint.left_m"));
    let short = with(Footprint { front_m, ..SMALL });
    assert!(matches!(&short, TubeError::Key(error) if error.key == "lidar.mount"));
}
