//! The poll loop against scripted links.

use super::*;
use crate::ethercat::transport::channel::Channel;
use ethercrab::Command;
use ethercrab::error::Error;
use std::collections::VecDeque;
use std::pin::pin;
use std::sync::{Arc, Mutex};

/// What becomes of one frame.
#[derive(Clone, Copy)]
enum Fate {
    Answered,
    Lost,
    /// Answered, but only when this many more frames have been sent.
    Late(usize),
    Twice,
    Echoed,
    Damaged,
    SendFails,
    ReceiveFails,
}

#[derive(Default)]
struct Script {
    fates: VecDeque<Fate>,
    sent: u64,
}

/// A segment of one SubDevice whose registers all hold the number of frames it has seen.
struct Scripted {
    script: Arc<Mutex<Script>>,
    arrived: VecDeque<Vec<u8>>,
    late: Vec<(usize, Vec<u8>)>,
    receive_fails: bool,
}

impl Scripted {
    fn answer(frame: &[u8], value: u8) -> Vec<u8> {
        let mut answer = frame.to_vec();
        answer[6] |= 0x02;
        answer[26] = value;
        answer[27] = 1; // working counter of a one-byte datagram
        answer
    }
}

impl Link for Scripted {
    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let mut script = self.script.lock().unwrap();
        for (wait, _) in &mut self.late {
            *wait -= 1;
        }
        let due = self.late.iter().position(|(wait, _)| *wait == 0);
        self.arrived.extend(due.map(|due| self.late.remove(due).1));
        let answer = Scripted::answer(frame, script.sent as u8);
        script.sent += 1;
        match script.fates.pop_front().unwrap_or(Fate::Answered) {
            Fate::Answered => self.arrived.push_back(answer),
            Fate::Lost => {}
            Fate::Late(frames) => self.late.push((frames, answer)),
            Fate::Twice => self.arrived.extend([answer.clone(), answer]),
            Fate::Echoed => self.arrived.push_back(frame.to_vec()),
            Fate::Damaged => self.arrived.push_back(answer[..20].to_vec()),
            Fate::SendFails => return Err(io::ErrorKind::NetworkDown.into()),
            Fate::ReceiveFails => self.receive_fails = true,
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], _deadline_ns: u64) -> io::Result<Option<usize>> {
        if std::mem::take(&mut self.receive_fails) {
            return Err(io::ErrorKind::ConnectionRefused.into());
        }
        // Nothing will ever arrive: no need to wait for the deadline.
        let Some(frame) = self.arrived.pop_front() else {
            return Ok(None);
        };
        buffer[..frame.len()].copy_from_slice(&frame);
        Ok(Some(frame.len()))
    }

    fn describe(&self) -> String {
        "script".to_owned()
    }
}

struct Bench {
    channel: Channel,
    pump: Pump,
    script: Arc<Mutex<Script>>,
}

impl Bench {
    fn new(fates: impl IntoIterator<Item = Fate>) -> Bench {
        let script = Arc::new(Mutex::new(Script {
            fates: fates.into_iter().collect(),
            sent: 0,
        }));
        let link = Scripted {
            script: script.clone(),
            arrived: VecDeque::new(),
            late: Vec::new(),
            receive_fails: false,
        };
        let channel = Channel::take().expect("few tests run at the same time");
        Bench {
            channel,
            pump: Pump::new(Box::new(link)),
            script,
        }
    }

    fn read(&mut self, resend: Option<Resend>) -> Result<u8, Stopped> {
        let (tx, rx, main_device) = self.channel.split();
        let future = pin!(async {
            Command::fprd(0x1000, 0x0130)
                .receive::<u8>(main_device)
                .await
        });
        let patience = Patience {
            deadline_ns: crate::monotonic_ns() + 1_000_000_000,
            resend,
        };
        self.pump
            .run((tx, rx), future, patience)
            .map(|answer: Result<u8, Error>| answer.unwrap())
    }
}

const NOW: Resend = Resend {
    after_ns: 0,
    attempts: 3,
};

#[test]
fn every_read_gets_the_answer_to_its_own_frame() {
    let mut bench = Bench::new([]);
    // More than the 256 datagram indices there are.
    for turn in 0..1000u64 {
        assert_eq!(bench.read(None).unwrap(), turn as u8);
    }
    assert_eq!(bench.pump.counters, BusCounters::default());
}

#[test]
fn a_thousand_lost_frames_exhaust_nothing() {
    let mut bench = Bench::new(std::iter::repeat_n(Fate::Lost, 1000));
    for _ in 0..1000 {
        assert!(matches!(bench.read(None), Err(Stopped::Deadline)));
    }
    assert_eq!(bench.read(None).unwrap(), 1000u16 as u8);
}

#[test]
fn late_answers_are_not_taken_for_the_current_one() {
    // 256 frames later, the datagram index is the same again.
    for frames in [1, 2, 8, 255, 256, 257] {
        let mut bench = Bench::new([Fate::Late(frames)]);
        assert!(matches!(bench.read(None), Err(Stopped::Deadline)));
        for turn in 1..=frames as u64 + 3 {
            assert_eq!(bench.read(None).unwrap(), turn as u8, "late by {frames}");
        }
        assert_eq!(bench.pump.counters.foreign_frames, 1, "late by {frames}");
    }
}

#[test]
fn duplicated_echoed_and_damaged_frames_are_counted_and_dropped() {
    let mut bench = Bench::new([
        Fate::Twice,
        Fate::Answered,
        Fate::Echoed,
        Fate::Damaged,
        Fate::Answered,
    ]);
    assert_eq!(bench.read(None).unwrap(), 0);
    assert_eq!(bench.read(None).unwrap(), 1);
    assert!(matches!(bench.read(None), Err(Stopped::Deadline)));
    assert!(matches!(bench.read(None), Err(Stopped::Deadline)));
    assert_eq!(bench.read(None).unwrap(), 4);
    let BusCounters {
        foreign_frames,
        echoed_frames,
        malformed_frames,
        ..
    } = bench.pump.counters;
    assert_eq!((foreign_frames, echoed_frames, malformed_frames), (1, 1, 1));
}

#[test]
fn a_frame_is_sent_again_as_often_as_allowed() {
    let mut bench = Bench::new([Fate::Lost, Fate::ReceiveFails, Fate::Answered]);
    assert_eq!(bench.read(Some(NOW)).unwrap(), 2);
    let mut bench = Bench::new([Fate::Lost; 3]);
    assert!(matches!(bench.read(Some(NOW)), Err(Stopped::Unanswered)));
    assert_eq!(bench.script.lock().unwrap().sent, 3);
    assert_eq!(bench.read(Some(NOW)).unwrap(), 3);
}

#[test]
fn what_the_link_says_is_handed_on_and_passes() {
    let mut bench = Bench::new([Fate::SendFails, Fate::ReceiveFails]);
    for expected in [io::ErrorKind::NetworkDown, io::ErrorKind::ConnectionRefused] {
        match bench.read(None) {
            Err(Stopped::Link(error)) => assert_eq!(error.kind(), expected),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(bench.read(None).unwrap(), 2);
    let mut bench = Bench::new([Fate::ReceiveFails; 3]);
    assert!(matches!(bench.read(Some(NOW)), Err(Stopped::Link(_))));
}

#[test]
fn a_future_that_waits_for_something_else_does_not_hang() {
    let mut bench = Bench::new([]);
    let (tx, rx, _) = bench.channel.split();
    let future = pin!(std::future::pending::<()>());
    let patience = Patience {
        deadline_ns: u64::MAX,
        resend: None,
    };
    assert!(matches!(
        bench.pump.run((tx, rx), future, patience),
        Err(Stopped::Stuck)
    ));
}

#[test]
fn a_frame_too_long_to_be_sealed_is_refused_and_freed() {
    let mut bench = Bench::new([]);
    for _ in 0..20 {
        let (tx, rx, main_device) = bench.channel.split();
        let future = pin!(async {
            Command::fprd(0x1000, 0)
                .receive_slice(main_device, 1470)
                .await
                .map(|_| ())
        });
        let patience = Patience {
            deadline_ns: u64::MAX,
            resend: None,
        };
        let outcome = bench.pump.run((tx, rx), future, patience);
        assert!(matches!(outcome, Ok(Err(Error::Pdu(_)))), "{outcome:?}");
    }
    assert_eq!(bench.read(None).unwrap(), 0);
}
