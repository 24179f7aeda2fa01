//! Contenders that take turns: what disturbs the machine disturbs all of them.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use onboard::cli::Failure;
use sim::rt::monotonic_ns;

use super::report::{Group, PartReport, What};
use super::samples::{Sample, Samples};
use crate::stalls::{StallWatch, Stalls};

/// Windows are about as long: much longer than what a contender needs to begin, and short beside what changes on a machine.
const WINDOW: Duration = Duration::from_secs(2);
/// Turns of each contender, in however little time: the same number forward and back.
const LEAST_ROUNDS: u32 = 2;

/// What is measured beside others.
pub trait Contender {
    /// Its name in the table.
    fn name(&self) -> String;

    /// Measures for so long. It may prepare before: only what is added counts.
    ///
    /// # Errors
    /// [`Failure`] when it cannot be measured.
    fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure>;
}

/// Lets contenders take turns, and knows when the machine stalled.
pub struct Meter<'a> {
    /// Sees stalls.
    pub watch: &'a StallWatch,
    /// Whether a 99.9th percentile is wanted.
    pub long: bool,
    /// Told to end early.
    pub asked_to_end: &'a AtomicBool,
}

impl Meter<'_> {
    /// Whether it was told to end.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.asked_to_end.load(Ordering::Relaxed)
    }

    /// Measures contenders under a condition for so long, all together: adds a group to the part. Ours is the first; a rival that cannot
    /// be measured is left out, with a note.
    ///
    /// # Errors
    /// As of [`Contender::window`], of ours.
    pub fn compare(
        &self,
        part: &mut PartReport,
        what: &What,
        time: Duration,
        contenders: Vec<Box<dyn Contender + '_>>,
    ) -> Result<(), Failure> {
        self.take_turns(part, what, (time, Duration::MAX), contenders)
    }

    /// Measures what has no rival for so long, at least once, and no other window begins later, however long they take.
    ///
    /// # Errors
    /// As of [`Contender::window`].
    pub fn alone(
        &self,
        part: &mut PartReport,
        what: &What,
        time: Duration,
        contender: impl Contender,
    ) -> Result<(), Failure> {
        self.take_turns(part, what, (time, time), vec![Box::new(contender)])
    }

    fn take_turns(
        &self,
        part: &mut PartReport,
        what: &What,
        (time, most): (Duration, Duration),
        mut contenders: Vec<Box<dyn Contender + '_>>,
    ) -> Result<(), Failure> {
        let (length, rounds) = turns(time, contenders.len());
        let began = Instant::now();
        let (began_ns, before) = (monotonic_ns(), self.watch.stalls());
        let mut measured: Vec<_> = { contenders.iter() }
            .map(|contender| (contender.name(), Samples::default()))
            .collect();
        let mut window = Vec::new();
        'rounds: for round in 0..rounds {
            if round > 0 && began.elapsed() >= most {
                break;
            }
            let mut order: Vec<usize> = (0..contenders.len()).collect();
            if round % 2 == 1 {
                order.reverse();
            }
            let mut fallen = Vec::new();
            for number in order {
                if self.is_over() {
                    break 'rounds;
                }
                window.clear();
                let window_ns = monotonic_ns();
                match contenders[number].window(length, &mut window) {
                    Ok(()) => {}
                    Err(failure) if number == 0 => return Err(failure),
                    Err(failure) => {
                        let (name, why) = (&measured[number].0, reason(&failure));
                        part.notes
                            .push(format!("{}: {name} is left out: {why}", what.title));
                        fallen.push(number);
                        continue;
                    }
                }
                let stalls = self.watch.spans_since(window_ns);
                measured[number].1.add(&window, &stalls);
            }
            fallen.sort_unstable();
            for number in fallen.into_iter().rev() {
                contenders.remove(number);
                measured.remove(number);
            }
        }
        if measured.iter().all(|(_, samples)| samples.is_empty()) {
            return Ok(());
        }
        let stalls = Stalls {
            steal_ms: self.watch.stalls().steal_ms - before.steal_ms,
            ..self.watch.since(began_ns)
        };
        part.groups
            .push(Group::new(what, &measured, stalls, self.long));
        Ok(())
    }
}

/// The sentence of a failure.
#[must_use]
pub fn reason(failure: &Failure) -> String {
    let (Failure::Refused(report) | Failure::Failed(report)) = failure;
    report.to_string()
}

/// How long a window is, and how often each contender has one.
fn turns(time: Duration, contenders: usize) -> (Duration, u32) {
    let each = time / contenders.max(1) as u32;
    let rounds = (each.as_secs_f64() / WINDOW.as_secs_f64()).round() as u32;
    // As often forward as back.
    let rounds = rounds.next_multiple_of(2).max(LEAST_ROUNDS);
    (each / rounds, rounds)
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use super::*;
    use crate::bench::report::Unit;

    struct Named {
        name: &'static str,
        order: Rc<RefCell<String>>,
        /// Windows after which it fails.
        fails_after: usize,
    }

    impl Contender for Named {
        fn name(&self) -> String {
            self.name.to_owned()
        }

        fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
            if self.fails_after == 0 {
                return Err(Failure::failed("it broke"));
            }
            self.fails_after -= 1;
            self.order.borrow_mut().push_str(self.name);
            into.push(Sample::sometime(length.as_nanos() as f64));
            Ok(())
        }
    }

    /// Lets these take turns for 8 s, each until it fails.
    fn compared(all: &[(&'static str, usize)], over: bool) -> (PartReport, String, bool) {
        let order = Rc::<RefCell<String>>::default();
        let contenders = all.iter().map(|&(name, fails_after)| {
            Box::new(Named {
                name,
                order: Rc::clone(&order),
                fails_after,
            }) as Box<dyn Contender>
        });
        let watch = StallWatch::of_cores().expect("threads");
        let meter = Meter {
            watch: &watch,
            long: false,
            asked_to_end: &AtomicBool::new(over),
        };
        let mut part = PartReport::default();
        let time = Duration::from_secs(8);
        let (what, contenders) = (What::new("idle", Unit::S), contenders.collect());
        let worked = meter.compare(&mut part, &what, time, contenders).is_ok();
        let order = order.borrow().clone();
        (part, order, worked)
    }

    #[test]
    fn each_comes_first_as_often_as_the_other() {
        let (part, order, worked) = compared(&[("a", 9), ("b", 9)], false);
        assert!(worked && part.notes.is_empty());
        assert_eq!(order, "abba");
        let rows = part.groups[0].rows.iter();
        let rows: Vec<_> = rows
            .map(|row| (row.name.as_str(), row.figures.max, row.figures.apart))
            .collect();
        // As long as a stall, but only in windows in which there was one.
        for (row, name) in rows.iter().zip(["a", "b"]) {
            assert!(
                row.0 == name && (row.1 == Some(2.0) || row.2 > 0),
                "{row:?}"
            );
        }
    }

    #[test]
    fn a_rival_that_fails_is_left_out_and_ours_is_not() {
        let (part, order, worked) = compared(&[("a", 9), ("b", 0), ("c", 9)], false);
        assert!(worked);
        assert_eq!(order, "acca");
        assert_eq!(part.notes, ["idle: b is left out: it broke"]);
        let rows = part.groups[0].rows.iter();
        assert!(rows.map(|row| row.name.as_str()).eq(["a", "c"]));
        let (part, _, worked) = compared(&[("a", 1), ("b", 9)], false);
        assert!(!worked && part.groups.is_empty());
    }

    #[test]
    fn nothing_is_measured_when_it_was_told_to_end() {
        let (part, order, worked) = compared(&[("a", 9), ("b", 9)], true);
        assert!(worked && part.groups.is_empty() && order.is_empty());
    }

    #[test]
    fn what_is_alone_has_no_window_after_its_time() {
        /// Takes longer than it is told to.
        struct Slow;

        impl Contender for Slow {
            fn name(&self) -> String {
                "slow".to_owned()
            }

            fn window(&mut self, length: Duration, into: &mut Vec<Sample>) -> Result<(), Failure> {
                std::thread::sleep(3 * length);
                into.push(Sample::sometime(1.0));
                Ok(())
            }
        }

        let watch = StallWatch::of_cores().expect("threads");
        let meter = Meter {
            watch: &watch,
            long: false,
            asked_to_end: &AtomicBool::new(false),
        };
        let mut part = PartReport::default();
        let time = Duration::from_millis(4);
        let worked = meter.alone(&mut part, &What::new("start", Unit::S), time, Slow);
        assert!(worked.is_ok());
        assert_eq!(part.groups[0].rows[0].figures.samples, 1);
    }

    #[test]
    fn windows_fill_the_time_that_they_have() {
        let s = Duration::from_secs;
        assert_eq!(turns(s(40), 2), (s(2), 10));
        assert_eq!(turns(s(60), 4), (s(15) / 8, 8));
        assert_eq!(turns(s(1), 2), (s(1) / 4, 2));
        assert_eq!(turns(s(1), 0), (s(1) / 2, 2));
    }
}
