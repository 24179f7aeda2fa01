//! What an operator can ask of a running robot, on the command line and on the socket.

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, Subcommand};
use description::geometry::Pose2;
use description::instruction::Instruction;
use serde::{Deserialize, Serialize};

use super::reply::Refusal;

/// What an operator can ask of a running robot.
#[derive(Clone, Debug, PartialEq, Subcommand)]
pub enum Request {
    /// Slow down and stand; `resume` goes on
    Pause,
    /// Go on after `pause`
    Resume,
    /// Stop hard and stay stopped until `reset`
    Stop,
    /// Forget faults whose causes are dealt with, and go on
    Reset,
    /// Read gains, limits, tubes and map from the files again
    Reload,
    /// Give the robot's state machine one of its external events
    Send(Event),
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

fn speed(text: &str) -> Result<f64, String> {
    let speed_m_s = number(text)?;
    if speed_m_s < 0.0 {
        return Err(format!("{speed_m_s} m/s is negative; expected 0 or more"));
    }
    Ok(speed_m_s)
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

/// What stands before an event on the socket.
const SEND: &str = "send ";

impl Request {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Pause => "pause",
            Self::Resume => "resume",
            Self::Stop => "stop",
            Self::Reset => "reset",
            Self::Reload => "reload",
            Self::Send(_) => "send",
        }
    }

    /// The line on the socket.
    pub(super) fn line(&self) -> String {
        match self {
            // Its numbers are finite and its keys are strings: it always serializes.
            Self::Send(event) => {
                format!("{SEND}{}", serde_json::to_string(event).unwrap_or_default())
            }
            other => other.name().to_owned(),
        }
    }

    pub(super) fn from_line(line: &str) -> Result<Self, Refusal> {
        let plain = [
            Self::Pause,
            Self::Resume,
            Self::Stop,
            Self::Reset,
            Self::Reload,
        ];
        if let Some(event) = line.strip_prefix(SEND) {
            return serde_json::from_str(event)
                .map(Self::Send)
                .map_err(|error| Refusal::Unreadable(error.to_string()));
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
    fn an_event_goes_over_the_socket_with_its_parameters() {
        let event = Instruction {
            event: "stop \"here\"".to_owned(),
            speed_limit_m_s: Some(0.25),
            stop_at: Some(Pose2::new(-1.5, 0.1 + 0.2, 3.0)),
        };
        for request in [
            Request::Send(Event(event)),
            Request::Send(Event(Instruction::plain("go".to_owned()))),
            Request::Reload,
        ] {
            assert_eq!(Request::from_line(&request.line()), Ok(request));
        }
        for bad in ["send", "send ", "send {}", "send go", "reload now", ""] {
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
    }
}
