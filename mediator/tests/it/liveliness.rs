//! Two mediators see each other before any robot follows either.

use std::time::{Duration, Instant};

use crate::program::{Program, Site, folder, free_endpoint};

fn site() -> Site {
    Site {
        name: "rooms".into(),
        areas: vec![("room".into(), 1)],
        robots: vec![("amr-0".into(), "normal", 0)],
        events: Vec::new(),
        more: String::new(),
        nets: Vec::new(),
        own_nets: Vec::new(),
    }
}

fn wait_for(program: &Program, said: &str) {
    let until = Instant::now() + Duration::from_secs(20);
    while !program.log().contains(said) {
        assert!(Instant::now() < until, "{said}: {}", program.log());
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn two_mediators_tell_people_of_each_other_though_no_robot_is_there() {
    let folders = [(); 2].map(|()| folder());
    let endpoint = free_endpoint("tcp");
    let mut first = Program::new(folders[0].path(), &site(), Vec::new());
    first.listen(&endpoint);
    first.start();
    first.wait_ready(Duration::from_secs(60));
    assert!(!first.log().contains("another mediator"), "{}", first.log());
    let mut second = Program::new(folders[1].path(), &site(), vec![endpoint]);
    second.start();
    for program in [&first, &second] {
        wait_for(program, "another mediator, ");
        assert_eq!(program.log().matches("another mediator").count(), 1);
    }
    second.kill();
    wait_for(&first, "is gone");
}
