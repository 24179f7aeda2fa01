//! A scenario: robots on a site, what they are to do there, and what must not happen.

use std::collections::BTreeMap;
use std::path::PathBuf;

use config::{NetConfig, RobotConfig, SiteConfig};
use description::site::{FsmConfig, SiteRobot};
use description::threads::ActivityKind;
use onboard::cli::Failure;

use super::clutter::Clutter;
use super::fault::{ScriptedFault, ScriptedKind};
use super::goal::{Goal, Stop};
use super::limits::Limits;

/// Six weeks: no drive is on for longer.
pub const LONGEST_DRIVEN_H: f64 = 1_000.0;

/// Robots on a site, and what they are to do there.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Its name.
    pub name: String,
    /// Its purpose, in a sentence.
    pub about: String,
    /// Site file.
    pub site_file: PathBuf,
    /// What the site file says.
    pub site: SiteConfig,
    /// The nets of the site's coordinations.
    pub nets: Vec<NetConfig>,
    /// Values changed in the site file and in all robot files, `KEY=VALUE`.
    pub set: Vec<String>,
    /// Longest time until all goals are reached,
    pub patience_s: f64,
    /// and this much more for each round of the robot that drives most.
    pub patience_round_s: f64,
    /// The run fails when no robot has moved for this long, not counting what was before the end of a fault.
    pub standstill_s: f64,
    /// Each robot is started after a time of up to this, drawn from the seed.
    pub start_delay_s: f64,
    /// What is a violation.
    pub limits: Limits,
    /// On the simulated clock the rig stands in for the mediator: it withholds leave for areas at random.
    pub withholds_areas: bool,
    /// What the site file does not know.
    pub clutter: Option<Clutter>,
    /// Of many runs on the simulated clock at least this share must reach all goals; none may have a violation.
    pub least_done_share: f64,
    /// Faults that are drawn begin by this time.
    pub faults_until_s: f64,
    /// What goes wrong, on the simulated clock.
    pub faults: Vec<ScriptedFault>,
    /// The robots, by identity.
    pub robots: Vec<Player>,
    /// How many runs of each coordination must come to a declared end, by their ids.
    pub coordinations: BTreeMap<String, u32>,
    /// What must be true while something else is.
    pub during: Vec<During>,
}

/// A robot that takes part.
#[derive(Clone, Debug)]
pub struct Player {
    /// Its identity, also on the site.
    pub id: String,
    /// Robot file.
    pub file: PathBuf,
    /// Values changed in it, `KEY=VALUE`, after those of the scenario.
    pub set: Vec<String>,
    /// What the robot file says, with these values.
    pub config: RobotConfig,
    /// Its role and start on the site.
    pub start: SiteRobot,
    /// The state machine of its role.
    pub fsm: FsmConfig,
    /// What it is to do.
    pub goal: Goal,
    /// An operator gives it the events that nothing on the robot raises.
    pub operator: bool,
    /// The encoders of its drive have counted as if it had driven for so many hours at its top speed.
    pub driven_h: f64,
}

/// Something that must be true while something else is.
#[derive(Clone, Debug, PartialEq)]
pub struct During {
    /// While the `base_link` of this robot
    pub robot: String,
    /// is in this area,
    pub area: Stop,
    /// and a net of this coordination has the discrete control of robots,
    pub coordination: Option<Coordination>,
    /// this other robot
    pub other: String,
    /// is in this area with its whole footprint.
    pub other_area: Stop,
}

/// A coordination of the site.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Coordination {
    /// Its id in the site file.
    pub id: String,
    /// Its net, by which it is known on the network.
    pub net: String,
}

impl Scenario {
    /// The robot with this identity.
    #[must_use]
    pub fn player(&self, id: &str) -> Option<usize> {
        self.robots.iter().position(|player| player.id == id)
    }

    /// Lets more go wrong, each as in a scenario file.
    ///
    /// # Errors
    /// [`Failure::Refused`] with what is wrong with the first bad one.
    pub fn add_faults(&mut self, faults: &[String]) -> Result<(), Failure> {
        #[derive(serde::Deserialize)]
        struct File {
            fault: ScriptedFault,
        }
        for written in faults {
            let refused = |why: &str| Failure::refused(format_args!("--fault {written}: {why}"));
            let read = toml::from_str(&format!("fault = {written}"));
            let File { fault } = read.map_err(|error| refused(error.message()))?;
            let known: Vec<_> = self.robots.iter().map(Player::threads).collect();
            if let Some(why) = fault.complaints(&known).first() {
                return Err(refused(why));
            }
            self.faults.push(fault);
        }
        Ok(())
    }

    /// Second robots of one identity: the numbers of fault and robot. Their bodies are numbered after those of the robots, in
    /// this order.
    pub fn clones(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let faults = self.faults.iter().enumerate();
        { faults.filter(|(_, fault)| fault.what == ScriptedKind::CloneRobot) }
            .filter_map(|(number, fault)| Some((number, self.player(fault.robot.as_deref()?)?)))
    }

    /// Whether a mediator is given an older copy of its journal, or has one beside it: what was granted and ordered since then, nobody can
    /// tell it.
    #[must_use]
    pub fn uses_older_journal(&self) -> bool {
        let older = [ScriptedKind::RestoreJournal, ScriptedKind::CopiedMediator];
        (self.faults.iter()).any(|fault| older.contains(&fault.what))
    }

    /// The same scenario in which no robot drives more rounds than this; drawn faults then begin earlier, by as much.
    #[must_use]
    pub fn with_at_most(mut self, rounds: u32) -> Self {
        let whole = { self.robots.iter() }.map(|player| player.goal.rounds());
        let whole = whole.max().unwrap_or(0).max(1);
        self.faults_until_s *= f64::from(whole.min(rounds)) / f64::from(whole);
        for player in &mut self.robots {
            player.goal.limit_rounds(rounds);
        }
        self
    }

    /// Whether the rig must know what robots believe, and in which states they are.
    #[must_use]
    pub fn looks_inside(&self) -> bool {
        let needs = |player: &Player| player.operator || player.goal == Goal::EveryState;
        self.limits.concern_belief() || self.robots.iter().any(needs)
    }

    /// The `--set` values of a robot: the scenario's, then its own.
    #[must_use]
    pub fn set_of(&self, player: &Player) -> Vec<String> {
        self.set.iter().chain(&player.set).cloned().collect()
    }
}

impl Player {
    /// Its identity, and the names of its threads.
    #[must_use]
    pub fn threads(&self) -> (&str, Vec<&str>) {
        let names = self.config.threads.iter().map(|own| own.name.as_str());
        (&self.id, names.collect())
    }

    /// The name of the thread that runs this.
    #[must_use]
    pub fn thread_of(&self, kind: ActivityKind) -> Option<String> {
        let mut threads = self.config.threads.iter();
        let own = threads.find(|own| own.activities.contains(&kind));
        own.map(|own| own.name.clone())
    }

    /// How far the encoders of its wheels have counted when it starts.
    #[must_use]
    pub fn encoders_ahead_rad(&self) -> f64 {
        let drive = &self.config.drive;
        let driven_m = self.driven_h * 3600.0 * drive.limits.max_speed_m_s;
        driven_m / (drive.geometry.wheel_diameter_m / 2.0)
    }

    /// The state in which its machine starts.
    #[must_use]
    pub fn start_state(&self) -> &str {
        let given = self.start.start_state.as_ref();
        given.unwrap_or(&self.fsm.initial)
    }
}

impl During {
    /// In a sentence.
    #[must_use]
    pub fn rule(&self) -> String {
        let coordination = self
            .coordination
            .as_ref()
            .map_or(String::new(), |own| format!(" in coordination {}", own.id));
        format!(
            "while {} is in {}{coordination}, all of {} is in {}",
            self.robot, self.area.name, self.other, self.other_area.name
        )
    }
}
