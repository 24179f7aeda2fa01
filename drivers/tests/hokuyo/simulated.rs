//! The driver against the simulated URG-04LX, whose serial line has a real bit rate and whose turns have a known time.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use super::scripted_connect::{WATCHDOG, patient, soon};
use drivers::hokuyo::{ConnectError, Hokuyo, LidarCounters, Options, ReadError, Reading, Scan};
use drivers::monotonic_ns;
use sim::lidar::{
    BIT_RATES, DeviceOptions, FaultHandle, LidarOptions, LidarServer, Protocol, RangeSource,
};

type TurnStarts = Arc<Mutex<Vec<u64>>>;

/// Readings tell their step and their turn.
struct Ruler {
    turn_starts: TurnStarts,
}

const TURNS: u64 = 1000;

impl RangeSource for Ruler {
    fn measure(
        &mut self,
        turn_start_ns: u64,
        _: u64,
        readings_mm: &mut [u16; sim::world::RANGE_STEPS],
    ) {
        let mut turns = self.turn_starts.lock().unwrap();
        let turn = turns.len() as u64 % TURNS;
        turns.push(turn_start_ns);
        for (step, reading) in readings_mm.iter_mut().enumerate() {
            *reading = 1000 + step as u16;
        }
        readings_mm[44] = 1000 + turn as u16;
        // Codes: nothing in sight, and two kinds of unknown.
        (readings_mm[100], readings_mm[101], readings_mm[102]) = (0, 6, 19);
    }
}

fn serve(device: DeviceOptions, link: Option<&std::path::Path>) -> (LidarServer, TurnStarts) {
    let turn_starts = TurnStarts::default();
    let source = Ruler {
        turn_starts: turn_starts.clone(),
    };
    let options = LidarOptions {
        device,
        link: link.map(Into::into),
        // Where that is permitted: one that is late does not keep its bit rate.
        priority: Some(90),
        ..LidarOptions::default()
    };
    (
        LidarServer::start_with(Box::new(source), options).unwrap(),
        turn_starts,
    )
}

fn new_device(bit_rate: u32) -> DeviceOptions {
    DeviceOptions {
        bit_rate,
        protocol: Protocol::Scip20,
        ..DeviceOptions::default()
    }
}

fn connect(server: &LidarServer, options: &Options) -> Hokuyo {
    let started = Instant::now();
    match Hokuyo::connect(&server.path().unwrap(), options) {
        Ok(lidar) => lidar,
        Err(error) => panic!(
            "{error} after {:?}: {:?}",
            started.elapsed(),
            server.counters()
        ),
    }
}

fn connected() -> (LidarServer, Hokuyo) {
    let (server, _) = serve(new_device(750_000), None);
    let lidar = connect(&server, &patient());
    (server, lidar)
}

fn check(scan: &Scan) {
    assert_eq!((scan.count, scan.first_step, scan.cluster), (682, 44, 1));
    for (reading, step) in scan.ranges_mm().iter().zip(44u16..).skip(1) {
        match step {
            100 => assert_eq!(Reading::from(*reading), Reading::NothingInSight),
            101 => assert_eq!(Reading::from(*reading), Reading::Unknown { code: 6 }),
            102 => assert_eq!(Reading::from(*reading), Reading::Unknown { code: 19 }),
            _ => assert_eq!(*reading, 1000 + step),
        }
    }
}

fn read(lidar: &mut Hokuyo, scans: u64) {
    let mut scan = Scan::new();
    for _ in 0..scans {
        if let Err(error) = lidar.read_scan(&mut scan, soon()) {
            panic!("{error}: {:?}", lidar.counters());
        }
        check(&scan);
    }
}

/// Connects, at 750 kbit/s, to a device that starts at each bit rate in turn.
fn from_every_bit_rate(device: impl Fn(u32) -> DeviceOptions + Sync) {
    std::thread::scope(|scope| {
        for bit_rate in BIT_RATES {
            let device = &device;
            scope.spawn(move || {
                let (server, _) = serve(device(bit_rate), None);
                let mut lidar = connect(&server, &patient());
                read(&mut lidar, 3);
                assert_eq!(server.counters().bit_rate, 750_000);
            });
        }
    });
}

#[test]
fn an_idle_device_at_every_bit_rate() {
    from_every_bit_rate(new_device);
}

#[test]
fn an_old_device_at_every_bit_rate() {
    from_every_bit_rate(|bit_rate| DeviceOptions {
        protocol: Protocol::Scip11,
        ..new_device(bit_rate)
    });
}

#[test]
fn a_streaming_device_at_every_bit_rate() {
    from_every_bit_rate(|bit_rate| DeviceOptions {
        streaming: true,
        ..new_device(bit_rate)
    });
}

#[test]
fn connecting_again_and_again() {
    let (server, _) = serve(new_device(19_200), None);
    for _ in 0..4 {
        let mut lidar = connect(&server, &patient());
        read(&mut lidar, 1);
    }
}

#[test]
fn a_slow_line_carries_what_fits() {
    for (bit_rate, cluster, skip) in [
        (250_000, 1, 0),
        (115_200, 2, 0),
        (115_200, 1, 1),
        (19_200, 13, 0),
    ] {
        let (server, _) = serve(new_device(bit_rate), None);
        let options = Options {
            bit_rate,
            cluster,
            skip,
            ..patient()
        };
        let mut lidar = connect(&server, &options);
        let mut scan = Scan::new();
        for _ in 0..5 {
            lidar.read_scan(&mut scan, soon()).unwrap();
            assert_eq!(scan.count, lidar.format().beams());
        }
        let counters = lidar.counters();
        assert_eq!(
            counters,
            LidarCounters {
                scans: 5,
                bytes: counters.bytes,
                ..LidarCounters::default()
            }
        );
        assert_eq!(server.counters().dropped_scans, 0, "{bit_rate} bit/s");
    }
    let (server, _) = serve(new_device(19_200), None);
    let options = Options {
        bit_rate: 115_200,
        ..patient()
    };
    let error = Hokuyo::connect(&server.path().unwrap(), &options).unwrap_err();
    assert!(matches!(error, ConnectError::TooSlow { .. }), "{error}");
}

/// The largest error of the stamps of `scans` scans, in milliseconds.
fn stamp_error_ms(device: DeviceOptions, scans: usize) -> f64 {
    let (server, turn_starts) = serve(device, None);
    let mut lidar = connect(&server, &patient());
    let to_first_beam_ns = lidar.parameters().step_time(44).as_nanos() as i64;
    let mut scan = Scan::new();
    let mut worst_ms = 0f64;
    for _ in 0..scans {
        lidar.read_scan(&mut scan, soon()).unwrap();
        let truth_ns = turn_starts.lock().unwrap()[usize::from(scan.ranges_mm[0]) - 1000];
        let error_ns = scan.stamp_ns as i64 - to_first_beam_ns - truth_ns as i64;
        worst_ms = worst_ms.max(error_ns.abs() as f64 * 1e-6);
    }
    assert_eq!(lidar.counters().clock_jumps, 0);
    worst_ms
}

#[test]
fn stamps_tell_when_the_turn_began() {
    let devices = [
        new_device(750_000),
        // A timer that wraps a few seconds after connecting.
        DeviceOptions {
            timer_ms: (1 << 24) - 2500,
            ..new_device(750_000)
        },
        DeviceOptions {
            timer_drift_ppm: 200.0,
            ..new_device(19_200)
        },
        DeviceOptions {
            timer_drift_ppm: -200.0,
            ..new_device(750_000)
        },
    ];
    std::thread::scope(|scope| {
        for device in devices {
            scope.spawn(|| {
                let description = format!("{device:?}");
                let error_ms = stamp_error_ms(device, 85);
                assert!(error_ms < 4.0, "{error_ms} ms: {description}");
            });
        }
    });
}

/// Injects a fault while scans come; the errors that were seen until scans come again.
fn errors_after(
    server: &LidarServer,
    lidar: &mut Hokuyo,
    patience: Duration,
    inject: impl Fn(&FaultHandle),
) -> Vec<ReadError> {
    read(lidar, 1);
    inject(&server.faults());
    let mut errors = Vec::new();
    let mut scan = Scan::new();
    let mut in_a_row = 0;
    for _ in 0..100 {
        match lidar.read_scan(&mut scan, monotonic_ns() + patience.as_nanos() as u64) {
            Ok(_) => {
                check(&scan);
                in_a_row += 1;
            }
            Err(error) => {
                errors.push(error);
                in_a_row = 0;
            }
        }
        if !errors.is_empty() && in_a_row == 3 {
            return errors;
        }
    }
    panic!("{errors:?}");
}

#[test]
fn garbage_truncation_and_wrong_checksums_cost_single_scans() {
    let patience = Duration::from_secs(3);
    let (server, mut lidar) = connected();
    let errors = errors_after(&server, &mut lidar, patience, |faults| {
        faults.corrupt_checksums(2)
    });
    assert_eq!(errors, [ReadError::Checksum; 2]);
    let errors = errors_after(&server, &mut lidar, patience, |faults| {
        faults.truncate_scans(2)
    });
    assert_eq!(errors, [ReadError::Truncated; 2]);
    for bytes in [1, 30, 1000, 5000] {
        let errors = errors_after(&server, &mut lidar, patience, |faults| {
            faults.garbage(bytes)
        });
        assert!((1..=2).contains(&errors.len()), "{bytes} bytes: {errors:?}");
    }
    let counters = lidar.counters();
    assert_eq!(
        (counters.checksum, counters.truncated),
        (2, 2),
        "{counters:?}"
    );
    assert!(counters.resynchronisations >= 6, "{counters:?}");
    assert!(counters.missed >= 4, "{counters:?}");
}

#[test]
fn a_silent_wire_times_out_and_scans_come_back() {
    let (server, mut lidar) = connected();
    let errors = errors_after(&server, &mut lidar, Duration::from_millis(300), |faults| {
        faults.silence(Duration::from_millis(900))
    });
    assert!(errors.contains(&ReadError::Timeout), "{errors:?}");
    server.faults().freeze();
    let mut scan = Scan::new();
    while lidar
        .read_scan(&mut scan, monotonic_ns() + 300_000_000)
        .is_ok()
    {}
    let started = Instant::now();
    assert_eq!(
        lidar.read_scan(&mut scan, monotonic_ns() + 50_000_000),
        Err(ReadError::Timeout)
    );
    assert!(started.elapsed() >= Duration::from_millis(50) && started.elapsed() < WATCHDOG);
    // A frozen device gives no connection either, in bounded time.
    drop(lidar);
    let hasty = Options {
        connect_timeout: Duration::from_secs(1),
        ..Options::default()
    };
    let started = Instant::now();
    let error = Hokuyo::connect(&server.path().unwrap(), &hasty).unwrap_err();
    assert!(matches!(error, ConnectError::NoAnswer { .. }), "{error}");
    assert!(started.elapsed() < hasty.connect_timeout + WATCHDOG);
    server.faults().thaw();
    read(&mut connect(&server, &patient()), 2);
}

fn until(is_so: impl Fn() -> bool) {
    let deadline = Instant::now() + WATCHDOG;
    while !is_so() {
        assert!(Instant::now() < deadline);
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn the_cable_can_be_pulled_and_put_back() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("lidar");
    let (server, _) = serve(new_device(19_200), Some(&link));
    for _ in 0..3 {
        let mut lidar = connect(&server, &patient());
        read(&mut lidar, 2);
        server.faults().unplug();
        let started = Instant::now();
        let mut scan = Scan::new();
        while lidar.read_scan(&mut scan, monotonic_ns() + 1_000_000_000)
            != Err(ReadError::Disconnected)
        {
            assert!(started.elapsed() < WATCHDOG);
        }
        drop(lidar);
        // The terminal goes first, then its name.
        until(|| !server.counters().plugged);
        let error = Hokuyo::connect(&link, &Options::default()).unwrap_err();
        assert!(matches!(error, ConnectError::Open { .. }), "{error}");
        server.faults().replug();
        until(|| server.counters().plugged);
    }
}
