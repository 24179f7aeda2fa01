//! What is measured, and for how long.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};

/// All parts together, unless told otherwise: with what they need to begin, ten minutes,
const SHORT: Duration = Duration::from_secs(540);
/// and in a long run an hour.
const LONG: Duration = Duration::from_secs(3_540);
/// The longest that a part may be told to take, seconds: a day.
const LONGEST_S: f64 = 86_400.0;

/// Arguments of `rig bench`.
#[derive(Args, Clone, Debug, Default)]
pub struct Options {
    /// An hour instead of ten minutes, and a 99.9th percentile of whatever has a million samples
    #[arg(long)]
    pub long: bool,
    /// Only these parts
    #[arg(long, value_name = "PART", value_delimiter = ',')]
    pub only: Vec<Part>,
    /// How long each part measures, in seconds [default: its share of ten minutes, or of an hour]
    #[arg(long, value_name = "N", value_parser = seconds)]
    pub seconds_per_part: Option<Duration>,
    /// Folder for bench.json [default: target/rig/bench]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// A part of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// How late a thread wakes up, beside cyclictest
    Wakeup,
    /// Reads and writes of symbols, beside locks
    Symbols,
    /// From one thread's event to another thread, beside a channel
    Events,
    /// One cycle of the fieldbus, beside SOEM
    Bus,
    /// Motion tubes against a scan, beside brute force
    Tubes,
    /// What the cycles of a robot compute, on the simulated clock
    Work,
    /// A whole robot: start, memory, processor time
    Robot,
    /// Grants and commands of a mediator
    Mediator,
}

impl Part {
    /// What it is called on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Wakeup => "wakeup",
            Self::Symbols => "symbols",
            Self::Events => "events",
            Self::Bus => "bus",
            Self::Tubes => "tubes",
            Self::Work => "work",
            Self::Robot => "robot",
            Self::Mediator => "mediator",
        }
    }

    /// Its share of the whole time: those with one sample in each period need the most for a million.
    fn share(self) -> f64 {
        match self {
            Self::Wakeup => 0.30,
            Self::Symbols => 0.16,
            Self::Events => 0.24,
            Self::Tubes => 0.04,
            Self::Work => 0.02,
            Self::Robot | Self::Bus | Self::Mediator => 0.08,
        }
    }
}

impl Options {
    /// The parts, in order.
    #[must_use]
    pub fn parts(&self) -> Vec<Part> {
        let wanted = |part: &Part| self.only.is_empty() || self.only.contains(part);
        let all = Part::value_variants().iter().copied();
        all.filter(wanted).collect()
    }

    /// How long a part measures.
    #[must_use]
    pub fn time(&self, part: Part) -> Duration {
        let all = if self.long { LONG } else { SHORT };
        { self.seconds_per_part }.unwrap_or_else(|| all.mul_f64(part.share()))
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().map_err(|error| error.to_string())?;
    if seconds > 0.0 && seconds <= LONGEST_S {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err(format!(
            "found {seconds}, expected more than 0 and at most {LONGEST_S}"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_measures_for_a_minute_less_than_ten_minutes_or_an_hour() {
        for (long, expected_s) in [(false, 540.0), (true, 3_540.0)] {
            let options = Options {
                long,
                ..Options::default()
            };
            let all = options.parts().into_iter();
            let sum_s: f64 = all.map(|part| options.time(part).as_secs_f64()).sum();
            assert!((sum_s - expected_s).abs() < 1e-3, "{sum_s}");
        }
    }

    #[test]
    fn parts_are_picked_by_name_and_time() {
        let options = Options {
            only: vec![Part::Events, Part::Wakeup],
            seconds_per_part: seconds("0.5").ok(),
            ..Options::default()
        };
        assert_eq!(options.parts(), [Part::Wakeup, Part::Events]);
        assert_eq!(options.time(Part::Events), Duration::from_millis(500));
        for part in Part::value_variants() {
            let value = part.to_possible_value().expect("none is hidden");
            assert_eq!(value.get_name(), part.name());
        }
        for wrong in ["0", "-1", "NaN", "1e9", "long"] {
            assert!(seconds(wrong).is_err(), "{wrong}");
        }
    }
}
