//! From a file to a configuration: read, parse, override, convert, check.

mod net;

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

use description::keys::Section;
use miette::NamedSource;

use crate::check;
use crate::diagnostic::{ConfigError, Problem, ProblemKind};
use crate::loaded::{Loaded, RobotConfig, SiteConfig};
use crate::node::Entry;
use crate::origin::Origin;
use crate::overrides::Override;
use crate::reader;
use crate::report::Report;
use crate::spot::{Source, Spot};
use crate::tree;

pub use net::{load_net, parse_net};

/// Larger than any file that a person writes.
const LARGEST_BYTES: u64 = 1 << 20;

/// Reads and checks a robot file; overrides for site files are left alone.
///
/// # Errors
/// Everything wrong with the file and the overrides, at once.
pub fn load_robot(
    path: impl AsRef<Path>,
    overrides: &[Override],
) -> Result<RobotConfig, ConfigError> {
    let path = path.as_ref();
    parse_robot(
        &path.display().to_string(),
        &read(path, "robot")?,
        overrides,
    )
}

/// Reads and checks a site file; overrides for robot files are left alone.
///
/// # Errors
/// Everything wrong with the file and the overrides, at once.
pub fn load_site(
    path: impl AsRef<Path>,
    overrides: &[Override],
) -> Result<SiteConfig, ConfigError> {
    let path = path.as_ref();
    parse_site(&path.display().to_string(), &read(path, "site")?, overrides)
}

/// Like [`load_robot`], from text; `file` is the name that errors show.
///
/// # Errors
/// As [`load_robot`].
pub fn parse_robot(
    file: &str,
    text: &str,
    overrides: &[Override],
) -> Result<RobotConfig, ConfigError> {
    parse(file, text, overrides, check::robot)
}

/// Like [`load_site`], from text; `file` is the name that errors show.
///
/// # Errors
/// As [`load_site`].
pub fn parse_site(
    file: &str,
    text: &str,
    overrides: &[Override],
) -> Result<SiteConfig, ConfigError> {
    parse(file, text, overrides, check::site)
}

fn parse<T: Section>(
    file: &str,
    text: &str,
    overrides: &[Override],
    check: fn(&Loaded<T>, &Report),
) -> Result<Loaded<T>, ConfigError> {
    let (origin, entries) = document(file, text, overrides, T::KEYS)?;
    let report = Report::new(origin);
    let loaded = Loaded {
        value: reader::Section::root(&report, &entries, T::read),
        origin: report.origin.clone(),
    };
    check(&loaded, &report);
    report.finish(loaded)
}

fn document(
    file: &str,
    text: &str,
    overrides: &[Override],
    sections: &[&str],
) -> Result<(Origin, Vec<Entry>), ConfigError> {
    // Spans count bytes of this very text: nothing may be stripped from it.
    let text_source = NamedSource::new(file, text.to_owned()).with_language("TOML");
    let mut sources = vec![Source {
        text: Arc::new(text_source),
        is_file: true,
    }];
    let only_text = Origin::new(sources.clone(), &[]);
    let mut entries = tree::parse_document(text, &only_text)?;
    let mut failed: Option<ConfigError> = None;
    for own in overrides.iter().filter(|own| own.belongs_to(sections)) {
        if let Err(error) = own.apply(&mut entries, sources.len()) {
            failed = Some(match failed {
                Some(earlier) => earlier.and(error),
                None => error,
            });
        }
        sources.push(own.source());
    }
    if let Some(error) = failed {
        return Err(error);
    }
    Ok((Origin::new(sources, &entries), entries))
}

/// Reads a file; `what` names it in errors.
fn read(path: &Path, what: &str) -> Result<String, ConfigError> {
    let problem = |found: String| {
        Problem::new(
            ProblemKind::File,
            "",
            found,
            format!("a readable {what} file in TOML"),
        )
        .in_file(path.display().to_string())
    };
    let unreadable = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => problem("no such file".to_owned()),
        ErrorKind::PermissionDenied => problem("a file that may not be read".to_owned()),
        _ => problem(format!("an error when reading ({error})")),
    };
    // Opening a named pipe would wait for its writer, perhaps for ever.
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        let found = if metadata.is_dir() {
            "a directory"
        } else {
            "something that is no file"
        };
        return Err(problem(found.to_owned()).into());
    }
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(LARGEST_BYTES + 1).read_to_end(&mut bytes))
        .map_err(unreadable)?;
    if bytes.len() as u64 > LARGEST_BYTES {
        return Err(problem(format!("a file over {} KiB", LARGEST_BYTES >> 10)).into());
    }
    String::from_utf8(bytes).map_err(|error| not_utf8(path, &error))
}

fn not_utf8(path: &Path, error: &std::string::FromUtf8Error) -> ConfigError {
    let at = error.utf8_error().valid_up_to();
    let byte = error.as_bytes().get(at).copied().unwrap_or_default();
    let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
    let source = Source {
        text: Arc::new(NamedSource::new(path.display().to_string(), text)),
        is_file: true,
    };
    Origin::new(vec![source], &[])
        .problem_at(
            ProblemKind::Syntax,
            "",
            Some(Spot {
                source: 0,
                span: at..at,
            }),
            format!("the byte 0x{byte:02X}"),
            "text in UTF-8".to_owned(),
        )
        .into()
}

#[cfg(test)]
mod tests {
    use description::keys::Section;
    use description::robot::Robot;
    use description::site::Site;

    use crate::overrides::OF_THE_FILE;

    /// Else an override could belong to both files.
    #[test]
    fn no_section_that_can_be_set_is_in_both_files() {
        let both = Robot::KEYS
            .iter()
            .filter(|section| Site::KEYS.contains(section));
        assert_eq!(both.collect::<Vec<_>>(), [&OF_THE_FILE]);
        let error = crate::Override::parse("metamodel=x").expect_err("of both");
        assert!(error.to_string().contains("metamodel"), "{error}");
    }
}
