//! `onboard teleop` on a terminal: what its keys say to the robot, and that the terminal is given back in every end.

use std::fs::{File, Permissions};
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::os::fd::OwnedFd;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus};
use std::thread::sleep;
use std::time::{Duration, Instant};

use onboard::process::teleop::Status;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, tcgetattr};

const PATIENCE: Duration = Duration::from_secs(10);
/// What a plain terminal says when it is asked who it is, and one with the kitty keyboard protocol.
const PLAIN: &[u8] = b"\x1b[?1;2c";
const KITTY: &[u8] = b"\x1b[?0u\x1b[?1;2c";

/// The program on a terminal of its own, and the end of its connection at which a robot would be.
struct Desk {
    program: Child,
    screen: File,
    /// The program's side of the terminal.
    side: OwnedFd,
    robot: BufReader<UnixStream>,
    shown: Vec<u8>,
    _folder: tempfile::TempDir,
}

impl Desk {
    fn new(terminal: &[u8]) -> Self {
        let folder = tempfile::Builder::new()
            .permissions(Permissions::from_mode(0o700))
            .tempdir()
            .expect("a folder");
        let listener = UnixListener::bind(folder.path().join("amr-1.ctl")).expect("a socket");
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
        grantpt(&master).expect("granted");
        unlockpt(&master).expect("unlocked");
        let name = ptsname(&master, Vec::new()).expect("a name");
        let flags = rustix::fs::OFlags::RDWR | rustix::fs::OFlags::NOCTTY;
        let side = rustix::fs::open(&name, flags, rustix::fs::Mode::empty()).expect("opened");
        let copy = || side.try_clone().expect("a copy");
        let mut command = Command::new(env!("CARGO_BIN_EXE_onboard"));
        command
            .args(["teleop", "amr-1", "--runtime"])
            .arg(folder.path())
            .stdin(copy())
            .stdout(copy())
            .stderr(copy());
        let controlling = copy();
        // SAFETY: between fork and exec only two system calls are made, and nothing is allocated.
        unsafe {
            command.pre_exec(move || {
                rustix::process::setsid()?;
                rustix::process::ioctl_tiocsctty(&controlling)?;
                Ok(())
            });
        }
        let mut program = command.spawn().expect("it starts");
        drop(command);
        let mut screen = File::from(master);
        screen.write_all(terminal).expect("written");
        rustix::io::ioctl_fionbio(&screen, true).expect("set");
        let mut robot = BufReader::new(connected(&listener, &mut program));
        let mut line = String::new();
        robot.read_line(&mut line).expect("it asks");
        assert_eq!(line, "teleop {\"without_borders\":false}\n");
        writeln!(robot.get_mut(), "in your hands, session 1").expect("answered");
        robot.get_mut().set_nonblocking(true).expect("set");
        let mut desk = Self {
            program,
            screen,
            side,
            robot,
            shown: Vec::new(),
            _folder: folder,
        };
        desk.until_taken();
        desk
    }

    /// Looks until the program has taken the terminal, as it does once the robot is in its hands.
    fn until_taken(&mut self) {
        let began = Instant::now();
        while !self.text().contains("\x1b[?1049h") {
            assert!(began.elapsed() < PATIENCE, "never taken, {}", self.text());
            sleep(Duration::from_millis(5));
            self.read_screen();
        }
    }

    fn types(&mut self, keys: &[u8]) {
        self.screen.write_all(keys).expect("typed");
    }

    /// Looks until the program has said this, typing meanwhile.
    fn until_said(&mut self, wish: &str, typing: &[u8]) -> Duration {
        let began = Instant::now();
        let mut line = String::new();
        loop {
            self.read_screen();
            match self.robot.read_line(&mut line) {
                Ok(0) => panic!("it has ended"),
                Ok(_) if line.trim_end() == wish => return began.elapsed(),
                Ok(_) => line.clear(),
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    assert!(
                        began.elapsed() < PATIENCE,
                        "never said {wish}, {}",
                        self.text()
                    );
                    self.types(typing);
                    sleep(Duration::from_millis(30));
                }
                Err(error) => panic!("{error}"),
            }
        }
    }

    /// What it shows; the terminal would block it if nobody read that.
    fn read_screen(&mut self) {
        let mut bytes = [0; 4096];
        while let Ok(count @ 1..) = self.screen.read(&mut bytes) {
            self.shown.extend_from_slice(&bytes[..count]);
        }
    }

    fn text(&self) -> String {
        String::from_utf8_lossy(&self.shown).into_owned()
    }

    /// Keys are read as they are typed, and not shown.
    fn is_raw(&self) -> bool {
        let modes = tcgetattr(&self.side).expect("a terminal").local_modes;
        !modes.intersects(LocalModes::ICANON | LocalModes::ECHO)
    }

    fn until_ended(&mut self) -> ExitStatus {
        let began = Instant::now();
        loop {
            self.read_screen();
            if let Some(status) = self.program.try_wait().expect("it ran") {
                self.read_screen();
                return status;
            }
            assert!(
                began.elapsed() < PATIENCE,
                "it does not end, {}",
                self.text()
            );
            sleep(Duration::from_millis(10));
        }
    }

    /// It ends, and the terminal is as it was.
    fn gives_back(&mut self) -> ExitStatus {
        let status = self.until_ended();
        assert!(!self.is_raw());
        let text = self.text();
        let (show, leave) = ("\x1b[?25h", "\x1b[?1049l");
        assert!(text.contains(show) && text.contains(leave), "{text:?}");
        status
    }
}

/// The program's connection; one that ends without has refused to start.
fn connected(listener: &UnixListener, program: &mut Child) -> UnixStream {
    listener.set_nonblocking(true).expect("set");
    let began = Instant::now();
    loop {
        match listener.accept() {
            Ok((robot, _)) => return robot,
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                let ended = program.try_wait().expect("it ran");
                assert!(ended.is_none(), "it ends with {ended:?} unconnected");
                assert!(began.elapsed() < PATIENCE, "it does not connect");
                sleep(Duration::from_millis(5));
            }
            Err(error) => panic!("{error}"),
        }
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        // It may have ended before.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

#[test]
fn a_key_that_repeats_drives_and_one_that_does_not_stops() {
    let mut desk = Desk::new(PLAIN);
    desk.until_said("0 0", b"");
    assert!(desk.is_raw());
    desk.until_said("0.1 0", b"w");
    let stopped = desk.until_said("0 0", b"");
    assert!(stopped < Duration::from_millis(600), "{stopped:?}");
    desk.until_said("-0.1 -0.125", b"a");
    desk.until_said("0 0", b" ");
    // What the robot says is shown.
    let status = Status {
        limit: "tube: something is in the way".to_owned(),
        ..Status::default()
    };
    let said = serde_json::to_string(&status).expect("JSON");
    writeln!(desk.robot.get_mut(), "{said}").expect("said");
    let began = Instant::now();
    while !desk.text().contains("something is in the way") {
        assert!(began.elapsed() < PATIENCE, "{}", desk.text());
        desk.read_screen();
        sleep(Duration::from_millis(10));
    }
    desk.types(b"x");
    assert!(desk.gives_back().success());
}

#[test]
fn with_the_kitty_protocol_a_key_drives_from_press_to_release() {
    let mut desk = Desk::new(KITTY);
    desk.until_said("0 0", b"");
    desk.types(b"\x1b[119;1:1u");
    desk.until_said("0.1 0", b"");
    sleep(Duration::from_millis(300));
    desk.types(b"\x1b[119;1:3u");
    let stopped = desk.until_said("0 0", b"");
    assert!(stopped < Duration::from_millis(500), "{stopped:?}");
    desk.types(b"\x03");
    // With all keys told as sequences, Ctrl-C is one, too.
    desk.types(b"\x1b[99;5u");
    assert!(desk.gives_back().success());
    assert!(desk.text().contains("\x1b[<1u"), "the protocol is left");
}

#[test]
fn whatever_ends_it_the_terminal_is_given_back() {
    use rustix::process::{Pid, Signal, kill_process};
    for signal in [Signal::TERM, Signal::HUP, Signal::INT, Signal::QUIT] {
        let mut desk = Desk::new(PLAIN);
        desk.until_said("0 0", b"");
        let id = Pid::from_child(&desk.program);
        kill_process(id, signal).expect("sent");
        assert!(desk.gives_back().success(), "{signal:?}");
    }
    // The robot's program ends.
    let mut desk = Desk::new(PLAIN);
    desk.until_said("0 0", b"");
    let robot = desk.robot.get_ref();
    robot.shutdown(std::net::Shutdown::Both).expect("closed");
    let status = desk.gives_back();
    assert_eq!(status.code(), Some(1));
    let text = desk.text();
    assert!(text.contains("the robot's program has ended"), "{text}");
    // The robot was taken back, and says why.
    let mut desk = Desk::new(PLAIN);
    desk.until_said("0 0", b"");
    let over = "{\"over\":\"taken-back\",\"why\":\"an operator has stopped the robot\"}";
    writeln!(desk.robot.get_mut(), "{over}").expect("said");
    assert_eq!(desk.gives_back().code(), Some(1));
    assert!(desk.text().contains("an operator has stopped the robot"));
}
