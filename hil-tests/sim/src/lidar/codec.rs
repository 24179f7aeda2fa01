//! Checksum, number encoding and line layout of SCIP 2.0 (Hokuyo, "Communication Protocol Specification for SCIP 2.0").

/// Most data characters on a line.
const LINE_CHARACTERS: usize = 64;

/// Low six bits of the sum, plus 0x30.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u8 {
    let sum = bytes.iter().fold(0u8, |sum, byte| sum.wrapping_add(*byte));
    (sum & 0x3F) + 0x30
}

/// Appends a value as `characters` characters of six bits each, most significant first; what does not fit saturates.
pub fn encode(value: u32, characters: u32, out: &mut Vec<u8>) {
    let bits = (6 * characters).min(32);
    let most = u32::try_from((1u64 << bits) - 1).unwrap_or(u32::MAX);
    let value = value.min(most);
    for position in (0..characters).rev() {
        let six = value.checked_shr(6 * position).unwrap_or(0) & 0x3F;
        out.push(six as u8 + 0x30);
    }
}

/// Appends a line with its checksum.
pub(super) fn summed_line(bytes: &[u8], out: &mut Vec<u8>) {
    out.extend_from_slice(bytes);
    out.push(checksum(bytes));
    out.push(b'\n');
}

/// Appends data in lines of at most 64 characters, each with its checksum.
pub(super) fn data_lines(data: &[u8], out: &mut Vec<u8>) {
    for line in data.chunks(LINE_CHARACTERS) {
        summed_line(line, out);
    }
}

/// Appends a line of VV, PP or II: the semicolon before the checksum is not part of the sum.
pub(super) fn report_line(text: &str, out: &mut Vec<u8>) {
    out.extend_from_slice(text.as_bytes());
    out.push(b';');
    out.push(checksum(text.as_bytes()));
    out.push(b'\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_by_hand() {
        // 0x30 + 0x30 = 0x60; low six bits 0x20; plus 0x30 = 'P'.
        assert_eq!(checksum(b"00"), b'P');
        assert_eq!(checksum(b"99"), b'b');
        assert_eq!(checksum(b"02"), b'R');
        assert_eq!(checksum(b"10"), b'Q');
        assert_eq!(checksum(b"0E"), b'e');
        assert_eq!(checksum(b""), b'0');
    }

    #[test]
    fn report_lines_as_the_device_prints_them() {
        for (text, sum) in [
            ("MODL:URG-04LX(Hokuyo Automatic Co.,Ltd.)", 'N'),
            ("DMIN:20", '4'),
            ("DMAX:5600", '_'),
            ("ARES:1024", '\\'),
            ("AMIN:44", '7'),
            ("AMAX:725", 'o'),
            ("AFRT:384", '6'),
            ("SCAN:600", 'e'),
            ("LASR:OFF", '7'),
            ("PROT:SCIP 2.0", 'N'),
        ] {
            let mut line = Vec::new();
            report_line(text, &mut line);
            assert_eq!(line, format!("{text};{sum}\n").into_bytes());
        }
    }

    #[test]
    fn values_by_hand() {
        let encoded = |value, characters| {
            let mut out = Vec::new();
            encode(value, characters, &mut out);
            String::from_utf8(out).unwrap()
        };
        // 1234 = 0b010011_010010: 0x13 + 0x30 = 'C', 0x12 + 0x30 = 'B'.
        assert_eq!(encoded(1234, 2), "CB");
        // 5432 = 0b000001_010100_111000: '1', 'D', 'h'.
        assert_eq!(encoded(5432, 3), "1Dh");
        // 16000000 = 0b111101_000010_010000_000000: 'm', '2', '@', '0'.
        assert_eq!(encoded(16_000_000, 4), "m2@0");
        assert_eq!(encoded(5000, 2), "oo");
        assert_eq!(encoded(4095, 2), "oo");
        assert_eq!(encoded(u32::MAX, 6), "3ooooo");
    }

    #[test]
    fn long_data_is_cut_into_lines() {
        let mut out = Vec::new();
        data_lines(&[b'0'; 130], &mut out);
        let lines: Vec<_> = out.split(|byte| *byte == b'\n').map(<[u8]>::len).collect();
        assert_eq!(lines, [65, 65, 3, 0]);
    }
}
