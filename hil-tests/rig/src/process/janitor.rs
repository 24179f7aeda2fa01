//! Removes what a rig leaves that was killed, its folder and the shared memory of its robots: a process that waits for the
//! rig's end and does nothing else.

use std::ffi::OsString;
use std::fs;
use std::io::{self, Read};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use coordination::symbols::remove_all_stale;
use onboard::process::runtime::Runtime;

/// Hidden subcommand by which this program becomes a janitor.
pub const SUBCOMMAND: &str = "__janitor";

/// Robots and mediator end by themselves when the rig does. The janitor waits at most this long for that.
const PATIENCE: Duration = Duration::from_secs(12);
/// How often it looks.
const LOOK: Duration = Duration::from_millis(50);

/// A running janitor. Dropping it lets it remove the folder, and waits for that.
#[derive(Debug)]
pub struct Janitor(Child);

impl Janitor {
    /// Starts one for this folder. It learns of the rig's end by its standard input, which only the rig holds open.
    ///
    /// # Errors
    /// The operating system's.
    pub fn start(program: &Path, folder: &Path) -> io::Result<Self> {
        Command::new(program)
            .arg(SUBCOMMAND)
            .arg(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .process_group(0)
            .spawn()
            .map(Self)
    }
}

impl Drop for Janitor {
    fn drop(&mut self) {
        drop(self.0.stdin.take());
        // It ends by itself.
        let _ = self.0.wait();
    }
}

/// What the janitor's process does.
#[must_use]
pub fn main_from(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let Some(folder) = arguments.into_iter().next().map(PathBuf::from) else {
        return ExitCode::FAILURE;
    };
    // Nothing is ever written: it ends when the rig does.
    let _ = io::stdin().read_to_end(&mut Vec::new());
    let since = Instant::now();
    // One that was just starting has nothing in the folder yet, and would make it anew.
    while is_used(&folder) && since.elapsed() < PATIENCE {
        std::thread::sleep(LOOK);
    }
    for runtime in runtime_folders(&folder) {
        // Of robots that ran in the rig itself; the others have removed theirs.
        if let Ok(runtime) = Runtime::new(Some(runtime)) {
            let _ = remove_all_stale(&runtime.place());
        }
    }
    match fs::remove_dir_all(&folder) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => ExitCode::FAILURE,
        _ => ExitCode::SUCCESS,
    }
}

/// This folder and those in it.
fn runtime_folders(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let below = { entries.map(|entry| entry.path()) }.filter(|path| path.is_dir());
    std::iter::once(folder.to_owned()).chain(below)
}

/// Whether a process was started with something in this folder, as robots and mediator are, or may have been: one that was
/// just started has a program for a moment, and no command yet.
fn is_used(folder: &Path) -> bool {
    let name = folder.as_os_str().as_bytes();
    let processes = fs::read_dir("/proc").into_iter().flatten().flatten();
    processes
        // `self` is there as well.
        .filter_map(|process| Some((process.file_name().to_str()?.parse::<u32>().ok()?, process.path())))
        .filter(|(id, _)| *id != std::process::id())
        .filter_map(|(_, process)| Some((fs::read(process.join("cmdline")).ok()?, process)))
        .any(|(line, process)| {
            let starting = || line.is_empty() && fs::read_link(process.join("exe")).is_ok();
            line.windows(name.len()).any(|part| part == name) || starting()
        })
}
