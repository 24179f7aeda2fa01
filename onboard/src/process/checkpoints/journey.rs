//! The note that outlives the machine's being switched off.

use std::fs;
use std::io::{self, Read};
use std::path::Path;

use contract::private;
use description::geometry::Pose2;

const UNDER_WAY: &str = "under way";
const ENDED: &str = "ended";

/// Where the process before has left its robot, as the disk knows it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Journey {
    /// There was none, or it has ended as it was asked to, and the next one begins at its start.
    #[default]
    None,
    /// It has not ended as it was asked to.
    UnderWay,
    /// It has, here, in `map`.
    Ended(Pose2),
}

impl Journey {
    /// Reads a note: `under way`, or `ended X Y THETA` in metres and radians.
    pub(super) fn noted(path: &Path) -> io::Result<Self> {
        let mut text = Vec::new();
        match private::open(path) {
            Err(error) if error.is_missing() => return Ok(Self::None),
            file => file?
                .read_to_end(&mut text)
                .map_err(|error| named(path, &error))?,
        };
        let text = String::from_utf8_lossy(&text);
        let read = |text: &str| match text.trim() {
            UNDER_WAY => Some(Self::UnderWay),
            text => {
                let numbers = text.strip_prefix(ENDED)?.split_whitespace();
                let numbers: Result<Vec<f64>, _> = numbers.map(str::parse).collect();
                match numbers.ok()?[..] {
                    [x_m, y_m, theta_rad] => {
                        let pose = Pose2::new(x_m, y_m, theta_rad);
                        pose.is_finite().then_some(Self::Ended(pose))
                    }
                    _ => None,
                }
            }
        };
        // Whatever else a disk has made of it: there was one.
        Ok(read(&text).unwrap_or(Self::UnderWay))
    }

    /// Writes it, in place of the last one, so that it is there after a loss of power.
    pub(super) fn note(self, path: &Path) -> io::Result<()> {
        let text = match self {
            Self::None => return remove(path),
            Self::UnderWay => UNDER_WAY.to_owned(),
            Self::Ended(pose) => {
                format!("{ENDED} {:?} {:?} {:?}", pose.x_m, pose.y_m, pose.theta_rad)
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
        let at = Pose2::new(0.1 + 0.2, -1.0 / 3.0, 3.1);
        for journey in [Journey::UnderWay, Journey::Ended(at), Journey::None] {
            journey.note(&path).expect("written");
            assert_eq!(read(), journey);
        }
        for damaged in ["", "ended", "ended 1.0 2.0", "ended 1 2 inf", "\0\0\0\0"] {
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
