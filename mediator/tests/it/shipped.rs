//! The coordinations of the sites that ship, step by step, with robots that say by script where they are.

use crate::sites;
use contract::client::{Client, Order, Situation};
use contract::wire::{Control, Level};
use mediator::journal::Stored;
use mediator::manager::{Alarm, Manager};
use mediator::setup::Setup;

const SECOND_NS: u64 = 1_000_000_000;

struct Robot {
    client: Client,
    now: Situation,
    /// It says nothing of its discrete control.
    mute: bool,
    /// But that it was acquired in this coordination.
    says_acquired_in: Option<u64>,
    /// It repeats for ever that it was asked for it.
    stuck: bool,
    repeats: Option<Control>,
}

impl Robot {
    fn new(id: &str, setup: &Setup) -> Self {
        Self {
            client: Client::new(id, &setup.site, 5).on(setup.floor.clone()),
            now: Situation {
                located: true,
                ..Situation::default()
            },
            mute: false,
            says_acquired_in: None,
            stuck: false,
            repeats: None,
        }
    }

    fn is(&mut self, state: &str, stands_in: &[&str], wanted: &[&str]) {
        let names = |list: &[&str]| list.iter().map(|&area| area.to_owned()).collect();
        self.now.fsm_state = state.to_owned();
        self.now.stands_in = names(stands_in);
        self.now.wanted = names(&[stands_in, wanted].concat());
    }

    fn orders(&mut self) -> Vec<Order> {
        std::iter::from_fn(|| self.client.next_order()).collect()
    }

    /// The event of the only order there is.
    fn event(&mut self) -> Option<String> {
        let orders = self.orders();
        assert_eq!(orders.len(), 1, "{orders:?}");
        orders[0].instruction.event.clone()
    }
}

struct Scene {
    manager: Manager,
    normal: Robot,
    emergency: Robot,
    now_ns: u64,
}

impl Scene {
    /// Nobody has reported yet.
    fn new() -> Self {
        let (setup, plans) = sites::shipped("overtaking", "overtaking");
        Self {
            manager: Manager::with_plans(&setup, plans, &Stored::new(1), 0).expect("valid"),
            normal: Robot::new("amr-1", &setup),
            emergency: Robot::new("amr-2", &setup),
            // No robot may still enter what an earlier manager has granted.
            now_ns: 10 * SECOND_NS,
        }
    }

    /// The emergency robot has come up behind: the normal one drives through area 1, before the lay-by.
    fn overtaking() -> Self {
        let mut scene = Self::new();
        scene.come_up();
        assert!(scene.normal.client.is_acquired() && scene.emergency.client.is_acquired());
        scene
    }

    /// The emergency robot comes up behind.
    fn come_up(&mut self) {
        self.normal.is("drive-1", &["1"], &[]);
        self.emergency.is("end-6", &["6"], &["7"]);
        self.talk();
        assert!(self.emergency.client.holds("7"));
        self.emergency.is("u-turn-7", &["7"], &["1"]);
        self.talk();
    }

    /// Both sides talk until nobody has news.
    fn talk(&mut self) {
        for _ in 0..8 {
            for robot in [&mut self.normal, &mut self.emergency] {
                robot.client.step(robot.now.clone(), self.now_ns, SECOND_NS);
                let mut report = robot.client.report();
                report.control = report.control.filter(|_| !robot.mute);
                if let Some(coordination) = robot.says_acquired_in {
                    let level = Level {
                        progress: 2,
                        ..Level::default()
                    };
                    report.control = Some(Control {
                        coordination,
                        level: Some(level),
                        ..Control::default()
                    });
                }
                if robot.stuck {
                    let asked = Some(Level {
                        progress: 1,
                        ..Level::default()
                    });
                    let control = report.control.or_else(|| robot.repeats.take());
                    report.control = control.map(|own| Control {
                        level: asked,
                        ..own
                    });
                    robot.repeats.clone_from(&report.control);
                }
                self.manager.report(&report, self.now_ns);
            }
            while let Some(message) = self.manager.next_message(self.now_ns) {
                for robot in [&mut self.normal, &mut self.emergency] {
                    robot.client.receive(&message, self.now_ns);
                }
            }
        }
    }

    /// Lets time pass in which nothing happens, except that everybody is heard.
    fn wait(&mut self, seconds: u64) {
        for _ in 0..2 * seconds {
            self.now_ns += SECOND_NS / 2;
            self.talk();
            self.manager.tick(self.now_ns);
        }
        self.talk();
    }

    fn alarms(&mut self) -> Vec<Alarm> {
        self.manager.alarms().collect()
    }

    fn why(&self, robot: &str) -> String {
        self.manager.why(robot, self.now_ns).expect("it is known")
    }

    fn runs(&self) -> usize {
        let status = self.manager.status(self.now_ns);
        status.coordinations.iter().filter(|own| !own.over).count()
    }

    /// The normal robot is in the lay-by, and the emergency robot is let into area 1.
    fn park(&mut self) {
        assert_eq!(self.normal.event().as_deref(), Some("aside"));
        let slow = self.emergency.orders();
        assert_eq!(
            (
                slow[0].instruction.speed_limit_m_s,
                &slow[0].instruction.event
            ),
            (Some(0.2), &None)
        );
        self.talk();
        assert!(self.normal.client.holds("5") && !self.emergency.client.holds("1"));
        self.normal.is("pull-over", &["1", "5"], &[]);
        self.talk();
        self.normal.is("wait-5", &["5"], &[]);
        self.normal.client.output("parked");
        self.talk();
        assert!(self.emergency.client.holds("1"));
        assert_eq!(
            self.emergency.event(),
            None,
            "its machine drives on by itself"
        );
    }
}

#[test]
fn the_emergency_robot_passes_while_the_normal_one_waits_aside() {
    let mut scene = Scene::overtaking();
    scene.park();
    let why = scene.why("amr-1");
    assert!(
        why.contains("coordination overtaking as normal")
            && why.contains("amr-2 has not set `done2`"),
        "{why}"
    );
    scene.emergency.is("drive-on-1", &["1"], &["2"]);
    scene.emergency.client.output("past-lay-by");
    scene.talk();
    assert!(scene.emergency.client.holds("2"));
    assert_eq!(scene.emergency.event(), None);
    scene.emergency.is("end-2", &["1", "2"], &["3"]);
    scene.emergency.client.output("through-2");
    scene.talk();
    assert_eq!(scene.emergency.event().as_deref(), Some("resume"));
    assert_eq!(scene.normal.event().as_deref(), Some("back"));
    scene.talk();
    assert!(
        !scene.normal.client.holds("1"),
        "the other one is in there still"
    );
    assert!(!scene.emergency.client.is_acquired());
    scene.emergency.is("end-2", &["2"], &["3"]);
    scene.talk();
    assert!(scene.normal.client.holds("1") && scene.emergency.client.holds("3"));
    scene.normal.is("drive-on-1", &["1"], &["2"]);
    scene.normal.client.output("back-on-lane");
    scene.talk();
    assert_eq!(scene.normal.event().as_deref(), Some("resume"));
    scene.talk();
    assert!(!scene.normal.client.is_acquired());
    assert_eq!(scene.runs(), 0);
    assert!(scene.alarms().is_empty());
}

#[test]
fn a_normal_robot_that_has_passed_the_lay_by_is_not_overtaken() {
    let mut scene = Scene::new();
    scene.normal.is("drive-on-1", &["1"], &[]);
    scene.emergency.is("u-turn-7", &["7"], &["1"]);
    scene.talk();
    assert_eq!(scene.runs(), 0);
    assert!(scene.why("amr-2").contains("amr-1 (in it"));
}

/// The normal robot has passed the lay-by before it heard of it: both stand where they are, and go on by themselves.
#[test]
fn what_stands_still_is_broken_off_from_states_that_the_site_names() {
    let mut scene = Scene::overtaking();
    scene.normal.orders();
    scene.emergency.orders();
    scene.normal.is("drive-on-1", &["1"], &[]);
    scene.wait(45);
    let alarms = scene.alarms();
    let [Alarm::Still { what, .. }] = &alarms[..] else {
        panic!("{alarms:?}");
    };
    assert!(
        what.contains("amr-1: it is to set the flag `done5` itself")
            && what.contains("fires `parked`"),
        "{what}"
    );
    scene.wait(20);
    assert!(matches!(scene.alarms()[..], [Alarm::Preempted { .. }]));
    for robot in [&mut scene.normal, &mut scene.emergency] {
        assert_eq!(robot.event().as_deref(), Some("halt"));
        assert!(robot.client.is_acquired());
    }
    // The emergency robot turns in its own area, which is out of the way; the normal one still drives.
    scene.wait(2);
    for robot in [&mut scene.normal, &mut scene.emergency] {
        assert!(robot.client.is_acquired() && robot.orders().is_empty());
    }
    scene.normal.is("yield-on-1", &["1"], &[]);
    scene.talk();
    for robot in [&mut scene.normal, &mut scene.emergency] {
        assert_eq!(robot.event().as_deref(), Some("resume"));
    }
    scene.talk();
    assert!(!scene.normal.client.is_acquired() && !scene.emergency.client.is_acquired());
    assert_eq!(scene.runs(), 0);
    // Without a coordination, the emergency robot gets area 1 when it is free.
    scene.normal.is("search-2", &["2"], &[]);
    scene.wait(1);
    assert!(scene.emergency.client.holds("1"));
}

/// A robot that is told to get out of the way stays where it is: after another minute both are let go as they are.
#[test]
fn robots_that_do_not_get_out_of_the_way_are_let_go_after_a_while() {
    let mut scene = Scene::overtaking();
    scene.normal.is("pull-over", &["1", "5"], &[]);
    scene.wait(65);
    assert!(scene.normal.client.is_acquired() && scene.runs() == 1);
    scene.alarms();
    scene.wait(50);
    assert!(scene.normal.client.is_acquired() && scene.emergency.client.is_acquired());
    scene.wait(12);
    let alarms = scene.alarms();
    assert!(
        matches!(alarms[..], [Alarm::Still { .. }, Alarm::LetGo { .. }]),
        "{alarms:?}"
    );
    assert!(!scene.normal.client.is_acquired() && !scene.emergency.client.is_acquired());
    assert!(scene.normal.client.holds("1") && !scene.emergency.client.holds("1"));
}

/// Something stands in the lay-by for a while: when the normal robot has got there after all, the net begins again.
#[test]
fn what_stands_still_begins_again_with_the_normal_robot_aside() {
    let mut scene = Scene::overtaking();
    scene.normal.orders();
    scene.emergency.orders();
    scene.talk();
    scene.normal.is("pull-over", &["1", "5"], &[]);
    scene.wait(65);
    let alarms = scene.alarms();
    assert!(
        matches!(alarms[..], [Alarm::Still { .. }, Alarm::Preempted { .. }]),
        "{alarms:?}"
    );
    for robot in [&mut scene.normal, &mut scene.emergency] {
        assert_eq!(robot.event().as_deref(), Some("halt"));
    }
    scene.wait(2);
    assert!(scene.normal.client.holds("5") && !scene.emergency.client.holds("1"));
    scene.normal.is("wait-5", &["5"], &[]);
    scene.wait(1);
    let status = scene.manager.status(scene.now_ns);
    let runs: Vec<&str> = { status.coordinations.iter() }
        .filter(|own| !own.over)
        .map(|own| own.situation.as_str())
        .collect();
    assert_eq!(runs, ["normal-aside"]);
    assert!(scene.normal.orders().is_empty(), "it waits where it is");
    assert_eq!(
        scene.emergency.orders()[0].instruction.speed_limit_m_s,
        Some(0.2)
    );
    scene.talk();
    assert!(scene.emergency.client.holds("1"));
}

#[test]
fn a_robot_that_does_not_answer_does_not_hold_the_other() {
    let mut scene = Scene::new();
    scene.normal.mute = true;
    scene.come_up();
    assert_eq!(scene.runs(), 1);
    scene.wait(4);
    assert!(scene.emergency.client.is_acquired() && scene.alarms().is_empty());
    scene.wait(2);
    assert!(!scene.emergency.client.is_acquired());
    let alarms = scene.alarms();
    assert!(matches!(&alarms[..], [Alarm::Mute { robot, .. }] if robot == "amr-1"));
    // For a minute nobody asks it again.
    scene.wait(50);
    assert_eq!(scene.runs(), 0);
    scene.wait(12);
    assert_eq!(scene.runs(), 1);
    scene.normal.mute = false;
    scene.wait(1);
    assert!(scene.normal.client.is_acquired() && scene.emergency.client.is_acquired());
    assert!(scene.alarms().is_empty());
}

/// What was to ask it is written only then.
#[test]
fn a_robot_that_could_not_be_asked_while_the_disk_stalled_is_not_mute() {
    let mut scene = Scene::new();
    scene.normal.mute = true;
    scene.come_up();
    scene.wait(1);
    scene.now_ns += 40 * SECOND_NS;
    scene.manager.was_held_up(40 * SECOND_NS);
    scene.talk();
    scene.manager.tick(scene.now_ns);
    assert_eq!(scene.alarms(), []);
    scene.wait(3);
    assert_eq!((scene.runs(), scene.alarms()), (1, Vec::new()));
    scene.wait(2);
    let alarms = scene.alarms();
    assert!(matches!(&alarms[..], [Alarm::Mute { robot, .. }] if robot == "amr-1"));
}

#[test]
fn a_robot_that_repeats_for_ever_that_it_was_asked_does_not_hold_the_other() {
    let mut scene = Scene::new();
    scene.normal.stuck = true;
    scene.come_up();
    assert_eq!(scene.runs(), 1);
    scene.wait(6);
    let alarms = scene.alarms();
    assert!(matches!(&alarms[..], [Alarm::Mute { robot, .. }] if robot == "amr-1"));
    for second in 0..50 {
        assert_eq!(scene.runs(), 0, "after {second} s");
        scene.wait(1);
    }
    // Not even when the minute is over it has said that it was acquired.
    scene.wait(12);
    assert_eq!(scene.runs(), 1);
    scene.normal.stuck = false;
    scene.wait(1);
    assert!(scene.normal.client.is_acquired() && scene.emergency.client.is_acquired());
    assert!(scene.alarms().is_empty());
}

#[test]
fn a_robot_that_repeats_for_ever_that_it_was_acquired_once_does_not_hold_the_other() {
    let mut scene = Scene::new();
    scene.normal.mute = true;
    scene.come_up();
    scene.wait(6 + 60);
    assert_eq!(scene.runs(), 1, "the second one");
    // Of the first one, which is over.
    scene.normal.says_acquired_in = Some(1);
    scene.wait(6);
    for second in 0..50 {
        assert_eq!(scene.runs(), 0, "after {second} s");
        scene.wait(1);
    }
    // Nor does a number that nobody has given out mean that it answers.
    scene.normal.says_acquired_in = Some(1000);
    scene.wait(1);
    assert_eq!(scene.runs(), 0);
}

#[test]
fn a_robot_that_answers_late_is_asked_again_at_once() {
    let mut scene = Scene::new();
    scene.normal.mute = true;
    scene.come_up();
    scene.wait(6);
    assert_eq!(scene.runs(), 0);
    scene.normal.says_acquired_in = Some(1);
    scene.wait(1);
    assert_eq!(scene.runs(), 1);
}

/// A robot lies once about what it takes part in.
#[test]
fn a_made_up_number_of_a_coordination_leaves_room_for_others() {
    for number in [(1 << 61) - 1, (1 << 62) - 1, 1 << 62] {
        let mut scene = Scene::new();
        scene.normal.is("drive-1", &["1"], &[]);
        scene.emergency.is("end-6", &["6"], &["7"]);
        scene.talk();
        scene
            .normal
            .client
            .step(scene.normal.now.clone(), scene.now_ns, SECOND_NS);
        let mut report = scene.normal.client.report();
        report.control = Some(Control {
            coordination: number,
            ..Control::default()
        });
        scene.manager.report(&report, scene.now_ns);
        scene.come_up();
        assert!(scene.normal.client.is_acquired() && scene.emergency.client.is_acquired());
        let running = scene.manager.status(scene.now_ns).coordinations;
        assert!(running.iter().all(|own| own.number <= 1 << 61));
    }
}

#[test]
fn a_robot_that_knows_no_protocol_2_is_not_asked() {
    let mut scene = Scene::new();
    let client = scene.normal.client.clone();
    scene.normal.client = client.without_control();
    scene.come_up();
    scene.wait(10);
    assert_eq!(scene.runs(), 0);
    assert!(scene.alarms().is_empty());
}

#[test]
fn an_operator_ends_a_coordination_in_two_steps() {
    let mut scene = Scene::overtaking();
    scene.normal.orders();
    scene.emergency.orders();
    let name = "overtaking/1".to_owned();
    let found = scene.manager.end("docking", scene.now_ns);
    assert_eq!(
        found.map_err(|error| error.to_string()),
        Err("no coordination `docking` runs; there are overtaking/1".to_owned())
    );
    // First they get out of the way, where the site says how.
    assert_eq!(scene.manager.end(&name, scene.now_ns), Ok((name, false)));
    scene.talk();
    assert_eq!(scene.normal.event().as_deref(), Some("halt"));
    assert!(scene.normal.client.is_acquired() && scene.runs() == 1);
    // Then they are let go as they are, and keep what they have.
    let ended = scene.manager.end("2", scene.now_ns);
    assert_eq!(ended, Ok(("overtaking/2".to_owned(), true)));
    scene.talk();
    assert!(!scene.normal.client.is_acquired() && !scene.emergency.client.is_acquired());
    assert!(scene.normal.client.holds("1") && scene.emergency.client.holds("7"));
    scene.wait(5);
    assert_eq!(scene.runs(), 0, "not at once again");
    assert!(scene.manager.end("overtaking", scene.now_ns).is_err());
}
