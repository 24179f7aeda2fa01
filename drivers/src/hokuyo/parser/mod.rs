//! Finds scans in the bytes of a stream (SCIP 2.0, commands `MD` and `MS`).
//!
//! Real-time: after construction, no allocation, no system call. Any byte sequence is accepted: a scan with a broken
//! line is dropped and reported once, and the search goes on at the next echo of the stream command, even when noise
//! precedes it on the same line.

use crate::hokuyo::codec::{self, LINE_DATA_BYTES, STREAM_COMMAND_BYTES, Status};
use crate::hokuyo::line::LineBuffer;
use crate::hokuyo::options::ScanFormat;
use crate::hokuyo::scan::MAX_BEAMS;

/// Digits of the remaining scans at the end of an echo; they may differ from those in the command.
const REMAINING_DIGITS: usize = 2;

/// Why a scan was dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// A checksum is wrong, or a character is not of the encoding.
    Checksum,
    /// Bytes are missing.
    Truncated,
    /// Bytes that belong to no scan.
    Garbage,
    /// An error status in place of the scan.
    Device(Status),
}

/// What a byte has completed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// The echo that precedes a scan; its arrival time is the scan's.
    Begun {
        /// The echo was found after dropped bytes.
        resynchronised: bool,
        /// What was dropped with it.
        dropped: Option<Fault>,
    },
    /// A whole scan, in [`StreamParser::ranges_mm`].
    Complete {
        /// The device's time stamp, 24 bits.
        device_ms: u32,
    },
    /// A scan was dropped.
    Dropped(Fault),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Expect {
    /// The echo that precedes a scan. Anything else is a fault.
    Echo,
    /// The echo that precedes a scan, after a fault that has been reported.
    Search,
    Status,
    /// The empty line after the status that accepts the command.
    AcceptedEnd,
    Stamp,
    Data,
    /// The empty line after the data.
    End,
}

/// Parses the stream of one scan format.
#[derive(Debug)]
pub struct StreamParser {
    line: LineBuffer,
    echo: [u8; STREAM_COMMAND_BYTES - REMAINING_DIGITS],
    characters: usize,
    beams: usize,
    data_bytes: usize,
    expect: Expect,
    lost: bool,
    device_ms: u32,
    /// Data characters still to come.
    missing: usize,
    /// A value cut by the end of a line.
    partial: u32,
    partial_characters: usize,
    count: usize,
    ranges_mm: [u16; MAX_BEAMS],
}

impl StreamParser {
    /// For the stream that `command` starts. Beams beyond [`MAX_BEAMS`] would be left out;
    /// [`crate::hokuyo::Options::format`] refuses them.
    pub fn new(command: &[u8; STREAM_COMMAND_BYTES], format: &ScanFormat) -> Self {
        let mut echo = [0; STREAM_COMMAND_BYTES - REMAINING_DIGITS];
        echo.copy_from_slice(&command[..STREAM_COMMAND_BYTES - REMAINING_DIGITS]);
        Self {
            line: LineBuffer::new(),
            echo,
            characters: format.encoding.characters(),
            beams: format.beams().min(MAX_BEAMS),
            data_bytes: format.data_bytes(),
            expect: Expect::Search,
            lost: false,
            device_ms: 0,
            missing: 0,
            partial: 0,
            partial_characters: 0,
            count: 0,
            ranges_mm: [0; MAX_BEAMS],
        }
    }

    /// The readings of the scan that was completed last, until the next one begins.
    pub fn ranges_mm(&self) -> &[u16] {
        &self.ranges_mm[..self.count]
    }

    /// Takes one byte.
    pub fn push(&mut self, byte: u8) -> Option<Event> {
        // The line is copied out because handling it changes the parser; it is short.
        let line = self.line.push(byte)?;
        let mut copy = [0; 128];
        let length = line.len().min(copy.len());
        copy[..length].copy_from_slice(&line[..length]);
        self.line(&copy[..length])
    }

    fn line(&mut self, line: &[u8]) -> Option<Event> {
        // A data line that is whole may end like an echo by chance; it is data.
        let whole_data = self.expect == Expect::Data
            && line.len() == self.missing.min(LINE_DATA_BYTES) + 1
            && codec::verify(line).is_some();
        if !whole_data && self.ends_with_echo(line) {
            return Some(self.begin(line));
        }
        match self.expect {
            Expect::Search => None,
            Expect::Echo if line.is_empty() => None,
            Expect::Echo => self.drop_scan(Fault::Garbage),
            Expect::Status => self.status(line),
            Expect::AcceptedEnd if line.is_empty() => {
                self.expect = Expect::Echo;
                None
            }
            Expect::AcceptedEnd => self.drop_scan(Fault::Garbage),
            Expect::Stamp => self.stamp(line),
            Expect::Data => self.data(line),
            Expect::End if line.is_empty() => {
                self.expect = Expect::Echo;
                Some(Event::Complete {
                    device_ms: self.device_ms,
                })
            }
            Expect::End => self.drop_scan(Fault::Garbage),
        }
    }

    fn ends_with_echo(&self, line: &[u8]) -> bool {
        let Some(start) = line.len().checked_sub(STREAM_COMMAND_BYTES) else {
            return false;
        };
        let (command, remaining) = line[start..].split_at(self.echo.len());
        command == self.echo && remaining.iter().all(u8::is_ascii_digit)
    }

    fn begin(&mut self, line: &[u8]) -> Event {
        let prefixed = line.len() > STREAM_COMMAND_BYTES;
        let dropped = match self.expect {
            Expect::Search => None,
            Expect::Echo if prefixed => Some(Fault::Garbage),
            Expect::Echo | Expect::AcceptedEnd => None,
            Expect::Status | Expect::Stamp | Expect::Data | Expect::End => Some(Fault::Truncated),
        };
        let resynchronised = self.lost || dropped.is_some();
        self.lost = false;
        self.expect = Expect::Status;
        Event::Begun {
            resynchronised,
            dropped,
        }
    }

    fn status(&mut self, line: &[u8]) -> Option<Event> {
        match Status::parse(line) {
            Some(Status::SCAN) => {
                self.expect = Expect::Stamp;
                None
            }
            Some(Status::OK) => {
                self.expect = Expect::AcceptedEnd;
                None
            }
            Some(status) => {
                self.expect = Expect::Search;
                Some(Event::Dropped(Fault::Device(status)))
            }
            None => self.drop_line(line, 3),
        }
    }

    fn stamp(&mut self, line: &[u8]) -> Option<Event> {
        let stamp = (line.len() == 5)
            .then(|| codec::verify(line).and_then(codec::decode))
            .flatten();
        let Some(device_ms) = stamp else {
            return self.drop_line(line, 5);
        };
        self.device_ms = device_ms;
        self.missing = self.data_bytes;
        self.partial = 0;
        self.partial_characters = 0;
        self.count = 0;
        self.expect = Expect::Data;
        None
    }

    fn data(&mut self, line: &[u8]) -> Option<Event> {
        let expected = self.missing.min(LINE_DATA_BYTES);
        let payload = (line.len() == expected + 1)
            .then(|| codec::verify(line))
            .flatten();
        let Some(payload) = payload else {
            return self.drop_line(line, expected + 1);
        };
        for character in payload {
            let Some(bits) = codec::decode_character(*character) else {
                return self.drop_scan(Fault::Checksum);
            };
            self.partial = self.partial << 6 | u32::from(bits);
            self.partial_characters += 1;
            if self.partial_characters == self.characters {
                if self.count < self.beams {
                    self.ranges_mm[self.count] = u16::try_from(self.partial).unwrap_or(u16::MAX);
                    self.count += 1;
                }
                self.partial = 0;
                self.partial_characters = 0;
            }
        }
        self.missing -= expected;
        if self.missing == 0 {
            self.expect = Expect::End;
        }
        None
    }

    fn drop_line(&mut self, line: &[u8], expected_bytes: usize) -> Option<Event> {
        self.drop_scan(match line.len() {
            length if length == expected_bytes => Fault::Checksum,
            length if length < expected_bytes => Fault::Truncated,
            _ => Fault::Garbage,
        })
    }

    fn drop_scan(&mut self, fault: Fault) -> Option<Event> {
        self.expect = Expect::Search;
        self.lost = true;
        Some(Event::Dropped(fault))
    }
}

#[cfg(test)]
mod tests;
