//! `onboard ctl`: requests to a running robot over its control socket.
//!
//! One connection carries one line there, the request's name (after `send` the event as JSON), and text back: what was
//! done, or `refused: WHY`.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand};
use coordination::event::EventId;
use description::geometry::Pose2;
use serde::{Deserialize, Serialize};
use skills::navigator::Instruction;

use crate::composition::failure::Failure;
use crate::process::runtime::Runtime;

/// How long either side waits for the other's line.
const PATIENCE: Duration = Duration::from_secs(10);
/// The server's patience with a client that connects and says nothing: it delays one tick of the supervisor.
const SERVER_PATIENCE: Duration = Duration::from_millis(50);
/// The longest line that the server reads.
const LONGEST_LINE: u64 = 1024;

/// What an operator can ask of a running robot.
#[derive(Clone, Debug, PartialEq, Subcommand)]
pub enum Request {
    /// Slow down and stand; `resume` goes on
    Pause,
    /// Go on after `pause`
    Resume,
    /// Stop hard and stay stopped until `reset`
    Stop,
    /// The causes of faults are seen to: forget them and go on
    Reset,
    /// Take gains, limits, tubes and map from the files anew
    Reload,
    /// Give the robot's state machine one of its external events
    Send(Event),
}

/// An external event of the robot's machine, with what holds in the state that it enters until that state is left.
#[derive(Args, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Name of the event, one of `external` in the site file
    #[arg(value_name = "EVENT")]
    pub name: String,
    /// Drive no faster than this in the state that it enters
    #[arg(long = "speed-limit", value_name = "M_S", value_parser = speed, allow_hyphen_values = true)]
    pub speed_limit_m_s: Option<f64>,
    /// Stop with base_link at this pose in `map`: metres, metres, radians
    #[arg(long, value_name = "X,Y,THETA", value_parser = pose, allow_hyphen_values = true)]
    pub stop: Option<Stop>,
}

/// Where to stop, in `map`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stop {
    /// East.
    pub x_m: f64,
    /// North.
    pub y_m: f64,
    /// Counter-clockwise from east.
    pub theta_rad: f64,
}

impl Event {
    /// As navigation takes it; `id` is the event's number.
    #[must_use]
    pub fn instruction(&self, id: EventId) -> Instruction {
        let stop = self.stop;
        Instruction {
            event: id,
            speed_limit_m_s: self.speed_limit_m_s,
            stop_at: stop.map(|stop| Pose2::new(stop.x_m, stop.y_m, stop.theta_rad)),
        }
    }
}

fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{text}` is no number")),
    }
}

fn speed(text: &str) -> Result<f64, String> {
    let speed_m_s = number(text)?;
    if speed_m_s < 0.0 {
        return Err(format!("{speed_m_s} m/s is negative; expected 0 or more"));
    }
    Ok(speed_m_s)
}

fn pose(text: &str) -> Result<Stop, String> {
    let parts: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    match parts[..] {
        [x_m, y_m, theta_rad] => Ok(Stop {
            x_m,
            y_m,
            theta_rad,
        }),
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
    fn line(&self) -> String {
        match self {
            // Its numbers are finite and its keys are texts: nothing in it cannot be told.
            Self::Send(event) => {
                format!("{SEND}{}", serde_json::to_string(event).unwrap_or_default())
            }
            other => other.name().to_owned(),
        }
    }

    fn from_line(line: &str) -> Result<Self, String> {
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
                .map_err(|error| format!("a request that cannot be read: {error}"));
        }
        plain
            .into_iter()
            .find(|request| request.name() == line)
            .ok_or_else(|| format!("unknown request {line:?}"))
    }
}

/// Sends one request and prints the answer.
///
/// # Errors
/// [`Failure::Refused`] when there is no such robot, [`Failure::Failed`] when it refuses or does not answer.
pub fn send(runtime: &Runtime, robot: Option<&str>, request: &Request) -> Result<(), Failure> {
    let robot = runtime.choose(robot)?;
    let answer = exchange(runtime, &robot, request).map_err(|error| {
        Failure::failed(format_args!("robot `{robot}` does not answer: {error}"))
    })?;
    match answer.strip_prefix("refused: ") {
        None => {
            println!("{robot}: {answer}");
            Ok(())
        }
        Some(why) => Err(Failure::failed(format_args!(
            "robot `{robot}` refuses to {}: {why}",
            request.name()
        ))),
    }
}

fn exchange(runtime: &Runtime, robot: &str, request: &Request) -> io::Result<String> {
    let mut stream = UnixStream::connect(runtime.socket(robot))?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    writeln!(stream, "{}", request.line())?;
    let mut answer = String::new();
    BufReader::new(stream.take(64 * 1024)).read_to_string(&mut answer)?;
    if answer.is_empty() {
        Err(io::ErrorKind::UnexpectedEof.into())
    } else {
        Ok(answer.trim_end().to_owned())
    }
}

/// The robot's side: polled by the supervisor.
#[derive(Debug)]
pub struct Server {
    listener: UnixListener,
    path: PathBuf,
}

/// A request that waits for its answer.
#[derive(Debug)]
pub struct Pending {
    /// What is asked.
    pub request: Request,
    stream: UnixStream,
}

impl Server {
    /// Opens the robot's socket. The caller holds the robot's name, so a socket that is already there is left over.
    ///
    /// # Errors
    /// [`Failure::Refused`] when the socket cannot be opened.
    pub fn open(runtime: &Runtime, robot_id: &str) -> Result<Self, Failure> {
        let path = runtime.socket(robot_id);
        let refused = |error: io::Error| {
            Failure::refused(format_args!(
                "control socket {} cannot be opened: {error}",
                path.display()
            ))
        };
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(refused(error)),
            _ => {}
        }
        let listener = UnixListener::bind(&path).map_err(refused)?;
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o600)).map_err(refused)?;
        listener.set_nonblocking(true).map_err(refused)?;
        Ok(Self { listener, path })
    }

    /// The next request, if one waits. Bad ones are answered here, and clients that say nothing are left.
    #[must_use]
    pub fn next(&self) -> Option<Pending> {
        while let Ok((stream, _)) = self.listener.accept() {
            let Some(line) = first_line(&stream) else {
                continue;
            };
            match Request::from_line(line.trim_end()) {
                Ok(request) => return Some(Pending { request, stream }),
                Err(why) => answer(stream, &Err(why)),
            }
        }
        None
    }
}

/// What a client says first; `None` when it says nothing in time.
fn first_line(stream: &UnixStream) -> Option<String> {
    stream
        .set_nonblocking(false)
        .and_then(|()| stream.set_read_timeout(Some(SERVER_PATIENCE)))
        .and_then(|()| stream.set_write_timeout(Some(SERVER_PATIENCE)))
        .ok()?;
    let mut line = String::new();
    BufReader::new(stream.take(LONGEST_LINE))
        .read_line(&mut line)
        .ok()?;
    Some(line)
}

impl Drop for Server {
    fn drop(&mut self) {
        // Gone already is as good.
        let _ = std::fs::remove_file(&self.path);
    }
}

impl Pending {
    /// Answers; a client that has left is not an error.
    pub fn answer(self, result: &Result<String, String>) {
        answer(self.stream, result);
    }
}

fn answer(mut stream: UnixStream, result: &Result<String, String>) {
    let _ = match result {
        Ok(text) => writeln!(stream, "{text}"),
        Err(why) => writeln!(stream, "refused: {why}"),
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runtime() -> (tempfile::TempDir, Runtime) {
        let folder = tempfile::tempdir().expect("temporary folder");
        let runtime = Runtime::new(Some(folder.path().join("run"))).expect("made");
        (folder, runtime)
    }

    #[test]
    fn a_request_is_answered_and_the_socket_goes_with_the_server() {
        let (_folder, runtime) = runtime();
        let server = Server::open(&runtime, "amr-1").expect("opens");
        let client = {
            let runtime = runtime.clone();
            std::thread::spawn(move || exchange(&runtime, "amr-1", &Request::Pause))
        };
        let pending = std::iter::repeat_with(|| server.next())
            .flatten()
            .next()
            .expect("arrives");
        assert_eq!(pending.request, Request::Pause);
        pending.answer(&Err("not now".into()));
        assert_eq!(
            client.join().expect("ends").expect("answered"),
            "refused: not now"
        );
        drop(server);
        assert!(runtime.robots().is_empty());
    }

    #[test]
    fn an_unknown_request_is_refused_and_a_silent_client_does_not_hang_the_server() {
        let (_folder, runtime) = runtime();
        let server = Server::open(&runtime, "amr-1").expect("opens");
        let _silent = UnixStream::connect(runtime.socket("amr-1")).expect("connects");
        assert!(server.next().is_none());
        let mut stream = UnixStream::connect(runtime.socket("amr-1")).expect("connects");
        writeln!(stream, "dance").expect("written");
        assert!(server.next().is_none());
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("answered");
        assert!(answer.starts_with("refused: unknown request"), "{answer}");
    }

    #[test]
    fn a_robot_must_be_named_when_there_are_several() {
        let (_folder, runtime) = runtime();
        assert!(runtime.choose(None).is_err());
        let _one = Server::open(&runtime, "a").expect("opens");
        assert!(runtime.choose(None).is_ok_and(|id| id == "a"));
        let _two = Server::open(&runtime, "b").expect("opens");
        assert!(runtime.choose(None).is_err());
        assert!(runtime.choose(Some("b")).is_ok());
        assert!(runtime.choose(Some("c")).is_err());
    }

    #[test]
    fn an_event_goes_over_the_socket_with_its_parameters() {
        let event = Event {
            name: "stop \"here\"".into(),
            speed_limit_m_s: Some(0.25),
            stop: Some(Stop {
                x_m: -1.5,
                y_m: 0.1 + 0.2,
                theta_rad: 3.0,
            }),
        };
        for request in [
            Request::Send(event),
            Request::Send(Event {
                name: "go".into(),
                speed_limit_m_s: None,
                stop: None,
            }),
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
        assert_eq!(
            pose("5.0, -0.5,3.0"),
            Ok(Stop {
                x_m: 5.0,
                y_m: -0.5,
                theta_rad: 3.0
            })
        );
        for bad in ["1,2", "1,2,3,4", "1,2,nan", "1,,3", "", "a,b,c"] {
            assert!(pose(bad).is_err(), "{bad:?}");
        }
        assert_eq!(speed("0"), Ok(0.0));
        for bad in ["-0.1", "inf", "fast"] {
            assert!(speed(bad).is_err(), "{bad:?}");
        }
    }
}
