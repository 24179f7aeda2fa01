//! Reads a scenario file and the files that it names.

use std::path::{Component, Path, PathBuf};

use clap::Args;
use onboard::cli::Failure;
use toml::Spanned;

use super::file::File;
use super::reader::Reader;
use crate::scenario::model::Scenario;
use crate::scenario::problem::Complaints;

/// No file that a person writes is larger.
const LARGEST_BYTES: u64 = 1 << 20;
/// Where the scenarios that ship are.
const FOLDER: &str = "config/scenarios";
/// The same scenarios, for use where that folder does not exist.
const SHIPPED: [(&str, &str); 6] = [
    (
        "clutter",
        include_str!("../../../../../config/scenarios/clutter.toml"),
    ),
    (
        "course",
        include_str!("../../../../../config/scenarios/course.toml"),
    ),
    (
        "docking",
        include_str!("../../../../../config/scenarios/docking.toml"),
    ),
    (
        "lap",
        include_str!("../../../../../config/scenarios/lap.toml"),
    ),
    (
        "overtaking",
        include_str!("../../../../../config/scenarios/overtaking.toml"),
    ),
    (
        "t-junction",
        include_str!("../../../../../config/scenarios/t-junction.toml"),
    ),
];

/// What the command line changes in a scenario. The robot has the identity that its file says; values are changed after
/// those of the scenario.
#[derive(Args, Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Robot file, where one robot drives [default: the scenario's own]
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    /// Site file, where one robot drives [default: the scenario's own]
    #[arg(long, value_name = "FILE")]
    pub site: Option<PathBuf>,
    /// Change one value of the files of robot and site, such as drive.max_speed_m_s=0.3
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// Reads a scenario file, with the site, robot and net files that it names, and checks that they fit together.
///
/// # Errors
/// [`Failure::Refused`] with everything that is wrong with the first bad file.
pub fn load(file: &Path, changes: &Changes) -> Result<Scenario, Failure> {
    from_text(file, read(file)?, changes)
}

/// The same for a scenario that ships, by its name: from `config/scenarios` if it is there, else from this program.
///
/// # Errors
/// As [`load`].
pub fn load_shipped(name: &str, changes: &Changes) -> Result<Scenario, Failure> {
    let file = Path::new(FOLDER).join(name).with_extension("toml");
    let built_in = SHIPPED.iter().find(|(own, _)| *own == name);
    match built_in {
        Some((_, text)) if !file.is_file() => from_text(&file, (*text).to_owned(), changes),
        _ => load(&file, changes),
    }
}

fn from_text(file: &Path, text: String, changes: &Changes) -> Result<Scenario, Failure> {
    let mut complaints = Complaints::about(file.display().to_string(), text.clone());
    let raw: File = match toml::from_str(&text) {
        Ok(raw) => raw,
        Err(error) => {
            complaints.push(error.span(), error.message().to_owned());
            return Err(Failure::Refused(complaints.report()));
        }
    };
    let elsewhere = changes.robot.is_some() || changes.site.is_some();
    if elsewhere && raw.robots.len() != 1 {
        return Err(Failure::refused(format_args!(
            "--robot and --site are for scenarios with one robot; `{}` has {}",
            raw.name.get_ref(),
            raw.robots.len()
        )));
    }
    let folder = file.parent().unwrap_or_else(|| Path::new("."));
    let site_file = match &changes.site {
        Some(site) => site.clone(),
        None => existing(&mut complaints, &raw.site, folder),
    };
    let robot_files: Vec<PathBuf> = { raw.robots.values() }
        .map(|robot| match &changes.robot {
            Some(file) => file.clone(),
            None => existing(&mut complaints, &robot.file, folder),
        })
        .collect();
    if !complaints.is_empty() {
        return Err(Failure::Refused(complaints.report()));
    }
    let report = |error| Failure::Refused(miette::Report::new(error));
    let set: Vec<String> = raw.set.iter().chain(&changes.set).cloned().collect();
    let site = config::load_site(&site_file, &onboard::cli::overrides(&set)?).map_err(report)?;
    let mut nets = Vec::new();
    let net_folder = site_file
        .parent()
        .unwrap_or_else(|| Path::new("."))
        .join("../nets");
    for coordination in site.coordinations.values() {
        if !{ nets.iter() }.any(|net: &config::NetConfig| net.name == coordination.net) {
            let file = net_folder.join(format!("{}.toml", coordination.net));
            nets.push(config::load_net(file).map_err(report)?);
        }
    }
    let mut reader = Reader::new(&site, &set, complaints);
    reader.check_robots(&raw, changes.site.is_some(), changes.robot.is_some());
    let mut robots = Vec::new();
    for ((id, robot), file) in raw.robots.iter().zip(robot_files) {
        let id = changes.robot.is_none().then_some(id);
        robots.extend(reader.player(id, robot, file)?);
    }
    let scenario = reader.scenario(&raw, robots);
    let complaints = reader.complaints();
    if !complaints.is_empty() {
        return Err(Failure::Refused(complaints.report()));
    }
    Ok(Scenario {
        site_file,
        site,
        set,
        nets,
        ..scenario
    })
}

fn read(file: &Path) -> Result<String, Failure> {
    let cannot = |why: String| {
        Failure::refused(format_args!(
            "scenario {} cannot be read: {why}",
            file.display()
        ))
    };
    let size = std::fs::metadata(file)
        .map_err(|error| cannot(error.to_string()))?
        .len();
    if size > LARGEST_BYTES {
        return Err(cannot(format!(
            "found {size} bytes, expected at most {LARGEST_BYTES}"
        )));
    }
    std::fs::read_to_string(file).map_err(|error| cannot(error.to_string()))
}

/// A file that the scenario names, which must be there.
fn existing(complaints: &mut Complaints, written: &Spanned<PathBuf>, folder: &Path) -> PathBuf {
    let path = folder.join(written.get_ref());
    let short = without_detours(&path);
    if short.is_file() {
        return short;
    }
    if !path.is_file() {
        complaints.push(
            Some(written.span()),
            format!(
                "found no file {}, expected one, named from the scenario file's folder",
                path.display()
            ),
        );
    }
    path
}

/// `config/scenarios/../sites` as `config/sites`.
fn without_detours(path: &Path) -> PathBuf {
    let mut short = PathBuf::new();
    for part in path.components() {
        let leads_back = part == Component::ParentDir
            && matches!(short.components().next_back(), Some(Component::Normal(_)));
        if leads_back {
            short.pop();
        } else {
            short.push(part);
        }
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_told_without_detours() {
        let short = |path: &str| without_detours(Path::new(path)).display().to_string();
        assert_eq!(
            short("config/scenarios/../sites/a.toml"),
            "config/sites/a.toml"
        );
        assert_eq!(short("../sites/a.toml"), "../sites/a.toml");
        assert_eq!(short("/a/../../b"), "/../b");
    }
}
