//! Whoever reaches the port can open connections, also without a certificate, and say nothing, or not enough.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::hall::{Hall, Robot};

/// Files that the mediator may have open: usually half of them.
const FILES: u64 = 160;
/// More than it usually may, and more than it may ever.
const SOME: usize = 110;
const MANY: usize = 200;
/// zenoh's listener waits a tenth of a second after each that it closes.
const PATIENCE: Duration = Duration::from_secs(60);
/// A robot that hears nothing for a second stops before borders. This machine has other things to do.
const MOST_SILENCE: Duration = Duration::from_secs(3);
/// Of a first message of TLS: a handshake of 512 bytes, of which none comes.
const BEGINS: [u8; 5] = [22, 3, 1, 2, 0];

/// A mediator, its two robots in their rooms, and somebody who has opened connections and goes on holding them.
struct Siege {
    hall: Hall,
    robots: [Robot; 2],
    /// Files that were open before.
    before: u64,
    idle: Vec<TcpStream>,
    begun: Instant,
}

impl Siege {
    fn lay(connections: usize) -> Self {
        let hall = Hall::with_files(FILES);
        let mut robots = [hall.robot("amr-0"), hall.robot("amr-1")];
        hall.until("both have their rooms", || {
            robots.iter_mut().for_each(Robot::step);
            robots.iter().all(Robot::holds)
        });
        let before = hall.program.open_files();
        let with_some = before + SOME as u64;
        assert!((FILES / 2 + 1..FILES).contains(&with_some), "{before}");
        assert!(FILES < MANY as u64);
        let address = hall.endpoint.trim_start_matches("tls/").to_owned();
        let idle = (0..connections).map(|number| {
            let mut connection = TcpStream::connect(&address).expect("the kernel takes it");
            if number % 2 == 0 {
                connection.write_all(&BEGINS).expect("it is open");
            }
            connection.set_nonblocking(true).expect("a socket");
            connection
        });
        Self {
            before,
            idle: idle.collect(),
            robots,
            hall,
            begun: Instant::now(),
        }
    }

    /// Holds them until all are closed.
    fn hold(&mut self, mut meanwhile: impl FnMut(&mut [Robot; 2])) {
        while !self.idle.iter().all(is_closed) {
            let log = self.hall.program.log();
            assert!(self.begun.elapsed() < PATIENCE, "not closed: {log}");
            meanwhile(&mut self.robots);
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Whoever comes now finds a place, operators are answered, and the files are free again.
    fn ends(self) {
        drop(self.robots);
        let mut anew = self.hall.robot("amr-0");
        self.hall.until_served("one that comes anew", &mut anew);
        self.hall.program.wait_ready(super::PATIENCE);
        self.hall.until("the files are free again", || {
            self.hall.program.open_files() <= self.before + 10
        });
    }
}

/// Whether the other side has closed it.
fn is_closed(mut connection: &TcpStream) -> bool {
    match connection.read(&mut [0; 64]) {
        // It may say first that it has waited for too long.
        Ok(count) => count == 0 || is_closed(connection),
        Err(error) => error.kind() != std::io::ErrorKind::WouldBlock,
    }
}

#[test]
fn more_connections_that_say_nothing_than_files_are_closed_and_no_robot_notices() {
    let mut siege = Siege::lay(SOME);
    let (mut heard, mut heard_at, mut longest) = ([0; 2], [Instant::now(); 2], Duration::ZERO);
    siege.hold(|robots| {
        for (number, robot) in robots.iter_mut().enumerate() {
            robot.step();
            assert!(robot.holds());
            if robot.heard > heard[number] {
                (heard[number], heard_at[number]) = (robot.heard, Instant::now());
            }
            longest = longest.max(heard_at[number].elapsed());
        }
    });
    assert!(longest < MOST_SILENCE, "silent for {longest:?}");
    let waited = siege.begun.elapsed();
    assert!(waited > Duration::from_secs(5), "closed after {waited:?}");
    let log = siege.hall.program.log();
    assert!(log.contains("none of 80 files"), "{log}");
    assert!(!log.contains("opened anew: no file"), "{log}");
    siege.ends();
}

#[test]
fn where_even_those_files_are_not_enough_the_network_is_opened_anew() {
    let mut siege = Siege::lay(MANY);
    siege.hold(|_| {});
    let log = siege.hall.program.log();
    assert!(log.contains("opened anew: no file"), "{log}");
    siege.ends();
}
