//! A SubDevice like the KELO drive, a link that needs no network, and what every test needs.

use drivers::ethercat::{BringUpOptions, Expectation, Link};
use drivers::{Clock, kelo, monotonic_ns};
use sim::ethercat::eeprom::ReadSize;
use sim::ethercat::sii::{EntryType, Identity, Pdo, Sii, SyncManagerUse};
use sim::ethercat::sync_manager::SyncManager;
use sim::ethercat::{
    Application, Cycle, FaultHandle, Segment, ServeOptions, ServerHandle, StatisticsHandle,
    SubDevice, serve_udp,
};
use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

pub const VENDOR: u32 = 0x0000_0000;

/// A SubDevice with the drive's process-data layout that answers every exchange with what it was told.
///
/// Inputs: the 36 bytes of the last valid outputs, then zeros, and in the last byte how often outputs were written.
#[derive(Clone)]
pub struct Mirror {
    pub identity: Identity,
    pub outputs: Vec<EntryType>,
    pub inputs: Vec<EntryType>,
    pub outputs_control: u8,
    /// Length of the inputs' SyncManager that the application insists on; by default what the PDO says.
    pub inputs_length: Option<u16>,
    /// Since power-on.
    pub writes: u8,
}

impl Default for Mirror {
    fn default() -> Mirror {
        use EntryType::{F32, U16, U64};
        let mut outputs = vec![U16, U16];
        outputs.extend([F32; 6]);
        outputs.push(U64);
        let mut inputs = vec![U16, U16, U64, U64];
        inputs.extend([F32; 27]);
        inputs.push(U64);
        inputs.extend([F32; 9]);
        Mirror {
            identity: Identity {
                vendor_id: VENDOR,
                product_code: 0x0170_5011,
                revision: 7,
                serial: 42,
            },
            outputs,
            inputs,
            outputs_control: 0x64,
            inputs_length: None,
            writes: 0,
        }
    }
}

impl Application for Mirror {
    fn sii(&self) -> Sii {
        let pdo = |index, entry_index, sync_manager, entries: &Vec<EntryType>| Pdo {
            index,
            entry_index,
            sync_manager,
            entries: entries.clone(),
        };
        let outputs = pdo(0x1600, 0x7000, 0, &self.outputs);
        let inputs = pdo(0x1A00, 0x6000, 1, &self.inputs);
        let sync_manager = |start, length_bytes, control| SyncManager {
            start,
            length_bytes,
            control,
            active: true,
        };
        let outputs_sm = sync_manager(0x1100, outputs.bytes() as u16, self.outputs_control);
        let inputs_length = self.inputs_length.unwrap_or(inputs.bytes() as u16);
        let inputs_sm = sync_manager(0x1400, inputs_length, 0x20);
        Sii {
            identity: self.identity,
            alias: 0,
            name: "MIRROR".to_owned(),
            group: "tests".to_owned(),
            description: "A SubDevice for tests".to_owned(),
            sync_managers: vec![
                (outputs_sm, SyncManagerUse::Outputs),
                (inputs_sm, SyncManagerUse::Inputs),
            ],
            outputs,
            inputs,
        }
    }

    fn cycle(&mut self, cycle: Cycle<'_>) {
        self.writes = self.writes.wrapping_add(u8::from(cycle.outputs_are_new));
        cycle.inputs.fill(0);
        if let Some(outputs) = cycle.outputs {
            let length = outputs.len().min(cycle.inputs.len());
            cycle.inputs[..length].copy_from_slice(&outputs[..length]);
        }
        if let Some(last) = cycle.inputs.last_mut() {
            *last = self.writes;
        }
    }
}

pub fn segment(applications: impl IntoIterator<Item = Mirror>) -> Segment {
    let new = |application| SubDevice::new(Box::new(application), ReadSize::Eight);
    Segment::new(applications.into_iter().map(new).collect())
}

/// A segment of one mirror, served over UDP by a thread of its own.
pub fn served_over_udp(options: ServeOptions) -> (ServerHandle, SocketAddr, FaultHandle) {
    let segment = segment([Mirror::default()]);
    let faults = segment.faults();
    let server = serve_udp("127.0.0.1:0".parse().unwrap(), segment, options).unwrap();
    let address = server.local_addr().unwrap();
    (server, address, faults)
}

/// A segment in the same thread, with a clock of its own. Frames are processed when sent; replies are held until their time.
#[derive(Clone)]
pub struct SegmentLink {
    inner: Arc<Mutex<Wire>>,
    clock: Arc<WaitingClock>,
    pub faults: FaultHandle,
    pub statistics: StatisticsHandle,
}

struct Wire {
    segment: Segment,
    /// Replies under way, with the time they arrive, the next one first.
    replies: VecDeque<(u64, Vec<u8>)>,
    sent: u64,
}

/// A clock that goes on only while somebody waits: however late the test's thread is, nothing comes late.
#[derive(Debug)]
struct WaitingClock(AtomicU64);

/// A computer that has run for a while.
const START_NS: u64 = 1_000_000_000_000;
/// From sending a frame to its return.
const ROUND_TRIP_NS: u64 = 10_000;
/// How often the segment's own side runs, as its server has it.
const CYCLE_NS: u64 = 1_000_000;

impl Clock for WaitingClock {
    fn now_ns(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    fn sleep_until(&self, at_ns: u64) {
        self.0.fetch_max(at_ns, Ordering::Relaxed);
    }

    /// Nobody else runs who could change the word.
    fn wait_on(&self, _word: &AtomicU32, _seen: u32, until_ns: u64) {
        self.sleep_until(until_ns);
    }
}

impl SegmentLink {
    pub fn new(segment: Segment) -> SegmentLink {
        let (faults, statistics) = (segment.faults(), segment.statistics());
        let wire = Wire {
            segment,
            replies: VecDeque::new(),
            sent: 0,
        };
        SegmentLink {
            inner: Arc::new(Mutex::new(wire)),
            clock: Arc::new(WaitingClock(AtomicU64::new(START_NS))),
            faults,
            statistics,
        }
    }

    pub fn of(applications: impl IntoIterator<Item = Mirror>) -> SegmentLink {
        SegmentLink::new(segment(applications))
    }

    pub fn boxed(&self) -> Box<dyn Link> {
        Box::new(self.clone())
    }

    /// What time it is on the link's clock.
    pub fn now_ns(&self) -> u64 {
        self.clock.now_ns()
    }

    /// A time to come on the link's clock.
    pub fn in_us(&self, us: u64) -> u64 {
        self.now_ns() + us * 1000
    }

    /// Lets time pass.
    pub fn pass(&self, time: Duration) {
        self.pass_until(self.now_ns() + time.as_nanos() as u64);
    }

    /// Lets the segment's own side run, as its server's thread would.
    pub fn cycle(&self) {
        self.pass(Duration::ZERO);
    }

    fn pass_until(&self, at_ns: u64) {
        let mut wire = self.inner.lock().unwrap();
        loop {
            let now_ns = self.now_ns();
            wire.segment.cycle(now_ns);
            if now_ns >= at_ns {
                return;
            }
            self.clock.sleep_until(at_ns.min(now_ns + CYCLE_NS));
        }
    }

    /// Somebody else on the wire writes a register of the first SubDevice.
    pub fn write_register(&self, register: u16, value: u16) {
        const APWR: u8 = 2;
        // EtherCAT header; then the datagram: command, index, position, register, length, interrupts, data, working counter.
        let mut payload = vec![14, 0x10, APWR, 0, 0, 0];
        payload.extend(register.to_le_bytes());
        payload.extend([2, 0, 0, 0]);
        payload.extend(value.to_le_bytes());
        payload.extend([0, 0]);
        let mut wire = self.inner.lock().unwrap();
        let now_ns = self.now_ns();
        wire.segment.process_payload(&mut payload, now_ns);
        assert_eq!(payload[14..], [1, 0], "written");
        wire.segment.cycle(now_ns);
    }

    pub fn frames_sent(&self) -> u64 {
        self.inner.lock().unwrap().sent
    }
}

impl Link for SegmentLink {
    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let mut wire = self.inner.lock().unwrap();
        let now_ns = self.now_ns();
        wire.sent += 1;
        let mut bytes = frame.to_vec();
        if let Some(reply) = wire.segment.process_frame(&mut bytes, now_ns) {
            bytes.truncate(reply.length);
            let arrives_ns = now_ns + ROUND_TRIP_NS + reply.delay.as_nanos() as u64;
            let before = |(earlier_ns, _): &(u64, Vec<u8>)| *earlier_ns <= arrives_ns;
            let place = wire.replies.partition_point(before);
            for _ in 0..reply.copies {
                wire.replies.insert(place, (arrives_ns, bytes.clone()));
            }
        }
        wire.segment.cycle(now_ns);
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], deadline_ns: u64) -> io::Result<Option<usize>> {
        let wire = self.inner.lock().unwrap();
        let next_ns = wire.replies.front().map(|(arrives_ns, _)| *arrives_ns);
        drop(wire);
        self.pass_until(next_ns.unwrap_or(deadline_ns).min(deadline_ns));
        if next_ns.is_none_or(|arrives_ns| arrives_ns > self.now_ns()) {
            return Ok(None);
        }
        let (_, frame) = self.inner.lock().unwrap().replies.pop_front().unwrap();
        buffer[..frame.len()].copy_from_slice(&frame);
        Ok(Some(frame.len()))
    }

    fn clock(&self) -> Arc<dyn Clock> {
        Arc::clone(&self.clock) as _
    }

    fn describe(&self) -> String {
        "simulated segment".to_owned()
    }
}

pub fn expectation() -> Expectation {
    Expectation {
        vendor_id: VENDOR,
        product_codes: kelo::PRODUCT_CODES.to_vec(),
        outputs_bytes: kelo::OUTPUTS_BYTES,
        inputs_bytes: kelo::INPUTS_BYTES,
        // Generous, so that a busy machine trips nothing: close to the longest that there is.
        watchdog_ms: 6000,
    }
}

/// Impatient, for tests that expect a failure.
pub fn impatient() -> BringUpOptions {
    BringUpOptions {
        timeout: Duration::from_millis(300),
        frame_timeout: Duration::from_millis(5),
        frame_attempts: 4,
        ..BringUpOptions::default()
    }
}

/// Patient, for segments with a thread of their own: however late that one is, no frame is sent twice.
pub fn patient() -> BringUpOptions {
    BringUpOptions {
        timeout: Duration::from_secs(30),
        frame_timeout: Duration::from_secs(2),
        ..BringUpOptions::default()
    }
}

/// A time to come on the clock of links to segments with a thread of their own.
pub fn in_us(us: u64) -> u64 {
    monotonic_ns() + us * 1000
}

/// Runs a test that changes its thread in one of its own: tests may share theirs.
pub fn in_own_thread(test: impl FnOnce() + Send + 'static) {
    if let Err(panic) = thread::spawn(test).join() {
        std::panic::resume_unwind(panic);
    }
}
