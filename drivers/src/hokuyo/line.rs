//! Cuts a byte stream into lines, in a buffer of fixed size.

/// The longest line kept whole. The longest data line has 65 bytes, text fields have fewer than 100.
const CAPACITY: usize = 128;
/// Bytes kept from the end of a line that is too long: enough to find a command's echo there.
const KEPT_TAIL: usize = 32;

/// Collects bytes until a line feed. Real-time: no allocation.
#[derive(Debug)]
pub struct LineBuffer {
    bytes: [u8; CAPACITY],
    length: usize,
    complete: bool,
}

impl LineBuffer {
    /// Empty.
    pub const fn new() -> Self {
        Self {
            bytes: [0; CAPACITY],
            length: 0,
            complete: false,
        }
    }

    /// Forgets what has been collected.
    pub fn clear(&mut self) {
        self.length = 0;
        self.complete = false;
    }

    /// Takes one byte; gives the line, without its end, when the byte ends it.
    ///
    /// Of a line longer than the buffer only the end is kept, which cannot be mistaken for a whole line of the
    /// protocol: it still has more bytes than any.
    pub fn push(&mut self, byte: u8) -> Option<&[u8]> {
        if self.complete {
            self.clear();
        }
        if byte == b'\n' {
            self.complete = true;
            let line = &self.bytes[..self.length];
            return Some(line.strip_suffix(b"\r").unwrap_or(line));
        }
        if self.length == CAPACITY {
            // Keep it longer than any line of the protocol, so that the rest is not mistaken for one.
            self.bytes
                .copy_within(CAPACITY - KEPT_TAIL.., CAPACITY - 2 * KEPT_TAIL);
            self.length = CAPACITY - KEPT_TAIL;
        }
        self.bytes[self.length] = byte;
        self.length += 1;
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut buffer = LineBuffer::new();
        bytes
            .iter()
            .filter_map(|byte| buffer.push(*byte).map(<[u8]>::to_vec))
            .collect()
    }

    #[test]
    fn cuts_at_line_feeds_and_drops_carriage_returns() {
        assert_eq!(lines(b"QT\r\n00P\n\nrest"), [&b"QT"[..], b"00P", b""]);
    }

    #[test]
    fn keeps_the_end_of_an_endless_line() {
        let mut bytes = vec![b'x'; 10_000];
        bytes.extend_from_slice(b"MD0044072501000\nnext\n");
        let lines = lines(&bytes);
        assert_eq!(lines.len(), 2);
        assert!(lines[0].ends_with(b"MD0044072501000"));
        assert!(lines[0].len() > 66 && lines[0].len() <= CAPACITY);
        assert_eq!(lines[1], b"next");
    }
}
