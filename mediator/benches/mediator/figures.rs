//! Distributions of measured times.

use std::time::Duration;

/// Measured times, sorted once.
pub struct Times(Vec<u64>);

impl Times {
    pub fn new(mut ns: Vec<u64>) -> Self {
        ns.sort_unstable();
        Self(ns)
    }

    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// The quantile at `per_mille`: the smallest time that this many of a thousand do not exceed.
    pub fn per_mille(&self, per_mille: usize) -> Duration {
        let rank = (self.0.len() * per_mille).div_ceil(1000).max(1) - 1;
        Duration::from_nanos(self.0.get(rank).copied().unwrap_or(0))
    }

    pub fn max(&self) -> Duration {
        self.per_mille(1000)
    }
}

/// The middle of some figures.
pub fn median(mut figures: Vec<f64>) -> f64 {
    figures.sort_by(f64::total_cmp);
    figures.get(figures.len() / 2).copied().unwrap_or(f64::NAN)
}

pub fn us(time: Duration) -> String {
    format!("{:.1} us", time.as_secs_f64() * 1e6)
}

pub fn ms(time: Duration) -> String {
    format!("{:.2} ms", time.as_secs_f64() * 1e3)
}

/// Where this was measured, and how busy it was.
pub fn machine() -> String {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let cpu = read("/proc/cpuinfo");
    let model = cpu.lines().find(|line| line.starts_with("model name"));
    let model = { model.and_then(|line| line.split(": ").nth(1)) }.unwrap_or("unknown processor");
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let load = read("/proc/loadavg");
    let load = load.split(' ').next().unwrap_or("?");
    let kernel = read("/proc/sys/kernel/osrelease");
    format!(
        "{model}, {cores} cores, Linux {}; load {load} at the start",
        kernel.trim()
    )
}
