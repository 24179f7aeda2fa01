//! A MainDevice made of single datagrams, and what it finds.

mod commands;
mod faults;
mod process_data;
mod random;
mod registers;

use super::eeprom::ReadSize;
use super::frame::for_each_datagram;
use super::frame::tests::payload;
use super::{Segment, StatisticsHandle, SubDevice};
use crate::kelo::{Kelo, KeloOptions};
use crate::plant::TestStand;

pub(super) const MS: u64 = 1_000_000;

/// Commands, as on the wire.
pub(super) mod cmd {
    pub const APRD: u8 = 1;
    pub const APWR: u8 = 2;
    pub const APRW: u8 = 3;
    pub const FPRD: u8 = 4;
    pub const FPWR: u8 = 5;
    pub const FPRW: u8 = 6;
    pub const BRD: u8 = 7;
    pub const BWR: u8 = 8;
    pub const BRW: u8 = 9;
    pub const LRD: u8 = 10;
    pub const LWR: u8 = 11;
    pub const LRW: u8 = 12;
    pub const ARMW: u8 = 13;
    pub const FRMW: u8 = 14;
}

pub(super) fn address(device: u16, offset: u16) -> u32 {
    u32::from(device) | u32::from(offset) << 16
}

/// What came back in one datagram.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Answer {
    pub counter: u16,
    pub device: u16,
    pub data: Vec<u8>,
}

/// A segment of KELO drives, and a clock that only moves when told.
pub(super) struct Bench {
    pub segment: Segment,
    pub statistics: StatisticsHandle,
    pub now_ns: u64,
}

impl Bench {
    pub fn new(drives: usize) -> Bench {
        let kelo = || {
            Box::new(Kelo::new(
                Box::new(TestStand::new()),
                KeloOptions::default(),
            ))
        };
        let segment = Segment::new(
            (0..drives)
                .map(|_| SubDevice::new(kelo(), ReadSize::Eight))
                .collect(),
        );
        Bench {
            statistics: segment.statistics(),
            segment,
            now_ns: 1000 * MS,
        }
    }

    /// Sends one frame of datagrams; `None` if nothing comes back.
    pub fn frame(&mut self, datagrams: &[(u8, u32, &[u8])]) -> Option<Vec<Answer>> {
        let mut bytes = payload(datagrams);
        let reply = self.segment.process_payload(&mut bytes, self.now_ns);
        self.segment.cycle(self.now_ns);
        let length = reply?.length;
        let mut answers = Vec::new();
        for_each_datagram(&mut bytes[..length], |d| {
            let (counter, device) = (d.working_counter(), d.device_address());
            answers.push(Answer {
                counter,
                device,
                data: d.data.to_vec(),
            });
        });
        Some(answers)
    }

    /// Sends one datagram.
    pub fn send(&mut self, command: u8, address: u32, data: &[u8]) -> Answer {
        self.frame(&[(command, address, data)])
            .expect("a reply")
            .remove(0)
    }

    /// Reads a register of the first SubDevice.
    pub fn read<const N: usize>(&mut self, offset: u16) -> [u8; N] {
        let answer = self.send(cmd::APRD, address(0, offset), &[0; N]);
        assert_eq!(answer.counter, 1, "read of {offset:#06x}");
        answer.data.try_into().unwrap()
    }

    pub fn read_u16(&mut self, offset: u16) -> u16 {
        u16::from_le_bytes(self.read(offset))
    }

    /// Writes a register of the first SubDevice.
    pub fn write(&mut self, offset: u16, data: &[u8]) {
        assert_eq!(
            self.send(cmd::APWR, address(0, offset), data).counter,
            1,
            "write of {offset:#06x}"
        );
    }

    /// AL status and its code.
    pub fn al(&mut self) -> (u16, u16) {
        (self.read_u16(0x0130), self.read_u16(0x0134))
    }

    /// Requests a state and returns AL status and code.
    pub fn request(&mut self, control: u8) -> (u16, u16) {
        self.write(0x0120, &[control, 0]);
        self.al()
    }

    /// Time passes with the segment's own cycles only.
    pub fn wait_ms(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds {
            self.now_ns += MS;
            self.segment.cycle(self.now_ns);
        }
    }

    /// Sets up SyncManagers and FMMUs: outputs at logical 0x10000, inputs behind them.
    pub fn configure(&mut self, outputs_control: u8) {
        self.write(0x0810, &[0x00, 0x11, 36, 0, outputs_control, 0, 1, 0]);
        self.write(0x0818, &[0x00, 0x12, 172, 0, 0x20, 0, 1, 0]);
        self.write(
            0x0600,
            &[0, 0, 1, 0, 36, 0, 0, 7, 0x00, 0x11, 0, 2, 1, 0, 0, 0],
        );
        self.write(
            0x0610,
            &[36, 0, 1, 0, 172, 0, 0, 7, 0x00, 0x12, 0, 1, 1, 0, 0, 0],
        );
    }

    /// Brings the first SubDevice to OP.
    pub fn reach_op(&mut self, outputs_control: u8) {
        assert_eq!(self.request(0x11), (1, 0));
        assert_eq!(self.request(2), (2, 0));
        self.configure(outputs_control);
        assert_eq!(self.request(4), (4, 0));
        assert_eq!(self.request(8), (8, 0));
    }

    /// Exchanges process data once: both motors on in velocity mode at this speed.
    pub fn drive(&mut self, speed_rad_s: f32) -> Answer {
        let mut data = [0; 36 + 172];
        data[0] = 0x0B;
        let floats = [-speed_rad_s, speed_rad_s, 20.0, -20.0, 20.0, -20.0];
        for (i, value) in floats.into_iter().enumerate() {
            data[4 + 4 * i..8 + 4 * i].copy_from_slice(&f32::to_le_bytes(value));
        }
        self.send(cmd::LRW, 0x1_0000, &data)
    }

    /// Exchanges process data every millisecond.
    pub fn drive_for_ms(&mut self, milliseconds: u64, speed_rad_s: f32) -> Answer {
        let mut last = self.drive(speed_rad_s);
        for _ in 0..milliseconds {
            self.now_ns += MS;
            last = self.drive(speed_rad_s);
        }
        last
    }
}

/// A field of the inputs in an exchange's answer.
pub(super) fn input_f32(answer: &Answer, at: usize) -> f32 {
    f32::from_le_bytes(answer.data[36 + at..40 + at].try_into().unwrap())
}

pub(super) fn input_u64(answer: &Answer, at: usize) -> u64 {
    u64::from_le_bytes(answer.data[36 + at..44 + at].try_into().unwrap())
}
