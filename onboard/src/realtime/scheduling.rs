//! Gives a thread its policy, priority and cores, and reads back what the kernel granted.

use std::fs;

use bytemuck::{Pod, Zeroable};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use serde::{Serialize, Serializer};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// Which cores a thread may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoreClass {
    /// Every core.
    Any,
    /// The fast cores of a big.LITTLE machine; every core elsewhere.
    Big,
    /// The economical cores of a big.LITTLE machine; every core elsewhere.
    Little,
    /// One core by its number.
    Number(usize),
}

/// What a thread asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Priority of `SCHED_FIFO`, 1 to 99; `None` for the normal policy.
    pub fifo_priority: Option<u8>,
    /// Cores it may use.
    pub cores: CoreClass,
}

/// What the kernel says the thread has: read back, never assumed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Granted {
    /// Bit n: may run on core n (cores beyond 63 are not shown).
    pub cores: u64,
    /// The kernel's number: 0 normal, 1 FIFO, 2 round robin.
    pub policy: u32,
    /// Real-time priority, 0 under the normal policy.
    pub priority: u32,
    /// 1 when the policy is not inherited by children (`SCHED_RESET_ON_FORK`).
    pub reset_on_fork: u32,
    /// Fills the structure.
    pub reserved: u32,
}

impl Serialize for Granted {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Shown {
            policy: &'static str,
            priority: u32,
            cores: String,
            reset_on_fork: bool,
        }
        Shown {
            policy: self.policy_name(),
            priority: self.priority,
            cores: self.cores_text(),
            reset_on_fork: self.reset_on_fork != 0,
        }
        .serialize(serializer)
    }
}

impl Granted {
    /// Name of the policy.
    #[must_use]
    pub fn policy_name(&self) -> &'static str {
        match self.policy as i32 {
            libc::SCHED_OTHER => "normal",
            libc::SCHED_FIFO => "fifo",
            libc::SCHED_RR => "rr",
            libc::SCHED_BATCH => "batch",
            libc::SCHED_IDLE => "idle",
            _ => "other",
        }
    }

    /// Numbers of the cores, such as `0,1`.
    #[must_use]
    pub fn cores_text(&self) -> String {
        let numbers: Vec<String> = (0..64)
            .filter(|n| self.cores >> n & 1 == 1)
            .map(|n: u32| n.to_string())
            .collect();
        numbers.join(",")
    }
}

/// A literal core number that this machine does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "core {number} does not exist here: expected one of {available:?}, or `any`, `big`, `little`"
)]
#[expect(missing_docs, reason = "the message says what each field is")]
pub struct NoSuchCore {
    pub number: usize,
    pub available: Vec<usize>,
}

/// Checks a literal core number against this machine.
///
/// # Errors
/// [`NoSuchCore`] when it does not exist.
pub fn check_core(cores: CoreClass) -> Result<(), NoSuchCore> {
    let CoreClass::Number(number) = cores else {
        return Ok(());
    };
    let available: Vec<usize> = core_affinity::get_core_ids()
        .unwrap_or_default()
        .iter()
        .map(|core| core.id)
        .collect();
    if available.contains(&number) {
        Ok(())
    } else {
        Err(NoSuchCore { number, available })
    }
}

/// Gives the calling thread what it wants as far as that is permitted; warnings say what to grant for the rest.
#[must_use]
pub fn promote(wanted: &Wanted) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Err(warning) = pin(wanted.cores) {
        warnings.push(warning);
    }
    if let Some(priority) = wanted.fifo_priority
        && let Err(warning) = make_fifo(priority)
    {
        warnings.push(warning);
    }
    warnings
}

/// Whether a thread would get what it wants, tried on a thread of its own.
///
/// # Errors
/// A sentence that says what was not granted, and what to grant.
pub fn try_out(wanted: &Wanted) -> Result<(), String> {
    let wanted = *wanted;
    let tried = std::thread::spawn(move || promote(&wanted)).join();
    match tried.as_deref() {
        Ok([]) => Ok(()),
        Ok(warnings) => Err(warnings.join("; ")),
        Err(_) => Err("the thread that tried it out has ended".to_owned()),
    }
}

/// The fast cores of a big.LITTLE machine; every core elsewhere.
#[must_use]
pub fn fast_cores() -> Vec<usize> {
    fastest(&capacities())
}

/// Numbers of the fastest among them: all where they are alike.
pub(super) fn fastest(capacities: &[(usize, u64)]) -> Vec<usize> {
    let high = { capacities.iter() }.map(|&(_, capacity)| capacity).max();
    { capacities.iter() }
        .filter(|&&(_, capacity)| Some(capacity) == high)
        .map(|&(core, _)| core)
        .collect()
}

/// What the calling thread has.
#[must_use]
pub fn granted() -> Granted {
    let mut parameters = libc::sched_param { sched_priority: 0 };
    // SAFETY: both calls only read the calling thread's scheduling; `parameters` outlives the call.
    let policy = unsafe {
        libc::sched_getparam(0, &raw mut parameters);
        libc::sched_getscheduler(0)
    };
    let cores = sched_getaffinity(None).map_or(0, |set| {
        (0..64)
            .filter(|&core| set.is_set(core))
            .fold(0, |mask, core| mask | 1 << core)
    });
    Granted {
        cores,
        policy: (policy & !libc::SCHED_RESET_ON_FORK).max(0) as u32,
        priority: parameters.sched_priority.max(0) as u32,
        reset_on_fork: u32::from(policy >= 0 && policy & libc::SCHED_RESET_ON_FORK != 0),
        reserved: 0,
    }
}

fn make_fifo(priority: u8) -> Result<(), String> {
    let advice = |error: String| {
        format!(
            "real-time priority {priority} was not granted ({error}); grant it with CAP_SYS_NICE or \
             `@realtime - rtprio 99` in /etc/security/limits.conf"
        )
    };
    let value =
        ThreadPriorityValue::try_from(priority).map_err(|error| advice(error.to_string()))?;
    set_thread_priority_and_policy(
        thread_native_id(),
        ThreadPriority::Crossplatform(value),
        ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
    )
    .map_err(|error| advice(error.to_string()))?;
    // The library has no flag for this: a helper that a driver forks must not inherit the priority.
    let parameters = libc::sched_param {
        sched_priority: i32::from(priority),
    };
    // SAFETY: changes the calling thread's own policy; `parameters` outlives the call.
    let result = unsafe {
        libc::sched_setscheduler(
            0,
            libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK,
            &raw const parameters,
        )
    };
    if result == 0 {
        Ok(())
    } else {
        Err(advice(std::io::Error::last_os_error().to_string()))
    }
}

fn pin(cores: CoreClass) -> Result<(), String> {
    let classes = capacities();
    let (low, high) = classes
        .iter()
        .fold((u64::MAX, 0), |(low, high), &(_, capacity)| {
            (low.min(capacity), high.max(capacity))
        });
    let wanted_capacity = match cores {
        CoreClass::Any => return Ok(()),
        CoreClass::Number(id) => {
            let pinned = core_affinity::set_for_current(core_affinity::CoreId { id });
            return if pinned {
                Ok(())
            } else {
                Err(format!("could not be pinned to core {id}"))
            };
        }
        CoreClass::Big => high,
        CoreClass::Little => low,
    };
    if low == high {
        return Ok(()); // all cores are alike
    }
    let mut set = CpuSet::new();
    classes
        .iter()
        .filter(|(_, capacity)| *capacity == wanted_capacity)
        .for_each(|&(core, _)| set.set(core));
    sched_setaffinity(None, &set)
        .map_err(|error| format!("could not be pinned to the {cores:?} cores: {error}"))
}

/// Core numbers with a figure that tells fast from slow ones: the kernel's capacity, else the highest frequency.
pub(super) fn capacities() -> Vec<(usize, u64)> {
    let read = |core: usize, file: &str| -> Option<u64> {
        fs::read_to_string(format!("/sys/devices/system/cpu/cpu{core}/{file}"))
            .ok()?
            .trim()
            .parse()
            .ok()
    };
    core_affinity::get_core_ids()
        .unwrap_or_default()
        .iter()
        .map(|core| {
            let capacity =
                read(core.id, "cpu_capacity").or_else(|| read(core.id, "cpufreq/cpuinfo_max_freq"));
            (core.id, capacity.unwrap_or(0))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_core_is_an_error_and_classes_never_are() {
        let error = check_core(CoreClass::Number(4096)).expect_err("no machine of ours has it");
        assert!(
            error.to_string().contains("core 4096 does not exist"),
            "{error}"
        );
        for cores in [CoreClass::Any, CoreClass::Big, CoreClass::Little] {
            assert_eq!(check_core(cores), Ok(()));
        }
    }

    #[test]
    fn what_was_granted_is_read_back() {
        std::thread::spawn(|| {
            let warnings = promote(&Wanted {
                fifo_priority: Some(2),
                cores: CoreClass::Big,
            });
            let granted = granted();
            assert_ne!(granted.cores, 0);
            if warnings.is_empty() {
                assert_eq!(
                    (
                        granted.policy_name(),
                        granted.priority,
                        granted.reset_on_fork
                    ),
                    ("fifo", 2, 1)
                );
            } else {
                assert_eq!(granted.policy_name(), "normal");
                assert!(warnings[0].contains("CAP_SYS_NICE"), "{warnings:?}");
            }
        })
        .join()
        .expect("thread ends");
    }
}
