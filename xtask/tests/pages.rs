//! Every command that a page tells a reader to type is run: here, by another test, or by `.ci/run`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Who runs a command.
#[derive(Debug)]
enum Run {
    /// This test, which expects success.
    Here,
    /// This test, which leaves this out: it takes as long as all of CI, and changes nothing but speed.
    HereWithout(&'static str),
    /// This test, beside a mediator that it starts.
    BesideMediator,
    /// `.ci/run`, which has a line with all of its words in this order, and perhaps more.
    ByCi,
    /// Another test, in a file that names this.
    ByTest {
        file: &'static str,
        naming: &'static str,
    },
    /// Nobody: what it takes is not there when tests run.
    Needs(&'static str),
}
use Run::{BesideMediator, ByCi, ByTest, Here, HereWithout, Needs};

const CONTROLS: &str = "hil-tests/rig/tests/it/a_fleet/stepped.rs";
const PROGRAM: &str = "hil-tests/rig/tests/it/a_fleet/programs/program.rs";
const LAPS: &str = "hil-tests/rig/tests/it/laps/programs.rs";
const OPERATOR: &str = "hil-tests/rig/tests/it/operator/programs.rs";
const ORDERS: &str = "hil-tests/rig/tests/it/orders/programs.rs";
const TELEOP: &str = "hil-tests/rig/tests/it/by_hand/programs.rs";
const HARDWARE: &str = "the robot's own hardware, and an administrator";
const BOARD: &str = "a robot's own computer, with the package";
const CROSS: &str = "a Debian with ARM's compiler and emulator, and a quarter of an hour";
const PYTHON: &str = "the conformance kit's Python packages";
const SELFTEST: &str = "contract/kit/selftest/run.py";
const SERVE: &str = "target/debug/mediator run --site config/sites/overtaking.toml --first-start";

/// All commands of all pages, each once.
const COMMANDS: &[(&str, Run)] = &[
    // onboard/INSTALL
    ("scripts/xu4 toolchain", Needs(CROSS)),
    ("scripts/xu4 build", Needs(CROSS)),
    ("scripts/xu4 package", Needs(CROSS)),
    ("scripts/xu4 count", Needs(CROSS)),
    ("scripts/xu4 measure odroid@board", Needs("a board")),
    ("sudo apt install ./onboard_*_armhf.deb", Needs(BOARD)),
    (
        "sudo cp /usr/share/onboard/config/robots/amr-1.toml /etc/onboard/robot.toml",
        Needs(BOARD),
    ),
    (
        "sudo cp /usr/share/onboard/config/sites/corridor.toml /etc/onboard/site.toml",
        Needs(BOARD),
    ),
    ("sudo /usr/share/onboard/take-port eth0", Needs(BOARD)),
    (
        "sudo systemctl enable systemd-networkd onboard",
        Needs(BOARD),
    ),
    ("sudo reboot", Needs(BOARD)),
    ("sudo systemctl stop onboard", Needs(BOARD)),
    ("sudo onboard-doctor", Needs(BOARD)),
    ("sudo systemctl start onboard", Needs(BOARD)),
    ("sudo systemctl restart onboard", Needs(BOARD)),
    ("systemctl status onboard", Needs(BOARD)),
    (
        "sudo -u onboard onboard inspect --runtime /run/onboard",
        Needs(BOARD),
    ),
    ("sudo systemctl disable --now irqbalance", Needs(BOARD)),
    (
        "sudo systemctl mask sleep.target suspend.target hibernate.target hybrid-sleep.target",
        Needs(BOARD),
    ),
    ("sudo apt install linux-image-rt-armmp", Needs(BOARD)),
    // contract/kit/README
    ("cargo build --bin rig --bin onboard", ByCi),
    ("cd contract", Needs(PYTHON)),
    (
        "python -m kit robot --start 'exec python -m kit.robot --connect {endpoint} --prefix {prefix} --at 0.75,0 --route a,b,c,d'",
        ByTest {
            file: SELFTEST,
            naming: "--at 0.75,0 --route a,b,c,d",
        },
    ),
    (
        "python contract/kit selftest --mediator 'target/debug/mediator run --site contract/kit/sites/kit.toml --journal {folder}/journal --first-start --listen {endpoint} --key-prefix {prefix} --runtime {folder}'",
        ByCi,
    ),
    (
        "python -m kit.robot --connect tcp/127.0.0.1:7447 --site kit --id kit-1 --at 1.0,0.0 --route a,b,c,hall",
        Needs(PYTHON),
    ),
    (
        "python contract/kit mediator --areas a,b,c,hall --coordinated kit-1:call:bay --start 'target/debug/mediator run --site contract/kit/sites/kit.toml --journal {folder}/journal --first-start --listen {endpoint} --key-prefix {prefix} --runtime {folder}'",
        ByTest {
            file: SELFTEST,
            naming: "\"--areas\", \"a,b,c,hall\", \"--coordinated\", \"kit-1:call:bay\"",
        },
    ),
    (
        "python contract/kit robot --robot amr-1 --site overtaking --patience 60 --start 'sh contract/kit/start_onboard.sh target/debug config overtaking {endpoint} {prefix} {folder}'",
        ByCi,
    ),
    (
        "python3 -m venv venv",
        ByTest {
            file: ".ci/run",
            naming: "python3 -m venv",
        },
    ),
    (
        "venv/bin/pip install -r contract/kit/requirements.txt",
        ByTest {
            file: ".ci/run",
            naming: "-r contract/kit/requirements.txt",
        },
    ),
    // README
    (
        "cargo run --bin rig -- overtaking",
        ByTest {
            file: PROGRAM,
            naming: "\"overtaking\"",
        },
    ),
    ("cargo test --workspace", ByCi),
    (
        "cargo test --workspace -- --ignored stepped:: a_fleet:: model:: published:: whole_floor:: no_run_leads",
        ByCi,
    ),
    (
        "cargo run --bin rig -- docking",
        ByTest {
            file: PROGRAM,
            naming: "\"docking\"",
        },
    ),
    (
        "cargo run --bin rig -- t-junction",
        ByTest {
            file: PROGRAM,
            naming: "\"t-junction\"",
        },
    ),
    (
        "cargo run --bin rig -- campaign overtaking --runs 20",
        ByTest {
            file: ".ci/run",
            naming: "--bin rig -- campaign overtaking --runs 1",
        },
    ),
    (
        "cargo run --bin rig -- overtaking --without-mediator",
        ByTest {
            file: CONTROLS,
            naming: "without_the_mediator",
        },
    ),
    (
        "cargo run --bin rig -- overtaking --without-nets",
        ByTest {
            file: CONTROLS,
            naming: "without_nets",
        },
    ),
    (
        "cargo run --bin rig -- lap",
        ByTest {
            file: LAPS,
            naming: "\"lap\"",
        },
    ),
    (
        "cargo run --bin rig -- lap --robot config/robots/amr-1.toml --site config/sites/corridor.toml",
        ByTest {
            file: LAPS,
            naming: "\"--robot\"",
        },
    ),
    (
        "cargo run --bin rig -- lap --stepped --laps 1800 --driven-h 24",
        Needs("ten minutes; hours, bounds and encoders have tests of their own"),
    ),
    (
        "cargo run --bin rig -- course",
        ByTest {
            file: PROGRAM,
            naming: "\"course\"",
        },
    ),
    (
        "cargo run --bin rig -- clutter",
        ByTest {
            file: PROGRAM,
            naming: "\"clutter\"",
        },
    ),
    ("cargo run --bin rig -- clutter --stepped --runs 100", ByCi),
    (
        "cargo run --bin rig -- overtaking --stepped --runs 20",
        ByCi,
    ),
    (
        "cargo run --bin rig -- campaign overtaking --stepped --runs 200 --faults",
        ByCi,
    ),
    (
        "cargo run --bin rig -- campaign faults --stepped --runs 3",
        ByCi,
    ),
    ("cargo run --bin rig -- map config/sites/course.toml", Here),
    (
        "cargo run --bin rig -- scenario config/scenarios/overtaking.toml",
        ByTest {
            file: PROGRAM,
            naming: "\"scenario\"",
        },
    ),
    (
        "cargo run --bin rig -- devices --robot config/robots/amr-1.toml --ethercat udp:127.0.0.1:34980",
        ByTest {
            file: "hil-tests/rig/tests/it/stranger/programs.rs",
            naming: "\"devices\"",
        },
    ),
    (
        "cargo run --bin onboard -- check --robot config/robots/amr-1.toml --site config/sites/corridor.toml",
        Here,
    ),
    (
        "cargo run --bin mediator -- check --site config/sites/overtaking.toml",
        Here,
    ),
    (
        "cargo run --bin mediator -- show --site config/sites/overtaking.toml --net overtaking",
        Here,
    ),
    ("cargo build --bin mediator", Here),
    (SERVE, BesideMediator),
    ("target/debug/mediator status", BesideMediator),
    ("target/debug/mediator why amr-1", BesideMediator),
    ("target/debug/mediator clear 3", BesideMediator),
    (
        "target/debug/mediator close 3 --because \"wet floor\"",
        BesideMediator,
    ),
    ("target/debug/mediator open 3", BesideMediator),
    (
        "target/debug/mediator end overtaking",
        ByTest {
            file: "mediator/tests/it/shipped.rs",
            naming: "manager.end(",
        },
    ),
    (
        "target/debug/mediator absent amr-2 --taken-away",
        BesideMediator,
    ),
    ("target/debug/mediator orders", BesideMediator),
    (
        "target/debug/mediator keys site --site config/sites/overtaking.toml",
        BesideMediator,
    ),
    (
        "target/debug/mediator keys robot amr-1 amr-2 --site config/sites/overtaking.toml",
        BesideMediator,
    ),
    (
        "target/debug/mediator keys operator anna --site config/sites/overtaking.toml",
        BesideMediator,
    ),
    (
        "target/debug/mediator keys operator anna --replace --site config/sites/overtaking.toml",
        BesideMediator,
    ),
    (
        "target/debug/mediator status --connect tls/localhost:7447 --identity anna.pem",
        BesideMediator,
    ),
    (
        "target/debug/mediator keys revoke --robot amr-2 --site config/sites/overtaking.toml",
        BesideMediator,
    ),
    (
        "cargo build --release --bin onboard",
        HereWithout(" --release"),
    ),
    ("sudo groupadd --system --force robots", Needs(HARDWARE)),
    (
        "sudo usermod --append --groups robots \"$USER\"",
        Needs(HARDWARE),
    ),
    (
        "sudo chown root:robots target/release/onboard",
        Needs(HARDWARE),
    ),
    ("sudo chmod 0750 target/release/onboard", Needs(HARDWARE)),
    (
        "sudo setcap cap_net_raw,cap_sys_nice,cap_ipc_lock+ep target/release/onboard",
        Needs(HARDWARE),
    ),
    (
        "target/release/onboard run --robot config/robots/amr-1.toml --site config/sites/corridor.toml --set 'ethercat.interface=\"eth0\"' --set 'lidar.device=\"/dev/ttyACM0\"'",
        Needs(HARDWARE),
    ),
    (
        "target/release/onboard doctor --robot config/robots/amr-1.toml --site config/sites/corridor.toml",
        ByTest {
            file: "onboard/tests/doctor.rs",
            naming: "\"doctor\"",
        },
    ),
    (
        "target/release/onboard inspect --watch",
        ByTest {
            file: OPERATOR,
            naming: "\"inspect\"",
        },
    ),
    (
        "target/release/onboard ctl pause",
        ByTest {
            file: OPERATOR,
            naming: "ask(\"pause\")",
        },
    ),
    (
        "target/release/onboard ctl place start",
        ByTest {
            file: OPERATOR,
            naming: "\"place start\"",
        },
    ),
    (
        "target/release/onboard ctl free-behind 1.5",
        ByTest {
            file: OPERATOR,
            naming: "ask(\"free-behind 1.5\")",
        },
    ),
    (
        "target/release/onboard ctl load 'pallet 17' --mass-kg 40",
        ByTest {
            file: OPERATOR,
            naming: "ask(\"load pallet --mass-kg 40\")",
        },
    ),
    (
        "target/release/onboard teleop amr-1",
        ByTest {
            file: TELEOP,
            naming: "[\"teleop\"",
        },
    ),
    (
        "target/release/onboard ctl send stop --stop 5.0,0.5,3.14159",
        ByTest {
            file: ORDERS,
            naming: "\"send\"",
        },
    ),
    ("cargo run --example tube_timing", Here),
    (
        "cargo run --release --bin rig -- bench",
        ByTest {
            file: "hil-tests/rig/tests/it/measured/programs.rs",
            naming: "\"bench\"",
        },
    ),
    ("cargo bench -p mediator --bench mediator -- sessions", ByCi),
    (
        "cargo test --test it localisation::timing -- --ignored --nocapture",
        Here,
    ),
    // CONTRIBUTING
    (
        "bash .ci/run",
        Needs("everything else: it is what runs these tests"),
    ),
    ("cargo xtask house", Here),
    ("cargo xtask fuzz", ByCi),
    (
        "cargo test -p mediator",
        ByTest {
            file: ".ci/run",
            naming: "cargo test --workspace",
        },
    ),
    (
        "cargo test -p config",
        ByTest {
            file: ".ci/run",
            naming: "cargo test --workspace",
        },
    ),
    (
        "cargo test -p onboard",
        ByTest {
            file: ".ci/run",
            naming: "cargo test --workspace",
        },
    ),
    (
        "cargo run -p config --example keys > config/KEYS.md",
        ByTest {
            file: "config/tests/it/keys_page.rs",
            naming: "KEYS.md",
        },
    ),
    // coordination/README
    ("cargo run --example t_junction", Here),
    (
        "cargo run --example pnml -- coordination/tests/pnml/printer.pnml",
        Here,
    ),
    ("cargo run --example machine_and_net", Here),
    ("cargo run --example lossy_link", Here),
    (
        "cargo run --example registration",
        ByTest {
            file: "coordination/tests/symbols/example.rs",
            naming: "examples/registration.rs",
        },
    ),
    (
        "cargo test -p coordination --features pnml,symbolic,serde",
        // With which `cargo test --workspace` compiles it.
        ByTest {
            file: "hil-tests/rig/Cargo.toml",
            naming: "features = [\"pnml\", \"serde\", \"symbols\"]",
        },
    ),
    (
        "cargo run --release -p coordination --example petri_families -- --baseline",
        ByTest {
            file: ".ci/run",
            naming: "--example petri_families -- --check",
        },
    ),
    (
        "cargo test -p coordination",
        ByTest {
            file: ".ci/run",
            naming: "cargo test --workspace",
        },
    ),
    (
        "RUSTFLAGS=\"--cfg loom\" CARGO_TARGET_DIR=target/loom cargo test --release -p coordination --test loom_protocol",
        ByTest {
            file: ".ci/run",
            naming: "-p coordination --test loom_protocol",
        },
    ),
    (
        "RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Zsanitizer=thread CARGO_TARGET_DIR=target/tsan cargo test -Zbuild-std --target x86_64-unknown-linux-gnu -p coordination --test it -- t_junction protocol",
        Needs("the sources of Rust's standard library"),
    ),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn commands() -> Vec<xtask::pages::Command> {
    xtask::pages::commands(&root()).expect("readable pages")
}

#[test]
fn every_command_of_a_page_is_run_by_somebody() {
    let table: BTreeMap<&str, &Run> = COMMANDS.iter().map(|(text, run)| (*text, run)).collect();
    let commands = commands();
    for command in &commands {
        assert!(
            table.contains_key(command.text.as_str()),
            "{}:{}: nobody runs `{}`; say in xtask/tests/pages.rs who does",
            command.page.display(),
            command.line,
            command.text
        );
    }
    for text in table.keys() {
        assert!(
            commands.iter().any(|command| command.text == *text),
            "`{text}` stands on no page any more"
        );
    }
}

#[test]
fn what_a_page_names_is_there() {
    let findings = xtask::pages::broken_paths(&root()).expect("readable pages");
    assert!(findings.is_empty(), "{}", findings.join("\n"));
}

#[test]
fn commands_that_ci_runs_stand_in_its_script() {
    let script = fs::read_to_string(root().join(".ci/run")).expect(".ci/run");
    for (text, _) in COMMANDS.iter().filter(|(_, run)| matches!(run, ByCi)) {
        // On the simulated clock it is another command.
        let stepped = |line: &str| line.contains("--stepped");
        let runs = script.lines().any(|line| {
            let mut words = line.split_whitespace();
            stepped(line) == stepped(text)
                && text
                    .split_whitespace()
                    .all(|wanted| words.any(|word| word == wanted))
        });
        assert!(runs, ".ci/run has no line with `{text}`");
    }
}

#[test]
fn commands_that_other_tests_run_are_named_there() {
    for (text, run) in COMMANDS {
        match run {
            ByTest { file, naming } => {
                let source = fs::read_to_string(root().join(file))
                    .unwrap_or_else(|error| panic!("{file}: {error}"));
                assert!(
                    source.contains(naming),
                    "{file} should run `{text}`, but has no `{naming}`"
                );
            }
            Needs(what) => assert!(!what.is_empty()),
            Here | HereWithout(_) | BesideMediator | ByCi => {}
        }
    }
}

/// A command as a reader types it, in the repository's root. What cargo tells a test about its crate is kept from it:
/// build scripts below zenoh run again when that changes, and all above them is compiled again.
fn bash(text: &str) -> Command {
    let mut command = Command::new("bash");
    command.args(["-c", text]).current_dir(root());
    for (name, _) in std::env::vars_os() {
        let name = name.to_string_lossy().into_owned();
        let of_the_crate = ["CARGO_PKG_", "CARGO_MANIFEST_", "CARGO_BIN_"];
        if of_the_crate.iter().any(|start| name.starts_with(start)) {
            command.env_remove(name);
        }
    }
    command
}

/// Runs a command, which is to succeed.
fn run(text: &str, environment: &[(&str, &Path)]) {
    let output = bash(text)
        .envs(environment.iter().copied())
        .output()
        .expect("bash");
    assert!(
        output.status.success(),
        "`{text}`: {}\n{}{}",
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

/// A process that ends with this.
struct Ends(Child);

impl Drop for Ends {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn commands_beside_a_mediator_reach_it() {
    run("cargo build --bin mediator", &[]);
    let folder = tempfile::tempdir().expect("a folder");
    let (runtime, journal) = (
        folder.path().join("run"),
        folder.path().join("journal.redb"),
    );
    // A port, keys and files of its own: another mediator may run on this machine. The port is below those that Linux gives to whoever
    // asks for any, so that nobody has it by chance before the mediator listens.
    let is_free = |&port: &u16| std::net::TcpListener::bind(("127.0.0.1", port)).is_ok();
    let port = (20_000..30_000).find(is_free).expect("a free port");
    let own = |text: &str| {
        let mut text = text
            .replace("tls/localhost:7447", &format!("tls/127.0.0.1:{port}"))
            .replace(
                "anna.pem",
                &folder.path().join("anna.pem").display().to_string(),
            );
        if text.contains("keys robot") || text.contains("keys operator") {
            text += &format!(" --out {}", folder.path().display());
        }
        text
    };
    let environment = [
        ("MEDIATOR_RUNTIME_DIR", runtime.as_path()),
        ("XDG_STATE_HOME", folder.path()),
    ];
    let beside = COMMANDS
        .iter()
        .filter(|(_, run)| matches!(run, BesideMediator))
        .map(|(text, _)| *text)
        .filter(|text| *text != SERVE);
    let makes_keys = |text: &&str| text.contains(" keys ") && !text.contains(" revoke ");
    let (before, after): (Vec<&str>, Vec<&str>) = beside.partition(makes_keys);
    before.iter().for_each(|text| run(&own(text), &environment));
    let serve = format!(
        "exec {SERVE} --listen tls/127.0.0.1:{port} --journal {}",
        journal.display()
    );
    let mediator = bash(&serve)
        .envs(environment)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("bash");
    let mediator = Ends(mediator);
    let began = Instant::now();
    while !runtime.join("overtaking.ctl").exists() {
        assert!(began.elapsed() < Duration::from_secs(60), "no mediator");
        std::thread::sleep(Duration::from_millis(20));
    }
    // For so long any robot may still enter what the mediator before has granted to it; this one counts from before its socket was there.
    std::thread::sleep(Duration::from_secs(5));
    after.iter().for_each(|text| run(&own(text), &environment));
    drop(mediator);
}

#[test]
fn short_commands_do_what_they_should() {
    for (text, by) in COMMANDS {
        match by {
            Here => run(text, &[]),
            HereWithout(what) => run(&text.replace(what, ""), &[]),
            _ => {}
        }
    }
}
