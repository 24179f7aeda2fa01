//! What the kernel tells of the computer, as files below `/proc`, `/sys`, `/run` and `/dev`.

use std::fs;
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

    /// Programs that have a file open of which `is` holds; only of the same user, unless this one is root.
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
}

/// Programs as people write them: `a (17), b (4)`.
pub fn listed(programs: &[Program]) -> String {
    let each = |program: &Program| format!("{} ({})", program.name, program.pid);
    programs.iter().map(each).collect::<Vec<_>>().join(", ")
}

/// What ends programs; none where there are none.
pub fn end_all(programs: &[Program]) -> Option<String> {
    let numbers: Vec<String> = programs.iter().map(|own| own.pid.to_string()).collect();
    (!numbers.is_empty()).then(|| format!("sudo kill {}", numbers.join(" ")))
}

#[cfg(test)]
pub mod tests {
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
    fn this_process_runs_on_this_computer() {
        let pid = std::process::id();
        assert!(
            { Computer::this().programs() }
                .iter()
                .any(|own| own.pid == pid)
        );
    }
}
