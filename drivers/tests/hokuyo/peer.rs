//! A small scripted SCIP device on a pseudo-terminal, faults included.
//!
//! It has no physics: every scan is a ramp, and bytes leave at once.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use drivers::hokuyo::codec;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// The device at power-up, and what it refuses.
#[derive(Clone)]
pub struct Setup {
    pub bit_rate: u32,
    pub scip_1_1: bool,
    pub adjusting: bool,
    /// Streams this command from the start.
    pub streaming: Option<&'static str>,
    pub rpm: u16,
    /// Replies in place of the usual ones: command and status.
    pub refuse: Vec<(&'static str, &'static str)>,
    /// Answers to these, as often as given, with a wrong checksum in the fields.
    pub garble: Vec<&'static str>,
    /// What it says of its state.
    pub says: &'static str,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            bit_rate: 750_000,
            scip_1_1: false,
            adjusting: false,
            streaming: None,
            rpm: 3000,
            refuse: Vec::new(),
            garble: Vec::new(),
            says: "STAT:Sensor works well.",
        }
    }
}

/// Happens to the next scan, or at once.
#[derive(Debug, Clone)]
pub enum Order {
    WrongChecksum,
    /// Send only the first bytes of it: this number.
    Truncate(usize),
    /// Send these before it.
    Garbage(Vec<u8>),
    Status(&'static str),
    /// Pause in the middle of it, and say so, until the next order that does not set the clock.
    PauseWithin(Sender<()>),
    /// End the pause.
    GoOn,
    /// Set the device's clock.
    Clock(u32),
    Freeze,
}

pub struct Peer {
    path: PathBuf,
    orders: Option<Sender<Order>>,
    commands: Arc<Mutex<Vec<String>>>,
    thread: Option<JoinHandle<()>>,
    unplugged: Arc<AtomicBool>,
    addressed: Arc<AtomicBool>,
}

impl Peer {
    pub fn start(setup: Setup) -> Self {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&master).unwrap();
        unlockpt(&master).unwrap();
        let path = PathBuf::from(ptsname(&master, Vec::new()).unwrap().into_string().unwrap());
        fcntl_setfl(&master, fcntl_getfl(&master).unwrap() | OFlags::NONBLOCK).unwrap();
        // Held open, so that the master does not see a hang-up between two hosts.
        let slave = File::options().read(true).write(true).open(&path).unwrap();
        let mut termios = tcgetattr(&slave).unwrap();
        termios.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &termios).unwrap();
        let (orders, receiver) = channel();
        let commands = Arc::new(Mutex::new(Vec::new()));
        let unplugged = Arc::<AtomicBool>::default();
        let addressed = Arc::<AtomicBool>::default();
        let device = Device {
            unplugged: unplugged.clone(),
            addressed: addressed.clone(),
            master: master.into(),
            host_line: OwnedFd::from(slave),
            clock_0: Instant::now(),
            orders: receiver,
            commands: commands.clone(),
            stream: setup
                .streaming
                .map(|command| (command.to_owned(), Instant::now())),
            setup,
            line: Vec::new(),
            frozen: false,
        };
        let thread = std::thread::spawn(move || device.run());
        Self {
            path,
            orders: Some(orders),
            commands,
            thread: Some(thread),
            unplugged,
            addressed,
        }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn order(&self, order: Order) {
        self.orders.as_ref().unwrap().send(order).unwrap();
    }

    /// Somebody has sent it something, at any bit rate.
    pub fn is_addressed(&self) -> bool {
        self.addressed.load(Ordering::Relaxed)
    }

    pub fn commands(&self) -> Vec<String> {
        self.commands.lock().unwrap().clone()
    }

    /// Closes the device's end.
    pub fn unplug(&mut self) {
        self.orders = None;
        self.unplugged.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        self.unplug();
    }
}

struct Device {
    unplugged: Arc<AtomicBool>,
    addressed: Arc<AtomicBool>,
    master: File,
    host_line: OwnedFd,
    clock_0: Instant,
    orders: Receiver<Order>,
    commands: Arc<Mutex<Vec<String>>>,
    setup: Setup,
    /// Command and start of the next turn.
    stream: Option<(String, Instant)>,
    line: Vec<u8>,
    frozen: bool,
}

impl Device {
    fn run(mut self) {
        let mut pending = VecDeque::new();
        loop {
            loop {
                match self.orders.try_recv() {
                    Ok(Order::Freeze) => self.frozen = true,
                    Ok(Order::Clock(ms)) => self.set_clock(ms),
                    Ok(order) => pending.push_back(order),
                    Err(TryRecvError::Empty) => break,
                    Err(TryRecvError::Disconnected) => return,
                }
            }
            self.listen();
            let turn = Duration::from_nanos(60_000_000_000 / u64::from(self.setup.rpm));
            if let Some((command, start)) = self.stream.clone()
                && start.elapsed() >= turn
            {
                self.stream = Some((command.clone(), start + turn));
                if !self.frozen {
                    self.send_scan(&command, start, pending.pop_front());
                }
            }
        }
    }

    fn understands_host(&self) -> bool {
        tcgetattr(&self.host_line).unwrap().output_speed() == self.setup.bit_rate
    }

    fn listen(&mut self) {
        let mut fds = [PollFd::new(&self.master, PollFlags::IN)];
        let millisecond = Timespec::try_from(Duration::from_millis(1)).unwrap();
        if poll(&mut fds, Some(&millisecond)) != Ok(1) {
            return;
        }
        let mut bytes = [0; 256];
        let Ok(count) = self.master.read(&mut bytes) else {
            return;
        };
        self.addressed.store(true, Ordering::Relaxed);
        for byte in &bytes[..count] {
            // At another bit rate something arrives, but nothing sensible.
            let byte = if self.understands_host() {
                *byte
            } else {
                byte.rotate_left(3) ^ 0x55
            };
            if byte != b'\n' {
                self.line.push(byte);
                continue;
            }
            let command = std::mem::take(&mut self.line);
            if !self.frozen {
                self.obey(&String::from_utf8_lossy(&command));
            }
        }
    }

    fn obey(&mut self, command: &str) {
        self.commands.lock().unwrap().push(command.to_owned());
        let refusal = self
            .setup
            .refuse
            .iter()
            .find(|(refused, _)| command.starts_with(refused));
        if let Some((_, status)) = refusal {
            return self.reply(command, status, &[]);
        }
        if self.setup.scip_1_1 {
            if command == "SCIP2.0" {
                self.setup.scip_1_1 = false;
                return self.send(format!("{command}\n0\n\n").as_bytes());
            }
            return self.send(format!("{command}\nE\n\n").as_bytes());
        }
        if self.setup.adjusting && !command.starts_with("TM") {
            return self.reply(command, "0E", &[]);
        }
        match command {
            "VV" => self.fields(
                command,
                &[
                    "VEND:Hokuyo Automatic Co., Ltd.",
                    "PROD:SOKUIKI Sensor URG-04LX",
                    "FIRM:3.4.03(17/Dec./2012)",
                    "PROT:SCIP 2.0",
                    "SERI:H1234567",
                ],
            ),
            "PP" => {
                let scan = format!("SCAN:{}", self.setup.rpm);
                self.fields(
                    command,
                    &[
                        "MODL:URG-04LX(Hokuyo Automatic Co., Ltd.)",
                        "DMIN:20",
                        "DMAX:5600",
                        "ARES:1024",
                        "AMIN:44",
                        "AMAX:725",
                        "AFRT:384",
                        &scan,
                    ],
                );
            }
            "II" => self.fields(command, &["LASR:OFF", "SCSP:Initial", self.setup.says]),
            "QT" => {
                self.stream = None;
                self.reply(command, "00", &[]);
            }
            "BM" => self.reply(command, "00", &[]),
            "TM0" => {
                let already = std::mem::replace(&mut self.setup.adjusting, true);
                self.reply(command, if already { "02" } else { "00" }, &[]);
            }
            "TM1" => {
                let stamp = self.stamp(Instant::now());
                self.reply(command, "00", &[&stamp]);
            }
            "TM2" => {
                self.setup.adjusting = false;
                self.reply(command, "00", &[]);
            }
            _ if command.starts_with("SS") => {
                self.reply(command, "00", &[]);
                self.setup.bit_rate = command[2..].parse().unwrap();
            }
            _ if command.starts_with("MD") || command.starts_with("MS") => {
                self.reply(command, "00", &[]);
                self.stream = Some((command.to_owned(), Instant::now()));
            }
            _ => self.reply(command, "0E", &[]),
        }
    }

    fn stamp(&self, at: Instant) -> String {
        let ms = at.duration_since(self.clock_0).as_millis() as u32 & 0xff_ffff;
        let mut stamp = [0; 4];
        assert!(codec::encode(ms, &mut stamp));
        String::from_utf8(stamp.into()).unwrap()
    }

    fn fields(&mut self, command: &str, fields: &[&str]) {
        let garbled = self.setup.garble.iter().position(|name| *name == command);
        let mut bytes = format!("{command}\n00P\n").into_bytes();
        for field in fields {
            bytes.extend_from_slice(field.as_bytes());
            let sum = codec::checksum(field.as_bytes()) ^ u8::from(garbled.is_some());
            bytes.extend_from_slice(&[b';', sum, b'\n']);
        }
        bytes.push(b'\n');
        if let Some(index) = garbled {
            self.setup.garble.remove(index);
        }
        self.send(&bytes);
    }

    fn reply(&mut self, command: &str, status: &str, lines: &[&str]) {
        let mut bytes = format!("{command}\n").into_bytes();
        for line in std::iter::once(&status).chain(lines) {
            bytes.extend_from_slice(line.as_bytes());
            bytes.extend_from_slice(&[codec::checksum(line.as_bytes()), b'\n']);
        }
        bytes.push(b'\n');
        self.send(&bytes);
    }

    fn send_scan(&mut self, command: &str, start: Instant, order: Option<Order>) {
        if let Some(Order::Status(status)) = order {
            return self.reply(command, status, &[]);
        }
        let number = |range: std::ops::Range<usize>| command[range].parse::<usize>().unwrap();
        let steps = number(6..10) - number(2..6) + 1;
        let beams = steps.div_ceil(number(10..12).max(1));
        let characters = if command.starts_with("MD") { 3 } else { 2 };
        let mut data = vec![0; characters * beams];
        for (beam, value) in data.chunks_mut(characters).enumerate() {
            assert!(codec::encode(beam as u32, value));
        }
        let mut bytes = format!("{command}\n99b\n").into_bytes();
        let stamp = self.stamp(start);
        for payload in std::iter::once(stamp.as_bytes()).chain(data.chunks(codec::LINE_DATA_BYTES))
        {
            bytes.extend_from_slice(payload);
            bytes.extend_from_slice(&[codec::checksum(payload), b'\n']);
        }
        bytes.push(b'\n');
        match order {
            Some(Order::WrongChecksum) => bytes[100] ^= 1,
            Some(Order::Truncate(length)) => bytes.truncate(length),
            Some(Order::Garbage(garbage)) => bytes.splice(..0, garbage).for_each(drop),
            Some(Order::PauseWithin(begun)) => {
                let rest = bytes.split_off(bytes.len() / 2);
                self.send(&bytes);
                // Nobody need hear it, and who unplugs it ends the pause, too.
                let _ = begun.send(());
                while let Ok(Order::Clock(ms)) = self.orders.recv() {
                    self.set_clock(ms);
                }
                bytes = rest;
            }
            _ => {}
        }
        self.send(&bytes);
    }

    fn set_clock(&mut self, ms: u32) {
        self.clock_0 = Instant::now() - Duration::from_millis(ms.into());
    }

    fn send(&mut self, bytes: &[u8]) {
        let garbled: Vec<u8>;
        let mut rest = bytes;
        if !self.understands_host() {
            garbled = bytes
                .iter()
                .map(|byte| byte.rotate_left(3) ^ 0x55)
                .collect();
            rest = &garbled;
        }
        // What the host does not take in time is lost, as on a wire. A machine that is busy takes its time.
        let until = Instant::now() + Duration::from_secs(3);
        while Instant::now() < until && !self.unplugged.load(Ordering::Relaxed) {
            match self.master.write(rest) {
                Ok(count) => rest = &rest[count..],
                Err(_) => std::thread::sleep(Duration::from_millis(1)),
            }
            if rest.is_empty() {
                return;
            }
        }
    }
}
