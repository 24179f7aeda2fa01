//! Two machines agree over a link that loses, repeats, delays and reorders messages: each has a replica of
//! the protocol and sends its whole level now and then; no message is acknowledged or sent again.
//!
//! ```sh
//! cargo run -p coordination --example lossy_link
//! ```
//!
//! With a number it loses so many percent of the messages.

use std::collections::VecDeque;
use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;

use coordination::protocol::{Change, Level, Party, Protocol, ProtocolModel, Replica, Side};

/// How often the robot passes.
const RUNS: u32 = 50;
/// Two sides that do not get on within so many rounds are stuck.
const PATIENCE: u32 = 100_000;

fn main() -> ExitCode {
    let percent = match std::env::args().nth(1).map(|text| text.parse()) {
        None => 60,
        Some(Ok(percent @ 0..=99)) => percent,
        Some(_) => {
            eprintln!("expected how many percent are lost, 0 to 99");
            return ExitCode::FAILURE;
        }
    };
    match run(percent, 7) {
        Ok(outcome) => {
            println!(
                "{} runs in {} rounds: {} levels sent, {} lost, {} changed nothing",
                outcome.runs, outcome.rounds, outcome.sent, outcome.lost, outcome.stale
            );
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// What happened on the link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// How many runs both sides have completed.
    pub runs: u32,
    /// How often both sides had their turn.
    pub rounds: u32,
    /// How many levels were sent.
    pub sent: u32,
    /// How many of them were lost.
    pub lost: u32,
    /// How many arrived that told nothing new: repeated or late ones.
    pub stale: u32,
}

/// Messages under way, which come in any order, several times, or never.
struct Link {
    under_way: VecDeque<Level>,
    percent_lost: u64,
}

impl Link {
    fn send(&mut self, level: Level, random: &mut Random, outcome: &mut Outcome) {
        outcome.sent += 1;
        if random.below(100) < self.percent_lost {
            outcome.lost += 1;
            return;
        }
        for _ in 0..1 + random.below(2) {
            self.under_way.push_back(level);
        }
    }

    /// One of those under way, if one arrives now.
    fn receive(&mut self, random: &mut Random) -> Option<Level> {
        let arrives = random.below(2) == 0 && !self.under_way.is_empty();
        let which = random.below(self.under_way.len().max(1) as u64) as usize;
        arrives
            .then(|| self.under_way.swap_remove_back(which))
            .flatten()
    }
}

/// Random numbers, the same for the same seed (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 20) % limit
    }
}

/// The robot passes [`RUNS`] times, over a link that loses so many percent.
///
/// # Errors
/// If a side refuses a level, or sees a flag out of order, which cannot be; or if they get stuck.
pub fn run(percent_lost: u64, seed: u64) -> Result<Outcome, Box<dyn Error>> {
    let mut model = ProtocolModel::new("gate", "robot", "mediator");
    let flags = [
        ("request", "robot"),
        ("granted", "mediator"),
        ("released", "robot"),
    ];
    model.array("pass", &flags);
    let protocol = Arc::new(model.compile()?);
    let mut robot = Replica::new(&protocol, 0, Party::First, 0);
    let mut mediator = Replica::new(&protocol, 0, Party::Second, 0);
    let link = || Link {
        under_way: VecDeque::new(),
        percent_lost,
    };
    let (mut up, mut down) = (link(), link());
    let mut random = Random(seed.max(1));
    let (mut outcome, mut free) = (Outcome::default(), true);
    while outcome.runs < RUNS {
        outcome.rounds += 1;
        if outcome.rounds > PATIENCE {
            return Err(format!("they got stuck in run {}", robot.run()).into());
        }
        if let Some(level) = up.receive(&mut random) {
            count(mediator.merge(level)?, &mut outcome);
        }
        if let Some(level) = down.receive(&mut random) {
            count(robot.merge(level)?, &mut outcome);
        }
        for flag in flags_read(&mut mediator, &protocol) {
            match (flag.as_str(), free) {
                ("request", true) => {
                    free = false;
                    mediator.set(named(&protocol, "granted")?)?;
                }
                ("released", false) => {
                    free = true;
                    outcome.runs += 1;
                }
                (flag, _) => return Err(format!("`{flag}` at the wrong time").into()),
            }
        }
        for flag in flags_read(&mut robot, &protocol) {
            if flag != "granted" || free {
                return Err(format!("the robot read `{flag}`, and free is {free}").into());
            }
            robot.set(named(&protocol, "released")?)?;
        }
        // Refused until the mediator has read the end of the last run.
        let _ = robot.set(named(&protocol, "request")?);
        up.send(robot.level(), &mut random, &mut outcome);
        down.send(mediator.level(), &mut random, &mut outcome);
    }
    Ok(outcome)
}

fn named(
    protocol: &Protocol,
    flag: &str,
) -> Result<coordination::protocol::FlagId, Box<dyn Error>> {
    protocol
        .flag(flag)
        .ok_or_else(|| format!("no flag `{flag}`").into())
}

fn flags_read(side: &mut Replica, protocol: &Protocol) -> Vec<String> {
    let changes = std::iter::from_fn(|| side.poll());
    changes
        .map(|change| match change {
            Change::Flag(flag) => protocol.flag_name(flag).to_owned(),
            Change::Aborted => "aborted".to_owned(),
        })
        .collect()
}

fn count(merged: coordination::protocol::Merged, outcome: &mut Outcome) {
    outcome.stale += u32::from(merged == coordination::protocol::Merged::Nothing);
}
