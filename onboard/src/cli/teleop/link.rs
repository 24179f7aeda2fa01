//! The connection to a robot that is in somebody's hands.

use std::io::{BufReader, ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;

use description::geometry::Twist2;
use serde::Deserialize;

use crate::composition::failure::Failure;
use crate::process::ctl::{self, Teleop};
use crate::process::runtime::Runtime;
use crate::process::teleop::{Over, Status};

/// What the robot says.
#[derive(Deserialize)]
#[serde(untagged)]
enum Said {
    Over(Over),
    Status(Box<Status>),
}

/// The connection.
pub(super) struct Link {
    stream: BufReader<UnixStream>,
    read: Vec<u8>,
}

impl AsFd for Link {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.stream.get_ref().as_fd()
    }
}

impl Link {
    /// Takes a robot into our hands. It is told first that nothing is wanted.
    pub(super) fn begin(runtime: &Runtime, robot: &str, teleop: Teleop) -> Result<Self, Failure> {
        let stream = ctl::begin(runtime, robot, teleop)?;
        stream
            .get_ref()
            .set_nonblocking(true)
            .map_err(Failure::failed)?;
        let mut link = Self {
            stream,
            read: Vec::new(),
        };
        link.say(Twist2::default())?;
        Ok(link)
    }

    /// Says what is wanted.
    pub(super) fn say(&mut self, wish: Twist2) -> Result<(), Failure> {
        self.say_line(&format!("{} {}", wish.v_m_s, wish.omega_rad_s))
    }

    /// The same, as a line.
    pub(super) fn say_line(&mut self, line: &str) -> Result<(), Failure> {
        match self
            .stream
            .get_mut()
            .write_all(format!("{line}\n").as_bytes())
        {
            Ok(()) => Ok(()),
            // The robot's side hangs; it stops for want of wishes.
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(()),
            // Why, it may have said before it closed.
            Err(_) => self.hear().and(Ok(())),
        }
    }

    /// The newest thing that the robot has said since the last call.
    pub(super) fn hear(&mut self) -> Result<Option<Status>, Failure> {
        let mut newest = None;
        for line in self.heard_lines()? {
            match serde_json::from_str(&line) {
                Ok(Said::Status(status)) => newest = Some(*status),
                Ok(Said::Over(over)) => return Err(Failure::failed(over)),
                Err(error) => {
                    return Err(Failure::failed(format_args!(
                        "the robot cannot be understood: {error}"
                    )));
                }
            }
        }
        Ok(newest)
    }

    fn heard_lines(&mut self) -> Result<Vec<String>, Failure> {
        let mut closed = false;
        let mut bytes = [0; 4096];
        loop {
            match self.stream.read(&mut bytes) {
                Ok(0) => closed = true,
                Ok(count) => {
                    self.read.extend_from_slice(&bytes[..count]);
                    continue;
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(_) => closed = true,
            }
            break;
        }
        let whole = self.read.iter().rposition(|&byte| byte == b'\n');
        let rest = self.read.split_off(whole.map_or(0, |end| end + 1));
        let lines = std::mem::replace(&mut self.read, rest);
        let lines: Vec<String> = String::from_utf8_lossy(&lines)
            .lines()
            .map(str::to_owned)
            .collect();
        if closed && lines.is_empty() {
            return Err(Failure::failed("the robot's program has ended"));
        }
        Ok(lines)
    }
}
