//! A plugged-in cable: the terminal, its link, and whether anybody reads.

use std::io;
use std::path::Path;

use super::options::LidarError;
use crate::lidar::pty::{Link, Pty};
use crate::lidar::sensor::Sensor;

/// The kernel keeps 4095 bytes for a reader; what does not fit waits in the line, where its bit rate is known.
const MAX_UNREAD: u64 = 4000;
/// When no more fit, what is unread is discarded after this time without a reader, as it would be lost on a real wire. Replies
/// that fit wait for their reader.
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

    /// Hands the host what may have arrived by now; returns the number of bytes discarded because nobody reads.
    pub(super) fn send(
        &mut self,
        sensor: &mut Sensor,
        host_bit_rate: u32,
        now_ns: u64,
    ) -> io::Result<u64> {
        let unread = self.keep(now_ns);
        let pty = &mut self.pty;
        sensor.speak(now_ns, host_bit_rate, |bytes| {
            let room = MAX_UNREAD.saturating_sub(pty.unread()) as usize;
            pty.write(&bytes[..bytes.len().min(room)])
        })?;
        Ok(unread)
    }

    /// Discards what nobody reads; returns the number of bytes discarded.
    fn keep(&mut self, now_ns: u64) -> u64 {
        if now_ns.saturating_sub(self.kept_ns) >= HOUSEKEEPING_NS {
            self.kept_ns = now_ns;
            self.pty.release_exclusive();
        }
        let unread = self.pty.unread();
        // Fewer unread bytes than before show that somebody reads.
        if unread < MAX_UNREAD || unread < self.last_unread || self.heard_ns == 0 {
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
