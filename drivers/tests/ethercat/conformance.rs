//! What every link must do, whatever carries its frames.

use crate::interfaces::{MAIN_DEVICE, SEGMENT, with_own_network};
use crate::support::{Mirror, SegmentLink, segment, served_over_udp};
use drivers::ethercat::{Link, RawLink, UdpLink};
use drivers::monotonic_ns;
use sim::ethercat::{ServeOptions, serve_raw};
use std::collections::VecDeque;
use std::io;

const ANSWER_US: u64 = 2_000_000;

/// A frame with one broadcast read of the SubDevices' type register.
fn frame(index: u8) -> [u8; 60] {
    let mut frame = [0; 60];
    frame[..6].fill(0xFF);
    frame[6..12].fill(0x10);
    frame[12..16].copy_from_slice(&[0x88, 0xA4, 13, 0x10]);
    frame[16..18].copy_from_slice(&[7, index]);
    frame[22] = 1;
    frame
}

/// The contract of [`Link`], on a link to a segment of one SubDevice.
fn conforms(link: &mut dyn Link) {
    let mut buffer = [0; 1514];
    let clock = link.clock();
    let in_us = |us: u64| clock.now_ns() + us * 1000;

    // Reaching the deadline is no error, and takes until the deadline; a deadline in the past takes no time.
    let deadline_ns = in_us(20_000);
    assert_eq!(link.receive(&mut buffer, deadline_ns).unwrap(), None);
    assert!(clock.now_ns() >= deadline_ns);
    assert_eq!(link.receive(&mut buffer, 0).unwrap(), None);

    // A frame comes back processed: locally-administered source, same index, working counter of one SubDevice.
    link.send(&frame(1)).unwrap();
    let length = link.receive(&mut buffer, in_us(ANSWER_US)).unwrap();
    assert!(length.is_some_and(|length| length >= 29), "{length:?}");
    assert_eq!(buffer[6] & 0x02, 0x02);
    assert_eq!((buffer[12], buffer[13]), (0x88, 0xA4));
    assert_eq!((buffer[17], buffer[27]), (1, 1));

    // Frames come back in the order in which they were sent, once each.
    for index in 2..10 {
        link.send(&frame(index)).unwrap();
    }
    for index in 2..10 {
        let length = link.receive(&mut buffer, in_us(ANSWER_US)).unwrap();
        assert!(length.is_some());
        assert_eq!((buffer[17], buffer[27]), (index, 1));
    }
    assert_eq!(link.receive(&mut buffer, in_us(1000)).unwrap(), None);

    // What has arrived is returned after the deadline too.
    link.send(&frame(10)).unwrap();
    clock.sleep_until(in_us(50_000));
    let mut arrived = None;
    for _ in 0..100 {
        arrived = link.receive(&mut buffer, 0).unwrap();
        if arrived.is_some() {
            break;
        }
        clock.sleep_until(in_us(10_000));
    }
    assert!(arrived.is_some());
    assert_eq!(buffer[17], 10);

    let name = link.describe();
    assert!(!name.is_empty() && name == link.describe());
}

/// Answers recorded from another link, given back for the same frames.
struct Replay {
    recorded: Vec<(Vec<u8>, Vec<u8>)>,
    arrived: VecDeque<Vec<u8>>,
}

impl Replay {
    /// Records the answers to these frames.
    fn of(link: &mut dyn Link, frames: impl IntoIterator<Item = [u8; 60]>) -> Replay {
        let clock = link.clock();
        let mut record = |frame: [u8; 60]| {
            let mut buffer = [0; 1514];
            link.send(&frame).unwrap();
            let deadline_ns = clock.now_ns() + ANSWER_US * 1000;
            let length = link.receive(&mut buffer, deadline_ns).unwrap();
            (frame.to_vec(), buffer[..length.unwrap()].to_vec())
        };
        Replay {
            recorded: frames.into_iter().map(&mut record).collect(),
            arrived: VecDeque::new(),
        }
    }
}

impl Link for Replay {
    fn send(&mut self, ethernet_frame: &[u8]) -> io::Result<()> {
        let answers = self
            .recorded
            .iter()
            .filter(|(sent, _)| sent == ethernet_frame);
        self.arrived
            .extend(answers.map(|(_, answer)| answer.clone()));
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], deadline_ns: u64) -> io::Result<Option<usize>> {
        let Some(frame) = self.arrived.pop_front() else {
            let left_ns = deadline_ns.saturating_sub(monotonic_ns());
            std::thread::sleep(std::time::Duration::from_nanos(left_ns));
            return Ok(None);
        };
        buffer[..frame.len()].copy_from_slice(&frame);
        Ok(Some(frame.len()))
    }

    fn describe(&self) -> String {
        "replay".to_owned()
    }
}

#[test]
fn a_simulated_link() {
    conforms(&mut SegmentLink::of([Mirror::default()]));
}

#[test]
fn a_replayed_link() {
    let mut recorded = SegmentLink::of([Mirror::default()]);
    conforms(&mut Replay::of(&mut recorded, (1..=10).map(frame)));
}

#[test]
fn a_udp_link() {
    let (_server, address, _) = served_over_udp(ServeOptions::default());
    conforms(&mut UdpLink::open(address).unwrap());
}

#[test]
fn a_raw_link() {
    with_own_network(|| {
        let segment = segment([Mirror::default()]);
        let _server = serve_raw(SEGMENT, segment, ServeOptions::default()).unwrap();
        conforms(&mut RawLink::open(MAIN_DEVICE).unwrap());
    });
}

#[test]
fn frames_that_nobody_takes_are_lost_and_those_after_them_arrive() {
    with_own_network(|| {
        let segment = segment([Mirror::default()]);
        let _server = serve_raw(SEGMENT, segment, ServeOptions::default()).unwrap();
        let mut link = RawLink::open(MAIN_DEVICE).unwrap();
        let mut buffer = [0; 1514];
        // Again and again, so that whatever holds them is gone through to its end and from its begin.
        for _ in 0..5 {
            let sent = 1000;
            for number in 0..sent {
                link.send(&frame(number as u8)).unwrap();
            }
            let mut received = 0u64;
            while link
                .receive(&mut buffer, monotonic_ns() + 100_000_000)
                .unwrap()
                .is_some()
            {
                // The first of them, in their order.
                assert!(received >= 100 || buffer[17] == received as u8);
                received += 1;
            }
            assert!((100..=sent).contains(&received), "{received}");
        }
        // A buffer that is too short gets the begin.
        link.send(&frame(1)).unwrap();
        let deadline_ns = monotonic_ns() + ANSWER_US * 1000;
        let length = link.receive(&mut buffer[..20], deadline_ns).unwrap();
        assert_eq!((length, buffer[17]), (Some(20), 1));
        conforms(&mut link);
    });
}

/// On a real bus with one SubDevice: `ETHERCAT_INTERFACE=eth0 cargo test -p drivers -- --ignored a_real_link`.
#[test]
#[ignore = "needs a real SubDevice"]
fn a_real_link() {
    let interface =
        std::env::var("ETHERCAT_INTERFACE").expect("ETHERCAT_INTERFACE names the interface");
    conforms(&mut RawLink::open(&interface).unwrap());
}
