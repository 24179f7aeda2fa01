//! What all runs of a scenario share.

use std::path::Path;

use coordination::analysis::Limits;
use mediator::nets;
use mediator::setup::Setup;
use onboard::cli::{Failure, Files};
use onboard::composition::plan::Plan;

use super::mediator::MediatorPlan;
use crate::folder::Folder;
use crate::process::janitor::Janitor;
use crate::scenario::{Player, Scenario};

/// What is common to all runs of a scenario: each robot's plan, in the order of the scenario, and the mediator's.
pub struct Plans {
    pub(super) robots: Vec<(Files, Plan)>,
    pub(super) mediator: Option<MediatorPlan>,
    /// A mediator grants areas, or should.
    pub(super) managed: bool,
    /// Each run has one below it, for its robots' symbols.
    pub(super) folder: Folder,
    _janitor: Option<Janitor>,
}

impl Plans {
    /// Makes the plans of a scenario.
    ///
    /// # Errors
    /// [`Failure::Refused`] when a plan cannot be made.
    pub fn of(scenario: &Scenario) -> Result<Self, Failure> {
        let plan = |player: &Player| {
            let files = Files {
                robot: player.file.clone(),
                site: scenario.site_file.clone(),
                set: scenario.set_of(player),
            };
            Ok((files.clone(), Plan::load(&files)?))
        };
        let managed = scenario.site.areas_managed && !scenario.withholds_areas;
        Ok(Self {
            robots: { scenario.robots.iter() }
                .map(plan)
                .collect::<Result<_, Failure>>()?,
            mediator: managed.then(|| mediator_plan(scenario)).transpose()?,
            managed,
            folder: Folder::in_memory()?,
            _janitor: None,
        })
    }

    /// Has what the runs leave removed even if this process is killed. `program` is the rig's.
    ///
    /// # Errors
    /// [`Failure::Refused`] when the janitor cannot be started.
    pub fn with_janitor(self, program: &Path) -> Result<Self, Failure> {
        let janitor = Janitor::start(program, self.folder.path()).map_err(Failure::refused)?;
        Ok(Self {
            _janitor: Some(janitor),
            ..self
        })
    }

    /// A control: nobody grants anything.
    #[must_use]
    pub fn without_mediator(self) -> Self {
        let mediator = None;
        Self { mediator, ..self }
    }

    /// A control: nobody is coordinated.
    #[must_use]
    pub fn without_nets(self) -> Self {
        let mediator = self.mediator.map(MediatorPlan::without_nets);
        Self { mediator, ..self }
    }
}

fn mediator_plan(scenario: &Scenario) -> Result<MediatorPlan, Failure> {
    let setup = Setup::of(&scenario.site).map_err(Failure::refused)?;
    let nets = nets::plans(&scenario.site, &setup, &scenario.nets, &Limits::default());
    let nets = nets.map_err(|errors| {
        let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
        Failure::refused(lines.join("\n"))
    })?;
    Ok(MediatorPlan::new(setup, nets))
}
