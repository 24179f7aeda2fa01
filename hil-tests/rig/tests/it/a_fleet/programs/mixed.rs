//! Two robots of ours and one of another vendor at the junction: the example of the conformance kit, in Python, with a certificate.
//!
//! Its body is simulated by its own program. Here it is a disc where that says it is, which the others see and can run into.
//! Needs a Python with what `contract/kit/requirements.txt` names: `RIG_PYTHON`, else `python3`.

use std::path::Path;
use std::process::{Child, Command, Stdio};

use contract::network::Party;
use contract::private;
use mediator::keys::Keys;
use rig::run::Ending;
use rig::scenario::{self, Changes};
use sim::world::{Obstacle, ObstacleId, Shape};

use crate::programs::fleet::{Bench, CONFIG, Run, has};
use crate::programs::late::{once_more_if_late, safe};

const STRANGER: &str = "amr-3";
const RADIUS_M: f64 = 0.2;
/// Where it is put.
const START: &str = "R2i";
/// Keeping right: west over the crossing, round at the end of the road, and back east.
const ROUND: &str = "R2i@4:0.6,R1o@-4:0.6,R1t@-5.4:0.6,R1t@-5.4:-0.6,R1i@-4:-0.6,R2o@4:-0.6,R2t@5.4:-0.6,R2t@5.4:0.6";
const KIT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../contract");

/// The robot in Python, and its body in the world.
struct Stranger {
    process: Child,
    body: Option<ObstacleId>,
    /// It stands where it was put before it can ask for that.
    is_let_in: bool,
    /// Areas that it has reached into.
    been_in: Vec<String>,
}

impl Stranger {
    fn start(python: &str, run: &Run) -> Self {
        let folder = run.stage.folder();
        let identity = Keys::new(folder.join("keys"))
            .issue(Party::Robot(STRANGER.to_owned()))
            .expect("made");
        let file = folder.join(format!("{STRANGER}.pem"));
        private::replace(&file, identity.to_pem().as_bytes()).expect("written");
        let links = &run.stage.links;
        let process = Command::new(python)
            .args([
                "-B",
                "-m",
                "kit.robot",
                "--site",
                "t-junction",
                "--id",
                STRANGER,
            ])
            .args(["--connect", &links.mediator, "--prefix", &links.key_prefix])
            .args(["--at", "4,0.6", "--round", "--route", ROUND, "--identity"])
            .arg(&file)
            .current_dir(KIT)
            .stdin(Stdio::null())
            .spawn()
            .expect("python starts");
        Self {
            process,
            body: None,
            is_let_in: false,
            been_in: Vec::new(),
        }
    }

    /// Puts its body where it says it is, and looks whether that is only where it may be.
    fn follow(&mut self, run: &Run) {
        let ended = self.process.try_wait().expect("our child");
        assert!(ended.is_none(), "it has ended: {ended:?}");
        let observations = run.stage.listener.observations();
        let pose = { observations.said(STRANGER) }.and_then(|said| said.state.pose);
        drop(observations);
        let Some(pose) = pose else { return };
        let disc = Shape::Disc {
            centre_m: [pose.x_m, pose.y_m],
            radius_m: RADIUS_M,
        };
        let mut world = run.stage.world.lock();
        if let Some(body) = self.body {
            world.remove_obstacle(body);
        }
        self.body = Some(
            world
                .add_obstacle(Obstacle::fixed(disc))
                .expect("there is room"),
        );
        drop(world);
        self.is_let_in |= has(run, STRANGER, START);
        if !self.is_let_in {
            return;
        }
        for area in &run.scenario.site.areas {
            let [min_m, max_m] = [area.region.min, area.region.max];
            let apart_m = (min_m.x_m - pose.x_m).max(pose.x_m - max_m.x_m).max(0.0);
            let beside_m = (min_m.y_m - pose.y_m).max(pose.y_m - max_m.y_m).max(0.0);
            if apart_m.hypot(beside_m) < RADIUS_M {
                safe(has(run, STRANGER, &area.id), || {
                    format!("it is in {}, uninvited", area.id)
                });
                if !self.been_in.contains(&area.id) {
                    self.been_in.push(area.id.clone());
                }
            }
        }
    }
}

impl Drop for Stranger {
    fn drop(&mut self) {
        // It may have ended before.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[test]
fn two_of_ours_and_one_of_another_vendor_pass_the_junction() {
    once_more_if_late(|| {
        let python = std::env::var("RIG_PYTHON").unwrap_or_else(|_| "python3".to_owned());
        let imports = Command::new(&python)
            .args(["-c", "import google.protobuf, zenoh"])
            .output();
        if !imports.is_ok_and(|output| output.status.success()) {
            println!(
                "skipped: {python} lacks what contract/kit/requirements.txt names (RIG_PYTHON names another)"
            );
            return;
        }
        let shipped = Path::new(CONFIG).join("scenarios/t-junction.toml");
        let mut scenario = scenario::load(&shipped, &Changes::default())
            .unwrap_or_else(|failure| panic!("{failure:?}"))
            .with_at_most(1);
        scenario.robots.retain(|robot| robot.id != STRANGER);
        let mut bench = Bench::start_secured(scenario);
        let mut stranger = Stranger::start(&python, &bench.run);
        let ending = bench.until_end_with(|run| stranger.follow(run));
        let been_in = stranger.been_in.clone();
        drop(stranger);
        let (result, summary, _) = bench.finish(&ending);
        assert_eq!(ending, Ending::Done, "{summary:#}");
        assert!(result.is_ok(), "{result:?} {summary:#}");
        for area in ["Cr", "R1o", "R1t", "R1i", "R2o"] {
            assert!(been_in.iter().any(|own| own == area), "{been_in:?}");
        }
    });
}
