//! From a serial device in any state to a stream of scans.
//!
//! The device may run at any bit rate, in SCIP 1.1 or 2.0, stream already, or be left in clock-adjust mode by a host
//! that crashed. One deadline bounds all of it.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use super::clock::ClockBounds;
use super::codec::{self, STREAM_COMMAND_BYTES, Status};
use super::conversation::{Answer, Conversation, Reply, Trouble};
use super::error::ConnectError;
use super::identity::{DeviceState, Fields, Parameters, SensorIdentity};
use super::options::{LIKELY_BIT_RATES, Options, ScanFormat};
use super::serial_line::SerialLine;
use crate::clock::Clock;

/// How long to wait for a first answer at a bit rate. Doubles with every pass over the bit rates, because answers come
/// late on a busy host.
const ANSWER: Duration = Duration::from_millis(100);
/// As [`ANSWER`], for a device that streams: up to two scans precede the answer, each of about a second at 19200 bit/s.
const ANSWER_BEHIND_SCANS: Duration = Duration::from_millis(2500);
/// How long a device takes to change its bit rate after accepting the command.
const RATE_CHANGE: Duration = Duration::from_millis(20);
/// Attempts at a command whose reply is garbled or missing.
const ATTEMPTS: usize = 3;
/// Readings of the device's clock.
const CLOCK_READINGS: usize = 10;
/// The offset between the clocks must be known to this. At 19200 bit/s a reading takes 10 ms, which leaves 5 ms to either side.
const MOST_UNCERTAIN_NS: u64 = 10_000_000;

/// A connection whose stream has been accepted.
pub struct Connected {
    pub line: Box<dyn SerialLine>,
    pub command: [u8; STREAM_COMMAND_BYTES],
    pub format: ScanFormat,
    pub identity: SensorIdentity,
    pub parameters: Parameters,
    pub state: DeviceState,
    pub clock: ClockBounds,
}

/// Connects; see [`super::Hokuyo::connect_over`].
pub fn connect(
    line: Box<dyn SerialLine>,
    path: &Path,
    options: &Options,
) -> Result<Connected, ConnectError> {
    options.check()?;
    let clock = line.clock();
    let deadline_ns = clock.now_ns() + options.connect_timeout.as_nanos() as u64;
    let mut session = Session {
        conversation: Conversation::new(line),
        clock,
        path: path.into(),
        deadline_ns,
        reply_timeout: options.reply_timeout,
        bit_rate: options.bit_rate,
        answer: ANSWER,
    };
    session.find_device(options.bit_rate)?;
    session.change_rate(options.bit_rate)?;
    let parameters = session.fields("PP")?.parameters()?;
    // What another device than the one that is supported would need makes no sense to ask for.
    let other = |error| match parameters.check_urg_04lx() {
        Ok(()) => error,
        Err(found) => ConnectError::OtherDevice(found),
    };
    let format = options.format(&parameters).map_err(other)?;
    let identity = session.fields("VV")?.identity()?;
    let state = session.fields("II")?.state();
    if !state.is_well() {
        return Err(ConnectError::Unwell {
            found: state.status,
        });
    }
    // Another host may have slowed the motor down. A model that cannot change its speed may refuse this.
    session.command(b"CR00")?;
    let clock = session.read_clock()?;
    session.laser_on()?;
    let command = session.start_stream(&format)?;
    let line = session.conversation.into_line();
    Ok(Connected {
        line,
        command,
        format,
        identity,
        parameters,
        state,
        clock,
    })
}

struct Session {
    conversation: Conversation,
    clock: Arc<dyn Clock>,
    path: PathBuf,
    deadline_ns: u64,
    reply_timeout: Duration,
    bit_rate: u32,
    /// [`ANSWER`], doubled with every pass.
    answer: Duration,
}

impl Session {
    /// Tries the bit rates until the device answers; its stream, if any, is ended then.
    fn find_device(&mut self, wanted: u32) -> Result<(), ConnectError> {
        let others = LIKELY_BIT_RATES.into_iter().filter(|rate| *rate != wanted);
        let rates: Vec<u32> = std::iter::once(wanted).chain(others).collect();
        let mut tried = Vec::new();
        while !self.is_late() {
            let mut possible = false;
            for bit_rate in &rates {
                if self.is_late() || !self.reset(*bit_rate)? {
                    continue;
                }
                possible = true;
                if !tried.contains(bit_rate) {
                    tried.push(*bit_rate);
                }
                if self.wake()? {
                    return Ok(());
                }
            }
            if !possible {
                break;
            }
            self.answer *= 2;
        }
        Err(ConnectError::NoAnswer {
            path: self.path.clone(),
            tried,
            heard_bytes: self.conversation.heard_bytes(),
        })
    }

    /// Brings the device at this bit rate, if there is one, to SCIP 2.0, idle. `false` when nothing answers.
    fn wake(&mut self) -> Result<bool, ConnectError> {
        // The first command may join noise that the device heard at other bit rates; its line end flushes that.
        match self.ask(b"QT")? {
            Some(Answer::Status(Status::OK)) => return Ok(true),
            // In clock-adjust mode (`TM0`) the device accepts only `TM2`, which leaves it.
            Some(Answer::Status(_)) => {
                self.ask(b"TM2")?;
            }
            None if self.conversation.hears_rubbish() => return Ok(false),
            Some(Answer::Other) | None => {
                if self.ask(b"SCIP2.0")?.is_none() {
                    return Ok(false);
                }
            }
        }
        for _ in 0..ATTEMPTS {
            if self.ask(b"QT")? == Some(Answer::Status(Status::OK)) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Sends a command and returns the answer, or `None` when nothing answers in time.
    fn ask(&mut self, command: &[u8]) -> Result<Option<Answer>, ConnectError> {
        let started_ns = self.clock.now_ns();
        let send = self.conversation.send(command, self.until(self.answer));
        if self.heard(send)?.is_none() {
            return Ok(None);
        }
        let answer = self.conversation.answer(command, self.until(self.answer));
        if let Some(answer) = self.heard(answer)? {
            return Ok(Some(answer));
        }
        if !self.conversation.hears_stream() {
            return Ok(None);
        }
        let behind_ns = started_ns + ANSWER_BEHIND_SCANS.as_nanos() as u64;
        let answer = self
            .conversation
            .answer(command, behind_ns.min(self.deadline_ns));
        self.heard(answer)
    }

    /// Switches the device and the port to `wanted` and checks that the device answers there.
    fn change_rate(&mut self, wanted: u32) -> Result<(), ConnectError> {
        if self.bit_rate == wanted {
            return Ok(());
        }
        let command = codec::bit_rate_command(wanted).ok_or_else(|| ConnectError::Option {
            option: "bit_rate",
            expected: "at most six digits".into(),
            found: wanted.to_string(),
        })?;
        match self.command(&command)?.status {
            Status::OK | Status::SAME_BIT_RATE => {}
            status => return Err(refused(&command, status, "it does not have this bit rate")),
        }
        let changed_ns = self.clock.now_ns() + RATE_CHANGE.as_nanos() as u64;
        self.clock.sleep_until(changed_ns);
        if !self.reset(wanted)? {
            return Err(ConnectError::Option {
                option: "bit_rate",
                expected: "a rate of the serial port".into(),
                found: wanted.to_string(),
            });
        }
        match self.command(b"QT")?.status {
            Status::OK => Ok(()),
            status => Err(refused(b"QT", status, "it should always stop")),
        }
    }

    /// The fields of a reply whose checksums all hold.
    fn fields(&mut self, command: &'static str) -> Result<Fields, ConnectError> {
        for _ in 0..ATTEMPTS {
            let reply = self.command(command.as_bytes())?;
            if reply.status != Status::OK {
                return Err(refused(
                    command.as_bytes(),
                    reply.status,
                    "it should always answer this",
                ));
            }
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            let fields: Option<Vec<_>> = reply
                .lines
                .iter()
                .map(|line| codec::verify_field(line).map(|(key, value)| (text(key), text(value))))
                .collect();
            if let Some(fields) = fields {
                return Ok(Fields { command, fields });
            }
        }
        Err(self.no_reply(command.as_bytes()))
    }

    /// Reads the device's clock several times. One that cannot be read, or only with replies that take too long, is an error: how old
    /// scans are would not be known, and a delay would pass for the time of measuring.
    fn read_clock(&mut self) -> Result<ClockBounds, ConnectError> {
        let mut bounds = ClockBounds::default();
        match self.command(b"TM0")?.status {
            // Also after a reply that was lost.
            Status::OK | Status::ADJUSTS_ALREADY => {}
            status => {
                return Err(refused(
                    b"TM0",
                    status,
                    "how old its scans are is not known",
                ));
            }
        }
        for _ in 0..CLOCK_READINGS {
            let before_ns = self.clock.now_ns();
            let reply = self.command(b"TM1")?;
            let stamp = reply
                .lines
                .first()
                .and_then(|line| codec::verify(line))
                .and_then(codec::decode);
            if let (Status::OK, Some(device_ms)) = (reply.status, stamp) {
                bounds.add(device_ms, before_ns, reply.arrival_ns);
            }
        }
        self.command(b"TM2")?;
        match bounds.offset_ns() {
            None => Err(ConnectError::ClockUnreadable {
                readings: CLOCK_READINGS,
            }),
            Some((_, found_ns)) if found_ns > MOST_UNCERTAIN_NS => {
                Err(ConnectError::ClockUncertain {
                    found_ms: found_ns / 1_000_000,
                    expected_ms: MOST_UNCERTAIN_NS / 1_000_000,
                })
            }
            Some(_) => Ok(bounds),
        }
    }

    fn laser_on(&mut self) -> Result<(), ConnectError> {
        match self.command(b"BM")?.status {
            Status::OK | Status::LASER_ALREADY_ON => Ok(()),
            status => Err(refused(b"BM", status, "the laser does not start")),
        }
    }

    fn start_stream(
        &mut self,
        format: &ScanFormat,
    ) -> Result<[u8; STREAM_COMMAND_BYTES], ConnectError> {
        let ScanFormat {
            first_step,
            last_step,
            cluster,
            skip,
            encoding,
        } = *format;
        let command = codec::stream_command(encoding, first_step, last_step, cluster, skip);
        let command = command.ok_or_else(|| ConnectError::Option {
            option: "last_step",
            expected: "at most four digits".into(),
            found: last_step.to_string(),
        })?;
        match self.command(&command)?.status {
            // `SCAN`: the reply was lost, but the stream runs.
            Status::OK | Status::SCAN => Ok(command),
            status => Err(refused(&command, status, stream_status(status))),
        }
    }

    /// Sends a command, again if need be, and reads its reply.
    fn command(&mut self, command: &[u8]) -> Result<Reply, ConnectError> {
        for _ in 0..ATTEMPTS {
            let reply = self
                .conversation
                .command(command, self.until(self.reply_timeout));
            if let Some(reply) = self.heard(reply)? {
                return Ok(reply);
            }
            if self.is_late() {
                return Err(ConnectError::OutOfTime {
                    during: step(command),
                });
            }
        }
        Err(self.no_reply(command))
    }

    fn heard<T>(&self, result: Result<T, Trouble>) -> Result<Option<T>, ConnectError> {
        match result {
            Ok(value) => Ok(Some(value)),
            Err(Trouble::Silent) => Ok(None),
            Err(Trouble::Gone) => Err(self.disconnected()),
        }
    }

    fn reset(&mut self, bit_rate: u32) -> Result<bool, ConnectError> {
        self.bit_rate = bit_rate;
        self.conversation
            .reset(bit_rate)
            .map_err(|_| self.disconnected())
    }

    fn until(&self, time: Duration) -> u64 {
        (self.clock.now_ns() + time.as_nanos() as u64).min(self.deadline_ns)
    }

    fn is_late(&self) -> bool {
        self.clock.now_ns() >= self.deadline_ns
    }

    fn disconnected(&self) -> ConnectError {
        ConnectError::Disconnected {
            path: self.path.clone(),
        }
    }

    fn no_reply(&self, command: &[u8]) -> ConnectError {
        ConnectError::NoReply {
            command: command.escape_ascii().to_string(),
            bit_rate: self.bit_rate,
        }
    }
}

fn refused(command: &[u8], status: Status, meaning: &'static str) -> ConnectError {
    ConnectError::Refused {
        command: command.escape_ascii().to_string(),
        status,
        meaning,
    }
}

fn step(command: &[u8]) -> &'static str {
    match command {
        [b'S', b'S', ..] => "changing the bit rate",
        [b'M', ..] => "starting the stream",
        [b'T', ..] => "reading the device's clock",
        b"BM" => "starting the laser",
        _ => "asking the device what it is",
    }
}

fn stream_status(status: Status) -> &'static str {
    match &status.0 {
        b"04" => "it does not have the last step",
        b"05" => "the last step is below the first",
        b"10" => "the laser is off",
        [b'2'..=b'4', _] => "it stopped to verify an error",
        [b'5'..=b'9', _] => "hardware trouble",
        _ => "a parameter of the command is out of range",
    }
}
