//! A MainDevice that was not written for this segment, ethercrab, brings it to OP and exchanges process data.

use std::cell::Cell;
use std::future::Future;
use std::net::UdpSocket;
use std::pin::pin;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

use ethercrab::{MainDevice, MainDeviceConfig, PduRx, PduStorage, PduTx, SubDeviceState, Timeouts};
use sim::ethercat::{Segment, ServeOptions, SubDevice, eeprom::ReadSize, serve_udp};
use sim::kelo::{Kelo, KeloOptions, PRODUCT_CODE, SimulatedDrive, VENDOR_ID};
use sim::plant::TestStand;
use sim::rt::{monotonic_ns, promote};

const ETHERNET_HEADER: usize = 14;
/// From sending a frame to its return, in the same thread.
const ROUND_TRIP: Duration = Duration::from_micros(10);
const MILLISECOND: Duration = Duration::from_millis(1);
const PATIENCE: Duration = Duration::from_secs(20);

/// Velocity mode, both motors enabled.
const DRIVE: u16 = 0x000B;

/// Carries a frame to a segment and brings back what comes.
trait Carrier {
    fn exchange(&mut self, frame: &[u8]) -> Option<Vec<u8>>;
    fn idle(&mut self) {}
    /// Lets time pass.
    fn pass(&mut self, time: Duration);
    /// What time it is for the segment.
    fn clock(&self) -> Box<dyn Fn() -> u64>;
}

/// A segment in the same thread, for which time passes only when it is told: however late the test is, no watchdog trips.
struct InProcess {
    segment: Segment,
    now_ns: Rc<Cell<u64>>,
}

impl InProcess {
    fn of(segment: Segment) -> InProcess {
        let now_ns = Rc::new(Cell::new(monotonic_ns()));
        InProcess { segment, now_ns }
    }
}

impl Carrier for InProcess {
    fn exchange(&mut self, frame: &[u8]) -> Option<Vec<u8>> {
        let mut frame = frame.to_vec();
        let reply = self.segment.process_frame(&mut frame, self.now_ns.get());
        self.idle();
        self.pass(ROUND_TRIP);
        reply.map(|reply| {
            frame.truncate(reply.length);
            frame
        })
    }

    fn idle(&mut self) {
        self.segment.cycle(self.now_ns.get());
    }

    fn pass(&mut self, time: Duration) {
        self.now_ns.set(self.now_ns.get() + time.as_nanos() as u64);
        self.idle();
    }

    fn clock(&self) -> Box<dyn Fn() -> u64> {
        let now_ns = Rc::clone(&self.now_ns);
        Box::new(move || now_ns.get())
    }
}

impl Carrier for UdpSocket {
    fn exchange(&mut self, frame: &[u8]) -> Option<Vec<u8>> {
        self.send(&frame[ETHERNET_HEADER..]).unwrap();
        let mut reply = frame[..ETHERNET_HEADER].to_vec();
        reply[6] |= 0x02;
        let mut payload = [0; 1600];
        let length = self.recv(&mut payload).ok()?;
        reply.extend(&payload[..length]);
        Some(reply)
    }

    fn pass(&mut self, time: Duration) {
        std::thread::sleep(time);
    }

    fn clock(&self) -> Box<dyn Fn() -> u64> {
        Box::new(monotonic_ns)
    }
}

/// Polls a future and carries its frames until it is done.
struct Pump<'c> {
    tx: PduTx<'static>,
    rx: PduRx<'static>,
    carrier: &'c mut dyn Carrier,
}

impl Pump<'_> {
    fn run<T>(&mut self, future: impl Future<Output = T>) -> T {
        let mut future = pin!(future);
        let mut context = Context::from_waker(Waker::noop());
        let started = Instant::now();
        loop {
            if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
                return value;
            }
            assert!(started.elapsed() < PATIENCE, "ethercrab waits for ever");
            let mut sent = None;
            while let Some(frame) = self.tx.next_sendable_frame() {
                frame
                    .send_blocking(|bytes| {
                        sent = Some(bytes.to_vec());
                        Ok(bytes.len())
                    })
                    .unwrap();
                if let Some(reply) = sent.take().and_then(|frame| self.carrier.exchange(&frame)) {
                    self.rx.receive_frame(&reply).unwrap();
                }
            }
            self.carrier.idle();
        }
    }
}

fn main_device(carrier: &mut dyn Carrier) -> (MainDevice<'static>, Pump<'_>) {
    let storage: &'static PduStorage<16, 1100> = Box::leak(Box::new(PduStorage::new()));
    let (tx, rx, pdu_loop) = storage.try_split().unwrap();
    let timeouts = Timeouts {
        pdu: Duration::from_secs(2),
        eeprom: Duration::from_secs(2),
        ..Timeouts::default()
    };
    let config = MainDeviceConfig {
        dc_static_sync_iterations: 20,
        ..MainDeviceConfig::default()
    };
    (
        MainDevice::new(pdu_loop, timeouts, config),
        Pump { tx, rx, carrier },
    )
}

/// Process data outputs: both wheels at this speed, forward.
fn outputs(speed_rad_s: f32) -> [u8; 36] {
    let mut bytes = [0; 36];
    bytes[..2].copy_from_slice(&DRIVE.to_le_bytes());
    let floats = [-speed_rad_s, speed_rad_s, 20.0, -20.0, 20.0, -20.0];
    for (i, value) in floats.into_iter().enumerate() {
        bytes[4 + 4 * i..8 + 4 * i].copy_from_slice(&f32::to_le_bytes(value));
    }
    bytes
}

fn float(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

fn time(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}

/// Brings the segment to OP, drives every wheel, stops writing, and looks what the watchdog does.
fn whole_session(carrier: &mut dyn Carrier, drives: usize) {
    let clock = carrier.clock();
    let (main_device, mut pump) = main_device(carrier);
    let main_device = &main_device;
    let group = pump
        .run(main_device.init_single_group::<4, 1024>(&*clock))
        .unwrap();
    assert_eq!(group.len(), drives);
    for subdevice in group.iter(main_device) {
        let identity = subdevice.identity();
        assert_eq!(
            (identity.vendor_id, identity.product_id),
            (VENDOR_ID, PRODUCT_CODE)
        );
        assert_eq!(subdevice.name(), "KELO Drive");
        let description = pump.run(subdevice.description()).unwrap().unwrap();
        assert_eq!(description, "KELO Drive (simulated)");
        assert_eq!(pump.run(subdevice.eeprom_size(main_device)).unwrap(), 2048);
    }
    let group = pump.run(group.into_safe_op(main_device)).unwrap();
    for subdevice in group.iter(main_device) {
        assert_eq!(
            (subdevice.outputs_raw().len(), subdevice.inputs_raw().len()),
            (36, 172)
        );
        let control: u8 = pump.run(subdevice.register_read(0x0814u16)).unwrap();
        assert_eq!(control, 0x64, "watchdog enabled");
    }
    pump.run(group.tx_rx(main_device)).unwrap();
    let group = pump.run(group.into_op(main_device)).unwrap();
    for subdevice in group.iter(main_device) {
        subdevice.outputs_raw_mut().copy_from_slice(&outputs(5.0));
    }
    let mut sensor_ts = vec![0; drives];
    for _ in 0..150 {
        let response = pump.run(group.tx_rx(main_device)).unwrap();
        assert_eq!(usize::from(response.working_counter), 3 * drives);
        assert!(
            response
                .subdevice_states
                .iter()
                .all(|state| *state == SubDeviceState::Op)
        );
        for (subdevice, last) in group.iter(main_device).zip(&mut sensor_ts) {
            let inputs = subdevice.inputs_raw();
            assert!(time(&inputs, 4) >= *last);
            *last = time(&inputs, 4);
        }
        pump.carrier.pass(MILLISECOND);
    }
    let now_ns = clock();
    assert!(
        sensor_ts.iter().all(|ts| ts.abs_diff(now_ns) < 100_000_000),
        "{sensor_ts:?} follow the MainDevice's clock"
    );
    for subdevice in group.iter(main_device) {
        let inputs = subdevice.inputs_raw();
        assert_eq!(inputs[..4], [63, 0, 3, 8]);
        assert!(
            (float(&inputs, 24) + 5.0).abs() < 0.1,
            "motor 1 runs backwards: {}",
            float(&inputs, 24)
        );
        assert!(
            (float(&inputs, 72) - 5.0).abs() < 0.1,
            "motor 2 runs forwards: {}",
            float(&inputs, 72)
        );
    }
    // Registers only, no process data: the watchdog trips.
    for _ in 0..100 {
        for subdevice in group.iter(main_device) {
            pump.run(subdevice.register_read::<u16>(0x0130u16)).unwrap();
        }
        pump.carrier.pass(2 * MILLISECOND);
    }
    for subdevice in group.iter(main_device) {
        let (state, code): (u16, u16) = (
            pump.run(subdevice.register_read(0x0130u16)).unwrap(),
            pump.run(subdevice.register_read(0x0134u16)).unwrap(),
        );
        assert_eq!((state, code), (0x14, 0x1B));
    }
}

fn drive(options: KeloOptions) -> SimulatedDrive {
    SimulatedDrive::new(Box::new(TestStand::new()), options)
}

#[test]
fn one_drive_in_process() {
    let drive = drive(KeloOptions::default());
    whole_session(&mut InProcess::of(drive.segment), 1);
    assert_eq!(drive.statistics.snapshot().watchdog_trips, 1);
    let driven = drive.drive.statistics();
    assert_eq!(
        (
            driven.left_rad_s.max,
            driven.right_rad_s.max,
            driven.over_speed
        ),
        (5.0, 5.0, 0)
    );
}

#[test]
fn reads_of_four_bytes_do_too() {
    let options = KeloOptions {
        eeprom_read_size: ReadSize::Four,
        ..KeloOptions::default()
    };
    whole_session(&mut InProcess::of(drive(options).segment), 1);
}

#[test]
fn three_drives_in_a_line() {
    let kelo = || {
        Box::new(Kelo::new(
            Box::new(TestStand::new()),
            KeloOptions::default(),
        ))
    };
    let segment = Segment::new(
        (0..3)
            .map(|_| SubDevice::new(kelo(), ReadSize::Eight))
            .collect(),
    );
    whole_session(&mut InProcess::of(segment), 3);
}

#[test]
fn a_second_session_follows_a_first() {
    let mut carrier = InProcess::of(drive(KeloOptions::default()).segment);
    whole_session(&mut carrier, 1);
    whole_session(&mut carrier, 1);
}

#[test]
fn one_drive_over_udp() {
    // In a thread of its own: tests may share theirs.
    std::thread::spawn(session_over_udp).join().unwrap();
}

/// Where that is permitted, before others that compute: a drive waits no longer than its watchdog.
fn session_over_udp() {
    println!("MainDevice: {}", promote(80));
    let drive = drive(KeloOptions::default());
    let options = ServeOptions { priority: Some(85) };
    let server = serve_udp("127.0.0.1:0".parse().unwrap(), drive.segment, options).unwrap();
    let mut socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.connect(server.local_addr().unwrap()).unwrap();
    socket
        .set_read_timeout(Some(Duration::from_millis(500)))
        .unwrap();
    whole_session(&mut socket, 1);
    let asked = Instant::now();
    assert!(server.stop());
    assert!(asked.elapsed() < Duration::from_secs(1));
}
