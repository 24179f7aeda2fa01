//! The kernel: its age, whether it is one for real time, what it takes from real-time threads and from its own, its clock.

use std::path::Path;
use std::time::Duration;

use super::computer::Computer;
use super::finding::Finding;
use crate::realtime::clock::{check_absolute_sleep, now_ns, sleep_until};

/// From here on sleeps to absolute times have 64 bits of time on 32-bit processors too, and PREEMPT_RT is kept for years.
const OLDEST: (u32, u32) = (5, 10);
/// Clocks that are read without a system call.
const FAST_CLOCKS: [&str; 6] = [
    "tsc",
    "arch_sys_counter",
    "kvm-clock",
    "hyperv_clocksource_tsc_page",
    "hyperv_clocksource",
    "xen",
];
/// Where the kernel tells of its clocks.
const CLOCKS: &str = "/sys/devices/system/clocksource/clocksource0";
/// So much of each period real-time threads may have at the least: ours need a tenth of one core.
const LEAST_SHARE: f64 = 0.5;

/// Debian's newest with PREEMPT_RT.
const INSTALL: &str =
    "sudo apt-get install linux-image-rt-$(dpkg --print-architecture | sed s/armhf/armmp/)";

/// All of them.
pub fn findings(computer: &Computer) -> Vec<Finding> {
    vec![
        release(computer),
        preemption(computer),
        throttling(computer),
        autogroups(computer),
        clock(computer),
        absolute_sleep(),
        sleeping(computer),
    ]
}

fn release(computer: &Computer) -> Finding {
    let (oldest_major, oldest_minor) = OLDEST;
    let should = format!("{oldest_major}.{oldest_minor} or newer");
    let Some(release) = computer.text("/proc/sys/kernel/osrelease") else {
        let is = "/proc/sys/kernel/osrelease cannot be read";
        return Finding::unknown("kernel", is, should);
    };
    let mut numbers = release.split(|c: char| !c.is_ascii_digit()).map(str::parse);
    let (Some(Ok(major)), Some(Ok(minor))) = (numbers.next(), numbers.next()) else {
        return Finding::unknown("kernel", release, should);
    };
    if (major, minor) >= OLDEST {
        Finding::good("kernel", release)
    } else {
        Finding::bad("kernel", release, should).with(INSTALL)
    }
}

fn preemption(computer: &Computer) -> Finding {
    let version = computer
        .text("/proc/sys/kernel/version")
        .unwrap_or_default();
    let is_real_time =
        computer.number("/sys/kernel/realtime") == Some(1) || version.contains("PREEMPT_RT");
    if is_real_time {
        return Finding::good("PREEMPT_RT", "a kernel for real time");
    }
    let found = ["PREEMPT_DYNAMIC", "PREEMPT"]
        .into_iter()
        .find(|kind| version.contains(kind));
    Finding::weak(
        "PREEMPT_RT",
        found.unwrap_or("no preemption inside the kernel"),
        "a kernel with PREEMPT_RT: others may hold a thread up for milliseconds",
    )
    .with(INSTALL)
}

fn throttling(computer: &Computer) -> Finding {
    const SUBJECT: &str = "throttling";
    const SHOULD: &str = "95 %, as kernels begin";
    let read = |name: &str| computer.number::<i64>(&format!("/proc/sys/kernel/{name}"));
    let (runtime, period) = (read("sched_rt_runtime_us"), read("sched_rt_period_us"));
    match (runtime, period) {
        (Some(..0), _) => Finding::good(
            SUBJECT,
            "real-time threads are not throttled; one that runs wild keeps its core",
        ),
        (Some(runtime), Some(period)) if period > 0 => {
            let is = format!("real-time threads get {runtime} of each {period} µs");
            if runtime as f64 >= period as f64 * LEAST_SHARE {
                Finding::good(SUBJECT, is)
            } else {
                Finding::bad(SUBJECT, is, SHOULD)
                    .with("sudo sysctl -w kernel.sched_rt_runtime_us=950000 kernel.sched_rt_period_us=1000000")
            }
        }
        _ => Finding::unknown(SUBJECT, "the kernel does not tell", SHOULD),
    }
}

/// Whether threads of the kernel share the cores with whole sessions (sched(7)). One of them hands on the lidar's bytes, at no real-time
/// priority: on a kernel 6.18 whose cores two sessions kept busy it was seen to wait for two seconds, and for 10 ms without autogroups.
fn autogroups(computer: &Computer) -> Finding {
    const SUBJECT: &str = "autogroups";
    const KEY: &str = "kernel.sched_autogroup_enabled";
    match computer.number("/proc/sys/kernel/sched_autogroup_enabled") {
        Some(1..) => Finding::weak(
            SUBJECT,
            "on: the kernel's thread that hands on the lidar's bytes may wait for a busy session",
            "off",
        )
        .with(format!("sudo sysctl -w {KEY}=0")),
        _ => Finding::good(SUBJECT, "off"),
    }
}

fn clock(computer: &Computer) -> Finding {
    const SUBJECT: &str = "clock";
    const SHOULD: &str = "one that is read in user space, where the processor has it";
    let Some(current) = computer.text(&format!("{CLOCKS}/current_clocksource")) else {
        return Finding::unknown(SUBJECT, "the kernel does not tell", SHOULD);
    };
    if FAST_CLOCKS.contains(&current.as_str()) {
        return Finding::good(SUBJECT, current);
    }
    let others = computer
        .text(&format!("{CLOCKS}/available_clocksource"))
        .unwrap_or_default();
    let better = others
        .split_whitespace()
        .find(|other| FAST_CLOCKS.contains(other));
    let finding = Finding::weak(
        SUBJECT,
        format!("{current}, which takes a system call to read"),
        SHOULD,
    );
    finding.with(match better {
        Some(better) => format!("echo {better} | sudo tee {CLOCKS}/current_clocksource"),
        None => "sudo dmesg | grep -i -e clocksource -e tsc -e arch_timer   # why the kernel offers no other".to_owned(),
    })
}

/// Whether somebody who closes a lid or presses a key, or nobody for long, puts the computer to sleep while its robot drives.
fn sleeping(computer: &Computer) -> Finding {
    const SUBJECT: &str = "sleep";
    const SHOULD: &str = "one that stays awake";
    const RTC: &str = "/sys/class/rtc";
    let Some(states) = computer.text("/sys/power/state") else {
        return Finding::unknown(SUBJECT, "the kernel does not tell", SHOULD);
    };
    if states.is_empty() {
        return Finding::good(SUBJECT, "this computer cannot sleep");
    }
    let is_masked = ["/etc", "/run"].into_iter().any(|folder| {
        let link = computer.link(&format!("{folder}/systemd/system/sleep.target"));
        link.is_some_and(|target| target == Path::new("/dev/null"))
    });
    if is_masked {
        return Finding::good(SUBJECT, "systemd does not let it sleep");
    }
    // By such a clock the kernel tells how long it has slept.
    let mut clocks = computer.names(RTC).into_iter();
    let is_told = |clock: String| computer.number(&format!("{RTC}/{clock}/hctosys")) == Some(1);
    let is = if clocks.any(is_told) {
        "it may be put to sleep: its robot stops then, and waits to be told where it is"
    } else {
        "it may be put to sleep, and without a battery-backed clock may not notice when it wakes"
    };
    Finding::weak(SUBJECT, is, SHOULD).with(
        "sudo systemctl mask sleep.target suspend.target hibernate.target hybrid-sleep.target",
    )
}

/// A thread that sleeps until a time which has passed must not sleep, and one that sleeps until another must not wake before.
fn absolute_sleep() -> Finding {
    const SUBJECT: &str = "absolute sleep";
    const AHEAD: Duration = Duration::from_millis(2);
    /// No machine that drives a robot is held up for so long.
    const LONGEST: Duration = Duration::from_millis(500);
    if let Err(error) = check_absolute_sleep() {
        return Finding::bad(SUBJECT, error.to_string(), "a kernel from 5.1 on").with(INSTALL);
    }
    let wanted_ns = now_ns() + AHEAD.as_nanos() as u64;
    sleep_until(wanted_ns);
    let woken_ns = now_ns();
    if woken_ns < wanted_ns {
        let early = Duration::from_nanos(wanted_ns - woken_ns);
        // A sleep that ends too soon goes on.
        return Finding::bad(
            SUBJECT,
            format!("woken {early:?} early, by a clock that has gone back"),
            "never early: another clock of those that the kernel has",
        )
        .with(format!("cat {CLOCKS}/available_clocksource   # then: echo NAME | sudo tee {CLOCKS}/current_clocksource"));
    }
    let late = Duration::from_nanos(woken_ns - wanted_ns);
    if late > LONGEST {
        return Finding::bad(
            SUBJECT,
            format!("{late:?} late"),
            "a fraction of a millisecond: cores that neither other programs nor a busy host take",
        )
        .with("top -b -n 1 | head -n 20   # who takes them");
    }
    Finding::good(SUBJECT, format!("{late:?} late"))
}

#[cfg(test)]
mod tests {
    use super::super::computer::tests::Fake;
    use super::super::finding::Verdict;
    use super::*;

    #[test]
    fn kernels_are_judged_by_age_and_kind() {
        let of = |release: &str, version: &str| {
            let fake = Fake::new()
                .with("/proc/sys/kernel/osrelease", release)
                .with("/proc/sys/kernel/version", version);
            (
                super::release(&fake.computer()).verdict,
                preemption(&fake.computer()).verdict,
            )
        };
        assert_eq!(
            of("6.1.0-18-rt-amd64\n", "#1 SMP PREEMPT_RT Debian"),
            (Verdict::Good, Verdict::Good)
        );
        assert_eq!(of("5.10", "#1 SMP PREEMPT"), (Verdict::Good, Verdict::Weak));
        assert_eq!(of("4.14.180-178", "#1 SMP"), (Verdict::Bad, Verdict::Weak));
        assert_eq!(of("unheard", ""), (Verdict::Unknown, Verdict::Weak));
    }

    #[test]
    fn throttling_is_bad_where_it_would_stop_our_threads() {
        let of = |runtime: &str| {
            let fake = Fake::new()
                .with("/proc/sys/kernel/sched_rt_runtime_us", runtime)
                .with("/proc/sys/kernel/sched_rt_period_us", "1000000\n");
            throttling(&fake.computer())
        };
        assert_eq!(of("-1\n").verdict, Verdict::Good);
        assert_eq!(of("950000\n").verdict, Verdict::Good);
        let strict = of("50000\n");
        assert_eq!(strict.verdict, Verdict::Bad);
        assert!(strict.is.contains("50000 of each 1000000 µs"), "{strict}");
        assert_eq!(
            throttling(&Fake::new().computer()).verdict,
            Verdict::Unknown
        );
    }

    #[test]
    fn autogroups_are_weak_where_there_are_any() {
        const FILE: &str = "/proc/sys/kernel/sched_autogroup_enabled";
        let of = |on: &str| autogroups(&Fake::new().with(FILE, on).computer());
        assert_eq!(of("0\n").verdict, Verdict::Good);
        let found = of("1\n");
        let command = "sudo sysctl -w kernel.sched_autogroup_enabled=0";
        assert_eq!(
            (found.verdict, found.command.as_deref()),
            (Verdict::Weak, Some(command))
        );
        let without = autogroups(&Fake::new().computer());
        assert_eq!(without.verdict, Verdict::Good);
    }

    #[test]
    fn a_slow_clock_is_told_with_the_faster_one_that_is_there() {
        let fake = Fake::new()
            .with(&format!("{CLOCKS}/current_clocksource"), "hpet\n")
            .with(
                &format!("{CLOCKS}/available_clocksource"),
                "acpi_pm hpet tsc\n",
            );
        let found = clock(&fake.computer());
        assert_eq!(found.verdict, Verdict::Weak);
        assert!(
            found
                .command
                .is_some_and(|command| command.starts_with("echo tsc |"))
        );
        let slow_ones = fake.with(&format!("{CLOCKS}/available_clocksource"), "hpet\n");
        let found = clock(&slow_ones.computer());
        assert!(
            found
                .command
                .is_some_and(|command| command.contains("dmesg"))
        );
    }

    #[test]
    fn a_computer_that_may_be_put_to_sleep_is_told() {
        let able = || Fake::new().with("/sys/power/state", "freeze mem disk\n");
        let found = sleeping(&able().computer());
        assert!(found.verdict == Verdict::Weak && found.is.contains("may not notice"));
        let clock = able().with("/sys/class/rtc/rtc0/hctosys", "1\n");
        let found = sleeping(&clock.computer());
        assert!(found.verdict == Verdict::Weak && found.is.contains("stops then"));
        for folder in ["/etc", "/run"] {
            let path = format!("{folder}/systemd/system/sleep.target");
            let masked = able().linking(&path, "/dev/null");
            assert_eq!(sleeping(&masked.computer()).verdict, Verdict::Good);
        }
        let unable = Fake::new().with("/sys/power/state", "");
        assert_eq!(sleeping(&unable.computer()).verdict, Verdict::Good);
        assert_eq!(sleeping(&Fake::new().computer()).verdict, Verdict::Unknown);
    }

    #[test]
    fn this_computer_sleeps_to_absolute_times() {
        assert_eq!(absolute_sleep().verdict, Verdict::Good);
    }
}
