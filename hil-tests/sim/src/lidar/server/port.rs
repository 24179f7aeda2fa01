//! A plugged-in cable: the terminal, its link, and whether anybody reads.

use std::io;
use std::path::Path;

use super::options::LidarError;
use crate::lidar::line::Line;
use crate::lidar::pty::{Link, Pty};
use crate::world::Random;

/// The kernel keeps 4095 bytes for a reader; what does not fit waits in the line, where its bit rate is known.
const MAX_UNREAD: u64 = 4000;
/// Unread bytes are discarded after this time without a reader, as they would be lost on a real wire.
const UNHEARD_NS: u64 = 500_000_000;
const HOUSEKEEPING_NS: u64 = 100_000_000;

#[derive(Debug)]
pub(super) struct Port {
    pty: Pty,
    _link: Option<Link>,
    last_unread: u64,
    heard_ns: u64,
    kept_ns: u64,
}

/// What a transfer did.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sent {
    pub(super) bytes: u64,
    pub(super) garbled: u64,
    pub(super) unread: u64,
}

impl Port {
    pub(super) fn new(link: Option<&Path>, bit_rate: u32) -> Result<Port, LidarError> {
        let pty = Pty::open(bit_rate).map_err(LidarError::Terminal)?;
        let link = link.map(|link| Link::create(link, pty.path())).transpose();
        Ok(Port {
            _link: link.map_err(LidarError::Link)?,
            pty,
            last_unread: 0,
            heard_ns: 0,
            kept_ns: 0,
        })
    }

    pub(super) fn pty(&self) -> &Pty {
        &self.pty
    }

    pub(super) fn path(&self) -> &Path {
        self.pty.path()
    }

    /// Hands the host what may have arrived by now; garbled if it listens at another bit rate, or swallowed if
    /// the wire is silent.
    pub(super) fn send(
        &mut self,
        line: &mut Line,
        now_ns: u64,
        silent: bool,
        random: &mut Random,
    ) -> io::Result<Sent> {
        let mut sent = Sent {
            unread: self.keep(now_ns),
            ..Sent::default()
        };
        let host_bit_rate = self.pty.host_bit_rate();
        loop {
            let bit_rate = line.bit_rate();
            let ready = line.ready(now_ns);
            if ready.is_empty() {
                return Ok(sent);
            }
            if silent {
                let swallowed = ready.len();
                line.advance(swallowed);
                continue;
            }
            let room = MAX_UNREAD.saturating_sub(self.pty.unread()) as usize;
            let ready = &ready[..ready.len().min(room)];
            let written = if bit_rate == host_bit_rate {
                self.pty.write(ready)?
            } else {
                let garbled: Vec<u8> = ready.iter().map(|_| random.byte()).collect();
                let written = self.pty.write(&garbled)?;
                sent.garbled += written as u64;
                written
            };
            if written == 0 {
                return Ok(sent);
            }
            sent.bytes += written as u64;
            line.advance(written);
        }
    }

    /// Discards what nobody reads; returns the number of bytes discarded.
    fn keep(&mut self, now_ns: u64) -> u64 {
        if now_ns.saturating_sub(self.kept_ns) >= HOUSEKEEPING_NS {
            self.kept_ns = now_ns;
            self.pty.release_exclusive();
        }
        let unread = self.pty.unread();
        // Fewer unread bytes than before, or none, show that somebody reads.
        if unread == 0 || unread < self.last_unread || self.heard_ns == 0 {
            self.heard_ns = now_ns;
        }
        self.last_unread = unread;
        if now_ns.saturating_sub(self.heard_ns) < UNHEARD_NS {
            return 0;
        }
        self.pty.discard_unread();
        self.last_unread = 0;
        self.heard_ns = now_ns;
        unread
    }
}
