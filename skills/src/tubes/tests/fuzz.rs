//! Any input: no panic, and no motion without a scan, on NaN, or faster than wanted.

use super::stand::{parameters, with_detours};
use super::world::{MS, Random, SMALL, urg};
use crate::history::OdometryHistory;
use crate::odometry::{DeadReckoning, EncoderSample};
use crate::scan::AlignedScan;
use crate::tubes::{MotionTubes, Reason, StopRules, TubeSet, Verdict};
use description::geometry::{MotionCommand, Twist2};
use description::robot::TricycleGeometry;
use description::robot::Tubes;
use proptest::prelude::*;
use std::sync::OnceLock;

fn set() -> TubeSet {
    static SET: OnceLock<TubeSet> = OnceLock::new();
    let generate = || {
        let parameters = Tubes {
            horizons: parameters().horizons[..3].to_vec(),
            omega_steps: 21,
            ..parameters()
        };
        TubeSet::generate(&parameters, &SMALL, &urg()).unwrap().0
    };
    SET.get_or_init(generate).clone()
}

/// Scans of every kind that a broken device, or a strange place, could send.
fn fill(random: &mut Random, raw: &mut [u16]) {
    match random.below(8) {
        // Frozen: as it was.
        0 => {}
        // Nothing in range, nothing known, everything at the longest or the shortest length.
        1 => raw.fill(0),
        2 => raw.fill(1 + random.below(19) as u16),
        3 => raw.fill(u16::MAX),
        4 => raw.fill(20),
        // Noise over all values, codes among them.
        5 => raw.fill_with(|| random.between(0.0, 65_535.9) as u16),
        6 => raw.fill_with(|| random.between(0.0, 40.0) as u16),
        _ => raw.fill_with(|| random.between(1_000.0, 4_200.0) as u16),
    }
}

fn number(random: &mut Random, scale: f64) -> f64 {
    match random.below(40) {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => -1e300,
        3 => 0.0,
        _ => random.between(-scale, scale),
    }
}

struct Rig {
    random: Random,
    now_ns: u64,
    encoders: EncoderSample,
    dead_reckoning: DeadReckoning,
    history: OdometryHistory,
    scan: AlignedScan,
    raw: Vec<u16>,
    tubes: MotionTubes,
    /// Arrival of the last scan that was judged.
    judged_ns: Option<u64>,
    moved: usize,
}

impl Rig {
    fn new(seed: u64) -> Self {
        Self {
            random: Random(seed),
            now_ns: 3_600_000 * MS,
            encoders: EncoderSample::default(),
            dead_reckoning: DeadReckoning::new(TricycleGeometry::default(), 35.0).unwrap(),
            history: OdometryHistory::default(),
            scan: AlignedScan::new(urg()).unwrap(),
            raw: vec![0; urg().beams],
            tubes: MotionTubes::new(set(), with_detours(), StopRules::default()).unwrap(),
            judged_ns: None,
            moved: 0,
        }
    }

    /// 5 ms of encoders, which in trouble now and then jump, wrap, or are no numbers.
    fn odometry(&mut self, troubled: bool) {
        let random = &mut self.random;
        self.encoders.stamp_ns = self.now_ns;
        self.encoders.angles.left_rad += random.between(-0.01, 0.06);
        self.encoders.angles.right_rad += random.between(-0.01, 0.06);
        match random.below(200) {
            _ if !troubled => {}
            0 => self.encoders.angles.left_rad += number(random, 1e3),
            1 => self.encoders.angles.pivot_rad = number(random, 3.0),
            2 => self.encoders = EncoderSample::default(),
            _ => {}
        }
        if !self.encoders.angles.left_rad.is_finite() || !self.encoders.angles.pivot_rad.is_finite()
        {
            let _ = self.dead_reckoning.update(&self.encoders);
            self.encoders = EncoderSample::default();
        }
        let _ = self.dead_reckoning.update(&self.encoders);
        let odometry = *self.dead_reckoning.odometry();
        // Sometimes a pose from nowhere.
        let mut pose = odometry.pose;
        if troubled && self.random.below(500) == 0 {
            pose.x_m = number(&mut self.random, 1e12);
        }
        let _ = self.history.push(odometry.stamp_ns, pose, odometry.twist);
    }

    fn tick(&mut self, troubled: bool) {
        for _ in 0..20 {
            self.now_ns += 5 * MS;
            self.odometry(troubled);
        }
        if troubled {
            match self.random.below(40) {
                0 => {
                    let back_ns = (self.random.unit() * 3_000.0) as u64 * MS;
                    self.now_ns = self.now_ns.saturating_sub(back_ns);
                }
                1 => self.now_ns += (self.random.unit() * 3_000.0) as u64 * MS,
                2 => self.now_ns = (self.random.unit() * 1e13) as u64,
                3 => self.history.clear(),
                _ => {}
            }
        }
        if !troubled || self.random.below(5) > 0 {
            if troubled {
                fill(&mut self.random, &mut self.raw);
            } else {
                self.raw
                    .fill_with(|| self.random.between(3_000.0, 4_500.0) as u16);
            }
            let stamp_ns = self.now_ns.saturating_sub(urg().duration_ns() + 20 * MS);
            let _ = self.scan.align(&self.raw, stamp_ns, &self.history);
            if self.tubes.observe(&self.scan, self.now_ns).is_ok() {
                self.judged_ns = Some(self.now_ns);
            }
        }
        for _ in 0..1 + self.random.below(4) {
            self.ask(troubled);
            self.now_ns += 30 * MS;
        }
    }

    fn ask(&mut self, troubled: bool) {
        let random = &mut self.random;
        let wanted = if troubled {
            MotionCommand::new(number(random, 0.6), number(random, 4.0))
        } else {
            MotionCommand::new(0.3, 0.0)
        };
        let current = if troubled && random.below(10) == 0 {
            Twist2::new(number(random, 1.0), number(random, 2.0))
        } else {
            Twist2::new(0.1, 0.0)
        };
        let adapted = self.tubes.adapt(wanted, current, self.now_ns);
        let speed_m_s = adapted.command.speed_m_s;
        assert!(adapted.command.is_finite() && adapted.length_m.is_finite());
        assert!(adapted.command.curvature_1_m.abs() <= 20.0, "{adapted:?}");
        if speed_m_s == 0.0 {
            return;
        }
        self.moved += 1;
        assert!(wanted.is_finite() && current.is_finite(), "{adapted:?}");
        if wanted.speed_m_s > 0.0 && speed_m_s < 0.0 {
            // It backs out of a dead end.
            assert_eq!(adapted.verdict, Verdict::Shifted, "{wanted:?} {adapted:?}");
            assert!(speed_m_s >= -0.1, "{adapted:?}");
        } else {
            assert!(speed_m_s * wanted.speed_m_s > 0.0, "{wanted:?} {adapted:?}");
            assert!(speed_m_s.abs() <= wanted.speed_m_s.abs());
        }
        assert!(adapted.verdict != Verdict::Stopped && adapted.tube.is_some());
        let judged_ns = self.judged_ns.expect("a scan was judged");
        // A present scan: neither older than the timeout, nor from the future.
        assert!(
            self.now_ns.saturating_sub(judged_ns) <= 250 * MS,
            "{adapted:?}"
        );
        assert!(
            judged_ns.saturating_sub(self.now_ns) <= 20 * MS,
            "{adapted:?}"
        );
        let delay_s = adapted.scan_age_ns as f64 * 1e-9 + 0.1;
        let needed_m = speed_m_s.abs() * delay_s + speed_m_s * speed_m_s / 4.0;
        assert!(needed_m <= adapted.length_m + 1e-9, "{adapted:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, ..ProptestConfig::default() })]

    #[test]
    fn nothing_that_comes_in_makes_it_move_unseen(seed in any::<u64>()) {
        survives(seed);
    }
}

/// A positive wish after 3 s before a thing: it backs out of the dead end.
#[test]
fn what_backs_out_is_not_held_to_the_wish() {
    survives(33_367);
}

fn survives(seed: u64) {
    let mut rig = Rig::new(seed);
    for tick in 0..400 {
        rig.tick(tick / 50 % 2 == 1);
    }
    // Whatever it went through, good scans bring it back.
    rig.tubes.reset();
    rig.history.clear();
    rig.now_ns = rig.now_ns.max(1) + 10_000_000 * MS;
    rig.dead_reckoning = DeadReckoning::new(TricycleGeometry::default(), 35.0).unwrap();
    rig.scan = AlignedScan::new(urg()).unwrap();
    let before = rig.moved;
    for _ in 0..40 {
        rig.tick(false);
    }
    assert!(rig.moved > before);
}

#[test]
fn a_clock_that_is_set_back_stops_it_until_scans_are_good_again() {
    let mut rig = Rig::new(1);
    for _ in 0..40 {
        rig.tick(false);
    }
    let ahead = MotionCommand::new(0.3, 0.0);
    let ask = |rig: &mut Rig| rig.tubes.adapt(ahead, Twist2::default(), rig.now_ns);
    assert_eq!(ask(&mut rig).verdict, Verdict::Free);
    rig.now_ns -= 1_000_000 * MS;
    assert_eq!(ask(&mut rig).reason, Reason::NoScan);
    rig.history.clear();
    rig.dead_reckoning = DeadReckoning::new(TricycleGeometry::default(), 35.0).unwrap();
    rig.scan = AlignedScan::new(urg()).unwrap();
    for _ in 0..6 {
        rig.tick(false);
    }
    assert_eq!(ask(&mut rig).reason, Reason::AwaitingScans);
    for _ in 0..20 {
        rig.tick(false);
    }
    assert_eq!(ask(&mut rig).verdict, Verdict::Free);
    assert!(rig.tubes.counters().jumps > 0);
}
