//! `mediator keys`: who is who on a site's network.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use contract::network::{Identity, Party};

use super::failure::Failure;
use super::files::load_site;
use crate::keys::{Keys, Registered};
use crate::runtime::Folder;

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Make the site's authority, once: then its mediator, robots and operators can have certificates
    Site {
        #[command(flatten)]
        place: Place,
        /// How long certificates hold; running robots get another one after half of that
        #[arg(long, value_name = "DAYS", default_value_t = 30.0)]
        days: f64,
    },
    /// Make the file of robots of the site: each is to be copied to `fleet.keys` of its robot, and nowhere else
    Robot {
        /// Ids of the robots
        #[arg(required = true)]
        robots: Vec<String>,
        #[command(flatten)]
        place: Place,
        /// Folder for ROBOT.pem
        #[arg(long, value_name = "DIR", default_value = ".")]
        out: PathBuf,
        /// Put the file in the place of one that is there, as for a robot that was off until its certificate had ended
        #[arg(long)]
        replace: bool,
    },
    /// Make the file with which somebody may ask and order the mediator from afar
    Operator {
        /// Name of the operator, as it will stand in the journal
        name: String,
        #[command(flatten)]
        place: Place,
        /// Folder for NAME.pem
        #[arg(long, value_name = "DIR", default_value = ".")]
        out: PathBuf,
        /// Put the file in the place of one that is there, as each time that it has ended
        #[arg(long)]
        replace: bool,
    },
    /// Make all certificates worthless that a robot or an operator has got so far; a running mediator cuts it off within a second
    Revoke {
        #[command(flatten)]
        whose: Whose,
        #[command(flatten)]
        place: Place,
    },
    /// List who has certificates
    List {
        #[command(flatten)]
        place: Place,
    },
}

#[derive(Debug, Args)]
pub(super) struct Place {
    /// Site file
    #[arg(long, value_name = "FILE")]
    site: PathBuf,
    /// Folder of the site's keys [default: $XDG_STATE_HOME/mediator/keys/SITE]
    #[arg(long, value_name = "DIR")]
    keys: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub(super) struct Whose {
    /// Id of the robot
    #[arg(long, value_name = "ID")]
    robot: Option<String>,
    /// Name of the operator
    #[arg(long, value_name = "NAME")]
    operator: Option<String>,
}

pub(super) fn run(command: Command) -> Result<(), Failure> {
    match command {
        Command::Site { place, days } => {
            let site = load_site(&place.site)?;
            let keys = keys(place.keys, &site.name);
            keys.begin(&site.name, days).map_err(Failure::Refused)?;
            say(&format!(
                "site {} has an authority in {}: whoever reads its key can pass for everybody; keep a copy where the computer's fire does not reach",
                site.name,
                keys.folder().display()
            ));
        }
        Command::Robot {
            robots,
            place,
            out,
            replace,
        } => {
            let site = load_site(&place.site)?;
            for id in &robots {
                if !site.robots.contains_key(id) {
                    let known: Vec<&str> = site.robots.keys().map(String::as_str).collect();
                    return Err(Failure::Refused(format!(
                        "site {} has no robot `{id}`; it has {}",
                        site.name,
                        known.join(", ")
                    )));
                }
            }
            let keys = keys(place.keys, &site.name);
            for id in robots {
                hand_out(
                    &keys,
                    Party::Robot(id.clone()),
                    &out.join(format!("{id}.pem")),
                    replace,
                )?;
            }
        }
        Command::Operator {
            name,
            place,
            out,
            replace,
        } => {
            let site = load_site(&place.site)?;
            let keys = keys(place.keys, &site.name);
            let path = out.join(format!("{name}.pem"));
            hand_out(&keys, Party::Operator(name), &path, replace)?;
        }
        Command::Revoke { whose, place } => {
            let site = load_site(&place.site)?;
            let party = match (whose.robot, whose.operator) {
                (Some(id), _) => Party::Robot(id),
                (None, Some(name)) => Party::Operator(name),
                (None, None) => unreachable!("the arguments require one of them"),
            };
            let keys = keys(place.keys, &site.name);
            let name = keys.revoke(&party).map_err(Failure::Refused)?;
            say(&format!(
                "{name} and those before it mean nothing any more; a robot that drives stops before the next border"
            ));
        }
        Command::List { place } => {
            let site = load_site(&place.site)?;
            let registry = { keys(place.keys, &site.name).registry() }.map_err(Failure::Refused)?;
            say(&format!("certificates hold {} days", registry.days));
            let list = |kind: &str, name: &String, own: &Registered| {
                let revoked = if own.revoked { ", revoked" } else { "" };
                say(&format!(
                    "  {kind} {name}: generation {}{revoked}",
                    own.generation
                ));
            };
            { registry.robots.iter() }.for_each(|(id, own)| list("robot", id, own));
            { registry.operators.iter() }.for_each(|(name, own)| list("operator", name, own));
        }
    }
    Ok(())
}

fn keys(folder: Option<PathBuf>, site: &str) -> Keys {
    Keys::new(folder.unwrap_or_else(|| Folder::default_keys(site)))
}

/// Makes an identity and writes its file, which must not be there yet unless it is to be replaced.
fn hand_out(keys: &Keys, party: Party, path: &Path, replace: bool) -> Result<(), Failure> {
    let cannot = |error: std::io::Error| {
        let hint = match error.kind() {
            ErrorKind::AlreadyExists => "; --replace puts the new one in its place",
            _ => "",
        };
        Failure::Refused(format!(
            "{} cannot be written: {error}{hint}",
            path.display()
        ))
    };
    if !replace && path.symlink_metadata().is_ok() {
        return Err(cannot(ErrorKind::AlreadyExists.into()));
    }
    let identity: Identity = keys.issue(party).map_err(Failure::Refused)?;
    let text = identity.to_pem();
    if replace {
        // All of the new one or all of the old one is there at any moment.
        let next = path.with_extension("pem.new");
        // One that was left behind is worth nothing.
        let _ = std::fs::remove_file(&next);
        write_new(&next, &text)
            .and_then(|()| std::fs::rename(&next, path))
            .map_err(cannot)?;
    } else {
        write_new(path, &text).map_err(cannot)?;
    }
    say(&format!("{}: {}", path.display(), identity.name()));
    Ok(())
}

fn write_new(path: &Path, text: &str) -> std::io::Result<()> {
    use std::os::unix::fs::OpenOptionsExt;
    let mut options = std::fs::OpenOptions::new();
    let mut file = { options.write(true).create_new(true).mode(0o600) }.open(path)?;
    file.write_all(text.as_bytes())?;
    file.sync_all()
}

fn say(line: &str) {
    // A reader that closes the pipe early is no failure.
    let _ = writeln!(std::io::stdout(), "{line}");
}
