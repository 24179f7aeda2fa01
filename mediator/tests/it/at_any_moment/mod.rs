//! The real program, killed at random moments.
//!
//! `mediator run` with its journal in a file, zenoh on the loopback, and robots with the contract's own client that go where
//! they like, some of them over a crossing on which the shipped net lets one robot at a time. The mediator is killed and
//! started again, and robots forget everything. Two judges look on: the floor, which knows where the bodies are, and an
//! observer on the network, which knows owners by their fences and asks nobody.
//!
//! Two mediators of one site, of which either is killed while the other one runs: the floor alone judges, since each has fences of its own.
//!
//! Each in [`RUNS`] runs at a time: a fleet waits for leases, of 5 s, most of the time. `MEDIATOR_KILLS` asks for more kills.

mod fleet;
mod observer;

use std::collections::BTreeSet;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::program::{Program, Site, folder, free_endpoint, session};
use crate::random::Random;
use fleet::Fleet;
use observer::Observer;

const ROAMERS: usize = 2;
const CROSSERS: usize = 3;
const ROOMS: usize = 8;
const CROSSING: &str = "Cr";
/// One kill of so many comes after robots have moved since the one before it.
const WORKS_BEFORE: u64 = 4;
const RUNS: u64 = 2;
/// Longer than anything here takes on a machine that has other things to do.
const PATIENCE: Duration = Duration::from_secs(30);

/// Rooms for one, in which robots go from each to any other, and the crossing.
fn site() -> Site {
    let mut areas: Vec<(String, u32)> =
        (0..ROOMS).map(|room| (format!("room-{room}"), 1)).collect();
    areas.push((CROSSING.to_owned(), 1));
    let robots = (0..ROAMERS + CROSSERS).map(|robot| (format!("amr-{robot}"), "normal", robot));
    Site {
        name: "rooms".into(),
        areas,
        robots: robots.collect(),
        events: Vec::new(),
        // One that stands still for long on a busy machine is no news here.
        more: "[coordinations.crossing]\nnet = \"t-junction\"\nalarm_after_s = 300.0\nsituations.all-outside = { \
               west = { robot = \"amr-2\" }, east = { robot = \"amr-3\" }, south = { robot = \"amr-4\" } }\n"
            .into(),
        nets: vec!["t-junction"],
        own_nets: Vec::new(),
    }
}

fn kills() -> u64 {
    let asked = std::env::var("MEDIATOR_KILLS").ok();
    asked.map_or(8, |text| {
        text.parse()
            .unwrap_or_else(|_| panic!("MEDIATOR_KILLS must be a number, found `{text}`"))
    })
}

/// Some of this many kills in each run, with other numbers each time.
fn in_runs(kills: u64, run: impl Fn(u64, Random) + Sync) {
    let clock = SystemTime::now().duration_since(UNIX_EPOCH);
    let seed = clock.map_or(1, |since| since.as_nanos() as u64);
    println!("seed {seed}");
    let mut random = Random::new(seed);
    std::thread::scope(|threads| {
        for _ in 0..RUNS {
            let random = Random::new(random.next());
            threads.spawn(|| run(kills.div_ceil(RUNS), random));
        }
    });
}

/// Work goes on for everyone.
fn until_all_move(fleet: &mut Fleet, times: u64) {
    let before = fleet.moves_by_robot();
    fleet.run_until(PATIENCE, |fleet| {
        let after = fleet.moves_by_robot();
        let mut both = after.iter().zip(&before);
        both.all(|(after, before)| *after >= before + times)
    });
}

#[test]
fn the_mediator_may_be_killed_at_any_moment() {
    in_runs(kills(), kill_again_and_again);
}

fn kill_again_and_again(kills: u64, mut random: Random) {
    let folder = folder();
    let (watching, observer_at) = session(&[]);
    let (driving, robots_at) = session(std::slice::from_ref(&observer_at));
    let observer = Observer::new(watching);
    let site = site();
    let mut fleet = Fleet::new(driving, &site, ROAMERS, CROSSING, random.next());
    let mut program = Program::new(folder.path(), &site, vec![robots_at, observer_at]);
    program.start();
    program.wait_ready(PATIENCE);
    fleet.run_until(PATIENCE, |fleet| fleet.moves() >= 20);

    let begun = Instant::now();
    let (mut during_start, mut worked) = (0, 0);
    for kill in 1..=kills {
        let before = fleet.moves();
        fleet.run(Duration::from_millis(random.below(1000)));
        if kill % WORKS_BEFORE == 0 {
            // However slow the machine is: some kills hit a fleet at work.
            fleet.run_until(PATIENCE, |fleet| fleet.moves() > before);
        }
        if fleet.moves() > before {
            worked += 1;
        }
        if random.chance(25) {
            fleet.forget(random.below((ROAMERS + CROSSERS) as u64) as usize);
        }
        program.kill();
        if random.chance(50) {
            fleet.run(Duration::from_millis(random.below(200)));
        }
        program.start();
        if random.chance(20) {
            // Killed during its start.
            fleet.run(Duration::from_millis(random.below(60)));
            program.kill();
            program.start();
            during_start += 1;
        }
    }
    let took = begun.elapsed();

    until_all_move(&mut fleet, 3);
    fleet.run_until(PATIENCE, |fleet| fleet.crossings() > 0);
    // Nothing is lost: whoever stays where it is has that area, and there is nobody else.
    fleet.park();
    fleet.run_until(PATIENCE, Fleet::is_parked);
    let until = Instant::now() + PATIENCE;
    loop {
        fleet.run(Duration::from_millis(100));
        let status = program.wait_ready(PATIENCE);
        let held = status.areas.iter().flat_map(|area| {
            let robots = area.holders.iter();
            robots.map(|(robot, _)| (robot.clone(), area.id.clone()))
        });
        let held: BTreeSet<(String, String)> = held.collect();
        let crossing =
            { status.coordinations.iter() }.find(|own| !own.over && own.net == "t-junction");
        let marking = crossing.map(|own| own.marking.clone());
        // Requests that nobody wants any more wait on: they are returned when they are granted.
        if held == fleet.standing() && marking == Some(vec!["free".to_owned()]) {
            break;
        }
        assert!(
            Instant::now() < until,
            "robots stand in {:?}, and the mediator says {status:#?}",
            fleet.standing()
        );
    }
    let epoch = program.wait_ready(PATIENCE).epoch;
    program.kill();

    let seen = observer.finish();
    let log = program.log();
    let accused: Vec<&str> = { log.lines() }
        .filter(|line| line.contains("WARN") || line.contains("ERROR"))
        .filter(|line| !line.contains(" is silent; ") && !line.contains(" is back"))
        // Each start is asked for as if it were the first.
        .filter(|line| !line.contains("leave out --first-start"))
        .collect();
    println!(
        "{kills} kills and {during_start} more right after a start in {:.1} s, {epoch} starts took effect; {} moves, {} over the crossing, \
         {worked} times work between kills; robots forgot everything {} times; \
         observer: {} reports, {} owners by fence, {} messages of the mediator",
        took.as_secs_f64(),
        fleet.moves(),
        fleet.crossings(),
        fleet.forgot(),
        seen.reports,
        seen.owners,
        seen.messages,
    );
    assert!(seen.accusations.is_empty(), "{:#?}", seen.accusations);
    assert!(accused.is_empty(), "{accused:#?}");
    assert_eq!(fleet.lost(), 0, "grants were taken from robots");
    assert!(
        seen.owners as u64 >= fleet.moves(),
        "the observer has not seen all: {seen:?}"
    );
    assert!(worked >= kills / WORKS_BEFORE);
}

#[test]
fn of_two_mediators_one_leads_and_either_may_be_killed() {
    in_runs(kills() / 2, kill_either);
}

fn kill_either(kills: u64, mut random: Random) {
    let (driving, robots_at) = session(&[]);
    let site = site();
    let mut fleet = Fleet::new(driving, &site, ROAMERS, CROSSING, random.next());
    let folders = [(); 2].map(|()| folder());
    let endpoint = free_endpoint("tcp");
    let first = Program::new(folders[0].path(), &site, vec![robots_at.clone()]);
    let second = Program::new(folders[1].path(), &site, vec![robots_at, endpoint.clone()]);
    let mut programs = [first, second];
    programs[0].listen(&endpoint);
    programs[0].start();
    programs[0].wait_ready(PATIENCE);
    fleet.run_until(PATIENCE, |fleet| fleet.moves() >= 20);
    programs[1].start();
    let mut leading_killed = 0;
    for _ in 0..kills {
        programs[0].wait_ready(PATIENCE);
        programs[1].wait_ready(PATIENCE);
        fleet.run(Duration::from_millis(random.below(3000)));
        until_all_move(&mut fleet, 1);
        let killed = random.below(2) as usize;
        let stands_by = programs[killed].wait_ready(PATIENCE).stands_by;
        leading_killed += u64::from(!stands_by);
        // Such a robot may follow either.
        fleet.forget(random.below((ROAMERS + CROSSERS) as u64) as usize);
        fleet.run(Duration::from_millis(random.below(500)));
        programs[killed].kill();
        if random.chance(50) {
            // The other one takes over, if it was not the one that leads.
            until_all_move(&mut fleet, 1);
        }
        programs[killed].start();
    }
    until_all_move(&mut fleet, 3);
    let until = Instant::now() + PATIENCE;
    loop {
        fleet.run(Duration::from_millis(100));
        let leads = { programs.iter() }.filter(|own| !own.wait_ready(PATIENCE).stands_by);
        if leads.count() == 1 {
            break;
        }
        assert!(
            Instant::now() < until,
            "both lead, or neither: {:?}",
            programs.map(|own| own.log())
        );
    }
    println!(
        "{kills} kills, {leading_killed} of the one that leads; {} moves",
        fleet.moves()
    );
    programs.iter_mut().for_each(Program::kill);
}
