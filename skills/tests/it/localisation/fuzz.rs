//! Scans, stamps and odometry that make no sense: nothing panics, and the pose is never confidently wrong.

use crate::localisation::maps;
use crate::localisation::run::{START_STD_M, START_STD_RAD};
use description::geometry::{Pose2, Twist2};
use description::robot::Navigation;
use proptest::prelude::*;
use skills::history::OdometryHistory;
use skills::localisation::PoseFilter;
use skills::odometry::Odometry;
use skills::perception::walls::WallMatcher;
use skills::scan::{AlignedScan, ScanGeometry};

/// One scan's ranges.
#[derive(Clone, Debug)]
enum Ranges {
    Zero,
    Full,
    Codes(u16),
    Constant(u16),
    Noise(u16, u16, u64),
    Frozen,
}

fn ranges() -> impl Strategy<Value = Ranges> {
    prop_oneof![
        Just(Ranges::Zero),
        Just(Ranges::Full),
        (1u16..20).prop_map(Ranges::Codes),
        any::<u16>().prop_map(Ranges::Constant),
        (20u16..4000, 0u16..3000, any::<u64>())
            .prop_map(|(low, span, seed)| Ranges::Noise(low, span, seed)),
        Just(Ranges::Frozen),
    ]
}

fn fill(raw: &mut [u16], ranges: &Ranges) {
    match *ranges {
        Ranges::Zero => raw.fill(0),
        Ranges::Full => raw.fill(u16::MAX),
        Ranges::Codes(code) => raw.fill(code),
        Ranges::Constant(length) => raw.fill(length),
        Ranges::Noise(low, span, seed) => {
            let mut random = crate::random::Random::new(seed);
            for place in raw {
                *place = low.saturating_add((random.uniform() * f64::from(span)) as u16);
            }
        }
        Ranges::Frozen => {}
    }
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -0.05..0.05f64, 1 => -3.0..3.0f64, 1 => prop::num::f64::ANY]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn nonsense_neither_panics_nor_convinces(
        steps in prop::collection::vec(
            (ranges(), (number(), number(), number()), 0u64..200_000_000, any::<bool>()),
            1..40,
        ),
    ) {
        let place = maps::t_junction();
        let lidar = ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0);
        let mut scan = AlignedScan::new(lidar).expect("sound lidar");
        let mut matcher = WallMatcher::new(&place.map, lidar.beams, Navigation::default());
        let mut filter =
            PoseFilter::new(Navigation::default(), place.start(), START_STD_M, START_STD_RAD);
        let mut raw = vec![0u16; lidar.beams];
        let mut odometry = Odometry { stamp_ns: 10_000_000_000, ..Odometry::default() };
        for (ranges, (x, y, theta), dt_ns, backwards) in steps {
            odometry.stamp_ns = if backwards {
                odometry.stamp_ns.saturating_sub(dt_ns)
            } else {
                odometry.stamp_ns + dt_ns
            };
            odometry.pose = odometry.pose.compose(Pose2::new(x, y, theta));
            filter.predict(&odometry);
            if !odometry.pose.is_finite() {
                odometry.pose = Pose2::IDENTITY;
            }
            fill(&mut raw, &ranges);
            let mut history = OdometryHistory::new(8);
            for at_ns in [odometry.stamp_ns.saturating_sub(200_000_000), odometry.stamp_ns] {
                let _ = history.push(at_ns, odometry.pose, Twist2::default());
            }
            let _ = scan.align(&raw, odometry.stamp_ns.saturating_sub(150_000_000), &history);
            let since = odometry.pose.between(scan.odom_pose());
            let before = filter.pose();
            let outcome = filter.see_walls(&mut matcher, &scan, since);
            let (pose, covariance) = (filter.pose(), *filter.covariance());
            prop_assert!(pose.is_finite() && covariance.iter().all(|number| number.is_finite()));
            prop_assert!(covariance.symmetric_eigenvalues().min() > 0.0);
            // Nonsense may look like a wall by chance; then it must look so within what was known.
            let moved_m = before.position().distance_m(pose.position());
            prop_assert!(moved_m < 1e-9 || outcome.corrected > 0);
        }
    }
}

/// At a known place, no garbage makes the robot believe to be elsewhere.
#[test]
fn garbage_moves_nobody_who_stands() {
    let place = maps::t_junction();
    let lidar = ScanGeometry::urg_04lx(Pose2::new(0.28, 0.0, 0.0), 4.0);
    let start = place.start();
    for kind in [
        Ranges::Zero,
        Ranges::Full,
        Ranges::Codes(7),
        Ranges::Constant(1500),
        Ranges::Noise(300, 2500, 1),
        Ranges::Noise(600, 200, 2),
        Ranges::Noise(1900, 60, 3),
    ] {
        let mut scan = AlignedScan::new(lidar).expect("sound lidar");
        let mut matcher = WallMatcher::new(&place.map, lidar.beams, Navigation::default());
        let mut filter = PoseFilter::new(Navigation::default(), start, 0.03, 0.03);
        let mut raw = vec![0u16; lidar.beams];
        let mut odometry = Odometry {
            stamp_ns: 10_000_000_000,
            ..Odometry::default()
        };
        let mut history = OdometryHistory::default();
        for round in 0..100 {
            odometry.stamp_ns += 100_000_000;
            filter.predict(&odometry);
            let _ = history.push(odometry.stamp_ns, odometry.pose, Twist2::default());
            let kind = match kind {
                Ranges::Noise(low, span, seed) => Ranges::Noise(low, span, seed + round),
                ref other => other.clone(),
            };
            fill(&mut raw, &kind);
            let _ = scan.align(&raw, odometry.stamp_ns.saturating_sub(90_000_000), &history);
            filter.see_walls(&mut matcher, &scan, Pose2::IDENTITY);
            let off_m = filter.pose().position().distance_m(start.position());
            assert!(filter.is_uncertain() || off_m < 0.1, "{kind:?}: {off_m}");
        }
        assert!(filter.is_uncertain(), "{kind:?}");
    }
}
