//! Every frame carries a number used once; the check that an answer belongs to the frame that was sent.
//!
//! A frame is an Ethernet header, an EtherCAT header (11 bits of length, 4 bits of type) and datagrams (ETG.1000.4
//! section 5.4): command, index, address (4 bytes), length and flags (2), event request (2), data, working counter (2).
//! Flag bit 15 says that another datagram follows. [`seal`] appends a NOP datagram with a number; [`verify`] looks for
//! it in an answer, and [`open`] takes it off again. Without it an answer could only be told from an old one by an
//! 8-bit index.

use std::ops::Range;

/// The longest Ethernet frame, without its checksum.
pub const MAX_FRAME: usize = 1514;
/// What sealing adds.
pub const SEAL: usize = DATAGRAM_OVERHEAD + SEAL_DATA;

const ETHERNET_HEADER: usize = 14;
const HEADER: usize = ETHERNET_HEADER + 2;
const DATAGRAM_HEADER: usize = 10;
const DATAGRAM_OVERHEAD: usize = DATAGRAM_HEADER + 2;
const SEAL_DATA: usize = 8;
const LENGTH_MASK: u16 = 0x07FF;
const TYPE_DATAGRAMS: u16 = 1 << 12;
const MORE_FOLLOWS: u16 = 0x8000;
const CIRCULATED: u16 = 0x4000;
const NOP: u8 = 0;

/// What a received frame is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The answer to the frame that was sent.
    Answer,
    /// A whole frame, but the answer to another one: late, duplicated, or of another MainDevice.
    Other,
    /// A frame that no SubDevice has touched: our own, or looped back by a wire without SubDevices.
    Echo,
    /// Not a frame that SubDevices could have returned for ours.
    Malformed,
}

/// Appends `number` to the `length` bytes of frame in `buffer` and returns the new length.
///
/// `None` when there is no room or the bytes are not an EtherCAT frame.
pub fn seal(buffer: &mut [u8], length: usize, number: u64) -> Option<usize> {
    let sealed = length
        .checked_add(SEAL)
        .filter(|&sealed| sealed <= buffer.len())?;
    let last = Datagrams::of(buffer.get(..length)?)?.last()??;
    let flags = read_u16(buffer, last.start + 6)?;
    write_u16(buffer, last.start + 6, flags | MORE_FOLLOWS);
    let nop = &mut buffer[length..sealed];
    nop.fill(0);
    nop[0] = NOP;
    nop[6..8].copy_from_slice(&(SEAL_DATA as u16).to_le_bytes());
    nop[DATAGRAM_HEADER..DATAGRAM_HEADER + SEAL_DATA].copy_from_slice(&number.to_le_bytes());
    set_payload(buffer, sealed - HEADER);
    Some(sealed)
}

/// Takes the number off a frame that [`verify`] has accepted.
pub fn open(frame: &mut [u8]) {
    let Some(payload) = payload_range(frame) else {
        return;
    };
    let without = payload.len().saturating_sub(SEAL);
    let before_last = Datagrams::of(frame).and_then(|datagrams| {
        datagrams
            .take_while(Option::is_some)
            .flatten()
            .take_while(|datagram| datagram.end <= HEADER + without)
            .last()
    });
    if let Some(last) = before_last
        && let Some(flags) = read_u16(frame, last.start + 6)
    {
        write_u16(frame, last.start + 6, flags & !MORE_FOLLOWS);
        set_payload(frame, without);
    }
}

/// Compares a received frame with the sealed frame that was sent.
///
/// SubDevices change data, working counters, event requests, and the addresses of position-addressed datagrams.
/// Everything else must come back as it left.
pub fn verify(sent: &[u8], received: &[u8]) -> Verdict {
    let (Some(ours), Some(theirs)) = (payload_range(sent), payload_range(received)) else {
        return Verdict::Malformed;
    };
    let Some(number) = seal_of(received, &theirs) else {
        return Verdict::Malformed;
    };
    if received[6..12] == sent[6..12] {
        return Verdict::Echo;
    }
    if Some(number) != seal_of(sent, &ours) {
        return Verdict::Other;
    }
    let (Some(ours), Some(theirs)) = (Datagrams::of(sent), Datagrams::of(received)) else {
        return Verdict::Malformed;
    };
    if payload_range(sent) != payload_range(received) {
        return Verdict::Malformed;
    }
    for (our, their) in ours.zip(theirs) {
        let same = match (our, their) {
            (Some(our), Some(their)) if our == their => same_datagram(&sent[our], &received[their]),
            _ => false,
        };
        if !same {
            return Verdict::Malformed;
        }
    }
    Verdict::Answer
}

fn same_datagram(ours: &[u8], theirs: &[u8]) -> bool {
    let flags = |datagram: &[u8]| u16::from_le_bytes([datagram[6], datagram[7]]) & !CIRCULATED;
    let command = ours[0];
    // Auto-increment (APRD, APWR, APRW, ARMW) and broadcast (BRD, BWR, BRW) addresses count the SubDevices.
    let position_addressed = matches!(command, 1 | 2 | 3 | 7 | 8 | 9 | 13);
    let address = if position_addressed { 4..6 } else { 2..6 };
    ours[..2] == theirs[..2]
        && ours[address.clone()] == theirs[address]
        && flags(ours) == flags(theirs)
}

/// The number in the last datagram of a sealed frame.
fn seal_of(frame: &[u8], payload: &Range<usize>) -> Option<u64> {
    let nop = frame.get(payload.end.checked_sub(SEAL)?..payload.end)?;
    let length_only = nop[6..8] == (SEAL_DATA as u16).to_le_bytes();
    let number = nop[DATAGRAM_HEADER..].first_chunk::<SEAL_DATA>()?;
    // No SubDevice reads or writes a NOP, so any count here is damage.
    let uncounted = nop[SEAL - 2..] == [0, 0];
    (nop[0] == NOP && length_only && uncounted && payload.len() > SEAL)
        .then(|| u64::from_le_bytes(*number))
}

/// Where the datagrams of an EtherCAT frame are; behind them there may be padding.
fn payload_range(frame: &[u8]) -> Option<Range<usize>> {
    if frame.get(12..14)? != [0x88, 0xA4] {
        return None;
    }
    let header = read_u16(frame, ETHERNET_HEADER)?;
    let range = HEADER..HEADER + usize::from(header & LENGTH_MASK);
    (header & !LENGTH_MASK == TYPE_DATAGRAMS && range.end <= frame.len()).then_some(range)
}

fn set_payload(frame: &mut [u8], length: usize) {
    write_u16(frame, ETHERNET_HEADER, TYPE_DATAGRAMS | length as u16);
}

fn read_u16(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn write_u16(bytes: &mut [u8], at: usize, value: u16) {
    bytes[at..at + 2].copy_from_slice(&value.to_le_bytes());
}

/// The datagrams of a frame, as ranges of its bytes. `None`, and then the end, where one does not fit the frame's
/// length.
struct Datagrams<'a> {
    frame: &'a [u8],
    next: Option<usize>,
    end: usize,
}

impl<'a> Datagrams<'a> {
    fn of(frame: &'a [u8]) -> Option<Datagrams<'a>> {
        let payload = payload_range(frame)?;
        Some(Datagrams {
            frame,
            next: Some(payload.start),
            end: payload.end,
        })
    }

    fn parse(&self, start: usize) -> Option<(Range<usize>, bool)> {
        let flags = read_u16(self.frame, start + 6)?;
        let end = start + DATAGRAM_OVERHEAD + usize::from(flags & LENGTH_MASK);
        let more = flags & MORE_FOLLOWS != 0;
        // The last datagram ends where the payload ends, and no other does.
        (if more {
            end < self.end
        } else {
            end == self.end
        })
        .then_some((start..end, more))
    }
}

impl Iterator for Datagrams<'_> {
    type Item = Option<Range<usize>>;

    fn next(&mut self) -> Option<Self::Item> {
        let start = self.next.take()?;
        let Some((range, more)) = self.parse(start) else {
            return Some(None);
        };
        self.next = more.then_some(range.end);
        Some(Some(range))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A frame of datagrams with those commands and data lengths.
    fn frame(datagrams: &[(u8, usize)]) -> Vec<u8> {
        let mut frame = vec![0xFF; 6];
        frame.extend([0x10; 6]);
        frame.extend([0x88, 0xA4, 0, 0]);
        for (index, &(command, length)) in datagrams.iter().enumerate() {
            let more = if index + 1 < datagrams.len() {
                MORE_FOLLOWS
            } else {
                0
            };
            frame.extend([command, index as u8, 0x01, 0x10, 0x30, 0x01]);
            frame.extend((length as u16 | more).to_le_bytes());
            frame.extend(vec![0; 2 + length + 2]);
        }
        let payload = frame.len() - HEADER;
        set_payload(&mut frame, payload);
        frame
    }

    fn sealed(datagrams: &[(u8, usize)], number: u64) -> Vec<u8> {
        let mut frame = frame(datagrams);
        let length = frame.len();
        frame.resize(MAX_FRAME, 0xEE);
        let length = seal(&mut frame, length, number).unwrap();
        frame.truncate(length);
        frame
    }

    /// What the first SubDevice makes of a frame.
    fn answered(sent: &[u8]) -> Vec<u8> {
        let mut answer = sent.to_vec();
        answer[6] |= 0x02;
        answer
    }

    #[test]
    fn opening_restores_what_was_sealed() {
        for datagrams in [
            &[(12, 208)][..],
            &[(12, 208), (4, 2)],
            &[(7, 1), (1, 4), (4, 2)],
            &[(8, 0)],
        ] {
            let plain = frame(datagrams);
            let mut opened = sealed(datagrams, 7);
            assert_eq!(opened.len(), plain.len() + SEAL);
            open(&mut opened);
            assert_eq!(opened[..plain.len()], plain);
        }
    }

    #[test]
    fn the_answer_is_recognised_with_changed_data_and_padding() {
        let sent = sealed(&[(12, 36), (4, 2), (1, 2)], 41);
        let mut answer = answered(&sent);
        answer[HEADER + DATAGRAM_HEADER] = 0xAB;
        answer[HEADER + DATAGRAM_HEADER + 36] = 3; // working counter
        answer[HEADER + 8] = 0x04; // event request
        answer[HEADER + 48 + 14 + 2] ^= 0x01; // position of the APRD
        answer.extend([0; 30]);
        assert_eq!(verify(&sent, &answer), Verdict::Answer);
    }

    #[test]
    fn answers_to_other_frames_are_told_apart() {
        let datagrams = [(12, 36), (4, 2)];
        let sent = sealed(&datagrams, 1000);
        // 128 cycles ago all indices and lengths were the same.
        assert_eq!(
            verify(&sent, &answered(&sealed(&datagrams, 1000 - 128))),
            Verdict::Other
        );
        assert_eq!(
            verify(&sent, &answered(&sealed(&[(7, 1)], 999))),
            Verdict::Other
        );
        assert_eq!(verify(&sent, &sent), Verdict::Echo);
        assert_eq!(
            verify(&sent, &answered(&frame(&datagrams))),
            Verdict::Malformed
        );
    }

    #[test]
    fn damaged_frames_are_refused() {
        let sent = sealed(&[(12, 36), (4, 2)], 5);
        let answer = answered(&sent);
        for (at, what) in [
            (12, "ethertype"),
            (14, "length"),
            (15, "type"),
            (HEADER, "command"),
            (HEADER + 1, "index"),
            (HEADER + 2, "address"),
            (HEADER + 6, "datagram length"),
            (HEADER + 7, "more follows"),
        ] {
            let mut damaged = answer.clone();
            damaged[at] ^= 0x81;
            assert_ne!(verify(&sent, &damaged), Verdict::Answer, "{what}");
        }
        for length in 0..answer.len() {
            assert_eq!(
                verify(&sent, &answer[..length]),
                Verdict::Malformed,
                "cut to {length}"
            );
        }
    }

    #[test]
    fn a_frame_without_room_is_not_sealed() {
        let mut full = frame(&[(12, 1000)]);
        let length = full.len();
        full.resize(length + SEAL - 1, 0);
        assert_eq!(seal(&mut full, length, 1), None);
        assert_eq!(seal(&mut [0; 64], 64 - SEAL, 1), None);
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(mut bytes in proptest::collection::vec(any::<u8>(), 0..120), header in any::<bool>()) {
            if header && bytes.len() > HEADER {
                let length = bytes.len() - HEADER;
                bytes[12..14].copy_from_slice(&[0x88, 0xA4]);
                set_payload(&mut bytes, length);
            }
            let sent = sealed(&[(12, 36), (4, 2)], 5);
            verify(&sent, &bytes);
            verify(&bytes, &sent);
            let mut opened = bytes.clone();
            open(&mut opened);
            let length = bytes.len().saturating_sub(SEAL);
            seal(&mut bytes, length, 1);
        }
    }
}
