//! Other processes: this test binary runs itself again, as an owner or as an inspector.

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::fs::{MetadataExt, chown};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use coordination::symbols::{
    Inspector, Namespace, SymbolError, TableBuilder, remove_all_stale, remove_stale,
};

use rustix::process::{Signal, getpid, kill_process};

use crate::common::{Encoders, Room, shared_memory, small_table};

const ROLE: &str = "SYMBOLS_TEST_ROLE";
const ROOT: &str = "SYMBOLS_TEST_ROOT";
/// `nobody`, on most machines.
const STRANGER: u32 = 65534;

/// Not a test: what a child process does. It says `ready` and ends when its input does.
#[test]
fn child() {
    let (Ok(role), Some(root)) = (env::var(ROLE), env::var_os(ROOT)) else {
        return;
    };
    let place = Namespace::new(root, "test_");
    let wait = || {
        println!("\nready");
        std::io::stdout().flush().unwrap();
        let mut line = String::new();
        std::io::stdin().read_line(&mut line).unwrap();
    };
    match role.as_str() {
        "owner" => {
            let table = small_table("a", &place);
            let mut writer = table.writer::<Encoders>("drive", "drive").unwrap();
            let _reader = table.reader::<Encoders>("control", "drive").unwrap();
            let value = Encoders {
                left_rad: 1.5,
                right_rad: -1.5,
            };
            writer.write(77, &value);
            wait();
        }
        "killed while building" => {
            let mut builder = TableBuilder::new("a", &place);
            builder.declare::<Encoders>("drive", "drive").unwrap();
            // Ends this process at some moment of the construction.
            let fuse = Duration::from_micros(env::var("FUSE_US").unwrap().parse().unwrap());
            std::thread::spawn(move || {
                std::thread::sleep(fuse);
                kill_process(getpid(), Signal::KILL).unwrap();
            });
            let _table = builder.build();
            std::thread::sleep(Duration::from_secs(10));
        }
        "inspector" => {
            let inspector = Inspector::open("a", &place).unwrap();
            let mut reader = inspector.reader::<Encoders>("drive").unwrap();
            assert_eq!(reader.read().stamp_ns, 77);
            wait();
        }
        "owner with pages" => {
            let table = small_table("a", &place);
            let _first = table.add::<Encoders>("arm", "elbow").unwrap();
            let second = table.add::<Encoders>("arm", "wrist").unwrap();
            table.remove::<Encoders>("arm", "wrist").unwrap();
            wait();
            drop(second);
        }
        "follower" => {
            let inspector = Inspector::open("a", &place).unwrap();
            let ended = Arc::new(AtomicBool::new(false));
            let ends = Arc::clone(&ended);
            let follow = thread::spawn(move || {
                let look = || {
                    let mut reader = inspector.reader::<Encoders>("extra")?;
                    let value = reader.read().value;
                    assert_eq!(value.left_rad.to_bits(), value.right_rad.to_bits());
                    Ok(value.left_rad)
                };
                while !ends.load(Ordering::Relaxed) {
                    let directory = inspector.directory();
                    assert_eq!(&directory[0].model, "drive");
                    // It is there for less time than opening takes, most times.
                    if let Err(error) = look() {
                        assert!(matches!(error, SymbolError::Unknown { .. }), "{error}");
                    }
                }
                assert_eq!(inspector.directory().len(), 3);
                assert_eq!(look().unwrap(), -1.0, "the one that is there at the end");
            });
            wait();
            ended.store(true, Ordering::Relaxed);
            follow.join().unwrap();
        }
        "late inspector" => assert!(Inspector::open("a", &place).is_err()),
        role => panic!("no role {role}"),
    }
}

/// A process that reads the symbol `extra` whenever it is there.
pub fn follower(room: &Room) -> Process {
    Process::ready("follower", room)
}

/// A child in one role; killed with SIGKILL when dropped.
pub struct Process {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
}

impl Process {
    fn start(role: &str, room: &Room, fuse: Duration) -> Self {
        let mut child = Command::new(env::current_exe().unwrap())
            .args([
                "--exact",
                "processes::child",
                "--nocapture",
                "--test-threads=1",
            ])
            .env(ROLE, role)
            .env(ROOT, room.root())
            .env("FUSE_US", fuse.as_micros().to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let input = child.stdin.take();
        let output = BufReader::new(child.stdout.take().unwrap());
        Self {
            child,
            input,
            output,
        }
    }

    fn ready(role: &str, room: &Room) -> Self {
        let mut process = Self::start(role, room, Duration::ZERO);
        let mut line = String::new();
        while line != "ready\n" {
            line.clear();
            let length = process.output.read_line(&mut line).unwrap();
            assert_ne!(length, 0, "{role} ended early");
        }
        process
    }

    pub fn end(mut self) {
        self.input = None;
        assert!(self.child.wait().unwrap().success());
    }

    fn kill(mut self) -> u32 {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
        self.child.id()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // Both fail harmlessly when the child has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn another_process_lists_and_reads_a_running_robot() {
    let room = Room::new();
    let owner = Process::ready("owner", &room);
    let words = room.words();
    let inspector = Inspector::open("a", &room.place).unwrap();
    assert_eq!(inspector.pid(), owner.child.id());
    let directory = inspector.directory();
    assert_eq!(directory.len(), 2);
    assert_eq!(directory[0].readers, ["control"]);
    let mut reader = inspector.reader::<Encoders>("drive").unwrap();
    let read = reader.read();
    assert_eq!(read.stamp_ns, 77);
    assert_eq!((read.value.left_rad, read.value.right_rad), (1.5, -1.5));

    owner.end();
    assert!(!inspector.is_alive());
    assert_eq!(reader.read().stamp_ns, 77);
    assert!(Inspector::open("a", &room.place).is_err());
    drop((inspector, reader));
    room.assert_nothing_left(&words);
}

#[test]
fn no_other_user_can_reach_what_a_running_robot_and_those_who_look_at_it_share() {
    let room = Room::new();
    let owner = Process::ready("owner", &room);
    let words = room.words();
    let inspector = Process::ready("inspector", &room);
    let shared = shared_memory(&words);
    assert!(!shared.is_empty());
    let objects = shared.iter().map(|name| Path::new("/dev/shm").join(name));
    let objects = objects.chain([room.root().to_owned()]);
    // Below the root, what others may do does not matter: they do not get there.
    for object in objects.chain(room.files().iter().map(|name| room.root().join(name))) {
        let mode = fs::metadata(&object).unwrap().mode();
        assert_eq!(mode & 0o077, 0, "{mode:o} {}", object.display());
    }
    inspector.end();
    owner.end();
    room.assert_nothing_left(&words);
}

/// Whoever learns the word of a run can put something of that name into the folder that all users share.
#[test]
fn shared_memory_that_is_another_users_keeps_nobody_from_cleaning_up() {
    if !rustix::process::geteuid().is_root() {
        eprintln!("skipped: only root can be two users");
        return;
    }
    let room = Room::new();
    let word = format!(
        "{:012x}",
        0xdead_0000_0000_u64 | u64::from(std::process::id())
    );
    let run = room.root().join(format!("a.{word}"));
    fs::create_dir_all(&run).unwrap();
    for folder in [room.root().parent().unwrap(), room.root(), &run] {
        chown(folder, Some(STRANGER), None).unwrap();
    }
    let roots = Path::new("/dev/shm").join(format!("taken_{word}_"));
    fs::write(&roots, "").unwrap();
    let place = room.place.clone();
    let removed = std::thread::spawn(move || {
        // The system call itself, which is for one thread.
        let uid = rustix::process::Uid::from_raw(STRANGER);
        rustix::thread::set_thread_res_uid(uid, uid, uid).unwrap();
        remove_stale("a", &place)
    });
    let removed = removed.join().unwrap();
    fs::remove_file(&roots).unwrap();
    assert_eq!(removed.unwrap().paths, [run]);
    room.assert_nothing_left(&[word]);
}

#[test]
fn a_second_process_is_refused_with_the_first_ones_pid() {
    let room = Room::new();
    let owner = Process::ready("owner", &room);
    let words = room.words();
    let mut builder = TableBuilder::new("a", &room.place);
    builder.declare::<Encoders>("drive", "drive").unwrap();
    let message = format!("robot `a` already runs (pid {})", owner.child.id());
    assert_eq!(builder.build().unwrap_err().to_string(), message);
    assert_eq!(
        remove_stale("a", &room.place).unwrap_err().to_string(),
        message
    );
    owner.end();
    room.assert_nothing_left(&words);
}

#[test]
fn what_a_killed_owner_leaves_can_be_removed() {
    let room = Room::new();
    let owner = Process::ready("owner", &room);
    let words = room.words();
    let pid = owner.kill();
    assert!(
        !shared_memory(&words).is_empty(),
        "there is something to remove"
    );
    assert_eq!(room.files().len(), 2);

    match Inspector::open("a", &room.place).unwrap_err() {
        SymbolError::NotRunning { dead_pid, .. } => assert_eq!(dead_pid, Some(pid)),
        error => panic!("{error}"),
    }
    let removed = remove_stale("a", &room.place).unwrap();
    assert_eq!(removed.pid, Some(pid));
    assert!(removed.paths.len() > 2, "{removed:?}");
    room.assert_nothing_left(&words);
    assert!(remove_stale("a", &room.place).unwrap().is_empty());
}

#[test]
fn pages_of_a_killed_owner_are_swept_by_the_next_start() {
    let room = Room::new();
    let owner = Process::ready("owner with pages", &room);
    let mut words = room.words();
    let with_pages = shared_memory(&words).len();
    owner.kill();
    assert_eq!(
        shared_memory(&words).len(),
        with_pages,
        "there is something to remove"
    );
    let table = small_table("a", &room.place);
    assert_eq!(shared_memory(&words), [""; 0]);
    words.extend(room.words());
    drop(table);
    room.assert_nothing_left(&words);
}

#[test]
fn what_all_killed_owners_left_can_be_removed_and_the_living_are_left_alone() {
    let room = Room::new();
    let owner = Process::ready("owner", &room);
    let words = room.words();
    let pid = owner.kill();
    let living = small_table("b", &room.place);
    let removed = remove_all_stale(&room.place).unwrap();
    let pids: Vec<_> = removed.iter().map(|removed| removed.pid).collect();
    assert_eq!(pids, [Some(pid)]);
    assert_eq!(shared_memory(&words), [""; 0]);
    assert!(Inspector::open("b", &room.place).unwrap().is_alive());
    drop(living);
    room.assert_nothing_left(&words);
}

#[test]
fn a_robot_starts_again_after_it_was_killed() {
    let room = Room::new();
    let owner = Process::ready("owner", &room);
    let mut words = room.words();
    let pid = owner.kill();
    let table = small_table("a", &room.place);
    assert_eq!(table.removed_at_start().pid, Some(pid));
    assert_eq!(shared_memory(&words), [""; 0]);
    words.extend(room.words());
    drop(table);
    room.assert_nothing_left(&words);
}

#[test]
fn killed_inspectors_leave_nothing_behind_either() {
    let room = Room::new();
    let owner = Process::ready("owner", &room);
    let words = room.words();
    for _ in 0..3 {
        Process::ready("inspector", &room).kill();
    }
    let inspector = Inspector::open("a", &room.place).unwrap();
    assert!(inspector.is_alive());
    owner.end();
    let mut late = Process::start("late inspector", &room, Duration::ZERO);
    assert!(
        late.child.wait().unwrap().success(),
        "refused, and not hanging"
    );
    drop(inspector);
    room.assert_nothing_left(&words);
}

#[test]
fn an_owner_killed_at_any_moment_of_its_start_can_be_removed() {
    let room = Room::new();
    let mut left = BTreeSet::new();
    for step in 0..60 {
        // On a machine that has other things to do an owner is not far yet when it is killed.
        if step >= 20 && left.len() >= 2 {
            break;
        }
        let fuse = Duration::from_micros(60 * step * step);
        let mut owner = Process::start("killed while building", &room, fuse);
        owner.child.wait().unwrap();
        let words = room.words();
        assert!(Inspector::open("a", &room.place).is_err());
        let removed = remove_stale("a", &room.place).unwrap();
        room.assert_nothing_left(&words);
        left.insert(removed.paths.len());
    }
    // Otherwise the moments were all too early or all too late, and nothing was tested.
    assert!(left.len() >= 2, "{left:?}");
}
