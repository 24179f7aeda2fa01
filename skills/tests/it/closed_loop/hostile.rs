//! Any input: no panic, no allocation, no motion that is not allowed.

use crate::closed_loop::floor::{Floor, corridor, lidar};
use crate::counting;
use description::areas::AreaIndex;
use description::geometry::{Pose2, Rect, Twist2};
use description::site::{ControllerConfig, MonitorKind, StopPlace, TurnDirection};
use proptest::prelude::*;
use skills::borders::AreaSet;
use skills::history::OdometryHistory;
use skills::navigator::{ByHand, Instruction, NavigationInput, Navigator};
use skills::odometry::Odometry;
use skills::scan::AlignedScan;

const STATES: [&str; 11] = [
    "drive", "beside", "end", "u-turn", "shift", "pose", "border", "told", "dock", "creep", "stop",
];

/// Every controller, and an event from everywhere to each.
fn everything() -> Floor {
    let stop_at = |place| ControllerConfig::StopAt { place };
    let controllers = [
        ("1", ControllerConfig::Corridor { offset_m: 0.0 }),
        ("1", ControllerConfig::Corridor { offset_m: -0.2 }),
        ("2", ControllerConfig::EndOfLane { distance_m: 1.2 }),
        (
            "3",
            ControllerConfig::UTurn {
                direction: TurnDirection::Left,
                radius_m: 0.5,
            },
        ),
        (
            "5",
            ControllerConfig::Shift {
                offset_m: 0.0,
                within_m: 1.6,
            },
        ),
        ("1", stop_at(StopPlace::Pose(Pose2::new(5.0, -0.5, 0.0)))),
        (
            "1",
            stop_at(StopPlace::BeforeArea {
                area: "2".into(),
                margin_m: 0.1,
            }),
        ),
        ("2", stop_at(StopPlace::Instructed)),
        ("2", ControllerConfig::Dock { distance_m: 0.3 }),
        ("1", ControllerConfig::Creep { distance_m: -0.5 }),
        ("1", ControllerConfig::Stop),
    ];
    let mut floor = corridor()
        .monitor("done", MonitorKind::ManoeuvreDone)
        .monitor("late", MonitorKind::After { after_s: 3.0 });
    for (name, (area, controller)) in STATES.into_iter().zip(controllers) {
        floor = floor
            .state(name, area, controller, &["done", "late"])
            .searching_the_end();
    }
    // The U-turn comes from the end of the lane and goes to the lane back.
    floor = floor
        .state(
            "west",
            "4",
            ControllerConfig::Corridor { offset_m: 0.0 },
            &[],
        )
        .go("end", "done", "u-turn")
        .go("u-turn", "done", "west")
        .go("drive", "late", "shift")
        .go("west", "to-drive", "drive");
    for from in STATES {
        for to in STATES
            .into_iter()
            .filter(|to| *to != "u-turn" && *to != "shift")
        {
            floor = floor.go(from, &format!("to-{to}"), to);
        }
    }
    floor
}

/// A number as a broken sensor or a stranger may send it.
fn number(scale: f64) -> impl Strategy<Value = f64> {
    prop_oneof![
        12 => -scale..scale,
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(-1e300),
        1 => Just(0.0),
        1 => any::<f64>(),
    ]
}

#[derive(Clone, Debug)]
struct Step {
    now_ns: Option<u64>,
    moved: [f64; 3],
    twist: [f64; 2],
    leap: Option<[f64; 3]>,
    codes: (u16, u16),
    stamp_back_ns: u64,
    event: usize,
    speed_limit_m_s: Option<f64>,
    stop_at: Option<[f64; 3]>,
    allowed: u64,
    motion_allowed: bool,
    by_hand: Option<[f64; 2]>,
}

fn step() -> impl Strategy<Value = Step> {
    let clock = prop_oneof![8 => Just(None), 1 => any::<u64>().prop_map(Some), 1 => Just(Some(0))];
    let by_hand = proptest::option::weighted(0.3, [number(0.5), number(3.0)]);
    (
        (clock, [-0.02..0.05f64, -0.001..0.001f64, -0.05..0.05f64]),
        [number(0.5), number(1.0)],
        proptest::option::weighted(0.1, [number(12.0), number(3.0), number(4.0)]),
        (any::<u16>(), any::<u16>()),
        prop_oneof![6 => Just(0u64), 1 => any::<u64>()],
        0..40usize,
        proptest::option::weighted(0.3, number(0.5)),
        proptest::option::weighted(0.5, [number(10.0), number(2.0), number(3.0)]),
        prop_oneof![3 => Just(u64::MAX), 1 => any::<u64>()],
        (prop::bool::weighted(0.9), by_hand),
    )
        .prop_map(
            |(
                (now_ns, moved),
                twist,
                leap,
                codes,
                stamp_back_ns,
                event,
                speed_limit_m_s,
                stop_at,
                allowed,
                (motion_allowed, by_hand),
            )| Step {
                now_ns,
                moved,
                twist,
                leap,
                codes,
                stamp_back_ns,
                event,
                speed_limit_m_s,
                stop_at,
                allowed,
                motion_allowed,
                by_hand,
            },
        )
}

/// The footprint, a little smaller, overlaps the region.
fn inside(pose: Pose2, region: &Rect) -> bool {
    let body = crate::closed_loop::floor::FOOTPRINT.grown(-0.002);
    (0..=40).any(|along| {
        (0..=30).any(|across| {
            let x_m = -body.rear_m + body.length_m() * f64::from(along) / 40.0;
            let y_m = -body.right_m + body.width_m() * f64::from(across) / 30.0;
            region.contains(pose.transform(description::geometry::Point2::new(x_m, y_m)))
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]
    #[test]
    fn nothing_that_comes_in_breaks_a_step(steps in prop::collection::vec(step(), 1..80), seed in any::<u64>()) {
        let floor = everything();
        let start = Pose2::new(4.0, -0.5, 0.0);
        let mut navigator = Navigator::new(floor.setup(start)).expect("a sound setup");
        let events = navigator.events().clone();
        let mut random = crate::random::Random::new(seed);
        let mut history = OdometryHistory::default();
        let mut scan = AlignedScan::new(lidar()).expect("sound lidar");
        let mut raw = vec![0; lidar().beams];
        let mut odometry = Odometry::default();
        let mut now_ns = 1_000_000_000u64;
        for step in steps {
            now_ns += 50_000_000;
            let [x_m, y_m, theta_rad] = step.moved;
            odometry.stamp_ns = now_ns;
            odometry.pose = if odometry.pose.is_finite() {
                odometry.pose.compose(Pose2::new(x_m, y_m, theta_rad))
            } else {
                Pose2::IDENTITY
            };
            odometry.distance_m += x_m.abs();
            odometry.twist = Twist2::new(step.twist[0], step.twist[1]);
            if let Some([x_m, y_m, theta_rad]) = step.leap {
                odometry.pose = Pose2::new(x_m, y_m, theta_rad);
                odometry.distance_m += x_m;
            }
            let _ = history.push(now_ns, odometry.pose, odometry.twist);
            let (low, high) = (step.codes.0.min(step.codes.1), step.codes.0.max(step.codes.1));
            raw.fill_with(|| random.between(f64::from(low), f64::from(high)) as u16);
            let stamp_ns = now_ns.saturating_sub(step.stamp_back_ns).saturating_sub(100_000_000);
            let _ = scan.align(&raw, stamp_ns, &history);
            let name = STATES.get(step.event).map(|name| format!("to-{name}"));
            let event = name.and_then(|name| events.id(&name));
            let stop_at = step.stop_at.map(|[x_m, y_m, theta_rad]| Pose2::new(x_m, y_m, theta_rad));
            let mut allowed = AreaSet::ALL;
            for area in AreaIndex::first(7) {
                if step.allowed >> area.0 & 1 == 0 {
                    allowed.remove(area);
                }
            }
            let before = counting::so_far();
            if let Some(event) = event {
                let instruction = Instruction { event, speed_limit_m_s: step.speed_limit_m_s, stop_at };
                let _ = navigator.instruct(instruction);
            }
            let output = navigator.step(&NavigationInput {
                now_ns: step.now_ns.unwrap_or(now_ns),
                scan: Some(&scan),
                odometry: &odometry,
                lost: false,
                motion_allowed: step.motion_allowed,
                by_hand: step.by_hand.map(|[v_m_s, omega_rad_s]| ByHand {
                    wish: Twist2::new(v_m_s, omega_rad_s),
                    limit_m_s: 0.2,
                    creep_m_s: 0.1,
                    without_borders: false,
                }),
                allowed,
            });
            prop_assert_eq!(counting::so_far(), before);
            let speed_m_s = output.command.speed_m_s;
            prop_assert!(output.command.is_finite() && output.pose.is_finite(), "{:?}", output);
            prop_assert!((-0.2..=0.4).contains(&speed_m_s), "{:?}", output);
            prop_assert!(output.command.curvature_1_m.abs() <= 2.5, "{:?}", output);
            prop_assert!(output.covariance.as_flattened().iter().all(|number| number.is_finite()));
            prop_assert!(navigator.planned_path().iter().all(|pose| pose.is_finite()));
            let creeps = step.by_hand.is_some() && allowed == AreaSet::ALL;
            if !step.motion_allowed || output.pose_uncertain && !creeps {
                prop_assert_eq!(speed_m_s, 0.0);
            }
            let trespasses = AreaIndex::first(7).zip(&floor.site.areas).any(|(index, area)| {
                !allowed.contains(index) && inside(output.pose, &area.region)
            });
            // By hand it may be driven out.
            if trespasses && step.by_hand.is_none() {
                prop_assert!(speed_m_s == 0.0 && output.waiting_for.is_some(), "{:?}", output);
            }
        }
    }
}
