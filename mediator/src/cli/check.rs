//! `mediator check` and `mediator show`: what a site's nets are, and whether they may run.

use std::io::Write;
use std::path::Path;

use config::{NetConfig, SiteConfig};
use coordination::analysis::{Limits, Proof};
use coordination::petri::Dot;
use coordination::pnml::Document;
use description::keys::quoted_list;

use super::failure::Failure;
use super::files::{load_site, nets, plans};
use crate::setup::Setup;
use crate::whole_floor::{self, Death, Findings, Still, Verdict, Waits};

pub(super) fn check(path: &Path) -> Result<(), Failure> {
    let site = load_site(path)?;
    let setup = Setup::of(&site).map_err(|error| Failure::Refused(error.to_string()))?;
    let mut text = describe_site(&site, &setup);
    let plans = plans(path, &site, &setup)?;
    if !plans.is_empty() {
        text += "\ncoordinations\n";
    }
    for plan in &plans {
        text += &format!("  {:<12} by net {}\n", plan.id, plan.net);
    }
    let mut on_the_floor = Ok(());
    if site.areas_managed {
        let alone: Vec<&str> = { plans.iter() }
            .filter(|plan| !whole_floor::is_looked_at(plan))
            .map(|plan| plan.id.as_str())
            .collect();
        let findings = whole_floor::look(&site, &plans);
        text += &describe_floor(&findings, &alone);
        on_the_floor = outcome(&findings.verdict);
        for id in &alone {
            text += &format!(
                "  not looked at: coordination {id}, which takes the discrete control of some robots and lets others into areas; its net is \
                 judged alone\n"
            );
        }
    }
    let mut refused = 0;
    for net in nets(path)? {
        let (about, may_run) = describe_net(&net);
        text += &about;
        refused += u32::from(!may_run);
    }
    say(&text);
    if refused > 0 {
        return Err(Failure::Refused(format!(
            "{refused} of the nets may not run"
        )));
    }
    on_the_floor
}

/// How the command ends by what was found of the floor.
fn outcome(verdict: &Verdict) -> Result<(), Failure> {
    match verdict {
        Verdict::Never => Ok(()),
        Verdict::May { .. } | Verdict::Starves { .. } => Err(Failure::Refused(
            "robots of this site can come to wait for ever, as told under `whole floor`".to_owned(),
        )),
        Verdict::Unknown { .. } => Err(Failure::Undecided(
            "whether robots of this site can come to wait for ever is not decided: there are more placements than are looked at"
                .to_owned(),
        )),
    }
}

/// Prints. A reader that closes the pipe early is no failure.
fn say(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

fn describe_site(site: &SiteConfig, setup: &Setup) -> String {
    let mut text = format!(
        "site {}: {}\n\nareas\n",
        site.name,
        if site.areas_managed {
            "a mediator grants its areas"
        } else {
            "not managed, robots need no mediator (areas.managed = false)"
        }
    );
    for area in &setup.areas {
        text += &format!("  {:<12} holds {}\n", area.id, area.capacity);
    }
    text += "\nrobots\n";
    for robot in &setup.robots {
        let starts = if robot.starts_in.is_empty() {
            "outside all areas".to_owned()
        } else {
            format!("in or beside {}", robot.starts_in.join(", "))
        };
        text += &format!(
            "  {:<12} {}, priority {}, starts {starts}\n",
            robot.id, robot.role, robot.priority
        );
    }
    text
}

/// Whether robots can come to wait for ever, by the order of their areas, the coordinations, and their machines together.
/// `alone`: coordinations that are not part of it.
fn describe_floor(findings: &Findings, alone: &[&str]) -> String {
    let looked = findings.looked;
    let mut text = match &findings.verdict {
        Verdict::Never => {
            let only = match alone {
                [] => String::new(),
                ids => format!(
                    " as far as what is not looked at here lets them ({})",
                    ids.join(", ")
                ),
            };
            format!(
                "\nwhole floor: no robot ever waits for ever{only}: {looked} placements of robots and nets checked; whatever stops a robot is \
                 taken to send it on at last, and robots to ask for their next areas only\n"
            )
        }
        Verdict::Unknown { steps } => {
            format!(
                "\nwhole floor: not decided: more than {looked} placements of robots and nets; no robots that wait for each other by the order of their areas within {steps} steps\n"
            )
        }
        Verdict::May { steps, waits } => {
            let waits: String = waits.iter().map(describe_wait).collect();
            format!("\nwhole floor: deadlock: these robots can come to wait for ever:\n{waits}")
                + &describe_steps("after these steps", steps)
        }
        Verdict::Starves { steps, waits } => {
            "\nwhole floor: starvation: this robot can wait for ever while others go on:\n"
                .to_owned()
                + &describe_wait(waits)
                + &describe_steps("after these steps", steps)
                + "  a place of the net that says whose turn it is helps (`closed` of config/nets/docking.toml), another order of its \
                   transitions, or `[roles.<role>] ages_after`\n"
        }
    };
    if !findings.is_whole {
        text += &format!(
            "  there are more than {looked} placements: who waits for a robot that fails is told as far as the order of areas says, and of \
             coordinations that stand still nothing\n"
        );
    }
    text.extend(findings.stills.iter().map(describe_still));
    text.extend(findings.deaths.iter().map(describe_death));
    text
}

/// What its alarm and its pre-emption are for.
fn describe_still(own: &Still) -> String {
    let text = format!(
        "  coordination {} can stand still until its robots are told to get out of the way or are let go\n",
        own.coordination
    );
    text + &describe_steps("soonest after these steps", &own.steps)
}

fn describe_death(own: &Death) -> String {
    let names = |names: &[String], word: &str| {
        quoted_list(&names.iter().map(String::as_str).collect::<Vec<_>>(), word)
    };
    let coordinations: Vec<String> = { own.coordinations.iter() }
        .map(|id| format!("coordination {id}"))
        .collect();
    let missed = [&own.robots[..], &coordinations[..]].concat().join(", ");
    let text = format!(
        "  where {} fails in {}, these may wait for it: {missed}; take it away, and say so with `mediator clear AREA --taken-away`\n",
        own.robot,
        names(&own.stands_in, "or"),
    );
    text + &describe_steps("soonest after these steps", &own.steps)
}

fn describe_wait(own: &Waits) -> String {
    let let_into = match &own.let_into[..] {
        [] => String::new(),
        areas => format!(", is let into {}", areas.join(", ")),
    };
    let needs = match &own.needs[..] {
        [] => "an order".to_owned(),
        areas => areas.join(", "),
    };
    let has = own.has.join(", ");
    format!(
        "  {} has {has}{let_into} and waits for {needs}\n",
        own.robot
    )
}

fn describe_steps(when: &str, steps: &[String]) -> String {
    if steps.is_empty() {
        return "  from the start on\n".to_owned();
    }
    let mut text = format!("  {when}:\n");
    for (number, step) in steps.iter().enumerate() {
        text += &format!("  {:>4}. {step}\n", number + 1);
    }
    text
}

/// What a net is, and whether it may run.
fn describe_net(net: &NetConfig) -> (String, bool) {
    let mut text = format!("\nnet {}{}\n", net.name, about(net.about.as_deref()));
    match net.analyse(&Limits::default()) {
        Ok(proofs) => {
            for report in proofs.iter().map(Proof::report) {
                let situation = report.situation.as_deref().unwrap_or("as it begins");
                text += &format!(
                    "  {situation}: may run; {} states, {} steps, ends: {}\n",
                    report.states,
                    report.steps,
                    report.ends.join(", ")
                );
                for warning in &report.warnings {
                    text += &format!("    note: {warning}\n");
                }
            }
            (text, true)
        }
        Err(refusal) => (text + &format!("  may not run: {refusal}\n"), false),
    }
}

pub(super) fn show(
    path: &Path,
    name: &str,
    situation: Option<&str>,
    pnml: bool,
) -> Result<(), Failure> {
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
    say(&if pnml {
        let document = Document::new(&model);
        document
            .map_err(|error| Failure::Refused(format!("net `{name}`: {error}")))?
            .to_string()
    } else {
        Dot::new(&model).to_string()
    });
    Ok(())
}

fn about(text: Option<&str>) -> String {
    text.map(|text| format!(": {text}")).unwrap_or_default()
}
