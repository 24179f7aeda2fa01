//! Arguments of the commands that run one scenario many times.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;
use onboard::cli::Failure;

use super::scenarios::RunArgs;
use crate::campaign::faults::Times;
use crate::commands::{self, Many, Request};

/// The campaign of single faults,
const FAULTS: &str = "faults";
/// and the scenario in which they happen.
const FAULTS_IN: &str = "overtaking";

/// Arguments of `rig campaign`.
#[derive(Clone, Debug, Args)]
pub(super) struct CampaignArgs {
    /// Scenario file, or the name of one in config/scenarios; or `faults`: each kind of fault at a moment at which a robot of
    /// the scenario `overtaking` drives, or one of `docking` docks, on the simulated clock
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    /// Runs, with this seed and the following ones; of `faults` for each kind
    #[arg(long, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=100_000))]
    runs: usize,
    /// Run on a simulated clock, without threads and devices
    #[arg(long)]
    stepped: bool,
    /// Draw faults from the seed of each run (with --stepped)
    #[arg(long, requires = "stepped")]
    faults: bool,
    /// Each pair of kinds of faults once, besides (of `faults`)
    #[arg(long)]
    pairs: bool,
    /// Only these kinds of faults, as their rows are called (of `faults`)
    #[arg(long, value_name = "KIND", value_delimiter = ',')]
    only: Vec<String>,
    /// Make all runs, also those that an interrupted campaign has left in the folder (with --stepped)
    #[arg(long, requires = "stepped")]
    fresh: bool,
    /// Runs at once; through the real programs each takes a processor or two [default: one; on the simulated clock one for
    /// each core]
    #[arg(long)]
    jobs: Option<NonZeroUsize>,
    /// Seed of the first run
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=1_000_000_000))]
    seed: u64,
    /// No robot drives more rounds than this
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,
    /// Folder for campaign.json and what each run leaves: a folder, or a line of runs.jsonl on the simulated clock [default:
    /// target/rig/campaign/SCENARIO, and there `stepped` on the simulated clock]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl CampaignArgs {
    pub(super) fn run(self) -> Result<(), Failure> {
        let times = Times {
            runs: self.runs,
            pairs: self.pairs,
            only: self.only.clone(),
        };
        let of_faults = self.scenario == Path::new(FAULTS);
        let kinds = times.pairs || !times.only.is_empty();
        match (of_faults, kinds, self.faults) {
            (false, true, _) => Err(Failure::refused(
                "--pairs and --only are for `rig campaign faults`",
            )),
            (true, _, true) => Err(Failure::refused(
                "found --faults, expected none: `rig campaign faults` says itself what goes wrong",
            )),
            (true, _, false) => {
                let scenario = FAULTS_IN.into();
                commands::fault_campaign(&Self { scenario, ..self }.request(), &times)
            }
            (false, false, _) => commands::campaign(&self.request()),
        }
    }

    fn request(self) -> Request {
        let run = RunArgs {
            seed: self.seed,
            many: Many {
                stepped: self.stepped,
                faults: self.faults,
                without_faults: false,
                fault: Vec::new(),
                fresh: self.fresh,
                runs: self.runs,
                jobs: self.jobs,
            },
            headless: true,
            out: self.out,
        };
        Request {
            rounds: self.rounds,
            ..run.request(self.scenario)
        }
    }
}

/// Arguments of `rig agreement`.
#[derive(Clone, Debug, Args)]
pub(super) struct AgreementArgs {
    /// Scenario file, or the name of one in config/scenarios
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    /// No robot drives more rounds than this, as in the campaign
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: Option<u32>,
    /// Folder of the campaign, with a folder for each seed; agreement.json is left there. Order of grants, firings as far as their net
    /// orders them, and violations must be the same, durations within 2 s or 2 %, largest lateral errors within 3 cm [default:
    /// target/rig/campaign/SCENARIO]
    #[arg(long, value_name = "DIR")]
    real: Option<PathBuf>,
    /// Seeds whose times and lateral errors must have been compared as well; where the machine stalled in the real run they are not
    /// [default: all]
    #[arg(long, value_name = "N")]
    timed: Option<NonZeroUsize>,
    /// Orders are enough: succeed also where the machine stalled in every real run, so that no times were compared
    #[arg(long, conflicts_with = "timed")]
    untimed: bool,
}

impl AgreementArgs {
    pub(super) fn run(self) -> Result<(), Failure> {
        let timed = if self.untimed {
            Some(0)
        } else {
            self.timed.map(NonZeroUsize::get)
        };
        commands::agreement(timed, &self.request())
    }

    fn request(self) -> Request {
        let run = RunArgs {
            seed: 1,
            many: Many {
                stepped: true,
                ..Many::default()
            },
            headless: true,
            out: self.real,
        };
        Request {
            rounds: self.rounds,
            ..run.request(self.scenario)
        }
    }
}
