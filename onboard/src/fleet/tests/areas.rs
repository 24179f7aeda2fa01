//! Which areas are asked for, kept and given back.

use super::*;

#[test]
fn areas_are_asked_for_ahead_and_given_back_behind() {
    let mut scene = Scene::new(&["1", "2", "3", "4"]);
    assert!(
        scene.allowed().is_empty(),
        "nothing before the mediator spoke"
    );
    scene.be("drive-1", at(3.0, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1");
    // 0.2 m to stop, 0.12 m until then, and 0.5 m more.
    scene.be("drive-1", at(4.2, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1");
    scene.be("drive-1", at(4.6, -0.5, 0.0, 0.01));
    assert_eq!((scene.holds(), scene.allowed()), ("1 2".into(), vec![0, 1]));
    scene.be("search-2", at(5.55, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1 2", "its rear is in area 1 still");
    scene.be("search-2", at(5.8, -0.5, 0.0, 0.01));
    assert_eq!((scene.holds(), scene.allowed()), ("2".into(), vec![1]));
    let standing = scene.state();
    assert_eq!((standing.session, standing.mediator_epoch), (1, 1));
}

#[test]
fn what_is_not_free_is_waited_for_with_the_reason() {
    let mut scene = Scene::new(&["1"]);
    scene.be("drive-1", at(5.0, -0.5, 0.0, 0.01));
    assert_eq!((scene.holds(), scene.allowed()), ("1".into(), vec![0]));
    assert_eq!(scene.state().waits.as_str(), "2: area 2 is held by amr-2");
    scene.mediator.free.insert("2".into());
    scene.mediator.hear(&scene.member.report(scene.now_ns));
    scene.be("drive-1", at(5.1, -0.5, 0.0, 0.01));
    assert_eq!(scene.allowed(), [0, 1]);
}

#[test]
fn a_request_is_kept_when_the_robot_slows_down_before_the_border() {
    let mut scene = Scene::new(&["1", "2"]);
    scene.be("drive-1", at(4.5, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1 2");
    scene.with(&sense("drive-1", at(4.5, -0.5, 0.0, 0.01), 0.0));
    assert_eq!(scene.holds(), "1 2");
}

#[test]
fn a_manoeuvre_begins_when_it_has_all_its_areas() {
    let mut scene = Scene::new(&["1", "2"]);
    scene.be("wide-1", at(5.0, -0.5, 0.0, 0.01));
    assert_eq!((scene.holds(), scene.allowed()), ("1 2".into(), vec![0]));
    scene.mediator.free.insert("4".into());
    scene.mediator.hear(&scene.member.report(scene.now_ns));
    scene.be("wide-1", at(5.0, -0.5, 0.0, 0.01));
    assert_eq!(scene.allowed(), [0, 1, 3]);
}

#[test]
fn what_keeps_the_robot_from_going_on_is_asked_for() {
    let mut scene = Scene::new(&["1", "5"]);
    scene.be("drive-1", at(4.0, -0.5, 0.0, 0.01));
    assert_eq!(scene.holds(), "1");
    scene.with(&Sense {
        waiting_for: AreaIndex::new(4),
        ..sense("drive-1", at(4.0, -0.7, 0.0, 0.01), 0.0)
    });
    assert_eq!(scene.holds(), "1 5");
}
