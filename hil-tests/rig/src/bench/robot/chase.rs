//! Follows a scan through the robot: it is taken in, judged by the motion tubes, turned into setpoints by the next step of control, and
//! these are in a frame. What is seen late counts as late; what was not seen before the next scan came counts up to then.

use super::eyes::Seen;
use crate::bench::samples::Sample;

/// Setpoints that differ by less are the same.
const SAME_RAD_S: f64 = 1e-3;
/// By then a frame has setpoints that were there before, also if the drive limits them.
const FRAMES: u64 = 2;

/// Where the scan is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    /// It has not come yet: the newest is this one.
    Coming { scan: u64 },
    /// The robot has it; the motion tubes do not.
    TakenIn { ended_ns: u64, measured_ns: u64 },
    /// The motion tubes have judged it; control has not begun a step since.
    Judged { ended_ns: u64, since_ns: u64 },
    /// Control has made setpoints of it; they are in no frame yet.
    Controlled { ended_ns: u64, frames: u64 },
}

/// Follows one scan after the other.
#[derive(Debug, Default)]
pub(super) struct Chase {
    step: Option<Step>,
    scan: u64,
    /// Scans whose setpoints were not seen before the next scan came.
    pub(super) missed: u64,
}

impl Chase {
    /// Takes in what was seen; a sample when setpoints have reached the drive.
    pub(super) fn look(&mut self, seen: &Seen) -> Option<Sample> {
        let coming = Step::Coming { scan: seen.scan };
        let step = self.step.unwrap_or(coming);
        let late_ns = step.ended_ns().filter(|_| seen.scan != self.scan);
        let late = late_ns.map(|ended_ns| Sample::from_to(ended_ns, seen.now_ns));
        self.missed += u64::from(late.is_some());
        let step = if late.is_some() {
            Step::Coming { scan: self.scan }
        } else {
            step
        };
        self.scan = seen.scan;
        let (next, sample) = match step {
            // The sensor notes when its last byte is gone, and that may be seen after the scan: the end of the one before lies before
            // this one's beginning.
            Step::Coming { scan } if scan != seen.scan && seen.ended_ns >= seen.measured_ns => {
                let (ended_ns, measured_ns) = (seen.ended_ns, seen.measured_ns);
                let taken_in = Step::TakenIn {
                    ended_ns,
                    measured_ns,
                };
                (taken_in, None)
            }
            Step::TakenIn {
                ended_ns,
                measured_ns,
            } if seen.judged_ns >= measured_ns => {
                let since_ns = seen.now_ns;
                (Step::Judged { ended_ns, since_ns }, None)
            }
            Step::Judged { ended_ns, since_ns } if seen.controlled_ns >= since_ns => {
                let frames = seen.frames;
                (Step::Controlled { ended_ns, frames }, None)
            }
            Step::Controlled { ended_ns, frames } if is_framed(seen, frames) => {
                (coming, Some(Sample::from_to(ended_ns, seen.now_ns)))
            }
            waits => (waits, None),
        };
        self.step = Some(next);
        sample.or(late)
    }
}

impl Step {
    /// When the scan that is followed has ended; none while none is.
    fn ended_ns(self) -> Option<u64> {
        match self {
            Self::Coming { .. } => None,
            Self::TakenIn { ended_ns, .. }
            | Self::Judged { ended_ns, .. }
            | Self::Controlled { ended_ns, .. } => Some(ended_ns),
        }
    }
}

/// The newest setpoints have been in a frame after so many.
fn is_framed(seen: &Seen, frames: u64) -> bool {
    let (wanted, framed) = (seen.wanted_rad_s, seen.framed_rad_s);
    let same = |one: f64, other: f64| (one - other).abs() < SAME_RAD_S;
    let these = same(wanted.0, framed.0) && same(wanted.1, framed.1);
    seen.frames >= frames + FRAMES || seen.frames > frames && these
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot that stands, which has had a scan.
    const BEFORE: Seen = Seen {
        now_ns: 1_000,
        scan: 6,
        measured_ns: 100,
        ended_ns: 900,
        judged_ns: 150,
        controlled_ns: 990,
        wanted_rad_s: (1.0, 1.0),
        frames: 50,
        framed_rad_s: (1.0, 1.0),
    };
    const TAKEN_IN: Seen = Seen {
        now_ns: 2_100,
        scan: 7,
        measured_ns: 1_200,
        ended_ns: 2_000,
        ..BEFORE
    };
    const JUDGED: Seen = Seen {
        now_ns: 2_300,
        judged_ns: 1_250,
        // Begun before.
        controlled_ns: 2_290,
        ..TAKEN_IN
    };
    const CONTROLLED: Seen = Seen {
        now_ns: 2_500,
        controlled_ns: 2_450,
        wanted_rad_s: (2.0, 2.0),
        frames: 51,
        ..JUDGED
    };

    #[test]
    fn a_scan_is_followed_from_its_last_byte_to_its_frame() {
        let mut chase = Chase::default();
        for seen in [BEFORE, BEFORE, TAKEN_IN, TAKEN_IN, JUDGED, JUDGED] {
            assert_eq!(chase.look(&seen), None);
        }
        assert_eq!(chase.look(&CONTROLLED), None);
        // A frame that was on its way.
        let frame = |now_ns, frames, framed_rad_s| Seen {
            now_ns,
            frames,
            framed_rad_s,
            ..CONTROLLED
        };
        assert_eq!(chase.look(&frame(2_600, 52, (1.0, 1.0))), None);
        let sample = chase.look(&frame(2_700, 52, (2.0, 2.0)));
        assert_eq!(sample, Some(Sample::from_to(2_000, 2_700)));
        assert_eq!(chase.look(&frame(2_800, 54, (2.0, 2.0))), None);
        assert_eq!(chase.missed, 0);
    }

    #[test]
    fn the_second_frame_has_them_in_any_case() {
        let mut chase = Chase::default();
        for seen in [BEFORE, TAKEN_IN, JUDGED, CONTROLLED] {
            assert_eq!(chase.look(&seen), None);
        }
        let limited = Seen {
            frames: 53,
            ..CONTROLLED
        };
        assert!(chase.look(&limited).is_some());
    }

    #[test]
    fn a_scan_that_comes_too_early_takes_the_place_of_the_other_which_is_late() {
        let mut chase = Chase::default();
        for seen in [BEFORE, TAKEN_IN] {
            assert_eq!(chase.look(&seen), None);
        }
        let next = Seen {
            now_ns: 3_100,
            scan: 8,
            measured_ns: 2_200,
            ended_ns: 3_000,
            ..TAKEN_IN
        };
        assert_eq!(chase.look(&next), Some(Sample::from_to(2_000, 3_100)));
        assert_eq!(chase.missed, 1);
        let (measured_ns, ended_ns) = (2_200, 3_000);
        let expected = Step::TakenIn {
            ended_ns,
            measured_ns,
        };
        assert_eq!(chase.step, Some(expected));
    }

    #[test]
    fn a_scan_that_is_seen_before_its_end_is_noted_has_not_ended_with_the_one_before() {
        let mut chase = Chase::default();
        let early = Seen {
            ended_ns: BEFORE.ended_ns,
            ..TAKEN_IN
        };
        for seen in [BEFORE, early, early] {
            assert_eq!(chase.look(&seen), None);
        }
        for seen in [TAKEN_IN, JUDGED, CONTROLLED] {
            assert_eq!(chase.look(&seen), None);
        }
        let framed = Seen {
            frames: 53,
            ..CONTROLLED
        };
        let expected = Sample::from_to(TAKEN_IN.ended_ns, framed.now_ns);
        assert_eq!(chase.look(&framed), Some(expected));
    }
}
