use std::fs;
use std::path::{Path, PathBuf};

use super::*;
use onboard::cli::Failure;

const CONFIG: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config");

fn shipped(name: &str) -> PathBuf {
    Path::new(CONFIG).join("scenarios").join(name)
}

/// What is said about the shipped scenario after this change, on one line.
fn refusal(from: &str, to: &str) -> String {
    let text = fs::read_to_string(shipped("overtaking.toml")).expect("there");
    assert!(text.contains(from), "{from}");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("own.toml");
    let text = text
        .replacen(from, to, 1)
        .replace("\"../", &format!("\"{CONFIG}/"));
    fs::write(&file, text).expect("written");
    match load(&file, &Changes::default()) {
        Ok(_) => panic!("`{to}` was accepted"),
        Err(Failure::Refused(report)) => format!("{report:?}")
            .lines()
            .map(|line| line.trim_matches([' ', '│', '×', '╰', '─', '▶', '╭', '├']))
            .collect::<Vec<_>>()
            .join(" "),
        Err(Failure::Failed(report)) => panic!("failed: {report:?}"),
    }
}

#[test]
fn scenarios_that_ship_are_good_and_know_their_goals() {
    for entry in fs::read_dir(Path::new(CONFIG).join("scenarios")).expect("a folder") {
        let file = entry.expect("an entry").path();
        let scenario =
            load(&file, &Changes::default()).unwrap_or_else(|failure| panic!("{failure:?}"));
        assert_eq!(file.file_stem(), Some(scenario.name.as_ref()));
        let alone = scenario.robots.len() == 1;
        assert_eq!(scenario.site.areas_managed, !alone, "{}", scenario.name);
        for player in &scenario.robots {
            assert_eq!(player.config.identity.id, player.id);
            if let (Goal::Places(places), false) = (&player.goal, alone) {
                assert!(places.stops().count() > 1);
            }
        }
        let fewer = scenario.with_at_most(1);
        assert!(fewer.robots.iter().all(|player| player.goal.rounds() == 1));
    }
}

#[test]
fn names_that_nothing_has_are_refused_with_what_there_is() {
    let text = refusal("{ area = \"5\", stands_s", "{ area = \"55\", stands_s");
    assert!(text.contains("own.toml:"), "{text}");
    assert!(text.contains("found area `55`"), "{text}");
    assert!(text.contains("`1`, "), "{text}");
    let text = refusal("overtaking = 1", "docking = 1");
    assert!(
        text.contains("found `docking`, expected one of `overtaking`"),
        "{text}"
    );
    let text = refusal("while = { robot = \"amr-2\"", "while = { robot = \"amr-7\"");
    assert!(text.contains("found robot `amr-7`"), "{text}");
    let text = refusal("[robots.amr-2]", "[robots.amr-3]");
    assert!(text.contains("found robot `amr-3`"), "{text}");
    assert!(text.contains("found no [robots.amr-2]"), "{text}");
}

#[test]
fn files_that_are_not_there_are_named() {
    let text = refusal("sites/overtaking.toml", "sites/nowhere.toml");
    assert!(text.contains("found no file"), "{text}");
    assert!(
        text.replace(' ', "").contains("sites/nowhere.toml"),
        "{text}"
    );
    let missing = load(Path::new("/nowhere/at-all.toml"), &Changes::default());
    let Err(Failure::Refused(report)) = missing else {
        panic!("{missing:?}");
    };
    assert!(
        format!("{report}").contains("/nowhere/at-all.toml"),
        "{report}"
    );
}

#[test]
fn values_out_of_range_and_unknown_keys_are_refused() {
    let text = refusal("patience_s = 300.0", "patience_s = -1.0");
    assert!(text.contains("patience_s = -1"), "{text}");
    let text = refusal("patience_s = 300.0", "patience_s = nan");
    assert!(text.contains("patience_s = NaN"), "{text}");
    let text = refusal("patience_s = 300.0", "patience = 300.0");
    assert!(text.contains("unknown field `patience`"), "{text}");
    let text = refusal("rounds = 1", "rounds = -1");
    assert!(text.contains("own.toml:"), "{text}");
    let text = refusal("{ area = \"1\" },", "{ },");
    assert!(text.contains("expected one of them"), "{text}");
    let text = refusal("name = \"overtaking\"", "name = \"../up\"");
    assert!(text.contains("found the name"), "{text}");
    let text = refusal(
        "\"drive.max_speed_m_s=0.20\"",
        "\"drive.max_sped_m_s=0.20\"",
    );
    assert!(text.contains("max_sped_m_s"), "{text}");
}

#[test]
fn one_robot_may_be_another_on_another_site_and_several_may_not() {
    let other = Changes {
        robot: Some(Path::new(CONFIG).join("robots/amr-big.toml")),
        site: Some(Path::new(CONFIG).join("sites/docking.toml")),
        set: vec!["areas.managed=false".to_owned()],
    };
    let scenario =
        load(&shipped("lap.toml"), &other).unwrap_or_else(|failure| panic!("{failure:?}"));
    assert_eq!(scenario.robots[0].id, "amr-big");
    assert!(!scenario.site.areas_managed && scenario.site.name == "docking");
    let refused = load(&shipped("overtaking.toml"), &other);
    assert!(matches!(refused, Err(Failure::Refused(_))), "{refused:?}");
}

#[test]
fn scenarios_that_ship_are_built_in() {
    let scenario = load_shipped(
        "clutter",
        &Changes {
            robot: Some(Path::new(CONFIG).join("robots/amr-1.toml")),
            site: Some(Path::new(CONFIG).join("sites/corridor.toml")),
            set: Vec::new(),
        },
    );
    assert!(scenario.is_ok_and(|scenario| scenario.clutter.is_some()));
    assert!(load_shipped("no-such", &Changes::default()).is_err());
}

#[test]
fn clutter_that_makes_no_sense_is_refused() {
    let text = fs::read_to_string(shipped("clutter.toml")).expect("there");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("own.toml");
    let text = text
        .replace("count = [2, 5]", "count = [5, 2]")
        .replace("\"../", &format!("\"{CONFIG}/"));
    fs::write(&file, text).expect("written");
    let Err(Failure::Refused(report)) = load(&file, &Changes::default()) else {
        panic!("it was accepted");
    };
    assert!(
        format!("{report:?}").contains("found 5 to 2 boxes"),
        "{report:?}"
    );
}
