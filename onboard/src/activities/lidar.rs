//! Lidar: reads scans from the Hokuyo and publishes them; reconnects when it was lost.

use std::path::PathBuf;
use std::sync::Arc;

use coordination::activity::{Activity, LifeCycle, LifeCycleEvent, LifeCycleState};
use drivers::hokuyo::{ConnectError, Hokuyo, Options, ReadError, Scan, SerialLine};

use crate::activities::per_minute::PerMinute;
use crate::activities::port::{Command, Port};
use crate::activities::robot_activity::RobotActivity;
use crate::realtime::clock::{Clock, MILLISECOND_NS};
use crate::realtime::guard;
use crate::realtime::log::{Complaints, LogSender};
use crate::realtime::wake::Wake;
use crate::symbols::faults::Fault;
use crate::symbols::values::{LidarStatus, MAX_STEPS, RangeScan};
use crate::symbols::wiring::LidarSymbols;

/// Longest wait for the device in one event loop: bounds how late a command of the supervisor is heard.
const WAIT_NS: u64 = 100 * MILLISECOND_NS;
/// Pause between two attempts to connect.
const RETRY_NS: u64 = 250 * MILLISECOND_NS;
/// A device whose scans are frozen is connected anew no sooner than this after it was connected.
const FROZEN_AFTER_NS: u64 = 1000 * MILLISECOND_NS;
/// So often in a minute may its scans freeze before people have to look at it: after each time it shows for a moment what is there.
const FREEZES_PER_MINUTE: usize = 2;
/// Broken scans are reported no more often than this; all are counted.
const NOTE_NS: u64 = 200 * MILLISECOND_NS;

/// What the lidar activity needs to know.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Serial device.
    pub device: PathBuf,
    /// How to connect.
    pub options: Options,
    /// A device that sends no scan for longer than this counts as lost.
    pub silent_ns: u64,
}

/// Opens the line to the lidar; called again after each loss.
pub type OpenLine = Box<dyn Fn() -> Result<Box<dyn SerialLine>, ConnectError> + Send>;

/// The activity.
pub struct Lidar {
    port: Port,
    settings: Settings,
    symbols: LidarSymbols,
    open_line: OpenLine,
    clock: Arc<dyn Clock>,
    wake: Wake,
    log: LogSender,
    device: Option<Hokuyo>,
    scan: Box<Scan>,
    value: Box<RangeScan>,
    status: LidarStatus,
    // Counters of devices that were connected before this one.
    before: LidarStatus,
    fresh: bool,
    heard_ns: u64,
    waited_ns: u64,
    retry_ns: u64,
    noted_ns: u64,
    complaints: Complaints,
    /// Why the last read brought no scan, until it is logged.
    trouble: Option<ReadError>,
    /// When the device was connected, and the last scan before that.
    connected: (u64, u64),
    /// The last scan that was frozen, says the motion tube.
    frozen_scan: u64,
    freezes: PerMinute,
}

impl Lidar {
    /// An activity in state *created*. Its lines have `clock`. `wake` wakes the thread that waits for scans.
    #[must_use]
    pub fn new(
        port: Port,
        settings: Settings,
        symbols: LidarSymbols,
        (open_line, clock): (OpenLine, Arc<dyn Clock>),
        wake: Wake,
        log: LogSender,
    ) -> Self {
        Self {
            wake,
            open_line,
            clock,
            port,
            settings,
            symbols,
            log,
            device: None,
            scan: Box::new(Scan::new()),
            value: Box::default(),
            status: LidarStatus::default(),
            before: LidarStatus::default(),
            fresh: false,
            heard_ns: 0,
            waited_ns: 0,
            retry_ns: 0,
            noted_ns: 0,
            complaints: Complaints::default(),
            trouble: None,
            connected: (0, 0),
            frozen_scan: 0,
            freezes: PerMinute::new(FREEZES_PER_MINUTE),
        }
    }

    /// Whether scans of this connection repeat each other. A firmware that does so may go on when its laser is switched off and on.
    fn is_frozen(&self, now_ns: u64) -> bool {
        let (since_ns, before) = self.connected;
        self.frozen_scan > before && now_ns > since_ns + FROZEN_AFTER_NS
    }

    fn connect(&mut self) {
        self.device = None;
        if let Some(trouble) = self.trouble.take() {
            self.log.warn(format!("lidar is lost: {trouble}"));
        }
        if self.frozen_scan > self.connected.1 {
            let scan = self.frozen_scan;
            self.connected.1 = scan;
            self.log
                .warn(format!("lidar is frozen: scan {scan} repeats those before"));
        }
        let Settings {
            device, options, ..
        } = &self.settings;
        let result = (self.open_line)()
            .and_then(|line| Hokuyo::connect_over(line, device, options))
            .map_err(|error| error.to_string())
            // Everything else was prepared for its scans.
            .and_then(|device| device.parameters().check_urg_04lx().map(|()| device));
        match result {
            Ok(device) => {
                let identity = device.identity();
                self.log.info(format!(
                    "lidar is connected: {} {}, serial {}",
                    identity.vendor, identity.product, identity.serial
                ));
                self.device = Some(device);
                self.before = self.status;
                self.status.connections += 1;
                self.heard_ns = self.clock.now_ns();
                self.connected = (self.heard_ns, self.value.sequence);
                self.complaints.forget();
                self.port.clear(Fault::LidarLost);
                self.port.step(LifeCycleEvent::Configured);
            }
            Err(complaint) => {
                self.complaints
                    .say(&self.log, "lidar cannot be connected", complaint);
                self.port.raise(Fault::LidarLost, 0.0);
                self.retry_ns = self.clock.now_ns() + RETRY_NS;
            }
        }
    }

    fn lose(&mut self, now_ns: u64) {
        self.port.raise(
            Fault::LidarLost,
            (now_ns - self.heard_ns) as f64 / MILLISECOND_NS as f64,
        );
        self.port.step(LifeCycleEvent::Fault);
        self.retry_ns = 0;
    }

    fn read(&mut self, now_ns: u64) {
        let Some(device) = &mut self.device else {
            return;
        };
        let result = device.read_scan(&mut self.scan, now_ns + WAIT_NS);
        let after_ns = self.clock.now_ns();
        self.waited_ns = after_ns - now_ns;
        // That nothing came says less than what came before.
        let trouble = result.err();
        self.trouble = trouble
            .filter(|error| *error != ReadError::Timeout)
            .or(self.trouble);
        match result {
            Ok(_) if self.is_frozen(after_ns) => {
                if !self.freezes.note(after_ns) {
                    self.port
                        .raise(Fault::LidarFrozen, self.freezes.most() as f64);
                }
                self.lose(after_ns);
            }
            Ok(_) => {
                self.fresh = true;
                self.heard_ns = after_ns;
                self.trouble = None;
            }
            Err(ReadError::Disconnected | ReadError::Untrusted { .. }) => self.lose(after_ns),
            Err(_) if after_ns - self.heard_ns > self.settings.silent_ns => self.lose(after_ns),
            Err(ReadError::Timeout) => {}
            Err(_) if after_ns >= self.noted_ns + NOTE_NS => {
                self.noted_ns = after_ns;
                self.port
                    .note(Fault::ScanBroken, self.status.dropped as f64);
            }
            Err(_) => {} // counted by the driver
        }
    }
}

impl Activity for Lidar {
    fn name(&self) -> &'static str {
        "lidar"
    }

    fn life_cycle(&self) -> &LifeCycle {
        self.port.life_cycle()
    }

    fn communicate_in(&mut self, _now_ns: u64) {
        self.frozen_scan = self.symbols.tube.read().value.frozen_scan;
    }

    fn coordinate(&mut self, _now_ns: u64) {
        while let Some(command) = self.port.next_command() {
            if command == Command::Reset {
                self.freezes.forget();
                self.port.clear(Fault::LidarFrozen);
            }
        }
    }

    fn configure(&mut self, now_ns: u64) {
        if now_ns >= self.retry_ns {
            self.connect();
        }
    }

    fn compute(&mut self, now_ns: u64) {
        self.read(now_ns);
    }

    fn rest(&mut self, now_ns: u64) {
        match self.port.state() {
            LifeCycleState::Ready | LifeCycleState::Paused => self.read(now_ns),
            // Nothing to wait on: the loop needs a pace of its own.
            state => {
                if state == LifeCycleState::Stopped {
                    guard::relaxed(|| self.device = None); // the real-time rules are over
                }
                self.clock.sleep_until(now_ns + RETRY_NS / 10);
                self.waited_ns = self.clock.now_ns() - now_ns;
            }
        }
    }

    fn communicate_out(&mut self, now_ns: u64) {
        if let Some(device) = &self.device {
            let counters = device.counters();
            self.status.scans = self.before.scans + counters.scans;
            let dropped =
                counters.checksum + counters.truncated + counters.device_errors + counters.garbage;
            self.status.dropped = self.before.dropped + dropped;
            self.status.untrusted = self.before.untrusted + counters.untrusted;
        }
        self.status.streaming = u64::from(self.port.running());
        self.symbols.status.write(now_ns, &self.status);
        if std::mem::take(&mut self.fresh) && self.port.running() {
            let count = self.scan.count.min(MAX_STEPS);
            self.value.sequence += 1;
            self.value.count = count as u64;
            self.value.ranges_mm[..count].copy_from_slice(&self.scan.ranges_mm[..count]);
            self.symbols.scan.write(self.scan.stamp_ns, &self.value);
            self.wake.wake(self.clock.now_ns());
        }
        self.port.publish(now_ns);
    }
}

impl RobotActivity for Lidar {
    fn waited_ns(&self) -> u64 {
        self.waited_ns
    }
}
