use description::geometry::Pose2;

use super::*;
use crate::composition::files::Files;
use crate::realtime::clock::SECOND_NS;
use crate::realtime::log;
use crate::symbols::values::Mode;

fn plan(set: &[&str]) -> Plan {
    plan_on("corridor", set)
}

/// Where a mediator manages the areas.
fn managed() -> Plan {
    plan_on("overtaking", &[])
}

fn plan_on(site: &str, set: &[&str]) -> Plan {
    let config = concat!(env!("CARGO_MANIFEST_DIR"), "/../config");
    let files = Files {
        robot: format!("{config}/robots/amr-1.toml").into(),
        site: format!("{config}/sites/{site}.toml").into(),
        set: set.iter().map(|&one| one.to_owned()).collect(),
    };
    Plan::load(&files).expect("good files")
}

/// A folder, and the file of a robot in it.
fn file() -> (tempfile::TempDir, CheckpointFile) {
    let folder = crate::process::runtime::temporary();
    let runtime = Runtime::new(Some(folder.path().to_owned()));
    let file = CheckpointFile::of(&runtime.unwrap_or_else(|_| unreachable!()), "amr-1");
    (folder, file.unwrap_or_else(|_| unreachable!()))
}

fn checkpoint(plan: &Plan, mode: Mode) -> Box<Checkpoint> {
    let mut checkpoint = Checkpoint::of(plan);
    checkpoint.written_ns = 100 * SECOND_NS;
    checkpoint.mode = mode as u64;
    checkpoint.navigator.pose = Pose2::new(1.0, 2.0, 0.5);
    // As sure as a robot is that navigation takes it up again.
    for axis in 0..3 {
        checkpoint.navigator.covariance[axis][axis] = 1e-4;
    }
    checkpoint
}

fn left(file: &mut CheckpointFile, plan: &Plan, now_s: u64) -> Left {
    let (log, _drain) = log::queue();
    Left::take(file, plan, &log, now_s * SECOND_NS).expect("readable")
}

#[test]
fn the_newest_one_is_taken_out_once() {
    let (folder, mut file) = file();
    let plan = plan(&[]);
    assert!(left(&mut file, &plan, 101).place.is_none(), "there is none");
    for x_m in [1.0, 7.0] {
        let mut one = checkpoint(&plan, Mode::Running);
        one.navigator.pose.x_m = x_m;
        file.save(one.to_bytes()).expect("kept");
    }
    let first = left(&mut file, &plan, 101);
    assert_eq!(first.place.map(|one| one.navigator.pose.x_m), Some(7.0));
    assert!(!first.stopped && !first.paused && !first.lost);
    // The note stays: a process that ends before it has left a checkpoint knows no place.
    let names = fs::read_dir(folder.path()).expect("there");
    let names: Vec<_> = names
        .map(|entry| entry.expect("readable").file_name())
        .collect();
    assert_eq!(names, ["amr-1.journey"]);
    let left = left(&mut file, &plan, 101);
    assert!(left.lost && left.stopped);
}

#[test]
fn a_robot_that_ended_as_asked_is_where_it_ended_and_not_stopped() {
    let (folder, mut file) = file();
    let plan = managed();
    file.save(checkpoint(&plan, Mode::Running).to_bytes())
        .expect("kept");
    let at = Stood {
        pose: Pose2::new(1.0, 2.0, 0.5),
        std_m: 0.01,
        std_rad: 0.01,
        state: "drive-1".to_owned(),
    };
    let ends = || Began::Afresh {
        ended: Some(at.clone()),
    };
    let standing = |waited| Ended {
        at: Some(("overtaking".to_owned(), at.clone())),
        waited,
    };
    file.arrive(standing(Waited::default())).expect("noted");
    let left_once = left(&mut file, &plan, 101);
    assert_eq!(left_once.began(), ends());
    assert!(!left_once.lost && !left_once.stopped && left_once.place.is_none());
    assert_eq!(fs::read_dir(folder.path()).expect("there").count(), 1);
    // So is one that waited, and goes on waiting.
    for (stopped, paused) in [(true, false), (false, true), (true, true)] {
        let waited = Waited {
            for_reset: stopped,
            to_resume: paused,
        };
        file.arrive(standing(waited)).expect("noted");
        let left = left(&mut file, &plan, 101);
        assert_eq!(left.began(), ends());
        assert_eq!((left.stopped, left.paused), (stopped, paused));
    }
    // Another site.
    let other = Ended {
        at: Some(("hall".to_owned(), at.clone())),
        waited: Waited::default(),
    };
    file.arrive(other).expect("noted");
    assert_eq!(left(&mut file, &plan, 101).ended, None);
    // Where nobody manages the areas, nobody else knows its state.
    let alone = plan_on("overtaking", &["areas.managed=false"]);
    for (state, began) in [("drive-1", ends()), ("gone", Began::Lost)] {
        let mut standing = standing(Waited::default());
        { standing.at.iter_mut() }.for_each(|(_, at)| at.state = state.to_owned());
        file.arrive(standing).expect("noted");
        assert_eq!(left(&mut file, &alone, 101).began(), began);
    }
    // Under way again, and the machine is switched off.
    file.save(checkpoint(&plan, Mode::Running).to_bytes())
        .expect("kept");
    fs::remove_file(&file.path).expect("there");
    assert_eq!(left(&mut file, &plan, 101).began(), Began::Lost);
}

#[test]
fn where_the_robot_did_not_know_where_it_was_nobody_knows() {
    let (_folder, mut file) = file();
    let plan = plan(&[]);
    let mut unsure = checkpoint(&plan, Mode::Stopped);
    unsure.navigator.uncertain = 1;
    file.save(unsure.to_bytes()).expect("kept");
    let left = left(&mut file, &plan, 101);
    assert!(left.lost && left.stopped && left.place.is_none());
}

#[test]
fn what_is_old_or_of_other_files_is_no_place_but_stays_stopped() {
    let (_folder, mut file) = file();
    let own = plan(&[]);
    let other = plan(&["tubes.floor_memory_m=4.0"]);
    for (plan, now_s, good) in [(&own, 159, true), (&own, 161, false), (&own, 99, false)]
        .into_iter()
        .chain([(&other, 101, false)])
    {
        file.save(checkpoint(&own, Mode::Stopped).to_bytes())
            .expect("kept");
        let left = left(&mut file, plan, now_s);
        assert_eq!((left.place.is_some(), left.stopped), (good, true));
        assert_eq!(left.lost, !good, "nobody else knows where it is");
    }
    // Also of a supervisor that hangs: reset, it still waits to be resumed.
    let mut paused = checkpoint(&own, Mode::Paused);
    paused.paused = 1;
    let unattended = Checkpoint::unattended(paused.to_bytes()).expect("it is one");
    for (bytes, stopped) in [(paused.to_bytes(), false), (&unattended[..], true)] {
        file.save(bytes).expect("kept");
        let left = left(&mut file, &own, 101);
        assert_eq!((left.paused, left.stopped), (true, stopped));
    }
    assert_eq!(Checkpoint::unattended(b"no checkpoint"), None);
}

#[test]
fn what_is_damaged_keeps_it_stopped_and_what_is_from_before_the_machine_started_is_none() {
    let (_folder, mut file) = file();
    let plan = plan(&[]);
    let good = checkpoint(&plan, Mode::Stopped).to_bytes().to_vec();
    for place in [0, 9, 40, good.len() - 1] {
        let mut bad = good.clone();
        bad[place] ^= 1;
        file.save(&bad).expect("kept");
        let left = left(&mut file, &plan, 101);
        assert!(left.place.is_none() && left.stopped, "byte {place}");
    }
    file.save(&good[..good.len() - 8]).expect("kept");
    assert!(left(&mut file, &plan, 101).stopped);
    file.boot_id = "another start of the machine".into();
    file.save(&good).expect("kept");
    file.boot_id = "this one".into();
    let none = left(&mut file, &plan, 101);
    assert!(none.place.is_none() && none.stopped && none.lost);
}

#[test]
fn what_cannot_be_read_is_said() {
    let (_folder, mut file) = file();
    fs::create_dir(&file.path).expect("made");
    let (log, _drain) = log::queue();
    let refused = Left::take(&mut file, &plan(&[]), &log, 0).expect_err("a folder");
    assert!(format!("{refused:?}").contains("amr-1"), "{refused:?}");
}

#[test]
fn a_robot_that_was_stopped_stays_so_from_the_beginning() {
    use crate::process::supervisor::Keeper;
    let (_folder, mut file) = file();
    let plan = plan(&[]);
    file.save(checkpoint(&plan, Mode::Stopped).to_bytes())
        .expect("kept");
    let left_once = left(&mut file, &plan, 101);
    let again = CheckpointFile {
        path: file.path.clone(),
        boot_id: file.boot_id.clone(),
        note: file.note.clone(),
        noted: false,
    };
    // The process ends before it knows where the robot is.
    drop(Keeper::new(Box::new(again), &plan, &left_once));
    assert!(left(&mut file, &plan, 102).stopped);
}

/// The numbers are whole, and no place that navigation takes up.
#[test]
fn a_place_that_navigation_refuses_is_none() {
    let (_folder, mut file) = file();
    let plan = plan(&[]);
    let mut one = checkpoint(&plan, Mode::Running);
    one.navigator.state = 999;
    file.save(one.to_bytes()).expect("kept");
    let left = left(&mut file, &plan, 101);
    assert!(left.lost && left.place.is_none());
}

/// The last one that could be kept is not where the robot is any more.
#[test]
fn a_checkpoint_that_cannot_be_kept_leaves_no_older_one() {
    let (folder, mut file) = file();
    let plan = plan(&[]);
    let mut one = checkpoint(&plan, Mode::Running);
    file.save(one.to_bytes()).expect("kept");
    // Where the next one would be written first.
    let in_the_way = folder.path().join(".amr-1.checkpoint.new");
    fs::create_dir(&in_the_way).expect("made");
    assert!(file.save(one.to_bytes()).is_err());
    let left = left(&mut file, &plan, 101);
    assert!(left.lost && left.place.is_none());
}
