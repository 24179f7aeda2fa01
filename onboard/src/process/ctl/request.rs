//! What an operator can ask of a running robot, on the command line and on the socket.

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, Subcommand};
use description::geometry::Pose2;
use description::instruction::Instruction;
use serde::{Deserialize, Serialize};

use super::reply::Refusal;
use crate::symbols::values::Name;

/// What an operator can ask of a running robot.
#[derive(Clone, Debug, PartialEq, Subcommand)]
pub enum Request {
    /// Slow down and stand; `resume` goes on
    Pause,
    /// Go on after `pause`
    Resume,
    /// Stop hard and stay stopped until `reset`
    Stop,
    /// Forget faults whose causes are dealt with, and go on; says which remain
    Reset,
    /// Say where the robot stands, while it is stopped or paused
    Place(Place),
    /// Say how far the floor straight behind the robot is free, while it is stopped or paused
    FreeBehind(FreeBehind),
    /// Say what the robot carries, for those who look at it
    Load(Load),
    /// Say that the robot carries nothing
    Unload,
    /// Read gains, limits, tubes and map from the files again
    Reload,
    /// Give the robot's state machine one of its external events
    Send(Event),
    /// Take the robot into somebody's hands: the connection stays, and `onboard teleop` speaks on it
    #[command(skip)]
    Teleop(Teleop),
}

/// How somebody drives the robot by hand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Teleop {
    /// Somebody sees to it that it enters no area that others use, while it does not know where it is.
    pub without_borders: bool,
}

/// Where somebody has put the robot, or sees it stand. What it remembered of the floor is forgotten.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
pub struct Place {
    /// `start`, or the pose of base_link in `map`: metres, metres, radians
    #[arg(value_name = "start|X,Y,THETA", value_parser = spot, allow_hyphen_values = true)]
    pub at: Spot,
    /// The state that its machine goes on in; if not given, its first one at the start, else the present one
    #[arg(long)]
    pub state: Option<String>,
}

/// A place that an operator names.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Spot {
    /// Where the files say that the robot starts.
    Start,
    /// `base_link` in `map`.
    Pose(Pose2),
}

/// How far the floor straight behind the robot is free, as wide as the robot and a little more, as somebody sees who looks.
#[derive(Clone, Copy, Debug, PartialEq, Args, Serialize, Deserialize)]
pub struct FreeBehind {
    /// Metres behind the robot's rear, at most 2.5
    #[arg(value_name = "METRES", value_parser = way)]
    pub way_m: f64,
}

/// Farther than this nobody says that floor is free.
const FARTHEST_BEHIND_M: f64 = 2.5;

/// What the robot carries, as somebody sees who looks. Until the program ends, or something else is said.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
pub struct Load {
    /// What it is, at most 31 bytes
    #[arg(value_parser = load_name)]
    pub name: String,
    /// How heavy it is, in kilograms; not known if not given
    #[arg(long, value_name = "KG", default_value_t = 0.0, value_parser = mass)]
    pub mass_kg: f64,
}

/// An external event of the robot's machine, with what holds in the state that it enters until that state is left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Event(pub Instruction<String>);

const EVENT: &str = "event";
const SPEED_LIMIT: &str = "speed-limit";
const STOP: &str = "stop";

impl FromArgMatches for Event {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self(Instruction {
            event: matches.get_one(EVENT).cloned().unwrap_or_default(),
            speed_limit_m_s: matches.get_one(SPEED_LIMIT).copied(),
            stop_at: matches.get_one(STOP).copied(),
        }))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for Event {
    fn augment_args(command: Command) -> Command {
        let option = |name: &'static str, value: &'static str| {
            let argument = Arg::new(name).long(name).value_name(value);
            argument.allow_hyphen_values(true)
        };
        command
            .arg(
                Arg::new(EVENT)
                    .value_name("EVENT")
                    .required(true)
                    .help("Name of the event, one of `external` in the site file"),
            )
            .arg(
                option(SPEED_LIMIT, "M_S")
                    .value_parser(speed)
                    .help("Drive no faster than this in the state that it enters"),
            )
            .arg(
                option(STOP, "X,Y,THETA")
                    .value_parser(pose)
                    .help("Stop with base_link at this pose in `map`: metres, metres, radians"),
            )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{text}` is not a number")),
    }
}

fn not_negative(number: f64, unit: &str) -> Result<f64, String> {
    if !(0.0..f64::INFINITY).contains(&number) {
        return Err(format!("{number} {unit} is negative; expected 0 or more"));
    }
    Ok(number)
}

fn speed(text: &str) -> Result<f64, String> {
    not_negative(number(text)?, "m/s")
}

fn pose(text: &str) -> Result<Pose2, String> {
    let parts: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    match parts[..] {
        [x_m, y_m, theta_rad] => Ok(Pose2::new(x_m, y_m, theta_rad)),
        _ => Err(format!(
            "{} numbers; expected x, y and theta, such as 5.0,0.5,3.14",
            parts.len()
        )),
    }
}

fn spot(text: &str) -> Result<Spot, String> {
    if text == "start" {
        Ok(Spot::Start)
    } else {
        pose(text)
            .map(Spot::Pose)
            .map_err(|error| format!("neither `start` nor a pose: {error}"))
    }
}

fn way(text: &str) -> Result<f64, String> {
    let way_m = number(text)?;
    FreeBehind { way_m }.check()
}

fn load_name(text: &str) -> Result<String, String> {
    let printable = !text.chars().any(char::is_control);
    if printable && !text.is_empty() && Name::new(text).as_str() == text {
        Ok(text.to_owned())
    } else {
        Err(format!(
            "{text:?}; expected a name of 1 to 31 bytes without control characters"
        ))
    }
}

fn mass(text: &str) -> Result<f64, String> {
    not_negative(number(text)?, "kg")
}

impl Load {
    fn check(self) -> Result<Self, String> {
        load_name(&self.name)?;
        not_negative(self.mass_kg, "kg")?;
        Ok(self)
    }
}

impl FreeBehind {
    fn check(self) -> Result<f64, String> {
        let Self { way_m } = self;
        if way_m > 0.0 && way_m <= FARTHEST_BEHIND_M {
            Ok(way_m)
        } else {
            Err(format!(
                "{way_m} m; expected more than 0 and at most {FARTHEST_BEHIND_M} m"
            ))
        }
    }
}

/// What stands before the JSON of a request's parameters on the socket.
fn parameters<'a>(line: &'a str, name: &str) -> Option<&'a str> {
    line.strip_prefix(name)?.strip_prefix(' ')
}

fn read<'a, T: Deserialize<'a>>(json: &'a str) -> Result<T, Refusal> {
    serde_json::from_str(json).map_err(|error| Refusal::Unreadable(error.to_string()))
}

impl Request {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Pause => "pause",
            Self::Resume => "resume",
            Self::Stop => "stop",
            Self::Reset => "reset",
            Self::Place(_) => "place",
            Self::FreeBehind(_) => "free-behind",
            Self::Load(_) => "load",
            Self::Unload => "unload",
            Self::Reload => "reload",
            Self::Send(_) => "send",
            Self::Teleop(_) => "teleop",
        }
    }

    /// The line on the socket.
    pub(crate) fn line(&self) -> String {
        // Numbers are finite and keys are strings: they always serialize.
        let parameters = match self {
            Self::Send(event) => serde_json::to_string(event),
            Self::Place(place) => serde_json::to_string(place),
            Self::FreeBehind(behind) => serde_json::to_string(behind),
            Self::Load(load) => serde_json::to_string(load),
            Self::Teleop(teleop) => serde_json::to_string(teleop),
            plain => return plain.name().to_owned(),
        };
        format!("{} {}", self.name(), parameters.unwrap_or_default())
    }

    pub(super) fn from_line(line: &str) -> Result<Self, Refusal> {
        let plain = [
            Self::Pause,
            Self::Resume,
            Self::Stop,
            Self::Reset,
            Self::Unload,
            Self::Reload,
        ];
        if let Some(event) = parameters(line, "send") {
            return read(event).map(Self::Send);
        }
        if let Some(place) = parameters(line, "place") {
            return read(place).map(Self::Place);
        }
        if let Some(behind) = parameters(line, "free-behind") {
            let behind: FreeBehind = read(behind)?;
            behind.check().map_err(Refusal::Unreadable)?;
            return Ok(Self::FreeBehind(behind));
        }
        if let Some(load) = parameters(line, "load") {
            let load: Load = read(load)?;
            return load.check().map(Self::Load).map_err(Refusal::Unreadable);
        }
        if let Some(teleop) = parameters(line, "teleop") {
            return read(teleop).map(Self::Teleop);
        }
        plain
            .into_iter()
            .find(|request| request.name() == line)
            .ok_or_else(|| Refusal::UnknownRequest(line.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_goes_over_the_socket_with_its_parameters() {
        let event = Instruction {
            event: "stop \"here\"".to_owned(),
            speed_limit_m_s: Some(0.25),
            stop_at: Some(Pose2::new(-1.5, 0.1 + 0.2, 3.0)),
        };
        for request in [
            Request::Send(Event(event)),
            Request::Send(Event(Instruction::plain("go".to_owned()))),
            Request::Reload,
            Request::Place(Place {
                at: Spot::Start,
                state: None,
            }),
            Request::Place(Place {
                at: Spot::Pose(Pose2::new(1.0, -2.5, 0.1)),
                state: Some("drive-1".to_owned()),
            }),
            Request::FreeBehind(FreeBehind { way_m: 1.5 }),
            Request::Load(Load {
                name: "pallet \"17\"".to_owned(),
                mass_kg: 40.5,
            }),
            Request::Unload,
            Request::Teleop(Teleop {
                without_borders: true,
            }),
        ] {
            assert_eq!(Request::from_line(&request.line()), Ok(request));
        }
        let bad = [
            "send",
            "send ",
            "send {}",
            "send go",
            "reload now",
            "",
            "place",
            "place start",
            "place {\"at\":\"home\"}",
            "free-behind 1.0",
            "free-behind {\"way_m\":9.0}",
            "free-behind {\"way_m\":null}",
            "load",
            "load pallet",
            "load {\"name\":\"\",\"mass_kg\":1.0}",
            "load {\"name\":\"a\\nb\",\"mass_kg\":1.0}",
            "load {\"name\":\"a name of more than 31 bytes, by one\",\"mass_kg\":1.0}",
            "load {\"name\":\"pallet\",\"mass_kg\":-1.0}",
            "unload pallet",
            "teleop",
            "teleop now",
        ];
        for bad in bad {
            assert!(Request::from_line(bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn parameters_are_numbers_within_reason() {
        assert_eq!(pose("5.0, -0.5,3.0"), Ok(Pose2::new(5.0, -0.5, 3.0)));
        for bad in ["1,2", "1,2,3,4", "1,2,nan", "1,,3", "", "a,b,c"] {
            assert!(pose(bad).is_err(), "{bad:?}");
        }
        assert_eq!(speed("0"), Ok(0.0));
        for bad in ["-0.1", "inf", "fast"] {
            assert!(speed(bad).is_err(), "{bad:?}");
        }
        assert_eq!(spot("start"), Ok(Spot::Start));
        assert_eq!(spot("1,2,-3"), Ok(Spot::Pose(Pose2::new(1.0, 2.0, -3.0))));
        assert!(spot("home").is_err() && spot("1,2").is_err());
        assert_eq!(way("0.5"), Ok(0.5));
        for bad in ["0", "-1", "2.6", "nan"] {
            assert!(way(bad).is_err(), "{bad:?}");
        }
    }
}
