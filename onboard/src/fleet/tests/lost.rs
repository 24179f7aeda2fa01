//! A robot that does not know any more where it is, or was taken to be elsewhere.

use super::*;

/// As one whose computer has slept: somebody may have moved it.
#[test]
fn a_robot_that_loses_its_place_enters_nothing_and_gives_nothing_back_until_it_is_placed() {
    let mut scene = Scene::new(&["1", "2"]);
    scene.be("drive-1", at(5.0, -0.5, 0.0, 0.01));
    assert_eq!((scene.holds(), scene.allowed()), ("1 2".into(), vec![0, 1]));
    scene.member.lose_place();
    let mut told = scene.mediator.say();
    told.revocations = vec![revoked("2", scene.mediator.runs["2"].1)];
    scene.member.receive(&told, scene.now_ns);
    scene.be("drive-1", at(5.0, -0.5, 0.0, 0.01));
    let report = scene.member.report(scene.now_ns);
    assert!(!report.located && scene.member.troubles(scene.now_ns).lost);
    assert_eq!((scene.holds(), scene.allowed()), ("1 2".into(), vec![]));
    assert_eq!(report.revocations[0].level.map(|own| own.progress), Some(1));
    scene.member.relocated();
    scene.member.step(
        &sense("drive-1", at(5.0, -0.5, 0.0, 0.01), 0.0),
        scene.now_ns,
    );
    assert_eq!(scene.allowed(), [0], "what it stands in");
    let report = scene.member.report(scene.now_ns);
    assert!(
        report.located
            && report.revocations[0]
                .level
                .is_some_and(|own| own.progress == 2)
    );
}

#[test]
fn a_robot_that_loses_its_place_before_it_has_heard_anybody_does_not_go_on() {
    let mut scene = Scene::new(&["1"]);
    let knows = Setup {
        began: Began::GoesOn,
        ..setup()
    };
    scene.member = Member::new(knows, 0);
    scene.member.lose_place();
    scene.be("drive-1", at(2.0, -0.5, 0.0, 0.1));
    assert!(scene.allowed().is_empty() && !scene.member.report(scene.now_ns).located);
}

/// Its pose is corrected outward while it drives in: what it cannot stop before it keeps.
#[test]
fn an_area_that_it_seems_to_have_left_while_it_drives_in_is_not_given_back() {
    let mut scene = Scene::new(&["1", "2"]);
    scene.be("drive-1", at(5.3, -0.5, 0.0, 0.01));
    assert!(
        scene
            .member
            .report(scene.now_ns)
            .stands_in
            .contains(&"2".to_owned())
    );
    let mut told = scene.mediator.say();
    told.revocations = vec![revoked("2", scene.mediator.runs["2"].1)];
    scene.member.receive(&told, scene.now_ns);
    scene.member.step(
        &sense("drive-1", at(5.0, -0.5, 0.0, 0.01), 0.6),
        scene.now_ns,
    );
    let report = scene.member.report(scene.now_ns);
    assert!(!report.stands_in.contains(&"2".to_owned()));
    let answer = { report.revocations[0].level }.map(|own| (own.path, own.progress));
    assert_eq!(answer, Some((1, 2)), "kept");
}

/// People say where it stands as well as they see it. Its nose is in area 2; by their word it is just before it, or well before.
#[test]
fn an_area_that_a_robot_may_be_in_by_the_word_of_people_is_not_given_back() {
    for (said, keeps) in [
        (at(5.1, -0.5, 0.0, 0.1), true),
        (at(4.7, -0.5, 0.0, 0.1), false),
    ] {
        let mut scene = Scene::new(&["1", "2"]);
        scene.be("drive-1", at(5.3, -0.5, 0.0, 0.01));
        scene.member.lose_place();
        scene.be("drive-1", at(5.3, -0.5, 0.0, 0.01));
        scene.member.relocated();
        scene
            .member
            .step(&sense("drive-1", said, 0.0), scene.now_ns);
        let holds = if keeps { "1 2" } else { "1" };
        assert_eq!(scene.holds(), holds);
        // The walls say more.
        scene.be("drive-1", at(5.3, -0.5, 0.0, 0.01));
        assert_eq!((scene.holds(), scene.allowed()), ("1 2".into(), vec![0, 1]));
    }
}

/// The mediator asks for a grant.
fn revoked(area: &str, fence: u64) -> wire::Access {
    wire::Access {
        area: area.to_owned(),
        level: Some(wire::Level {
            progress: 1,
            ..wire::Level::default()
        }),
        fence,
    }
}
