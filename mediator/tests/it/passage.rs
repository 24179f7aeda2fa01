//! A robot that a net lets into several areas at once, of which one is taken from it while it is in another.

use contract::client::{Client, Situation};
use contract::timing::SILENT_AFTER_NS;
use mediator::journal::{ClosedRecord, Stored};
use mediator::manager::{Alarm, Manager};

use crate::sites;
use crate::takeover::talk;

const STEP_NS: u64 = SILENT_AFTER_NS / 5;
const IN: &str = "access-in";
const OUT: &str = "access-out";

/// The big robot has entered both lanes of the shipped docking bay, has left the lane out, and would come back to it.
struct Bay {
    manager: Manager,
    robots: Vec<(Client, Situation)>,
    now_ns: u64,
}

impl Bay {
    fn new() -> Self {
        let (setup, plans) = sites::docking();
        let manager = Manager::with_plans(&setup, plans, &Stored::new(1), 0).expect("valid");
        let robots = ["amr-1", "amr-2", "amr-big"].map(|id| {
            let situation = Situation {
                located: true,
                ..Situation::default()
            };
            (
                Client::new(id, &setup.site, 7).on(setup.floor.clone()),
                situation,
            )
        });
        let mut bay = Self {
            manager,
            robots: robots.into(),
            now_ns: 10 * SILENT_AFTER_NS,
        };
        bay.talk();
        bay.robots[2].1.wanted = [IN, OUT].map(str::to_owned).into();
        bay.talk();
        assert!(bay.has(IN) && bay.has(OUT), "{}", bay.why());
        for stands in [&[IN, OUT][..], &[IN]] {
            bay.robots[2].1.stands_in = stands.iter().map(|&area| area.to_owned()).collect();
            bay.talk();
        }
        assert!(bay.has(OUT));
        bay
    }

    fn talk(&mut self) {
        for _ in 0..5 {
            self.now_ns += STEP_NS;
            talk(&mut self.manager, &mut self.robots, self.now_ns);
        }
    }

    fn has(&self, area: &str) -> bool {
        self.robots[2].0.holds(area)
    }

    fn why(&self) -> String {
        self.manager.why("amr-big", self.now_ns).expect("a robot")
    }
}

#[test]
fn what_was_closed_meanwhile_it_has_again_when_that_is_open() {
    let mut bay = Bay::new();
    // Who waits for it does not get it in between.
    bay.robots[0].1.wanted = vec![OUT.to_owned()];
    bay.talk();
    let closed = bay.manager.close(OUT, ClosedRecord::default(), bay.now_ns);
    assert_eq!(closed.expect("the site has it").granted, ["amr-big"]);
    bay.talk();
    assert!(!bay.has(OUT) && bay.has(IN));
    assert_eq!(bay.manager.open(OUT, bay.now_ns), Ok(true));
    bay.talk();
    assert!(bay.has(OUT), "{}", bay.why());
    // It has passed, and wants neither any more.
    (bay.robots[2].1.wanted, bay.robots[2].1.stands_in) = (Vec::new(), Vec::new());
    bay.talk();
    assert!(
        bay.robots[0].0.holds(OUT),
        "{}",
        bay.manager.why("amr-1", bay.now_ns).expect("a robot")
    );
}

#[test]
fn what_it_gave_back_since_it_was_lost_it_has_again() {
    let mut bay = Bay::new();
    for located in [false, true] {
        bay.robots[2].1.located = located;
        bay.talk();
    }
    assert!(bay.has(IN) && bay.has(OUT), "{}", bay.why());
}

/// That it was wrong about where it is the mediator need not have heard: it knows a passage that it has not left.
#[test]
fn what_it_gave_back_before_it_was_placed_anew_it_has_again() {
    let mut bay = Bay::new();
    bay.robots[2].0.placed_anew();
    bay.talk();
    assert!(bay.has(IN) && bay.has(OUT), "{}", bay.why());
    // By a wrong pose it has left the lane out for good.
    bay.robots[2].1.wanted = vec![IN.to_owned()];
    bay.talk();
    assert!(bay.has(IN) && !bay.has(OUT));
    // Nobody else is let in there.
    bay.robots[0].1.wanted = vec![OUT.to_owned()];
    bay.talk();
    assert!(!bay.robots[0].0.holds(OUT));
    bay.robots[2].1.wanted = [IN, OUT].map(str::to_owned).into();
    bay.talk();
    assert!(bay.has(IN) && bay.has(OUT), "{}", bay.why());
    (bay.robots[2].1.wanted, bay.robots[2].1.stands_in) = (Vec::new(), Vec::new());
    bay.talk();
    assert!(bay.robots[0].0.holds(OUT), "{}", bay.why());
}

/// One of its processes was offered a session and never taken in. Much later, when the one that was is silent, it says where it stands:
/// it may live, or these are its last words.
#[test]
fn who_does_not_speak_for_a_robot_accuses_it_of_nothing() {
    let mut bay = Bay::new();
    let (setup, _) = sites::docking();
    let (_, mut situation) = bay.robots.remove(0);
    bay.talk();
    bay.talk();
    let process = |boot| Client::new("amr-1", &setup.site, boot).on(setup.floor.clone());
    let mut other = process(8);
    other.step(situation.clone(), bay.now_ns, SILENT_AFTER_NS);
    bay.manager.report(&other.report(), bay.now_ns);
    while let Some(message) = bay.manager.next_message(bay.now_ns) {
        other.receive(&message, bay.now_ns);
    }
    bay.robots.push((process(9), situation.clone()));
    bay.talk();
    assert!(bay.robots[2].0.is_registered());
    bay.robots.pop();
    bay.talk();
    bay.talk();
    let _ = bay.manager.alarms().count();
    situation.stands_in = vec![OUT.to_owned()];
    other.step(situation, bay.now_ns, SILENT_AFTER_NS);
    bay.manager.report(&other.report(), bay.now_ns);
    bay.manager.tick(bay.now_ns);
    let alarms: Vec<Alarm> = bay.manager.alarms().collect();
    assert!(
        matches!(&alarms[..], [Alarm::BypassedBySecond { robot, area, .. }] if robot == "amr-1" && area == OUT),
        "{alarms:?}"
    );
}
