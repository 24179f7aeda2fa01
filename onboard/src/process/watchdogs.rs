//! Those who restart the program, or the computer, when the supervisor or one of its threads hangs: systemd (`sd_notify`,
//! `WatchdogSec=`) and the computer's own watchdog (`watchdog.device`).
//!
//! They are told on a thread of their own, so that a service manager or a device that holds it up holds up nobody else; what is
//! not told in time is a restart, and the robot stands long before: its motion tube does not drive without a supervisor, nor its
//! drive without setpoints.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use description::robot::Watchdog as WatchdogConfig;
use rustix::ioctl::{Opcode, Updater, ioctl, opcode};
use sd_notify::NotifyState;

use crate::realtime::clock::{MILLISECOND_NS, SECOND_NS, now_ns, sleep_until};
use crate::realtime::memory::STACK_BYTES;
use crate::realtime::panic::Panicked;
use crate::symbols::faults::{Fault, FaultTable};
use crate::symbols::values::Mode;

/// How often watchdogs are told.
const PERIOD_NS: u64 = 250 * MILLISECOND_NS;
/// A supervisor that has not been heard for this long does not live.
const SILENT_NS: u64 = SECOND_NS;
/// systemd is not to be so impatient that a stall of the machine restarts a robot.
const LEAST_SYSTEMD: Duration = Duration::from_secs(2);

/// `WDIOC_SETTIMEOUT` of the kernel's watchdog interface (`linux/watchdog.h`).
const SET_TIMEOUT: Opcode = opcode::read_write::<i32>(b'W', 6);
/// Written as the last thing, it stops the watchdog ("magic close"), where the driver lets it be stopped.
const STOP_WATCHING: &[u8] = b"V";

/// What the supervisor says of itself, and the thread tells.
#[derive(Debug)]
pub struct Pulse {
    beat_ns: AtomicU64,
    mode: AtomicU64,
    /// A bit for each kind.
    faults: AtomicU64,
    over: AtomicBool,
}

const _: () = assert!(Fault::ALL.len() <= u64::BITS as usize);

impl Pulse {
    fn new(now_ns: u64) -> Self {
        Self {
            beat_ns: AtomicU64::new(now_ns),
            mode: AtomicU64::new(Mode::Configuring as u64),
            faults: AtomicU64::new(0),
            over: AtomicBool::new(false),
        }
    }

    /// The supervisor runs at `now_ns`. Not to be said while a thread hangs.
    pub fn beat(&self, now_ns: u64) {
        self.beat_ns.store(now_ns, Ordering::Relaxed);
    }

    /// What the robot does.
    pub fn show(&self, mode: u64, faults: &FaultTable) {
        let active = faults
            .active()
            .fold(0, |bits, fault| bits | 1 << (fault as u64));
        self.mode.store(mode, Ordering::Relaxed);
        self.faults.store(active, Ordering::Relaxed);
    }

    fn lives(&self, now_ns: u64) -> bool {
        now_ns <= self.beat_ns.load(Ordering::Relaxed) + SILENT_NS
    }

    /// What the robot does, in words.
    fn words(&self) -> (u64, String) {
        let mode = self.mode.load(Ordering::Relaxed);
        let bits = self.faults.load(Ordering::Relaxed);
        let active = { Fault::ALL.iter() }.filter(|&&fault| bits & 1 << (fault as u64) != 0);
        let names: Vec<&str> = active.map(|fault| fault.name()).collect();
        let mut words = Mode::name_of(mode).to_owned();
        if !names.is_empty() {
            words += ": ";
            words += &names.join(", ");
        }
        (mode, words)
    }
}

/// The computer's watchdog.
trait Device: Send {
    /// The program lives.
    fn feed(&mut self) -> io::Result<()>;
    /// The program ends, and is not to be missed.
    fn release(&mut self) -> io::Result<()>;
}

impl Device for File {
    fn feed(&mut self) -> io::Result<()> {
        self.write_all(&[0])
    }

    fn release(&mut self) -> io::Result<()> {
        self.write_all(STOP_WATCHING)
    }
}

/// Opens the computer's watchdog, which counts from then on.
fn open(path: &str, timeout_s: u32) -> io::Result<File> {
    let device = OpenOptions::new().write(true).open(path)?;
    let mut granted_s = i32::try_from(timeout_s).unwrap_or(i32::MAX);
    // SAFETY: this request reads and writes one int, which lives until it has returned; on a file that is no watchdog the
    // kernel refuses it.
    unsafe { ioctl(&device, Updater::<SET_TIMEOUT, i32>::new(&mut granted_s)) }?;
    if granted_s > 0 && granted_s.unsigned_abs() != timeout_s {
        tracing::warn!(
            "watchdog {path} restarts the computer after {granted_s} s, not {timeout_s} s"
        );
    }
    Ok(device)
}

/// The thread that tells watchdogs that the program lives.
#[derive(Debug)]
pub struct Watchdogs {
    pulse: Arc<Pulse>,
    thread: Option<JoinHandle<()>>,
}

impl Watchdogs {
    /// Begins to tell them. From here on the supervisor must [`beat`](Pulse::beat). The computer's watchdog is not stopped at the end of a
    /// program of which a part has `panicked`.
    ///
    /// # Errors
    /// In words, when the computer's watchdog cannot be had, or systemd's is too short.
    pub fn start(config: &WatchdogConfig, panicked: &Panicked) -> Result<Self, String> {
        if let Some(timeout) = sd_notify::watchdog_enabled()
            && timeout < LEAST_SYSTEMD
        {
            return Err(format!(
                "systemd's WatchdogSec is {} ms, expected at least {} s: the machine may stall for a moment",
                timeout.as_millis(),
                LEAST_SYSTEMD.as_secs()
            ));
        }
        let device: Option<Box<dyn Device>> = match &config.device {
            None => None,
            Some(path) => Some(Box::new(open(path, config.timeout_s).map_err(|error| {
                format!(
                    "watchdog.device {path:?}: {error}; expected a watchdog of the kernel that nobody else has open, such as \
                     \"/dev/watchdog\" (systemd has it if RuntimeWatchdogSec is set)"
                )
            })?)),
        };
        Self::telling(device, panicked)
    }

    fn telling(device: Option<Box<dyn Device>>, panicked: &Panicked) -> Result<Self, String> {
        let pulse = Arc::new(Pulse::new(now_ns()));
        let (told, panicked) = (Arc::clone(&pulse), panicked.clone());
        let thread = Builder::new()
            .name("watchdogs".into())
            .stack_size(STACK_BYTES)
            .spawn(move || tell(&told, device, &panicked))
            .map_err(|error| format!("thread watchdogs cannot be started: {error}"))?;
        Ok(Self {
            pulse,
            thread: Some(thread),
        })
    }

    /// What the supervisor says of itself.
    #[must_use]
    pub fn pulse(&self) -> &Pulse {
        &self.pulse
    }
}

impl Drop for Watchdogs {
    /// The program ends. After a panic the computer's watchdog goes on: if nobody starts the program again, it restarts the
    /// computer.
    fn drop(&mut self) {
        self.pulse.over.store(true, Ordering::Relaxed);
        // Whoever holds that thread up does not hold up the end of the program.
        if let Some(thread) = self.thread.take() {
            let deadline_ns = now_ns() + 2 * PERIOD_NS;
            while !thread.is_finished() && now_ns() < deadline_ns {
                sleep_until(now_ns() + PERIOD_NS / 25);
            }
        }
    }
}

fn tell(pulse: &Pulse, mut device: Option<Box<dyn Device>>, panicked: &Panicked) {
    let mut teller = Teller::default();
    while !pulse.over.load(Ordering::Relaxed) {
        teller.tell(pulse, device.as_deref_mut(), now_ns());
        sleep_until(now_ns() + PERIOD_NS);
    }
    notify(&[NotifyState::Stopping]);
    let released = device.filter(|_| !panicked.is_raised());
    if let Some(error) = released.and_then(|mut device| device.release().err()) {
        tracing::error!(
            "the computer's watchdog cannot be stopped, and will restart the computer: {error}"
        );
    }
}

/// What was told already.
#[derive(Debug, Default)]
struct Teller {
    ready: bool,
    status: String,
    silent: bool,
    fails: bool,
}

impl Teller {
    fn tell(&mut self, pulse: &Pulse, device: Option<&mut (dyn Device + 'static)>, now_ns: u64) {
        let (mode, status) = pulse.words();
        if status != self.status {
            notify(&[NotifyState::Status(&status)]);
            self.status = status;
        }
        if !self.ready && mode != Mode::Configuring as u64 {
            notify(&[NotifyState::Ready]);
            self.ready = true;
        }
        let silent = !pulse.lives(now_ns);
        if silent && !self.silent {
            tracing::error!(
                "the supervisor or a thread hangs: watchdogs are not told any more, and will restart the program"
            );
        }
        self.silent = silent;
        if silent {
            return;
        }
        notify(&[NotifyState::Watchdog]);
        let fed = device.map_or(Ok(()), Device::feed);
        if let Err(error) = &fed
            && !self.fails
        {
            tracing::error!(
                "the computer's watchdog does not hear that the program lives: {error}"
            );
        }
        self.fails = fed.is_err();
    }
}

/// Tells systemd, if it has started this program.
fn notify(states: &[NotifyState<'_>]) {
    // One that does not take it restarts the program, if it is told to.
    if let Err(error) = sd_notify::notify(states) {
        tracing::debug!("the service manager does not hear this program: {error}");
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::os::fd::OwnedFd;

    use super::*;

    const PATIENCE_NS: u64 = 30 * SECOND_NS;

    /// A watchdog that counts how often it was fed.
    #[derive(Default)]
    struct Fed(u32);

    impl Device for Fed {
        fn feed(&mut self) -> io::Result<()> {
            self.0 += 1;
            Ok(())
        }

        fn release(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_watchdog_is_fed_only_while_the_supervisor_beats() {
        let (pulse, mut teller, mut device) = (Pulse::new(0), Teller::default(), Fed::default());
        for now_ns in (0..10 * SECOND_NS).step_by(PERIOD_NS as usize) {
            if now_ns <= 2 * SECOND_NS {
                pulse.beat(now_ns);
            }
            teller.tell(&pulse, Some(&mut device), now_ns);
        }
        // Up to a second after the last beat.
        assert_eq!(u64::from(device.0), 3 * SECOND_NS / PERIOD_NS + 1);
        pulse.beat(10 * SECOND_NS);
        teller.tell(&pulse, Some(&mut device), 10 * SECOND_NS);
        assert_eq!(u64::from(device.0), 3 * SECOND_NS / PERIOD_NS + 2);
    }

    #[test]
    fn the_state_is_told_in_words() {
        let (pulse, mut table) = (Pulse::new(0), FaultTable::default());
        assert_eq!(pulse.words().1, "configuring");
        table.raise(Fault::OperatorStop, 1);
        table.raise(Fault::SupervisorSilent, 1);
        pulse.show(Mode::Stopped as u64, &table);
        assert_eq!(pulse.words().1, "stopped: operator-stop, supervisor-silent");
    }

    /// What a device sees of a program that lives until it was fed twice: the bytes in order. A pipe stands for the device, which takes
    /// the same writes; only its time limit cannot be asked for.
    fn seen_by_the_device(panics: bool) -> Vec<u8> {
        let (mut device, ours) = std::io::pipe().expect("a pipe");
        let device_of_program = File::from(OwnedFd::from(ours));
        let panicked = Panicked::default();
        let watchdogs = Watchdogs::telling(Some(Box::new(device_of_program)), &panicked);
        let watchdogs = watchdogs.expect("a thread");
        // Each quarter of a second; on a machine that stalls it is less often.
        let until_ns = now_ns() + PATIENCE_NS;
        while rustix::io::ioctl_fionread(&device).expect("a pipe") < 2 {
            assert!(now_ns() < until_ns, "it is not fed");
            watchdogs.pulse().beat(now_ns());
            sleep_until(now_ns() + PERIOD_NS / 5);
        }
        if panics {
            panicked.raise();
        }
        drop(watchdogs);
        let mut seen = Vec::new();
        // To the end: the program has closed its device.
        device.read_to_end(&mut seen).expect("a pipe");
        seen
    }

    #[test]
    fn the_device_is_fed_and_stopped_by_the_last_byte_unless_the_program_panicked() {
        let seen = seen_by_the_device(false);
        let (last, fed) = seen.split_last().expect("it was fed");
        assert_eq!([*last], *STOP_WATCHING);
        assert!(
            fed.len() >= 2 && fed.iter().all(|&byte| byte == 0),
            "{fed:?}"
        );
        let seen = seen_by_the_device(true);
        assert!(
            seen.len() >= 2 && !seen.contains(&STOP_WATCHING[0]),
            "{seen:?}"
        );
    }

    #[test]
    fn what_is_no_watchdog_is_refused() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        for path in [
            file.path().to_str().expect("a path"),
            "/dev/null",
            "/nowhere",
        ] {
            let config = WatchdogConfig {
                device: Some(path.to_owned()),
                ..WatchdogConfig::default()
            };
            let refused = Watchdogs::start(&config, &Panicked::default()).expect_err(path);
            assert!(
                refused.contains(path) && refused.contains("expected a watchdog"),
                "{refused}"
            );
        }
    }
}
