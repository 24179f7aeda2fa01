//! The characters of SCIP 2.0 (Hokuyo, "Communication Protocol Specification for SCIP 2.0"): checksums, six-bit values,
//! status codes and commands.
//!
//! Pure functions over bytes: no I/O, no allocation, no panic on any input.

use std::fmt;

/// Most data bytes in one line, without its checksum.
pub const LINE_DATA_BYTES: usize = 64;

/// The checksum character of `bytes`: the low six bits of their sum, made printable.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u8 {
    let sum = bytes.iter().fold(0u8, |sum, byte| sum.wrapping_add(*byte));
    (sum & 0x3f) + 0x30
}

/// The line without its checksum character, or `None` when they disagree.
#[must_use]
pub fn verify(line: &[u8]) -> Option<&[u8]> {
    let (found, payload) = line.split_last()?;
    (!payload.is_empty() && *found == checksum(payload)).then_some(payload)
}

/// Key and value of a line `KEY:value;c`, whose semicolon is not part of the sum.
#[must_use]
pub fn verify_field(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let (found, rest) = line.split_last()?;
    let payload = rest.strip_suffix(b";")?;
    if *found != checksum(payload) {
        return None;
    }
    let colon = payload.iter().position(|byte| *byte == b':')?;
    Some((&payload[..colon], &payload[colon + 1..]))
}

/// The six bits of one character, or `None` outside `0x30..=0x6f`.
#[must_use]
pub const fn decode_character(character: u8) -> Option<u8> {
    match character {
        0x30..=0x6f => Some(character - 0x30),
        _ => None,
    }
}

/// The value of up to five characters, most significant first.
#[must_use]
pub fn decode(characters: &[u8]) -> Option<u32> {
    if characters.is_empty() || characters.len() > 5 {
        return None;
    }
    characters.iter().try_fold(0u32, |value, character| {
        Some(value << 6 | u32::from(decode_character(*character)?))
    })
}

/// Writes `value` over all of `characters`, most significant first; false when it does not fit.
#[must_use]
pub fn encode(value: u32, characters: &mut [u8]) -> bool {
    let mut rest = value;
    for character in characters.iter_mut().rev() {
        *character = (rest & 0x3f) as u8 + 0x30;
        rest >>= 6;
    }
    rest == 0
}

/// How many characters carry one range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Encoding {
    /// `MS`: two characters, at most 4095 mm; a third fewer bytes.
    Two,
    /// `MD`: three characters, the whole range of the device.
    #[default]
    Three,
}

impl Encoding {
    /// Characters for one range.
    #[must_use]
    pub const fn characters(self) -> usize {
        match self {
            Self::Two => 2,
            Self::Three => 3,
        }
    }

    const fn letter(self) -> u8 {
        match self {
            Self::Two => b'S',
            Self::Three => b'D',
        }
    }
}

/// The two status characters of a reply.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Status(pub [u8; 2]);

impl Status {
    /// Accepted.
    pub const OK: Self = Self(*b"00");
    /// In reply to `BM`: the laser is on already. In reply to `SS`: not a bit rate.
    pub const LASER_ALREADY_ON: Self = Self(*b"02");
    /// In reply to `TM0`: the device tells its time already.
    pub const ADJUSTS_ALREADY: Self = Self(*b"02");
    /// In reply to `SS`: the device runs at this bit rate already.
    pub const SAME_BIT_RATE: Self = Self(*b"03");
    /// A scan of a stream follows.
    pub const SCAN: Self = Self(*b"99");

    /// The status in a line such as `00P`, if its checksum holds.
    #[must_use]
    pub fn parse(line: &[u8]) -> Option<Self> {
        let payload = verify(line)?;
        Some(Self(payload.try_into().ok()?))
    }
}

impl fmt::Display for Status {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.0.escape_ascii())
    }
}

impl fmt::Debug for Status {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "Status({self})")
    }
}

/// Length of a stream command, and of the echo that precedes each of its scans.
pub const STREAM_COMMAND_BYTES: usize = 15;

/// `MDaaaabbbbccdee` or `MS…`: an endless stream from `first_step` to `last_step`.
///
/// `None` when a number does not fit into its digits.
#[must_use]
pub fn stream_command(
    encoding: Encoding,
    first_step: u16,
    last_step: u16,
    cluster: u8,
    skip: u8,
) -> Option<[u8; STREAM_COMMAND_BYTES]> {
    let mut command = *b"MDaaaabbbbccd00";
    command[1] = encoding.letter();
    let fits = decimal(first_step.into(), &mut command[2..6])
        && decimal(last_step.into(), &mut command[6..10])
        && decimal(cluster.into(), &mut command[10..12])
        && decimal(skip.into(), &mut command[12..13]);
    fits.then_some(command)
}

/// `SSnnnnnn`; `None` for a rate of more than six digits.
#[must_use]
pub fn bit_rate_command(bit_rate: u32) -> Option<[u8; 8]> {
    let mut command = *b"SS000000";
    decimal(bit_rate, &mut command[2..]).then_some(command)
}

fn decimal(value: u32, digits: &mut [u8]) -> bool {
    let mut rest = value;
    for digit in digits.iter_mut().rev() {
        *digit = b'0' + (rest % 10) as u8;
        rest /= 10;
    }
    rest == 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn checksums_of_the_specification() {
        assert_eq!(Status::parse(b"00P"), Some(Status::OK));
        assert_eq!(Status::parse(b"99b"), Some(Status::SCAN));
        assert_eq!(Status::parse(b"02R"), Some(Status::LASER_ALREADY_ON));
        assert_eq!(Status::parse(b"10Q"), Some(Status(*b"10")));
        assert_eq!(
            verify_field(b"AFRT:384;6"),
            Some((&b"AFRT"[..], &b"384"[..]))
        );
        assert_eq!(
            verify_field(b"DMAX:5600;_"),
            Some((&b"DMAX"[..], &b"5600"[..]))
        );
        assert_eq!(
            verify_field(b"ARES:1024;\\"),
            Some((&b"ARES"[..], &b"1024"[..]))
        );
        assert_eq!(
            verify_field(b"SCAN:600;e"),
            Some((&b"SCAN"[..], &b"600"[..]))
        );
        assert_eq!(verify_field(b"SCAN:601;e"), None);
    }

    #[test]
    fn values_of_the_specification() {
        assert_eq!(decode(b"CB"), Some(1234));
        assert_eq!(decode(b"1Dh"), Some(5432));
        assert_eq!(decode(b"m2@0"), Some(16_000_000));
    }

    #[test]
    fn commands() {
        assert_eq!(
            stream_command(Encoding::Three, 44, 725, 1, 0).as_ref(),
            Some(b"MD0044072501000")
        );
        assert_eq!(
            stream_command(Encoding::Two, 0, 768, 99, 9).as_ref(),
            Some(b"MS0000076899900")
        );
        assert_eq!(stream_command(Encoding::Two, 0, 10_000, 1, 0), None);
        assert_eq!(stream_command(Encoding::Two, 0, 10, 100, 0), None);
        assert_eq!(stream_command(Encoding::Two, 0, 10, 1, 10), None);
        assert_eq!(bit_rate_command(19_200).as_ref(), Some(b"SS019200"));
        assert_eq!(bit_rate_command(750_000).as_ref(), Some(b"SS750000"));
        assert_eq!(bit_rate_command(1_000_000), None);
    }

    proptest! {
        #[test]
        fn values_survive_a_round_trip(value in 0u32..1 << 24, characters in 2usize..=4) {
            let mut buffer = [0; 4];
            let text = &mut buffer[..characters];
            let fits = encode(value, text);
            prop_assert_eq!(fits, value < 1 << (6 * characters));
            prop_assert!(text.iter().all(|c| (0x30..=0x6f).contains(c)));
            prop_assert_eq!(decode(text), Some(value & ((1 << (6 * characters)) - 1)));
        }

        #[test]
        fn a_checked_line_verifies_and_a_changed_bit_does_not(
            mut line in proptest::collection::vec(0x30u8..=0x6f, 1..=LINE_DATA_BYTES),
            at in any::<prop::sample::Index>(),
            bit in 0u8..6,
        ) {
            let payload = line.clone();
            line.push(checksum(&payload));
            prop_assert_eq!(verify(&line), Some(&payload[..]));
            let at = at.index(payload.len());
            line[at] ^= 1 << bit;
            prop_assert_eq!(verify(&line), None);
        }

        #[test]
        fn arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let _ = checksum(&bytes);
            let _ = verify(&bytes);
            let _ = verify_field(&bytes);
            let _ = decode(&bytes);
            let _ = Status::parse(&bytes).map(|status| status.to_string());
        }
    }
}
