//! Connecting to a device in every state.

use std::time::{Duration, Instant};

use description::robot::BIT_RATES;
use drivers::hokuyo::{ConnectError, Encoding, Hokuyo, Options, Parameters, Scan};
use drivers::monotonic_ns;

use super::peer::{Peer, Setup};

/// Half the beams: the scripted device turns at 50 Hz to save time. Long timeouts, for busy hosts.
pub fn options() -> Options {
    Options {
        cluster: 2,
        ..patient()
    }
}

pub fn patient() -> Options {
    Options {
        connect_timeout: Duration::from_secs(20),
        reply_timeout: Duration::from_secs(2),
        ..Options::default()
    }
}

/// A deadline long after the scan must have come.
pub fn soon() -> u64 {
    monotonic_ns() + 3_000_000_000
}

/// Allowance for a busy host on top of a bounded time.
pub const WATCHDOG: Duration = Duration::from_secs(2);

/// Connects and reads two scans.
fn connect_and_read(setup: Setup, options: &Options) -> (Peer, Hokuyo) {
    let peer = Peer::start(setup);
    let mut lidar = match Hokuyo::connect(peer.path(), options) {
        Ok(lidar) => lidar,
        Err(error) => panic!("{error}; the device heard {:?}", peer.commands()),
    };
    let mut scan = Scan::new();
    for sequence in 0..2 {
        lidar.read_scan(&mut scan, soon()).unwrap();
        assert_eq!(scan.sequence, sequence);
        assert_eq!(scan.count, lidar.format().beams());
        assert!(
            scan.ranges_mm()
                .iter()
                .enumerate()
                .all(|(beam, range)| usize::from(*range) == beam)
        );
    }
    (peer, lidar)
}

#[test]
fn tells_who_is_there() {
    let (peer, lidar) = connect_and_read(Setup::default(), &options());
    assert_eq!(lidar.identity().serial, "H1234567");
    assert_eq!(lidar.identity().vendor, "Hokuyo Automatic Co., Ltd.");
    assert_eq!(
        lidar.parameters(),
        &Parameters {
            scan_rpm: 3000,
            ..Parameters::urg_04lx()
        }
    );
    assert_eq!(lidar.state().status, "Sensor works well.");
    assert_eq!(lidar.scan_period(), Duration::from_millis(20));
    let (first, step) = lidar.beam_angles_rad();
    assert!((first.to_degrees() + 119.35).abs() < 0.01 && (step.to_degrees() - 0.703).abs() < 0.01);
    assert!(lidar.stamp_uncertainty().unwrap() < Duration::from_millis(5));
    assert_eq!(lidar.counters().scans, 2);
    assert!(
        !peer
            .commands()
            .iter()
            .any(|command| command.starts_with("SS"))
    );
}

#[test]
fn finds_the_device_at_every_bit_rate() {
    std::thread::scope(|scope| {
        for bit_rate in BIT_RATES {
            scope.spawn(move || {
                let (peer, _lidar) = connect_and_read(
                    Setup {
                        bit_rate,
                        ..Setup::default()
                    },
                    &options(),
                );
                let switched = peer.commands().iter().any(|command| command == "SS750000");
                assert_eq!(switched, bit_rate != 750_000, "{bit_rate}");
            });
        }
    });
}

#[test]
fn goes_to_every_bit_rate() {
    std::thread::scope(|scope| {
        for bit_rate in BIT_RATES {
            scope.spawn(move || {
                let options = Options {
                    bit_rate,
                    cluster: 99,
                    ..patient()
                };
                connect_and_read(
                    Setup {
                        rpm: 600,
                        ..Setup::default()
                    },
                    &options,
                );
            });
        }
    });
}

#[test]
fn switches_scip_1_1_over() {
    for bit_rate in [750_000, 19_200] {
        let setup = Setup {
            scip_1_1: true,
            bit_rate,
            ..Setup::default()
        };
        let (peer, _lidar) = connect_and_read(setup, &options());
        assert!(peer.commands().iter().any(|command| command == "SCIP2.0"));
    }
}

#[test]
fn takes_over_a_device_that_streams() {
    for bit_rate in [750_000, 115_200] {
        let streaming = Some("MD0044072501000");
        connect_and_read(
            Setup {
                streaming,
                bit_rate,
                ..Setup::default()
            },
            &options(),
        );
    }
}

#[test]
fn takes_over_a_device_in_clock_adjust_mode() {
    connect_and_read(
        Setup {
            adjusting: true,
            ..Setup::default()
        },
        &options(),
    );
}

#[test]
fn a_device_that_is_not_well_is_refused_in_its_words() {
    let peer = Peer::start(Setup {
        says: "STAT:Sensor malfunction (laser).",
        ..Setup::default()
    });
    let error = Hokuyo::connect(peer.path(), &options()).unwrap_err();
    assert!(matches!(error, ConnectError::Unwell { .. }), "{error}");
    assert!(error.to_string().contains("malfunction (laser)"), "{error}");
}

#[test]
fn a_device_whose_clock_cannot_be_compared_is_refused() {
    for (command, expected) in [
        ("TM0", "how old its scans are"),
        ("TM1", "could not be read"),
    ] {
        let peer = Peer::start(Setup {
            refuse: vec![(command, "0D")],
            ..Setup::default()
        });
        let error = Hokuyo::connect(peer.path(), &options()).unwrap_err();
        assert!(error.to_string().contains(expected), "{command}: {error}");
    }
}

#[test]
fn two_characters_per_reading() {
    let options = Options {
        encoding: Encoding::Two,
        ..options()
    };
    let (peer, _lidar) = connect_and_read(Setup::default(), &options);
    assert!(
        peer.commands()
            .iter()
            .any(|command| command == "MS0044072502000")
    );
}

#[test]
fn asks_again_when_a_reply_is_garbled() {
    let garble = vec!["PP", "VV", "VV", "II"];
    connect_and_read(
        Setup {
            garble,
            ..Setup::default()
        },
        &options(),
    );
    let garble = vec!["PP"; 3];
    let peer = Peer::start(Setup {
        garble,
        ..Setup::default()
    });
    let error = Hokuyo::connect(peer.path(), &options()).unwrap_err();
    assert!(
        matches!(&error, ConnectError::NoReply { command, .. } if command == "PP"),
        "{error}"
    );
}

#[test]
fn says_what_the_device_refuses() {
    for (command, status) in [("BM", "01"), ("SS", "02"), ("MD", "05"), ("PP", "0D")] {
        let refuse = vec![(command, status)];
        let peer = Peer::start(Setup {
            bit_rate: 115_200,
            refuse,
            ..Setup::default()
        });
        let error = Hokuyo::connect(peer.path(), &options()).unwrap_err();
        assert!(matches!(error, ConnectError::Refused { .. }), "{error}");
        let text = error.to_string();
        assert!(text.contains(command) && text.contains(status), "{text}");
    }
}

#[test]
fn says_that_the_line_is_too_slow() {
    let peer = Peer::start(Setup {
        rpm: 600,
        ..Setup::default()
    });
    let options = Options {
        bit_rate: 115_200,
        ..patient()
    };
    let error = Hokuyo::connect(peer.path(), &options).unwrap_err();
    assert!(
        matches!(
            error,
            ConnectError::TooSlow {
                bit_rate: 115_200,
                ..
            }
        ),
        "{error}"
    );
    assert!(
        error
            .to_string()
            .contains("cluster = 2 or skip = 1 or bit_rate = 250000"),
        "{error}"
    );
}

/// What it would take to read another device is of no use to know.
#[test]
fn another_device_is_refused_as_such() {
    let peer = Peer::start(Setup {
        rpm: 2400,
        ..Setup::default()
    });
    let options = Options {
        bit_rate: 115_200,
        ..patient()
    };
    let error = Hokuyo::connect(peer.path(), &options).unwrap_err();
    assert!(matches!(error, ConnectError::OtherDevice(_)), "{error}");
    let text = error.to_string();
    assert!(
        text.contains("2400 turns") && text.contains("URG-04LX"),
        "{text}"
    );
}

/// Expects connecting to fail before its limit.
fn give_up(peer: &Peer, connect_timeout: Duration) -> ConnectError {
    let reply_timeout = Duration::from_millis(300);
    let options = Options {
        connect_timeout,
        reply_timeout,
        ..options()
    };
    let started = Instant::now();
    let error = Hokuyo::connect(peer.path(), &options).unwrap_err();
    assert!(started.elapsed() < connect_timeout + WATCHDOG, "{error}");
    error
}

#[test]
fn gives_up_in_time_when_nobody_answers() {
    let peer = Peer::start(Setup {
        bit_rate: 1200,
        ..Setup::default()
    });
    let error = give_up(&peer, Duration::from_millis(2500));
    let ConnectError::NoAnswer { tried, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!(tried.len(), BIT_RATES.len());
    give_up(&peer, Duration::from_millis(300));
}

#[test]
fn gives_up_in_time_when_the_device_only_streams() {
    let peer = Peer::start(Setup {
        streaming: Some("MD0044072501000"),
        refuse: vec![("QT", "0D"), ("TM2", "0D"), ("SCIP2.0", "0D")],
        ..Setup::default()
    });
    give_up(&peer, Duration::from_secs(2));
}

#[test]
fn refuses_what_is_no_serial_device() {
    for path in ["/dev/does-not-exist", "/dev/null", "/proc/version", "/tmp"] {
        let error = Hokuyo::connect(path.as_ref(), &options()).unwrap_err();
        assert!(matches!(error, ConnectError::Open { .. }), "{error}");
        assert!(error.to_string().contains(path), "{error}");
    }
}

#[test]
fn a_device_that_vanishes_while_connecting_is_noticed() {
    let mut peer = Peer::start(Setup {
        bit_rate: 1200,
        ..Setup::default()
    });
    let path = peer.path().to_owned();
    let connecting = std::thread::spawn(move || Hokuyo::connect(&path, &options()));
    let started = Instant::now();
    while !peer.is_addressed() {
        assert!(started.elapsed() < WATCHDOG, "never opened");
        std::thread::sleep(Duration::from_millis(1));
    }
    peer.unplug();
    let error = connecting.join().unwrap().unwrap_err();
    assert!(
        matches!(error, ConnectError::Disconnected { .. }),
        "{error}"
    );
}
