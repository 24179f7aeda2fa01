//! The folder in which running robots leave their names: control sockets and the root of their shared memory. And the one on
//! disk, for what outlives the machine's being switched off.

use std::fs;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};

use contract::private;
use coordination::symbols::Namespace;

use crate::composition::failure::Failure;

/// Where running robots of this user are found.
#[derive(Clone, Debug)]
pub struct Runtime {
    folder: PathBuf,
    lasting: PathBuf,
}

impl Runtime {
    /// The folder given, else `$XDG_RUNTIME_DIR/onboard`, else `/tmp/onboard-UID`; made when it is missing. And one on disk: the
    /// same if it was given, else `$XDG_STATE_HOME/onboard`, else `~/.local/state/onboard`, else the same. Both are private.
    ///
    /// # Errors
    /// [`Failure::Refused`] when it cannot be made, or others can reach it.
    pub fn new(folder: Option<PathBuf>) -> Result<Self, Failure> {
        let uid = rustix::process::geteuid().as_raw();
        let variable = |name| std::env::var_os(name).map(PathBuf::from);
        let (folder, lasting) = folder.map_or_else(
            || {
                let folder = match variable("XDG_RUNTIME_DIR") {
                    Some(base) => base.join("onboard"),
                    None => PathBuf::from(format!("/tmp/onboard-{uid}")),
                };
                let lasting = variable("XDG_STATE_HOME")
                    .or_else(|| Some(variable("HOME")?.join(".local/state")))
                    .map_or(folder.clone(), |base| base.join("onboard"));
                (folder, lasting)
            },
            |given| (given.clone(), given),
        );
        private_folder(&folder, "runtime")?;
        Ok(Self { folder, lasting })
    }

    /// With this folder on disk instead, if there is one.
    #[must_use]
    pub fn lasting_in(self, folder: Option<PathBuf>) -> Self {
        Self {
            lasting: folder.unwrap_or(self.lasting),
            ..self
        }
    }

    /// The folder for what outlives the machine's being switched off; made when it is missing.
    ///
    /// # Errors
    /// [`Failure::Refused`] when it cannot be made, or others can reach it.
    pub fn lasting(&self) -> Result<&Path, Failure> {
        private_folder(&self.lasting, "state")?;
        Ok(&self.lasting)
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The robot's control socket.
    #[must_use]
    pub fn socket(&self, robot_id: &str) -> PathBuf {
        self.folder.join(format!("{robot_id}.ctl"))
    }

    /// Where the shared memory of this folder's robots lives. The prefix is drawn from the folder's name, so that
    /// robots in different folders never meet.
    #[must_use]
    pub fn place(&self) -> Namespace {
        let hash = self
            .folder
            .as_os_str()
            .as_encoded_bytes()
            .iter()
            .fold(0xcbf2_9ce4_8422_2325_u64, |hash, &byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            });
        Namespace {
            root: self.folder.join("symbols"),
            prefix: format!("ob{:08x}_", (hash >> 32) ^ (hash & 0xffff_ffff)),
        }
    }

    /// Ids of the robots that have a control socket here.
    #[must_use]
    pub fn robots(&self) -> Vec<String> {
        let mut robots: Vec<String> = fs::read_dir(&self.folder)
            .into_iter()
            .flatten()
            .filter_map(|entry| {
                entry
                    .ok()?
                    .file_name()
                    .to_str()?
                    .strip_suffix(".ctl")
                    .map(str::to_owned)
            })
            .collect();
        robots.sort();
        robots
    }

    /// The robot that was asked for, or the only one there is.
    ///
    /// # Errors
    /// [`Failure::Refused`] when none runs, or when several do and none was named.
    pub fn choose(&self, wanted: Option<&str>) -> Result<String, Failure> {
        let mut robots = self.robots();
        if wanted.is_none() && robots.len() > 1 {
            // One that was killed leaves its socket behind.
            robots.retain(|id| UnixStream::connect(self.socket(id)).is_ok());
        }
        match (wanted, robots.as_slice()) {
            (Some(id), found) if found.iter().any(|robot| robot == id) => Ok(id.to_owned()),
            (None, [only]) => Ok(only.clone()),
            (_, []) => Err(Failure::refused(format_args!(
                "no robot runs in {}; if it runs in another folder, name that with --runtime",
                self.folder.display()
            ))),
            (None, found) => Err(Failure::refused(format_args!(
                "several robots run: {}; name one with --robot",
                found.join(", ")
            ))),
            (Some(id), found) => Err(Failure::refused(format_args!(
                "robot `{id}` does not run here; running: {}",
                found.join(", ")
            ))),
        }
    }
}

/// Makes a folder that is nobody else's, and says which option names another.
fn private_folder(folder: &Path, name: &str) -> Result<(), Failure> {
    private::folder(folder).map_err(|why| {
        Failure::refused(format_args!("{name} folder: {why}; --{name} names another"))
    })
}

/// A temporary folder as [`Runtime::new`] wants it; by itself a test's is open to others.
#[cfg(test)]
pub(super) fn temporary() -> tempfile::TempDir {
    use std::os::unix::fs::PermissionsExt;
    tempfile::Builder::new()
        .permissions(fs::Permissions::from_mode(0o700))
        .tempdir()
        .expect("a temporary folder")
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::os::unix::net::UnixListener;

    use super::*;

    #[test]
    fn a_killed_robot_is_none_to_choose_from() {
        let folder = temporary();
        let runtime = Runtime::new(Some(folder.path().to_owned())).expect("private");
        let listen = |id| UnixListener::bind(runtime.socket(id)).expect("a socket");
        drop(listen("killed"));
        let runs = listen("amr-1");
        assert!(matches!(runtime.choose(None), Ok(id) if id == "amr-1"));
        assert!(matches!(runtime.choose(Some("killed")), Ok(id) if id == "killed"));
        drop(listen("killed-too"));
        drop(runs);
        let Err(Failure::Refused(report)) = runtime.choose(None) else {
            panic!("none runs");
        };
        assert!(
            report.to_string().starts_with("no robot runs in"),
            "{report}"
        );
    }

    #[test]
    fn folders_that_others_reach_are_refused_with_what_to_do() {
        let place = tempfile::tempdir().expect("a folder");
        let [open, link] = ["open", "link"].map(|name| place.path().join(name));
        fs::create_dir(&open).expect("made");
        fs::set_permissions(&open, fs::Permissions::from_mode(0o755)).expect("it is ours");
        symlink(place.path(), &link).expect("a link");
        let said = |failure| match failure {
            Failure::Refused(report) | Failure::Failed(report) => report.to_string(),
        };
        for (path, why) in [(open, "chmod 0700"), (link, "is a symbolic link")] {
            let runtime = said(Runtime::new(Some(path.clone())).expect_err("refused"));
            let good = Runtime::new(Some(place.path().join("run"))).expect("private");
            let state = good.lasting_in(Some(path));
            let state = said(state.lasting().map(Path::to_owned).expect_err("refused"));
            for (said, name) in [(runtime, "runtime"), (state, "state")] {
                assert!(said.starts_with(&format!("{name} folder: ")), "{said}");
                assert!(said.contains(why), "{said}");
                assert!(said.ends_with(&format!("--{name} names another")), "{said}");
            }
        }
    }
}
