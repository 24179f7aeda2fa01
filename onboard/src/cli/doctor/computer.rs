//! What the kernel tells of the computer, as files below `/proc`, `/sys`, `/run` and `/dev`.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The files of a computer: those of this one, or in a test a folder with some of them.
#[derive(Clone, Debug)]
pub struct Computer {
    root: PathBuf,
}

/// A program that runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Program {
    /// Its number.
    pub pid: u32,
    /// Its name, of which the kernel keeps 15 bytes.
    pub name: String,
}

impl Program {
    /// It is ours, which drives a robot.
    pub fn is_a_robot(&self) -> bool {
        self.name == "onboard"
    }
}

impl Computer {
    /// This one.
    pub fn this() -> Self {
        Self::below("/")
    }

    /// The one whose files are below `root`.
    pub fn below(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    fn at(&self, path: &str) -> PathBuf {
        self.root.join(path.trim_start_matches('/'))
    }

    /// The text of a file without the white space around it; none if it cannot be read.
    pub fn text(&self, path: &str) -> Option<String> {
        let bytes = fs::read(self.at(path)).ok()?;
        Some(String::from_utf8_lossy(&bytes).trim().to_owned())
    }

    /// The number in a file.
    pub fn number<T: std::str::FromStr>(&self, path: &str) -> Option<T> {
        self.text(path)?.parse().ok()
    }

    /// Whether there is such a file or folder.
    pub fn has(&self, path: &str) -> bool {
        self.at(path).exists()
    }

    /// The names in a folder, in order; none where it cannot be read.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.at(folder)).into_iter().flatten();
        let mut names: Vec<String> = entries
            .flatten()
            .filter_map(|entry| entry.file_name().into_string().ok())
            .collect();
        names.sort();
        names
    }

    /// Where a symbolic link leads to, whether that exists or not.
    pub fn link(&self, path: &str) -> Option<PathBuf> {
        fs::read_link(self.at(path)).ok()
    }

    /// All programs that run.
    pub fn programs(&self) -> Vec<Program> {
        let named = |folder: String| {
            let pid = folder.parse().ok()?;
            let name = self.text(&format!("/proc/{pid}/comm"))?;
            Some(Program { pid, name })
        };
        self.names("/proc").into_iter().filter_map(named).collect()
    }

    /// The first program of this name that runs.
    pub fn runs(&self, name: &str) -> Option<Program> {
        let short: String = name.chars().take(15).collect();
        self.programs().into_iter().find(|own| own.name == short)
    }

    /// Programs that have a file open of which `is` holds, among those that this user may look into.
    pub fn who_has_open(&self, is: impl Fn(&Path) -> bool) -> Vec<Program> {
        let has = |program: &Program| {
            let folder = format!("/proc/{}/fd", program.pid);
            let numbers = self.names(&folder);
            let mut open = numbers
                .iter()
                .filter_map(|number| self.link(&format!("{folder}/{number}")));
            open.any(|target| is(&target))
        };
        self.programs().into_iter().filter(has).collect()
    }

    /// Whether this user may look into all programs, as root may: else somebody may have open what nobody seems to.
    pub fn sees_all(&self) -> bool {
        let is_denied = |error: io::Error| error.kind() == io::ErrorKind::PermissionDenied;
        let hides = |pid: &str| match fs::read_dir(self.at(&format!("/proc/{pid}/fd"))) {
            Ok(entries) => entries
                .flatten()
                .any(|entry| fs::read_link(entry.path()).is_err_and(is_denied)),
            // One that has ended meanwhile hides nothing.
            Err(error) => is_denied(error),
        };
        let names = self.names("/proc");
        let mut programs = { names.iter() }.filter(|name| name.parse::<u32>().is_ok());
        // Where programs of others are not even listed (proc(5), `hidepid`), the first of all is missing.
        self.has("/proc/1") && !programs.any(|pid| hides(pid))
    }
}

/// It is one robot's program and nobody else's.
pub fn is_one_robot(programs: &[Program]) -> bool {
    matches!(programs, [only] if only.is_a_robot())
}

/// Programs as people write them: `a (17), b (4)`.
pub fn listed(programs: &[Program]) -> String {
    let each = |program: &Program| format!("{} ({})", program.name, program.pid);
    programs.iter().map(each).collect::<Vec<_>>().join(", ")
}

/// What ends those that are no robot's; among robots alone what tells them apart.
pub fn end_rivals(programs: &[Program]) -> String {
    let numbers = |robots: bool| -> Vec<String> {
        { programs.iter() }
            .filter(|own| own.is_a_robot() == robots)
            .map(|own| own.pid.to_string())
            .collect()
    };
    let rivals = numbers(false);
    if rivals.is_empty() {
        format!(
            "ps -o pid,user,args -p {}   # which one is to drive? end the others",
            numbers(true).join(",")
        )
    } else {
        format!("sudo kill {}", rivals.join(" "))
    }
}

#[cfg(test)]
pub mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    /// A computer with these files.
    pub struct Fake {
        folder: tempfile::TempDir,
    }

    impl Fake {
        /// With nothing.
        pub fn new() -> Self {
            let folder = tempfile::tempdir().expect("a folder");
            Self { folder }
        }

        /// With one file more.
        #[must_use]
        pub fn with(self, path: &str, text: &str) -> Self {
            let path = self.path(path);
            fs::write(path, text).expect("written");
            self
        }

        /// With one symbolic link more.
        #[must_use]
        pub fn linking(self, path: &str, target: &str) -> Self {
            std::os::unix::fs::symlink(target, self.path(path)).expect("made");
            self
        }

        fn path(&self, path: &str) -> PathBuf {
            let path = self.folder.path().join(path.trim_start_matches('/'));
            fs::create_dir_all(path.parent().expect("it has one")).expect("made");
            path
        }

        /// To be looked at.
        pub fn computer(&self) -> Computer {
            Computer::below(self.folder.path())
        }
    }

    #[test]
    fn programs_are_found_by_name_and_by_what_they_have_open() {
        let fake = Fake::new()
            .with("/proc/17/comm", "ModemManager\n")
            .linking("/proc/17/fd/3", "/dev/ttyACM0")
            .with("/proc/18/comm", "systemd-networkd\n")
            .with("/proc/uptime", "1.0 2.0\n");
        let computer = fake.computer();
        assert_eq!(computer.runs("ModemManager").map(|own| own.pid), Some(17));
        // The kernel keeps 15 bytes of a name, as it is written here whole it is another one.
        assert_eq!(computer.runs("systemd-networkd"), None);
        let open = computer.who_has_open(|path| path == Path::new("/dev/ttyACM0"));
        assert_eq!(listed(&open), "ModemManager (17)");
        assert_eq!(computer.number::<u32>("/proc/uptime"), None);
        assert_eq!(computer.names("/nowhere"), Vec::<String>::new());
    }

    #[test]
    fn programs_that_are_not_listed_or_may_not_be_looked_into_hide_what_they_have_open() {
        let fake = Fake::new()
            .with("/proc/17/comm", "cat\n")
            .linking("/proc/17/fd/3", "/dev/ttyACM0");
        assert!(!fake.computer().sees_all(), "the first is not listed");
        let fake = fake.with("/proc/1/comm", "systemd\n");
        assert!(fake.computer().sees_all());
        if rustix::process::geteuid().is_root() {
            eprintln!("SKIPPED in part: root may look into all");
            return;
        }
        let locked = fake.path("/proc/18/fd/0");
        let locked = locked.parent().expect("it has one");
        let allow = |mode| {
            let permissions = fs::Permissions::from_mode(mode);
            fs::set_permissions(locked, permissions).expect("it is ours");
        };
        allow(0o000);
        assert!(!fake.computer().sees_all());
        allow(0o700);
        assert!(fake.computer().sees_all());
    }

    #[test]
    fn rivals_are_ended_and_robots_told_apart() {
        let program = |pid, name: &str| Program {
            pid,
            name: name.to_owned(),
        };
        let robot = program(40, "onboard");
        let other = program(41, "ec_master");
        assert_eq!(end_rivals(&[robot.clone(), other]), "sudo kill 41");
        let two = [robot.clone(), program(42, "onboard")];
        assert!(end_rivals(&two).starts_with("ps -o pid,user,args -p 40,42 "));
        assert!(is_one_robot(&[robot]) && !is_one_robot(&two) && !is_one_robot(&[]));
    }

    #[test]
    fn this_process_runs_on_this_computer() {
        let pid = std::process::id();
        assert!(
            { Computer::this().programs() }
                .iter()
                .any(|own| own.pid == pid)
        );
    }
}
