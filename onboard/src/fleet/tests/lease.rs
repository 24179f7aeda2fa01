//! A grant that was not entered is a lease.

use super::*;

/// It has areas 1 and 2, stands in 1, and drives towards 2.
fn before_the_second() -> Scene {
    let mut scene = Scene::new(&["1", "2"]);
    scene.be("drive-1", at(5.0, -0.5, 0.0, 0.01));
    assert_eq!((scene.holds(), scene.allowed()), ("1 2".into(), vec![0, 1]));
    scene
}

/// Messages of the mediator arrive, those to it do not.
fn deaf_mediator(scene: &mut Scene, sense: &Sense, for_ns: u64) {
    let until_ns = scene.now_ns + for_ns;
    while scene.now_ns < until_ns {
        scene.now_ns += 100 * MS;
        scene.member.step(sense, scene.now_ns);
        if scene.member.is_report_due(scene.now_ns) {
            scene.member.report(scene.now_ns);
        }
        scene.member.receive(&scene.mediator.say(), scene.now_ns);
    }
    scene.member.step(sense, scene.now_ns);
}

#[test]
fn a_robot_that_is_not_heard_enters_nothing_more_though_it_hears_its_mediator() {
    let mut scene = before_the_second();
    let near = sense("drive-1", at(5.0, -0.5, 0.0, 0.01), 0.4);
    deaf_mediator(&mut scene, &near, 900 * MS);
    assert_eq!(scene.allowed(), [0, 1]);
    deaf_mediator(&mut scene, &near, 200 * MS);
    assert_eq!((scene.holds(), scene.allowed()), ("1 2".into(), vec![0]));
    // It lasts.
    assert_eq!(scene.member.troubles(scene.now_ns), Troubles::default());
    deaf_mediator(&mut scene, &near, 1100 * MS);
    let silent = Troubles {
        silent: true,
        unheard: true,
        ..Troubles::default()
    };
    assert_eq!(scene.member.troubles(scene.now_ns), silent);
    // Heard again, it goes on: with the next level.
    (0..4).for_each(|_| scene.with(&near));
    assert_eq!(scene.allowed(), [0, 1]);
}

#[test]
fn where_it_stands_it_may_be_for_ever_but_not_come_back() {
    let mut scene = before_the_second();
    let inside = at(5.4, -0.5, 0.0, 0.01);
    scene.be("drive-1", inside);
    deaf_mediator(&mut scene, &sense("drive-1", inside, 0.0), 9000 * MS);
    assert_eq!(scene.allowed(), [0, 1]);
    // It is out by 3 cm, within what it may be wrong by: whoever looks sees the area empty, and it stays empty.
    let hardly = at(5.15, -0.5, 0.0, 0.01);
    deaf_mediator(&mut scene, &sense("drive-1", hardly, 0.0), 200 * MS);
    assert_eq!((scene.holds(), scene.allowed()), ("1 2".into(), vec![0]));
    // It has left the second one backwards, and wants to go there again.
    let out = at(4.6, -0.5, 0.0, 0.01);
    deaf_mediator(&mut scene, &sense("drive-1", out, 0.0), 200 * MS);
    assert_eq!(scene.allowed(), [0]);
}

#[test]
fn a_late_echo_of_an_old_report_is_no_lease() {
    let mut scene = before_the_second();
    let near = sense("drive-1", at(5.0, -0.5, 0.0, 0.01), 0.4);
    let old = scene.mediator.heard;
    deaf_mediator(&mut scene, &near, 2000 * MS);
    scene.mediator.heard = old;
    scene.member.receive(&scene.mediator.say(), scene.now_ns);
    scene.member.step(&near, scene.now_ns);
    assert_eq!(scene.allowed(), [0]);
    // Nor one of a report that was never sent.
    scene.mediator.heard = u64::MAX;
    scene.member.receive(&scene.mediator.say(), scene.now_ns);
    scene.member.step(&near, scene.now_ns);
    assert_eq!(scene.allowed(), [0]);
}
