//! Text of bounded length in the symbol table.

use bytemuck::{Pod, Zeroable};
use serde::{Serialize, Serializer};

/// Text of up to `BYTES` − 1 bytes.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(transparent)]
pub struct Text<const BYTES: usize> {
    bytes: [u8; BYTES],
}

/// A name of up to 31 bytes.
pub type Name = Text<32>;

/// A sentence of up to 255 bytes.
pub type Line = Text<256>;

impl<const BYTES: usize> Text<BYTES> {
    /// Takes over `text`, cut at a character boundary when it is too long.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let mut bytes = [0; BYTES];
        let mut end = text.len().min(BYTES - 1);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        bytes[..end].copy_from_slice(&text.as_bytes()[..end]);
        Self { bytes }
    }

    /// The text, up to the first zero.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let end = self.bytes.iter().position(|&byte| byte == 0);
        std::str::from_utf8(&self.bytes[..end.unwrap_or(BYTES)]).unwrap_or("?")
    }
}

impl<const BYTES: usize> Default for Text<BYTES> {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl<const BYTES: usize> Serialize for Text<BYTES> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_cut_at_a_character() {
        assert_eq!(Name::new("drive-1").as_str(), "drive-1");
        assert_eq!(Name::new(&"ä".repeat(20)).as_str(), "ä".repeat(15));
        assert_eq!(Line::new(&"ä".repeat(200)).as_str(), "ä".repeat(127));
    }
}
