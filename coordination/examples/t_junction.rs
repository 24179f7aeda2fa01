//! Three robots, one crossing, one mediator.
//!
//! ```text
//!   ------------------------------
//!    road 1  ->  [ Cr ]  <-  road 2        Robots come from three roads, each when it likes. The
//!   -----------+        +---------         crossing area Cr holds one of them at a time.
//!              | road 3 |
//! ```
//!
//! Each robot runs on its own thread and has a state machine; the mediator runs on one more and has
//! a Petri net. All that they share is one protocol each: *request*, *granted*, *entered*,
//! *released*, in this order, set by the robot or by the mediator. An output of the machine sets a
//! flag, the flag fills a source of the net, firing marks a sink, the sink sets the mediator's flag,
//! and that is the next input of the machine.
//!
//! `cargo run -p coordination --example t_junction` prints who crosses when, and ends by itself.

use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use coordination::analysis::{self, Limits, Use};
use coordination::binding::NetBinding;
use coordination::event::{EventId, EventTable};
use coordination::fsm::{Machine, MachineModel};
use coordination::petri::{Binding, Budget, NetModel};
use coordination::protocol::{
    Change, End, ModelError, Party, Protocol, ProtocolModel, Side, channel,
};

const ROBOTS: [&str; 3] = ["robot 1", "robot 2", "robot 3"];

/// What a thread can end with.
type Failure = Box<dyn Error + Send + Sync>;

/// How long and how fast the robots drive.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// How often each robot crosses.
    pub crossings: u32,
    /// How long it takes to drive along a road, or across; zero means as fast as threads can.
    pub drive: Duration,
    /// How long the whole may take before it counts as stuck.
    pub patience: Duration,
    /// Whether to print who crosses when.
    pub print: bool,
}

/// What happened at the junction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// How often robots crossed, together.
    pub crossings: u32,
    /// How many robots were in Cr at once, at most.
    pub most_inside: u32,
    /// How many transitions of the mediator's net fired.
    pub firings: u64,
}

fn main() -> ExitCode {
    let settings = Settings {
        crossings: 5,
        drive: Duration::from_millis(20),
        patience: Duration::from_secs(30),
        print: true,
    };
    match run(settings) {
        Ok(outcome) if outcome.most_inside == 1 => {
            println!(
                "{} crossings, {} firings, never more than one robot in Cr",
                outcome.crossings, outcome.firings
            );
            ExitCode::SUCCESS
        }
        Ok(outcome) => {
            eprintln!("error: {} robots were in Cr at once", outcome.most_inside);
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The flags that a robot and the mediator share, in order, and who sets which. When a run of the
/// protocol is over, the array is empty again for the next.
fn protocol() -> Result<Protocol, ModelError> {
    let mut model = ProtocolModel::new("area", "robot", "mediator");
    model.keeper("mediator").array(
        "cross",
        &[
            ("request", "robot"),
            ("granted", "mediator"),
            ("entered", "robot"),
            ("released", "robot"),
        ],
    );
    model.compile()
}

/// A robot's states: where it is. Its outputs set flags of the protocol; `granted` is one; the other inputs are its own events.
fn robot_model() -> MachineModel {
    let mut model = MachineModel::new("robot");
    for state in ["on the road", "at the border", "entering", "in Cr"] {
        model.state(state);
    }
    model.initial("on the road");
    model.transition("on the road", "near", "at the border", &["request"]);
    model.transition("at the border", "granted", "entering", &[]);
    model.transition("entering", "inside", "in Cr", &["entered"]);
    model.transition("in Cr", "outside", "on the road", &["released"]);
    model
}

/// The mediator's decision: whoever asks gets the token `free` and gives it back when it has left.
fn mediator_model() -> NetModel {
    let mut model = NetModel::new("T junction");
    model.place("free").mark("free");
    let mut holders = vec!["free".to_owned()];
    for robot in ROBOTS {
        let place = |what: &str| format!("{robot} {what}");
        let [asked, granted, entered, released] =
            ["request", "granted", "entered", "released"].map(&place);
        let [entering, inside] = ["entering", "inside"].map(&place);
        model.source(&asked, Binding::flag(robot, "request"));
        model.sink(&granted, Binding::flag(robot, "granted"));
        model.source(&entered, Binding::flag(robot, "entered"));
        model.source(&released, Binding::flag(robot, "released"));
        model.place(&entering).place(&inside);
        let grant = [granted.as_str(), entering.as_str()];
        model.transition(place("is let in"), &[&asked, "free"], &grant);
        model.transition(place("enters"), &[&entered, &entering], &[&inside]);
        model.transition(place("leaves"), &[&released, &inside], &["free"]);
        holders.extend([entering, inside]);
    }
    let holders: Vec<&str> = holders.iter().map(String::as_str).collect();
    model.exclusion("one robot in Cr", &holders);
    model.end("everybody is away", &["free"]);
    model
}

/// The world: it knows the truth about Cr, which neither machine nor net looks at.
struct World {
    begin: Instant,
    settings: Settings,
    inside: AtomicU32,
    most_inside: AtomicU32,
}

impl World {
    fn say(&self, robot: &str, what: &str) {
        if self.settings.print {
            let time_ms = self.begin.elapsed().as_secs_f64() * 1e3;
            println!("{time_ms:8.1} ms  {robot} {what}");
        }
    }

    fn enter(&self) {
        let inside = self.inside.fetch_add(1, Ordering::Relaxed) + 1;
        self.most_inside.fetch_max(inside, Ordering::Relaxed);
    }

    fn leave(&self) {
        self.inside.fetch_sub(1, Ordering::Relaxed);
    }

    fn drive(&self, roads: u32) {
        if !self.settings.drive.is_zero() {
            thread::sleep(self.settings.drive * roads);
        }
    }

    /// Lets other threads run; an error when patience is at its end.
    fn wait(&self, who: &str, why: &str) -> Result<(), Failure> {
        if self.begin.elapsed() > self.settings.patience {
            return Err(format!("{who} is stuck: {why}").into());
        }
        if self.settings.drive.is_zero() {
            thread::yield_now();
        } else {
            thread::sleep(Duration::from_micros(200));
        }
        Ok(())
    }
}

/// A robot: its state machine, and its end of the protocol.
struct Robot<'a> {
    name: &'a str,
    machine: Machine,
    end: End,
    world: &'a World,
}

impl Robot<'_> {
    /// Steps the machine. Its outputs set flags, each as soon as it is next.
    fn step(&mut self, event: EventId) -> Result<(), Failure> {
        let outputs = self.machine.step(event).outputs.to_vec();
        for output in outputs {
            let flag = self.end.protocol().flag(self.machine.output_name(output));
            let flag = flag.ok_or("an output is no flag")?;
            while self.end.set(flag).is_err() {
                // The mediator has not read the end of the last run.
                self.end.poll();
                self.wait()?;
            }
        }
        Ok(())
    }

    /// Waits for a flag of the mediator, and steps the machine by it.
    fn hear(&mut self) -> Result<(), Failure> {
        loop {
            if let Some(Change::Flag(flag)) = self.end.poll() {
                let event = self.machine.input(self.end.protocol().flag_name(flag));
                return self.step(event.ok_or("a flag is no input")?);
            }
            self.wait()?;
        }
    }

    fn wait(&self) -> Result<(), Failure> {
        let state = self.machine.state_name(self.machine.state());
        self.world.wait(self.name, state)
    }
}

/// One robot drives up to the crossing, asks, waits, crosses, and comes back.
fn robot(name: &str, number: u32, end: End, world: &World) -> Result<u32, Failure> {
    let mut events = EventTable::new();
    let machine = robot_model().compile(&mut events)?;
    let [near, inside, outside] = ["near", "inside", "outside"].map(|name| events.intern(name));
    let (near, inside, outside) = (near?, inside?, outside?);
    let mut robot = Robot {
        name,
        machine,
        end,
        world,
    };
    for _ in 0..world.settings.crossings {
        world.drive(1 + number);
        world.say(name, "asks");
        robot.step(near)?;
        robot.hear()?;
        world.enter();
        world.say(name, "enters Cr");
        robot.step(inside)?;
        world.drive(1);
        world.say(name, "leaves Cr");
        world.leave();
        robot.step(outside)?;
    }
    Ok(world.settings.crossings)
}

/// The mediator: reads flags, lets the net decide, sets flags, until all robots are gone.
fn mediator(mut net: NetBinding<End>, world: &World) -> Result<u64, Failure> {
    loop {
        let gone = { ROBOTS.iter() }.all(|name| net.side(name).is_some_and(End::is_abandoned));
        let progress = net.step(Budget::default(), |_| true);
        if gone && progress.read == 0 && !progress.remaining {
            break;
        }
        world.wait("the mediator", "robots are still there")?;
    }
    let executor = net.executor();
    let marking: Vec<_> = executor
        .marking()
        .map(|p| executor.net().place_name(p))
        .collect();
    if marking != ["free"] {
        return Err(format!("everybody is away, but the net says {marking:?}").into());
    }
    Ok(executor.firings())
}

/// Runs the junction until every robot has crossed as often as `settings` says.
///
/// # Errors
/// If the net is refused by its analysis, or the run does not end as it must.
pub fn run(settings: Settings) -> Result<Outcome, Failure> {
    let protocol = Arc::new(protocol()?);
    let model = mediator_model();

    // A net may run only when it is proved that it never lets two robots in and never gets stuck,
    // whatever the robots do.
    let uses = ROBOTS.map(|robot| Use::new(robot, Arc::clone(&protocol), Party::Second));
    let proof = analysis::check(&model, &uses, &Limits::default())?;

    let net = model.compile(&mut EventTable::new()).map_err(all)?;
    let (robot_ends, mediator_ends): (Vec<End>, Vec<End>) =
        ROBOTS.iter().map(|_| channel(&protocol)).unzip();
    let net = NetBinding::new(&proof, &net, ROBOTS.into_iter().zip(mediator_ends)).map_err(all)?;
    let world = World {
        begin: Instant::now(),
        settings,
        inside: AtomicU32::new(0),
        most_inside: AtomicU32::new(0),
    };
    let (crossings, firings) = thread::scope(|scope| {
        let world = &world;
        let robots: Vec<_> = { ROBOTS.into_iter().zip(robot_ends).zip(0..) }
            .map(|((name, end), number)| scope.spawn(move || robot(name, number, end, world)))
            .collect();
        let firings = scope.spawn(move || mediator(net, world));
        let mut crossings = 0;
        for robot in robots {
            crossings += joined(robot)?;
        }
        Ok::<_, Failure>((crossings, joined(firings)?))
    })?;
    Ok(Outcome {
        crossings,
        most_inside: world.most_inside.into_inner(),
        firings,
    })
}

fn joined<T>(thread: thread::ScopedJoinHandle<Result<T, Failure>>) -> Result<T, Failure> {
    thread
        .join()
        .unwrap_or_else(|_| Err("a thread panicked".into()))
}

/// All problems of a model in one message.
fn all(errors: Vec<impl Error>) -> Failure {
    let errors: Vec<String> = errors.iter().map(ToString::to_string).collect();
    errors.join("; ").into()
}
