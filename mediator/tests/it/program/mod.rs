//! The real `mediator run` as a process, a site file for it, and sessions for the robots that it talks to.
#![allow(
    dead_code,
    reason = "tests and benchmarks have their own choice of them"
)]

pub mod site;

use std::fs::{File, OpenOptions};
use std::io::{PipeReader, Write as _};
use std::net::{Ipv4Addr, TcpListener};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use contract::decode;
use contract::keys::InvalidName;
use contract::network::NetworkSettings;
use contract::wire::MediatorReport;
use mediator::manager::Status;
use mediator::runtime::{Answer, Question, ask};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use zenoh::Wait;

pub use site::Site;

/// A folder in memory: a compiler that keeps the disk busy would hold up a journal for longer than robots and operators wait.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir_in("/dev/shm").expect("a folder")
}

/// A free endpoint on the loopback. It has an address of its own: on the common one, the port of a program that is started again may
/// meanwhile be another one's, or that of any connection.
pub fn free_endpoint(protocol: &str) -> String {
    static LAST: AtomicU8 = AtomicU8::new(0);
    let [_, _, high, low] = std::process::id().to_be_bytes();
    let own = Ipv4Addr::new(
        127,
        high,
        low,
        1 + LAST.fetch_add(1, Ordering::Relaxed) % 254,
    );
    let address = TcpListener::bind((own, 0)).and_then(|socket| socket.local_addr());
    format!("{protocol}/{}", address.expect("a free port"))
}

/// A session that listens on the loopback, and where.
pub fn session(connect: &[String]) -> (zenoh::Session, String) {
    // Another program may take the port before it is used.
    for _ in 0..20 {
        let endpoint = free_endpoint("tcp");
        let settings = NetworkSettings {
            listen: vec![endpoint.clone()],
            connect: connect.to_vec(),
            ..NetworkSettings::default()
        };
        if let Ok(session) = settings.open() {
            return (session, endpoint);
        }
    }
    panic!("no session could be opened on the loopback");
}

/// The mediator's messages under this key, as they come. What cannot be read is left out.
pub fn hear(
    session: &zenoh::Session,
    key: Result<String, InvalidName>,
) -> Receiver<MediatorReport> {
    let (news, inbox) = channel();
    session
        .declare_subscriber(key.expect("a plain name"))
        .callback(move |sample| {
            if let Ok(message) = decode(&sample.payload().to_bytes()) {
                // After the end nobody listens.
                let _ = news.send(message);
            }
        })
        .background()
        .wait()
        .expect("it subscribes");
    inbox
}

/// A mediator that can be killed and started again with its journal. Killed when dropped.
pub struct Program {
    folder: PathBuf,
    site: String,
    connect: Vec<String>,
    listen: String,
    more: Vec<String>,
    /// How many files it may have open.
    most_files: Option<u64>,
    /// How much room the disk of its journal has, in KiB.
    disk_kib: Option<u64>,
    /// The end of its log that nobody reads.
    unread: Option<PipeReader>,
    child: Option<Child>,
}

impl Program {
    /// `folder` is its own, with the site file in `sites/`; it connects to all of `connect`.
    pub fn new(folder: &Path, site: &Site, connect: Vec<String>) -> Self {
        site.write(folder);
        Self {
            folder: folder.to_owned(),
            site: site.name.clone(),
            connect,
            listen: "tcp/127.0.0.1:0".into(),
            more: Vec::new(),
            most_files: None,
            disk_kib: None,
            unread: None,
            child: None,
        }
    }

    /// It listens there, and not somewhere.
    pub fn listen(&mut self, endpoint: &str) {
        endpoint.clone_into(&mut self.listen);
    }

    /// It is started with these arguments, too.
    pub fn add(&mut self, arguments: &[&str]) {
        self.more
            .extend(arguments.iter().map(|&text| text.to_owned()));
    }

    /// From its next start on it may have no more than so many files open.
    pub fn limit_files(&mut self, most: u64) {
        self.most_files = Some(most);
    }

    /// Its journal gets a disk of its own with so much room, which is gone with the process; says why that cannot be here.
    pub fn limit_disk(&mut self, kib: u64) -> Result<(), String> {
        let tried = Command::new("unshare")
            .args(["--mount", "mount", "-t", "tmpfs", "none", "/mnt"])
            .output()
            .map_err(|error| format!("unshare: {error}"))?;
        if !tried.status.success() {
            return Err(String::from_utf8_lossy(&tried.stderr).into_owned());
        }
        self.disk_kib = Some(kib);
        Ok(())
    }

    /// That disk of the running process, which only it has.
    pub fn disk(&self) -> PathBuf {
        let id = self.child.as_ref().map_or(0, Child::id);
        let own = self.folder.join("disk");
        Path::new(&format!("/proc/{id}/root"))
            .join(own.strip_prefix("/").expect("an absolute path"))
    }

    /// Its site file.
    pub fn site_file(&self) -> PathBuf {
        self.folder.join(format!("sites/{}.toml", self.site))
    }

    /// What another of its commands prints, on both outputs, and its exit code.
    pub fn command(arguments: &[&str]) -> (Option<i32>, String) {
        let output = Command::new(env!("CARGO_BIN_EXE_mediator"))
            .args(arguments)
            .env_remove("MEDIATOR_LOG")
            .env_remove("ZENOH_RUNTIME")
            .output()
            .expect("the program starts");
        let text = [output.stdout, output.stderr].concat();
        let text = String::from_utf8_lossy(&text).into_owned();
        (output.status.code(), text)
    }

    /// It is started with a log that takes no more, not even its first line.
    pub fn start_unread(&mut self) {
        let (reader, mut writer) = std::io::pipe().expect("a pipe");
        let flags = fcntl_getfl(&writer).expect("flags");
        fcntl_setfl(&writer, flags | OFlags::NONBLOCK).expect("set");
        while writer.write(&[b' '; 4096]).is_ok() {}
        while writer.write(b" ").is_ok() {}
        fcntl_setfl(&writer, flags).expect("set");
        self.unread = Some(reader);
        self.start_with(writer.into());
    }

    pub fn start(&mut self) {
        let path = self.folder.join("log");
        let log = OpenOptions::new().append(true).create(true).open(path);
        self.start_with(log.expect("a log").into());
    }

    fn start_with(&mut self, log: Stdio) {
        assert!(self.child.is_none(), "it runs already");
        let path = |name: &str| self.folder.join(name);
        let program = env!("CARGO_BIN_EXE_mediator");
        let mut journal = path("journal.redb");
        let mut command = match (self.most_files, self.disk_kib) {
            (None, None) => Command::new(program),
            (Some(most), _) => {
                let mut shell = Command::new("sh");
                let script = format!("ulimit -n {most} && exec \"$0\" \"$@\"");
                shell.args(["-c", &script, program]);
                shell
            }
            (None, Some(kib)) => {
                let disk = path("disk");
                std::fs::create_dir_all(&disk).expect("a folder");
                let mut shell = Command::new("unshare");
                let mount = format!("mount -t tmpfs -o size={kib}k,mode=0700 none \"$1\"");
                let script = format!("{mount} && shift && exec \"$0\" \"$@\"");
                shell.args(["--mount", "sh", "-c", &script, program]);
                shell.arg(&disk);
                journal = disk.join("journal.redb");
                shell
            }
        };
        command
            .args(["run", "--first-start"])
            .arg("--site")
            .arg(self.site_file())
            .arg("--journal")
            .arg(journal)
            .arg("--runtime")
            .arg(path("run"))
            .args(["--listen", &self.listen])
            .args(&self.more);
        for endpoint in &self.connect {
            command.args(["--connect", endpoint]);
        }
        command
            .env_remove("MEDIATOR_LOG")
            .env_remove("ZENOH_RUNTIME")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(log);
        self.child = Some(command.spawn().expect("the program starts"));
    }

    /// SIGKILL: it cannot clean up.
    pub fn kill(&mut self) {
        if let Some(mut child) = self.child.take() {
            // If it is dead already, the wait below says so.
            let _ = child.kill();
            let status = child.wait().expect("it was our child");
            assert!(
                status.code().is_none(),
                "it ended by itself with {status}: {}",
                self.log()
            );
        }
    }

    pub fn status(&self) -> Result<Status, String> {
        let socket = self.folder.join("run").join(format!("{}.ctl", self.site));
        match ask(&socket, &Question::Status)? {
            Answer::Status(status) => Ok(*status),
            answer => Err(format!("unexpected answer {answer:?}")),
        }
    }

    /// Waits until it answers.
    pub fn wait_ready(&self, longest: Duration) -> Status {
        let until = Instant::now() + longest;
        loop {
            match self.status() {
                Ok(status) => return status,
                Err(error) => assert!(Instant::now() < until, "{error}: {}", self.log()),
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// How many files the running process has open.
    pub fn open_files(&self) -> u64 {
        let id = self.child.as_ref().map_or(0, Child::id);
        let files = std::fs::read_dir(format!("/proc/{id}/fd"));
        files.map_or(0, |files| files.count() as u64)
    }

    /// Resident memory of the running process.
    pub fn rss_mib(&self) -> f64 {
        self.memory_mib("VmRSS:")
    }

    /// The most that it had so far.
    pub fn peak_mib(&self) -> f64 {
        self.memory_mib("VmHWM:")
    }

    /// By its name in proc_pid_status(5).
    fn memory_mib(&self, name: &str) -> f64 {
        let id = self.child.as_ref().map_or(0, Child::id);
        let status = std::fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix(name));
        let kib = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<f64>().ok());
        kib.map_or(f64::NAN, |kib| kib / 1024.0)
    }

    /// Processor time of the running process, by the kernel's clock ticks of 10 ms.
    pub fn cpu_time(&self) -> Duration {
        let id = self.child.as_ref().map_or(0, Child::id);
        let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
        // Behind the name, which may have spaces: fields 14 and 15 of proc_pid_stat(5).
        let fields = stat.rsplit(')').next().unwrap_or_default();
        let ticks = fields.split_whitespace().skip(11).take(2);
        let ticks: u64 = ticks.filter_map(|field| field.parse::<u64>().ok()).sum();
        Duration::from_millis(10 * ticks)
    }

    /// All it has said.
    pub fn log(&self) -> String {
        let log = File::open(self.folder.join("log")).and_then(std::io::read_to_string);
        log.unwrap_or_default()
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
