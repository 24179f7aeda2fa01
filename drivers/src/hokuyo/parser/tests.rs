//! The parser against whole, broken and arbitrary streams.

use proptest::prelude::*;

use super::{Event, Fault, StreamParser};
use crate::hokuyo::codec::{self, Encoding, LINE_DATA_BYTES};
use crate::hokuyo::options::ScanFormat;

const FULL: ScanFormat = ScanFormat {
    first_step: 44,
    last_step: 725,
    cluster: 1,
    skip: 0,
    encoding: Encoding::Three,
};
const BEGUN: Event = Event::Begun {
    resynchronised: false,
    dropped: None,
};
const BEGUN_AGAIN: Event = Event::Begun {
    resynchronised: true,
    dropped: None,
};

fn command(format: &ScanFormat) -> [u8; 15] {
    let ScanFormat {
        first_step,
        last_step,
        cluster,
        skip,
        encoding,
    } = *format;
    codec::stream_command(encoding, first_step, last_step, cluster, skip).unwrap()
}

/// One scan as the device sends it.
fn wire(format: &ScanFormat, device_ms: u32, ranges_mm: &[u16]) -> Vec<u8> {
    assert_eq!(ranges_mm.len(), format.beams());
    let mut bytes = command(format).to_vec();
    bytes.push(b'\n');
    let checked_line = |bytes: &mut Vec<u8>, payload: &[u8]| {
        bytes.extend_from_slice(payload);
        bytes.extend_from_slice(&[codec::checksum(payload), b'\n']);
    };
    checked_line(&mut bytes, b"99");
    let mut stamp = [0; 4];
    assert!(codec::encode(device_ms, &mut stamp));
    checked_line(&mut bytes, &stamp);
    let characters = format.encoding.characters();
    let mut data = vec![0; characters * ranges_mm.len()];
    for (value, out) in ranges_mm.iter().zip(data.chunks_mut(characters)) {
        assert!(codec::encode((*value).into(), out));
    }
    for payload in data.chunks(LINE_DATA_BYTES) {
        checked_line(&mut bytes, payload);
    }
    bytes.push(b'\n');
    bytes
}

fn ramp(format: &ScanFormat) -> Vec<u16> {
    (0..format.beams()).map(|beam| (beam * 6) as u16).collect()
}

fn parse(parser: &mut StreamParser, bytes: &[u8]) -> Vec<Event> {
    bytes.iter().filter_map(|byte| parser.push(*byte)).collect()
}

fn parser(format: &ScanFormat) -> StreamParser {
    StreamParser::new(&command(format), format)
}

#[test]
fn reads_a_stream_from_its_acceptance_on() {
    let mut parser = parser(&FULL);
    let mut bytes = command(&FULL).to_vec();
    bytes.extend_from_slice(b"\n00P\n\n");
    assert_eq!(parse(&mut parser, &bytes), [BEGUN]);
    for device_ms in [0, 100, 0xff_ffff] {
        let events = parse(&mut parser, &wire(&FULL, device_ms, &ramp(&FULL)));
        assert_eq!(events, [BEGUN, Event::Complete { device_ms }]);
        assert_eq!(parser.ranges_mm(), ramp(&FULL));
    }
}

#[test]
fn a_scan_cut_anywhere_costs_itself_and_no_other() {
    let scan = wire(&FULL, 1, &ramp(&FULL));
    for cut in 0..scan.len() {
        for tail in 0..2 {
            let mut parser = parser(&FULL);
            parse(&mut parser, &scan);
            // Bytes are missing at the end, or in the middle.
            let mut bytes = scan[..cut].to_vec();
            if tail == 1 {
                bytes.extend_from_slice(&scan[(cut + 40).min(scan.len())..]);
            }
            bytes.extend_from_slice(&scan);
            let events = parse(&mut parser, &bytes);
            let complete = |event: &&Event| matches!(event, Event::Complete { .. });
            assert!(
                events.iter().filter(complete).count() >= 1,
                "cut {cut}: {events:?}"
            );
            assert_eq!(
                events.last(),
                Some(&Event::Complete { device_ms: 1 }),
                "cut {cut}: {events:?}"
            );
            assert!(events.len() <= 5, "cut {cut}: {events:?}");
            assert_eq!(parser.ranges_mm(), ramp(&FULL));
        }
    }
}

#[test]
fn a_wrong_character_drops_one_scan_and_reports_it_once() {
    let mut scan = wire(&FULL, 1, &ramp(&FULL));
    scan[200] ^= 1;
    let mut parser = parser(&FULL);
    let dropped = Event::Dropped(Fault::Checksum);
    assert_eq!(parse(&mut parser, &scan), [BEGUN, dropped]);
    let scan = wire(&FULL, 2, &ramp(&FULL));
    assert_eq!(
        parse(&mut parser, &scan),
        [BEGUN_AGAIN, Event::Complete { device_ms: 2 }]
    );
    assert_eq!(
        parse(&mut parser, &scan),
        [BEGUN, Event::Complete { device_ms: 2 }]
    );
}

#[test]
fn an_echo_behind_rubbish_on_its_line_still_begins_a_scan() {
    let scan = wire(&FULL, 3, &ramp(&FULL));
    for rubbish in [5, 60, 100, 127, 128, 129, 5000] {
        let mut parser = parser(&FULL);
        parse(&mut parser, &scan);
        let mut bytes = vec![0xf5; rubbish];
        bytes.extend_from_slice(&scan);
        let begun = Event::Begun {
            resynchronised: true,
            dropped: Some(Fault::Garbage),
        };
        assert_eq!(
            parse(&mut parser, &bytes),
            [begun, Event::Complete { device_ms: 3 }]
        );
    }
}

#[test]
fn garbage_between_scans_is_reported_once() {
    let mut parser = parser(&FULL);
    let scan = wire(&FULL, 3, &ramp(&FULL));
    parse(&mut parser, &scan);
    assert_eq!(
        parse(&mut parser, b"noise\nmore\n\nand more\n"),
        [Event::Dropped(Fault::Garbage)]
    );
    assert_eq!(
        parse(&mut parser, &scan),
        [BEGUN_AGAIN, Event::Complete { device_ms: 3 }]
    );
}

#[test]
fn an_error_status_is_passed_on() {
    let mut parser = parser(&FULL);
    let mut bytes = command(&FULL).to_vec();
    bytes.extend_from_slice(b"\n50U\n\n");
    let dropped = Event::Dropped(Fault::Device(codec::Status(*b"50")));
    assert_eq!(parse(&mut parser, &bytes), [BEGUN, dropped]);
    let scan = wire(&FULL, 4, &ramp(&FULL));
    assert_eq!(
        parse(&mut parser, &scan),
        [BEGUN, Event::Complete { device_ms: 4 }]
    );
}

#[test]
fn a_data_line_that_looks_like_the_echo_is_data() {
    // Seven beams of two characters and a checksum are as long as an echo. Find one that is an echo.
    let (format, line) = (0u16..700)
        .flat_map(|first_step| (b'0'..=b'9').map(move |digit| (first_step, digit)))
        .find_map(|(first_step, digit)| {
            let last_step = first_step + 6;
            let format = ScanFormat {
                first_step,
                last_step,
                cluster: 1,
                skip: 0,
                encoding: Encoding::Two,
            };
            let mut line = command(&format);
            line[13] = digit;
            line[14] = codec::checksum(&line[..14]);
            line[14].is_ascii_digit().then_some((format, line))
        })
        .unwrap();
    let ranges: Vec<u16> = line[..14]
        .chunks(2)
        .map(|value| codec::decode(value).unwrap() as u16)
        .collect();
    let bytes = wire(&format, 9, &ranges);
    assert!(bytes.windows(15).filter(|window| *window == line).count() > 0);
    let mut parser = parser(&format);
    assert_eq!(
        parse(&mut parser, &bytes),
        [BEGUN, Event::Complete { device_ms: 9 }]
    );
    assert_eq!(parser.ranges_mm(), ranges);
}

#[test]
fn lengths_beyond_the_type_saturate() {
    let format = ScanFormat {
        first_step: 0,
        last_step: 0,
        ..FULL
    };
    let mut parser = parser(&format);
    let mut bytes = command(&format).to_vec();
    bytes.extend_from_slice(b"\n99b\n00000\nooo");
    bytes.extend_from_slice(&[codec::checksum(b"ooo"), b'\n', b'\n']);
    assert_eq!(
        parse(&mut parser, &bytes),
        [BEGUN, Event::Complete { device_ms: 0 }]
    );
    assert_eq!(parser.ranges_mm(), [u16::MAX]);
}

fn formats() -> impl Strategy<Value = ScanFormat> {
    (0u16..768, 0u16..768, 1u8..=99, 0u8..=9, any::<bool>()).prop_map(
        |(a, b, cluster, skip, two)| {
            let encoding = if two { Encoding::Two } else { Encoding::Three };
            ScanFormat {
                first_step: a.min(b),
                last_step: a.max(b),
                cluster,
                skip,
                encoding,
            }
        },
    )
}

proptest! {
    #[test]
    fn every_scan_survives_a_round_trip(
        format in formats(),
        device_ms in 0u32..1 << 24,
        values in proptest::collection::vec(0u16..4096, 768),
    ) {
        let ranges = &values[..format.beams()];
        let bytes = wire(&format, device_ms, ranges);
        prop_assert_eq!(bytes.len(), format.wire_bytes());
        let mut parser = parser(&format);
        let complete = Event::Complete { device_ms };
        prop_assert_eq!(parse(&mut parser, &bytes), [BEGUN, complete]);
        prop_assert_eq!(parser.ranges_mm(), ranges);
    }

    #[test]
    fn arbitrary_bytes_never_panic_and_hide_one_scan_at_most(
        rubbish in proptest::collection::vec(any::<u8>(), 0..600),
        cut in 0usize..2200,
    ) {
        let scan = wire(&FULL, 5, &ramp(&FULL));
        // Without its end, rubbish and the first line of a scan may be a line of data together, whose checksum is right by chance.
        for between in [&b"\n"[..], &scan] {
            let mut parser = parser(&FULL);
            parse(&mut parser, &scan[..cut.min(scan.len())]);
            parse(&mut parser, &rubbish);
            parse(&mut parser, between);
            let events = parse(&mut parser, &scan);
            prop_assert_eq!(events.last(), Some(&Event::Complete { device_ms: 5 }), "{:?}", events);
            prop_assert_eq!(parser.ranges_mm(), ramp(&FULL));
        }
    }
}
