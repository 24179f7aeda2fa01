//! From the keys of a scenario file to what they mean.

use std::ops::Range;
use std::path::PathBuf;

use config::SiteConfig;
use description::geometry::Rect;
use onboard::cli::Failure;
use onboard::composition::plan::Plan;
use toml::Spanned;

use super::file::{Corners, File, Robot, Rule, Way, Waypoint};
use crate::scenario::goal::{Goal, Places, Stop};
use crate::scenario::limits::{CLEARANCE_M, Limits};
use crate::scenario::model::{Coordination, During, LONGEST_DRIVEN_H, Player, Scenario};
use crate::scenario::problem::Complaints;

/// Bounds of a scenario: small floors, small computers.
const MOST_ROBOTS: usize = 8;
const MOST_ROUNDS: u32 = 1_000;
const DEFAULT_STANDSTILL_S: f64 = 60.0;
const DEFAULT_FAULTS_UNTIL_S: f64 = 90.0;

/// Turns the keys of a file into a scenario.
pub(super) struct Reader<'a> {
    site: &'a SiteConfig,
    set: &'a [String],
    complaints: Complaints,
}

impl<'a> Reader<'a> {
    pub(super) fn new(site: &'a SiteConfig, set: &'a [String], complaints: Complaints) -> Self {
        Self {
            site,
            set,
            complaints,
        }
    }

    /// What was found to be wrong.
    pub(super) fn complaints(self) -> Complaints {
        self.complaints
    }

    fn complain(&mut self, span: Range<usize>, what: String) {
        self.complaints.push(Some(span), what);
    }

    /// Checks that the file has the robots of the site. On another site, the site's other robots may be missing; another
    /// robot file is matched by its own identity.
    pub(super) fn check_robots(&mut self, raw: &File, other_site: bool, other_robot: bool) {
        let known = list(self.site.robots.keys());
        for id in raw.robots.keys().filter(|_| !other_robot) {
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
            let missing = !raw.robots.keys().any(|own| own.get_ref() == id);
            if missing && self.site.areas_managed && !other_site {
                let what = format!(
                    "found no [robots.{id}], expected all robots of the site: the floor under one that never reports \
                     stays blocked"
                );
                self.complaints.push(Some(raw.site.span()), what);
            }
        }
    }

    /// A robot; `id` is the identity that it is given, otherwise it has that of its file. None, with a complaint, if the
    /// site does not know it.
    pub(super) fn player(
        &mut self,
        id: Option<&Spanned<String>>,
        robot: &Robot,
        file: PathBuf,
    ) -> Result<Option<Player>, Failure> {
        let mut set: Vec<String> = { robot.set.iter() }
            .map(|value| value.get_ref().clone())
            .collect();
        set.extend(id.map(|id| format!("identity.id={:?}", id.get_ref())));
        let report = |error| Failure::Refused(miette::Report::new(error));
        let all: Vec<String> = self.set.iter().chain(&set).cloned().collect();
        let config = config::load_robot(&file, &onboard::cli::overrides(&all)?).map_err(report)?;
        if !self.site.robots.contains_key(&config.identity.id) {
            return match id {
                Some(_) => Ok(None),
                None => Err(Failure::refused(format_args!(
                    "site `{}` has no robot `{}`",
                    self.site.name, config.identity.id
                ))),
            };
        }
        let plan = Plan::new(config, self.site.clone()).map_err(report)?;
        Ok(Some(Player {
            id: plan.robot.identity.id.clone(),
            file,
            set,
            start: plan.start,
            fsm: plan.fsm,
            goal: self.goal(&robot.goal),
            operator: robot.operator,
            driven_h: { robot.driven_h.as_ref() }.map_or(0.0, |driven_h| {
                self.number("driven_h", driven_h, 0.0, LONGEST_DRIVEN_H)
            }),
            config: plan.robot,
        }))
    }

    fn goal(&mut self, written: &Spanned<Way>) -> Goal {
        let way = written.get_ref();
        match (&way.laps, way.every_state, &way.rounds, &way.through) {
            (Some(laps), false, None, None) => Goal::Laps(self.rounds(laps)),
            (None, true, None, None) => Goal::EveryState,
            (None, false, Some(rounds), Some(through)) => {
                if through.get_ref().is_empty() && *rounds.get_ref() > 0 {
                    let what = "found no place, expected those of one round in their order";
                    self.complain(through.span(), what.to_owned());
                }
                Goal::Places(Places {
                    rounds: self.rounds(rounds),
                    through: self.stops(through.get_ref()),
                    then: self.stops(&way.then),
                })
            }
            _ => {
                let what = "expected `rounds` and `through`, or `laps`, or `every_state = true`";
                self.complain(written.span(), what.to_owned());
                Goal::EveryState
            }
        }
    }

    fn rounds(&mut self, written: &Spanned<u32>) -> u32 {
        let rounds = *written.get_ref();
        if rounds > MOST_ROUNDS {
            let what = format!("found {rounds} rounds, expected at most {MOST_ROUNDS}");
            self.complain(written.span(), what);
        }
        rounds.min(MOST_ROUNDS)
    }

    fn stops(&mut self, places: &[Waypoint]) -> Vec<Stop> {
        places.iter().filter_map(|place| self.stop(place)).collect()
    }

    fn stop(&mut self, place: &Waypoint) -> Option<Stop> {
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
                let corners = || {
                    format!(
                        "({}, {}) to ({}, {})",
                        min_m[0], min_m[1], max_m[0], max_m[1]
                    )
                };
                Some(Stop {
                    name: place.name.clone().unwrap_or_else(corners),
                    region: Rect::new(min_m.into(), max_m.into()),
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

    /// All but what other files say.
    pub(super) fn scenario(&mut self, raw: &File, robots: Vec<Player>) -> Scenario {
        let name = raw.name.get_ref();
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if name.is_empty() || name.len() > 48 || !name.chars().all(plain) {
            let what = format!(
                "found the name {name:?}, expected letters, digits, `-` and `_`, at most 48"
            );
            self.complain(raw.name.span(), what);
        }
        if let Some(clutter) = &raw.clutter {
            for what in clutter.get_ref().complaints() {
                self.complain(clutter.span(), what);
            }
        }
        let robots_known: Vec<(&str, Vec<&str>)> = robots.iter().map(Player::threads).collect();
        for fault in &raw.faults {
            for what in fault.get_ref().complaints(&robots_known) {
                self.complain(fault.span(), what);
            }
        }
        let coordinations = { raw.coordinations.iter() }
            .map(|(id, count)| {
                self.coordination(id);
                (id.get_ref().clone(), *count.get_ref())
            })
            .collect();
        let mut or =
            |key: &str, written: &Option<Spanned<f64>>, default, [least, most]: [f64; 2]| {
                let number = |own| self.number(key, own, least, most);
                written.as_ref().map_or(default, number)
            };
        const DAY_S: f64 = 86_400.0;
        let standstill = [1.0, DAY_S];
        Scenario {
            name: name.clone(),
            about: raw.about.clone(),
            site_file: PathBuf::new(),
            nets: Vec::new(),
            set: Vec::new(),
            patience_round_s: or("patience_round_s", &raw.patience_round_s, 0.0, [0.0, DAY_S]),
            standstill_s: or(
                "standstill_s",
                &raw.standstill_s,
                DEFAULT_STANDSTILL_S,
                standstill,
            ),
            start_delay_s: or("start_delay_s", &raw.start_delay_s, 0.0, [0.0, 600.0]),
            faults_until_s: or(
                "faults_until_s",
                &raw.faults_until_s,
                DEFAULT_FAULTS_UNTIL_S,
                [2.0, DAY_S],
            ),
            least_done_share: or("least_done_share", &raw.least_done_share, 1.0, [0.0, 1.0]),
            patience_s: self.number("patience_s", &raw.patience_s, 1.0, DAY_S),
            site: SiteConfig::clone(self.site),
            limits: self.limits(raw),
            withholds_areas: raw.withhold_areas,
            faults: { raw.faults.iter() }
                .map(|fault| fault.get_ref().clone())
                .collect(),
            clutter: raw.clutter.as_ref().map(|own| own.get_ref().clone()),
            robots,
            coordinations,
            during: { raw.during.iter() }
                .map(|rule| self.during(raw, rule))
                .collect(),
        }
    }

    fn limits(&mut self, raw: &File) -> Limits {
        let own = &raw.limits;
        let mut limit = |key: &str, written: &Option<Spanned<f64>>, most: f64| {
            { written.as_ref() }.map(|written| self.number(key, written, 0.0, most))
        };
        Limits {
            clearance_m: { limit("least_clearance_m", &raw.least_clearance_m, 10.0) }
                .unwrap_or(CLEARANCE_M),
            may_be_run_into: own.may_be_run_into,
            lateral_error_m: limit("lateral_error_m", &own.lateral_error_m, 10.0),
            over_speed: limit("over_speed", &own.over_speed, 10.0),
            pose_error_m: limit("pose_error_m", &own.pose_error_m, 10.0),
            heading_error_deg: limit("heading_error_deg", &own.heading_error_deg, 180.0),
            dock_error_m: limit("dock_error_m", &own.dock_error_m, 10.0),
            pose_stop_error_m: limit("pose_stop_error_m", &own.pose_stop_error_m, 10.0),
            border_stop_error_m: limit("border_stop_error_m", &own.border_stop_error_m, 10.0),
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
