//! `mediator check` and `mediator show`: what a site's nets are, and whether they may run.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Failure, load_site};
use crate::coordination::{self, Plan};
use crate::setup::Setup;
use ::coordination::analysis::Limits;
use ::coordination::petri::Dot;
use config::{NetConfig, SiteConfig};

pub(super) fn check(path: &Path) -> Result<(), Failure> {
    let site = load_site(path)?;
    let setup = Setup::of(&site).map_err(|error| Failure::Refused(error.to_string()))?;
    println!(
        "site {}: {}",
        site.name,
        if site.areas_managed {
            "a mediator grants its areas"
        } else {
            "not managed, robots need no mediator (areas.managed = false)"
        }
    );
    println!("\nareas");
    for area in &setup.areas {
        println!("  {:<12} holds {}", area.id, area.capacity);
    }
    println!("\nrobots");
    for robot in &setup.robots {
        let starts = if robot.starts_in.is_empty() {
            "outside all areas".to_owned()
        } else {
            format!("in {}", robot.starts_in.join(", "))
        };
        println!(
            "  {:<12} {}, priority {}, starts {starts}",
            robot.id, robot.role, robot.priority
        );
    }
    let plans = plans(path, &site, &setup)?;
    println!("\ncoordinations");
    for plan in &plans {
        println!("  {:<12} by net {}", plan.id, plan.net);
    }
    let mut refused = 0;
    for net in nets(path)? {
        println!("\nnet {}{}", net.name, about(net.about.as_deref()));
        match net.analyse(&Limits::default()) {
            Ok(reports) => {
                for report in reports {
                    let situation = report.situation.as_deref().unwrap_or("as it begins");
                    println!(
                        "  {situation}: may run; {} states, {} steps, ends: {}",
                        report.states,
                        report.steps,
                        report.ends.join(", ")
                    );
                    for warning in report.warnings {
                        println!("    note: {warning}");
                    }
                }
            }
            Err(refusal) => {
                refused += 1;
                println!("  may not run: {refusal}");
            }
        }
    }
    if refused > 0 {
        return Err(Failure::Refused(format!("{refused} nets may not run")));
    }
    Ok(())
}

pub(super) fn show(path: &Path, name: &str, situation: Option<&str>) -> Result<(), Failure> {
    load_site(path)?;
    let nets = nets(path)?;
    let known = |names: Vec<&str>| names.join(", ");
    let net = nets.iter().find(|net| net.name == name).ok_or_else(|| {
        Failure::Refused(format!(
            "there is no net `{name}`; beside this site are {}",
            known(nets.iter().map(|net| net.name.as_str()).collect())
        ))
    })?;
    let first = net.situations.first().map(|first| first.id.as_str());
    let situation = situation.or(first).unwrap_or_default();
    let model = net.model(situation).ok_or_else(|| {
        Failure::Refused(format!(
            "net `{name}` has no situation `{situation}`; it has {}",
            known(net.situations.iter().map(|own| own.id.as_str()).collect())
        ))
    })?;
    print!("{}", Dot::new(&model));
    Ok(())
}

fn about(text: Option<&str>) -> String {
    text.map(|text| format!(": {text}")).unwrap_or_default()
}

/// The coordinations of a site, each with its net.
pub(super) fn plans(
    path: &Path,
    site: &SiteConfig,
    setup: &Setup,
) -> Result<Vec<Arc<Plan>>, Failure> {
    if site.coordinations.is_empty() {
        return Ok(Vec::new());
    }
    coordination::plans(site, setup, &nets(path)?, &Limits::default()).map_err(|errors| {
        let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
        Failure::Refused(lines.join("\n"))
    })
}

/// All nets in the folder `nets` beside the folder of the site file, by name.
fn nets(site: &Path) -> Result<Vec<NetConfig>, Failure> {
    let folder = site
        .parent()
        .map(|folder| folder.join("../nets"))
        .unwrap_or_else(|| PathBuf::from("../nets"));
    let Ok(entries) = std::fs::read_dir(&folder) else {
        return Ok(Vec::new());
    };
    let mut paths: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    paths.sort();
    let load = |path: &PathBuf| {
        config::load_net(path)
            .map_err(|error| Failure::Refused(format!("{:?}", miette::Report::new(error))))
    };
    paths.iter().map(load).collect()
}
