//! The threads that serve a segment: over UDP, and on a network interface where that is permitted.

use std::net::{SocketAddr, UdpSocket};
use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

use sim::ethercat::{
    FaultHandle, ServeError, ServeOptions, ServerHandle, StatisticsHandle, serve_raw, serve_udp,
};
use sim::kelo::{KeloOptions, SimulatedDrive};
use sim::plant::TestStand;

const LOCAL: &str = "127.0.0.1:0";
const PATIENCE: Duration = Duration::from_secs(10);

struct Served {
    server: ServerHandle,
    faults: FaultHandle,
    statistics: StatisticsHandle,
    socket: UdpSocket,
}

fn drive() -> SimulatedDrive {
    SimulatedDrive::new(Box::new(TestStand::new()), KeloOptions::default())
}

fn serve() -> Served {
    serve_at(LOCAL)
}

fn serve_at(address: &str) -> Served {
    let drive = drive();
    let address = address.parse().unwrap();
    let server = serve_udp(address, drive.segment, ServeOptions::default()).unwrap();
    let socket = UdpSocket::bind(LOCAL).unwrap();
    socket.connect(server.local_addr().unwrap()).unwrap();
    socket
        .set_read_timeout(Some(Duration::from_secs(5)))
        .unwrap();
    Served {
        server,
        faults: drive.faults,
        statistics: drive.statistics,
        socket,
    }
}

/// A datagram by position, in a frame of its own.
fn datagram(command: u8, offset: u16, data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![12 + data.len() as u8, 0x10, command, 0, 0, 0];
    bytes.extend(offset.to_le_bytes());
    bytes.extend([data.len() as u8, 0, 0, 0]);
    bytes.extend(data);
    bytes.extend([0, 0]);
    bytes
}

impl Served {
    fn receive(&self) -> Vec<u8> {
        let mut bytes = [0; 1600];
        let length = self.socket.recv(&mut bytes).unwrap();
        bytes[..length].to_vec()
    }

    /// Sends a datagram; returns data and working counter.
    fn exchange(&self, command: u8, offset: u16, data: &[u8]) -> (Vec<u8>, u16) {
        self.socket.send(&datagram(command, offset, data)).unwrap();
        let reply = self.receive();
        let (data, counter) = reply[12..].split_at(data.len());
        (data.to_vec(), u16::from_le_bytes([counter[0], counter[1]]))
    }
}

fn wait_for(what: &str, mut condition: impl FnMut() -> bool) {
    let started = Instant::now();
    while !condition() {
        assert!(started.elapsed() < PATIENCE, "still waiting: {what}");
        sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_taken_port_is_named() {
    let served = serve();
    let taken = served.server.local_addr().unwrap();
    let error = serve_udp(taken, drive().segment, ServeOptions::default()).unwrap_err();
    assert!(matches!(error, ServeError::Udp { .. }));
    let text = error.to_string();
    assert!(
        text.contains(&format!("UDP port {}", taken.port())) && text.contains("127.0.0.1"),
        "{text}"
    );
}

#[test]
fn stopping_is_quick_and_frees_the_port() {
    // Of its own: a port that is free again may be given to another test at once.
    let Served { server, .. } = serve_at("127.0.97.1:0");
    let address = server.local_addr().unwrap();
    assert!(server.is_running());
    let asked = Instant::now();
    drop(server);
    assert!(asked.elapsed() < Duration::from_secs(1));
    UdpSocket::bind(address).unwrap();
}

#[test]
fn without_frames_requests_and_watchdog_go_on() {
    let served = serve();
    // Outputs' and inputs' SyncManagers, then one state after the other.
    served.exchange(2, 0x0120, &[0x11, 0]);
    served.exchange(2, 0x0120, &[2, 0]);
    served.exchange(2, 0x0810, &[0x00, 0x11, 36, 0, 0x64, 0, 1, 0]);
    served.exchange(2, 0x0818, &[0x00, 0x12, 172, 0, 0x20, 0, 1, 0]);
    for state in [4, 8] {
        served.exchange(2, 0x0120, &[state, 0]);
        wait_for("state", || {
            served.statistics.snapshot().al_status == [u16::from(state)]
        });
    }
    wait_for("watchdog", || {
        served.statistics.snapshot().al_status == [0x14]
    });
    assert_eq!(served.statistics.snapshot().al_status_code, [0x1B]);
    let (code, counter) = served.exchange(1, 0x0134, &[0; 2]);
    assert_eq!((code, counter), (vec![0x1B, 0], 1));
}

#[test]
fn replies_are_held_back_copied_and_in_company() {
    let served = serve();
    served.faults.delay_next(1, Duration::from_millis(60));
    let sent = Instant::now();
    assert_eq!(served.exchange(1, 0, &[0]), (vec![0x11], 1));
    assert!(sent.elapsed() >= Duration::from_millis(60));
    served.faults.duplicate_next(1);
    served.faults.foreign_before_next(1);
    served.socket.send(&datagram(1, 0, &[0])).unwrap();
    assert_eq!(served.receive(), b"this is not EtherCAT");
    assert_eq!(served.receive(), served.receive());
}

#[test]
fn garbage_is_counted_and_not_answered() {
    let served = serve();
    for bytes in [&b""[..], &[0xFF; 60], &[0x10], &[0; 1500]] {
        served.socket.send(bytes).unwrap();
    }
    served.socket.send(&vec![0x5A; 60_000]).unwrap();
    assert_eq!(
        served.exchange(1, 0, &[0]),
        (vec![0x11], 1),
        "the first answer is that of the good frame"
    );
    let seen = served.statistics.snapshot();
    assert_eq!((seen.frames, seen.malformed + seen.foreign), (6, 5));
}

#[test]
fn a_peer_that_goes_away_does_no_harm() {
    let served = serve();
    for _ in 0..20 {
        let guest = UdpSocket::bind(LOCAL).unwrap();
        guest
            .send_to(&datagram(1, 0, &[0]), served.server.local_addr().unwrap())
            .unwrap();
    }
    assert_eq!(served.exchange(1, 0, &[0]).1, 1);
    assert!(served.server.is_running());
}

#[test]
fn an_address_that_is_not_ours_is_refused() {
    let elsewhere: SocketAddr = "192.0.2.1:34980".parse().unwrap();
    let error = serve_udp(elsewhere, drive().segment, ServeOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("UDP port 34980 on 192.0.2.1"), "{error}");
}

/// A pair of virtual interfaces, removed at the end.
struct Pair(String, String);

impl Pair {
    fn new() -> Option<Pair> {
        let id = std::process::id() % 100_000;
        let pair = Pair(format!("sim{id}a"), format!("sim{id}b"));
        let made = ip(&[
            "link", "add", &pair.0, "type", "veth", "peer", "name", &pair.1,
        ]);
        if !made {
            std::mem::forget(pair);
            return None;
        }
        Some(pair)
    }
}

impl Drop for Pair {
    fn drop(&mut self) {
        ip(&["link", "del", &self.0]);
    }
}

fn ip(arguments: &[&str]) -> bool {
    Command::new("ip")
        .args(arguments)
        .output()
        .is_ok_and(|output| output.status.success())
}

#[test]
fn interfaces_that_cannot_be_used_are_named() {
    let refused =
        |name: &str| serve_raw(name, drive().segment, ServeOptions::default()).unwrap_err();
    let error = refused("no-such-one");
    assert!(
        matches!(error, ServeError::NoInterface { .. })
            && error.to_string().contains("no-such-one"),
        "{error}"
    );
    assert!(matches!(
        refused("with\0zero"),
        ServeError::NoInterface { .. }
    ));
    match refused("lo") {
        ServeError::Loopback { .. } => {}
        ServeError::Raw { source, .. } => {
            eprintln!("SKIPPED in part: no raw sockets here ({source})")
        }
        other => panic!("{other}"),
    }
}

#[test]
fn an_interface_carries_whole_frames() {
    let Some(Pair(near, far)) = &Pair::new() else {
        eprintln!("SKIPPED: no permission to make virtual interfaces");
        return;
    };
    assert!(matches!(
        serve_raw(near, drive().segment, ServeOptions::default()),
        Err(ServeError::InterfaceDown { .. })
    ));
    assert!(ip(&["link", "set", near, "up"]) && ip(&["link", "set", far, "up"]));
    let drive = drive();
    let server = serve_raw(near, drive.segment, ServeOptions { priority: Some(90) }).unwrap();
    assert!(server.granted().is_some() && server.local_addr().is_none());
    let storage: &'static ethercrab::PduStorage<16, 1100> =
        Box::leak(Box::new(ethercrab::PduStorage::new()));
    let (tx, rx, pdu_loop) = storage.try_split().unwrap();
    let task = ethercrab::std::tx_rx_task(far, tx, rx).unwrap();
    let config = ethercrab::MainDeviceConfig {
        dc_static_sync_iterations: 10,
        ..Default::default()
    };
    let timeouts = ethercrab::Timeouts {
        pdu: Duration::from_secs(1),
        ..Default::default()
    };
    let main_device = ethercrab::MainDevice::new(pdu_loop, timeouts, config);
    std::thread::spawn(move || block_on(task));
    let names = block_on(async {
        let group = main_device.init_single_group::<2, 256>(|| 0).await.unwrap();
        group
            .into_safe_op(&main_device)
            .await
            .unwrap()
            .into_op(&main_device)
            .await
            .unwrap();
        drive.statistics.snapshot().al_status
    });
    assert_eq!(names, [8]);
    assert!(server.stop());
}

/// Polls a future to its end on this thread.
fn block_on<T>(future: impl Future<Output = T>) -> T {
    struct Unpark(std::thread::Thread);
    impl std::task::Wake for Unpark {
        fn wake(self: std::sync::Arc<Self>) {
            self.0.unpark();
        }
    }
    let waker = std::sync::Arc::new(Unpark(std::thread::current())).into();
    let mut context = std::task::Context::from_waker(&waker);
    let mut future = std::pin::pin!(future);
    loop {
        if let std::task::Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return value;
        }
        std::thread::park_timeout(Duration::from_millis(10));
    }
}
