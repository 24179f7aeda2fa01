//! The note that outlives the machine's being switched off.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

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
        let text = match fs::read(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::None),
            text => text.map_err(|error| named(path, &error))?,
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
        let write = || {
            let new = path.with_extension("journey-new");
            let mut file = File::create(&new)?;
            file.write_all(text.as_bytes())?;
            file.sync_all()?;
            fs::rename(&new, path)?;
            let folder = path.parent().map(File::open).transpose()?;
            folder.map_or(Ok(()), |folder| folder.sync_all())
        };
        write().map_err(|error| named(path, &error))
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
    use super::*;

    #[test]
    fn what_is_noted_is_read_again_and_what_is_damaged_is_under_way() {
        let folder = tempfile::tempdir().expect("a folder");
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
}
