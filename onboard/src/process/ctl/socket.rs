//! The control socket: one connection carries one line there and text back.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use contract::private;

use super::pending::Pending;
use super::reply::{Done, Refusal, Reply};
use super::request::{Request, Teleop};
use crate::composition::failure::Failure;
use crate::process::runtime::Runtime;

/// How long either side waits for the other's line.
const PATIENCE: Duration = Duration::from_secs(10);
/// The server's patience with a client that connects and says nothing: it delays one tick of the supervisor.
const SERVER_PATIENCE: Duration = Duration::from_millis(50);
/// Stands before the reason of a refusal.
const REFUSED: &str = "refused: ";
/// The longest line that the server reads.
const LONGEST_LINE: usize = 1024;

/// Somebody in whose hands the robot is: the connection goes on.
#[derive(Debug)]
pub struct Guest {
    /// The session's number.
    pub session: u64,
    /// What was asked for.
    pub teleop: Teleop,
    /// Wishes come, and what the robot makes of them goes.
    pub stream: UnixStream,
}

/// Takes a robot into somebody's hands: the connection, which goes on, from its second line.
///
/// # Errors
/// As [`send`].
pub fn begin(
    runtime: &Runtime,
    robot: &str,
    teleop: Teleop,
) -> Result<BufReader<UnixStream>, Failure> {
    let connect = || {
        let mut stream = UnixStream::connect(runtime.socket(robot))?;
        stream.set_read_timeout(Some(PATIENCE))?;
        writeln!(stream, "{}", Request::Teleop(teleop).line())?;
        let (mut reader, mut answer) = (BufReader::new(stream), String::new());
        reader.read_line(&mut answer)?;
        Ok((reader, answer))
    };
    let (reader, answer) = connect().map_err(|error| no_answer(robot, &error))?;
    match answer.trim_end() {
        "" => Err(no_answer(robot, &io::ErrorKind::UnexpectedEof.into())),
        answer => match answer.strip_prefix(REFUSED) {
            None => Ok(reader),
            Some(why) => Err(refuses(robot, "teleop", why)),
        },
    }
}

fn no_answer(robot: &str, error: &io::Error) -> Failure {
    Failure::failed(format_args!("robot `{robot}` does not answer: {error}"))
}

fn refuses(robot: &str, request: &str, why: &str) -> Failure {
    Failure::failed(format_args!("robot `{robot}` refuses to {request}: {why}"))
}

/// Sends one request and prints the answer.
///
/// # Errors
/// [`Failure::Refused`] when there is no such robot, [`Failure::Failed`] when it refuses or does not answer.
pub fn send(runtime: &Runtime, robot: Option<&str>, request: &Request) -> Result<(), Failure> {
    let robot = runtime.choose(robot)?;
    let answer = exchange(runtime, &robot, request).map_err(|error| no_answer(&robot, &error))?;
    match answer.strip_prefix(REFUSED) {
        None => {
            crate::say!("{robot}: {answer}");
            Ok(())
        }
        Some(why) => Err(refuses(&robot, request.name(), why)),
    }
}

/// Sends one request, and says what was answered.
///
/// # Errors
/// Why it was refused, or not answered.
pub fn ask(runtime: &Runtime, robot: &str, request: &Request) -> Result<String, String> {
    let answer = exchange(runtime, robot, request).map_err(|error| error.to_string())?;
    match answer.strip_prefix(REFUSED) {
        None => Ok(answer),
        Some(why) => Err(format!("refused to {}: {why}", request.name())),
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
    /// Where those go in whose hands the robot is.
    guests: Option<Sender<Guest>>,
}

impl Server {
    /// Opens the robot's socket. The caller holds the robot's name, so a socket that is already there is left over.
    ///
    /// # Errors
    /// [`Failure::Refused`] when the socket cannot be opened.
    pub fn open(runtime: &Runtime, robot_id: &str) -> Result<Self, Failure> {
        let path = runtime.socket(robot_id);
        let refused = |error: io::Error| {
            Failure::refused(format_args!("control socket cannot be opened: {error}"))
        };
        let listener = private::listen(&path).map_err(|why| refused(why.into()))?;
        listener.set_nonblocking(true).map_err(refused)?;
        Ok(Self {
            listener,
            path,
            guests: None,
        })
    }

    /// With a desk for those in whose hands the robot is.
    #[must_use]
    pub fn seating(mut self, guests: Sender<Guest>) -> Self {
        self.guests = Some(guests);
        self
    }

    /// The next request, if one waits. Bad ones are answered here, and clients that say nothing are left.
    #[must_use]
    pub fn next(&self) -> Option<Pending> {
        while let Ok((stream, _)) = self.listener.accept() {
            if let Err(why) = private::peer(&stream) {
                answer(&stream, &Err(Refusal::Stranger(why.to_string())));
                continue;
            }
            let Some(line) = first_line(&stream) else {
                continue;
            };
            match Request::from_line(line.trim_end()) {
                Ok(request) => {
                    let guests = self.guests.clone();
                    let teleop = match request {
                        Request::Teleop(teleop) => Some(teleop),
                        _ => None,
                    };
                    let reply = move |reply: &Reply| {
                        answer(&stream, reply);
                        if let (Some(teleop), Ok(Done::Lent(session))) = (teleop, reply) {
                            let guest = Guest {
                                session: *session,
                                teleop,
                                stream,
                            };
                            // Without a desk, the supervisor misses the session and takes the robot back.
                            let _ = guests.map(|guests| guests.send(guest));
                        }
                    };
                    return Some(Pending::new(request, reply));
                }
                Err(why) => answer(&stream, &Err(why)),
            }
        }
        None
    }
}

/// What a client says first; `None` when it says nothing in time.
fn first_line(stream: &UnixStream) -> Option<String> {
    stream
        .set_nonblocking(false)
        .and_then(|()| stream.set_write_timeout(Some(SERVER_PATIENCE)))
        .ok()?;
    let until = Instant::now() + SERVER_PATIENCE;
    let mut line = Vec::new();
    // The whole line has that time, however it drips.
    loop {
        let left = until.checked_duration_since(Instant::now());
        stream
            .set_read_timeout(Some(left.filter(|left| !left.is_zero())?))
            .ok()?;
        let mut bytes = [0; LONGEST_LINE];
        let count = (&*stream).read(&mut bytes[line.len()..]).ok()?;
        line.extend_from_slice(&bytes[line.len()..][..count]);
        if count == 0 || line.contains(&b'\n') || line.len() == LONGEST_LINE {
            let end = line.iter().position(|&byte| byte == b'\n');
            line.truncate(end.map_or(line.len(), |end| end + 1));
            return String::from_utf8(line).ok();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may be gone already.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// A client that has left is not an error.
fn answer(mut stream: &UnixStream, reply: &Reply) {
    let _ = match reply {
        Ok(done) => writeln!(stream, "{done}"),
        Err(why) => writeln!(stream, "{REFUSED}{why}"),
    };
}

#[cfg(test)]
mod tests {
    use std::fs::{Permissions, metadata, set_permissions};
    use std::os::unix::fs::PermissionsExt;

    use rustix::process::Uid;

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
            // One that is held up before it has asked is left by the server, and asks again.
            let ask = move || exchange(&runtime, "amr-1", &Request::Pause).ok();
            std::thread::spawn(move || (0..100).find_map(|_| ask()))
        };
        let until = Instant::now() + PATIENCE;
        let pending = loop {
            if let Some(pending) = server.next() {
                break pending;
            }
            assert!(Instant::now() < until, "nobody asks");
            std::thread::sleep(Duration::from_millis(1));
        };
        assert_eq!(pending.request, Request::Pause);
        pending.answer(&Err(Refusal::NotReady));
        assert_eq!(
            client.join().expect("ends").expect("answered"),
            "refused: navigation does not run yet"
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

    /// The supervisor has other things to do.
    #[test]
    fn a_client_that_drips_does_not_hold_up_the_server() {
        let (_folder, runtime) = runtime();
        let server = Server::open(&runtime, "amr-1").expect("opens");
        let mut stream = UnixStream::connect(runtime.socket("amr-1")).expect("connects");
        let drips = std::thread::spawn(move || {
            for _ in 0..500 {
                if stream.write_all(b"x").is_err() {
                    break;
                }
                std::thread::sleep(SERVER_PATIENCE / 5);
            }
        });
        let began = Instant::now();
        assert!(server.next().is_none());
        assert!(
            began.elapsed() < 20 * SERVER_PATIENCE,
            "{:?}",
            began.elapsed()
        );
        drop(server);
        drips.join().expect("ends");
    }

    #[test]
    fn another_user_is_refused_in_a_sentence_even_where_somebody_has_opened_the_folder() {
        if !rustix::process::geteuid().is_root() {
            eprintln!("skipped: only root can be another user");
            return;
        }
        let (folder, runtime) = runtime();
        let server = Server::open(&runtime, "amr-1").expect("opens");
        let socket = runtime.socket("amr-1");
        let mode = metadata(&socket).expect("it is there").permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
        let open = |path, mode| set_permissions(path, Permissions::from_mode(mode));
        open(folder.path(), 0o755).expect("it is ours");
        open(runtime.folder(), 0o755).expect("it is ours");
        open(socket.as_path(), 0o666).expect("it is ours");
        let stranger = std::thread::spawn(move || {
            // The system call itself, which is for one thread.
            let uid = Uid::from_raw(65534);
            rustix::thread::set_thread_res_uid(uid, uid, uid).expect("root may");
            let mut stream = UnixStream::connect(socket).expect("connects");
            writeln!(stream, "stop").expect("written");
            stream
        });
        let stream = stranger.join().expect("ends");
        assert!(server.next().is_none());
        let mut answer = String::new();
        BufReader::new(stream)
            .read_line(&mut answer)
            .expect("answered");
        let expected = "refused: user 65534 may not ask, only user 0 and root\n";
        assert_eq!(answer, expected);
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
}
