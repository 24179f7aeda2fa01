//! `onboard teleop`: a person drives a running robot by hand, while a dead-man is held.
//!
//! [`link`] is the connection to the robot; wishes come from the [`keyboard`] of a terminal, from [`lines`] of standard input,
//! or from a [`gamepad`]; [`screen`] shows what the robot makes of them. What is held is said to the robot at once when it
//! changes and every [`PERIOD`]; what is not said any more, the robot forgets by its own clock.

mod gamepad;
mod input;
mod keyboard;
mod lines;
mod link;
mod screen;
mod terminal;

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::Args;
use description::geometry::Twist2;

use crate::composition::failure::Failure;
use crate::process::ctl::{self, Request};
use crate::process::runtime::Runtime;
use crate::process::signals::termination_flag;
use input::Input;
use link::Link;
use screen::View;

/// How often the robot is told what is wanted while that stays the same.
const PERIOD: Duration = Duration::from_millis(50);

/// What `--help` says after the options.
const HELP: &str = "\
Keys: q w e forward left, straight, right; a s d backward; + - speed; 1 2 3 curve; r resets faults; x leaves.
The robot drives while a key is held, and stops when it is let go, when this program ends, and when nothing was heard for
`teleop.deadline_ms`. Tubes, borders and limits hold. Backward it drives only over floor that it knows, or that
`onboard ctl free-behind` names. `onboard ctl stop` takes it away. Afterwards it stays paused until `onboard ctl resume`.";

/// What the command line says.
#[derive(Clone, Debug, Args)]
#[command(after_help = HELP)]
pub(super) struct TeleopArgs {
    /// Robot to drive; may be left out while only one runs
    robot: Option<String>,
    /// Read lines `FORWARD_M_S TURN_RAD_S` from standard input, each good for `teleop.deadline_ms`; print JSON. The end stops
    #[arg(long, conflicts_with = "gamepad")]
    stdin: bool,
    /// Drive with this gamepad, such as /dev/input/event3, or the first there is; a shoulder button is the dead-man
    #[arg(long, value_name = "DEVICE", num_args = 0..=1, default_missing_value = "")]
    gamepad: Option<String>,
    /// Creep also while the robot does not know where it is: you see to it that it enters no area that others use
    #[arg(long)]
    without_borders: bool,
    /// Folder for the names of running robots [default: $XDG_RUNTIME_DIR/onboard, or /tmp/onboard-UID]
    #[arg(long = "runtime", value_name = "DIR", env = "ONBOARD_RUNTIME_DIR")]
    folder: Option<PathBuf>,
}

/// Drives a robot by hand.
///
/// # Errors
/// [`Failure::Refused`] when there is no such robot or nothing to drive it with, [`Failure::Failed`] when it refuses, or takes
/// itself back.
pub(super) fn teleop(arguments: TeleopArgs) -> Result<(), Failure> {
    let runtime = Runtime::new(arguments.folder)?;
    let robot = runtime.choose(arguments.robot.as_deref())?;
    let ends = termination_flag().map_err(Failure::refused)?;
    let teleop = ctl::Teleop {
        without_borders: arguments.without_borders,
    };
    if arguments.stdin {
        let link = Link::begin(&runtime, &robot, teleop)?;
        return lines::drive(link, &ends);
    }
    if !(std::io::stdin().is_terminal() && std::io::stdout().is_terminal()) {
        return Err(Failure::refused(
            "standard input and output must be a terminal; run it in one, or give wishes as lines with --stdin",
        ));
    }
    // Before the robot is in anybody's hands.
    let pad = { arguments.gamepad.as_deref() }
        .map(gamepad::Gamepad::open)
        .transpose()
        .map_err(Failure::refused)?;
    let link = Link::begin(&runtime, &robot, teleop)?;
    let reset = || ctl::ask(&runtime, &robot, &Request::Reset);
    drive(&robot, link, pad, reset, &ends)
}

/// Drives with keyboard or gamepad, on the terminal.
fn drive(
    robot: &str,
    mut link: Link,
    mut pad: Option<gamepad::Gamepad>,
    reset: impl Fn() -> Result<String, String>,
    ends: &AtomicBool,
) -> Result<(), Failure> {
    let gone =
        |error: std::io::Error| Failure::failed(format_args!("the terminal is gone: {error}"));
    let mut terminal = terminal::Terminal::take().map_err(gone)?;
    let mut keys = keyboard::Keyboard::new(terminal.tells_releases());
    let mut note = String::new();
    let (mut wish, mut said) = (Twist2::default(), None::<(Twist2, Instant)>);
    while !ends.load(Ordering::Relaxed) {
        let key = keys.poll(PERIOD / 5).map_err(gone)?;
        let now = Instant::now();
        let padded = match &mut pad {
            Some(pad) => pad.poll(now).map_err(Failure::failed)?,
            None => Input::Nothing,
        };
        // With a gamepad, keys drive nothing: what it wants comes last.
        for input in [key, padded] {
            match input {
                // With a gamepad, keys drive nothing.
                Input::Wants(twist) => wish = twist,
                Input::Reset => note = reset().unwrap_or_else(|why| why),
                Input::Leaves => return Ok(()),
                Input::Nothing => {}
            }
        }
        let due = said.is_none_or(|(last, at)| last != wish || now - at >= PERIOD);
        if due {
            link.say(wish)?;
            said = Some((wish, now));
        }
        if let Some(status) = link.hear()? {
            let view = View {
                robot,
                held: wish.v_m_s != 0.0,
                tells_releases: terminal.tells_releases(),
                gamepad: pad.is_some(),
                setting: keys.setting(),
                status: &status,
                note: &note,
            };
            terminal.show(&view.lines()).map_err(gone)?;
        }
    }
    Ok(())
}
