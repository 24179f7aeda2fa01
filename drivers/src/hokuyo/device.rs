//! The connected device.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use super::clock::{ClockBounds, DeviceClock, TOLERANCE_NS, Untrusted};
use super::connect::{Connected, connect};
use super::error::{ConnectError, ReadError};
use super::identity::{DeviceState, Parameters, SensorIdentity};
use super::options::{Options, ScanFormat};
use super::parser::{Event, Fault, StreamParser};
use super::scan::{LidarCounters, Received, Scan};
use super::serial_line::{Gone, SerialLine, Wait};
use super::tty::TtyLine;
use crate::clock::Clock;

/// Reads allowed after the deadline, for bytes that have already arrived: enough for one scan, bounded in endless
/// noise.
const MAX_LATE_READS: u32 = 4;
/// Limit for stopping the stream when the driver is dropped.
const FAREWELL: Duration = Duration::from_millis(20);
/// How often it looks meanwhile whether everything has left.
const GLANCE: Duration = Duration::from_millis(1);

const MS_NS: i64 = 1_000_000;

/// A connected device that streams.
#[derive(Debug)]
pub struct Hokuyo {
    line: Box<dyn SerialLine>,
    clock: Arc<dyn Clock>,
    gone: bool,
    untrusted: Option<ReadError>,
    identity: SensorIdentity,
    parameters: Parameters,
    state: DeviceState,
    format: ScanFormat,
    bounds: ClockBounds,
    to_first_beam_ns: u64,
    period_ms: u64,
    parser: StreamParser,
    device_clock: DeviceClock,
    counters: LidarCounters,
    chunk: Box<[u8; 2048]>,
    start: usize,
    end: usize,
    chunk_ns: u64,
    arrival_ns: u64,
}

impl Hokuyo {
    /// Connects to the device at `path` and starts its stream.
    ///
    /// Tries the bit rates until one is answered, ends a stream that runs already, switches to SCIP 2.0 and to the
    /// wanted bit rate, reads identity and parameters, compares the clocks, turns the laser on. Not real-time; it ends
    /// within a few milliseconds of [`Options::connect_timeout`].
    ///
    /// # Errors
    /// See [`ConnectError`]. Every error leaves the port closed; trying again is always possible.
    pub fn connect(path: &Path, options: &Options) -> Result<Self, ConnectError> {
        options.check()?;
        let line = TtyLine::open(path, options.bit_rate)?;
        Self::connect_over(Box::new(line), path, options)
    }

    /// The same over a line that is open, at any bit rate; `path` names it in errors.
    ///
    /// # Errors
    /// As for [`Hokuyo::connect`].
    pub fn connect_over(
        line: Box<dyn SerialLine>,
        path: &Path,
        options: &Options,
    ) -> Result<Self, ConnectError> {
        let Connected {
            line,
            command,
            format,
            identity,
            parameters,
            state,
            clock,
        } = connect(line, path, options)?;
        let measuring = parameters.step_time(format.last_step);
        let period = parameters.turn() * u32::from(format.skip + 1);
        Ok(Self {
            clock: line.clock(),
            line,
            gone: false,
            untrusted: None,
            identity,
            state,
            to_first_beam_ns: parameters.step_time(format.first_step).as_nanos() as u64,
            period_ms: (period.as_millis() as u64).max(1),
            parameters,
            parser: StreamParser::new(&command, &format),
            format,
            bounds: clock,
            device_clock: DeviceClock::new(clock, measuring.as_nanos() as u64),
            counters: LidarCounters::default(),
            chunk: Box::new([0; 2048]),
            start: 0,
            end: 0,
            chunk_ns: 0,
            arrival_ns: 0,
        })
    }

    /// Reads until a scan is complete or the deadline (of the line's clock) passes. Real-time.
    ///
    /// A scan that is half there at the deadline is continued by the next call. Scans that waited because nobody
    /// read are delivered one by one, with the stamps of their time. A deadline that has passed does not hide a scan
    /// that has arrived.
    ///
    /// # Errors
    /// Each dropped scan is reported once; the next call goes on behind it. `scan` changes only on success. After
    /// [`ReadError::Disconnected`] and [`ReadError::Untrusted`] only a new connection helps.
    pub fn read_scan(&mut self, scan: &mut Scan, deadline_ns: u64) -> Result<Received, ReadError> {
        let mut late_reads = 0;
        if let Some(error) = self.untrusted {
            return Err(error);
        }
        loop {
            while self.start < self.end {
                let byte = self.chunk[self.start];
                self.start += 1;
                if let Some(event) = self.parser.push(byte)
                    && let Some(result) = self.handle(event, scan)
                {
                    return result;
                }
            }
            if self.gone {
                return Err(ReadError::Disconnected);
            }
            if late_reads == MAX_LATE_READS {
                return Err(ReadError::Timeout);
            }
            match self.fill(deadline_ns) {
                Ok(Wait::Ready) => late_reads += u32::from(self.chunk_ns >= deadline_ns),
                Ok(Wait::TimedOut) => return Err(ReadError::Timeout),
                Err(Gone) => {
                    self.gone = true;
                    return Err(ReadError::Disconnected);
                }
            }
        }
    }

    fn fill(&mut self, deadline_ns: u64) -> Result<Wait, Gone> {
        if self.line.wait(deadline_ns)? == Wait::TimedOut {
            return Ok(Wait::TimedOut);
        }
        self.start = 0;
        self.end = 0;
        self.end = self.line.read(&mut self.chunk[..])?;
        self.chunk_ns = self.clock.now_ns();
        self.counters.bytes += self.end as u64;
        Ok(Wait::Ready)
    }

    fn handle(&mut self, event: Event, scan: &mut Scan) -> Option<Result<Received, ReadError>> {
        match event {
            Event::Begun {
                resynchronised,
                dropped,
            } => {
                self.arrival_ns = self.chunk_ns;
                self.counters.resynchronisations += u64::from(resynchronised);
                dropped.map(|fault| Err(self.count(fault)))
            }
            Event::Dropped(fault) => Some(Err(self.count(fault))),
            Event::Complete { device_ms } => Some(self.deliver(device_ms, scan)),
        }
    }

    fn count(&mut self, fault: Fault) -> ReadError {
        let (counter, error) = match fault {
            Fault::Checksum => (&mut self.counters.checksum, ReadError::Checksum),
            Fault::Truncated => (&mut self.counters.truncated, ReadError::Truncated),
            Fault::Garbage => (&mut self.counters.garbage, ReadError::Garbage),
            Fault::Device(status) => (
                &mut self.counters.device_errors,
                ReadError::DeviceError(status),
            ),
        };
        *counter += 1;
        error
    }

    fn deliver(&mut self, device_ms: u32, scan: &mut Scan) -> Result<Received, ReadError> {
        let mapped = self.device_clock.map(device_ms, self.arrival_ns);
        let mapped = mapped.map_err(|untrusted| self.distrust(untrusted))?;
        let ranges_mm = self.parser.ranges_mm();
        scan.ranges_mm[..ranges_mm.len()].copy_from_slice(ranges_mm);
        scan.count = ranges_mm.len();
        scan.first_step = self.format.first_step;
        scan.cluster = self.format.cluster.into();
        scan.stamp_ns = mapped.start_ns + self.to_first_beam_ns;
        scan.device_ms = mapped.device_ms;
        scan.sequence = self.counters.scans;
        let turns = (mapped.elapsed_ms + self.period_ms / 2) / self.period_ms;
        let missed = u32::try_from(turns.saturating_sub(1)).unwrap_or(u32::MAX);
        self.counters.scans += 1;
        self.counters.missed += u64::from(missed);
        self.counters.clock_jumps += u64::from(mapped.jumped);
        Ok(Received {
            arrival_ns: self.arrival_ns,
            complete_ns: self.chunk_ns,
            missed,
        })
    }

    fn distrust(&mut self, Untrusted { off_ns }: Untrusted) -> ReadError {
        let error = ReadError::Untrusted {
            found_ms: off_ns / MS_NS,
            expected_ms: TOLERANCE_NS / MS_NS,
        };
        self.counters.untrusted += u64::from(self.untrusted.is_none());
        *self.untrusted.insert(error)
    }

    /// Vendor, product, firmware and serial number.
    #[must_use]
    pub fn identity(&self) -> &SensorIdentity {
        &self.identity
    }

    /// What it measures: range, steps, speed.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The device's state when the connection was made.
    #[must_use]
    pub fn state(&self) -> &DeviceState {
        &self.state
    }

    /// The shape of its scans.
    #[must_use]
    pub fn format(&self) -> &ScanFormat {
        &self.format
    }

    /// The angle of beam 0 and from one beam to the next, in the sensor's frame (0 to the front, positive left).
    ///
    /// A clustered reading stands for the middle of its steps.
    #[must_use]
    pub fn beam_angles_rad(&self) -> (f64, f64) {
        let step_rad = self.parameters.step_rad();
        let middle = f64::from(self.format.cluster - 1) / 2.0 * step_rad;
        let first = self.parameters.step_angle_rad(self.format.first_step) + middle;
        (first, step_rad * f64::from(self.format.cluster))
    }

    /// The time from one beam to the next.
    #[must_use]
    pub fn beam_period(&self) -> Duration {
        self.parameters.turn() * u32::from(self.format.cluster) / u32::from(self.parameters.ares)
    }

    /// The time from one scan to the next.
    #[must_use]
    pub fn scan_period(&self) -> Duration {
        self.parameters.turn() * u32::from(self.format.skip + 1)
    }

    /// How far stamps may be off just after connecting.
    #[must_use]
    pub fn stamp_uncertainty(&self) -> Option<Duration> {
        self.bounds
            .offset_ns()
            .map(|(_, uncertainty_ns)| Duration::from_nanos(uncertainty_ns))
    }

    /// What has happened since the connection was made.
    #[must_use]
    pub fn counters(&self) -> LidarCounters {
        self.counters
    }
}

impl Drop for Hokuyo {
    /// Asks the device to stop its stream and laser, without waiting for the reply.
    fn drop(&mut self) {
        if self.gone {
            return;
        }
        let mut now_ns = self.clock.now_ns();
        let deadline_ns = now_ns + FAREWELL.as_nanos() as u64;
        if self.line.write(b"QT\n", deadline_ns) == Ok(true) {
            while self.line.unsent_bytes() > 0 && now_ns < deadline_ns {
                self.clock.sleep_until(now_ns + GLANCE.as_nanos() as u64);
                now_ns = self.clock.now_ns();
            }
        }
    }
}
