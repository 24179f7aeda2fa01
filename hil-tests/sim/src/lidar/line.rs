//! The serial line's sending side: bounded, and no faster than its bit rate.

use std::collections::VecDeque;

use super::device::{Emission, Kind};

/// Start bit, eight data bits, stop bit.
const BITS_PER_BYTE: u64 = 10;
/// Most transmission time that a line makes up for after it could not send.
const MAX_CREDIT_NS: u64 = 5_000_000;
/// Most scans queued: one on its way and one waiting. A third would only arrive older.
const MAX_SCANS: usize = 2;
/// Most bytes of replies that wait to be sent; further ones are lost.
const MAX_BYTES: usize = 64 * 1024;

/// What waits to be sent, and how fast it may go.
#[derive(Debug, Clone)]
pub struct Line {
    queue: VecDeque<Emission>,
    /// Bytes of the first emission that are gone already.
    sent: usize,
    bytes: usize,
    bit_rate: u32,
    /// Everything sent so far has left the wire at this time.
    clear_ns: u64,
    lost_bytes: u64,
}

impl Line {
    /// An idle line.
    #[must_use]
    pub fn new(bit_rate: u32) -> Line {
        Line {
            queue: VecDeque::new(),
            sent: 0,
            bytes: 0,
            bit_rate: bit_rate.max(1),
            clear_ns: 0,
            lost_bytes: 0,
        }
    }

    /// The present bit rate.
    #[must_use]
    pub fn bit_rate(&self) -> u32 {
        self.bit_rate
    }

    /// There is no room for another scan.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        let scans = self.queue.iter().filter(|e| e.kind == Kind::Scan);
        scans.count() >= MAX_SCANS || self.bytes >= MAX_BYTES
    }

    /// Nothing waits.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.queue.is_empty()
    }

    /// Bytes lost because too much was waiting.
    #[must_use]
    pub fn lost_bytes(&self) -> u64 {
        self.lost_bytes
    }

    /// Queues an emission; if too much waits already its bytes are lost, though not its change of bit rate.
    pub fn push(&mut self, mut emission: Emission, now_ns: u64) {
        if self.queue.is_empty() {
            self.clear_ns = self.clear_ns.max(now_ns);
        }
        if self.bytes + emission.bytes.len() > MAX_BYTES {
            self.lost_bytes += emission.bytes.len() as u64;
            emission.bytes.clear();
            if emission.bit_rate_after.is_none() {
                return;
            }
            // Only the last change counts: replies without bytes must not pile up either.
            if let Some(last) = self.queue.back_mut() {
                last.bit_rate_after = emission.bit_rate_after;
                return;
            }
        }
        self.bytes += emission.bytes.len();
        self.queue.push_back(emission);
    }

    /// Forgets what waits; pending changes of the bit rate happen.
    pub fn clear(&mut self) {
        for emission in self.queue.drain(..) {
            self.bit_rate = emission.bit_rate_after.unwrap_or(self.bit_rate);
        }
        self.sent = 0;
        self.bytes = 0;
    }

    /// The bytes that may leave by `now_ns`, all of one bit rate.
    pub fn ready(&mut self, now_ns: u64) -> &[u8] {
        self.finish_sent();
        self.clear_ns = self.clear_ns.max(now_ns.saturating_sub(MAX_CREDIT_NS));
        let credit_ns = now_ns.saturating_sub(self.clear_ns);
        let may = credit_ns * u64::from(self.bit_rate) / (BITS_PER_BYTE * 1_000_000_000);
        let Some(first) = self.queue.front() else {
            return &[];
        };
        let left = &first.bytes[self.sent..];
        &left[..left.len().min(usize::try_from(may).unwrap_or(usize::MAX))]
    }

    /// This number of the ready bytes has the last one of a scan.
    #[must_use]
    pub fn ends_scan(&self, bytes: usize) -> bool {
        let first = self.queue.front();
        first
            .is_some_and(|first| first.kind == Kind::Scan && self.sent + bytes >= first.bytes.len())
    }

    /// Takes note that this number of the ready bytes has left.
    pub fn advance(&mut self, bytes: usize) {
        self.sent += bytes;
        self.bytes = self.bytes.saturating_sub(bytes);
        self.clear_ns += bytes as u64 * BITS_PER_BYTE * 1_000_000_000 / u64::from(self.bit_rate);
        self.finish_sent();
    }

    /// Removes what is sent completely and changes the bit rate behind it.
    fn finish_sent(&mut self) {
        while self
            .queue
            .front()
            .is_some_and(|first| self.sent >= first.bytes.len())
        {
            if let Some(first) = self.queue.pop_front() {
                self.bit_rate = first.bit_rate_after.unwrap_or(self.bit_rate).max(1);
            }
            self.sent = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND_NS: u64 = 1_000_000_000;

    fn emission(length: usize, kind: Kind, bit_rate_after: Option<u32>) -> Emission {
        Emission {
            bytes: vec![b'x'; length],
            kind,
            bit_rate_after,
        }
    }

    fn drain(line: &mut Line, from_ns: u64, duration_ns: u64) -> usize {
        let mut total = 0;
        for now_ns in (from_ns..=from_ns + duration_ns).step_by(1_000_000) {
            let ready = line.ready(now_ns).len();
            line.advance(ready);
            total += ready;
        }
        total
    }

    #[test]
    fn sends_at_the_bit_rate() {
        let mut line = Line::new(19_200);
        line.push(emission(10_000, Kind::Reply, None), SECOND_NS);
        let sent = drain(&mut line, SECOND_NS, SECOND_NS);
        assert!((1915..=1920).contains(&sent), "{sent}");
    }

    #[test]
    fn the_last_byte_of_a_scan_is_known() {
        let mut line = Line::new(750_000);
        assert!(!line.ends_scan(0));
        line.push(emission(100, Kind::Reply, None), SECOND_NS);
        line.push(emission(200, Kind::Scan, None), SECOND_NS);
        assert!(!line.ends_scan(100));
        line.advance(100);
        line.advance(150);
        assert!(!line.ends_scan(49) && line.ends_scan(50));
    }

    #[test]
    fn rate_changes_behind_the_reply() {
        let mut line = Line::new(19_200);
        line.push(emission(96, Kind::Reply, Some(750_000)), SECOND_NS);
        line.push(emission(7500, Kind::Reply, None), SECOND_NS);
        assert_eq!(drain(&mut line, SECOND_NS, 49_000_000), 94);
        assert_eq!(line.bit_rate(), 19_200);
        drain(&mut line, SECOND_NS + 50_000_000, 2_000_000);
        assert_eq!(line.bit_rate(), 750_000);
        let sent = drain(&mut line, SECOND_NS + 53_000_000, 120_000_000);
        assert!(sent > 7300 && line.is_idle(), "{sent}");
    }

    #[test]
    fn is_bounded() {
        let mut line = Line::new(19_200);
        line.push(emission(2000, Kind::Scan, None), 0);
        assert!(!line.is_busy());
        line.push(emission(2000, Kind::Scan, None), 0);
        assert!(line.is_busy());
        for _ in 0..100_000 {
            line.push(emission(1000, Kind::Reply, Some(57_600)), 0);
        }
        assert!(line.bytes <= MAX_BYTES && line.queue.len() < 100);
        assert!(line.lost_bytes() > 90_000_000);
        line.clear();
        assert!(line.is_idle() && line.bit_rate() == 57_600);
    }
}
