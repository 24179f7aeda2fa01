//! What the running program keeps from other users of its computer.

use std::fs::{self, File, Permissions};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use mediator::runtime::{Answer, Question, ask};
use rustix::process::{Pid, Signal, Uid, kill_process};
use tempfile::TempDir;

use crate::program::folder;

const SITE: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../config/sites/overtaking.toml"
);
const PATIENCE: Duration = Duration::from_secs(60);

/// A mediator that was told no folder, in a home of its own; killed when dropped.
struct AtHome {
    home: TempDir,
    child: Child,
}

impl AtHome {
    /// As a user begins it, whose own umask lets everybody read.
    fn command(home: &Path) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_mediator"));
        command
            .args(["run", "--first-start", "--listen", "tcp/127.0.0.1:0"])
            .args(["--site", SITE])
            .env("HOME", home)
            .env("XDG_RUNTIME_DIR", home.join("run"))
            .env_remove("XDG_STATE_HOME")
            .env_remove("MEDIATOR_RUNTIME_DIR")
            .env_remove("MEDIATOR_LOG")
            .stdin(Stdio::null())
            .stdout(Stdio::null());
        command
    }

    fn start() -> Self {
        let home = folder();
        let log = File::create(home.path().join("log")).expect("a log");
        let child = Self::command(home.path()).stderr(log).spawn();
        let started = Self {
            child: child.expect("the program starts"),
            home,
        };
        let until = Instant::now() + PATIENCE;
        while let Err(error) = ask(&started.socket(), &Question::Status) {
            let log = fs::read_to_string(started.home.path().join("log"));
            assert!(Instant::now() < until, "{error}: {log:?}");
            std::thread::sleep(Duration::from_millis(10));
        }
        started
    }

    fn socket(&self) -> PathBuf {
        self.home.path().join("run/mediator/overtaking.ctl")
    }

    fn end(mut self) {
        let pid = Pid::from_child(&self.child);
        kill_process(pid, Signal::TERM).expect("it runs");
        assert!(self.child.wait().expect("it was our child").success());
        assert!(!self.socket().exists());
    }
}

impl Drop for AtHome {
    fn drop(&mut self) {
        // Both fail harmlessly when it has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// All files and folders below a folder.
fn below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("readable").flatten() {
        let path = entry.path();
        if entry.file_type().expect("readable").is_dir() {
            below(&path, found);
        }
        found.push(path);
    }
}

/// What an operator writes comes to terminals of others.
#[test]
fn a_text_that_could_move_somebodys_cursor_is_refused() {
    let program = AtHome::start();
    let asked = |area: &str, why: &str| {
        let (area, why) = (area.to_owned(), why.to_owned());
        ask(&program.socket(), &Question::Close { area, why }).expect("it answers")
    };
    for (area, why) in [("3", "\u{1b}[2J"), ("3\n", ""), ("3", &"x".repeat(257))] {
        let answer = asked(area, why);
        let refused =
            matches!(&answer, Answer::Refused(text) if text.contains("control characters"));
        assert!(refused, "{answer:?}");
    }
    assert!(matches!(asked("3", "wet floor \u{1f6a7}"), Answer::Done(_)));
    // Nor does it look like an order of somebody else to who reads what was ordered.
    let line = "2026-01-01T12:00:00Z operator bob: absent amr-1: done: said";
    let area = format!("x\n{line}{}", "x".repeat(3000));
    let asked = Question::Clear {
        area,
        taken_away: true,
    };
    let answer = ask(&program.socket(), &asked).expect("it answers");
    assert!(matches!(answer, Answer::Refused(_)), "{answer:?}");
    let Ok(Answer::Orders(orders)) = ask(&program.socket(), &Question::Orders) else {
        panic!("it tells what was ordered");
    };
    assert_eq!(orders.len(), 5, "{orders:?}");
    for order in &orders {
        let told = [&order.at, &order.who, &order.order, &order.answer];
        let fits = |text: &String| text.len() < 400 && !text.chars().any(char::is_control);
        assert!(told.into_iter().all(fits), "{order:?}");
    }
    program.end();
}

#[test]
fn nobody_else_can_reach_anything_that_it_makes() {
    let program = AtHome::start();
    let home = program.home.path();
    let mut made = Vec::new();
    below(home, &mut made);
    // The test's own.
    made.retain(|path| !path.ends_with("log"));
    for path in &made {
        let mode = fs::symlink_metadata(path).expect("it is there").mode();
        assert_eq!(mode & 0o077, 0, "{mode:o} {}", path.display());
    }
    for expected in [
        program.socket(),
        home.join(".local/state/mediator/overtaking.redb"),
    ] {
        assert!(made.contains(&expected), "{}", expected.display());
    }
    program.end();
}

#[test]
fn another_user_is_refused_in_a_sentence_even_where_somebody_has_opened_the_folder() {
    if !rustix::process::geteuid().is_root() {
        eprintln!("skipped: only root can be another user");
        return;
    }
    let program = AtHome::start();
    let socket = program.socket();
    let folders = socket.ancestors().skip(1);
    for folder in folders.take_while(|folder| folder.starts_with(program.home.path())) {
        fs::set_permissions(folder, Permissions::from_mode(0o755)).expect("it is ours");
    }
    fs::set_permissions(&socket, Permissions::from_mode(0o666)).expect("it is ours");
    let stranger = std::thread::spawn(move || {
        // The system call itself, which is for one thread.
        let uid = Uid::from_raw(65534);
        rustix::thread::set_thread_res_uid(uid, uid, uid).expect("root may");
        let mut stream = UnixStream::connect(socket).expect("connects");
        let absent = Question::Absent {
            taken_away: false,
            robot: "amr-1".into(),
        };
        writeln!(stream, "{}", serde_json::json!(absent)).expect("written");
        let mut answer = String::new();
        BufReader::new(stream)
            .read_line(&mut answer)
            .expect("answered");
        answer
    });
    let answer = stranger.join().expect("ends");
    let expected = Answer::Refused("user 65534 may not ask, only user 0 and root".into());
    assert_eq!(serde_json::from_str::<Answer>(&answer).ok(), Some(expected));
    program.end();
}

#[test]
fn a_folder_that_others_reach_is_refused_with_what_to_do() {
    let home = folder();
    let folder = home.path().join("run/mediator");
    fs::create_dir_all(&folder).expect("made");
    fs::set_permissions(&folder, Permissions::from_mode(0o755)).expect("it is ours");
    let child = AtHome::command(home.path())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut program = AtHome { home, child };
    let began = Instant::now();
    let status = loop {
        match program.child.try_wait().expect("it is our child") {
            Some(status) => break status,
            None => assert!(began.elapsed() < PATIENCE, "it runs, and should not"),
        }
        std::thread::sleep(Duration::from_millis(10));
    };
    let stderr = program.child.stderr.take().expect("it has one");
    let said = std::io::read_to_string(stderr).expect("text");
    assert_eq!(status.code(), Some(2), "{said}");
    let command = format!("chmod 0700 {}", folder.display());
    assert!(said.contains(&command), "{said}");
    assert!(said.contains("--runtime names another"), "{said}");
}
