//! What wakes up late.

use sim::world::Random;

/// Lateness of what is no thread here comes from the seed, apart from that of threads.
const LATE_STREAM: u64 = 0x4C41_5445;

/// How late threads are.
#[derive(Clone, Debug)]
pub struct Lateness {
    /// How likely a wake-up is late.
    pub share: f64,
    /// By how much at most.
    pub by_ns: u64,
    /// Only this thread.
    pub thread: Option<String>,
}

/// Holds back what runs without a coroutine of its own: the asynchronous loop, and the supervisor.
pub(super) struct Late {
    random: Random,
    /// When it runs that is due.
    runs_ns: Option<u64>,
}

impl Late {
    /// Nothing is due yet.
    pub(super) fn new(seed: u64) -> Self {
        Self {
            random: Random::new(seed, LATE_STREAM),
            runs_ns: None,
        }
    }

    /// Whether it runs now, by this name. What is `due` again before it has run is one with that.
    pub(super) fn runs(
        &mut self,
        due: bool,
        (lateness, name): (&[Lateness], &str),
        now_ns: u64,
    ) -> bool {
        if due && self.runs_ns.is_none() {
            let late_ns = late_ns(lateness, name, &mut self.random);
            self.runs_ns = Some(now_ns + late_ns);
        }
        let runs = self.runs_ns.is_some_and(|runs_ns| now_ns >= runs_ns);
        if runs {
            self.runs_ns = None;
        }
        runs
    }
}

/// How late a thread of this name wakes up.
pub(super) fn late_ns(lateness: &[Lateness], name: &str, random: &mut Random) -> u64 {
    { lateness.iter() }
        .filter(|own| own.thread.as_ref().is_none_or(|thread| thread == name))
        .map(|own| {
            let is_late = random.unit() < own.share;
            let late = if is_late { random.unit() } else { 0.0 };
            (late * own.by_ns as f64) as u64
        })
        .max()
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_due_runs_late_and_once() {
        let late = |thread: &str| Lateness {
            share: 1.0,
            by_ns: 50,
            thread: Some(thread.to_owned()),
        };
        let runs = |lateness: &[Lateness]| {
            let mut own = Late::new(1);
            let ran =
                (0..200).filter(|now_ns| own.runs(now_ns % 100 == 0, (lateness, "main"), *now_ns));
            ran.collect::<Vec<u64>>()
        };
        assert_eq!(runs(&[]), [0, 100]);
        assert_eq!(runs(&[late("other")]), [0, 100]);
        let held_up = runs(&[late("main")]);
        assert_eq!(held_up.len(), 2);
        for (ran_ns, due_ns) in held_up.into_iter().zip([0, 100]) {
            assert!((due_ns + 1..due_ns + 50).contains(&ran_ns), "{ran_ns}");
        }
    }
}
