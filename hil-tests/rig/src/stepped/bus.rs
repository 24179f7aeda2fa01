//! A robot's bus in memory: the simulated segment with its drive, and links to it.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use drivers::Clock;
use drivers::ethercat::{Link, refused};
use onboard::activities::drive::OpenLink;
use rustix::io::Errno;
use sim::ethercat::{FaultHandle, Segment};
use sim::kelo::{DriveHandle, SimulatedDrive};
use sim::world::Random;

use super::thread::ThreadClock;
use super::work::of_a_device;

/// From sending a frame to its return: about 200 bytes at 100 Mbit/s, there and back, and two network controllers.
const ROUND_TRIP_NS: u64 = 50_000;
/// Frames that wait to be received; those beyond are lost.
const MAX_REPLIES: usize = 64;
/// Which frames get lost comes from the seed.
const LOSS_STREAM: u64 = 0x4652_414D;
/// A frame of another protocol: its EtherType is of IPv4.
const FOREIGN: [u8; 60] = {
    let mut frame = [0; 60];
    (frame[12], frame[13]) = (0x08, 0x00);
    frame
};

/// A bus; it outlives the processes of its robot.
#[derive(Clone)]
pub(super) struct Bus {
    wire: Arc<Mutex<Wire>>,
    /// Faults of the bus,
    pub(super) faults: FaultHandle,
    /// and of the drive.
    pub(super) drive: DriveHandle,
}

struct Wire {
    segment: Segment,
    /// Frames on their way back, with the times of their arrival.
    replies: VecDeque<(u64, Vec<u8>)>,
    /// Frames that have been received, to be used again.
    spare: Vec<Vec<u8>>,
    served_ns: u64,
    /// Share of frames that get lost.
    lost_share: f64,
    /// Share of frames that the network interface refuses, for want of room.
    refused_share: f64,
    /// There is no network interface.
    interface_gone: bool,
    random: Random,
}

impl Bus {
    /// Which frames get lost is drawn from `seed`.
    pub(super) fn new(drive: SimulatedDrive, seed: u64) -> Self {
        let SimulatedDrive {
            segment,
            faults,
            drive,
            ..
        } = drive;
        let wire = Wire {
            segment,
            replies: VecDeque::new(),
            spare: Vec::new(),
            served_ns: 0,
            lost_share: 0.0,
            refused_share: 0.0,
            interface_gone: false,
            random: Random::new(seed, LOSS_STREAM),
        };
        Self {
            wire: Arc::new(Mutex::new(wire)),
            faults,
            drive,
        }
    }

    /// What goes on in a step besides frames: watchdogs, and the wheels.
    pub(super) fn cycle(&self, now_ns: u64) {
        let mut wire = lock(&self.wire);
        if wire.served_ns < now_ns {
            wire.served_ns = now_ns;
            wire.segment.cycle(now_ns);
        }
    }

    /// From now on this share of frames gets lost.
    pub(super) fn lose(&self, share: f64) {
        lock(&self.wire).lost_share = share;
    }

    /// From now on its network interface refuses this share of frames.
    pub(super) fn refuse(&self, share: f64) {
        lock(&self.wire).refused_share = share;
    }

    /// From now on there is no network interface, or there is.
    pub(super) fn lose_interface(&self, gone: bool) {
        lock(&self.wire).interface_gone = gone;
    }

    /// How a robot's process opens its link.
    pub(super) fn opener(&self, clock: &Arc<ThreadClock>) -> OpenLink {
        let (wire, clock) = (Arc::clone(&self.wire), Arc::clone(clock));
        Box::new(move || {
            let mut inside = lock(&wire);
            if inside.interface_gone {
                return Err("there is no such interface".to_owned());
            }
            inside.replies.clear();
            drop(inside);
            Ok(Box::new(MemoryLink {
                wire: Arc::clone(&wire),
                clock: Arc::clone(&clock),
            }))
        })
    }
}

fn lock(wire: &Mutex<Wire>) -> MutexGuard<'_, Wire> {
    wire.lock().unwrap_or_else(PoisonError::into_inner)
}

struct MemoryLink {
    wire: Arc<Mutex<Wire>>,
    clock: Arc<ThreadClock>,
}

impl MemoryLink {
    /// Puts a frame through the segment.
    fn pass(&self, ethernet_frame: &[u8]) -> io::Result<()> {
        let now_ns = self.clock.world_ns();
        let wire = &mut *lock(&self.wire);
        if wire.interface_gone {
            return refused(Errno::NETDOWN.into());
        }
        if wire.refused_share > 0.0 && wire.random.unit() < wire.refused_share {
            return refused(Errno::NOBUFS.into());
        }
        let mut frame = wire.spare.pop().unwrap_or_default();
        frame.clear();
        frame.extend_from_slice(ethernet_frame);
        let lost = wire.lost_share > 0.0 && wire.random.unit() < wire.lost_share;
        // On the way back as often as on the way there: the drive has done then what it was told.
        let is_there = !lost || wire.random.unit() < 0.5;
        let reply = { is_there }
            .then(|| wire.segment.process_frame(&mut frame, now_ns))
            .flatten()
            .filter(|_| !lost);
        wire.served_ns = now_ns;
        wire.segment.cycle(now_ns);
        let Some(reply) = reply else {
            wire.spare.push(frame);
            return Ok(());
        };
        frame.truncate(reply.length);
        let delay_ns = u64::try_from(reply.delay.as_nanos()).unwrap_or(u64::MAX);
        let arrives_ns = (now_ns + ROUND_TRIP_NS).saturating_add(delay_ns);
        if reply.foreign_before {
            wire.add(arrives_ns, FOREIGN.to_vec());
        }
        for _ in 1..reply.copies {
            wire.add(arrives_ns, frame.clone());
        }
        wire.add(arrives_ns, frame);
        Ok(())
    }
}

impl Link for MemoryLink {
    fn send(&mut self, ethernet_frame: &[u8]) -> io::Result<()> {
        of_a_device(|| self.pass(ethernet_frame))
    }

    fn receive(&mut self, buffer: &mut [u8], deadline_ns: u64) -> io::Result<Option<usize>> {
        loop {
            if lock(&self.wire).interface_gone {
                return Err(Errno::NETDOWN.into());
            }
            // Not held while it sleeps.
            let arrives_ns = match lock(&self.wire).take(buffer, self.clock.world_ns()) {
                Ok(length) => return Ok(Some(length)),
                Err(arrives_ns) => arrives_ns,
            };
            if self.clock.now_ns() >= deadline_ns {
                return Ok(None);
            }
            self.clock.sleep_until_world(arrives_ns, deadline_ns);
        }
    }

    fn clock(&self) -> Arc<dyn Clock> {
        Arc::clone(&self.clock) as _
    }

    fn describe(&self) -> String {
        "a segment in memory".to_owned()
    }
}

impl Wire {
    /// Takes the frame that has arrived, and returns its length; or else says when the next one arrives.
    fn take(&mut self, buffer: &mut [u8], now_ns: u64) -> Result<usize, Option<u64>> {
        let next_ns = self.replies.front().map(|(arrives_ns, _)| *arrives_ns);
        if next_ns.is_none_or(|arrives_ns| arrives_ns > now_ns) {
            return Err(next_ns);
        }
        let (_, frame) = self.replies.pop_front().ok_or(None)?;
        let length = frame.len().min(buffer.len());
        buffer[..length].copy_from_slice(&frame[..length]);
        self.spare.push(frame);
        Ok(length)
    }

    /// Puts a frame on its way back, behind those that arrive before it.
    fn add(&mut self, arrives_ns: u64, frame: Vec<u8>) {
        if self.replies.len() < MAX_REPLIES {
            let behind = |(earlier_ns, _): &(u64, Vec<u8>)| *earlier_ns <= arrives_ns;
            let place = self.replies.partition_point(behind);
            self.replies.insert(place, (arrives_ns, frame));
        }
    }
}
