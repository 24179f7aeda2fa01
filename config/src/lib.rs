//! The files a user writes, and the typed, validating loader for them.
//!
//! A **robot file** (`robots/amr-1.toml`) says what one robot is made of; a **site file** (`sites/corridor.toml`) says
//! where it drives and what it does there; a **net file** (`nets/t-junction.toml`) says how robots in roles and the
//! mediator coordinate. [`load_robot`], [`load_site`] and [`load_net`] read them into plain structs, [`check_together`]
//! checks that a site knows a robot. What a robot can do on a site is judged by `skills`, which gives it its meaning.
//!
//! Everything wrong with a file is collected and returned at once as a [`ConfigError`]; each [`Problem`] in it names
//! file, line, key, what was found and what was expected. Bad input never panics.
//!
//! Units are in the key: `_m`, `_rad`, `_s`, `_m_s`, `_rad_s`, and so on. Frames are those of ROS REP 103 and 105.
//!
//! Not for real-time threads: loading reads files and allocates.
//!
//! # Example
//! ```
//! use config::{Override, check_together, load_robot, load_site};
//!
//! let robot = load_robot("robots/amr-1.toml", &[Override::parse("drive.max_speed_m_s=0.3")?])?;
//! let site = load_site("sites/corridor.toml", &[])?;
//! check_together(&robot, &site)?;
//! assert_eq!(robot.drive.limits.max_speed_m_s, 0.3);
//!
//! let millimetres = Override::parse("drive.wheelbase_m=250")?;
//! let error = load_robot("robots/amr-1.toml", &[millimetres]).unwrap_err();
//! let problem = &error.problems()[0];
//! assert_eq!(problem.key, "drive.wheelbase_m");
//! assert_eq!(problem.hint.as_deref(), Some("this key is in m; 250 mm is 0.25 m"));
//! # Ok::<(), config::ConfigError>(())
//! ```

mod check;
mod diagnostic;
mod hint;
mod load;
mod loaded;
mod net;
mod node;
mod origin;
mod overrides;
mod page;
mod reader;
mod report;
mod spot;
mod tree;

pub use check::check_together;
pub use diagnostic::{ConfigError, Problem, ProblemKind};
pub use load::{load_net, load_robot, load_site, parse_net, parse_robot, parse_site};
pub use loaded::{Loaded, RobotConfig, SiteConfig};
pub use net::{
    MEDIATOR, NetArray, NetCommand, NetConfig, NetFile, NetFlag, NetMetamodel, NetParty, NetPlace,
    NetProtocol, NetRole, NetSet, NetSituation, NetTransition,
};
pub use origin::Origin;
pub use overrides::Override;
pub use page::reference_page;
