//! Commands and replies, before streaming. Not real-time; every wait has a deadline.

use std::sync::Arc;

use super::codec::{self, Status};
use super::line::LineBuffer;
use super::serial_line::{Gone, SerialLine, Wait};
use crate::clock::Clock;

/// Most lines kept of one reply; no SCIP reply has more.
const MAX_REPLY_LINES: usize = 16;
/// From this many bytes outside printable ASCII on, the bit rate is wrong; a change of bit rate leaves fewer behind.
const ENOUGH_RUBBISH: usize = 4;

/// Why there is no reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    /// None came in time.
    Silent,
    /// The line is gone.
    Gone,
}

impl From<Gone> for Trouble {
    fn from(_: Gone) -> Self {
        Self::Gone
    }
}

/// The line after the echo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// A status with a valid checksum.
    Status(Status),
    /// Something else: a device in SCIP 1.1 gives its status without checksum; or it was garbled.
    Other,
}

/// A whole reply.
#[derive(Debug)]
pub struct Reply {
    /// Its status.
    pub status: Status,
    /// The lines between the status and the empty line.
    pub lines: Vec<Vec<u8>>,
    /// When its last byte was read.
    pub arrival_ns: u64,
}

/// The host's side of the conversation.
#[derive(Debug)]
pub struct Conversation {
    serial: Box<dyn SerialLine>,
    clock: Arc<dyn Clock>,
    line: LineBuffer,
    chunk: [u8; 256],
    start: usize,
    end: usize,
    heard_bytes: u64,
    /// A valid data line of a stream came since the last reset.
    hears_stream: bool,
    /// Bytes since the last reset that no SCIP device sends.
    rubbish_bytes: usize,
}

impl Conversation {
    /// Over an open line.
    pub fn new(serial: Box<dyn SerialLine>) -> Self {
        Self {
            clock: serial.clock(),
            serial,
            line: LineBuffer::new(),
            chunk: [0; 256],
            start: 0,
            end: 0,
            heard_bytes: 0,
            hears_stream: false,
            rubbish_bytes: 0,
        }
    }

    /// The line, with the bytes not yet read from it.
    pub fn into_line(self) -> Box<dyn SerialLine> {
        self.serial
    }

    /// Bytes received since the line was opened.
    pub fn heard_bytes(&self) -> u64 {
        self.heard_bytes
    }

    /// Whether valid lines of data came since the last reset: the device streams, and the bit rate is right.
    pub fn hears_stream(&self) -> bool {
        self.hears_stream
    }

    /// Whether what came since the last reset is not SCIP: a device talks, at another bit rate.
    pub fn hears_rubbish(&self) -> bool {
        self.rubbish_bytes >= ENOUGH_RUBBISH && !self.hears_stream
    }

    /// Sets the bit rate and forgets what came at the old one. False when the line cannot do it.
    pub fn reset(&mut self, bit_rate: u32) -> Result<bool, Gone> {
        let done = self.serial.set_bit_rate(bit_rate).is_ok();
        if !done {
            // If the line is gone, the next read reports it.
            self.serial.read(&mut self.chunk)?;
        }
        self.serial.clear();
        self.line.clear();
        self.start = self.end;
        self.hears_stream = false;
        self.rubbish_bytes = 0;
        Ok(done)
    }

    /// Sends a command with its line end.
    pub fn send(&mut self, command: &[u8], deadline_ns: u64) -> Result<(), Trouble> {
        let mut line = command.to_vec();
        line.push(b'\n');
        if self.serial.write(&line, deadline_ns)? {
            Ok(())
        } else {
            Err(Trouble::Silent)
        }
    }

    /// Waits for the echo of `command`, passing over everything before it, and gives the line after it.
    pub fn answer(&mut self, command: &[u8], deadline_ns: u64) -> Result<Answer, Trouble> {
        // The rest of a broken line may precede the echo on its line.
        while !self.next_line(deadline_ns)?.ends_with(command) {}
        let status = Status::parse(&self.next_line(deadline_ns)?);
        Ok(status.map_or(Answer::Other, Answer::Status))
    }

    /// Sends `command` and reads the whole reply.
    pub fn command(&mut self, command: &[u8], deadline_ns: u64) -> Result<Reply, Trouble> {
        self.send(command, deadline_ns)?;
        let status = loop {
            if let Answer::Status(status) = self.answer(command, deadline_ns)? {
                break status;
            }
        };
        let mut lines = Vec::new();
        loop {
            let line = self.next_line(deadline_ns)?;
            if line.is_empty() || lines.len() == MAX_REPLY_LINES {
                return Ok(Reply {
                    status,
                    lines,
                    arrival_ns: self.clock.now_ns(),
                });
            }
            lines.push(line);
        }
    }

    fn next_line(&mut self, deadline_ns: u64) -> Result<Vec<u8>, Trouble> {
        loop {
            while self.start < self.end {
                let byte = self.chunk[self.start];
                self.start += 1;
                if let Some(line) = self.line.push(byte) {
                    let line = line.to_vec();
                    self.hears_stream |= is_stream_line(&line);
                    return Ok(line);
                }
            }
            if self.clock.now_ns() >= deadline_ns
                || self.serial.wait(deadline_ns)? == Wait::TimedOut
            {
                return Err(Trouble::Silent);
            }
            self.start = 0;
            self.end = 0;
            self.end = self.serial.read(&mut self.chunk)?;
            self.heard_bytes += self.end as u64;
            let bytes = self.chunk[..self.end].iter();
            self.rubbish_bytes += bytes
                .filter(|byte| !matches!(byte, b' '..=b'~' | b'\n' | b'\r'))
                .count();
        }
    }
}

/// A valid data line of more than 16 characters. At a wrong bit rate no line of that length has only SCIP characters.
fn is_stream_line(line: &[u8]) -> bool {
    line.len() > 16
        && codec::verify(line).is_some_and(|payload| {
            payload
                .iter()
                .all(|c| codec::decode_character(*c).is_some())
        })
}
