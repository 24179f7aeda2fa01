//! The robot's process: five threads, seven activities, and the supervisor that looks after them.
//!
//! Levels, each using only those above it in this table:
//!
//! | level | holds |
//! |---|---|
//! | [`realtime`] | clock, scheduling, memory, allocation guard, histograms, wake-ups, panic flag, log queue |
//! | [`symbols`] | what is shared between activities: values, faults, who owns and who reads each |
//! | [`fleet`] | the robot's side of the mediator, without network and threads |
//! | [`activities`] | the seven activities, their ports, life cycles and queues |
//! | [`composition`] | the two files, checked, made into parts and activities |
//! | [`process`] | threads, supervisor, control socket, reload, views from outside |
//! | [`cli`] | the commands of the program |
//!
//! Data flows in one circle: drive → encoders → proprioception → odometry → navigation → wanted command → motion tube →
//! safe command → control → wheel setpoints → drive; the lidar's scan enters at navigation and motion tube.
//!
//! # Example
//! The shipped files of a robot and a site are checked together, as `onboard check` does it. On a managed site the robot may
//! be nowhere until it has heard from a mediator:
//! ```
//! use onboard::cli::{Failure, Files};
//! use onboard::composition::plan::Plan;
//! use onboard::fleet::{Member, Sense};
//!
//! let plan = Plan::load(&Files {
//!     robot: "../config/robots/amr-1.toml".into(),
//!     site: "../config/sites/corridor.toml".into(),
//!     set: vec!["areas.managed=true".into()],
//! })?;
//! let threads = plan.robot.threads.iter().map(|thread| thread.name.as_str());
//! assert!(threads.eq(["fieldbus", "motion", "lidar", "navigation", "communication"]));
//!
//! let navigator = plan.navigator().map_err(Failure::refused)?;
//! let setup = plan.fleet_setup(&navigator, 1).expect("a managed site");
//! let (mut member, now_ns) = (Member::new(setup, 0), 2_000_000_000);
//! member.step(&Sense::default(), now_ns);
//! assert!(member.allowed().is_empty() && member.troubles(now_ns).silent);
//! # Ok::<(), Failure>(())
//! ```

pub mod activities;
pub mod cli;
pub mod composition;
pub mod fleet;
pub mod process;
pub mod realtime;
pub mod say;
pub mod symbols;

pub use cli::main_from;
