//! The folder in which running mediators of a user are found, by their control sockets.

use std::fs;
use std::io;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

use contract::private;

/// The folder.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    site: String,
}

fn path_or_default(path: Option<PathBuf>) -> PathBuf {
    path.unwrap_or_else(|| match std::env::var_os("XDG_RUNTIME_DIR") {
        Some(base) => Path::new(&base).join("mediator"),
        None => PathBuf::from(format!(
            "/tmp/mediator-{}",
            rustix::process::geteuid().as_raw()
        )),
    })
}

fn socket(folder: &Path, site: &str) -> PathBuf {
    folder.join(format!("{site}.ctl"))
}

impl Folder {
    /// The folder given, else `$XDG_RUNTIME_DIR/mediator`, else `/tmp/mediator-UID`; made when it is missing, and private. The
    /// mediator of each site has its own socket there.
    ///
    /// # Errors
    /// A sentence when it cannot be made, or others can reach it.
    pub fn new(path: Option<PathBuf>, site: &str) -> Result<Self, String> {
        let path = path_or_default(path);
        private::folder(&path)
            .map_err(|why| format!("runtime folder: {why}; --runtime names another"))?;
        let site = site.to_owned();
        Ok(Self { path, site })
    }

    /// The sites whose mediators run in the folder. Where a single one has a socket it is not asked: if it was killed, whoever talks
    /// to it hears so.
    ///
    /// # Errors
    /// A sentence when the folder cannot be read.
    pub fn sites(path: Option<PathBuf>) -> Result<Vec<String>, String> {
        let path = path_or_default(path);
        let entries = match fs::read_dir(&path) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(format!("folder {}: {error}", path.display())),
        };
        let name = |entry: fs::DirEntry| {
            let name = entry.file_name();
            Some(name.to_str()?.strip_suffix(".ctl")?.to_owned())
        };
        let mut sites: Vec<String> = entries.flatten().filter_map(name).collect();
        if sites.len() > 1 {
            // One that was killed leaves its socket behind.
            let runs = |site: &String| UnixStream::connect(socket(&path, site)).is_ok();
            sites.retain(runs);
        }
        sites.sort();
        Ok(sites)
    }

    /// The control socket.
    #[must_use]
    pub fn socket(&self) -> PathBuf {
        socket(&self.path, &self.site)
    }

    /// Where the journal is if nobody says otherwise. It must outlast a restart of the computer.
    #[must_use]
    pub fn default_journal(site: &str) -> PathBuf {
        Self::state().join(format!("{site}.redb"))
    }

    /// Where the site's keys are if nobody says otherwise.
    #[must_use]
    pub fn default_keys(site: &str) -> PathBuf {
        Self::state().join("keys").join(site)
    }

    fn state() -> PathBuf {
        let base = std::env::var_os("XDG_STATE_HOME")
            .map(PathBuf::from)
            .or_else(|| std::env::var_os("HOME").map(|home| Path::new(&home).join(".local/state")))
            .unwrap_or_else(|| PathBuf::from("."));
        base.join("mediator")
    }

    /// Listens on the control socket; one that a killed mediator left behind is replaced.
    pub(super) fn listen(&self) -> Result<UnixListener, String> {
        let socket = self.socket();
        if UnixStream::connect(&socket).is_ok() {
            return Err(format!(
                "a mediator of site `{}` runs already, at {}",
                self.site,
                socket.display()
            ));
        }
        let cannot = |error: io::Error| format!("control socket: {error}");
        let listener = private::listen(&socket).map_err(|why| cannot(why.into()))?;
        listener.set_nonblocking(true).map_err(cannot)?;
        Ok(listener)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_killed_mediator_is_none_that_runs() {
        let place = tempfile::tempdir().expect("a folder");
        let path = Some(place.path().join("run"));
        let sites = || Folder::sites(path.clone()).expect("it can be read");
        let listen = |site| Folder::new(path.clone(), site)?.listen();
        let runs = listen("hall").expect("nobody else does");
        assert_eq!(sites(), ["hall"]);
        drop(listen("killed").expect("nobody else does"));
        assert_eq!(sites(), ["hall"]);
        drop(runs);
        assert_eq!(sites(), Vec::<String>::new());
    }
}
