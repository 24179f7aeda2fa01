//! The shipped nets: they may run, and run, with robots that take their time.

use crate::common::lines;
use config::{NetConfig, load_net};
use coordination::analysis::{Limits, Proof, Reason, Warning};
use coordination::binding::NetBinding;
use coordination::event::EventTable;
use coordination::petri::{Budget, Dot};
use coordination::protocol::{Change, End, Party, Position, Side, channel};

fn shipped(name: &str) -> NetConfig {
    load_net(format!("nets/{name}.toml")).unwrap_or_else(|error| panic!("{}", lines(&error)))
}

fn prove(net: &NetConfig, situation: &str) -> Proof {
    let proofs = net.analyse(&Limits::default()).unwrap();
    let of = |proof: &Proof| proof.report().situation.as_deref() == Some(situation);
    proofs.into_iter().find(of).unwrap()
}

#[test]
fn every_shipped_net_may_run() {
    let mut found = 0;
    for file in std::fs::read_dir("nets").unwrap() {
        let path = file.unwrap().path();
        let net = load_net(&path).unwrap_or_else(|error| panic!("{}", lines(&error)));
        assert_eq!(path.file_stem().unwrap().to_str(), Some(net.name.as_str()));
        let proofs = net
            .analyse(&Limits::default())
            .unwrap_or_else(|refusal| panic!("{refusal}"));
        assert_eq!(proofs.len(), net.situations.len());
        for proof in proofs {
            let report = proof.report();
            assert_eq!(report.warnings, [], "{}", report.net);
            assert!(report.states < 10_000, "{report:?}");
            assert!(!report.ends.is_empty(), "{report:?}");
        }
        found += 1;
    }
    assert_eq!(found, 3);
}

#[test]
fn a_wrong_net_is_refused_in_the_words_of_its_file() {
    let edited = |name: &str, from: &str, to: &str| {
        let text = std::fs::read_to_string(format!("nets/{name}.toml")).unwrap();
        let text = crate::common::edit(&text, from, to);
        config::parse_net("some.toml", &text)
            .unwrap_or_else(|error| panic!("{}", lines(&error)))
            .analyse(&Limits::default())
            .map(|proofs| {
                proofs
                    .iter()
                    .flat_map(|proof| proof.report().warnings.clone())
                    .collect::<Vec<Warning>>()
            })
    };
    // The crossing is free again as soon as the robot from the west is on it.
    let refusal = edited(
        "t-junction",
        "west-in = { from = [\"west-enters\", \"west-may-come\"], to = [\"west-inside\"] }",
        "west-in = { from = [\"west-enters\", \"west-may-come\"], to = [\"west-inside\", \"free\"] }",
    )
    .unwrap_err();
    let text = refusal.to_string();
    assert!(
        text.starts_with("net `t-junction` in situation `all-outside`: ") && text.contains("west sets request; let-west-in; mediator raises west.granted; west sets entered; west-in; "),
        "{text}"
    );
    // e2 before done1: the flag would be out of order.
    let refusal = edited(
        "overtaking",
        "go-on = { from = [\"emergency-in-1\", \"emergency-done1\"], to = [\"emergency-in-2\", \"area-1-free\", \"emergency-e2\"] }",
        "go-on = { from = [\"emergency-in-1\"], to = [\"emergency-in-2\", \"area-1-free\", \"emergency-e2\"] }\nforget = { from = [\"emergency-done1\", \"emergency-gone\"], to = [\"emergency-gone\"] }",
    )
    .unwrap_err();
    let Reason::OutOfOrder { flag, next, .. } = &*refusal.reason else {
        panic!("{refusal}");
    };
    assert_eq!(
        (flag.as_str(), next.as_str()),
        ("e2", "`done1` of `emergency`")
    );
    assert!(refusal.to_string().contains("pass; go-on"), "{refusal}");
    // Nobody opens for the small robots again.
    let refusal = edited(
        "docking",
        "to = [\"in-free\", \"out-free\", \"open\"] }\n\n# --",
        "to = [\"in-free\", \"out-free\"] }\n\n# --",
    )
    .unwrap_err();
    assert!(
        matches!(
            *refusal.reason,
            Reason::Deadlock { .. } | Reason::Livelock { .. }
        ),
        "{refusal}"
    );
    assert!(
        refusal.to_string().contains("big-leaves-access"),
        "{refusal}"
    );
    // The exclusion is proved, not assumed.
    let refusal = edited(
        "docking",
        "let-big-in = { from = [\"closed\", \"in-free\", \"out-free\"]",
        "let-big-in = { from = [\"closed\", \"in-free\"]",
    )
    .unwrap_err();
    let text = refusal.to_string();
    assert!(
        text.contains("exclusion `lane-out` is broken")
            || text.contains("second token into place `out-free`"),
        "{text}"
    );
}

#[test]
fn pictures_show_meanings() {
    let net = shipped("overtaking");
    let model = net.model("normal-ahead").unwrap();
    let about = |name: &str| net.place(name).map(|place| place.about.as_str());
    let picture = Dot::new(&model).notes(about).to_string();
    assert!(
        picture.contains("tooltip=\"the normal robot waits in area 5\""),
        "{picture}"
    );
    assert!(picture.contains("\"normal-e5\\nnormal.e5 →\""), "{picture}");
}

/// Numbers that only look random (xorshift).
struct Coin(u64);

impl Coin {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % limit
    }
}

/// A robot that sets one of the flags that it may set next.
struct Robot {
    role: String,
    side: End,
    /// Runs that it still begins or takes part in.
    left: u32,
    /// Runs of others that were granted while it waited for its own grant.
    overtaken: u32,
}

impl Robot {
    fn turn(&mut self, coin: &mut Coin) {
        while let Some(change) = self.side.poll() {
            let Change::Flag(flag) = change else {
                panic!("nobody aborts");
            };
            let protocol = self.side.protocol();
            assert_eq!(protocol.owner(flag), Some(Party::Second));
        }
        let protocol = self.side.protocol();
        // After a complete run the next begins.
        let at = match self.side.position() {
            at if protocol.is_end(at) => Position::START,
            at => at,
        };
        let next: Vec<_> = protocol.next(at).collect();
        let (flag, to) = next[coin.below(next.len())];
        if protocol.owner(flag) != Some(Party::First) || (at == Position::START && self.left == 0) {
            return;
        }
        let ends = protocol.is_end(to);
        if self.side.set(flag).is_ok() && ends {
            self.left -= 1;
        }
    }

    /// The flags set in this run.
    fn flags(&self) -> Vec<String> {
        let protocol = self.side.protocol();
        let at = self.side.position();
        if protocol.is_end(at) {
            return Vec::new();
        }
        let flags = protocol.set_flags(at);
        flags
            .map(|(flag, _)| protocol.flag_name(flag).to_owned())
            .collect()
    }
}

/// What must hold at every moment, from what the robots themselves know.
type Judge = fn(&mut [Robot], &[String]);

/// Runs a net until all robots have made `runs` runs and it is at an end.
fn run(net: &NetConfig, proof: &Proof, runs: u32, seed: u64, judge: Judge) {
    let mut events = EventTable::new();
    let compiled = proof.model().compile(&mut events).unwrap();
    let (mut sides, mut robots) = (Vec::new(), Vec::new());
    for used in net.uses() {
        let (robot, mediator) = channel(&used.protocol);
        sides.push((used.name.clone(), mediator));
        robots.push(Robot {
            role: used.name,
            side: robot,
            left: runs,
            overtaken: 0,
        });
    }
    let mut binding = NetBinding::new(proof, &compiled, sides).unwrap();
    let mut coin = Coin(seed * 2 + 0x9E37_79B9_7F4A_7C15);
    // Some robots are slower than others.
    let patience: Vec<usize> = robots.iter().map(|_| 1 + coin.below(12)).collect();
    for _ in 0..200_000 {
        for (robot, &patience) in robots.iter_mut().zip(&patience) {
            if coin.below(patience) == 0 {
                robot.turn(&mut coin);
            }
        }
        let budget = Budget {
            firings: 1 + coin.below(4) as u32,
            ..Budget::default()
        };
        let progress = binding.step(budget, |_| true);
        assert!(binding.is_proved_by(proof));
        let marked: Vec<String> = binding
            .executor()
            .marking()
            .map(|place| compiled.place_name(place).to_owned())
            .collect();
        for exclusion in &net.exclusions {
            let both = marked
                .iter()
                .filter(|place| exclusion.places.contains(place))
                .count();
            assert!(
                both <= 1,
                "seed {seed}: {} is broken by {marked:?}",
                exclusion.id
            );
        }
        judge(&mut robots, &marked);
        let mut sorted = marked.clone();
        sorted.sort_unstable();
        let at_end = net.ends.iter().any(|end| {
            let mut places = end.places.clone();
            places.sort_unstable();
            places == sorted
        });
        if at_end && !progress.remaining && robots.iter().all(|robot| robot.left == 0) {
            assert!(robots.iter().all(|robot| robot.flags().is_empty()));
            return;
        }
    }
    let left: Vec<_> = robots
        .iter()
        .map(|r| (r.role.as_str(), r.left, r.flags()))
        .collect();
    panic!(
        "seed {seed}: `{}` does not come to an end: {left:?}",
        net.name
    );
}

fn has(robot: &Robot, flag: &str) -> bool {
    robot.flags().iter().any(|set| set == flag)
}

#[test]
fn t_junction_lets_one_at_a_time_cross_and_everybody_at_some_time() {
    let net = shipped("t-junction");
    let proof = prove(&net, "all-outside");
    for seed in 1..=200 {
        run(&net, &proof, 5, seed, |robots, _| {
            let on_crossing = robots.iter().filter(|robot| has(robot, "granted")).count();
            assert!(on_crossing <= 1);
        });
    }
}

#[test]
fn overtaking_passes_only_while_the_normal_robot_stands_aside() {
    let net = shipped("overtaking");
    let proofs = ["normal-ahead", "normal-aside"].map(|situation| prove(&net, situation));
    for seed in 1..=300 {
        for proof in &proofs {
            run(&net, proof, 1, seed, |robots, marked| {
                let [emergency, normal] = robots else {
                    panic!("two roles");
                };
                if has(emergency, "e1") && !has(emergency, "done2") {
                    assert!(
                        marked.iter().any(|place| place == "normal-in-5"),
                        "{marked:?}"
                    );
                    assert!(!has(normal, "e1"));
                }
                // It is told to slow down before anything else.
                assert!(!has(emergency, "e1") || has(emergency, "slowed"));
            });
        }
    }
}

#[test]
fn docking_keeps_the_big_robot_alone_and_lets_nobody_wait_for_ever() {
    let net = shipped("docking");
    let proof = prove(&net, "all-outside");
    for seed in 1..=200 {
        // Three rounds, in and out.
        run(&net, &proof, 6, seed, |robots, _| {
            let inside = |robot: &Robot, flag| has(robot, flag);
            let big = robots.iter().any(|robot| inside(robot, "granted"));
            for lane in ["go-in", "go-out"] {
                let small = robots.iter().filter(|robot| inside(robot, lane)).count();
                assert!(small <= 1 && !(small == 1 && big));
            }
        });
    }
}

/// The big robot asks once while the small ones never pause, and the other way round.
#[test]
fn docking_starves_neither_kind() {
    let net = shipped("docking");
    let proof = &prove(&net, "all-outside");
    for eager in ["small", "big"] {
        let mut events = EventTable::new();
        let compiled = proof.model().compile(&mut events).unwrap();
        let (mut sides, mut robots) = (Vec::new(), Vec::new());
        for used in net.uses() {
            let (robot, mediator) = channel(&used.protocol);
            sides.push((used.name.clone(), mediator));
            let is_eager = used.name.starts_with(eager);
            let left = if is_eager { u32::MAX } else { 1 };
            robots.push(Robot {
                role: used.name,
                side: robot,
                left,
                overtaken: 0,
            });
        }
        let mut binding = NetBinding::new(proof, &compiled, sides).unwrap();
        let mut coin = Coin(7);
        for step in 0_u32..2000 {
            for robot in &mut robots {
                // Those who ask once begin when the others are in full swing.
                if robot.left == u32::MAX || step > 50 {
                    let waits = robot.flags().len() == 1;
                    robot.turn(&mut coin);
                    robot.overtaken += u32::from(waits);
                }
            }
            binding.step(Budget::default(), |_| true);
        }
        for robot in robots.iter().filter(|robot| !robot.role.starts_with(eager)) {
            assert_eq!(robot.left, 0, "{} starves", robot.role);
            assert!(
                robot.overtaken < 30,
                "{} waits for {} turns",
                robot.role,
                robot.overtaken
            );
        }
    }
}
