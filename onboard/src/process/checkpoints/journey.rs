//! The note that outlives the machine's being switched off.

use std::fs;
use std::io::{self, Read};
use std::path::Path;

use contract::private;
use description::geometry::Pose2;

use crate::fleet::Stood;

const UNDER_WAY: &str = "under way";
const ENDED: &str = "ended";
const STOPPED: &str = "stopped";
const PAUSED: &str = "paused";

/// Where the process before has left its robot, as the disk knows it.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Journey {
    /// There was none, or it has ended as it was asked to, and the next one begins at its start and drives.
    #[default]
    None,
    /// It has not ended as it was asked to.
    UnderWay,
    /// It has.
    Ended(Ended),
}

/// How a process has ended that was asked to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ended {
    /// Where the robot stood, if the next process is to know: on the site of this name.
    pub at: Option<(String, Stood)>,
    /// What the robot waited for.
    pub waited: Waited,
}

/// What a robot waited for when its process ended; the next one waits for it, too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Waited {
    /// People, or a fault that waits for them, had stopped it.
    pub for_reset: bool,
    /// An operator had paused it.
    pub to_resume: bool,
}

impl From<Ended> for Journey {
    fn from(ended: Ended) -> Self {
        match ended == Ended::default() {
            true => Self::None,
            false => Self::Ended(ended),
        }
    }
}

impl Journey {
    /// Reads a note: `under way`, or `ended`, then `X Y THETA` if that is known, and the standard deviations of position and heading, in
    /// metres and radians, then `stopped`, and `paused`, if it was; and where it is known, in a line each, the names of the site and of the
    /// state.
    pub(super) fn noted(path: &Path) -> io::Result<Self> {
        let mut text = Vec::new();
        match private::open(path) {
            Err(error) if error.is_missing() => return Ok(Self::None),
            file => file?
                .read_to_end(&mut text)
                .map_err(|error| named(path, &error))?,
        };
        let text = String::from_utf8_lossy(&text);
        let read = |text: &str| {
            let mut lines = text.strip_prefix(ENDED)?.lines();
            let text = lines.next().unwrap_or_default();
            let names = (lines.next(), lines.next());
            let mut words: Vec<&str> = text.split_whitespace().collect();
            let to_resume = words.pop_if(|word| *word == PAUSED).is_some();
            let for_reset = words.pop_if(|word| *word == STOPPED).is_some();
            let waited = Waited {
                for_reset,
                to_resume,
            };
            let numbers: Result<Vec<f64>, _> = words.into_iter().map(str::parse).collect();
            let at = match numbers.ok()?[..] {
                [x_m, y_m, theta_rad, std_m, std_rad] => {
                    let (Some(site), Some(state)) = names else {
                        return None;
                    };
                    let stood = Stood {
                        pose: Pose2::new(x_m, y_m, theta_rad),
                        std_m,
                        std_rad,
                        state: state.to_owned(),
                    };
                    Some((site.to_owned(), stood))
                }
                // Nothing at all would have been noted.
                [] if waited != Waited::default() => None,
                _ => return None,
            };
            let is_good = |std: f64| std.is_finite() && std >= 0.0;
            let known = at.as_ref().is_none_or(|(_, at)| {
                at.pose.is_finite() && is_good(at.std_m) && is_good(at.std_rad)
            });
            known.then_some(Self::Ended(Ended { at, waited }))
        };
        // Whatever else a disk has made of it: there was one.
        Ok(read(text.trim()).unwrap_or(Self::UnderWay))
    }

    /// Writes it, in place of the last one, so that it is there after a loss of power.
    pub(super) fn note(self, path: &Path) -> io::Result<()> {
        let text = match self {
            Self::None => return remove(path),
            Self::UnderWay => UNDER_WAY.to_owned(),
            Self::Ended(Ended { at, waited }) => {
                let place = at.as_ref().map(|(_, at)| {
                    let (pose, std_m, std_rad) = (at.pose, at.std_m, at.std_rad);
                    format!(
                        "{:?} {:?} {:?} {std_m:?} {std_rad:?}",
                        pose.x_m, pose.y_m, pose.theta_rad
                    )
                });
                let names = at.map(|(site, at)| format!("\n{site}\n{}", at.state));
                let stopped = waited.for_reset.then(|| STOPPED.to_owned());
                let paused = waited.to_resume.then(|| PAUSED.to_owned());
                let words = [Some(ENDED.to_owned()), place, stopped, paused];
                let text: Vec<String> = words.into_iter().flatten().collect();
                text.join(" ") + &names.unwrap_or_default()
            }
        };
        Ok(private::write(path, text.as_bytes())?)
    }
}

/// Removes a file, if it is there.
pub(super) fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(named(path, &error)),
        _ => Ok(()),
    }
}

fn named(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;
    use crate::process::runtime::temporary;

    #[test]
    fn what_is_noted_is_read_again_and_what_is_damaged_is_under_way() {
        let folder = temporary();
        let path = folder.path().join("amr-1.journey");
        let read = || Journey::noted(&path).expect("readable");
        assert_eq!(read(), Journey::None);
        let stood = Stood {
            pose: Pose2::new(0.1 + 0.2, -1.0 / 3.0, 3.1),
            std_m: 0.1,
            std_rad: 1.0 / 3.0,
            state: "back off = 3 stopped".to_owned(),
        };
        let at = Some(("hall 2".to_owned(), stood));
        let waits = [[false; 2], [true, false], [false, true], [true; 2]];
        let waits = waits.map(|[for_reset, to_resume]| Waited {
            for_reset,
            to_resume,
        });
        let ended = [at, None].map(|at| {
            waits.map(|waited| {
                let at = at.clone();
                Journey::from(Ended { at, waited })
            })
        });
        assert_eq!(ended[1][0], Journey::None);
        for journey in [Journey::UnderWay].into_iter().chain(ended.concat()) {
            journey.clone().note(&path).expect("written");
            assert_eq!(read(), journey);
        }
        for damaged in [
            "",
            "ended",
            "ended 1.0 2.0",
            "ended 1.0 2.0 0.5 stopped\nhall\ndrive-1",
            "ended 1.0 2.0 0.5 0.1 0.1 stopped",
            "ended 1.0 2.0 0.5 0.1 0.1\nhall",
            "ended 1 2 3 0.1 -0.1\nhall\ndrive-1",
            "ended 1.0 2.0 stopped",
            "ended 1 2 inf 0.1 0.1\nhall\ndrive-1",
            "ended 1 2 3 stopped paused",
            "\0\0\0\0",
        ] {
            fs::write(&path, damaged).expect("written");
            assert_eq!(read(), Journey::UnderWay, "{damaged:?}");
        }
        fs::write(&path, [0xff, 0xfe]).expect("written");
        assert_eq!(read(), Journey::UnderWay);
        fs::remove_file(&path).expect("there");
        fs::create_dir(&path).expect("made");
        let error = Journey::noted(&path).expect_err("a folder");
        assert!(error.to_string().contains("amr-1.journey"), "{error}");
    }

    #[test]
    fn a_note_is_nobody_elses_and_no_link_is_followed() {
        let folder = temporary();
        let [path, victim] = ["amr-1.journey", "victim"].map(|name| folder.path().join(name));
        fs::write(&victim, "precious").expect("written");
        symlink(&victim, &path).expect("a link");
        let error = Journey::noted(&path).expect_err("a link");
        assert!(error.to_string().contains("is a symbolic link"), "{error}");
        Journey::UnderWay.note(&path).expect("in place of the link");
        assert_eq!(fs::read(&victim).expect("there"), b"precious");
        let mode = |mode| fs::set_permissions(&path, fs::Permissions::from_mode(mode));
        let found = fs::symlink_metadata(&path).expect("there").permissions();
        assert_eq!(found.mode() & 0o7777, 0o600);
        // As earlier versions left it: the folder keeps others out.
        mode(0o644).expect("it is ours");
        assert_eq!(Journey::noted(&path).expect("read"), Journey::UnderWay);
        let others = fs::Permissions::from_mode(0o755);
        fs::set_permissions(folder.path(), others).expect("it is ours");
        let error = Journey::UnderWay.note(&path).expect_err("it is open");
        assert!(error.to_string().contains("chmod 0700"), "{error}");
    }
}
