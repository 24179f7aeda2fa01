//! What generation counts, reports and refuses.

use super::world::{SMALL, urg};
use crate::scan::ScanGeometry;
use crate::tubes::{Horizon, Refusal, TubeError, TubeParameters, TubeSet};
use description::geometry::{Footprint, Pose2};

fn one(length_m: f64, d_sample_m: f64) -> TubeParameters {
    TubeParameters {
        horizons: vec![Horizon {
            duration_s: length_m / 0.4,
            speed_m_s: 0.4,
        }],
        omega_max_rad_s: 0.8,
        omega_steps: 41,
        d_sample_m,
        d_aug_m: d_sample_m / 2.0,
        backward: Vec::new(),
        ..TubeParameters::default()
    }
}

#[test]
fn straight_samples_are_as_many_as_the_formula_says() {
    let parameters = TubeParameters {
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
    let (set, report) = TubeSet::generate(&TubeParameters::default(), &SMALL, &urg()).unwrap();
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
    let (_, report) = TubeSet::generate(&TubeParameters::default(), &SMALL, &urg()).unwrap();
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
            refused.curvature_1_m.abs() > 2.4 || refused.horizon.duration_s > 3.5,
            "{refused:?}"
        );
    }

    let wide = Footprint {
        left_m: 0.5,
        right_m: 0.5,
        ..SMALL
    };
    let (_, report) = TubeSet::generate(&TubeParameters::default(), &wide, &urg()).unwrap();
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
    let (_, report) =
        TubeSet::generate(&TubeParameters::default(), &SMALL, &short_sighted).unwrap();
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
    let (_, report) = TubeSet::generate(&TubeParameters::default(), &SMALL, &coarse).unwrap();
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
    let parameters = TubeParameters {
        backward: Vec::new(),
        ..TubeParameters::default()
    };
    let error = TubeSet::generate(&parameters, &SMALL, &backwards).unwrap_err();
    assert!(matches!(error, TubeError::NothingLeft { .. }), "{error}");
}

#[test]
fn nonsense_is_refused_with_what_was_found() {
    let good = TubeParameters::default();
    let with = |change: fn(&mut TubeParameters)| {
        let mut parameters = good.clone();
        change(&mut parameters);
        TubeSet::generate(&parameters, &SMALL, &urg()).unwrap_err()
    };
    assert!(matches!(with(|p| p.horizons.clear()), TubeError::NoHorizon));
    assert!(matches!(
        with(|p| p.horizons.push(p.horizons[0])),
        TubeError::SameLength { .. }
    ));
    assert!(matches!(
        with(|p| p.horizons[0].speed_m_s = f64::NAN),
        TubeError::OutOfRange { .. }
    ));
    assert!(matches!(
        with(|p| p.horizons[0].duration_s = -1.0),
        TubeError::OutOfRange { .. }
    ));
    assert!(matches!(
        with(|p| p.horizons[3].duration_s = 0.7),
        TubeError::FasterButShorter { .. }
    ));
    assert!(matches!(
        with(|p| p.omega_steps = 40),
        TubeError::EvenSteps { .. }
    ));
    assert!(matches!(
        with(|p| p.omega_steps = 1),
        TubeError::OutOfRange { .. }
    ));
    assert!(matches!(
        with(|p| p.omega_steps = 11),
        TubeError::TubesApart { .. }
    ));
    assert!(matches!(
        with(|p| p.omega_max_rad_s = f64::NAN),
        TubeError::NotPositive { .. }
    ));
    assert!(matches!(
        with(|p| p.d_sample_m = 0.0),
        TubeError::OutOfRange { .. }
    ));
    assert!(matches!(
        with(|p| p.d_aug_m = 0.02),
        TubeError::AugmentedTooLittle { .. }
    ));
    assert!(matches!(
        with(|p| p.memory_s = f64::INFINITY),
        TubeError::OutOfRange { .. }
    ));

    let footprint = |footprint: Footprint| {
        TubeSet::generate(&TubeParameters::default(), &footprint, &urg()).unwrap_err()
    };
    assert!(matches!(
        footprint(Footprint {
            left_m: 0.0,
            ..SMALL
        }),
        TubeError::Footprint
    ));
    assert!(matches!(
        footprint(Footprint {
            front_m: 0.2,
            ..SMALL
        }),
        TubeError::SensorOutside { .. }
    ));
}
