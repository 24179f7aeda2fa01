//! A line of SubDevices behind one port of a MainDevice.
//!
//! Pure: frames and times go in, frames come out; nothing here waits, sends or reads a clock. Whoever carries the
//! frames calls [`Segment::process_frame`] (or [`Segment::process_payload`] when there is no Ethernet header), sends
//! the reply, and then calls [`Segment::cycle`], also when no frame comes: at least every 5 ms, since watchdogs and
//! the simulated mechanics run there.
//!
//! A frame passes every SubDevice in order, and each carries out every datagram in order, as on the wire.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use super::faults::{Action, FaultHandle, FramePlan};
use super::frame::{self, FrameError};
use super::subdevice::SubDevice;

/// Time from one SubDevice to the next.
const HOP_NS: u64 = 500;

/// What is to be sent back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reply {
    /// Bytes of the frame to send.
    pub length: usize,
    /// How long to hold it back.
    pub delay: Duration,
    /// How often to send it.
    pub copies: u32,
    /// Another protocol's frame goes before it.
    pub foreign_before: bool,
}

/// What a segment has seen.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Frames that arrived, of any kind.
    pub frames: u64,
    /// Datagrams carried out.
    pub datagrams: u64,
    /// Frames with a broken structure.
    pub malformed: u64,
    /// Frames of other protocols.
    pub foreign: u64,
    /// Frames or replies lost on purpose.
    pub lost: u64,
    /// Process data watchdogs that took a SubDevice out of OP.
    pub watchdog_trips: u64,
    /// Longest time between two calls of the segment: a starved simulator shows here, so that it is not mistaken for a
    /// fault of the MainDevice.
    pub longest_gap_ns: u64,
    /// AL status register of every SubDevice.
    pub al_status: Vec<u16>,
    /// AL status code of every SubDevice.
    pub al_status_code: Vec<u16>,
}

/// Reads a segment's statistics from any thread.
#[derive(Debug, Clone, Default)]
pub struct StatisticsHandle(Arc<Mutex<Statistics>>);

impl StatisticsHandle {
    /// The statistics as they are now.
    #[must_use]
    pub fn snapshot(&self) -> Statistics {
        self.with(|statistics| statistics.clone())
    }

    /// Resets the longest gap, for instance after a warm-up.
    pub fn reset_longest_gap(&self) {
        self.with(|statistics| statistics.longest_gap_ns = 0);
    }

    fn with<R>(&self, use_them: impl FnOnce(&mut Statistics) -> R) -> R {
        use_them(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// A line of SubDevices.
pub struct Segment {
    subdevices: Vec<SubDevice>,
    connected: Vec<bool>,
    faults: FaultHandle,
    statistics: StatisticsHandle,
    actions: Vec<Action>,
    corruption: usize,
    last_call_ns: Option<u64>,
}

impl Segment {
    /// A line of these SubDevices, the nearest first.
    #[must_use]
    pub fn new(subdevices: Vec<SubDevice>) -> Segment {
        let mut segment = Segment {
            connected: vec![true; subdevices.len()],
            subdevices,
            faults: FaultHandle::default(),
            statistics: StatisticsHandle::default(),
            actions: Vec::new(),
            corruption: 0,
            last_call_ns: None,
        };
        segment.update_links();
        segment.update_statistics();
        segment
    }

    /// Injects faults.
    #[must_use]
    pub fn faults(&self) -> FaultHandle {
        self.faults.clone()
    }

    /// Tells what the segment has seen.
    #[must_use]
    pub fn statistics(&self) -> StatisticsHandle {
        self.statistics.clone()
    }

    /// The SubDevices, the nearest first.
    #[must_use]
    pub fn subdevices(&self) -> &[SubDevice] {
        &self.subdevices
    }

    /// Carries out an Ethernet frame in place. `None`: nothing comes back.
    pub fn process_frame(&mut self, frame: &mut [u8], now_ns: u64) -> Option<Reply> {
        let plan = self.arrive(now_ns)?;
        let result = frame::ethernet_payload(frame)
            .and_then(|payload| self.carry_out(payload, plan, now_ns));
        if !self.answers(result) {
            return None;
        }
        frame::mark_processed(frame);
        self.reply(frame, frame::ETHERNET_HEADER, plan)
    }

    /// Carries out the payload of an EtherCAT frame (EtherCAT header and datagrams) in place.
    pub fn process_payload(&mut self, payload: &mut [u8], now_ns: u64) -> Option<Reply> {
        let plan = self.arrive(now_ns)?;
        let result = self.carry_out(payload, plan, now_ns);
        if !self.answers(result) {
            return None;
        }
        self.reply(payload, 0, plan)
    }

    /// Everything that goes on beside the frames.
    pub fn cycle(&mut self, now_ns: u64) {
        self.note_gap(now_ns);
        self.take_actions(now_ns);
        for subdevice in &mut self.subdevices {
            subdevice.cycle(now_ns);
        }
        self.update_statistics();
    }

    /// Carries out the faults that were asked for.
    fn take_actions(&mut self, now_ns: u64) {
        let mut actions = std::mem::take(&mut self.actions);
        self.faults.take_actions(now_ns, &mut actions);
        for action in actions.drain(..) {
            self.act(action, now_ns);
        }
        self.actions = actions;
    }

    fn arrive(&mut self, now_ns: u64) -> Option<FramePlan> {
        self.note_gap(now_ns);
        self.take_actions(now_ns);
        let plan = self.faults.plan(now_ns);
        self.statistics.with(|s| {
            s.frames += 1;
            s.lost += u64::from(plan.lost);
        });
        (!plan.lost).then_some(plan)
    }

    fn carry_out(
        &mut self,
        payload: &mut [u8],
        plan: FramePlan,
        now_ns: u64,
    ) -> Result<usize, FrameError> {
        let datagrams = frame::check(payload)?;
        let reached = self.reached();
        for (i, subdevice) in self.subdevices.iter_mut().take(reached).enumerate() {
            let there = HOP_NS * i as u64;
            let back = HOP_NS * (2 * reached - 2 - i) as u64;
            subdevice.begin_frame(now_ns + there, now_ns + back);
            subdevice
                .esc()
                .withhold_process_data(plan.process_data_withheld);
            frame::for_each_datagram(payload, |mut datagram| subdevice.execute(&mut datagram));
        }
        Ok(datagrams)
    }

    /// Counts what became of a frame and tells whether anything comes back.
    fn answers(&mut self, result: Result<usize, FrameError>) -> bool {
        self.statistics.with(|s| match result {
            Ok(datagrams) => s.datagrams += datagrams as u64,
            Err(FrameError::Foreign) => s.foreign += 1,
            Err(FrameError::TooShort { .. }) => s.malformed += 1,
        });
        let reached = self.reached();
        let Some(first) = self.subdevices.first_mut().filter(|_| reached > 0) else {
            return false;
        };
        match result {
            Ok(_) => true,
            Err(FrameError::Foreign) => first.esc().forwards_foreign_frames(),
            Err(FrameError::TooShort { .. }) => {
                first.esc().count_malformed();
                false
            }
        }
    }

    fn reply(&mut self, frame: &mut [u8], payload_at: usize, plan: FramePlan) -> Option<Reply> {
        if plan.reply_lost {
            self.statistics.with(|s| s.lost += 1);
            return None;
        }
        let length = if plan.corrupted {
            self.corrupt(frame, payload_at)
        } else {
            frame.len()
        };
        let copies = if plan.duplicated { 2 } else { 1 };
        Some(Reply {
            length,
            delay: plan.delay,
            copies,
            foreign_before: plan.foreign_before,
        })
    }

    /// Breaks the frame's structure, each time in another way; returns the new length.
    fn corrupt(&mut self, frame: &mut [u8], payload_at: usize) -> usize {
        self.corruption += 1;
        let length = frame.len();
        let payload = &mut frame[payload_at.min(length)..];
        let header = frame::ETHERCAT_HEADER;
        match self.corruption % 4 {
            1 => return payload_at + payload.len() / 2,
            // Command and index of the first datagram.
            2 => payload
                .iter_mut()
                .skip(header)
                .take(2)
                .for_each(|byte| *byte ^= 0x55),
            // Length of the first datagram.
            3 => payload
                .iter_mut()
                .skip(header + 6)
                .take(1)
                .for_each(|byte| *byte = byte.wrapping_add(1)),
            // Working counters.
            _ => frame::for_each_datagram(payload, |mut datagram| datagram.count(0x5A5A)),
        }
        length
    }

    /// SubDevices that a frame reaches: those before the first broken cable or dead SubDevice.
    fn reached(&self) -> usize {
        let alive = self.connected.iter().zip(&self.subdevices);
        alive
            .take_while(|(connected, subdevice)| **connected && subdevice.is_powered())
            .count()
    }

    fn act(&mut self, action: Action, now_ns: u64) {
        let position = match action {
            Action::Fall(position, ..) | Action::Reset(position) => position,
            Action::Connected(position, _)
            | Action::Powered(position, _)
            | Action::ClockStopped(position, _)
            | Action::WatchdogMissing(position) => position,
        };
        let Some(subdevice) = self.subdevices.get_mut(position) else {
            return;
        };
        match action {
            Action::Fall(_, state, code) => subdevice.fall(state, code),
            Action::Reset(_) => subdevice.reset(now_ns),
            Action::Connected(_, connected) => self.connected[position] = connected,
            Action::Powered(_, powered) => subdevice.set_powered(powered, now_ns),
            Action::ClockStopped(_, stopped) => subdevice.esc().set_clock_stopped(stopped, now_ns),
            Action::WatchdogMissing(_) => subdevice.esc().have_no_watchdog(),
        }
        self.update_links();
    }

    fn update_links(&mut self) {
        for i in 0..self.subdevices.len() {
            let next = self.connected.get(i + 1).copied().unwrap_or(false)
                && self
                    .subdevices
                    .get(i + 1)
                    .is_some_and(SubDevice::is_powered);
            let connected = self.connected[i];
            self.subdevices[i].esc().set_links([connected, next]);
        }
    }

    fn note_gap(&mut self, now_ns: u64) {
        let gap_ns = now_ns.saturating_sub(self.last_call_ns.unwrap_or(now_ns));
        self.last_call_ns = Some(now_ns);
        self.statistics
            .with(|s| s.longest_gap_ns = s.longest_gap_ns.max(gap_ns));
    }

    fn update_statistics(&mut self) {
        let subdevices = &self.subdevices;
        self.statistics.with(|s| {
            s.watchdog_trips = subdevices.iter().map(SubDevice::watchdog_trips).sum();
            s.al_status.clear();
            s.al_status.extend(
                subdevices
                    .iter()
                    .map(|subdevice| subdevice.al_status().register()),
            );
            s.al_status_code.clear();
            s.al_status_code.extend(
                subdevices
                    .iter()
                    .map(|subdevice| subdevice.al_status().code().0),
            );
        });
    }
}
