//! The cores: how fast they run, how deep they sleep, how many there are for the robot's threads, who interrupts them.

use super::computer::Computer;
use super::finding::Finding;
use crate::realtime::latency;
use crate::realtime::own_cores::Room;

/// Waking from a deeper sleep than this is late for a thread of 1 ms.
const LONGEST_EXIT_US: u64 = 50;
const CORES: &str = "/sys/devices/system/cpu";

/// All of them. `own`: what the robot's threads find of cores.
pub fn findings(computer: &Computer, own: &Room) -> Vec<Finding> {
    vec![
        governor(computer),
        sleep(computer),
        room(own),
        balance(computer),
    ]
}

fn core_folders(computer: &Computer) -> Vec<String> {
    let is_core = |name: &String| {
        name.strip_prefix("cpu")
            .is_some_and(|number| !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()))
    };
    let names = computer.names(CORES).into_iter().filter(is_core);
    names.map(|name| format!("{CORES}/{name}")).collect()
}

/// Numbers of those that are not fast.
pub fn slow(computer: &Computer, fast_cores: &[usize]) -> Vec<usize> {
    let mut slow: Vec<usize> = { core_folders(computer).into_iter() }
        .filter_map(|folder| folder.rsplit_once("cpu")?.1.parse().ok())
        .filter(|core| !fast_cores.contains(core))
        .collect();
    slow.sort_unstable();
    slow
}

fn governor(computer: &Computer) -> Finding {
    const SUBJECT: &str = "governor";
    let read = |folder: String| computer.text(&format!("{folder}/cpufreq/scaling_governor"));
    let mut found: Vec<String> = core_folders(computer)
        .into_iter()
        .filter_map(read)
        .collect();
    found.sort();
    found.dedup();
    match found.as_slice() {
        [] => Finding::unknown(
            SUBJECT,
            "the kernel does not set the frequency of cores here",
            "performance, or a fixed frequency from the firmware or the host",
        ),
        [only] if only == "performance" => Finding::good(SUBJECT, "performance"),
        several => Finding::weak(
            SUBJECT,
            several.join(", "),
            "performance: a core that slows down while nothing happens is slow when something does",
        )
        .with(format!(
            "echo performance | sudo tee {CORES}/cpu*/cpufreq/scaling_governor"
        )),
    }
}

/// States of sleep, and whether the robot may keep cores out of them.
fn sleep(computer: &Computer) -> Finding {
    const SUBJECT: &str = "sleep of cores";
    let mut deepest: Option<(u64, String)> = None;
    for folder in core_folders(computer) {
        for state in computer.names(&format!("{folder}/cpuidle")) {
            let file = |name: &str| format!("{folder}/cpuidle/{state}/{name}");
            if computer.number(&file("disable")) == Some(1) {
                continue;
            }
            let (exit_us, name) = (
                computer.number(&file("latency")),
                computer.text(&file("name")),
            );
            if let Some(exit_us) = exit_us {
                deepest = deepest.max(Some((exit_us, name.unwrap_or(state))));
            }
        }
    }
    let Some((exit_us, name)) = deepest else {
        return Finding::good(SUBJECT, "cores do not sleep");
    };
    let is = format!("{name}, from which a core wakes in {exit_us} µs");
    if exit_us <= LONGEST_EXIT_US {
        return Finding::good(SUBJECT, is);
    }
    match latency::may_forbid() {
        Ok(()) => Finding::good(SUBJECT, format!("{is}; forbidden while the robot runs")),
        Err(error) => Finding::weak(
            SUBJECT,
            format!("{is}, and {} cannot be written: {error}", latency::DEVICE),
            "a robot that may forbid it",
        )
        .with(format!(
            "sudo chgrp robots {0} && sudo chmod g+w {0}",
            latency::DEVICE
        )),
    }
}

fn room(own: &Room) -> Finding {
    const SUBJECT: &str = "cores";
    if own.are_alike() {
        let (cores, threads) = (own.cores, own.real_time);
        let is = format!("{cores} cores, all alike, for {threads} real-time threads");
        // One more than threads: for the interrupt of the bus, and for all others.
        return if cores > threads {
            Finding::good(
                SUBJECT,
                format!("{is}: none is given one of its own, and none needs it"),
            )
        } else {
            Finding::weak(
                SUBJECT,
                is,
                format!("more than {threads} cores: those of lower priority wait for the others"),
            )
            .with(format!(
                "echo 1 | sudo tee {CORES}/cpu*/online   # those that are switched off"
            ))
        };
    }
    let (free, fast, big) = (own.free.len(), own.fast, own.big);
    let is =
        format!("{free} of {fast} fast cores are free for {big} real-time threads that want one");
    if own.is_enough() {
        Finding::good(SUBJECT, format!("{is}: each has its own"))
    } else {
        Finding::weak(
            SUBJECT,
            is,
            "one for each: those of lower priority wait for the others",
        )
        .with("threads.NAME.core = \"little\"   # in the robot file, for one that may wait")
    }
}

fn balance(computer: &Computer) -> Finding {
    const SUBJECT: &str = "interrupts";
    match computer.runs("irqbalance") {
        Some(_) => Finding::weak(
            SUBJECT,
            "irqbalance moves them from core to core",
            "interrupts that stay where they are",
        )
        .with("sudo systemctl disable --now irqbalance"),
        None => Finding::good(SUBJECT, "nobody moves them"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::computer::tests::Fake;
    use super::super::finding::Verdict;
    use super::*;
    use crate::realtime::scheduling::{CoreClass, Wanted};

    #[test]
    fn one_core_that_saves_energy_is_enough_for_advice() {
        let fast = Fake::new()
            .with(
                "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor",
                "performance\n",
            )
            .with("/sys/devices/system/cpu/cpufreq/boost", "1\n");
        assert_eq!(governor(&fast.computer()).verdict, Verdict::Good);
        let mixed = fast.with(
            "/sys/devices/system/cpu/cpu4/cpufreq/scaling_governor",
            "ondemand\n",
        );
        let found = governor(&mixed.computer());
        assert_eq!(
            (found.verdict, found.is.as_str()),
            (Verdict::Weak, "ondemand, performance")
        );
        assert_eq!(governor(&Fake::new().computer()).verdict, Verdict::Unknown);
    }

    #[test]
    fn the_deepest_sleep_that_is_allowed_counts() {
        let state = |fake: Fake, number: u32, name: &str, exit_us: u32, disabled: u32| {
            let file =
                |file: &str| format!("/sys/devices/system/cpu/cpu0/cpuidle/state{number}/{file}");
            fake.with(&file("name"), name)
                .with(&file("latency"), &exit_us.to_string())
                .with(&file("disable"), &disabled.to_string())
        };
        let fake = state(state(Fake::new(), 0, "POLL", 0, 0), 1, "C1", 2, 0);
        let fake = state(fake, 2, "C6", 133, 1);
        let found = sleep(&fake.computer());
        assert_eq!(found.verdict, Verdict::Good);
        assert!(
            found.is.starts_with("C1, from which a core wakes in 2 µs"),
            "{found}"
        );
        let deep = state(fake, 3, "C7", 700, 0);
        assert!(sleep(&deep.computer()).is.starts_with("C7"));
    }

    #[test]
    fn cores_that_are_not_fast_are_slow() {
        let folder = |number: u32| format!("/sys/devices/system/cpu/cpu{number}/online");
        let fake = [0, 1, 10, 2].map(folder);
        let fake = { fake.iter() }.fold(Fake::new(), |fake, file| fake.with(file, "1\n"));
        let fake = fake.with("/sys/devices/system/cpu/cpuidle/current_driver", "none\n");
        assert_eq!(slow(&fake.computer(), &[1, 2]), [0, 10]);
        assert_eq!(slow(&fake.computer(), &[0, 1, 2, 10]), [0; 0]);
    }

    #[test]
    fn threads_are_counted_against_cores_that_nobody_else_has() {
        let thread = |fifo_priority, cores| Wanted {
            fifo_priority,
            cores,
        };
        let big = |priority| thread(Some(priority), CoreClass::Big);
        let three = [big(80), big(70), big(50)];
        // Four slow and four fast ones, and as many that are all alike.
        let unlike: Vec<(usize, u64)> = (0..8)
            .map(|n| (n, if n < 4 { 448 } else { 1024 }))
            .collect();
        let alike: Vec<(usize, u64)> = (0..8).map(|n| (n, 1024)).collect();
        let of = |wanted: &[Wanted], cores: &[(usize, u64)]| {
            let found = room(&Room::among(wanted, cores));
            assert_eq!(found.verdict == Verdict::Weak, found.command.is_some());
            (found.verdict, found.is)
        };
        let (verdict, is) = of(&three, &unlike);
        assert!(is.starts_with("4 of 4 fast cores are free for 3 "), "{is}");
        assert_eq!(verdict, Verdict::Good);
        let named = |core| thread(None, CoreClass::Number(core));
        let (verdict, is) = of(&[big(80), big(70), big(50), named(7)], &unlike);
        assert!(is.starts_with("3 of 4 fast cores are free for 3 "), "{is}");
        assert_eq!(verdict, Verdict::Good);
        let (verdict, is) = of(&[big(80), big(70), big(50), named(7), named(6)], &unlike);
        assert!(is.starts_with("2 of 4 fast cores are free for 3 "), "{is}");
        assert_eq!(verdict, Verdict::Weak);
        let (verdict, is) = of(&three, &alike[..4]);
        assert!(is.starts_with("4 cores, all alike, for 3 "), "{is}");
        assert_eq!(verdict, Verdict::Good);
        assert_eq!(of(&three, &alike[..3]).0, Verdict::Weak);
    }

    #[test]
    fn irqbalance_is_found() {
        let fake = Fake::new().with("/proc/9/comm", "irqbalance\n");
        assert_eq!(balance(&fake.computer()).verdict, Verdict::Weak);
    }
}
