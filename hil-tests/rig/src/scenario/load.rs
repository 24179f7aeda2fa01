//! From a scenario file to a scenario.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use config::{Rect, SiteConfig};
use serde::Deserialize;
use toml::Spanned;

use super::problem::Complaints;
use super::{Coordination, During, Goal, Player, Scenario, Stop};
use crate::cli::Failure;

/// No file that a person writes is larger.
const LARGEST_BYTES: u64 = 1 << 20;
/// Scenarios are for small floors and small computers.
const MOST_ROBOTS: usize = 8;
const MOST_ROUNDS: u32 = 1_000;
const DEFAULT_STANDSTILL_S: f64 = 60.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: Spanned<String>,
    #[serde(default)]
    about: String,
    site: Spanned<PathBuf>,
    patience_s: Spanned<f64>,
    standstill_s: Option<Spanned<f64>>,
    start_delay_s: Option<Spanned<f64>>,
    least_clearance_m: Option<Spanned<f64>>,
    robots: BTreeMap<Spanned<String>, Robot>,
    #[serde(default)]
    coordinations: BTreeMap<Spanned<String>, Spanned<u32>>,
    #[serde(default)]
    during: Vec<Rule>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Robot {
    file: Spanned<PathBuf>,
    #[serde(default)]
    set: Vec<Spanned<String>>,
    goal: Way,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Way {
    rounds: Spanned<u32>,
    through: Spanned<Vec<Place>>,
    #[serde(default)]
    then: Vec<Place>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Place {
    area: Option<Spanned<String>>,
    region: Option<Spanned<Corners>>,
    stands_s: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Corners {
    min_m: [f64; 2],
    max_m: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Rule {
    #[serde(rename = "while")]
    condition: Condition,
    #[serde(rename = "is")]
    claim: Claim,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Condition {
    robot: Spanned<String>,
    area: Spanned<String>,
    coordination: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Claim {
    robot: Spanned<String>,
    area: Spanned<String>,
}

/// Reads a scenario file, with the site, robot and net files that it names, and checks that they fit together.
///
/// # Errors
/// [`Failure::Refused`] with everything that is wrong with the first file that is not right.
pub fn load(file: &Path) -> Result<Scenario, Failure> {
    let text = read(file)?;
    let mut complaints = Complaints::about(file.display().to_string(), text.clone());
    let raw: File = match toml::from_str(&text) {
        Ok(raw) => raw,
        Err(error) => {
            complaints.push(error.span(), error.message().to_owned());
            return Err(Failure::Refused(complaints.report()));
        }
    };
    let folder = file.parent().unwrap_or_else(|| Path::new("."));
    let report = |error| Failure::Refused(miette::Report::new(error));
    let site_file = folder.join(raw.site.get_ref());
    must_exist(&mut complaints, &raw.site, &site_file);
    for robot in raw.robots.values() {
        must_exist(
            &mut complaints,
            &robot.file,
            &folder.join(robot.file.get_ref()),
        );
    }
    if !complaints.is_empty() {
        return Err(Failure::Refused(complaints.report()));
    }
    let site = config::load_site(&site_file, &[]).map_err(report)?;
    let mut reader = Reader {
        site: &site,
        complaints,
    };
    reader.check_robots(&raw);
    let mut robots = Vec::new();
    for (id, robot) in &raw.robots {
        robots.push(reader.player(folder, id, robot)?);
    }
    let scenario = reader.scenario(&raw, robots);
    if !reader.complaints.is_empty() {
        return Err(Failure::Refused(reader.complaints.report()));
    }
    let mut scenario = scenario;
    let nets = site_file
        .parent()
        .unwrap_or_else(|| Path::new("."))
        .join("../nets");
    for coordination in site.coordinations.values() {
        if !{ scenario.nets.iter() }.any(|net| net.name == coordination.net) {
            let net = config::load_net(nets.join(format!("{}.toml", coordination.net)));
            scenario.nets.push(net.map_err(report)?);
        }
    }
    scenario.site_file = site_file;
    scenario.site = site;
    Ok(scenario)
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

fn must_exist(complaints: &mut Complaints, written: &Spanned<PathBuf>, path: &Path) {
    if !path.is_file() {
        complaints.push(
            Some(written.span()),
            format!(
                "found no file {}, expected one, named from the scenario file's folder",
                path.display()
            ),
        );
    }
}

/// Turns what is written into what is meant.
struct Reader<'a> {
    site: &'a SiteConfig,
    complaints: Complaints,
}

impl Reader<'_> {
    fn complain(&mut self, span: Range<usize>, what: String) {
        self.complaints.push(Some(span), what);
    }

    fn check_robots(&mut self, raw: &File) {
        let known = list(self.site.robots.keys());
        for id in raw.robots.keys() {
            if !self.site.robots.contains_key(id.get_ref()) {
                let what = format!("found robot `{}`, expected one of {known}", id.get_ref());
                self.complain(id.span(), what);
            }
        }
        if raw.robots.len() > MOST_ROBOTS {
            let what = format!(
                "found {} robots, expected at most {MOST_ROBOTS}",
                raw.robots.len()
            );
            self.complaints.push(None, what);
        }
        for id in self.site.robots.keys() {
            if !raw.robots.keys().any(|own| own.get_ref() == id) {
                let what = format!(
                    "found no [robots.{id}], expected all robots of the site: the floor under one that never reports \
                     stays blocked"
                );
                self.complaints.push(Some(raw.site.span()), what);
            }
        }
    }

    fn player(
        &mut self,
        folder: &Path,
        id: &Spanned<String>,
        robot: &Robot,
    ) -> Result<Player, Failure> {
        let file = folder.join(robot.file.get_ref());
        let mut set: Vec<String> = { robot.set.iter() }
            .map(|value| value.get_ref().clone())
            .collect();
        set.push(format!("identity.id={:?}", id.get_ref()));
        let report = |error| Failure::Refused(miette::Report::new(error));
        let overrides = onboard::cli::overrides(&set)?;
        let config = config::load_robot(&file, &overrides).map_err(report)?;
        if self.site.robots.contains_key(id.get_ref()) {
            config::check_together(&config, self.site).map_err(report)?;
        }
        Ok(Player {
            id: id.get_ref().clone(),
            file,
            set,
            config,
            goal: self.goal(&robot.goal),
        })
    }

    fn goal(&mut self, way: &Way) -> Goal {
        let rounds = *way.rounds.get_ref();
        if rounds > MOST_ROUNDS {
            let what = format!("found {rounds} rounds, expected at most {MOST_ROUNDS}");
            self.complain(way.rounds.span(), what);
        }
        let through = way.through.get_ref();
        let goal = Goal {
            rounds: rounds.min(MOST_ROUNDS),
            through: through
                .iter()
                .filter_map(|place| self.stop(place))
                .collect(),
            then: { way.then.iter() }
                .filter_map(|place| self.stop(place))
                .collect(),
        };
        if through.is_empty() && rounds > 0 {
            let what = "found no place, expected those of one round in their order".to_owned();
            self.complain(way.through.span(), what);
        }
        goal
    }

    fn stop(&mut self, place: &Place) -> Option<Stop> {
        let stands_s = place
            .stands_s
            .as_ref()
            .map_or(0.0, |written| self.number("stands_s", written, 0.0, 3600.0));
        match (&place.area, &place.region) {
            (Some(area), None) => Some(Stop {
                stands_s,
                ..self.area(area)
            }),
            (None, Some(corners)) => {
                let Corners { min_m, max_m } = *corners.get_ref();
                let good = (0..2).all(|axis| {
                    min_m[axis].is_finite() && max_m[axis].is_finite() && min_m[axis] < max_m[axis]
                });
                if !good {
                    let what = format!("found {min_m:?} to {max_m:?}, expected min_m below max_m");
                    self.complain(corners.span(), what);
                }
                Some(Stop {
                    name: format!(
                        "({}, {}) to ({}, {})",
                        min_m[0], min_m[1], max_m[0], max_m[1]
                    ),
                    region: Rect { min_m, max_m },
                    stands_s,
                })
            }
            (area, region) => {
                let spans = [
                    area.as_ref().map(Spanned::span),
                    region.as_ref().map(Spanned::span),
                    place.stands_s.as_ref().map(Spanned::span),
                ];
                let what = if area.is_some() {
                    "found `area` and `region`, expected one of them"
                } else {
                    "found a place without `area` or `region`, expected one of them"
                };
                let span = spans.into_iter().flatten().next();
                self.complaints.push(span, what.to_owned());
                None
            }
        }
    }

    fn area(&mut self, name: &Spanned<String>) -> Stop {
        let region = self.site.area(name.get_ref()).map(|area| area.region);
        if region.is_none() {
            let known = list(self.site.areas.iter().map(|area| &area.id));
            let what = format!("found area `{}`, expected one of {known}", name.get_ref());
            self.complain(name.span(), what);
        }
        Stop {
            name: format!("area {}", name.get_ref()),
            region: region.unwrap_or_default(),
            stands_s: 0.0,
        }
    }

    fn number(&mut self, key: &str, written: &Spanned<f64>, least: f64, most: f64) -> f64 {
        let value = *written.get_ref();
        if value >= least && value <= most {
            return value;
        }
        let what = format!("found {key} = {value}, expected {least} to {most}");
        self.complain(written.span(), what);
        least
    }

    fn scenario(&mut self, raw: &File, robots: Vec<Player>) -> Scenario {
        let name = raw.name.get_ref();
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if name.is_empty() || name.len() > 48 || !name.chars().all(plain) {
            let what = format!(
                "found the name {name:?}, expected letters, digits, `-` and `_`, at most 48"
            );
            self.complain(raw.name.span(), what);
        }
        let mut number = |key: &str, written: &Option<Spanned<f64>>, default, range: [f64; 2]| {
            written.as_ref().map_or(default, |written| {
                self.number(key, written, range[0], range[1])
            })
        };
        let standstill_s = number(
            "standstill_s",
            &raw.standstill_s,
            DEFAULT_STANDSTILL_S,
            [1.0, 86_400.0],
        );
        let start_delay_s = number("start_delay_s", &raw.start_delay_s, 0.0, [0.0, 600.0]);
        let least_clearance_m = number(
            "least_clearance_m",
            &raw.least_clearance_m,
            crate::one_robot::judge::LEAST_CLEARANCE_M,
            [0.0, 10.0],
        );
        let coordinations = { raw.coordinations.iter() }
            .map(|(id, count)| {
                self.coordination(id);
                (id.get_ref().clone(), *count.get_ref())
            })
            .collect();
        Scenario {
            name: name.clone(),
            about: raw.about.clone(),
            site_file: PathBuf::new(),
            site: self.site.clone(),
            nets: Vec::new(),
            patience_s: self.number("patience_s", &raw.patience_s, 1.0, 86_400.0),
            standstill_s,
            start_delay_s,
            least_clearance_m,
            robots,
            coordinations,
            during: { raw.during.iter() }
                .map(|rule| self.during(raw, rule))
                .collect(),
        }
    }

    fn coordination(&mut self, id: &Spanned<String>) -> Coordination {
        let found = self.site.coordinations.get(id.get_ref());
        if found.is_none() {
            let known = list(self.site.coordinations.keys());
            let what = format!("found `{}`, expected one of {known}", id.get_ref());
            self.complain(id.span(), what);
        }
        Coordination {
            id: id.get_ref().clone(),
            net: found.map_or(String::new(), |own| own.net.clone()),
        }
    }

    fn during(&mut self, raw: &File, rule: &Rule) -> During {
        for robot in [&rule.condition.robot, &rule.claim.robot] {
            if !raw.robots.keys().any(|id| id.get_ref() == robot.get_ref()) {
                let known = list(raw.robots.keys().map(Spanned::get_ref));
                let what = format!("found robot `{}`, expected one of {known}", robot.get_ref());
                self.complain(robot.span(), what);
            }
        }
        During {
            robot: rule.condition.robot.get_ref().clone(),
            area: self.area(&rule.condition.area),
            coordination: { rule.condition.coordination.as_ref() }.map(|id| self.coordination(id)),
            other: rule.claim.robot.get_ref().clone(),
            other_area: self.area(&rule.claim.area),
        }
    }
}

fn list<'a>(names: impl Iterator<Item = &'a String>) -> String {
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    if names.is_empty() {
        "none: the site has none".to_owned()
    } else {
        names.join(", ")
    }
}
